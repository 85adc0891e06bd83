"""Video files: frames with their instants, in and out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import av
import numpy as np
from av.video.reformatter import ColorRange

from beltrepro.base import checks, reading
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError

SUFFIXES = (".mp4", ".mov", ".mkv")
LARGEST = 7680 * 4320  # pixels of a frame that is read
# Instants are multiples of this: the common frame rates (24, 25, 30, 50, 60) are exact in it.
_TICK = Fraction(1, 90_000)
# What every player shows: brightness, and colours at half as many points along each side.
_PIXELS, _NO_COLOUR = "yuv420p", 128
# Formats whose first plane is the brightness as it is; most videos have one of them.
_BRIGHTNESS_FIRST = (
    *("gray", "nv12", "nv21", "yuv420p", "yuv422p", "yuv444p"),
    *("yuvj420p", "yuvj422p", "yuvj444p"),
)
_PICTURES = ("image2", "png_pipe", "jpeg_pipe", "tiff_pipe", "bmp_pipe", "webp_pipe")


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
    with replacing(path) as part:
        with av.open(str(part), "w") as container:
            for time_s, picture in frames:
                frame = _to_be_written(picture)
                if stream is None:
                    rate = Fraction(frames_per_second).limit_denominator(1001)  # as containers do
                    stream = container.add_stream("libx264", rate=rate)
                    stream.height, stream.width = picture.shape[:2]
                    stream.pix_fmt = _PIXELS
                    stream.codec_context.time_base = _TICK
                    stream.codec_context.color_range = frame.color_range
                    stream.options = {"crf": str(compression), "preset": preset}
                frame.pts, frame.time_base = round(time_s / _TICK), _TICK
                container.mux(stream.encode(frame))
                count += 1
            if stream is not None:
                container.mux(stream.encode())
        if not count:
            raise InputError(f"{path}: no frame to write")
    return count


def read_video(path: str | Path) -> Iterator[Frame]:
    """Read the frames of a video one by one, as the camera meant them to be seen.

    Colours become brightness, 16 bits become 8, and a picture that a phone marks as turned is
    turned. A video that breaks off ends there. Of frames of the same instant the first counts.
    """
    path = checks.path("video", path)
    reading.check(path)
    try:
        with av.open(str(path)) as container:
            yield from _decode(container, path)
    except av.FFmpegError:
        raise InputError(f"{path}: not a video that can be read") from None


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


def _decode(container: Any, path: Path) -> Iterator[Frame]:
    """The frames of an open file."""
    if not container.streams.video:
        raise InputError(f"{path}: holds no video, only sound or text")
    if container.format.name in _PICTURES:
        raise InputError(f"{path}: a single picture, not a video")
    stream = container.streams.video[0]
    _check_size(path, stream)  # before a picture is decoded
    stream.thread_type = "AUTO"
    rate = float(stream.average_rate or stream.guessed_rate or 0)
    first = last = shape = None
    for index, frame in enumerate(_whole_frames(container, stream)):
        _check_size(path, frame)
        time_s = frame.time if frame.time is not None else index / rate if rate else float(index)
        picture = np.rot90(_brightness(frame), round(frame.rotation / 90))
        if last is not None and time_s < last:
            raise InputError(
                f"{path}: frame {index + 1} is earlier than the one before: write the film anew, "
                f"for instance with ffmpeg"
            )
        if time_s == last:
            continue  # the same picture, shown once more
        first, last = time_s if first is None else first, time_s
        shape = picture.shape if shape is None else shape
        if picture.shape != shape:
            raise InputError(f"{path}: frame {index + 1} has another size than the first")
        yield Frame(time_s - first, np.ascontiguousarray(picture))
    if first is None:
        raise InputError(f"{path}: holds no frame that can be read")


def _check_size(path: Path, seen: Any) -> None:
    """Refuse pictures too large for the memory: of a frame, or as the file announces them."""
    if seen.width * seen.height > LARGEST:
        raise InputError(
            f"{path}: frames of {seen.width} x {seen.height} pixels; allowed are "
            f"{LARGEST / 1e6:.0f} million pixels"
        )


def _brightness(frame: av.VideoFrame) -> np.ndarray:
    """Brightness (H, W) of a frame, 8 bit."""
    if frame.format.name not in _BRIGHTNESS_FIRST:
        return frame.to_ndarray(format="gray")
    plane: Any = frame.planes[0]
    rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
    return rows[: frame.height, : frame.width]


def _whole_frames(container: Any, stream: Any) -> Iterator[av.VideoFrame]:
    """Frames until the end, or until the file breaks off."""
    with suppress(av.FFmpegError):
        yield from container.decode(stream)
