"""Simulate chains: sampled runs, scans, catalogues of slips, times to continuous slip.

The functions take a `Setup`, or chains and its keywords, advance the chains in groups of equal
size, law and method, and return arrays in model units. What a chain does depends on its own
parameters, method, seed and replicate only, never on the chains beside it.
"""

from beltrepro.engine.state import ChainState
from beltrepro.simulation.catalogues import Catalogue, catalogue
from beltrepro.simulation.grid import Grid
from beltrepro.simulation.results import Results
from beltrepro.simulation.run import Run
from beltrepro.simulation.scans import scan, time_to_continuous_slip
from beltrepro.simulation.setup import METHODS, TOLERANCES, Setup
from beltrepro.simulation.starts import slipping_state
from beltrepro.simulation.trajectories import simulate

__all__ = [
    "METHODS",
    "TOLERANCES",
    "Catalogue",
    "ChainState",
    "Grid",
    "Results",
    "Run",
    "Setup",
    "catalogue",
    "scan",
    "simulate",
    "slipping_state",
    "time_to_continuous_slip",
]
