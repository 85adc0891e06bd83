"""Where r falls with u, and where it rises with noise (Figs. 12 to 15, 19 and 21).

Near the fall a run ends on a branch of high or of low r; noise lets long runs change between them.
Where each run lies between the branches, y in 0..1, falls with u as

    E[y] = s_low + (1 - s_low - s_high) / (1 + exp((u - u_c) / w)),

a logistic regression with runs as units (of shares too: L. E. Papke and J. M. Wooldridge, Journal
of Applied Econometrics 11, 619, 1996). s_low and s_high are shares of stray runs: attractors of
large r beyond the fall, periodic windows before it. A place with n runs weighs 1 / (phi / n + rho):
phi is the variance of y among runs at a place over the binomial one, rho that among places, since
neighbouring u may have other attractors. All but phi are integrated over on a grid, as is done for
psychometric curves (H. H. Schuett et al., Vision Research 122, 105, 2016): a likelihood alone has
no end where all runs change branch between two neighbouring u.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate

QUANTITIES = ("critical", "lower", "upper", "width", "r_high", "r_low", "contrast")
MINIMUM_POINTS = 8
# What the lower end of the contrast must reach: a flat row, parted where that looks best, has less.
MINIMUM_CONTRAST = 1.1
ROUNDS = 4  # how often the plateaus are read off anew, beside the fall that was found
PLATEAU = 4  # places that each plateau should have, and the least that it has is one fewer
# r falls from 90 % to 10 % within so many w on either side of u_c.
EDGE = np.log(9)
CELLS = 4  # of u_c in each gap of the grid
WIDTHS = 14
# Weak priors, chosen by the coverage of the intervals (tests/stats/test_fall.py).
STRAY = np.array([0.003, 0.06, 0.25])
STRAY_WEIGHT = np.array([0.4, 0.25, 0.35])
AMONG = np.array([0.0, 0.08, 0.3, 0.7])
AMONG_WEIGHT = np.array([0.4, 0.3, 0.2, 0.1])
# A smooth fall is no exact logistic function: a run never tells more than this many coin tosses.
LEAST_PHI = 0.25
DROPPED = 8.0  # in log likelihood below the best: such cells are left out
DRAWS = 2000
AS_LIKELY = np.exp(-1.92)  # of the best: what a 95 % interval holds

# Of r_high over r_low: a flat column of 5 or 10 single runs that scatter by 10 % reaches 1.25 in
# 5 % of cases.
MINIMUM_RISE = 1.3
MINIMUM_PLACES = 5
LEAST_RUNS = 4  # at each noise
# How far a number may be off by the grid alone, in spacings: a jump between two points has its
# edges anywhere between them.
ON_THE_GRID = {"critical": 1.0, "lower": 2.0, "upper": 2.0, "width": 2.0}


# --- falls ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    """Runs in order of u and r, and where those of each place begin."""

    u: np.ndarray
    r: np.ndarray
    places: np.ndarray
    first: np.ndarray
    count: np.ndarray

    @classmethod
    def of(cls, belt_velocity: npt.ArrayLike, disorder: npt.ArrayLike) -> Row:
        u, r = _in_order(belt_velocity, disorder, MINIMUM_POINTS)
        return cls(u, r[np.lexsort((r, u))], *np.unique(u, return_index=True, return_counts=True))

    @property
    def runs(self) -> int:
        """Runs at half of the places, at least: where outliers are left out one may remain."""
        return int(np.median(self.count))

    def mean(self, values: np.ndarray) -> np.ndarray:
        return np.add.reduceat(values, self.first) / self.count


Sides = tuple[np.ndarray, np.ndarray]  # masks of the runs on the high side of a fall, and the low


class Draws(NamedTuple):
    """What the runs leave open of a fall."""

    critical: np.ndarray  # u_c (DRAWS,)
    scale: np.ndarray  # w
    may_jump: bool  # a fall sharper than the grid is as good
    may_go_on: bool  # a fall wider than the row is as good

    def numbers(self, runs: int) -> dict[str, Estimate]:
        reach = EDGE * self.scale
        draws = {"critical": self.critical, "lower": self.critical - reach}
        draws |= {"upper": self.critical + reach, "width": 2 * reach}
        tail = (1 - estimates.CONFIDENCE) / 2
        numbers = {}
        for name, values in draws.items():
            value, low, high = np.quantile(values, [0.5, tail, 1 - tail]).tolist()
            numbers[name] = Estimate(value, low, high, runs)
        if self.may_jump:
            numbers["width"] = replace(numbers["width"], low=0.0)
        if self.may_go_on:
            numbers |= {name: replace(numbers[name], high=np.inf) for name in ("width", "upper")}
        return numbers


def fall(belt_velocity: npt.ArrayLike, disorder: npt.ArrayLike) -> dict[str, Estimate]:
    """The fall of r along u, from several runs at each: `QUANTITIES`.

    critical is u_c; lower, upper and width are those of the fall from 90 % to 10 %. Where runs
    cannot tell the end of the fall, upper and width have no upper end. There is no fall, and
    plateaus and contrast alone are known, if the contrast may lie below MINIMUM_CONTRAST.
    """
    row = Row.of(belt_velocity, disorder)
    require(row.count.max() > 1, "one run at each point, 2 are needed")
    numbers = dict.fromkeys(QUANTITIES, estimates.absent(row.runs))
    fit = _fit(row)
    if fit is None:
        return numbers
    draws, beside, on_branch = fit
    # Of all runs: those above the middle are larger than those below in a flat row, too.
    if _plateaus(row, beside)["contrast"].low >= MINIMUM_CONTRAST:
        numbers |= draws.numbers(row.runs)
    return numbers | _plateaus(row, on_branch)


def _plateaus(row: Row, sides: Sides) -> dict[str, Estimate]:
    """Medians of the two sides and their ratio; runs are drawn anew at each place by itself."""
    rng = np.random.default_rng(0)
    high, low = (
        np.append(np.median(r), np.median(r[_redrawn(u, rng)], axis=1))
        for u, r in ((row.u[side], row.r[side]) for side in sides)
    )
    medians = {"r_high": high, "r_low": low, "contrast": high / low}
    return {
        name: estimates.from_resamples(float(values[0]), values[1:], max(row.runs, 2))
        for name, values in medians.items()
    }


def _redrawn(place: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Indices (RESAMPLES, R) of runs in order of their place, drawn anew at each by itself."""
    _, first, count = np.unique(place, return_index=True, return_counts=True)
    begin, size = np.repeat(first, count), np.repeat(count, count)
    return begin + (rng.random((estimates.RESAMPLES, place.size)) * size).astype(int)


def _fit(row: Row) -> tuple[Draws, Sides, Sides] | None:
    """What runs say of the fall, those beside it, and of these the ones on the branch of each side.

    The plateaus are read off beside it, anew up to `ROUNDS` times. None where r falls nowhere.
    """
    step = best_step(row.u, row.r, falling=True)
    if not np.isfinite(step):
        return None
    near = far = (step, step)
    middle, seen = np.nan, []
    for _ in range(ROUNDS):
        beside = _beside(row, near, far)
        high, low = beside[0] & (row.r > middle), beside[1] & (row.r < middle)
        on_branch = high if high.any() else beside[0], low if low.any() else beside[1]
        r_high, r_low = levels = tuple(float(np.median(row.r[side])) for side in on_branch)
        if not r_high > r_low:
            return None
        if levels in seen:
            break
        seen.append(levels)
        middle = (r_high + r_low) / 2
        position = (row.r - r_low) / (r_high - r_low)
        phi = _phi(row, position.clip(0, 1))
        draws = _drawn(row.places, row.mean(position).clip(0, 1), row.count, phi)
        centre, reach = np.median(draws.critical), EDGE * np.median(draws.scale)
        near = centre - reach, centre + reach
        # Beside the edges themselves plateaus hold 10 % of a gradual fall, which looks the sharper.
        far = centre - 2 * reach, centre + 2 * reach
    return draws, beside, on_branch


def _beside(row: Row, near: tuple[float, float], far: tuple[float, float]) -> Sides:
    """The runs from half the lower edge to it, and from the upper edge to twice it.

    The edges are the far ones, or as near as leaves PLATEAU places. Where a row goes on beyond, its
    length does not decide on the plateaus.
    """
    places = row.places
    lower = max(far[0], min(near[0], places[PLATEAU - 1]), places[PLATEAU - 2])
    upper = min(far[1], max(near[1], places[-PLATEAU]), places[1 - PLATEAU])
    begin = min(lower / 2, places[places <= lower][1 - PLATEAU])
    end = max(2 * upper, places[places >= upper][PLATEAU - 2])
    return (row.u >= begin) & (row.u <= lower), (row.u >= upper) & (row.u <= end)


def _phi(row: Row, position: np.ndarray) -> float:
    """Variance among the runs at a place over that of coin tosses; 1 where none tell."""
    mean = row.mean(position)
    squares = row.mean((position - np.repeat(mean, row.count)) ** 2) * row.count
    # beyond, on a plateau, it is the scatter of r about a branch and no toss
    tells = (row.count > 1) & (mean > 0.05) & (mean < 0.95)
    mean, count = mean[tells], row.count[tells]
    variance = squares[tells] / (count - 1)
    # for the mean m of n runs m (1 - m) is too small by their variance over n
    tosses = np.sum(count * mean * (1 - mean) + variance)
    # drawn to 1 by one more toss of a fair coin, whose variance is 1/4
    return max(float((0.25 + np.sum(count * variance)) / (0.25 + tosses)), LEAST_PHI)


def _drawn(places: np.ndarray, mean: np.ndarray, count: np.ndarray, phi: float) -> Draws:
    """Draws of u_c and w from a grid of cells, alike within a cell."""
    gaps = np.diff(places)
    inside = (np.arange(CELLS) + 0.5) / CELLS
    centres = (places[:-1, np.newaxis] + gaps[:, np.newaxis] * inside).ravel()
    lengths = np.repeat(gaps / CELLS, CELLS)
    widths = np.array([gaps.min() / 4, places[-1] - places[0]])
    narrowest, widest = np.log(widths / (2 * EDGE))
    log_scale = np.linspace(narrowest, widest, WIDTHS + 1)
    scale = np.exp((log_scale[1:] + log_scale[:-1]) / 2)
    distance = (centres[:, np.newaxis] - places[:, np.newaxis, np.newaxis]) / scale
    curve = scipy.special.expit(distance).reshape(places.size, -1)
    weight = 1 / (phi / count + AMONG[:, np.newaxis])
    cells, weights = _posterior(curve, np.repeat(lengths, WIDTHS), mean, weight)
    place, width = np.divmod(cells, WIDTHS)
    of_width = np.bincount(width, weights.sum(axis=0), WIDTHS)
    likely = of_width > AS_LIKELY * of_width.max()
    rng = np.random.default_rng(0)
    total = np.cumsum(weights)
    at = (np.arange(DRAWS) + rng.random(DRAWS)) / DRAWS * total[-1]
    drawn = np.searchsorted(total, at) % cells.size
    place, width = place[drawn], width[drawn]
    critical = centres[place] + (rng.random(DRAWS) - 0.5) * lengths[place]
    scale = np.exp(log_scale[width] + (log_scale[1] - log_scale[0]) * rng.random(DRAWS))
    return Draws(critical, scale, bool(likely[0]), bool(likely[-1]))


def _posterior(
    curve: np.ndarray, prior: np.ndarray, mean: np.ndarray, weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cells (C,) that are not out of the question, and weights (A, C) for each dispersion."""
    # A likelihood rules most cells out: of 5 % stray runs, and of the third of four dispersions.
    rough = _log_likelihood(0.05 + 0.9 * curve, mean, weight[2:3])[0]
    cells = np.flatnonzero(rough > rough.max() - DROPPED)
    beyond, before = STRAY[:, np.newaxis, np.newaxis], STRAY[:, np.newaxis]
    expected = beyond + (1 - beyond - before) * curve[:, np.newaxis, np.newaxis, cells]
    strays = STRAY_WEIGHT[:, np.newaxis, np.newaxis] * STRAY_WEIGHT[:, np.newaxis]
    expected = expected.reshape(mean.size, -1)
    log_weights = _log_likelihood(expected, mean, weight) + np.log((strays * prior[cells]).ravel())
    weights = np.exp(log_weights - log_weights.max(axis=1, keepdims=True))
    weights /= weights.sum(axis=1, keepdims=True)
    weights *= _weight_of_dispersion(weights @ expected.T, mean, weight)[:, np.newaxis]
    return cells, weights.reshape(AMONG.size, -1, cells.size).sum(axis=1)


def _log_likelihood(expected: np.ndarray, mean: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Weighted log likelihood (A, K) of means (P,) where a share (P, K) is expected."""
    return (weight * mean) @ np.log(expected) + (weight * (1 - mean)) @ np.log1p(-expected)


def _weight_of_dispersion(expected: np.ndarray, mean: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Weight of each dispersion among places, by Pearson's residuals of the curve that it gives.

    Places on a plateau say nothing of it: they count by their binomial variance.
    """
    variance = expected * (1 - expected)
    tells = 4 * variance
    free = np.maximum(1 - 1 / tells.sum(axis=1, keepdims=True), 0)
    residual = (mean - expected) ** 2 / variance * weight
    fit = -0.5 * np.sum(tells * (residual - free * np.log(weight)), axis=1)
    weights = np.exp(fit - fit.max()) * AMONG_WEIGHT
    return weights / weights.sum()


# --- rises ----------------------------------------------------------------------------------------


def rise(noise: npt.ArrayLike, disorder: npt.ArrayLike) -> dict[str, Estimate]:
    """The rise of r along sigma, of one run or several at each noise.

    Runs are drawn anew at each place by itself, since those of two places are independent.
    """
    noise, disorder = _in_order(noise, disorder, MINIMUM_PLACES)
    best = find_rise(noise, disorder)
    places, count = np.unique(noise, return_counts=True)
    if count.max() == 1:
        return {
            name: estimates.single(value) if np.isfinite(value) else estimates.absent(1)
            for name, value in best.items()
        }
    least = int(count.min())
    require(least >= LEAST_RUNS, f"{least} runs at a point, {LEAST_RUNS} are needed")
    redrawn = _redrawn(noise, np.random.default_rng(0))
    samples = [find_rise(noise, disorder[drawn]) for drawn in redrawn]
    numbers, spacing = {}, _spacing(places, best)
    for name, value in best.items():
        values = np.array([sample[name] for sample in samples])
        off = ON_THE_GRID.get(name, 0.0) * spacing
        numbers[name] = estimates.from_resamples(value, values, least, grid_spacing=off)
    return numbers


def find_rise(noise: npt.ArrayLike, disorder: npt.ArrayLike) -> dict[str, float]:
    """Where r(sigma) at fixed u rises from a low to a high plateau: `QUANTITIES`.

    Criterion. (1) A step with two levels is fitted by least absolute deviations; the levels r_low
    and r_high are the medians on its two sides. (2) critical is where the isotonic regression of
    r(sigma) (the monotone curve of least squares) passes half way, lower and upper where it passes
    10 % and 90 % of the rise (linear between grid points). There is no transition, and all but the
    levels NaN, when r_high < MINIMUM_RISE * r_low.
    """
    noise, disorder = _in_order(noise, disorder, MINIMUM_PLACES)
    places, place = np.unique(noise, return_inverse=True)
    middle = best_step(noise, disorder, falling=False)
    numbers = dict.fromkeys(QUANTITIES, np.nan)
    if not np.isfinite(middle):
        return numbers
    r_low, r_high = np.median(disorder[noise < middle]), np.median(disorder[noise > middle])
    numbers |= {"r_high": float(r_high), "r_low": float(r_low), "contrast": float(r_high / r_low)}
    if not r_high >= MINIMUM_RISE * r_low:
        return numbers
    count = np.bincount(place)
    means = np.bincount(place, disorder) / count
    curve = scipy.optimize.isotonic_regression(means, weights=count).x
    share = (curve - r_low) / (r_high - r_low)
    lower, critical, upper = (_first_passage(places, share, level) for level in (0.1, 0.5, 0.9))
    return numbers | {"critical": critical, "lower": lower, "upper": upper, "width": upper - lower}


def _first_passage(places: np.ndarray, share: np.ndarray, level: float) -> float:
    """Where a rising curve first reaches a level; its end if it does not."""
    index = int(np.searchsorted(share, level))
    ends = slice(max(index - 1, 0), index + 1)
    return float(np.interp(level, share[ends], places[ends]))


def _spacing(places: np.ndarray, transition: dict[str, float]) -> float:
    """Median distance of the points in and next to the transition."""
    if not np.isfinite(transition["critical"]):
        return 0.0
    first = max(int(np.searchsorted(places, transition["lower"])) - 1, 0)
    last = int(np.searchsorted(places, transition["upper"], side="right")) + 1
    return float(np.median(np.diff(places[first:last])))


# --- steps ----------------------------------------------------------------------------------------


def contrast_of_step(belt_velocity: npt.ArrayLike, disorder: npt.ArrayLike) -> float:
    """High over low level of r(u) beside its best falling step; NaN without one.

    The levels are medians between half the position of the step and it, and up to twice it.
    """
    u, r = _in_order(belt_velocity, disorder, MINIMUM_POINTS)
    place = best_step(u, r, falling=True)
    before, after = r[(u <= place) & (u >= place / 2)], r[(u >= place) & (u <= 2 * place)]
    if not before.size or not after.size:  # r falls nowhere, or far from all points
        return np.nan
    return float(np.median(before) / np.median(after))


def best_step(abscissa: np.ndarray, ordinate: np.ndarray, *, falling: bool) -> float:
    """Position of the two-level step of least absolute deviations, midway between points."""
    places = np.unique(abscissa)
    positions = (places[1:] + places[:-1]) / 2
    before = abscissa < positions[:, np.newaxis]
    first, last = _medians(ordinate, before), _medians(ordinate, ~before)
    levels = np.where(before, first[:, np.newaxis], last[:, np.newaxis])
    cost = np.abs(ordinate - levels).sum(axis=1)
    cost[(first > last) != falling] = np.inf
    if not np.isfinite(cost.min()):
        return np.nan
    as_good = cost <= cost.min() * (1 + 1e-9)  # a tie is not left to the rounding of the sums
    return float(positions[np.argmax(as_good)])


def _medians(values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Median of the values that each row of the mask (M, P) chooses, at least one."""
    in_order = np.sort(np.where(chosen, values, np.inf), axis=1)
    row, count = np.arange(len(chosen)), np.count_nonzero(chosen, axis=1)
    return (in_order[row, (count - 1) // 2] + in_order[row, count // 2]) / 2


def _in_order(
    abscissa: npt.ArrayLike, ordinate: npt.ArrayLike, minimum: int
) -> tuple[np.ndarray, np.ndarray]:
    """The finite points along a curve, at so many places at least."""
    pairs = np.array([abscissa, ordinate], dtype=float)
    pairs = pairs[:, np.isfinite(pairs).all(axis=0)]
    x, y = pairs[:, np.argsort(pairs[0], kind="stable")]
    places = np.unique(x).size
    require(places >= minimum, f"{places} points along the curve, {minimum} are needed")
    return x, y
