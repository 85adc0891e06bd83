"""Cuts through scans, and what crossings of a section say (Figs. 10, 12, 14 and 22)."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require

# Velocities at the section repeat to this much on a periodic orbit: the paper's scheme locates
# crossings and sticks to one step, in which v changes by up to F_st*dt ~ 0.07 (model units), and
# the orbit passes on such errors enlarged, in proportion to its size.
PERIOD_TOLERANCE = 0.1
RELATIVE_TOLERANCE = 0.02
# Quasi-periodic motion comes back to within the tolerance too, after some 100 crossings.
MAXIMUM_PERIOD = 40
# Share of the extent of the states: an orbit of the paper's scheme comes back to less, and chaotic
# motion of some thousand crossings hardly ever as near.
NEAR = 0.005
MINIMUM_CROSSINGS = 12


def cut(scan: Any, **where: float) -> dict[str, np.ndarray]:
    """The points of a scan where quantities have these values.

    A row (n_blocks, noise) is in order of u, a column (n_blocks, belt_velocity) in order of noise.
    """
    arrays = getattr(scan, "arrays", scan)
    same = [np.isclose(arrays[name], value, rtol=1e-9, atol=1e-9) for name, value in where.items()]
    there = np.all(same, axis=0)
    of_points = {name: array for name, array in arrays.items() if len(array) == there.size}
    chosen = select(of_points, there)
    order = "noise" if "belt_velocity" in where else "belt_velocity"
    keys = [chosen[name] for name in ("replicate", order) if name in chosen]
    return select(chosen, np.lexsort(keys))


def select(points: Mapping[str, np.ndarray], chosen: np.ndarray) -> dict[str, np.ndarray]:
    """Some of the points of a row or column, by a mask or in an order."""
    return {name: values[chosen] for name, values in points.items()}


class Spread(NamedTuple):
    """Replicates at each place along an axis."""

    place: np.ndarray  # distinct places, rising; unit of the axis
    low: np.ndarray  # the least value
    median: np.ndarray
    high: np.ndarray  # the greatest
    mean: np.ndarray
    tenth: np.ndarray  # below it lie 10 % of the values
    ninetieth: np.ndarray


def spread(abscissa: npt.ArrayLike, values: npt.ArrayLike) -> Spread:
    """What the replicates at each place have in common, and how far they spread."""
    abscissa, values = (np.asarray(array, dtype=float) for array in (abscissa, values))
    is_number = np.isfinite(values)
    places = np.unique(abscissa[is_number])
    runs_at = [values[is_number & (abscissa == place)] for place in places]
    numbers = [
        (np.min(runs), np.median(runs), np.max(runs), np.mean(runs), *np.quantile(runs, (0.1, 0.9)))
        for runs in runs_at
    ]
    return Spread(places, *np.reshape(numbers, (-1, 6)).T)


def density_at(
    abscissa: npt.ArrayLike, counts: npt.ArrayLike, edges: npt.ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Distinct places along an axis (U,) and the density (B, U) at each, of all that is counted.

    counts : (P, B), a row at each `abscissa` (P,); edges : (B+1,), of the bins. NaN of nothing.
    """
    places, place = np.unique(abscissa, return_inverse=True)
    together = np.zeros((places.size, np.shape(counts)[1]))
    np.add.at(together, place, counts)
    with np.errstate(invalid="ignore"):
        return places, (together / together.sum(axis=1, keepdims=True) / np.diff(edges)).T


# --- velocities at the section -----------------------------------------------------------------


def find_period(values: npt.ArrayLike) -> int:
    """Period of a sequence, in crossings: the smallest p with |v[i+p] - v[i]| within a tolerance.

    The condition must hold for every i, and the sequence must be seen at least three times over,
    so periods up to a third of its length, and at most MAXIMUM_PERIOD, can be found; 0 if none is.
    """
    values = _crossings(values)
    tolerance = max(PERIOD_TOLERANCE, RELATIVE_TOLERANCE * float(np.ptp(values)))
    for period in range(1, min(values.size // 3, MAXIMUM_PERIOD) + 1):
        if np.max(np.abs(values[period:] - values[:-period])) <= tolerance:
            return period
    return 0


def repeated(states: npt.ArrayLike) -> np.ndarray:
    """Which states at a section lie near one that is listed before: they say nothing new.

    A run comes back to its states on a periodic orbit, and runs that have not parted yet visit the
    same ones. The states that are new are further than a limit from each other.
    """
    states = np.asarray(states, dtype=float)
    again = np.zeros(len(states), dtype=bool)
    if len(states):
        limit = NEAR * float(np.ptp(states, axis=0).max())
        tree = scipy.spatial.cKDTree(states)
        # A few at once: all pairs of an orbit passed ten thousand times would fill the memory.
        for first in range(0, len(states), 16):
            rows = first + np.flatnonzero(~again[first : first + 16])
            for row, near_it in zip(rows, tree.query_ball_point(states[rows], limit), strict=True):
                if not again[row] and len(near_it) > 1:
                    again[[other for other in near_it if other > row]] = True
    return again


def occupied_bins(counts: npt.ArrayLike, *, least: int = MINIMUM_CROSSINGS) -> np.ndarray:
    """Fewest bins that hold 90 % of the crossings in each row (P, B); NaN for fewer than `least`.

    A measure of how a band diagram is filled that also serves with noise: a periodic orbit fills
    few bins, noise widens its lines, a chaotic band fills a good part of the range.
    """
    held = np.cumsum(np.sort(np.asarray(counts, dtype=float))[:, ::-1], axis=1)
    bins = 1.0 + np.sum(held < 0.9 * held[:, -1:], axis=1)
    return np.where(held[:, -1] >= least, bins, np.nan)


def zero_one_test(values: npt.ArrayLike) -> float:
    """0-1 test for chaos (Gottwald and Melbourne 2009): K near 1 for chaos, 0 for regular motion.

    The values drive a walk in the plane for each of 60 random frequencies; K is the
    median correlation of its mean-square displacement, oscillating term removed, with time.
    """
    values = _crossings(values)
    require(values.size >= 50, f"{values.size} crossings, the 0-1 test needs 50")
    values = values - values.mean()
    if np.std(values) == 0:
        return 0.0
    frequencies = np.random.default_rng(0).uniform(np.pi / 5, 4 * np.pi / 5, 60)
    phase = np.exp(1j * np.outer(frequencies, np.arange(1, values.size + 1)))
    walk = np.cumsum(values * phase, axis=1)
    lags = np.arange(1, values.size // 10 + 1)
    span = values.size - lags[-1]
    ways = (walk[:, lag : lag + span] - walk[:, :span] for lag in lags)
    displacement = np.stack([np.mean(np.abs(way) ** 2, axis=1) for way in ways], axis=1)
    # The bounded oscillating term of the displacement is proportional to the mean: removed above.
    correlations = [np.corrcoef(lags, one)[0, 1] for one in displacement]
    return float(np.median(correlations))


def _crossings(values: npt.ArrayLike) -> np.ndarray:
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    count, least = values.size, MINIMUM_CROSSINGS
    require(count >= least, f"{count} crossings of the section, {least} are needed")
    return values


# --- correlation dimension: a number for the "low-dimensional" of Fig. 10 ------------------------

_LEAST_POINTS = 500
_MOST_POINTS = 20_000  # of which pairs are counted
_LEAST_PAIRS = 100
_WINDOW = (1e-4, 1e-2)  # of C(R)
_RADII = 24
_SAMPLES = 400_000  # pairs that tell at which radii C has given values


def correlation_dimension(points: npt.ArrayLike) -> tuple[float, float]:
    """Slope of log C(R) against log R (Grassberger and Procaccia 1983), and its error.

    C(R) is the share of pairs closer than R (Euclidean). It is read where it lies within a window,
    raised at the lower end so that enough pairs are counted. At smaller radii C depends on single
    pairs, at larger ones on the size of the set. The error is that of the line, and half of what
    the slope changes from the lower radii to the upper.
    """
    points = np.asarray(points, dtype=float)
    points = points[np.isfinite(points).all(axis=1)]
    require(len(points) >= _LEAST_POINTS, f"{len(points)} points, {_LEAST_POINTS} are needed")
    if len(points) > _MOST_POINTS:
        points = points[np.linspace(0, len(points) - 1, _MOST_POINTS).astype(int)]
    n_pairs = len(points) * (len(points) - 1) / 2
    first, second = np.random.default_rng(0).integers(0, len(points), (2, _SAMPLES))
    distances = np.linalg.norm(points[first] - points[second], axis=1)[first != second]
    low, high = np.quantile(distances, (max(_WINDOW[0], _LEAST_PAIRS / n_pairs), _WINDOW[1]))
    require(0 < low < high, "the correlation integral has no window to fit: points in few places")
    tree, radius = scipy.spatial.cKDTree(points), np.geomspace(low, high, _RADII)
    ordered_pairs_and_selves = tree.count_neighbors(tree, radius)
    x, y = np.log(radius), np.log((ordered_pairs_and_selves - tree.n) / 2 / n_pairs)
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    half = _RADII // 2
    lower, upper = np.polyfit(x[:half], y[:half], 1)[0], np.polyfit(x[half:], y[half:], 1)[0]
    return float(slope), float(np.hypot(covariance[0, 0] ** 0.5, (upper - lower) / 2))
