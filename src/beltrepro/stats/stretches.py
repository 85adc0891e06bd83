"""The error of a number of one recording, from stretches of it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.stats.estimates import CONFIDENCE, Estimate

# Few enough that most of what lasts fits into one, enough for Student's t.
STRETCHES = 16


def moments(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sums (K, 3) of weights, of values and of their squares, in stretches of equal weight."""
    share = (np.cumsum(weights) - weights / 2) / weights.sum()
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
    alike = max(0.0, float((excess[1:] * excess[:-1]).sum()) / squares) if squares else 0.0
    independent = count * (1 - alike) / (1 + alike)
    if independent < 2:
        return Estimate(value, math.nan, math.nan, 1)
    error = math.sqrt(squares / (count - 1) / independent)
    reach = float(scipy.stats.t.ppf((1 + CONFIDENCE) / 2, independent - 1)) * error
    return Estimate(value, value - reach, value + reach, int(independent))
