"""A replication of "Chaos on the conveyor belt" (Sándor, Járai-Szabó, Tél, Néda, 2013).

`simulate` is loaded on first use, so that what needs no simulation starts without numba.
"""

from importlib.metadata import version

from beltrepro.model.parameters import ChainParameters

__all__ = ["ChainParameters", "simulate"]
__version__ = version("beltrepro")


def __getattr__(name):
    if name == "simulate":
        from beltrepro.simulation import simulate

        return simulate
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
