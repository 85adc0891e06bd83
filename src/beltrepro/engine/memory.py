"""Arrays for vector code."""

import math

import numpy as np

_LINE = 64  # bytes of a cache line and of a vector of eight doubles


def zeros(shape, dtype=np.float64) -> np.ndarray:
    """np.zeros that starts on a cache line, so that no vector lies across two of them."""
    shape = (shape,) if isinstance(shape, int) else tuple(shape)
    size = math.prod(shape) * np.dtype(dtype).itemsize
    buffer = np.zeros(size + _LINE, dtype=np.uint8)
    start = -buffer.ctypes.data % _LINE
    return buffer[start : start + size].view(dtype).reshape(shape)


def aligned(values) -> np.ndarray:
    """A copy of an array that starts on a cache line."""
    values = np.asarray(values)
    copy = zeros(values.shape, values.dtype)
    copy[...] = values
    return copy
