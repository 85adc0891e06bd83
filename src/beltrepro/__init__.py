"""Chains of blocks that stick and slip on a conveyor belt (Sándor, Járai-Szabó, Tél, Néda, 2013).

Each name is loaded on first use, so that what needs no simulation starts without numba. What
editors and mypy see of them stands in `__init__.pyi`.
"""

from importlib import import_module as _import_module

_HOMES = {
    "Basins": "chaos.basins",
    "Catalogue": "simulation.catalogues",
    "ChainParameters": "model.parameters",
    "ChainState": "engine.state",
    "ChainValues": "stats.densities",
    "Density": "stats.densities",
    "Estimate": "stats.estimates",
    "Grid": "simulation.grid",
    "LyapunovSpectrum": "chaos.lyapunov",
    "Motion": "chaos.naming",
    "OrbitBranch": "chaos.continuation",
    "PeriodicOrbit": "chaos.periodic_orbits",
    "PowerLaw": "stats.power_law",
    "PowerSpectrum": "simulation.observables",
    "Progress": "base.progress",
    "Results": "simulation.results",
    "Run": "simulation.run",
    "SectionPoints": "simulation.observables",
    "Setup": "simulation.setup",
    "avalanche_energies": "simulation.observables",
    "basins": "chaos.basins",
    "catalogue": "simulation.catalogues",
    "classify": "chaos.naming",
    "density": "stats.densities",
    "from_si": "model.units",
    "lyapunov_spectrum": "chaos.lyapunov",
    "margin": "chaos.margin",
    "mode_energies": "model.energy",
    "orbit_branch": "chaos.continuation",
    "periodic_orbit": "chaos.periodic_orbits",
    "power_law": "stats.densities",
    "scan": "simulation.scans",
    "section": "simulation.observables",
    "simulate": "simulation.trajectories",
    "sliding_energy": "model.energy",
    "slip_sizes": "simulation.observables",
    "slipping_state": "simulation.starts",
    "spectrum": "simulation.observables",
    "sweep": "simulation.sweeps",
    "time_to_continuous_slip": "simulation.scans",
    "time_to_orbit": "chaos.irregular",
    "to_si": "model.units",
}
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> object:
    if name == "__version__":
        return _import_module("beltrepro.base.provenance").VERSION
    if name not in _HOMES:
        about = _import_module("beltrepro.base.names").left(name)
        raise AttributeError(about or f"module {__name__!r} has no attribute {name!r}")
    _import_module("beltrepro.base.provenance").code_version()  # before the code can change
    return getattr(_import_module(f"beltrepro.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__")), "__version__"]
