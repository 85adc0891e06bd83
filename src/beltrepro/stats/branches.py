"""The fall of r as a passage between two branches, from several runs at each belt velocity.

Near the transition a run ends on a branch of high or of low r; noise lets long runs change between
them. Where each run lies between the branches, y in 0..1, falls with u as

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

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require
from beltrepro.stats import estimates, transitions
from beltrepro.stats.estimates import Estimate

# What the lower end of the contrast must reach: a flat row, parted where that looks best, has less.
MINIMUM_CONTRAST = 1.1
ROUNDS = 4  # how often the plateaus are read off anew, beside the fall that was found
PLATEAU = 4  # places that each plateau should have, and the least that it has is one fewer
# r falls from 90 % to 10 % within so many w on either side of u_c.
EDGE = np.log(9)
CELLS = 4  # of u_c in each gap of the grid
WIDTHS = 14
# Weak priors, chosen by the coverage of the intervals (tests/stats/test_branches.py).
STRAY = np.array([0.003, 0.06, 0.25])
STRAY_WEIGHT = np.array([0.4, 0.25, 0.35])
AMONG = np.array([0.0, 0.08, 0.3, 0.7])
AMONG_WEIGHT = np.array([0.4, 0.3, 0.2, 0.1])
# A smooth fall is no exact logistic function: a run never tells more than this many coin tosses.
LEAST_PHI = 0.25
DROPPED = 8.0  # in log likelihood below the best: such cells are left out
DRAWS = 2000
AS_LIKELY = np.exp(-1.92)  # of the best: what a 95 % interval holds


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
        """The finite runs of a row."""
        u, r = transitions.in_order(belt_velocity, disorder)
        return cls(u, r[np.lexsort((r, u))], *np.unique(u, return_index=True, return_counts=True))

    @property
    def runs(self) -> int:
        """Runs at half of the places, at least: where outliers are left out one may remain."""
        return int(np.median(self.count))

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over the runs at each place."""
        return np.add.reduceat(values, self.first) / self.count


@dataclass(frozen=True)
class Fit:
    """Draws from what the runs leave open of a fall, and its plateaus."""

    critical: np.ndarray  # u_c (DRAWS,)
    scale: np.ndarray  # w
    dispersion: np.ndarray  # variance of the mean of y at a place, over that of coin tosses
    before: np.ndarray  # mask of the runs beside the fall, on its high side
    after: np.ndarray
    on_high: np.ndarray  # of these, the runs on the branch of that side
    on_low: np.ndarray
    may_jump: bool  # a fall sharper than the grid is as good
    may_go_on: bool  # a fall wider than the row is as good


# --- estimates ------------------------------------------------------------------------------------


def fall(belt_velocity: npt.ArrayLike, disorder: npt.ArrayLike) -> dict[str, Estimate]:
    """The fall of r along u: `transitions.QUANTITIES`, and the over-dispersion.

    critical is u_c; lower, upper and width are those of the fall from 90 % to 10 %. Where runs
    cannot tell the end of the fall, upper and width have no upper end. There is no fall, and
    plateaus and contrast alone are known, if the contrast may lie below MINIMUM_CONTRAST. Of one
    run at each u: `transitions.fall`.
    """
    row = Row.of(belt_velocity, disorder)
    if row.count.max(initial=0) == 1:
        return transitions.fall(row.u, row.r)
    fit, runs = _fit(row), row.runs
    nothing = dict.fromkeys((*transitions.QUANTITIES, "dispersion"), estimates.absent(runs))
    if fit is None:
        return nothing
    numbers = _plateau_estimates(row, fit.on_high, fit.on_low)
    # Of all runs: those above the middle are larger than those below in a flat row, too.
    if not _plateau_estimates(row, fit.before, fit.after)["contrast"].low >= MINIMUM_CONTRAST:
        return nothing | numbers
    quantities = {name: _of_draws(draws, runs) for name, draws in _quantities(fit).items()}
    return {
        name: _open_ends(name, quantity, fit) for name, quantity in quantities.items()
    } | numbers


def _quantities(fit: Fit) -> dict[str, np.ndarray]:
    reach = EDGE * fit.scale
    return {
        "critical": fit.critical,
        "lower": fit.critical - reach,
        "upper": fit.critical + reach,
        "width": 2 * reach,
        "dispersion": fit.dispersion,
    }


def _of_draws(draws: np.ndarray, runs: int) -> Estimate:
    tail = (1 - estimates.CONFIDENCE) / 2
    value, low, high = map(float, np.quantile(draws, [0.5, tail, 1 - tail]))
    return Estimate(value, low, high, runs)


def _open_ends(name: str, estimate: Estimate, fit: Fit) -> Estimate:
    low = 0.0 if name == "width" and fit.may_jump else estimate.low
    high = np.inf if name in ("width", "upper") and fit.may_go_on else estimate.high
    return Estimate(estimate.value, low, high, estimate.runs)


def _plateau_estimates(row: Row, high: np.ndarray, low: np.ndarray) -> dict[str, Estimate]:
    """Medians of two masks of runs and their ratio; runs are drawn anew at each place by itself."""
    rng = np.random.default_rng(0)
    samples = {
        name: _median_resamples(row.r[mask], row.u[mask], rng)
        for name, mask in (("r_high", high), ("r_low", low))
    }
    values = {
        name: float(np.median(row.r[mask])) for name, mask in (("r_high", high), ("r_low", low))
    }
    samples["contrast"] = samples["r_high"] / samples["r_low"]
    values["contrast"] = values["r_high"] / values["r_low"]
    return {
        name: estimates.from_resamples(value, samples[name], max(row.runs, 2))
        for name, value in values.items()
    }


def _median_resamples(r: np.ndarray, place: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    _, first, count = np.unique(place, return_index=True, return_counts=True)
    begin, size = np.repeat(first, count), np.repeat(count, count)
    drawn = begin + (rng.random((estimates.RESAMPLES, r.size)) * size).astype(int)
    return np.median(r[drawn], axis=1)


# --- the fit --------------------------------------------------------------------------------------


def _fit(row: Row) -> Fit | None:
    """What runs say of the fall; its plateaus are read off beside it, anew up to `ROUNDS` times.

    None where r falls nowhere.
    """
    least = transitions.MINIMUM_POINTS
    require(
        row.places.size >= least, f"{row.places.size} points along the curve, {least} are needed"
    )
    step = transitions.step(row.u, row.r, falling=True)
    if not np.isfinite(step):
        return None
    near = far = (step, step)
    middle, seen = np.nan, []
    for _ in range(ROUNDS):
        before, after = _beside(row, near, far)
        on_high, on_low = _branches(row, before, after, middle)
        r_high, r_low = np.median(row.r[on_high]), np.median(row.r[on_low])
        if not r_high > r_low:
            return None
        if (r_high, r_low) in seen:
            break
        seen.append((r_high, r_low))
        middle = (r_high + r_low) / 2
        position = (row.r - r_low) / (r_high - r_low)
        phi = _phi(row, position.clip(0, 1))
        posterior = _posterior(row.places, row.mean(position).clip(0, 1), row.count, phi)
        draws = posterior.draw()
        critical, reach = np.median(draws[0]), EDGE * np.median(draws[1])
        near = critical - reach, critical + reach
        # Beside the edges themselves plateaus hold 10 % of a gradual fall, which looks the sharper.
        far = critical - 2 * reach, critical + 2 * reach
    critical, scale, among = draws
    return Fit(
        critical,
        scale,
        phi + np.median(row.count) * among,
        before,
        after,
        on_high,
        on_low,
        bool(posterior.of_scale[0] > AS_LIKELY * posterior.of_scale.max()),
        bool(posterior.of_scale[-1] > AS_LIKELY * posterior.of_scale.max()),
    )


def _beside(
    row: Row, near: tuple[float, float], far: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Masks of the runs from half the lower edge to it, and from the upper edge to twice it.

    The edges are the far ones, or as near as leaves PLATEAU places.
    """
    places = row.places
    lower = max(far[0], min(near[0], places[PLATEAU - 1]), places[PLATEAU - 2])
    upper = min(far[1], max(near[1], places[-PLATEAU]), places[1 - PLATEAU])
    begin = min(lower / 2, places[places <= lower][1 - PLATEAU])
    end = max(2 * upper, places[places >= upper][PLATEAU - 2])
    return (row.u >= begin) & (row.u <= lower), (row.u >= upper) & (row.u <= end)


def _branches(
    row: Row, before: np.ndarray, after: np.ndarray, middle: float
) -> tuple[np.ndarray, np.ndarray]:
    """Of masks beside a fall, the runs on the branch of that side; all until there is a middle."""
    high, low = before & (row.r > middle), after & (row.r < middle)
    return (high if high.any() else before), (low if low.any() else after)


def _phi(row: Row, position: np.ndarray) -> float:
    """Variance among the runs at a place over that of coin tosses; 1 where none tell."""
    mean = row.mean(position)
    squares = row.mean((position - np.repeat(mean, row.count)) ** 2) * row.count
    tells = (row.count > 1) & (mean > 0.05) & (mean < 0.95)
    mean, count = mean[tells], row.count[tells]
    variance = squares[tells] / (count - 1)
    tosses = np.sum(count * mean * (1 - mean) + variance)
    return max(float((0.25 + np.sum(count * variance)) / (0.25 + tosses)), LEAST_PHI)


@dataclass(frozen=True)
class Posterior:
    """Weights of the cells of u_c and w (C, W) for each dispersion among places (A, C, W)."""

    weights: np.ndarray
    centres: np.ndarray  # of the cells of u_c
    lengths: np.ndarray
    log_scale: np.ndarray  # edges of the cells of ln w

    @property
    def of_scale(self) -> np.ndarray:
        """Weight of each w."""
        return self.weights.sum(axis=(0, 1))

    def draw(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """u_c, w and the dispersion among places of DRAWS draws, alike within a cell."""
        rng = np.random.default_rng(0)
        total = np.cumsum(self.weights)
        at = (np.arange(DRAWS) + rng.random(DRAWS)) / DRAWS * total[-1]
        cell = np.minimum(np.searchsorted(total, at), total.size - 1)
        among, place, scale = np.unravel_index(cell, self.weights.shape)
        critical = self.centres[place] + (rng.random(DRAWS) - 0.5) * self.lengths[place]
        step = self.log_scale[1] - self.log_scale[0]
        return critical, np.exp(self.log_scale[scale] + step * rng.random(DRAWS)), AMONG[among]


def _posterior(places: np.ndarray, mean: np.ndarray, count: np.ndarray, phi: float) -> Posterior:
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
    # Most cells are out of the question by the flattest of the likelihoods that stray runs allow.
    rough = _log_likelihood(0.05 + 0.9 * curve, mean, weight[2:3])[0]
    cells = np.flatnonzero(rough > rough.max() - DROPPED)
    beyond, before = STRAY[:, np.newaxis, np.newaxis], STRAY[:, np.newaxis]
    expected = beyond + (1 - beyond - before) * curve[:, np.newaxis, np.newaxis, cells]
    prior = STRAY_WEIGHT[:, np.newaxis, np.newaxis] * STRAY_WEIGHT[:, np.newaxis]
    prior = (prior * lengths[cells // WIDTHS]).ravel()
    expected = expected.reshape(places.size, -1)
    log_weights = _log_likelihood(expected, mean, weight) + np.log(prior)
    weights = np.exp(log_weights - log_weights.max(axis=1, keepdims=True))
    weights /= weights.sum(axis=1, keepdims=True)
    weights *= _weight_of_dispersion(weights @ expected.T, mean, weight)[:, np.newaxis]
    kept = np.zeros((AMONG.size, curve.shape[1]))
    kept[:, cells] = weights.reshape(AMONG.size, -1, cells.size).sum(axis=1)
    return Posterior(kept.reshape(AMONG.size, -1, WIDTHS), centres, lengths, log_scale)


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
