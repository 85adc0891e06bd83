"""How large a disturbance periodic motion bears, and for how long irregular motion lasts."""
