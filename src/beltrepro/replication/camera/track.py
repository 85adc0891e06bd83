"""Where the white block is in each frame of a film whose scale is known (Sec. II), and its table.

What is narrower across the belt than the block, as springs and a tape, is wiped off; Otsu's
threshold parts bright from dark, and the block is the largest bright rectangle. Its place is the
middle of its light. The line through the places of all frames is the direction of the belt.
"""

from __future__ import annotations

import io
import json
import math
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from beltrepro.base import checks, names, reading
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.camera.recording import LONGEST_GAP, stretches
from beltrepro.replication.camera.video import read_video

SUPPORTS = {"left": 1, "right": -1}  # where the chain is held, and to which side x grows
# What is narrower across the belt is wiped off, and what is larger is no block: it is 8 cm wide.
WIPED_M, _LARGEST_M = 0.04, 0.2
_SCALES = 1e-6, 0.1  # metres per pixel that a camera above a treadmill can have
_BESIDE = 4  # pixels beside the block that show its edge and the dark
_CONTRAST = 30  # levels between white and dark, at least
_FILLED = 0.65  # share of the rectangle around a region that a block fills, at least
_ALIKE = 0.7  # a region with this share of the largest one's area may be the block as well
_LOST = 0.05  # share of frames without the block that is told
_SIZE = 0.25  # share by which area and height of the block may be others than in most frames

_KNOWN = (
    "track needs the scale and the zero of the film. Find two marks of a tape a known length apart "
    "in a frame: scale = metres / pixels between them (--scale). zero = the pixel column of the "
    "point where x is 0, the fixed point of the chain (--zero)"
)
_NEEDED = ["time_s", "x_m"]
_SETTINGS = ("lost_s", "metres_per_pixel", "zero", "angle")
_MOST_BYTES = 10**9  # of a table


@dataclass(frozen=True, eq=False)
class Track:
    """Places of the white block."""

    # instants of the frames in which it was found, seconds from the beginning of the film
    time_s: np.ndarray
    x_m: np.ndarray  # its middle along the belt, metres from the zero
    # begin and end (L, 2) of each stretch in which it was not found, or that has no frames
    lost_s: np.ndarray
    metres_per_pixel: float = math.nan  # scale, as given
    zero: tuple[float, float] = (math.nan, math.nan)  # pixel of x = 0: column, as given, and row
    angle: float = math.nan  # by which the belt is turned in the picture, degrees, clockwise

    def save(self, path: str | Path, **about: Any) -> None:
        """Write the track as CSV: a line of settings that begins with #, and two columns."""
        settings = about | {name: getattr(self, name) for name in _SETTINGS}
        settings["lost_s"] = self.lost_s.tolist()
        path = checks.path("path", path, (".csv",))
        with replacing(path) as part, part.open("w", encoding="utf-8") as file:
            file.write(f"# {json.dumps(settings)}\n{','.join(_NEEDED)}\n")
            np.savetxt(file, np.column_stack([self.time_s, self.x_m]), delimiter=",", fmt="%.9g")

    @classmethod
    def load(cls, path: str | Path) -> Track:
        """Read a CSV file with the columns time_s and x_m, and the settings if `save` wrote it."""
        text = reading.text(checks.path("path", path), _MOST_BYTES)
        try:
            time_s, x_m = _columns(text)
        except ValueError as reason:
            raise InputError(f"{path}: {reason}") from None
        if not text.endswith("\n"):
            warnings.warn(f"{path}: its last line has no end: was it cut off?", stacklevel=2)
        try:
            said = json.loads(text.partition("\n")[0].removeprefix("#"))
            lost_s, scale, zero, angle = (said[name] for name in _SETTINGS)
            lost_s = np.array(lost_s, dtype=float).reshape(-1, 2)
            return cls(time_s, x_m, lost_s, scale, tuple(zero), angle)
        except (KeyError, TypeError, ValueError):  # of another program
            return cls(time_s, x_m, np.empty((0, 2)))


def _columns(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Instants and places in a table; ValueError in a line where it has none."""
    import pandas as pd  # not needed to film and track

    rows = "".join(line for line in text.splitlines(True) if not line.lstrip().startswith("#"))
    try:
        # as text: pandas makes numbers of True and False
        table = pd.read_csv(io.StringIO(rows), dtype=str, skipinitialspace=True)
    except pd.errors.EmptyDataError:
        table = pd.DataFrame()
    if missing := [name for name in _NEEDED if name not in table]:
        raise ValueError(f"lacks the column {', '.join(missing)}")
    if not isinstance(table.index, pd.RangeIndex):  # pandas takes the first cells for names
        raise ValueError("its rows have more cells than its header: 0,5 is 0.5")
    if twice := [name for name in _NEEDED if f"{name}.1" in table]:
        raise ValueError(f"has the column {', '.join(twice)} twice")
    values = table[_NEEDED].apply(pd.to_numeric, errors="coerce").to_numpy(dtype=float)
    if not len(values):
        raise ValueError("has no rows")
    wrong = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if wrong.size:
        row = ", ".join(map(str, table[_NEEDED].iloc[wrong[0]]))
        raise ValueError(f"row {wrong[0] + 1} has no finite number in time_s or x_m: {row}")
    return values.T


def track(
    video: str | Path,
    *,
    scale: float | None = None,
    zero: float | None = None,
    support: str = "left",
) -> Track:
    """Track the white block in a film from straight above the belt.

    scale : metres per pixel.
    zero : column of the pixel where x is 0, on the way of the block; 0 is the middle of the first.
    support : side of the picture where the chain is held, left or right.
    """
    if scale is None or zero is None:
        raise InputError(_KNOWN)
    scale = checks.within("scale", scale, ge=_SCALES[0], le=_SCALES[1])
    zero = checks.finite_number("zero", zero)
    side = SUPPORTS[names.one_of("support", support, SUPPORTS)]
    frames = [(time_s, *_block(picture, scale)) for time_s, picture in read_video(video)]
    time, column, row, area, height, second = np.array(frames).T
    alike = np.isfinite(column) & (second > _ALIKE * area)
    if 2 * alike.sum() > len(time):
        raise InputError(f"{video}: two white things are as large as the block: cover the other")
    seen = np.isfinite(column) & ~alike
    for size in (area, height):
        seen &= np.abs(size / np.median(size[seen] if seen.any() else size) - 1) < _SIZE
    if seen.sum() < max(2, len(time) / 2):
        raise InputError(
            f"{video}: the white block is found in {seen.sum()} of {len(time)} frames: half of "
            f"them are needed, and two at least, with a bright rectangle that is wider than "
            f"{100 * WIPED_M:g} cm across a dark belt, and away from the edges of the picture"
        )
    if _spread(row[seen]) > max(1.0, _spread(column[seen]) / 2):
        raise InputError(f"{video}: the belt must run from left to right: turn the film")
    for _ in range(2):  # what is not on the line of most places is another thing
        slope, level = _line(column[seen], row[seen])
        seen &= np.abs(row - level - slope * column) < _SIZE * np.median(height[seen])
    x = side * scale * math.hypot(1, slope) * (column[seen] - zero)
    if np.median(x) < 0:
        raise InputError(
            f"{video}: the block is on the side of the support, {np.median(x):.3g} m from zero: "
            f"give the column of x = 0, --zero, or the other side, --support"
        )
    if (lost := np.count_nonzero(~seen)) > _LOST * len(time):
        where = "where it is covered, or moves so fast that it blurs; means leave that out"
        warnings.warn(f"{video}: no block in {lost} of {len(time)} frames, {where}", stacklevel=2)
    place, lost_s = (zero, level + slope * zero), _lost(time, seen)
    return Track(time[seen], x, lost_s, scale, place, math.degrees(math.atan(slope)))


def _lost(time: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Begin and end of the stretches without the block; a gap counts as frames without it."""
    steps = np.diff(time)
    interval = np.median(steps)
    gaps = np.flatnonzero(steps > LONGEST_GAP * interval)
    edges = np.column_stack([time[gaps] + interval, time[gaps + 1] - interval]).ravel()
    place = np.repeat(gaps + 1, 2)
    return stretches(np.insert(time, place, edges), np.insert(~seen, place, True))


def white(picture: np.ndarray, scale: float) -> np.ndarray:
    """The picture (H, W) of 0 and 1 after the threshold, without what is narrow across the belt."""
    rows = np.clip(round(WIPED_M / scale), 1, len(picture))
    opened = cv2.morphologyEx(picture, cv2.MORPH_OPEN, np.ones((rows, 1), np.uint8))
    return cv2.threshold(opened, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[1]


def _block(picture: np.ndarray, scale: float) -> tuple[float, float, float, float, float]:
    """Column and row of the block, its area and height, and the area of the next; nan for none."""
    _, _, table, _ = cv2.connectedComponentsWithStats(white(picture, scale))
    left, top, width, height, area = table[1:].T  # without the dark
    inside = (left > 0) & (left + width < picture.shape[1])
    inside &= (top > 0) & (top + height < picture.shape[0])
    whole = inside & (area > _FILLED * width * height)
    whole &= np.maximum(width, height) < _LARGEST_M / scale
    if not whole.any():
        return (math.nan,) * 5
    regions = table[1:][whole]
    regions = regions[regions[:, cv2.CC_STAT_AREA].argsort()[::-1]]
    left, top, width, height, area = regions[0]
    second = regions[1, cv2.CC_STAT_AREA] if len(regions) > 1 else 0
    third = height // 3  # a spring touches the block on the rows between
    rows = np.r_[top : top + third, top + height - third : top + height]
    column, contrast = _middle(picture[rows], left, width)
    row, _ = _middle(picture[:, left : left + width].T, top, height)
    return column if contrast > _CONTRAST else math.nan, row, area, height, second


def _middle(rows: np.ndarray, begin: int, size: int) -> tuple[float, float]:
    """Middle of the white in rows of pixels, and how much lighter it is than the dark beside it."""
    first = max(0, begin - _BESIDE)
    light = rows[:, first : begin + size + _BESIDE].mean(axis=0)
    dark, white = np.median(light[[0, 1, -2, -1]]), np.median(light[begin - first :][:size])
    share = np.clip((light - dark) / max(white - dark, 1), 0, 1)
    return first + float(share @ np.arange(len(share)) / share.sum()), float(white - dark)


def _spread(places: np.ndarray) -> float:
    """Median distance from the median, in pixels."""
    return float(np.median(np.abs(places - np.median(places))))


def _line(column: np.ndarray, row: np.ndarray) -> tuple[float, float]:
    """Slope of the line through places, and its row in column 0; level for a block at rest."""
    way = column - column.mean()
    slope = float(way @ row / max(way @ way, len(way)))  # a way of a pixel has no direction
    return slope, float(row.mean() - slope * column.mean())
