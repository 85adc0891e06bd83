"""Beside the library: a window on the chain, and the comparison with published results."""
