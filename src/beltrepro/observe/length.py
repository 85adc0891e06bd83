"""Moments of the chain length x_N: mean length and disorder parameter r (Eq. 4)."""

import numpy as np


class LengthMoments:
    """Mean, standard deviation and range of x_N over the samples it is shown.

    width : number of chains W. start : samples before this time are not counted.
    """

    def __init__(self, width: int, start: float = 0.0):
        self._start = start
        self._count = 0
        self._mean = np.zeros(width)
        self._squares = np.zeros(width)
        self._low = np.full(width, np.inf)
        self._high = np.full(width, -np.inf)

    def observe(self, chunk) -> None:
        """Add the samples of a chunk (merging moments, Chan et al. 1983)."""
        values = chunk.displacement[chunk.time >= self._start, -1]
        if not len(values):
            return
        count = len(values)
        mean = values.mean(axis=0)
        squares = ((values - mean) ** 2).sum(axis=0)
        total = self._count + count
        shift = mean - self._mean
        self._mean += shift * count / total
        self._squares += squares + shift**2 * self._count * count / total
        self._count = total
        np.minimum(self._low, values.min(axis=0), out=self._low)
        np.maximum(self._high, values.max(axis=0), out=self._high)

    def result(self, rest_length: float) -> dict[str, np.ndarray]:
        """mean_length, disorder_parameter, minimum_length, maximum_length, each (W,).

        rest_length : rest position of the last block. NaN where nothing was sampled.
        """
        if self._count == 0:
            names = ("mean_length", "disorder_parameter", "minimum_length", "maximum_length")
            return {name: np.full(len(self._mean), np.nan) for name in names}
        mean = self._mean + rest_length
        return {
            "mean_length": mean,
            "disorder_parameter": np.sqrt(self._squares / self._count) / mean,
            "minimum_length": self._low + rest_length,
            "maximum_length": self._high + rest_length,
        }
