"""How much of each pixel lies beyond an edge, exactly, also while the edge moves."""

import numpy as np


def band(low: float, high: float, count: int) -> np.ndarray:
    """Share (count,) of each pixel between two places.

    Pixel j reaches from j to j + 1.
    """
    ends = np.arange(count + 1)
    return np.diff(np.clip(ends, low, max(low, high)))


def step_changes(begin: np.ndarray, end: np.ndarray, heights: np.ndarray, count: int) -> np.ndarray:
    """Changes from pixel to pixel of the sum of steps that move while the shutter is open.

    A step is 0 before its edge and `height` behind it. Pixel j shows its mean from j to j + 1, and
    over all places from `begin` to `end`, which the edge passes at constant velocity. The sum of
    the changes up to pixel j is the brightness there.
    """
    # Few pixels see an edge: those it passes, and one more on either side.
    first = np.floor(np.minimum(begin, end)).astype(int) - 1
    reach = int(np.ceil(np.abs(end - begin).max(initial=0.0))) + 3
    pixels = first[..., np.newaxis] + np.arange(reach)
    seen = _behind(pixels, begin[..., np.newaxis], end[..., np.newaxis])
    changes = np.diff(seen, axis=-1, prepend=0) * heights[:, np.newaxis]
    inside = pixels < count
    frames = len(begin)
    # Frame after frame in one long row of pixels.
    places = np.maximum(pixels, 0) + count * np.arange(frames)[:, np.newaxis, np.newaxis]
    summed = np.bincount(places[inside], changes[inside], minlength=frames * count)
    return summed.reshape(frames, count)


def _behind(pixel: np.ndarray, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Share of a pixel behind an edge, mean over its way."""
    # So short a way leaves digits enough in the difference.
    half = np.maximum(np.abs(end - begin) / 2, 1e-6)
    middle = pixel + 1 - (begin + end) / 2
    return (_integral(middle + half) - _integral(middle - half)) / (2 * half)


def _integral(distance: np.ndarray) -> np.ndarray:
    """Integral from minus infinity of clip(s, 0, 1) over s."""
    inside = np.minimum(np.maximum(distance, 0), 1)
    return inside * (distance - inside / 2)
