"""The laws of force and friction, and what holds by them (Figs. 6 and 7)."""
