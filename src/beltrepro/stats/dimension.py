"""Correlation dimension of section points: a number for the "low-dimensional" of Fig. 10."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require

MINIMUM_POINTS = 500
MOST_POINTS = 20_000  # of which pairs are counted
LEAST_PAIRS = 100
_WINDOW = (1e-4, 1e-2)  # of C(R)
_RADII = 24
_SAMPLES = 400_000  # pairs that tell at which radii C has given values


class Dimension(NamedTuple):
    """Correlation dimension of a set of points."""

    dimension: float  # slope of log C against log R
    error: float  # of the slope, and half of what it changes from the lower radii to the upper


def correlation_dimension(points: npt.ArrayLike) -> Dimension:
    """Slope of log C(R) against log R (Grassberger and Procaccia 1983), by a k-d tree.

    C(R) is the share of pairs closer than R (Euclidean). It is read where it lies within a window,
    raised at the lower end so that enough pairs are counted. At smaller radii C depends on single
    pairs, at larger ones on the size of the set.
    """
    points = np.asarray(points, dtype=float)
    points = points[np.isfinite(points).all(axis=1)]
    require(len(points) >= MINIMUM_POINTS, f"{len(points)} points, {MINIMUM_POINTS} are needed")
    if len(points) > MOST_POINTS:
        points = points[np.linspace(0, len(points) - 1, MOST_POINTS).astype(int)]
    n_pairs = len(points) * (len(points) - 1) / 2
    first, second = np.random.default_rng(0).integers(0, len(points), (2, _SAMPLES))
    distances = np.linalg.norm(points[first] - points[second], axis=1)[first != second]
    low, high = np.quantile(distances, (max(_WINDOW[0], LEAST_PAIRS / n_pairs), _WINDOW[1]))
    require(0 < low < high, "the correlation integral has no window to fit: points in few places")
    tree, radius = scipy.spatial.cKDTree(points), np.geomspace(low, high, _RADII)
    ordered_pairs_and_selves = tree.count_neighbors(tree, radius)
    x, y = np.log(radius), np.log((ordered_pairs_and_selves - tree.n) / 2 / n_pairs)
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    half = _RADII // 2
    lower, upper = np.polyfit(x[:half], y[:half], 1)[0], np.polyfit(x[half:], y[half:], 1)[0]
    return Dimension(float(slope), float(np.hypot(covariance[0, 0] ** 0.5, (upper - lower) / 2)))
