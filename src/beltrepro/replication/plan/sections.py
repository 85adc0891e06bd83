"""Recorded for datasets: how often a section is crossed where, in place of all crossings."""

import numpy as np

from beltrepro.simulation.catalogues import catalogue
from beltrepro.simulation.scans import scan


def density(setup, *, section_from, section_bins, **settings):
    """A scan that counts all crossings by v_N, in bins of one width up to 0."""
    edges = np.linspace(section_from, 0.0, section_bins + 1)
    return scan(setup, section_bins=edges, **settings) | {"section_bins": edges}


def section(setup, **settings):
    """The last block where any block crosses a section, in single precision: these are many."""
    states = catalogue(setup, **settings)["section"]
    crossings = np.empty(len(states), [("point", "i4"), ("position", "f4"), ("velocity", "f4")])
    crossings["point"] = states["point"]
    crossings["position"] = states["positions"][:, -1]
    crossings["velocity"] = states["velocities"][:, -1]
    return {"crossings": crossings}
