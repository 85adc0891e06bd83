"""A replication of "Chaos on the conveyor belt" (Sándor, Járai-Szabó, Tél, Néda, 2013).

What simulates is loaded on first use, so that what needs no simulation starts without numba.
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from beltrepro.model.parameters import ChainParameters

if TYPE_CHECKING:
    from beltrepro.base.progress import Progress
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
    from beltrepro.simulation.audit import Audit, audit
    from beltrepro.simulation.grid_scan import GridScan, scan_grid

__all__ = [
    "Audit",
    "ChainParameters",
    "ChainState",
    "GridScan",
    "LyapunovSpectrum",
    "Motion",
    "PeriodicOrbit",
    "Progress",
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
    "scan_grid",
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
_ROOMS = (
    dict.fromkeys(_CHAOS, "chaos")
    | dict.fromkeys(("Audit", "audit"), "simulation.audit")
    | dict.fromkeys(("GridScan", "scan_grid"), "simulation.grid_scan")
    | {"Progress": "base.progress"}
)


def __getattr__(name: str) -> Any:
    if name in __all__:
        room = _ROOMS.get(name, "simulation")
        return getattr(import_module(f"beltrepro.{room}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
