"""Video files: frames with their instants, in and out."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import av
import cv2
import numpy as np
from av.video.reformatter import ColorRange, VideoReformatter

from beltrepro.base import checks, reading
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError

SUFFIXES = (".mp4", ".mov", ".mkv")
# Instants are multiples of this: the common frame rates (24, 25, 30, 50, 60) are exact in it.
_TICK = Fraction(1, 90_000)
_FEW_EARLY = 2  # frames out of order, as at the begin of some films
_MISSED = 1.5  # steps between frames, over the usual one, where one is missing
_STILL_S = 0.5  # for which a moving belt cannot give the same picture
_REPEATS = 0.1  # share of pictures that come twice, which is told
_NEW = 32  # levels by which a picture differs that the motion has not come to by and by
_STILL = 8  # levels by which pictures of the same differ that are compressed
_SOUND_S = 1.0  # by which the sound of a film may be longer than its pictures, which is no fault
# What every player shows: brightness, and colours at half as many points along each side.
_PIXELS, _NO_COLOUR = "yuv420p", 128


class Frame(NamedTuple):
    """A picture and when it was taken."""

    time_s: float  # seconds from the beginning of the video
    picture: np.ndarray  # brightness, from 0 (black) to 255 (white); or red, green and blue


def write_video(
    path: str | Path,
    frames: Iterable[Frame],
    *,
    frames_per_second: float,
    compression: int = 18,
    preset: str = "ultrafast",
) -> int:
    """Write frames to an H.264 video; the file appears under its name when it is complete."""
    path = checks.path("path", path, SUFFIXES)
    stream, count = None, 0
    # "file:", as FFmpeg takes the "a:" of a name for a protocol
    with replacing(path) as part, av.open(f"file:{part}", "w") as container:
        for time_s, picture in frames:
            frame = _to_be_written(picture)
            if stream is None:
                rate = Fraction(frames_per_second).limit_denominator(1001)  # as containers do
                stream = container.add_stream("libx264", rate=rate)
                stream.height, stream.width = frame.height, frame.width
                stream.pix_fmt = _PIXELS
                stream.codec_context.time_base = _TICK
                stream.codec_context.color_range = frame.color_range
                stream.options = {"crf": str(compression), "preset": preset}
            frame.pts, frame.time_base = round(time_s / _TICK), _TICK
            container.mux(stream.encode(frame))
            count += 1
        if stream is None:
            raise InputError(f"{path}: no frame to write")
        container.mux(stream.encode())
    return count


def read_video(path: str | Path) -> Iterator[Frame]:
    """Read the frames of a video one by one, as the camera meant them to be seen.

    Colours become brightness, and a picture that a phone marks as turned is turned. A frame that is
    no later than the one before is left out. So are, with a warning, a damaged one and those that
    rest on it, up to the next whole picture; a video that breaks off ends there. A warning tells of
    times without frames before pictures that are not whole: a decoder cannot tell whether the
    camera left them out, or the file has lost them. Another tells of a picture that stands still.
    """
    path = checks.path("video", path)
    reading.opened(path).close()  # one line for what is no file
    first, last, to_grey = math.nan, -math.inf, VideoReformatter()
    is_whole, count, left_out, announced, shape = True, 0, [], 0.0, [1]
    early, times, rests = 0, [], []  # frames out of order; those read: when, and on others or not
    same, since, longest = None, 0.0, (0.0, 0.0)  # a picture that stays: from when, for how long
    repeats, is_new = 0, False  # pictures that come twice; whether the last one was new
    with suppress(av.FFmpegError), av.open(f"file:{path}") as container:
        announced = _seconds(container)
        shape = [one.sample_aspect_ratio or 1 for one in container.streams.video[:1]]
        for frame in _decoded(container):
            if frame is None:
                is_whole = False
                continue
            is_whole = not frame.is_corrupt and (is_whole or bool(frame.key_frame))
            if frame.time is None or frame.time <= last:
                early += 1
                continue
            first, last = frame.time if math.isnan(first) else first, frame.time
            times.append(frame.time)
            rests.append(not frame.key_frame)
            if is_whole:
                grey = to_grey.reformat(frame, format="gray").to_ndarray()
                picture = np.ascontiguousarray(np.rot90(grey, round(frame.rotation / 90)), np.uint8)
                if same is not None and picture.shape != same.shape:
                    raise InputError(f"{path}: pictures have another size from {last:.3g} s on")
                change = math.inf if same is None else cv2.norm(picture, same, cv2.NORM_INF)
                if change > _STILL:
                    same, since, is_new = picture, last, change > _NEW
                else:
                    repeats, is_new = repeats + is_new, False
                    if last - since > longest[1]:
                        longest = since - first, last - since
                yield Frame(last - first, picture)
                count += 1
            else:
                left_out.append(last - first)
    if not count:
        raise InputError(f"{path}: not a video that can be read")
    if left_out:
        many = f"{len(left_out)} of {count + len(left_out)}, from {left_out[0]:.3g} s on"
        warnings.warn(f"{path}: damaged; frames left out: {many}", stacklevel=2)
    if early > _FEW_EARLY:
        warnings.warn(
            f"{path}: {early} frames that are no later than others left out", stacklevel=2
        )
    if count > 1 and not left_out:
        steps = np.diff(times)
        missing = np.flatnonzero((steps > _MISSED * np.median(steps)) & rests[1:])
        if missing.size:
            where = f"{missing.size} times, first at {times[missing[0]] - first:.3g} s"
            wrong = "if the file lost them, places up to the next whole picture are wrong"
            warnings.warn(f"{path}: frames are missing {where}; {wrong}", stacklevel=2)
    if shape != [1]:
        warnings.warn(
            f"{path}: its pixels are {float(shape[0]):.4g} times as wide as high, and players "
            "stretch it: scale and zero are those of stored pixels",
            stacklevel=2,
        )
    if longest[1] > _STILL_S:
        still = f"from {longest[0]:.3g} s for {longest[1]:.3g} s"
        warnings.warn(f"{path}: the picture stands still {still}", stacklevel=2)
    if repeats > _REPEATS * count:
        late = "the camera took fewer than the film has, and places are late by up to a frame"
        warnings.warn(f"{path}: {repeats} of {count} pictures come again: {late}", stacklevel=2)
    if last - first < announced - _SOUND_S:
        ends = f"it ends at {last - first:.3g} s of {announced:.3g} s"
        warnings.warn(f"{path}: damaged or cut: {ends}", stacklevel=2)


def _decoded(container: av.container.InputContainer) -> Iterator[av.VideoFrame | None]:
    """The frames of a video; None for what cannot be decoded."""
    for packet in container.demux(video=0) if container.streams.video else ():
        try:
            yield from packet.decode()
        except av.FFmpegError:
            yield None


def _seconds(container: av.container.InputContainer) -> float:
    """How long a video says that it is; 0 if it does not."""
    for stream in container.streams.video[:1]:
        if stream.duration and stream.time_base:
            return float(stream.duration * stream.time_base)
    return (container.duration or 0) / av.time_base


def _to_be_written(picture: np.ndarray) -> av.VideoFrame:
    """A frame of brightness (H, W), as it is, or of red, green and blue (H, W, 3)."""
    if picture.ndim == 3:
        return av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(format=_PIXELS)
    height, width = picture.shape
    planes = np.full((height + height // 2, width), _NO_COLOUR, np.uint8)
    planes[:height] = picture
    frame = av.VideoFrame.from_ndarray(planes, format=_PIXELS)
    frame.color_range = ColorRange.JPEG  # from 0 to 255
    return frame
