"""Simulate chains: sampled runs, scans, catalogues of slips, times to continuous slip.

The functions take a `Setup`, or chains and its keywords, advance the chains in groups of equal
size, law and method, and return arrays in model units. What a chain does depends on its own
parameters, method, seed and replicate only, never on the chains beside it.
"""
