"""Claims on how the effect of noise depends on the number of blocks (Sec. V, Figs. 21 and 22)."""

from functools import partial

import numpy as np
import scipy

from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, transitions
from beltrepro.stats.errors import require
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.transitions import LEAST_RUNS

MINIMUM_VELOCITIES = 4
MINIMUM_CROSSINGS = 30
RESAMPLES = 100  # of section velocities, which are many


@claim("r-of-sigma-size")
def r_of_sigma_size(evidence):
    """Rise of r with noise at the upper edge of the transition, for several N."""
    return {
        "logarithm of the ratio of the plateaus": partial(_rises, evidence, _contrast),
        "the same over the width of the rise": partial(_rises, evidence, _steepness),
    }


def _rises(evidence, evident):
    scan = evidence.dataset("size_columns").arrays
    found = {}
    for n_blocks in evidence.claim.parameters["n_blocks"]:
        own = scan["belt_velocity"][scan["n_blocks"] == n_blocks]
        require(own.size, f"size_columns has no runs of {n_blocks} blocks")
        column = evidence.column("size_columns", n_blocks, own.max())
        levels = np.unique(column.noise)
        groups = [column.disorder[column.noise == level] for level in levels]
        found[n_blocks] = estimates.bootstrap(partial(_of_rise, evident, levels), groups)
    return _weaker_with_size(found)


def _of_rise(evident, levels, *groups):
    noise = np.repeat(levels, [len(group) for group in groups])
    return evident(transitions.find_rise(noise, np.concatenate(groups)))


def _contrast(rise):
    """ln of high over low plateau; 0 for a curve that does not rise."""
    return float(np.log(np.nan_to_num(rise.contrast, nan=1.0)))


def _steepness(rise):
    return _contrast(rise) / rise.width if rise.found and rise.width > 0 else 0.0


@claim("noise-less-relevant")
def noise_less_relevant(evidence):
    """Effect of noise on r and on the section velocities, for five and more blocks."""
    return {
        "r, the same u for all N": partial(_noise_effects, evidence, _of_r, True),
        "r, all u of each N": partial(_noise_effects, evidence, _of_r, False),
        "section velocities": partial(_noise_effects, evidence, _of_section, True),
    }


def _noise_effects(evidence, effect_of, common):
    parameters = evidence.claim.parameters
    low, high = parameters["belt_velocity"] if common else (0.0, np.inf)
    found = {}
    for n_blocks in parameters["n_blocks"]:
        quiet, noisy = (
            evidence.replicates(n_blocks, noise) for noise in (0.0, parameters["noise"])
        )
        shared = np.intersect1d(quiet.belt_velocity, noisy.belt_velocity)
        places = shared[(shared >= low) & (shared <= high)]
        require(
            places.size >= MINIMUM_VELOCITIES,
            f"{places.size} shared belt velocities at N = {n_blocks}, {MINIMUM_VELOCITIES} needed",
        )
        found[n_blocks] = effect_of(places, quiet, noisy)
    return _weaker_with_size(found)


def _of_r(places, quiet, noisy):
    """Mean square over u of the change of ln r that noise makes.

    The square of a mean over runs exceeds that of its expectation by the variance of the mean,
    which is subtracted. What is left is normal about the truth; its variance follows from those.
    """
    squares, variances = np.array([_squared_change(place, quiet, noisy) for place in places]).T
    weights = _trapezoid(places)
    value = float(weights @ squares)
    reach = float(scipy.stats.norm.ppf(0.975) * np.sqrt(weights**2 @ variances))
    return Estimate(value, value - reach, value + reach, _fewest(places, quiet, noisy))


def _squared_change(place, quiet, noisy):
    """Square of the change of the mean ln r at a place, and the variance of this estimate."""
    logs = [np.log(cut.disorder[cut.between(place, place)]) for cut in (quiet, noisy)]
    fewest = min(map(len, logs))
    require(fewest >= LEAST_RUNS, f"{fewest} runs at u = {place:g}, {LEAST_RUNS} are needed")
    error = sum(own.var(ddof=1) / own.size for own in logs)
    square = (logs[1].mean() - logs[0].mean()) ** 2 - error
    return square, 4 * max(square, 0.0) * error + 2 * error**2


def _of_section(places, quiet, noisy):
    """Mean over u of the largest distance of the distributions of v_N at the section."""
    groups, known = [], []
    for place in places:
        pair = [cut.velocities[cut.between(place, place)] for cut in (quiet, noisy)]
        if min(np.isfinite(own).sum() for own in pair) >= MINIMUM_CROSSINGS:
            known.append(place)
            groups += pair
    require(len(known) >= MINIMUM_VELOCITIES, f"section velocities at {len(known)} velocities")
    weights = _trapezoid(np.array(known))

    def distance(*samples):
        each = [_distance(*pair) for pair in zip(samples[::2], samples[1::2], strict=True)]
        return float(weights @ each)

    return estimates.bootstrap(distance, groups, resamples=RESAMPLES)


def _distance(first, second):
    """Of Kolmogorov and Smirnov; 0 where a resample has no crossing."""
    first, second = (own[np.isfinite(own)] for own in (first, second))
    if not (first.size and second.size):
        return 0.0
    # only the distance counts: the exact p, which goes unread, takes ten times as long
    return float(scipy.stats.ks_2samp(first, second, method="asymp").statistic)


def _trapezoid(places):
    """Weights (P,) of a mean over u by the trapezoidal rule."""
    gaps = np.diff(places)
    return (np.append(gaps, 0) + np.insert(gaps, 0, 0)) / (2 * gaps.sum())


def _fewest(places, *cuts):
    return min(int(cut.between(place, place).sum()) for cut in cuts for place in places)


def _weaker_with_size(found):
    """Trend over N of an effect; not found if no number of blocks shows any."""
    sizes = sorted(found)
    judged = {
        "slope over N": estimates.trend(sizes, [found[n] for n in sizes]),
        "N = 5 minus N = 10": estimates.difference(found[5], found[10]),
    }
    if not any(each.value > 0 for each in found.values()):
        judged = dict.fromkeys(judged, estimates.absent(estimates.fewest(*found.values())))
    return Measurement(judged, {f"N = {n}": found[n] for n in sizes})
