"""Rises of r with noise, section velocities and their windows, shares of laminar time."""

from collections.abc import Mapping

import numpy as np
import scipy

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import sections, transitions
from beltrepro.stats.estimates import CONFIDENCE, Estimate, bootstrap, share_of


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


RANGE = (3.0, 15.0)
LEAST_RUNS = 6


def share_in_windows(row: Cut, usual: Cut) -> Estimate:
    """Share of the runs at 3 <= u <= 15 that fill less than half of the bins of v_N that is usual.

    row : the runs; usual : those whose median run says what is usual, and whose range is binned.
    """
    velocities = usual.velocities[usual.between(*RANGE)]
    require(bool(np.isfinite(velocities).any()), "no crossings of the section")
    span = float(np.nanmin(velocities)), float(np.nanmax(velocities))
    least = 0.5 * np.median(_filled(velocities, span))
    own = _filled(row.velocities[row.between(*RANGE)], span)
    return share_of(own < least)


def spread_ratio(row: Cut) -> Estimate:
    """Bins of v_N that the median run fills above u = 25, relative to 3 <= u <= 15."""
    span = float(np.nanmin(row.velocities)), float(np.nanmax(row.velocities))
    high = _filled(row.velocities[row.belt_velocity > 25], span)
    low = _filled(row.velocities[row.between(*RANGE)], span)
    return bootstrap(lambda high, low: np.median(high) / np.median(low), [high, low])


def _filled(velocities: np.ndarray, span: tuple[float, float]) -> np.ndarray:
    """Share of the bins that each run fills; runs that rarely reach the section are left out."""
    found = []
    for own in velocities:
        try:
            found.append(sections.occupied_share(own, range=span))
        except NotEnoughDataError:
            continue
    require(
        len(found) >= LEAST_RUNS, f"{len(found)} runs cross the section, {LEAST_RUNS} are needed"
    )
    return np.array(found)


LEAST_CYCLES = 5


def share_of_time(phases: np.ndarray) -> Estimate:
    """Share of the time in phases, where these and the times between them are independent.

    A cycle is a phase and the time until the next one begins. A run of chaotic motion under noise
    forgets its past within a cycle, so that cycles are independent of each other and stand for
    independent runs (regenerative method: M. A. Crane and A. J. Lemoine, An Introduction to the
    Regenerative Method for Simulation Analysis, 1977). The interval is that of Student's t for the
    logarithm of the odds, so that it stays between 0 and 1.

    phases : array (L, 2), begin and end of each phase, in order. What is before the first of them
    and after the beginning of the last one belongs to no whole cycle and is left out.
    """
    inside = np.diff(phases[:-1], axis=1)[:, 0]
    between = phases[1:, 0] - phases[:-1, 1]
    cycles = inside.size
    require(cycles >= LEAST_CYCLES, f"{cycles} whole cycles, {LEAST_CYCLES} are needed")
    odds = inside.mean() / between.mean()
    scatter = inside / inside.mean() - between / between.mean()
    error = scatter.std(ddof=1) / np.sqrt(cycles)
    reach = float(scipy.stats.t.ppf((1 + CONFIDENCE) / 2, cycles - 1)) * error
    value, low, high = (float(scipy.special.expit(np.log(odds) + x)) for x in (0.0, -reach, reach))
    return Estimate(value, low, high, cycles)
