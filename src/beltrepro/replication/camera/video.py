"""Video files: frames with their instants, in and out."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import av
import numpy as np
from av.video.reformatter import ColorRange, VideoReformatter

from beltrepro.base import checks, reading
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError

SUFFIXES = (".mp4", ".mov", ".mkv")
# Instants are multiples of this: the common frame rates (24, 25, 30, 50, 60) are exact in it.
_TICK = Fraction(1, 90_000)
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
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: the name of a video must end in {', '.join(SUFFIXES)}")
    stream, count = None, 0
    with replacing(path) as part, av.open(str(part), "w") as container:
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

    Colours become brightness, and a picture that a phone marks as turned is turned. A video that
    breaks off ends there. A frame that is no later than the one before is left out.
    """
    path = checks.path("video", path)
    reading.opened(path).close()  # one line for what is no file
    first, last, to_grey = None, -math.inf, VideoReformatter()
    with suppress(av.FFmpegError), av.open(str(path)) as container:
        for frame in container.decode(video=0) if container.streams.video else ():
            if frame.time is None or frame.time <= last:
                continue
            first, last = frame.time if first is None else first, frame.time
            picture = to_grey.reformat(frame, format="gray").to_ndarray()
            picture = np.rot90(picture, round(frame.rotation / 90))
            yield Frame(last - first, np.ascontiguousarray(picture))
    if first is None:
        raise InputError(f"{path}: not a video that can be read")


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
