"""Slips and avalanches at small belt velocity (Figs. 8 to 10)."""
