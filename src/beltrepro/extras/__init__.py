"""Beside the library: a window on the chain, the benchmark, the deposit."""
