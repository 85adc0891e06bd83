"""Rises of r with noise, its scatter, section velocities and their windows; laminar phases."""

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.model.units import TIME_S, from_si
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import estimates, sections, transition
from beltrepro.stats.estimates import CONFIDENCE, Estimate, difference, share_of
from beltrepro.stats.places import over_places, part_of, share_over
from beltrepro.stats.spectra import SEGMENT_S, comb
from beltrepro.stats.states import intermittent_mask, laminar_phases


def rise(noise: np.ndarray, disorder: np.ndarray) -> dict[str, Estimate]:
    """The rise of r along sigma at levels with noise: those without are a set apart."""
    noisy = noise > 0
    return transition.rise(noise[noisy], disorder[noisy])


# --- how r and the section velocities scatter -----------------------------------------------------

RANGE = (3.0, 15.0)
LEAST_RUNS = 6
LEAST_SHARED = 10
BINS = np.linspace(-120.0, 0.0, 101)  # of v_N: finer ones are not filled by 500 crossings


def share_in_windows(row: Cut, usual: Cut) -> Estimate:
    """Share of the runs at 3 <= u <= 15 that fill less than half of the bins of v_N that is usual.

    Usual is what the median run of `usual` fills. Parts of the axis of u count for the interval,
    since neighbouring velocities are in one window.
    """
    part = row.within(*RANGE)
    filled, least = _filled(part), 0.5 * np.nanmedian(_filled(usual.within(*RANGE)))
    crossing = np.isfinite(filled)
    return share_over(part_of(part.belt_velocity[crossing]), filled[crossing] < least)


def spread_ratio(row: Cut) -> Estimate:
    """Bins of v_N that the median run fills above u = 25, relative to 3 <= u <= 15."""
    ends = (25 + 1e-6, np.inf), RANGE
    filled = [bins[np.isfinite(bins)] for bins in (_filled(row.within(*pair)) for pair in ends)]
    return estimates.bootstrap(lambda high, low: np.median(high) / np.median(low), filled)


def _filled(row: Cut) -> np.ndarray:
    """Bins that each run fills; NaN for runs that rarely reach the section."""
    counts = row.points.get("section_histogram")
    if counts is None:
        counts = np.array([np.histogram(run, BINS)[0] for run in row.velocities])
    first = np.arange(0, counts.shape[1], max(1, counts.shape[1] // (BINS.size - 1)))
    filled = sections.occupied_bins(np.add.reduceat(counts, first, axis=1))  # of finer bins
    crossing = np.isfinite(filled).sum()
    require(crossing >= LEAST_RUNS, f"{crossing} runs cross the section, {LEAST_RUNS} are needed")
    return filled


def scatter_ratio(first: Cut, second: Cut) -> Estimate:
    """Scatter of r about a straight line in 3 <= u <= 15, of one row over that of another."""
    scatters = []
    for row in (first, second):
        part = row.within(*RANGE)
        places = np.unique(part.belt_velocity).size
        require(places >= 4, f"{places} belt velocities in 3 <= u <= 15, 4 are needed")
        runs = np.column_stack([part.belt_velocity, part.disorder])
        scatters.append(over_places(_scatter, part.belt_velocity, runs))
    return estimates.ratio(*scatters)


def _scatter(runs: np.ndarray) -> float:
    disorder, u = runs[:, 1], runs[:, 0] - runs[:, 0].mean()
    slope = (u @ disorder) / ((u @ u) or 1.0)  # all drawn at one place
    return float(np.std(disorder - slope * u) / disorder.mean())


def distance(table: Cut, runs: Cut) -> Estimate:
    """Median of |ln r(map) - ln mean r(runs)| over the points with noise that both have."""
    distances = []
    for u, noise, disorder in zip(table.belt_velocity, table.noise, table.disorder, strict=True):
        here = np.isclose(runs.belt_velocity, u) & np.isclose(runs.noise, noise)
        if noise > 0 and here.any():  # without noise the map is by another integrator
            distances.append(abs(np.log(disorder / runs.disorder[here].mean())))
    require(len(distances) >= LEAST_SHARED, f"{len(distances)} points shared, not {LEAST_SHARED}")
    return estimates.bootstrap(np.median, [np.array(distances)])


def typical_disorder(table: Cut, noise: float, time_step: float) -> Estimate:
    """Geometric mean of r over the runs, which has no interval below zero."""
    here = np.isclose(table.noise, noise) & np.isclose(table.points["time_step"], time_step)
    require(here.any(), f"no runs with sigma = {noise:g}, dt = {time_step:g}")
    return estimates.mapped(np.exp, estimates.mean(np.log(table.disorder[here])))


# --- laminar and chaotic phases: in which runs, with which spectra, and where in the map ----------

STRETCH_S = 2 * SEGMENT_S


def lasting(row):
    """Which runs are intermittent and do not leave chaos for good while they are measured."""
    last_half = row.transient + 0.5 * (row.duration - row.transient)
    return intermittent_mask(row.points) & (row.points["last_stick_time"] >= last_half)


# --- spectra --------------------------------------------------------------------------------------


def spectra(evidence, *names):
    """Spectra of the laminar and of the chaotic stretches of some series."""
    laminar, chaotic = [], []
    for name in names:
        run = evidence.dataset(name)
        phases = laminar_phases(run, evidence.settings["defaults"]["laminar_time"])
        laminar += _spectra(run, phases)
        chaotic += _spectra(run, np.column_stack([phases[:-1, 1], phases[1:, 0]]))
    fewest = min(len(laminar), len(chaotic))
    require(fewest >= 2, f"{fewest} phases of {STRETCH_S:g} s or more, 2 are needed")
    quiet, lively = (share_of(np.array([s.found for s in kind])) for kind in (laminar, chaotic))
    teeth = np.array([stretch.peaks.mean() for stretch in laminar])
    also = {
        "peaks at equal distances, chaotic": lively,
        "multiples that stand out, laminar": estimates.bootstrap(np.mean, [teeth]),
    }
    return Measurement({"peaks at equal distances, laminar": quiet}, also)


def _spectra(run, phases):
    """Combs of peaks in the middle of each phase that is long enough."""
    time, position = run.arrays["time"], run.arrays["positions"][:, -1]
    length = from_si(STRETCH_S, "time")
    middle = phases.mean(axis=1)[np.diff(phases, axis=1)[:, 0] >= length]
    interval = time[1] - time[0]
    samples = round(length / interval)
    begin = np.searchsorted(time, middle - length / 2)
    return [comb(position[first : first + samples], interval * TIME_S) for first in begin]


# --- the region in the plane of u and sigma -------------------------------------------------------


def region(evidence, low, high):
    """Where the map is intermittent, for laminar phases of some share of the time."""
    table, quiet = evidence.table("n5_map"), evidence.row("n5_replicates", 5, 0.0)
    fast = evidence.row("n5_replicates_beyond", 5, 0.0).within(38.0, 50.0)
    mask = intermittent_mask(table.points, (low, high))
    first, second, third, weak, strong = (
        _width(table, mask, *levels) for levels in ((0, 2), (2, 4), (4, 6), (0, 4), (4, 8))
    )
    below, across = difference(second, first), difference(third, second)
    also = {
        "width, sigma up to 2": first,
        "width, sigma 2 to 4": second,
        "width, sigma 4 to 6": third,
    }
    for start, end in ((38.0, 42.0), (44.0, 50.0)):
        also[f"at sigma = 0, {start:g} to {end:g}"] = share_of(lasting(fast.within(start, end)))
    return Measurement(
        {
            "intermittent at sigma = 0": share_of(lasting(quiet.within(0.0, np.inf))),
            "width beyond 4 over width up to 4": estimates.ratio(strong, weak),
            "growth across 4 less twice that below": difference(across, below.scaled(2)),
        },
        also,
    )


def _width(table, mask, low, high):
    """Number of intermittent points times their spacing in u, mean over low < sigma <= high.

    Each point is a run of its own, and is intermittent by chance. The levels of the group tell how
    probable that is at each u, and so the variance of the sum. To it comes that of the two edges at
    each level, which lie anywhere between two points.
    """
    chosen = (table.noise > low + 1e-9) & (table.noise <= high + 1e-9)
    levels = np.unique(table.noise[chosen]).size
    require(levels >= 2, f"{levels} noise levels in {low:g} < sigma <= {high:g}, not 2")
    velocities, place, runs = np.unique(
        table.belt_velocity[chosen], return_inverse=True, return_counts=True
    )
    step = float(np.median(np.diff(velocities)))
    shares = np.bincount(place, mask[chosen].astype(float)) / runs
    by_chance = np.sum(shares * (1 - shares) / np.maximum(runs - 1, 1))
    error = step * np.sqrt(by_chance + 2 / (12 * levels))
    value = step * float(shares.sum())
    reach = float(scipy.stats.norm.ppf((1 + CONFIDENCE) / 2) * error)
    return Estimate(value, value - reach, value + reach, int(np.count_nonzero(chosen)))
