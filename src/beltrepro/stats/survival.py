"""How long irregular motion lasts, from runs of which some were given up before it ended.

A run that still is irregular when it is given up says only that its lifetime is longer. Such a
lifetime is called censored. All functions take it as it is: `lifetime` holds the time of the end,
or the time up to which a run was followed, and `ended` tells them apart.

Irregular motion that forgets its past ends at a constant rate, so that lifetimes follow an
exponential distribution, once runs have spread: count from `start` on (`spreading_time`).

That a run ended may become known only some time after its end. Then ends shortly before the runs
are given up are missing. So ends count up to a `horizon` only (`SEEN`).
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy
from scipy.optimize import brentq

from beltrepro.base.errors import require
from beltrepro.stats.estimates import CONFIDENCE, share
from beltrepro.stats.motion import FOLDINGS, above_zero

REGULAR = "regular"
TRANSIENT = "transient"
LASTING = "lasting"
OPEN = "open"

LEVEL = 0.05  # p below which lifetimes are not exponential
MINIMUM_ENDS = 3  # fewer ends tell no distribution
# Share of its duration up to which the ends of a run of kind settling are all known. Its state must
# come back before a run counts as settled, which takes up to some 40000 time units after the end.
SEEN = 0.5
LONGEST_START = 0.1  # share of the horizon that may pass before runs are counted
_SLOWEST = 1e-6  # rate of ends, times the horizon, that is as good as none


class SurvivalCurve(NamedTuple):
    """Share of runs that are irregular for longer than a time, by Kaplan and Meier."""

    time: np.ndarray  # 0, then the instants at which a run ended or was given up, rising
    share: np.ndarray  # share of runs that last longer
    lower: np.ndarray  # confidence band, for each instant by itself
    upper: np.ndarray


def kaplan_meier(
    lifetime: npt.ArrayLike, ended: npt.ArrayLike, *, horizon: float = np.inf
) -> SurvivalCurve:
    """Share of runs that are still irregular, against time; its band by Greenwood's variance."""
    time, late = _between(0.0, horizon, lifetime, ended)
    curve = scipy.stats.ecdf(_censored(time, late)).sf
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The confidence interval is undefined", RuntimeWarning)
        band = curve.confidence_interval(CONFIDENCE, method="log-log")
    # none where the share is 1 or 0: the exact interval of a share of all runs stands for it there
    whole, none = (share(count, late.size) for count in (late.size, 0))
    left = curve.probabilities
    ends = [left == 1, left == 0]
    return SurvivalCurve(
        np.append(0.0, curve.quantiles),
        np.append(1.0, left),
        np.append(whole.low, np.select(ends, [whole.low, none.low], band.low.probabilities)),
        np.append(whole.high, np.select(ends, [whole.high, none.high], band.high.probabilities)),
    )


# --- exponential lifetimes ------------------------------------------------------------------------


class MeanLifetime(NamedTuple):
    """Mean of an exponential distribution of lifetimes."""

    mean: float  # inf without an end
    lower: float  # confidence interval; upper is inf without an end
    upper: float
    ended: int  # runs that ended after the start
    runs: int  # runs that were irregular at the start
    time: float  # time under observation, the sum over these runs


def mean_lifetime(
    lifetime: npt.ArrayLike, ended: npt.ArrayLike, *, start: float = 0.0, horizon: float = np.inf
) -> MeanLifetime:
    """Mean of exponential lifetimes: time under observation over the number of ends.

    The interval is the exact one of the rate of a Poisson process (Garwood, Biometrika 28, 437,
    1936), on the clock of the time under observation. Each end is wrong in at most half of
    1 - CONFIDENCE of all cases, whatever the number of runs.
    """
    time, late = _between(start, horizon, lifetime, ended)
    require(time.size, f"no run is irregular at t = {start:.6g}, 1 is needed")
    count, total = int(late.sum()), float(time.sum())
    tail = (1 - CONFIDENCE) / 2
    lower = 2 * total / float(scipy.stats.chi2.isf(tail, 2 * count + 2))
    if not count:
        return MeanLifetime(np.inf, lower, np.inf, count, time.size, total)
    upper = 2 * total / float(scipy.stats.chi2.ppf(tail, 2 * count))
    return MeanLifetime(total / count, lower, upper, count, time.size, total)


def mean_of_ended(lifetime: npt.ArrayLike, ended: npt.ArrayLike, *, horizon: float) -> MeanLifetime:
    """Mean of exponential lifetimes from the runs alone that ended by the horizon.

    Of the others nothing is assumed: some may last on, and some may have reached a state that this
    kind of end never leaves, as a stick-slip attractor where the end is the last stick. The
    lifetimes of runs that ended follow an exponential distribution that is cut off at the horizon.
    Its rate is that of the greatest likelihood; the interval is where twice the logarithm of the
    ratio of likelihoods is below the quantile of chi2 with one degree of freedom.
    """
    time, late = _between(0.0, horizon, lifetime, ended)
    ends = time[late]
    require(ends.size >= MINIMUM_ENDS, f"{ends.size} runs ended, {MINIMUM_ENDS} are needed")
    part = float(ends.mean()) / horizon

    def mean_up_to_one(rate: float) -> float:
        return 1 / rate - float(np.exp(-rate) / -np.expm1(-rate))

    def log_likelihood(rate: float) -> float:  # of an end
        return float(np.log(rate / -np.expm1(-rate))) - rate * part

    best = _SLOWEST
    if part < mean_up_to_one(_SLOWEST):  # a cut-off makes the mean smaller than without one
        best = brentq(lambda rate: mean_up_to_one(rate) - part, _SLOWEST, 2 / part)
    least = log_likelihood(best) - scipy.stats.chi2.ppf(CONFIDENCE, 1) / (2 * ends.size)

    def excess(rate: float) -> float:
        return log_likelihood(rate) - least

    most = 2 * max(best, 1.0)
    while excess(most) > 0:
        most *= 2
    mean = horizon / best if best > _SLOWEST else np.inf
    lower = horizon / brentq(excess, best, most)
    upper = np.inf if excess(_SLOWEST) > 0 else horizon / brentq(excess, _SLOWEST, best)
    return MeanLifetime(mean, lower, upper, ends.size, time.size, float(ends.sum()))


class WeibullTest(NamedTuple):
    """Whether the rate of ends falls or rises with time."""

    # chance that runs which end at a constant rate show a trend at least as strong as these
    p: float
    # of the Weibull distribution: below 1 if the rate of ends falls with time, as where runs of
    # two kinds are mixed; above 1 if it rises
    shape: float


def weibull_test(
    lifetime: npt.ArrayLike, ended: npt.ArrayLike, *, start: float = 0.0, horizon: float = np.inf
) -> WeibullTest:
    """Test whether the rate of ends is constant, or falls or rises with time.

    A Weibull distribution has an exponential one as the special case of shape 1. Twice the
    logarithm of the ratio of their greatest likelihoods follows chi2 with one degree of freedom if
    lifetimes are exponential. That holds for many ends. With 16 runs p is below 0.05 in 6 % of all
    cases, and with 8 in 8 %.
    """
    time, late = _between(start, horizon, lifetime, ended)
    late &= time > 0  # an end at the very start has no likelihood for some shapes
    ends = int(late.sum())
    require(ends >= MINIMUM_ENDS, f"{ends} runs ended, {MINIMUM_ENDS} are needed")
    time = time / (time.sum() / ends)  # the mean as the unit of time
    shape, _, scale = scipy.stats.weibull_min.fit(_censored(time, late), floc=0)
    weibull = scipy.stats.weibull_min(shape, scale=scale)
    likelihood = weibull.logpdf(time[late]).sum() + weibull.logsf(time[~late]).sum()
    exponential = -ends  # its greatest log-likelihood in this unit
    return WeibullTest(float(scipy.stats.chi2.sf(2 * (likelihood - exponential), 1)), float(shape))


# --- verdict --------------------------------------------------------------------------------------


class PooledExponent(NamedTuple):
    """Largest exponent of the irregular motion, over several runs; NaN where none has one."""

    value: float  # mean over the runs, with the time of each as its weight
    # standard error, from the scatter of the runs; that of the run itself if there is one only
    error: float
    time: float  # time over which a run measured it, mean over the runs
    runs: int  # runs with an exponent


def pool_exponents(
    exponent: npt.ArrayLike, error: npt.ArrayLike, time: npt.ArrayLike
) -> PooledExponent:
    """Largest exponent of irregular motion from the irregular parts of several runs."""
    rows = np.array([exponent, error, time], dtype=float)
    values, errors, times = rows[:, np.isfinite(rows[0]) & (rows[2] > 0)]
    if not (runs := values.size):
        return PooledExponent(np.nan, np.nan, 0.0, 0)
    mean = float(np.average(values, weights=times))
    if runs == 1:
        return PooledExponent(mean, float(errors[0]), float(times[0]), 1)
    scatter = np.sqrt(np.sum((times * (values - mean)) ** 2) * runs / (runs - 1))
    return PooledExponent(mean, float(scatter / times.sum()), float(times.mean()), runs)


def spreading_time(exponent: PooledExponent, horizon: float) -> float:
    """Time that runs need to forget how they started: five e-foldings of a small deviation."""
    if not above_zero(exponent.value, exponent.error, exponent.time):
        return 0.0
    return min(FOLDINGS / exponent.value, LONGEST_START * horizon)


def decide(
    lifetime: npt.ArrayLike, ended: npt.ArrayLike, *, start: float = 0.0, horizon: float = np.inf
) -> str:
    """Whether irregular motion ends, as far as these runs tell: the verdicts of docs/chaos.md."""
    _, late = _between(start, np.inf, lifetime, ended)
    if not late.size:
        return REGULAR
    if late.all():
        return TRANSIENT
    time, counted = _between(start, horizon, lifetime, ended)
    if not time.size:
        return OPEN
    if not late.any():
        # That it is permanent cannot be shown by runs of finite length. Four of equal length
        # are enough to show that the mean lifetime is longer.
        return LASTING if mean_lifetime(time, counted).lower > time.max() else OPEN
    if counted.sum() < MINIMUM_ENDS:
        return OPEN
    # A rate that falls with time is that of motions of which some end and others do not; else the
    # others can be expected to end too.
    test = weibull_test(time, counted)
    return OPEN if test.p < LEVEL and test.shape < 1 else TRANSIENT


def _between(
    start: float, horizon: float, lifetime: npt.ArrayLike, ended: npt.ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Time after the start of the runs that are irregular then, and which end by the horizon."""
    times, ends = np.asarray(lifetime, dtype=float), np.asarray(ended, dtype=bool)
    require(times.size, "no runs, 1 is needed")
    seen = np.minimum(times, horizon)
    late = seen >= start
    return seen[late] - start, (ends & (times <= horizon))[late]


def _censored(lifetime: np.ndarray, ended: np.ndarray) -> scipy.stats.CensoredData:
    return scipy.stats.CensoredData(uncensored=lifetime[ended], right=lifetime[~ended])
