"""Where the white block is in each frame of a video, in metres (Sec. II)."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.replication.camera import white_block
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.survey import SUPPORTS, Survey
from beltrepro.replication.camera.video import Frame, read_video
from beltrepro.replication.camera.white_block import Place, Region

# Frames at the beginning in which the belt, the tape and the block are looked for, and of how many
# each is one that is looked at.
_SURVEY, _EVERY = 240, 10
SPRING = 0.3  # share of the block: what is narrower across the belt is wiped off
_FASTEST = 3.0  # m/s that the block never reaches
_SCALES = (1e-6, 0.1)  # metres per pixel that a camera above a treadmill can have
# Fields of a track that its file has in the first line.
_NUMBERS = ("metres_per_pixel", "angle", "scale_error", "zero_error_m")
_FIRST_MARK = 5.0  # metres: no tape beside a chain reads more where the picture begins


@dataclass(frozen=True, eq=False)
class Track:
    """Places of the white block."""

    # instants of the frames in which it was found, seconds from the beginning of the video
    time_s: np.ndarray
    # its middle along the belt, metres from the first mark of the tape (plus what it reads)
    x_m: np.ndarray
    error_m: np.ndarray  # one standard error of x_m, of which some is common to all frames
    metres_per_pixel: float  # scale of the picture
    angle: float  # by which the belt is turned in the picture, degrees, clockwise
    lost_s: np.ndarray  # begin and end of each stretch of frames in which the block was not found
    # What all frames have in common: x is wrong by zero_error_m + scale_error x, one standard error
    # of each. Both are part of error_m; nan where they are not known.
    scale_error: float = math.nan
    zero_error_m: float = math.nan

    def save(self, path: str | Path) -> None:
        """Write the track as CSV: a line of settings, which begins with #, and three columns."""
        settings: dict[str, Any] = {"lost_s": self.lost_s.tolist()}
        for name in _NUMBERS:
            number = getattr(self, name)
            settings[name] = number if math.isfinite(number) else None
        rows = np.column_stack([self.time_s, self.x_m, self.error_m])
        with Path(path).open("w", encoding="utf-8") as file:
            file.write(f"# {json.dumps(settings)}\ntime_s,x_m,error_m\n")
            np.savetxt(file, rows, delimiter=",", fmt="%.9g")

    @classmethod
    def load(cls, path: str | Path) -> Track:
        """Read a CSV file with the columns time_s, x_m and, if known, error_m."""
        from beltrepro.replication.camera.track_file import read_track

        (time_s, x_m, error_m), settings = read_track(Path(path))
        values = ((name, settings.get(name)) for name in _NUMBERS)
        numbers = {name: math.nan if value is None else float(value) for name, value in values}
        lost_s = np.array(settings.get("lost_s", []), dtype=float).reshape(-1, 2)
        return cls(time_s, x_m, error_m, lost_s=lost_s, **numbers)


def track(
    video: str | Path,
    *,
    metres_per_pixel: float | None = None,
    first_mark: float | None = None,
    support: str = "auto",
    scene: Scene | None = None,
    progress: Callable[[float], None] | None = None,
) -> Track:
    """Track the white block in a video from above the belt.

    Belt, tape and block are looked for in the first ten seconds or so; then the block is followed
    from frame to frame (docs/experiment.md).
    """
    scene = scene or Scene()
    if metres_per_pixel is not None:
        checks.within("metres_per_pixel", metres_per_pixel, ge=_SCALES[0], le=_SCALES[1])
    if first_mark is not None:
        checks.within("first_mark", first_mark, ge=-_FIRST_MARK, le=_FIRST_MARK)
    if support not in SUPPORTS:
        raise InputError(f"support = {support!r}: allowed are {', '.join(SUPPORTS)}")
    beginning = itertools.islice(read_video(video), 0, _SURVEY, _EVERY)
    pictures = [frame.picture for frame in beginning]
    survey = Survey.of(pictures, scene, metres_per_pixel, first_mark, support, str(video))
    places, lost, across = [], [], []
    for frame, place in _follow(read_video(video), survey):
        if place is None:
            lost.append(frame.time_s)
        else:
            places.append((frame.time_s, survey.along_belt(place), place.error))
            across.append(survey.across_belt(place))
        if progress:
            progress(frame.time_s)
    if len(places) < 2:
        raise InputError(f"{video}: no white block found in more than {len(places)} of the frames")
    time, along, error = np.array(places).T
    return Track(
        time_s=time,
        x_m=(first_mark or 0.0) + along * survey.metres_per_pixel,
        error_m=error * survey.metres_per_pixel,
        metres_per_pixel=survey.metres_per_pixel,
        angle=survey.angle + survey.towards * _slope(along, np.array(across), survey.along),
        lost_s=_stretches(np.array(lost), time),
    )


def _follow(frames: Iterator[Frame], survey: Survey) -> Iterator[tuple[Frame, Place | None]]:
    """Each frame with the place of the block, None where it is not found."""
    last, last_time = None, 0.0
    for frame in frames:
        farthest = _FASTEST * (frame.time_s - last_time) / survey.metres_per_pixel
        place = None
        for reach in (min(survey.along, farthest), farthest, None):
            if place is None and (last is not None or reach is None):
                place = _look(frame.picture, survey, last, reach)
        if place is not None:
            last, last_time = place, frame.time_s
        yield frame, place


def _look(
    picture: np.ndarray, survey: Survey, last: Place | None, reach: float | None
) -> Place | None:
    """The block in a picture, or only within reach of where it was."""
    window, left, top = picture, 0, 0
    if last is not None and reach is not None:
        askew = abs(np.sin(np.radians(survey.angle)))
        half = (reach + 1.5 * survey.along, reach * askew + survey.across)
        left, top = (max(0, int(middle - by)) for middle, by in zip(last[:2], half, strict=True))
        right, bottom = (int(middle + by) + 1 for middle, by in zip(last[:2], half, strict=True))
        window = picture[top:bottom, left:right]
    regions: Iterable[Region] = _blocks(window, survey, last, (left, top))
    if last is None:
        regions = sorted(regions, key=lambda region: -region.along * region.across)
    elif reach is None:
        regions = sorted(regions, key=lambda region: _distance(region, last))
    else:  # others are cut by the edge of the window
        regions = (seen for seen in regions if _distance(seen, last) < reach + survey.along / 2)
    for region in regions:
        place = white_block.place_block(picture, region, survey.angle, survey.along, survey.across)
        if place is not None:
            return place
    return None


def _blocks(
    window: np.ndarray, survey: Survey, last: Place | None, corner: tuple[int, int]
) -> Iterator[Region]:
    """Regions of the size of the block in a part of a picture, in the lane of the last place."""
    lane = None if last is None else survey.across_belt(last)
    shape, opening = survey.along / survey.across, int(SPRING * survey.across)
    for region in white_block.bright_rectangles(window, survey.angle, shape, opening):
        placed = region._replace(x=region.x + corner[0], y=region.y + corner[1])
        if white_block.has_size(placed, survey.along, survey.across) and (
            lane is None or abs(survey.across_belt(placed) - lane) < survey.across / 2
        ):
            yield placed


def _distance(one: Region, other: Place) -> float:
    return math.hypot(one.x - other.x, one.y - other.y)


def _slope(along: np.ndarray, across: np.ndarray, length: float) -> float:
    """Degrees between the way of the block and the lines that the survey saw; 0 for a short way."""
    if along.std() < length / 2:
        return 0.0
    return float(np.degrees(np.arctan(np.polyfit(along, across, 1)[0])))


def _stretches(lost: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Begin and end (L, 2) of runs of lost frames with no frame in between that was found."""
    if not lost.size:
        return np.empty((0, 2))
    place = np.searchsorted(seen, lost)
    parts = np.split(lost, np.flatnonzero(np.diff(place)) + 1)
    return np.array([(part[0], part[-1]) for part in parts])
