"""What noise does to the transition, and intermittency (Figs. 13 to 18)."""
