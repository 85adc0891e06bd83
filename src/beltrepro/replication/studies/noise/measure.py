"""Rises of r with noise, its scatter, section velocities and their windows."""

import contextlib
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import sections, transition
from beltrepro.stats.estimates import Estimate, bootstrap, exponential, mean, share_of


def rise(noise: np.ndarray, disorder: np.ndarray) -> dict[str, Estimate]:
    """The rise of r along sigma at levels with noise: those without are a set apart."""
    noisy = noise > 0
    return transition.rise(noise[noisy], disorder[noisy])


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
LEAST_SHARED = 10


def share_in_windows(row: Cut, usual: Cut) -> Estimate:
    """Share of the runs at 3 <= u <= 15 that fill less than half of the bins of v_N that is usual.

    row : the runs; usual : those whose median run says what is usual, and whose range is binned.
    """
    velocities = usual.velocities[usual.between(*RANGE)]
    require(bool(np.isfinite(velocities).any()), "no crossings of the section")
    span = float(np.nanmin(velocities)), float(np.nanmax(velocities))
    least = 0.5 * np.median(_filled(velocities, span))
    return share_of(_filled(row.velocities[row.between(*RANGE)], span) < least)


def spread_ratio(row: Cut) -> Estimate:
    """Bins of v_N that the median run fills above u = 25, relative to 3 <= u <= 15."""
    span = float(np.nanmin(row.velocities)), float(np.nanmax(row.velocities))
    high = _filled(row.velocities[row.belt_velocity > 25], span)
    low = _filled(row.velocities[row.between(*RANGE)], span)
    return bootstrap(lambda high, low: np.median(high) / np.median(low), [high, low])


def _filled(velocities: np.ndarray, span: tuple[float, float]) -> np.ndarray:
    """Share of the bins that each run fills; runs that rarely reach the section are left out."""
    shares = []
    for of_run in velocities:
        with contextlib.suppress(NotEnoughDataError):
            shares.append(sections.occupied_share(of_run, range=span))
    require(
        len(shares) >= LEAST_RUNS, f"{len(shares)} runs cross the section, {LEAST_RUNS} are needed"
    )
    return np.array(shares)


def scatter_ratio(first: Cut, second: Cut) -> Estimate:
    """Scatter of r about a straight line in 3 <= u <= 15, of one row over that of another."""
    one, other = _runs_by_velocity(first), _runs_by_velocity(second)

    def statistic(*runs: np.ndarray) -> float:
        return _scatter(one, runs[: len(one)]) / _scatter(other, runs[len(one) :])

    return bootstrap(statistic, [*one.values(), *other.values()])


def _runs_by_velocity(row: Cut) -> dict[float, np.ndarray]:
    """R of the runs at each u in 3 <= u <= 15."""
    places = np.unique(row.belt_velocity[row.between(*RANGE)])
    require(places.size >= 4, f"{places.size} belt velocities in 3 <= u <= 15, 4 are needed")
    return {float(u): row.disorder[np.isclose(row.belt_velocity, u)] for u in places}


def _scatter(places: Iterable[float], runs: Sequence[np.ndarray]) -> float:
    velocity = np.repeat(list(places), [values.size for values in runs])
    disorder = np.concatenate(runs)
    line = np.polyval(np.polyfit(velocity, disorder, 1), velocity)
    return float(np.sqrt(np.mean((disorder - line) ** 2)) / disorder.mean())


def distance(table: Cut, runs: Cut) -> Estimate:
    """Median of |ln r(map) - ln mean r(runs)| over the points with noise that both have."""
    distances = []
    for u, noise, disorder in zip(table.belt_velocity, table.noise, table.disorder, strict=True):
        here = np.isclose(runs.belt_velocity, u) & np.isclose(runs.noise, noise)
        if noise > 0 and here.any():  # without noise the map is by another integrator
            distances.append(abs(np.log(disorder / runs.disorder[here].mean())))
    require(len(distances) >= LEAST_SHARED, f"{len(distances)} points shared, not {LEAST_SHARED}")
    return bootstrap(np.median, [np.array(distances)])


def typical_disorder(table: Cut, noise: float, time_step: float) -> Estimate:
    """Geometric mean of r over the runs, which has no interval below zero."""
    here = np.isclose(table.noise, noise) & np.isclose(table.points["time_step"], time_step)
    require(here.any(), f"no runs with sigma = {noise:g}, dt = {time_step:g}")
    return exponential(mean(np.log(table.disorder[here])))
