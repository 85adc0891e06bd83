"""The belt's direction and the marks of the tape measure, in a picture (H, W) that stands still."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import scipy

STEEPEST = 20.0  # degrees by which the belt may be turned in the picture
_WIDEST = 960  # pixels that are enough to see a direction
# By how much the period of the marks may differ from the one that the white block leads to expect.
_DOUBT = 0.25
# How far the marks must stand out of the other periods of a row for the row to be one of a tape.
_CLEAR = 8.0
_SHARE = 0.3  # of all that varies along the row; of equal marks on a plain tape it is 0.7
# Rows that marks must cover, and as a share of their distance: the steps of a line that lies askew
# on the pixels are as regular, but lower.
_LEAST_ROWS, _HEIGHT = 2, 0.3
_SEEN = 0.4  # contrast of a mark, as a share of that of most marks
_DARKEST = 0.25  # share of the light of the tape below which nothing is seen
_DARKER = 0.6  # share of the brightness of the tape that what lies beyond it does not reach


@dataclass(frozen=True)
class Tape:
    """The marks of a tape measure along the belt."""

    spacing: float  # distance of neighbouring marks, pixels
    first: float  # place along the belt of the first mark in the picture, pixels from its middle
    clearness: float  # strength of the period of the marks, in units of the other periods near it
    begins: bool  # whether the end of the tape before that mark is in the picture


def direction(picture: np.ndarray) -> float:
    """Angle by which the belt is turned in a picture.

    Along the belt lie its own edges and those of the tape, the blocks and the treadmill. When the
    picture is turned so that they lie along its rows, its rows differ most from each other.
    """
    shrink = min(1.0, _WIDEST / max(picture.shape))
    small = cv2.resize(picture.astype(np.float32), None, fx=shrink, fy=shrink)
    small = cv2.GaussianBlur(small, (0, 0), 1.0)
    angles = np.arange(-STEEPEST, STEEPEST + 0.5)
    best = angles[np.argmax([_row_contrast(small, angle) for angle in angles])]
    angles = np.arange(best - 1, best + 1.05, 0.1)
    best = angles[np.argmax([_row_contrast(small, angle) for angle in angles])]
    return _largest(lambda angle: _row_contrast(small, angle), best, 0.1, 0.005)


def straightened(picture: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """The picture, turned about its middle so that the belt lies along its rows."""
    size = picture.shape[::-1]
    matrix = cv2.getRotationMatrix2D(((size[0] - 1) / 2, (size[1] - 1) / 2), angle, 1.0)
    turned = cv2.warpAffine(picture.astype(np.float32), matrix, size)
    weight = cv2.warpAffine(np.ones(picture.shape, np.float32), matrix, size)
    return turned, (weight > 0.999).astype(np.float32)


def find_tape(picture: np.ndarray, angle: float, spacing: float) -> Tape | None:
    """Find the marks of a tape measure that lies along the belt."""
    turned, weight = straightened(picture, angle)
    ripple = _ripple(turned, weight, spacing)
    width = ripple.shape[1]
    frequencies = np.arange((1 - _DOUBT) / spacing, (1 + _DOUBT) / spacing, 0.25 / width)
    if width < 8 * spacing or spacing < 2.2 or frequencies.size < 8:
        return None
    strength = np.abs(_transform(ripple, frequencies))
    clearness = strength.max(axis=1) / (np.median(strength, axis=1) + 1e-3 * strength.max() + 1e-9)
    row = int(np.argmax(clearness * strength.max(axis=1)))
    if clearness[row] < _CLEAR or strength[row].max() < _SHARE * np.abs(ripple[row]).sum():
        return None
    rows = _rows_alike(strength, clearness, row)
    if rows.stop - rows.start < max(_LEAST_ROWS, _HEIGHT * spacing):
        return None
    profile = ripple[rows].mean(axis=0)
    rough = frequencies[np.argmax(strength[row])]
    frequency = _refined(profile, rough)
    shown = weight[rows]
    shape = (turned[rows] * shown).sum(axis=0) / np.maximum(shown.sum(axis=0), 1)
    first, begins = _first_mark(profile, shape, shown.min(axis=0) > 0, frequency)
    return Tape(1 / frequency, first - (width - 1) / 2, float(clearness[row]), begins)


def _row_contrast(picture: np.ndarray, angle: float) -> float:
    """How much neighbouring rows differ when a belt at this angle is straightened."""
    turned, weight = straightened(picture, angle)
    count = weight.sum(axis=1)
    mean = (turned * weight).sum(axis=1) / np.maximum(count, 1)
    pairs = np.minimum(count[1:], count[:-1])
    return float(np.sum(pairs * np.diff(mean) ** 2) / max(pairs.sum(), 1))


def _ripple(turned: np.ndarray, weight: np.ndarray, spacing: float) -> np.ndarray:
    """What varies along a row within a few marks; 0 beyond the picture."""
    shown = turned * weight
    scale = 1.5 * spacing
    level = cv2.GaussianBlur(shown, (0, 0), sigmaX=scale, sigmaY=0.01)
    share = cv2.GaussianBlur(weight, (0, 0), sigmaX=scale, sigmaY=0.01)
    return weight * (shown - level / np.maximum(share, 1e-3))


def _transform(rows: np.ndarray, frequencies: np.ndarray) -> np.ndarray:
    """Fourier transform (..., F) of rows (..., W) at frequencies in cycles per pixel."""
    waves = np.exp(-2j * np.pi * np.outer(np.arange(rows.shape[-1]), frequencies))
    return rows @ waves.astype(np.complex64 if rows.dtype == np.float32 else complex)


def _rows_alike(strength: np.ndarray, clearness: np.ndarray, row: int) -> slice:
    """Rows around the clearest one with as clear a period of the same length."""
    peak = strength.argmax(axis=1)
    alike = (np.abs(peak - peak[row]) <= 4) & (clearness > 0.5 * clearness[row])
    alike &= strength.max(axis=1) > 0.5 * strength[row].max()
    breaks = np.flatnonzero(~alike)
    low = breaks[breaks < row].max(initial=-1) + 1
    high = breaks[breaks > row].min(initial=len(alike))
    return slice(int(low), int(high))


def _refined(profile: np.ndarray, frequency: float) -> float:
    """The frequency near a given one at which the transform is greatest."""
    profile = profile.astype(float)
    step = 0.5 / profile.size

    def strength(cycles: float) -> float:
        return abs(_transform(profile, np.array([cycles]))[0])

    return _largest(strength, frequency, step, 1e-4 * step)


def _largest(function: Callable[[float], float], near: float, reach: float, error: float) -> float:
    """Where a function is largest within reach of a place."""
    best = scipy.optimize.minimize_scalar(
        lambda x: -function(x), bounds=(near - reach, near + reach), options={"xatol": error}
    )
    return float(best.x)


def _first_mark(
    profile: np.ndarray, shape: np.ndarray, shown: np.ndarray, frequency: float
) -> tuple[float, bool]:
    """Place of the first mark, pixels, and whether the end of the tape before it is seen."""
    spacing = 1 / frequency
    once, twice = _transform(profile.astype(float), np.array([frequency, 2 * frequency]))
    # Marks are narrower than what lies between them. So the second harmonic tells dark marks from
    # bright ones; where it cannot be seen, marks are dark.
    bright = (twice * np.conj(once) ** 2).real > 0.05 * abs(once) ** 3
    sign = 1 if bright else -1
    phase = -np.angle(sign * once) / (2 * np.pi) * spacing
    marks = np.arange(phase % spacing, shape.size - spacing, spacing)
    seen = _seen(marks, shape, spacing, sign, middle=_centre(profile))
    # Three marks in a row are a tape; what lies dark between two such parts of it, covers it.
    rows = np.flatnonzero(seen[:-2] & seen[1:-1] & seen[2:])
    inside = marks[rows[0] + 1] if rows.size else _centre(profile)
    end, end_seen = _beginning(shape, shown, spacing, inside)
    # The end of a tape can be its zero: a mark there may lie a little before it.
    possible = seen & (marks >= end - spacing / 4)
    first = float(marks[np.argmax(possible)] if possible.any() else end)
    # A tape hardly brighter than what lies beyond it ends where there is room for marks, but none.
    return first, bool(end_seen or first > np.argmax(shown) + 1.5 * spacing)


def _seen(
    marks: np.ndarray, shape: np.ndarray, spacing: float, sign: int, middle: float
) -> np.ndarray:
    """Which places (M,) differ from what follows them as marks of the tape do."""
    pixels = np.arange(shape.size)
    on, between = (np.interp(marks + shift, pixels, shape) for shift in (0, spacing / 2))
    near = np.argsort(np.abs(marks - middle))[: max(3, marks.size // 2)]
    light = np.maximum(on + between, _DARKEST * np.median((on + between)[near]))
    contrast = sign * (on - between) / light  # whatever the light there
    return contrast > _SEEN * np.median(contrast[near])


def _beginning(
    shape: np.ndarray, shown: np.ndarray, spacing: float, middle: float
) -> tuple[float, bool]:
    """Where the tape begins, pixels, and whether that is seen: it may go on beyond the picture."""
    size = int(np.ceil(spacing)) + 1
    # the marks filled up, or what is between them
    body = scipy.ndimage.grey_closing(shape, size=size)
    ahead = scipy.ndimage.maximum_filter1d(body, 4 * size, origin=-2 * size + 1)
    half = _DARKER * ahead
    before = np.flatnonzero(shown & (body < half) & (np.arange(body.size) < middle))
    if not before.size:
        return float(np.argmax(shown)) + 0.25 * spacing, False
    last = before[-1]
    rise = body[last + 1] - body[last]
    part = np.clip((half[last] - body[last]) / max(rise, 1e-9), 0, 1)
    return float(last + part), True


def _centre(profile: np.ndarray) -> float:
    """Centre of gravity of what varies, pixels."""
    weight = profile.astype(float) ** 2
    return float(np.arange(weight.size) @ weight / weight.sum())
