"""A replication of "Chaos on the conveyor belt" (Sándor, Járai-Szabó, Tél, Néda, 2013).

What simulates is loaded on first use, so that what needs no simulation starts without numba.
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from beltrepro.model.parameters import ChainParameters

if TYPE_CHECKING:
    from beltrepro.analysis.audit import Audit, audit
    from beltrepro.chaos import (
        LyapunovSpectrum,
        Motion,
        PeriodicOrbit,
        classify,
        close_orbit,
        exponents,
        lyapunov_spectrum,
        motions,
        periodic_orbit,
        separation,
        settling,
    )
    from beltrepro.simulation import ChainState, Run, catalogue, escapes, scan, simulate

__all__ = [
    "Audit",
    "ChainParameters",
    "ChainState",
    "LyapunovSpectrum",
    "Motion",
    "PeriodicOrbit",
    "Run",
    "audit",
    "catalogue",
    "classify",
    "close_orbit",
    "escapes",
    "exponents",
    "lyapunov_spectrum",
    "motions",
    "periodic_orbit",
    "scan",
    "separation",
    "settling",
    "simulate",
]
__version__ = version("beltrepro")

_CHAOS = (
    "LyapunovSpectrum",
    "Motion",
    "PeriodicOrbit",
    "classify",
    "close_orbit",
    "exponents",
    "lyapunov_spectrum",
    "motions",
    "periodic_orbit",
    "separation",
    "settling",
)


def __getattr__(name: str) -> Any:
    if name in __all__:
        room = "chaos" if name in _CHAOS else "simulation"
        room = "analysis.audit" if name in ("Audit", "audit") else room
        return getattr(import_module(f"beltrepro.{room}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
