"""Measured numbers with their intervals: what criteria judge.

An interval is the central 95 % of what independent runs give. It says nothing of what all runs
share; where an estimator has such an error (the spacing of a grid, say), it is in the interval too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy

from beltrepro.base.errors import require

CONFIDENCE = 0.95  # of intervals, where nothing else is said
RESAMPLES = 1000
# Of one recording: few enough that most of what lasts fits into one, enough for Student's t.
STRETCHES = 16


@dataclass(frozen=True, repr=False)
class Estimate:
    """A measured number with its interval.

    Attributes
    ----------
    value : float
        The number; NaN where nothing was found.
    low, high : float
        Its 95 % interval; infinite where one run tells no error.
    runs : int or None
        Independent runs, or stretches of few, that it rests on; None if it is no matter of chance.
    still_open : int
        Of these, runs that must be longer to tell; the interval covers all they may be.
    """

    value: float
    low: float
    high: float
    runs: int | None = None
    still_open: int = 0

    def __repr__(self) -> str:
        runs = "" if self.runs is None else f", {self.runs} runs"
        return f"Estimate({self.value:.6g}, {self.low:.6g} to {self.high:.6g}{runs})"

    @property
    def numbers(self) -> tuple[float, float, float]:
        """The number and the ends of its interval."""
        return self.value, self.low, self.high

    @property
    def words(self) -> str:
        """The number and its interval, short; "yes" and "no" for what is sure.

        Of a single run, whose error is not known, the number alone.
        """
        if math.isnan(self.value):
            return "not found"
        if self.runs is None and self.value in (0.0, 1.0) and self.low == self.high:
            return ("no", "yes")[int(self.value)]
        if self.low == self.high:
            return f"{self.value:.4g}"
        interval = {
            (True, True): f"{self.low:.3g} to {self.high:.3g}",
            (True, False): f"{self.low:.3g} or more",
            (False, True): f"{self.high:.3g} or less",
            (False, False): "error not known" if math.isnan(self.low) else "one run",
        }[math.isfinite(self.low), math.isfinite(self.high)]
        return f"{self.value:.3g} ({interval})"

    def named(self, *names: str) -> dict[str, float]:
        """The number and the ends of its interval under three names, as columns of a table.

        Parameters
        ----------
        *names : str
            Of the number and the ends.

        Returns
        -------
        dict
            The three numbers by name.
        """
        return dict(zip(names, self.numbers, strict=True))

    def scaled(self, factor: float) -> Estimate:
        """The number and its interval times a factor.

        Parameters
        ----------
        factor : float
            A number of either sign.

        Returns
        -------
        Estimate
            It rests on as many runs.
        """
        low, high = sorted((factor * self.low, factor * self.high))
        return replace(self, value=factor * self.value, low=low, high=high)


def sure(value: float | bool) -> Estimate:
    """What is no matter of chance: a closed form, a property of the model, a yes or no."""
    return Estimate(float(value), float(value), float(value))


def all_sure(values: dict[str, float | bool]) -> dict[str, Estimate]:
    return {name: sure(value) for name, value in values.items()}


def single(value: float) -> Estimate:
    """What one run gave: nothing is known of its error, so the interval is everything."""
    return Estimate(float(value), -math.inf, math.inf, 1)


def absent(runs: int | None = None) -> Estimate:
    """What was looked for and not found."""
    return Estimate(math.nan, math.nan, math.nan, runs)


def about(value: float, below: float, above: float, runs: int | None) -> Estimate:
    """A number whose interval reaches so far below and above it."""
    return Estimate(float(value), float(value - below), float(value + above), runs)


def from_error(value: float, error: float, runs: int | None, freedom: float = math.inf) -> Estimate:
    """A number with a standard error that so many degrees of freedom tell, by Student's t."""
    reach = scipy.stats.t.ppf((1 + CONFIDENCE) / 2, freedom) * error
    return about(value, reach, reach, runs)


def error_of(low: Any, high: Any) -> Any:
    """The standard error of which intervals have these ends."""
    return (high - low) / (2 * scipy.stats.norm.ppf((1 + CONFIDENCE) / 2))


def mean(samples: Sequence[float] | np.ndarray) -> Estimate:
    """Mean of independent runs, with the interval of Student's t."""
    samples = np.asarray(samples, dtype=float)
    runs = samples.size
    require(runs >= 2, f"{runs} runs, 2 are needed for an interval")
    return from_error(samples.mean(), scipy.stats.sem(samples), runs, runs - 1)


def share(count: int, runs: int, still_open: int = 0) -> Estimate:
    """Share of independent runs, with the exact interval of Clopper and Pearson.

    It holds for few runs and for shares of 0 and 1 too (Biometrika 26, 404, 1934). It covers both
    that none and that all of those still open have the property; the value is that none has.
    """
    require(runs > 0, "no runs, 1 is needed")
    most, tail = count + still_open, (1 - CONFIDENCE) / 2
    low = scipy.special.betaincinv(count, runs - count + 1, tail) if count else 0.0
    high = scipy.special.betainccinv(most + 1, runs - most, tail) if most < runs else 1.0
    return Estimate(count / runs, float(low), float(high), int(runs), int(still_open))


def share_of(having: np.ndarray, unknown: np.ndarray | None = None) -> Estimate:
    """`share` of the runs that a mask marks; the others of a second one are still open."""
    open_runs = 0 if unknown is None else np.sum(np.asarray(unknown) & ~np.asarray(having))
    return share(np.sum(having), np.size(having), open_runs)


def bootstrap(
    statistic: Callable[..., float],
    samples: Sequence[np.ndarray],
    *,
    resamples: int | None = None,
    grid_spacing: float = 0.0,
) -> Estimate:
    """Statistic of groups of independent runs, with a bootstrap interval.

    Within each group the runs, its first axis, are drawn anew with replacement, group by group
    (stratified bootstrap: A. C. Davison and D. V. Hinkley, Bootstrap Methods and their Application,
    1997, Sec. 3.2). For the interval see `from_resamples`. Of a group of one run nothing is known
    of the error (`single`).
    """
    samples = [np.asarray(group) for group in samples]
    runs = min(len(group) for group in samples)
    value = float(statistic(*samples))
    if runs < 2:
        return single(value)
    rng = np.random.default_rng(0)
    redrawn = np.array(
        [
            statistic(*(group[rng.integers(0, len(group), len(group))] for group in samples))
            for _ in range(resamples or RESAMPLES)
        ],
        dtype=float,
    )
    return from_resamples(value, redrawn, runs, grid_spacing=grid_spacing)


def from_resamples(
    value: float, redrawn: np.ndarray, runs: int, *, grid_spacing: float = 0.0
) -> Estimate:
    """The estimate that a value and its resamples make, which are NaN where nothing is found.

    There is no interval if that is so in more than 5 %. Half the spacing of a grid on which values
    lie is added to it in quadrature. Resamples of few runs scatter less than the runs do, and more
    of them than 95 % are within the interval: as many as make the interval of a mean that of
    Student's t (expanded percentiles: T. C. Hesterberg, The American Statistician 69, 371, 2015).
    With four runs all resamples are within, and that is still too narrow: it covers a mean in 86 %.
    """
    finite = redrawn[np.isfinite(redrawn)]
    if math.isnan(value):
        return absent(runs)
    if finite.size < 0.95 * redrawn.size:
        return Estimate(value, math.nan, math.nan, runs)
    reach = scipy.stats.t.ppf((1 + CONFIDENCE) / 2, runs - 1) * math.sqrt(runs / (runs - 1))
    tail = scipy.stats.norm.sf(reach)
    low, high = np.quantile(finite, [tail, 1 - tail])
    # a value outside the quantiles of its own resamples is an end of the interval
    below, above = (
        math.hypot(max(0.0, side), grid_spacing / 2) for side in (value - low, high - value)
    )
    return about(value, below, above, runs)


def difference(first: Estimate, second: Estimate) -> Estimate:
    """First minus second, of independent runs; the sides of the intervals add in quadrature."""
    below = math.hypot(first.value - first.low, second.high - second.value)
    above = math.hypot(first.high - first.value, second.value - second.low)
    return about(first.value - second.value, below, above, fewest(first, second))


def ratio(first: Estimate, second: Estimate) -> Estimate:
    """First over second, both above zero: as `difference`, of their logarithms."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return mapped(np.exp, difference(mapped(np.log, first), mapped(np.log, second)))


def mapped(function: Callable[[float], float], estimate: Estimate) -> Estimate:
    """Rising function of an estimate."""
    value, low, high = map(float, map(function, estimate.numbers))
    return replace(estimate, value=value, low=low, high=high)


def fewest(*numbers: Estimate) -> int | None:
    """Runs of the estimate that rests on fewest; None if none rests on runs."""
    return min((number.runs for number in numbers if number.runs is not None), default=None)


def slope(places: Sequence[float], points: Sequence[Estimate]) -> Estimate:
    """Slope of a straight line through estimates, weighted by their intervals.

    The interval follows from those of the estimates, widened where they scatter more about the
    line than their intervals explain (by the root of the reduced chi square, if above 1).
    """
    require(len(points) >= 3, f"{len(points)} points, 3 are needed for a slope")
    values, low, high = np.array([point.numbers for point in points]).T
    errors = error_of(low, high)
    require(bool(np.all(np.isfinite(values)) and np.all(errors > 0)), "a point has no interval")
    line, covariance = np.polyfit(places, values, 1, w=1 / errors, cov="unscaled")
    excess = np.sum(((values - np.polyval(line, places)) / errors) ** 2) / (len(points) - 2)
    return from_error(line[0], math.sqrt(max(1.0, excess) * covariance[0, 0]), fewest(*points))


def trend(places: Sequence[float], points: Sequence[Estimate]) -> Estimate:
    """Slope of the line of least squares through estimates, all with the same weight.

    It says whether values rise or fall on the whole, not whether they lie on a line: scatter about
    the line does not widen the interval. The sides of the intervals add as for `difference`.
    """
    require(len(points) >= 3, f"{len(points)} points, 3 are needed for a trend")
    centred = np.asarray(places, dtype=float) - np.mean(places)
    shares = centred / np.sum(centred**2)
    # one in the middle says nothing, even if it is not known at all
    parts = [point.scaled(share) for share, point in zip(shares, points, strict=True) if share]
    below = math.hypot(*(part.value - part.low for part in parts))
    above = math.hypot(*(part.high - part.value for part in parts))
    return about(sum(part.value for part in parts), below, above, fewest(*points))


# --- of one recording -----------------------------------------------------------------------------


def sums_in_stretches(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sums (K, 3) of weights, of values and of their squares, in stretches of equal weight."""
    least = 2 * STRETCHES  # with fewer some stretches would be empty, and count as independent
    require(values.size >= least, f"{values.size} values, {least} are needed for an interval")
    share = (np.cumsum(weights) - weights / 2) / weights.sum()
    # a last value without weight has a share of 1
    place = np.minimum((STRETCHES * share).astype(int), STRETCHES - 1)
    terms = (weights, weights * values, weights * values**2)
    return np.stack([np.bincount(place, term, STRETCHES) for term in terms], axis=1)


def from_stretches(statistic: Callable[[np.ndarray], float], parts: np.ndarray) -> Estimate:
    """Statistic of the sum of the parts (K, M) of a recording that its stretches are, in order.

    Each stretch is left out once; by how much that changes the statistic gives its error (block
    jackknife: H. R. Künsch, Annals of Statistics 17, 1217, 1989). What lasts longer than a
    stretch makes neighbours alike. With the correlation c of neighbours, K (1 - c) / (1 + c) of
    the K stretches are independent; they are the runs of the estimate.
    """
    count = len(parts)
    require(count >= 3, f"{count} stretches, 3 are needed for an interval")
    whole = parts.sum(axis=0)
    value = float(statistic(whole))
    without = np.array([statistic(whole - part) for part in parts])
    if not np.isfinite(without).all():
        return Estimate(value, math.nan, math.nan, 1)
    excess = (count - 1) * (without.mean() - without)  # of a stretch over the mean of all
    squares = float((excess**2).sum())
    # unlike neighbours, too, are no more than K independent stretches
    alike = max(0.0, float((excess[1:] * excess[:-1]).sum()) / squares) if squares else 0.0
    independent = count * (1 - alike) / (1 + alike)
    if independent < 2:
        return Estimate(value, math.nan, math.nan, 1)
    error = math.sqrt(squares / (count - 1) / independent)
    return from_error(value, error, int(independent), independent - 1)
