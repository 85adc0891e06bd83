"""A replication of "Chaos on the conveyor belt" (Sándor, Járai-Szabó, Tél, Néda, 2013).

What simulates is loaded on first use, so that what needs no simulation starts without numba.
"""

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from beltrepro.model.parameters import ChainParameters

if TYPE_CHECKING:
    from beltrepro.simulation import (
        ChainState,
        LyapunovSpectrum,
        Run,
        catalogue,
        escapes,
        exponents,
        lyapunov_spectrum,
        scan,
        simulate,
    )

__all__ = [
    "ChainParameters",
    "ChainState",
    "LyapunovSpectrum",
    "Run",
    "catalogue",
    "escapes",
    "exponents",
    "lyapunov_spectrum",
    "scan",
    "simulate",
]
__version__ = version("beltrepro")


def __getattr__(name: str) -> Any:
    if name in __all__:
        from beltrepro import simulation

        return getattr(simulation, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
