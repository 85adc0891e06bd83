"""How long irregular motion lasts, from runs of which some were given up before it ended.

A run that still is irregular when it is given up says only that its lifetime is longer. Such a
lifetime is called censored. `lifetime` holds the time of the end, or the time up to which a run was
followed, and `ended` tells them apart. `observed` cuts them to the span that counts.

Irregular motion that forgets its past ends at a constant rate, so that lifetimes follow an
exponential distribution, once runs have spread: count from a `start` on (`spreading_time`).

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
from beltrepro.stats.estimates import CONFIDENCE, Estimate, share
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
# Share of the horizon that may pass before runs are counted: an exponent near zero would leave
# nothing to count.
LONGEST_START = 0.1
# Rate of ends, times the horizon, that is as good as none: at 0 the formulas divide by it.
_SLOWEST = 1e-6


def observed(
    lifetime: npt.ArrayLike, ended: npt.ArrayLike, *, start: float = 0.0, horizon: float = np.inf
) -> tuple[np.ndarray, np.ndarray]:
    """Time after the start of the runs that are irregular then, and which end by the horizon."""
    times, ends = np.asarray(lifetime, dtype=float), np.asarray(ended, dtype=bool)
    require(times.size, "no runs, 1 is needed")
    seen = np.minimum(times, horizon)
    late = seen >= start
    return seen[late] - start, (ends & (times <= horizon))[late]


class SurvivalCurve(NamedTuple):
    """Share of runs that are irregular for longer than a time, by Kaplan and Meier."""

    time: np.ndarray  # 0, then the instants at which a run ended or was given up, rising
    share: np.ndarray
    lower: np.ndarray  # confidence band, for each instant by itself
    upper: np.ndarray


def kaplan_meier(lifetime: np.ndarray, ended: np.ndarray) -> SurvivalCurve:
    """Share of runs that are still irregular, against time; its band by Greenwood's variance."""
    curve = scipy.stats.ecdf(_censored(lifetime, ended)).sf
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The confidence interval is undefined", RuntimeWarning)
        # of log(-log(share)): that of the share itself may reach beyond 0 and 1
        band = curve.confidence_interval(CONFIDENCE, method="log-log")
    # none where the share is 1 or 0: the exact interval of a share of all runs stands for it there
    whole, none = (share(count, ended.size) for count in (ended.size, 0))
    left = curve.probabilities
    ends = [left == 1, left == 0]
    return SurvivalCurve(
        np.append(0.0, curve.quantiles),
        np.append(1.0, left),
        np.append(whole.low, np.select(ends, [whole.low, none.low], band.low.probabilities)),
        np.append(whole.high, np.select(ends, [whole.high, none.high], band.high.probabilities)),
    )


def mean_lifetime(lifetime: np.ndarray, ended: np.ndarray) -> Estimate:
    """Mean of exponential lifetimes: time under observation over the number of ends.

    The interval is the exact one of the rate of a Poisson process (Garwood, Biometrika 28, 437,
    1936), on the clock of the time under observation. Each end is wrong in at most half of
    1 - CONFIDENCE of all cases, whatever the number of runs. Without an end the mean is infinite.
    """
    runs, count, total = lifetime.size, int(ended.sum()), float(lifetime.sum())
    require(runs, "no run is irregular at the start, 1 is needed")
    tail = (1 - CONFIDENCE) / 2
    lower = 2 * total / float(scipy.stats.chi2.isf(tail, 2 * count + 2))
    if not count:
        return Estimate(np.inf, lower, np.inf, runs)
    upper = 2 * total / float(scipy.stats.chi2.ppf(tail, 2 * count))
    return Estimate(total / count, lower, upper, runs)


def mean_of_ended(lifetime: np.ndarray, ended: np.ndarray, *, horizon: float) -> Estimate:
    """Mean of exponential lifetimes from the runs alone that ended by the horizon.

    Of the others nothing is assumed: some may last on, and some may have reached a state that this
    kind of end never leaves, as a stick-slip attractor where the end is the last stick. The
    lifetimes of runs that ended follow an exponential distribution that is cut off at the horizon.
    Its rate is that of the greatest likelihood; the interval is where twice the logarithm of the
    ratio of likelihoods is below the quantile of chi2 with one degree of freedom.
    """
    ends = lifetime[ended]
    require(ends.size >= MINIMUM_ENDS, f"{ends.size} runs ended, {MINIMUM_ENDS} are needed")
    part = float(ends.mean()) / horizon

    def mean_up_to_one(rate: float) -> float:
        return 1 / rate - float(np.exp(-rate) / -np.expm1(-rate))

    def log_likelihood(rate: float) -> float:  # of an end
        return float(np.log(rate / -np.expm1(-rate))) - rate * part

    best = _SLOWEST
    if part < mean_up_to_one(_SLOWEST):  # a cut-off makes the mean smaller than without one
        # the mean is below 1 / rate
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
    return Estimate(mean, lower, upper, lifetime.size)


def weibull_test(lifetime: np.ndarray, ended: np.ndarray) -> tuple[float, float]:
    """Whether the rate of ends is constant: p, and the shape of the Weibull distribution.

    The shape is below 1 if the rate falls with time, as where runs of two kinds are mixed, and
    above 1 if it rises. A Weibull distribution has an exponential one as the special case of shape
    1. Twice the logarithm of the ratio of their greatest likelihoods follows chi2 with one degree
    of freedom if lifetimes are exponential. That holds for many ends. With 16 runs p is below 0.05
    in 6 % of all cases, and with 8 in 8 %.
    """
    ended = ended & (lifetime > 0)  # an end at the very start has no likelihood for some shapes
    ends = int(ended.sum())
    require(ends >= MINIMUM_ENDS, f"{ends} runs ended, {MINIMUM_ENDS} are needed")
    time = lifetime / (lifetime.sum() / ends)  # the mean as the unit of time
    shape, _, scale = scipy.stats.weibull_min.fit(_censored(time, ended), floc=0)
    weibull = scipy.stats.weibull_min(shape, scale=scale)
    likelihood = weibull.logpdf(time[ended]).sum() + weibull.logsf(time[~ended]).sum()
    exponential = -ends  # its greatest log-likelihood in this unit
    return float(scipy.stats.chi2.sf(2 * (likelihood - exponential), 1)), float(shape)


def _censored(lifetime: np.ndarray, ended: np.ndarray) -> scipy.stats.CensoredData:
    return scipy.stats.CensoredData(uncensored=lifetime[ended], right=lifetime[~ended])


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
    _, late = observed(lifetime, ended, start=start)
    if not late.size:
        return REGULAR
    if late.all():
        return TRANSIENT
    time, counted = observed(lifetime, ended, start=start, horizon=horizon)
    if not time.size:
        return OPEN
    if not late.any():
        # That it is permanent cannot be shown by runs of finite length. Four of equal length
        # are enough to show that the mean lifetime is longer.
        return LASTING if mean_lifetime(time, counted).low > time.max() else OPEN
    if counted.sum() < MINIMUM_ENDS:
        return OPEN
    # A rate that falls with time is that of motions of which some end and others do not; else the
    # others can be expected to end too.
    p, shape = weibull_test(time, counted)
    return OPEN if p < LEVEL and shape < 1 else TRANSIENT
