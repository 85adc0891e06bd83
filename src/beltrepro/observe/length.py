"""Moments of the chain length x_N: mean length and disorder parameter r (Eq. 4)."""

import numpy as np

from beltrepro.engine.integrator import Chunk
from beltrepro.engine.simd import select
from beltrepro.engine.vector import kernel, separate_arrays


def _samples(chunk: Chunk, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Samples of a chunk from an instant on: times (S,), displacements of last blocks (S, W)."""
    first = np.searchsorted(chunk.time, start)
    return chunk.time[first:], np.ascontiguousarray(chunk.displacement[first:, -1])


class LengthMoments:
    """Mean, standard deviation and range of x_N over the samples it is shown."""

    def __init__(self, width: int, start: float = 0.0) -> None:
        self.start = start
        self.count = 0
        self._mean = np.zeros(width)
        self._squares = np.zeros(width)
        self._low = np.full(width, np.inf)
        self._high = np.full(width, -np.inf)

    def observe(self, chunk: Chunk) -> None:
        # merging moments, Chan et al. 1983
        _, values = _samples(chunk, self.start)
        if len(values):
            self.count += len(values)
            moments = self._mean, self._squares, self._low, self._high
            _add_moments(values, self.count, np.zeros_like(self._mean), *moments)

    def result(self, rest_length: float) -> dict[str, np.ndarray]:
        """Moments (W,) of the chain length in the laboratory frame; NaN without samples."""
        rest = rest_length if self.count else np.nan
        mean = self._mean + rest
        return {
            "mean_length": mean,
            "disorder_parameter": np.sqrt(self._squares / max(1, self.count)) / mean,
            "minimum_length": self._low + rest,
            "maximum_length": self._high + rest,
        }


@kernel
def _add_moments(values, count, shift, mean, squares, low, high):
    """Add samples (S, W), of which there are `count` in total now, to the moments (W,).

    Each chain in one fixed order: NumPy sums in an order that depends on the number of chains.
    shift : zeros, in which the change of the means is found.
    """
    separate_arrays()
    rows, width = values.shape
    for row in range(rows):
        for lane in range(width):
            value = values[row, lane]
            shift[lane] += value - mean[lane]
            low[lane] = select(value < low[lane], value, low[lane])
            high[lane] = select(value > high[lane], value, high[lane])
    for lane in range(width):
        shift[lane] /= rows
    for row in range(rows):
        for lane in range(width):
            squares[lane] += (values[row, lane] - (mean[lane] + shift[lane])) ** 2
    for lane in range(width):
        squares[lane] += shift[lane] ** 2 * (count - rows) * rows / count
        mean[lane] += shift[lane] * rows / count


class Reach:
    """From where to where the first of the sampled blocks moves, over the samples from `start`."""

    def __init__(self, width: int, start: float) -> None:
        self._start = start
        self.low, self.high = np.full(width, np.inf), np.full(width, -np.inf)

    def observe(self, chunk: Chunk) -> None:
        values = chunk.displacement[np.searchsorted(chunk.time, self._start) :, 0]
        self.low = np.minimum(self.low, values.min(axis=0, initial=np.inf))
        self.high = np.maximum(self.high, values.max(axis=0, initial=-np.inf))


GROWTH = 1.15  # length of a bin over that before it: loading may end anywhere


class LengthHistory:
    """How x_N moves in bins of time from `start` to `end`, each longer than the one before.

    For K bins and W chains: edges (K+1,); count (K,) of samples; mean, squares (about 0), low and
    high (K, W) of the displacement of the last block.
    """

    def __init__(self, width: int, start: float, end: float, first: float = 1.0) -> None:
        number = int(np.log1p((end - start) / first * (GROWTH - 1)) / np.log(GROWTH)) + 1
        powers = GROWTH ** np.arange(number)
        self.edges = np.append(start + first * (powers - 1) / (GROWTH - 1), end)
        self.count = np.zeros(number, dtype=np.int64)
        self.mean, self.squares = np.zeros((number, width)), np.zeros((number, width))
        self.low, self.high = np.full((number, width), np.inf), np.full((number, width), -np.inf)

    def observe(self, chunk: Chunk) -> None:
        time, values = _samples(chunk, self.edges[0])
        bins = np.searchsorted(self.edges[1:-1], time, side="right")
        _add_to_bins(values, bins, self.count, self.mean, self.squares, self.low, self.high)


@kernel
def _add_to_bins(values, bins, count, mean, squares, low, high):
    """Add samples (S, W), each of which is in one of K bins, to what is known of these (K, W)."""
    separate_arrays()
    rows, width = values.shape
    for row in range(rows):
        place = bins[row]
        count[place] += 1
        share = 1.0 / count[place]
        for lane in range(width):
            value = values[row, lane]
            mean[place, lane] += (value - mean[place, lane]) * share
            squares[place, lane] += (value * value - squares[place, lane]) * share
            low[place, lane] = select(value < low[place, lane], value, low[place, lane])
            high[place, lane] = select(value > high[place, lane], value, high[place, lane])
