"""A replication of "Chaos on the conveyor belt" (Sándor, Járai-Szabó, Tél, Néda, 2013).

`simulate` is loaded on first use, so that what needs no simulation starts without numba.
"""

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from beltrepro.model.parameters import ChainParameters

if TYPE_CHECKING:
    from beltrepro.simulation import simulate

__all__ = ["ChainParameters", "simulate"]
__version__ = version("beltrepro")


def __getattr__(name: str) -> Any:
    if name == "simulate":
        from beltrepro.simulation import simulate

        return simulate
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
