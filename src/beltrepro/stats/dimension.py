"""Correlation dimension of section points: a number for the "low-dimensional" of Fig. 10."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require

MINIMUM_POINTS = 500


class Dimension(NamedTuple):
    """Correlation dimension of a set of points."""

    dimension: float  # slope of log C against log R
    error: float  # of the slope, and half of what it changes from the lower radii to the upper


def correlation_dimension(
    points: npt.ArrayLike,
    *,
    window: tuple[float, float] = (1e-4, 1e-2),
    n_radii: int = 24,
    max_points: int = 20_000,
    minimum_pairs: int = 100,
) -> Dimension:
    """Slope of log C(R) against log R (Grassberger and Procaccia 1983), by a k-d tree.

    C(R) is the share of pairs closer than R (Euclidean). It is read where it lies within `window`,
    raised at the lower end so that at least `minimum_pairs` pairs are counted. At smaller radii C
    depends on single pairs, at larger ones on the size of the set.
    """
    points = np.asarray(points, dtype=float)
    points = points[np.isfinite(points).all(axis=1)]
    require(len(points) >= MINIMUM_POINTS, f"{len(points)} points, {MINIMUM_POINTS} are needed")
    if len(points) > max_points:
        points = points[np.linspace(0, len(points) - 1, max_points).astype(int)]
    n_pairs = len(points) * (len(points) - 1) / 2
    lowest = max(window[0], minimum_pairs / n_pairs)
    low, high = _radii(points, (lowest, window[1]))
    require(0 < low < high, "the correlation integral has no window to fit: points in few places")
    tree = scipy.spatial.cKDTree(points)
    radius = np.geomspace(low, high, n_radii)
    share = _correlation(tree, radius, n_pairs)
    logs = np.log(radius), np.log(share)
    slope, slope_error = _slope(*logs)
    half = n_radii // 2
    lower, _ = _slope(logs[0][:half], logs[1][:half])
    upper, _ = _slope(logs[0][half:], logs[1][half:])
    return Dimension(slope, float(np.hypot(slope_error, (upper - lower) / 2)))


def _radii(points: np.ndarray, shares: tuple[float, float], n_samples: int = 400_000) -> np.ndarray:
    """Radii at which C has the given values, about: quantiles of the distances of random pairs."""
    first, second = np.random.default_rng(0).integers(0, len(points), (2, n_samples))
    distances = np.linalg.norm(points[first] - points[second], axis=1)[first != second]
    return np.quantile(distances, shares)


def _correlation(tree: scipy.spatial.cKDTree, radius: np.ndarray, n_pairs: float) -> np.ndarray:
    ordered_pairs_and_selves = tree.count_neighbors(tree, radius)
    return (ordered_pairs_and_selves - tree.n) / 2 / n_pairs


def _slope(abscissa: np.ndarray, ordinate: np.ndarray) -> tuple[float, float]:
    coefficients, covariance = np.polyfit(abscissa, ordinate, 1, cov=True)
    return float(coefficients[0]), float(np.sqrt(covariance[0, 0]))
