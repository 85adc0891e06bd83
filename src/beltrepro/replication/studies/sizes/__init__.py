"""What the number of blocks does (Figs. 19 to 22)."""
