"""Whether the beginning of a run differs from all that follows: the chain still loads."""

from typing import NamedTuple

import numpy as np

_MATERIAL = 0.01  # of the standard deviation: smaller changes of mean and deviation do not matter


class Moments(NamedTuple):
    """Mean and standard deviation of W runs, with standard errors; each (W,)."""

    mean: np.ndarray
    deviation: np.ndarray
    mean_error: np.ndarray
    deviation_error: np.ndarray


class Beginning(NamedTuple):
    """The beginning of each of W runs; each (W,)."""

    length: np.ndarray  # 0 where the run is none different at first, infinite if it is to its end
    matters: np.ndarray  # whether mean or deviation change by more than their errors without it
    whole: Moments
    rest: Moments  # without it


def beginning(
    edges: np.ndarray,
    count: np.ndarray,
    mean: np.ndarray,
    squares: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
) -> Beginning:
    """The beginning of runs, from what a number does in K bins of time (K, W).

    A bin belongs to it if its mean is beyond all values that come later, and if all bins before it
    do. What comes back, as in periodic, chaotic and intermittent motion, is no beginning.

    edges (K+1,) : of the bins. count (K,) : of samples. squares : mean of the square.
    """
    kept = count > 0
    starts, count = edges[:-1][kept], count[kept, None]
    mean, squares, low, high = (values[kept] for values in (mean, squares, low, high))
    lowest, highest = (
        function.accumulate(values[::-1])[::-1][1:]
        for function, values in ((np.minimum, low), (np.maximum, high))
    )
    beyond = (mean[:-1] < lowest) | (mean[:-1] > highest)
    bins = np.logical_and.accumulate(beyond).sum(axis=0)
    later = np.arange(len(count))[:, None] >= bins
    whole, rest = (_moments(weight, mean, squares) for weight in (count + 0 * mean, count * later))
    material = _MATERIAL * rest.deviation
    matters = np.abs(rest.mean - whole.mean) > np.maximum(rest.mean_error, material)
    matters |= np.abs(rest.deviation - whole.deviation) > np.maximum(rest.deviation_error, material)
    length = np.where(bins < len(count) - 1, starts[bins] - edges[0], np.inf)
    return Beginning(length, matters & (bins > 0), whole, rest)


def _moments(weight: np.ndarray, mean: np.ndarray, squares: np.ndarray) -> Moments:
    """Moments over bins (K, W) of these weights; errors as if bins were independent."""
    share = weight / weight.sum(axis=0)
    centre = (share * mean).sum(axis=0)
    variances = squares - 2 * centre * mean + centre**2
    variance = np.maximum((share * variances).sum(axis=0), 0.0)
    deviation = np.sqrt(variance)
    mean_error = np.sqrt((share**2 * (mean - centre) ** 2).sum(axis=0))
    variance_error = np.sqrt((share**2 * (variances - variance) ** 2).sum(axis=0))
    return Moments(
        centre, deviation, mean_error, variance_error / np.maximum(2 * deviation, 1e-300)
    )
