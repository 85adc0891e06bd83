"""The virtual experiment and what the recordings say (Figs. 1 to 5)."""
