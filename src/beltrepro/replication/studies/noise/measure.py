"""Where r rises with noise, and how the section velocities are distributed."""

from collections.abc import Mapping

import numpy as np

from beltrepro.stats import transitions
from beltrepro.stats.estimates import Estimate


def rise(noise: np.ndarray, disorder: np.ndarray, *, above: float = 0.0) -> dict[str, Estimate]:
    """The rise of r along sigma at noise levels above one: those without noise are a set apart."""
    noisy = noise > above
    return transitions.rise(noise[noisy], disorder[noisy])


def velocity_density(
    row: Mapping[str, np.ndarray], *, bins: int, range: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Density of the section velocities of a row, each column normalised to 1 over v."""
    belt_velocity, place = np.unique(row["belt_velocity"], return_inverse=True)
    vcell_edges = np.linspace(*range, bins + 1)
    density = np.full((bins, belt_velocity.size), np.nan)
    velocities = np.asarray(row["section_velocity"], dtype=float)
    for column in np.arange(belt_velocity.size):
        values = velocities[place == column].ravel()
        count, _ = np.histogram(values[np.isfinite(values)], vcell_edges)
        if count.sum():
            density[:, column] = count / (count.sum() * np.diff(vcell_edges))
    return cell_edges(belt_velocity), vcell_edges, density


def cell_edges(centres: np.ndarray) -> np.ndarray:
    """Borders of cells around grid values."""
    if centres.size < 2:
        return np.array([centres[0] - 0.5, centres[0] + 0.5]) if centres.size else np.zeros(1)
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])
