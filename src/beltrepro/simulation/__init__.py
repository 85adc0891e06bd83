"""Simulate chains: sampled runs, points of scans, catalogues of slips, lifetimes of transients.

The functions check their input, advance the chains in groups of equal size, law and method, and
return arrays in model units. What a chain does depends on its own parameters, method, seed and
replicate only, never on the chains beside it.
"""

from beltrepro.engine.state import ChainState
from beltrepro.simulation.catalogues import catalogue
from beltrepro.simulation.lifetimes import escapes
from beltrepro.simulation.methods import METHODS, TOLERANCES
from beltrepro.simulation.run import Run
from beltrepro.simulation.scans import scan
from beltrepro.simulation.trajectories import simulate

__all__ = ["METHODS", "TOLERANCES", "ChainState", "Run", "catalogue", "escapes", "scan", "simulate"]
