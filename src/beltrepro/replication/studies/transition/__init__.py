"""The transition without noise (Figs. 11 and 12)."""
