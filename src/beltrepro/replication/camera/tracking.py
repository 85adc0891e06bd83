"""Where the white block is in each frame of a video, in metres (Sec. II)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.replication.camera import tape, white_block
from beltrepro.replication.camera.following import ACROSS, SHIFT, Follower, Motion, settled
from beltrepro.replication.camera.reading import read
from beltrepro.replication.camera.scene import TAPE_HEIGHT_ERROR, Scene
from beltrepro.replication.camera.survey import SUPPORTS, Survey
from beltrepro.replication.camera.track_file import Track
from beltrepro.replication.camera.video import Frame, read_video
from beltrepro.replication.camera.white_block import Place, Region

# Frames at the beginning in which the belt, the tape and the block are looked for, and of how many
# each is one that is looked at.
_SURVEY, _EVERY = 240, 10
SPRING = 0.3  # share of the block: what is narrower across the belt is wiped off
_FASTEST = 3.0  # m/s that the block never reaches
_SCALES = (1e-6, 0.1)  # metres per pixel that a camera above a treadmill can have
_FIRST_MARK = 5.0  # metres: no tape beside a chain reads more where the picture begins


def track(
    video: str | Path,
    *,
    metres_per_pixel: float | None = None,
    first_mark: float | None = None,
    support: str = "auto",
    scene: Scene | None = None,
    tape_height_error: float = TAPE_HEIGHT_ERROR,
) -> Track:
    """Track the white block in a video from above the belt.

    Belt, tape and block are looked for in the first ten seconds or so; then the block is followed
    from frame to frame (docs/experiment.md). The face of the tape may lie above or below the tops
    of the blocks, with a standard error of `tape_height_error` in metres.
    """
    if metres_per_pixel is not None:
        checks.within("metres_per_pixel", metres_per_pixel, ge=_SCALES[0], le=_SCALES[1])
    if first_mark is not None:
        checks.within("first_mark", first_mark, ge=-_FIRST_MARK, le=_FIRST_MARK)
    tape_height_error = checks.not_negative("tape_height_error", tape_height_error)
    if support not in SUPPORTS:
        raise InputError(f"support = {support!r}: allowed are {', '.join(SUPPORTS)}")
    beginning = itertools.islice(read_video(video), 0, _SURVEY, _EVERY)
    pictures = [frame.picture for frame in beginning]
    with _named(video):
        survey = Survey.of(pictures, scene or Scene(), metres_per_pixel, first_mark, support)
    frames = list(_follow(read_video(video), survey))
    time = np.array([frame.time_s for frame in frames])
    places = [frame.place for frame in frames if frame.place]
    seen = np.array([frame.place is not None for frame in frames])
    with _named(video):
        if len(places) < max(2, len(frames) / 2):
            side = tape.lies_on_its_side(survey.picture)
            advice = ": turn the film by a quarter, so that the belt runs from left to right"
            raise InputError(
                f"the white block is found in {len(places)} of the frames, of which there are "
                f"{len(frames)}: half of them are needed, and two at least{advice if side else ''}"
            )
        moved, moved_error = settled(*map(np.array, zip(*(f.motion for f in frames), strict=True)))
        lost_s = _stretches(time[~seen], time[seen])
        moved, moved_error = moved[seen], moved_error[seen]
        return read(survey, time[seen], lost_s, places, moved, moved_error, tape_height_error)


@contextmanager
def _named(video: str | Path) -> Iterator[None]:
    """Name the video in what is refused of it."""
    try:
        yield
    except InputError as reason:
        raise InputError(f"{video}: {reason}") from None


class _Frame(NamedTuple):
    """What is seen in a frame."""

    time_s: float
    place: Place | None  # of the block
    motion: Motion  # of the picture since the survey


def _follow(frames: Iterator[Frame], survey: Survey) -> Iterator[_Frame]:
    """What is seen in each frame, looked for from where it was in the one before."""
    follower = Follower(survey.picture, survey.measure) if survey.measure else None
    motion, last, last_time, last_moved = Motion(np.zeros(5), np.zeros(5)), None, 0.0, np.zeros(5)
    for time_s, picture in frames:
        if follower:
            motion = follower(picture)
        if np.isfinite(motion.values[0]):
            if last is not None:
                last = _carried(last, motion.values - last_moved, survey)
            last_moved = motion.values
        farthest = _FASTEST * (time_s - last_time) / survey.ruler.metres_per_pixel
        place = None
        for reach in (min(survey.along, farthest), farthest, None):
            if place is None and (last is not None or reach is None):
                place = _look(picture, survey, last, reach)
        if place is not None:
            last, last_time = place, time_s
        yield _Frame(time_s, place, motion)


def _carried(place: Place, moved: np.ndarray, survey: Survey) -> Place:
    """A place that has moved with the picture."""
    x, y = survey.in_picture(moved[SHIFT], moved[ACROSS])
    x0, y0 = survey.in_picture(0.0, 0.0)
    return place._replace(x=place.x + x - x0, y=place.y + y - y0)


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
    sides = survey.along, survey.across
    places = (white_block.place_block(picture, one, survey.angle, *sides) for one in regions)
    return next(filter(None, places), None)


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


def _stretches(lost: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Begin and end (L, 2) of runs of lost frames with no frame in between that was found."""
    if not lost.size:
        return np.empty((0, 2))
    place = np.searchsorted(seen, lost)
    parts = np.split(lost, np.flatnonzero(np.diff(place)) + 1)
    return np.array([(part[0], part[-1]) for part in parts])
