"""The white block in one picture: found by its size and shape, then placed to parts of a pixel."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np

# A region counts as a block if its sides and area are those of a rectangle, to this share.
_SIDES = 0.3
_FILLED = 0.78
_TILT = 12.0  # degrees
_LEVELS = 3  # of brightness above the dark
_SMALLEST = 4.0  # pixels of the shorter side
# Error that remains where noise is none: pixels are squares and codecs round.
_FLOOR = 0.02
# Neighbouring rows that share their error, because codecs describe 4 x 4 pixels or more together.
_ALIKE = 4
_BESIDE = 4  # pixels beside a block that show its edge and the dark
_BRIGHTEST = 250.0  # of 255 levels: beyond it brightness is cut off
_PLAIN = 0.2  # share of the contrast of the block by which the dark beside it may vary
_NORMAL = 1.4826  # standard deviation of normal deviates with a median of |deviation| of 1


class Region(NamedTuple):
    """A bright region of a picture, as a rectangle."""

    x: float  # its middle, pixels
    y: float
    along: float  # its sides along the belt and across it, pixels
    across: float


class Place(NamedTuple):
    """Where the white block is."""

    x: float  # its middle, pixels
    y: float
    error: float  # one standard error of the place along the belt, pixels
    length: float  # along the belt, pixels
    lean: float  # how its edges lean: pixels along the belt for each one across it
    sides: tuple[float, ...]  # along the belt and across, for its size; pixels


def bright_rectangles(
    picture: np.ndarray, angle: float, ratio: float, opening: int = 0
) -> Iterator[Region]:
    """Bright regions with the shape of a block: rectangles across the belt.

    Otsu's threshold parts bright from dark. Then it parts what is bright once more, and again: a
    white block can lie on a bright spring.
    """
    if opening > 1:
        picture = cv2.morphologyEx(picture, cv2.MORPH_OPEN, np.ones((opening, 1), np.uint8))
    seen: list[Region] = []
    above = picture.ravel()
    for _ in range(_LEVELS):
        if above.size < 2 * _SMALLEST**2:
            break
        threshold, _ = cv2.threshold(above, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
        for region in _rectangles(picture > threshold, angle, ratio):
            if all(_apart(region, other) for other in seen):
                seen.append(region)
                yield region
        above = above[above > threshold]


def _rectangles(white: np.ndarray, angle: float, ratio: float) -> Iterator[Region]:
    """Connected regions (H, W) of bool that are rectangles across the belt, of this shape."""
    _, label, table, _ = cv2.connectedComponentsWithStats(white.view(np.uint8), connectivity=4)
    least = _SMALLEST**2 / min(ratio, 1 / ratio)
    for number, (left, top, width, height, area) in enumerate(table[1:].tolist(), 1):
        if area < least or area < 0.4 * width * height:
            continue
        part = (label[top : top + height, left : left + width] == number).view(np.uint8)
        outline, _ = cv2.findContours(part, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
        _, sides, tilt = cv2.minAreaRect(outline[0])
        quarters = round((angle - tilt) / 90)
        # Pixels reach half a pixel beyond their middles.
        along, across = (side + 1 for side in (sides[::-1] if quarters % 2 else sides))
        if (
            abs(angle - tilt - 90 * quarters) <= _TILT
            and area >= _FILLED * along * across
            and abs(np.log(along / across / ratio)) < np.log(1 + 1.5 * _SIDES)
        ):
            sums = cv2.moments(part, binaryImage=True)
            yield Region(left + sums["m10"] / area, top + sums["m01"] / area, along, across)


def _apart(one: Region, other: Region) -> bool:
    """Whether two regions are different things."""
    return abs(one.x - other.x) > other.along / 2 or abs(one.y - other.y) > other.across / 2


def has_size(region: Region, along: float, across: float) -> bool:
    """Whether a region is as large as a block."""
    pairs = ((region.along, along), (region.across, across))
    return all(abs(side - size) < _SIDES * size + 1.5 for side, size in pairs)


def place_block(
    picture: np.ndarray, region: Region, angle: float, along: float, across: float
) -> Place | None:
    """Place a block to parts of a pixel, by the light on either side of its middle.

    The excess of the light over the dark beside the block, divided by that of the white, is the
    distance of an edge from the middle. Each row of pixels tells both edges. The median over the
    rows counts: a spring or a glare that touches the block on some rows does not move it.
    """
    margin = max(4.0, 0.25 * along)
    half = int(np.ceil(along / 2 + margin))
    for _ in range(3):  # again about the place found, if that is another
        patch = _patch(picture, region, angle, half, max(2, int(0.35 * across)))
        if patch is None:
            return None
        offset, length, error, lean = _edges(patch, half, int(np.ceil(margin / 2)))
        region = region._replace(
            x=region.x + offset * np.cos(np.radians(angle)),
            y=region.y + offset * np.sin(np.radians(angle)),
        )
        if abs(offset) < 0.5:
            break
    if not abs(length - along) < _SIDES * along + 1 or not error < 0.1 * along + 0.5:
        return None
    sides = (
        _extent(picture, region._replace(along=size, across=other), angle + turn)
        for size, other, turn in ((along, across, 0.0), (across, along, 90.0))
    )
    return Place(region.x, region.y, error, length, lean, tuple(sides))


def _extent(picture: np.ndarray, region: Region, angle: float) -> float:
    """Length of a side, pixels: in each row the light over that in the middle of the row.

    It is nan if something lies so near that no dark is seen between, or if the white is as bright
    as a picture can be: then the edges are, too.
    """
    half = round(region.along / 2) + _BESIDE
    patch = _patch(picture, region, angle, half, max(2, int(0.35 * region.across)))
    if patch is None:
        return np.nan
    third = half // 3
    white = np.median(patch[:, half - third : half + third + 1], axis=1)
    first, last = (_median(patch[:, part]) for part in (slice(0, 2), slice(-2, None)))
    if white.max() > _BRIGHTEST or abs(first - last) > _PLAIN * (_median(white) - min(first, last)):
        return np.nan
    dark = (first + last) / 2
    return _median((patch - dark).sum(axis=1) / (white - dark))


def _patch(
    picture: np.ndarray, region: Region, angle: float, half: int, rows: int
) -> np.ndarray | None:
    """The surroundings of a block (2 rows + 1, 2 half + 1), straightened, if they are all seen."""
    (reach_x, reach_y), (height, width) = _reach(angle, half, rows), picture.shape
    seen = (
        reach_x <= region.x <= width - 1 - reach_x and reach_y <= region.y <= height - 1 - reach_y
    )
    return around(picture, region, angle, half, rows) if seen else None


def _reach(angle: float, half: int, rows: int) -> tuple[float, float]:
    """How far the corners of a turned rectangle lie from its middle, along x and y."""
    cosine, sine = np.cos(np.radians(angle)), abs(np.sin(np.radians(angle)))
    return half * cosine + rows * sine, rows * cosine + half * sine


def around(picture: np.ndarray, region: Region, angle: float, half: int, rows: int) -> np.ndarray:
    """The surroundings of a block (2 rows + 1, 2 half + 1), straightened."""
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[cosine, -sine], [sine, cosine]])
    corner = np.array([region.x, region.y]) - turn @ (half, rows)
    # Only this window as numbers with parts: 8 bits would round what lies between pixels.
    reach_x, reach_y = _reach(angle, half, rows)
    left, top = max(0, int(region.x - reach_x)), max(0, int(region.y - reach_y))
    window = picture[top : int(region.y + reach_y) + 2, left : int(region.x + reach_x) + 2]
    return cv2.warpAffine(
        window.astype(np.float32),
        np.column_stack([turn, corner - (left, top)]),
        (2 * half + 1, 2 * rows + 1),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )


def _edges(patch: np.ndarray, half: int, border: int) -> tuple[float, float, float, float]:
    """Offset of the block's middle, its length, the error of the offset, pixels, and the lean."""
    quarter = max(1, half // 3)
    dark_left, dark_right = _median(patch[:, :border]), _median(patch[:, -border:])
    white_left = _median(patch[:, half - quarter : half])
    white_right = _median(patch[:, half + 1 : half + 1 + quarter])
    if min(white_left - dark_left, white_right - dark_right) < 5:
        return 0.0, 0.0, np.inf, 0.0
    # Half of the column in the middle counts for either side.
    middle = patch[:, half] / 2
    left = patch[:, :half].sum(axis=1) + middle - (half + 0.5) * dark_left
    right = patch[:, half + 1 :].sum(axis=1) + middle - (half + 0.5) * dark_right
    left /= white_left - dark_left
    right /= white_right - dark_right
    offsets = (right - left) / 2
    offset, length = _median(offsets), _median(left + right)
    spread = _NORMAL * _median(np.abs(offsets - offset))
    error = np.hypot(_FLOOR, spread * np.sqrt(np.pi / 2 / (len(offsets) / _ALIKE)))
    # The upper and the lower third: a spring touches the one between them.
    third = len(offsets) // 3
    lean = (_median(offsets[-third:]) - _median(offsets[:third])) / (len(offsets) - third)
    return offset, length, float(error), lean


def _median(values: np.ndarray) -> float:
    """The median of all values; `np.median` takes five times as long for a few hundred."""
    half = values.size // 2
    ordered = np.partition(values, (half - 1, half), axis=None) if half else values.ravel()
    return float(ordered[half] if values.size % 2 else (ordered[half - 1] + ordered[half]) / 2)
