"""The belt's direction and the marks of the tape measure, in a picture (H, W) that stands still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
import scipy

STEEPEST = 20.0  # degrees by which the belt may be turned in the picture
_WIDEST = 960  # pixels that are enough to see a direction
# By how much the period of the marks may differ from the one that the white block leads to expect.
_DOUBT = 0.25
# Bends of a tape that are tried: neighbouring ones differ by a quarter of a mark's distance at the
# ends of 80 marks. The largest is that of a camera tilted by some 7 degrees.
# Bends beside one of them, on the way to the best.
_FINE_BENDS, _FINEST_BEND = 12, 0.005
BENDS = (0.0, 0.025, -0.025, 0.05, -0.05, 0.075, -0.075)
# How far the marks must stand out of the other periods of a row for the row to be one of a tape.
_CLEAR = 8.0
_SHARE = 0.3  # of all that varies along the row; of equal marks on a plain tape it is 0.7
# Rows that marks must cover, and as a share of their distance: the steps of a line that lies askew
# on the pixels are as regular, but lower.
_LEAST_ROWS, _HEIGHT = 2, 0.3
_NEAREST = 2.2  # pixels from mark to mark
_SEEN = 0.4  # contrast of a mark, as a share of that of most marks
# Width of the window in which the place of a mark is taken, standard deviation, in their distances.
_SHARPNESS = 0.8
WIDE_GAP = 8  # marks in a row that may be hidden and are still counted by their distances
# Every tenth mark is longer, or every fifth. By how much more they differ there from what is
# beside them.
_LONGER = 2.0
_DARKEST = 0.25  # share of the light of the tape below which nothing is seen
_DARKER = 0.6  # share of the brightness of the tape that what lies beyond it does not reach


@dataclass(frozen=True, eq=False)
class Tape:
    """The marks of a tape measure along the belt, in a straightened picture."""

    turn: float  # degrees by which the picture was turned to be straight
    rows: slice  # of the straightened picture that show the marks
    line: float  # place of these rows across the belt, pixels from the middle of the picture
    places: np.ndarray  # (M,) of the marks that are seen, along the belt, pixels from the middle
    numbers: np.ndarray  # (M,) of these marks, 0 for the first one in the picture
    spacing: float  # mean distance of neighbouring marks, pixels
    clearness: float  # strength of the period of the marks, in units of the other periods near it
    begins: bool  # whether the end of the tape before the first mark is in the picture
    # number of the first of the longer marks, and from one to the next; None if not seen
    long: tuple[int, int] | None


def direction(picture: np.ndarray) -> float:
    """Angle by which the belt is turned in a picture.

    Along the belt lie its own edges and those of the tape, the blocks and the treadmill. When the
    picture is turned so that they lie along its rows, its rows differ most from each other.
    """
    small = _small(picture)
    _, best = _clearest(small, np.arange(-STEEPEST, STEEPEST + 0.5))
    _, best = _clearest(small, np.arange(best - 1, best + 1.05, 0.1))
    finest = scipy.optimize.minimize_scalar(
        lambda angle: -_row_contrast(small, angle),
        bounds=(best - 0.1, best + 0.1),
        options={"xatol": 0.005},
    )
    return float(finest.x)


def lies_on_its_side(picture: np.ndarray) -> bool:
    """Whether the belt runs from top to bottom."""
    angles = np.arange(-STEEPEST, STEEPEST + 0.5)
    upright, turned = (_clearest(_small(one), angles)[0] for one in (picture, picture.T))
    return upright < turned


def _clearest(small: np.ndarray, angles: np.ndarray) -> tuple[float, float]:
    """The largest contrast of rows at some angles, and the first angle that has it."""
    return max(((_row_contrast(small, angle), angle) for angle in angles), key=lambda pair: pair[0])


def _small(picture: np.ndarray) -> np.ndarray:
    """A picture of no more pixels than are needed to see a direction."""
    shrink = min(1.0, _WIDEST / max(picture.shape))
    small = cv2.resize(picture.astype(np.float32), None, fx=shrink, fy=shrink)
    return cv2.GaussianBlur(small, (0, 0), 1.0)


def straightened(picture: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """The picture, turned about its middle so that the belt lies along its rows."""
    size = picture.shape[::-1]
    matrix = cv2.getRotationMatrix2D(((size[0] - 1) / 2, (size[1] - 1) / 2), angle, 1.0)
    turned = cv2.warpAffine(picture.astype(np.float32), matrix, size)
    weight = cv2.warpAffine(np.ones(picture.shape, np.float32), matrix, size)
    return turned, (weight > 0.999).astype(np.float32)


def find_tape(
    picture: np.ndarray, turn: float, spacing: float, bends: Sequence[float] = (0.0,)
) -> Tape | None:
    """Find the marks of a tape measure that lies along the belt, and number them.

    A camera that is tilted along the belt sees marks nearer to each other at one end. A bend is the
    share by which they are denser at the right edge of the picture than in its middle.
    """
    width = picture.shape[1]
    if not _NEAREST < spacing < width / 8:
        return None
    frequencies = np.arange((1 - _DOUBT) / spacing, (1 + _DOUBT) / spacing, 0.25 / width)
    if frequencies.size < 8:
        return None
    turned, weight = straightened(picture, turn)
    ripple = _ripple(turned, weight, spacing)
    for bend in bends:
        band = _band(ripple, frequencies, bend)
        if band is None:
            continue
        rows, frequency, clearness = band
        profile, shown = ripple[rows].mean(axis=0).astype(float), weight[rows]
        light = (turned[rows] * shown).sum(axis=0) / np.maximum(shown.sum(axis=0), 1)
        comb = _fitted(profile, Comb(frequency, bend))
        places, numbers, begins = _marks(profile, light, shown.min(axis=0) > 0, comb)
        line, spacing = (rows.start + rows.stop - turned.shape[0]) / 2, 1 / comb.frequency
        long = _long_marks(turned, rows, places, numbers, spacing)
        places = places - (width - 1) / 2
        return Tape(turn, rows, line, places, numbers, spacing, clearness, begins, long)
    return None


class Comb(NamedTuple):
    """Marks at distances that change slowly along a row."""

    frequency: float  # marks per pixel in the middle of the row
    bend: float = 0.0  # share by which they are denser at its right end, because of a tilt
    bulge: float = 0.0  # share by which they are denser at both ends, because of the lens

    def marks(self, width: int) -> np.ndarray:
        """Number of marks (W,) from the middle of a row to each of its pixels."""
        u = (np.arange(width) - (width - 1) / 2) / (width / 2)
        return self.frequency * width / 2 * (u + self.bend * u**2 / 2 + self.bulge * u**3 / 3)


def _band(
    ripple: np.ndarray, frequencies: np.ndarray, bend: float
) -> tuple[slice, float, float] | None:
    """The rows in which marks stand out, if there are any; marks per pixel, and how clear."""
    waves = _waves(Comb(1.0, bend).marks(ripple.shape[1])[:, np.newaxis] * frequencies)
    strength = np.abs(ripple @ waves.astype(np.complex64))
    most = strength.max(axis=1)
    clearness = most / (np.median(strength, axis=1) + 1e-3 * strength.max() + 1e-9)
    row = int(np.argmax(clearness * most))
    if clearness[row] < _CLEAR or most[row] < _SHARE * np.abs(ripple[row]).sum():
        return None
    # rows around the clearest one with as clear a period of the same length
    peak = strength.argmax(axis=1)
    alike = (np.abs(peak - peak[row]) <= 4) & (clearness > 0.5 * clearness[row])
    breaks = np.flatnonzero(~(alike & (most > 0.5 * most[row])))
    low = int(breaks[breaks < row].max(initial=-1)) + 1
    high = int(breaks[breaks > row].min(initial=len(alike)))
    frequency = float(frequencies[peak[row]])
    if high - low < max(_LEAST_ROWS, _HEIGHT / frequency):
        return None
    return slice(low, high), frequency, float(clearness[row])


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


def _fitted(profile: np.ndarray, comb: Comb) -> Comb:
    """The comb near a given one that the marks follow best."""
    width = profile.size
    # The strength has other maxima beside the greatest one: first all combs, coarsely.
    frequencies = comb.frequency + np.arange(-6, 6.1, 0.25) / width
    bends = comb.bend + np.arange(-_FINE_BENDS, _FINE_BENDS + 1) * _FINEST_BEND
    counts = (Comb(1.0, bend).marks(width)[:, np.newaxis] * frequencies for bend in bends)
    table = np.abs([profile @ _waves(count) for count in counts])
    row, column = np.unravel_index(np.argmax(table), table.shape)
    start = np.array([frequencies[column], bends[row], 0.0])
    best = scipy.optimize.minimize(
        lambda values: -float(np.abs(profile @ _waves(Comb(*values).marks(width)))),
        start, method="Nelder-Mead",
        options={
            "initial_simplex": start + np.vstack([np.zeros(3), np.diag([0.1 / width, 3e-3, 0.01])]),
            "xatol": 1e-6, "fatol": 1e-6 * np.abs(profile).sum(),
        },
    ).x  # fmt: skip
    return Comb(*best)


def _waves(count: np.ndarray) -> np.ndarray:
    """One turn for each mark."""
    return np.exp(-2j * np.pi * count)


def _marks(
    profile: np.ndarray, light: np.ndarray, shown: np.ndarray, comb: Comb
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Places of the marks in a row, their numbers, and whether the tape's beginning is seen."""
    spacing, count = 1 / comb.frequency, comb.marks(profile.size)
    once, twice = (profile @ _waves(times * count) for times in (1, 2))
    # Marks are narrower than what lies between them. So the second harmonic tells dark marks from
    # bright ones; where it cannot be seen, marks are dark.
    bright = (twice * np.conj(once) ** 2).real > 0.05 * abs(once) ** 3
    sign = 1 if bright else -1
    count += np.angle(sign * once) / (2 * np.pi)
    pixels = np.arange(profile.size, dtype=float)
    last = np.interp(profile.size - 1 - spacing, pixels, count)
    numbers = np.arange(np.ceil(count[0]), np.floor(last) + 1)
    even = np.interp(numbers, count, pixels)  # where the comb has them
    middle = float(scipy.ndimage.center_of_mass(profile**2)[0])
    seen = _seen(even, light, spacing, sign, middle=middle)
    late, clear = _lateness(sign * profile, count, even, spacing)
    clear /= np.median(clear[seen]) if seen.any() else 1.0
    plain = seen & (clear > _SEEN)
    # Three marks in a row are a tape; what lies dark between two such parts of it, covers it.
    three = np.flatnonzero(plain[:-2] & plain[1:-1] & plain[2:])
    inside = even[three[0] + 1] if three.size else middle
    end, end_seen = _beginning(light, shown, spacing, inside)
    # The end of a tape can be its zero: a mark there may lie a little before it.
    on_tape = even >= end - spacing / 4
    possible = seen & on_tape
    first = int(np.argmax(possible)) if possible.any() else int(np.argmin(np.abs(even - end)))
    # A tape hardly brighter than what lies beyond it ends where there is room for marks, but none.
    begins = bool(end_seen or even[first] > np.argmax(shown) + 1.5 * spacing)
    kept = plain & on_tape
    return even[kept] + spacing * late[kept], numbers[kept] - numbers[first], begins


def _long_marks(
    turned: np.ndarray, rows: slice, places: np.ndarray, numbers: np.ndarray, spacing: float
) -> tuple[int, int] | None:
    """Number of the first of the longer marks, and from one to the next: every tenth, or fifth.

    Only marks before a wide gap tell: beyond it the count may be wrong.
    """
    part = slice(1 + int(np.argmax(np.append(np.diff(numbers), np.inf) > WIDE_GAP)))
    pixels, places, residue = np.arange(turned.shape[1]), places[part], numbers[part] % 10
    if residue.size < 20 or np.unique(residue).size < 10:
        return None
    reach = max(2, (rows.stop - rows.start) // 2)  # rows beside those of the other marks
    for beside in (slice(rows.stop, rows.stop + reach), slice(rows.start - reach, rows.start)):
        if beside.start < 0 or beside.stop > turned.shape[0]:
            continue
        light = turned[beside].mean(axis=0)
        on = np.interp(places, pixels, light)
        between = (np.interp(places + side * spacing / 2, pixels, light) for side in (-1, 1))
        contrast = np.abs(on - sum(between) / 2)
        mean = np.array([np.median(contrast[residue == digit]) for digit in range(10)])
        for every in (10, 5):
            shortest = mean.reshape(-1, every).min(axis=0)  # of the marks that may be long
            first = int(np.argmax(shortest))
            others = np.delete(mean, np.arange(first, 10, every))
            if shortest[first] > _LONGER * others.max():
                return first, every
    return None


def _lateness(
    profile: np.ndarray, count: np.ndarray, even: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """By what share of a mark's distance each one lies to the right of its comb, and how clear."""
    distance = (np.arange(profile.size) - even[:, np.newaxis]) / (_SHARPNESS * spacing)
    near = np.exp(-(distance**2) / 2) * _waves(count)
    period = near @ profile
    return -np.angle(period) / (2 * np.pi), np.abs(period)


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
        # A mark on the first pixel may have its middle beside it.
        return float(np.argmax(shown)) + 0.25 * spacing - 1, False
    last = before[-1]
    rise = body[last + 1] - body[last]
    part = np.clip((half[last] - body[last]) / max(rise, 1e-9), 0, 1)
    return float(last + part), True
