"""Where r falls with u, of single runs, or rises with noise (Figs. 12 to 15, 19 and 21).

`fall` and `rise` are the numbers: estimates with intervals, runs as units. `find_fall` and
`find_rise` find a transition in one set of points. Falls of several runs at each u: `branches`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate

MINIMUM_POINTS = 8
MINIMUM_CONTRAST = 2.0
MINIMUM_RISE = 1.3
LEAST_RUNS = 4
# How often the plateaus are read off anew, beside the region that was found. Beside the step alone
# a wide fall is a part of its own plateaus: of made-up falls from u = 12 to 21 no interval covered
# the middle, with four rounds 95 % do.
ROUNDS = 4
# The window in u of the running median: a single run scatters too much to tell an edge.
SINGLE_RUNS_WINDOW = 3.0
QUANTITIES = ("critical", "lower", "upper", "width", "r_high", "r_low", "contrast")
# How far a number may be off by the grid alone, in spacings: a jump between two points has its
# edges anywhere between them.
ON_THE_GRID = {"critical": 1.0, "lower": 2.0, "upper": 2.0, "width": 2.0}


@dataclass(frozen=True)
class Transition:
    """A fall or rise of r between two plateaus, along u or sigma.

    The edges and `critical` are NaN when the plateaus are too alike for a transition.
    """

    lower: float  # lower edge of the transition region
    upper: float  # upper edge of the transition region
    critical: float  # the point that stands for the region
    r_high: float  # median of the high plateau
    r_low: float  # median of the low plateau

    @property
    def exists(self) -> bool:
        """Whether there is a transition."""
        return bool(np.isfinite(self.critical))

    @property
    def width(self) -> float:
        """Width of the transition region."""
        return self.upper - self.lower

    @property
    def contrast(self) -> float:
        """Ratio of the plateaus."""
        return self.r_high / self.r_low


# --- estimates ------------------------------------------------------------------------------------


def fall(belt_velocity: npt.ArrayLike, disorder: npt.ArrayLike) -> dict[str, Estimate]:
    """The fall of r along u, of one run at each u: edges, midpoint, width, plateaus, their ratio.

    The numbers alone are known (`estimates.single`), through a running median over
    SINGLE_RUNS_WINDOW. Of several runs at each u: `branches.fall`.
    """
    best = find_fall(belt_velocity, disorder, window=SINGLE_RUNS_WINDOW)
    return {name: _single(getattr(best, name)) for name in QUANTITIES}


def rise(noise: npt.ArrayLike, disorder: npt.ArrayLike) -> dict[str, Estimate]:
    """The rise of r along sigma, of one run or several at each noise.

    Runs are drawn anew at each place by itself, since those of two places are independent.
    """
    noise, disorder = in_order(noise, disorder)
    best = find_rise(noise, disorder)
    distinct, first, count = np.unique(noise, return_index=True, return_counts=True)
    if count.max() == 1:
        return {name: _single(getattr(best, name)) for name in QUANTITIES}
    least = int(count.min())
    require(least >= LEAST_RUNS, f"{least} runs at a point, {LEAST_RUNS} are needed")
    rng = np.random.default_rng(0)
    begin, size = np.repeat(first, count), np.repeat(count, count)
    samples = [
        find_rise(noise, disorder[begin + (rng.random(noise.size) * size).astype(int)])
        for _ in range(estimates.RESAMPLES)
    ]
    spacing = _spacing(distinct, best)
    return {
        name: estimates.from_resamples(
            float(getattr(best, name)),
            np.array([getattr(sample, name) for sample in samples], dtype=float),
            least,
            grid_spacing=ON_THE_GRID.get(name, 0.0) * spacing,
        )
        for name in QUANTITIES
    }


def _single(value: float) -> Estimate:
    return estimates.single(value) if np.isfinite(value) else estimates.absent(1)


def _spacing(places: np.ndarray, transition: Transition) -> float:
    """Median distance of the points in and next to the transition."""
    if not transition.exists:
        return 0.0
    first = max(int(np.searchsorted(places, transition.lower)) - 1, 0)
    last = int(np.searchsorted(places, transition.upper, side="right")) + 1
    return float(np.median(np.diff(places[first:last])))


# --- finders --------------------------------------------------------------------------------------


def find_fall(
    belt_velocity: npt.ArrayLike,
    disorder: npt.ArrayLike,
    *,
    window: float = 0.0,
    rounds: int = ROUNDS,
) -> Transition:
    """Where r(u) falls from its high to its low plateau.

    Criterion. (1) A step with two levels is fitted to r(u) by least absolute deviations: outliers
    (periodic windows, attractors of large amplitude) do not move it. (2) r_high is the median of r
    between half the position of the step and the step, r_low that between the step and twice its
    position. (3) In the median of r over a window in u around each point, `lower` is the last u up
    to which r keeps 90 % of the fall, `upper` the first u after that where it is down to 10 %
    (interpolated). (4) Steps 2 and 3 are repeated with these edges in place of the step, `rounds`
    times. (5) critical is the midpoint, as for the paper's u_c. There is no transition when
    r_high < MINIMUM_CONTRAST * r_low.
    """
    velocity, disorder = in_order(belt_velocity, disorder)
    _require_points(velocity, MINIMUM_POINTS)
    place = step(velocity, disorder, falling=True)
    transition = _between_plateaus(velocity, disorder, place, place, window)
    for _ in range(rounds):
        if not transition.exists:
            break
        edges = transition.lower, transition.upper
        transition = _between_plateaus(velocity, disorder, *edges, window)
    return transition


def _between_plateaus(
    velocity: np.ndarray,
    disorder: np.ndarray,
    lower: float,
    upper: float,
    window: float,
) -> Transition:
    """The fall between the plateaus below and above these edges."""
    before = (velocity <= lower) & (velocity >= lower / 2)
    after = (velocity >= upper) & (velocity <= 2 * upper)
    if not before.any() or not after.any():
        return _absent(np.nan, np.nan)
    r_high, r_low = np.median(disorder[before]), np.median(disorder[after])
    if not r_high >= MINIMUM_CONTRAST * r_low:
        return _absent(r_high, r_low)
    places, smooth = running_median(velocity, disorder, window)
    share = (smooth - r_low) / (r_high - r_low)
    above = np.flatnonzero((share >= 0.9) & (places <= upper))
    if not above.size:
        return _absent(r_high, r_low)
    below = np.flatnonzero((share <= 0.1) & (places > places[above[-1]]))
    if not below.size:
        return _absent(r_high, r_low)
    lower = _crossing(places, share, above[-1], 0.9)
    upper = _crossing(places, share, below[0] - 1, 0.1)
    return Transition(lower, upper, (lower + upper) / 2, r_high, r_low)


def find_rise(noise: npt.ArrayLike, disorder: npt.ArrayLike) -> Transition:
    """Where r(sigma) at fixed u rises from a low to a high plateau.

    Criterion. (1) A step with two levels is fitted by least absolute deviations; the levels r_low
    and r_high are the medians on its two sides. (2) critical is where the isotonic regression of
    r(sigma) (the monotone curve of least squares) passes half way, lower and upper where it passes
    10 % and 90 % of the rise (linear between grid points). There is no transition when
    r_high < MINIMUM_RISE * r_low.
    """
    noise, disorder = in_order(noise, disorder)
    _require_points(noise, 5)
    middle = step(noise, disorder, falling=False)
    if not np.isfinite(middle):
        return _absent(np.nan, np.nan)
    r_low, r_high = np.median(disorder[noise < middle]), np.median(disorder[noise > middle])
    if not r_high >= MINIMUM_RISE * r_low:
        return _absent(r_high, r_low)
    places, place = np.unique(noise, return_inverse=True)
    count = np.bincount(place)
    curve = scipy.optimize.isotonic_regression(
        np.bincount(place, disorder) / count, weights=count
    ).x
    share = (curve - r_low) / (r_high - r_low)
    lower, critical, upper = (_first_passage(places, share, level) for level in (0.1, 0.5, 0.9))
    return Transition(lower, upper, critical, r_high, r_low)


def running_median(
    abscissa: np.ndarray, ordinate: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Median of the ordinate over points within width/2 of each distinct abscissa."""
    places = np.unique(abscissa)
    near = np.abs(abscissa - places[:, np.newaxis]) <= width / 2 + 1e-9
    return places, _medians(ordinate, near)


def step(abscissa: np.ndarray, ordinate: np.ndarray, *, falling: bool) -> float:
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


def _crossing(places: np.ndarray, share: np.ndarray, index: int, level: float) -> float:
    """Where the curve passes `level` between places[index] and the next one."""
    if index + 1 >= places.size or share[index] == share[index + 1]:
        return float(places[index])
    part = (share[index] - level) / (share[index] - share[index + 1])
    return float(places[index] + np.clip(part, 0, 1) * (places[index + 1] - places[index]))


def _first_passage(places: np.ndarray, share: np.ndarray, level: float) -> float:
    index = int(np.argmax(share >= level))
    if share[index] < level:
        return float(places[-1])
    if index == 0:
        return float(places[0])
    return _crossing(places, share, index - 1, level)


def _absent(r_high: float, r_low: float) -> Transition:
    return Transition(np.nan, np.nan, np.nan, r_high, r_low)


def in_order(abscissa: npt.ArrayLike, ordinate: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    abscissa, ordinate = (np.asarray(values, dtype=float) for values in (abscissa, ordinate))
    finite = np.isfinite(abscissa) & np.isfinite(ordinate)
    order = np.argsort(abscissa[finite], kind="stable")
    return abscissa[finite][order], ordinate[finite][order]


def _require_points(abscissa: np.ndarray, minimum: int) -> None:
    places = np.unique(abscissa).size
    require(places >= minimum, f"{places} points along the curve, {minimum} are needed")
