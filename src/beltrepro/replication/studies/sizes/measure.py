"""What changes with the number of blocks: alternation, r, the variety of motions, noise."""

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.stats import estimates, states, transition
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.places import over_places
from beltrepro.stats.transition import LEAST_RUNS

LAST_PART = 0.1  # of the time after the transient, in which motion that lasts still sticks
MINIMUM_VELOCITIES = 4
MINIMUM_CROSSINGS = 30
RESAMPLES = 100  # of section velocities, which are many


# --- alternation ----------------------------------------------------------------------------------


def intermittency(row):
    """Share of runs that alternate, and that do to their end; laminar share of time over u."""
    require(row.belt_velocity.size >= 4, f"{row.belt_velocity.size} runs, 4 are needed")
    late = row.duration - LAST_PART * (row.duration - row.transient)
    lasting = np.nan_to_num(row.points["last_stick_time"], nan=-np.inf) >= late
    share = row.points["laminar_fraction"]
    runs = np.column_stack([row.belt_velocity, share])
    return Measurement(
        {
            "intermittent": estimates.share_of(states.intermittent_mask(row.points)),
            "lasts": estimates.share_of(lasting),
            "laminar share over u": estimates.bootstrap(_rank_correlation, [runs]),
        },
        {"laminar share": estimates.mean(share)},
    )


def _rank_correlation(runs):
    """Of two columns; NaN where one of them is constant."""
    if np.ptp(runs, axis=0).min() == 0:
        return np.nan
    return float(scipy.stats.spearmanr(*runs.T).statistic)


# --- motions --------------------------------------------------------------------------------------


def contrast(belt_velocity, disorder):
    """High over low plateau of r(u) beside its best falling step; 1 if r falls nowhere.

    Velocities are drawn anew, with all their runs: without noise runs at one u often end alike.
    """

    def best_fall(runs):
        return float(np.nan_to_num(transition.contrast_of_step(*runs.T), nan=1.0))

    runs = np.column_stack([belt_velocity, disorder])
    return over_places(best_fall, belt_velocity, runs)


def excess(codes, near):
    """Entropy of the richest of the first `near` samples of codes, less that of the others."""

    def difference(*groups):
        bits = list(map(entropy, groups))
        return max(bits[:near]) - max(bits[near:])

    return estimates.bootstrap(difference, codes)


def entropy(codes):
    """Entropy in bits of the shares of codes (R,)."""
    return float(scipy.special.entr(np.bincount(codes) / codes.size).sum() / np.log(2))


# --- effects of noise -----------------------------------------------------------------------------


def rise(column):
    """ln of the high over the low plateau of r(sigma); 0 for a curve that does not rise."""
    levels = np.unique(column.noise)

    def log_contrast(*groups):
        noise = np.repeat(levels, [len(group) for group in groups])
        contrast = transition.find_rise(noise, np.concatenate(groups))["contrast"]
        return float(np.log(np.nan_to_num(contrast, nan=1.0)))

    groups = [column.disorder[column.noise == level] for level in levels]
    return estimates.bootstrap(log_contrast, groups)


def effect_on_r(low, high, quiet, noisy):
    """Mean square over u of the change of ln r that noise makes.

    The square of a mean over runs exceeds that of its expectation by the variance of the mean,
    which is subtracted. What is left is normal about the truth; its variance follows from those.
    """
    places = _shared(low, high, quiet, noisy)
    squares, variances = np.array([_squared_change(u, quiet, noisy) for u in places]).T
    weights = _trapezoid(places)
    value = float(weights @ squares)
    reach = float(scipy.stats.norm.ppf(0.975) * np.sqrt(weights**2 @ variances))
    runs = min(int(row.between(u, u).sum()) for row in (quiet, noisy) for u in places)
    return Estimate(value, value - reach, value + reach, runs)


def _squared_change(place, quiet, noisy):
    """Square of the change of the mean ln r at a place, and the variance of this estimate."""
    logs = [np.log(row.disorder[row.between(place, place)]) for row in (quiet, noisy)]
    fewest = min(map(len, logs))
    require(fewest >= LEAST_RUNS, f"{fewest} runs at u = {place:g}, {LEAST_RUNS} are needed")
    error = sum(runs.var(ddof=1) / runs.size for runs in logs)
    square = (logs[1].mean() - logs[0].mean()) ** 2 - error
    return square, 4 * max(square, 0.0) * error + 2 * error**2


def effect_on_section(low, high, quiet, noisy):
    """Mean over u of the largest distance of the distributions of v_N at the section."""
    pairs = {}
    for place in _shared(low, high, quiet, noisy):
        pair = [row.velocities[row.between(place, place)] for row in (quiet, noisy)]
        if min(np.isfinite(runs).sum() for runs in pair) >= MINIMUM_CROSSINGS:
            pairs[place] = pair
    require(len(pairs) >= MINIMUM_VELOCITIES, f"section velocities at {len(pairs)} velocities")
    weights = _trapezoid(np.array(list(pairs)))

    def distance(*samples):
        distances = [_distance(*pair) for pair in zip(samples[::2], samples[1::2], strict=True)]
        return float(weights @ distances)

    groups = [runs for pair in pairs.values() for runs in pair]
    return estimates.bootstrap(distance, groups, resamples=RESAMPLES)


def _distance(first, second):
    """Of Kolmogorov and Smirnov; 0 where a resample has no crossing."""
    first, second = (runs[np.isfinite(runs)] for runs in (first, second))
    if not (first.size and second.size):
        return 0.0
    # `scipy.stats.ks_2samp` also finds a p, which takes ten times as long
    values = np.sort(np.concatenate([first, second]))  # in order they are found faster
    below = [
        np.searchsorted(np.sort(runs), values, "right") / runs.size for runs in (first, second)
    ]
    return float(np.max(np.abs(below[0] - below[1])))


def _shared(low, high, quiet, noisy):
    """Belt velocities in a range that both rows have."""
    shared = np.intersect1d(quiet.belt_velocity, noisy.belt_velocity)
    places = shared[(shared >= low) & (shared <= high)]
    count = f"{places.size} shared belt velocities"
    require(places.size >= MINIMUM_VELOCITIES, f"{count}, {MINIMUM_VELOCITIES} are needed")
    return places


def _trapezoid(places):
    """Weights (P,) of a mean over u by the trapezoidal rule."""
    gaps = np.diff(places)
    return (np.append(gaps, 0) + np.insert(gaps, 0, 0)) / (2 * gaps.sum())
