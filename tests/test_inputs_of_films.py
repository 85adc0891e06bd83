"""What people give to the commands: each input is measured right, or refused in one line."""

import json
import os
import time

import av
import cv2
import numpy as np
import pytest

from beltrepro import cli
from beltrepro.experiment import Camera, Scene
from beltrepro.experiment.camera import View, pictures
from beltrepro.experiment.tables import read_track
from beltrepro.experiment.video import Frame, write_video
from filming import FRAMES_PER_SECOND, swaying

MOVEMENT = swaying(2.0)
CAMERA = Camera(width=480, height=88)
SCALE = View.of(MOVEMENT, Scene(), CAMERA).metres_per_pixel
LEFT = View.of(MOVEMENT, Scene(), CAMERA).left
WHOLE = np.array([f.picture for f in pictures(MOVEMENT, camera=CAMERA)])
TRUE = MOVEMENT.x_m[:, -1]
SECONDS = 5.0  # in which a command must answer


def run(capsys, *words):
    """Exit status, and what the command wrote to stdout and stderr."""
    begin = time.process_time()
    try:
        status = cli.main([str(word) for word in words])
    except SystemExit as stop:  # argparse
        status = stop.code
    assert time.process_time() - begin < SECONDS
    return (status, *capsys.readouterr())


def refused(answer, path, words):
    """Check that the answer is one line that names the file and says `words`."""
    status, out, err = answer
    assert (status, out) == (2, ""), err
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert str(path) in err
    assert any(word in err for word in words.split("|")), err


def written(path, frames, times=None):
    """A film of some pictures."""
    times = np.arange(len(frames)) / FRAMES_PER_SECOND if times is None else times
    film = (Frame(t, np.ascontiguousarray(f)) for t, f in zip(times, frames, strict=True))
    write_video(path, film, frames_per_second=FRAMES_PER_SECOND)
    return path


def encoded(path, frames, codec, pixels, layout="gray", times=None, **options):
    """A film by any codec, with instants in whole frames."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=24, options=options)
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = pixels
        for number, picture in enumerate(frames):
            frame = av.VideoFrame.from_ndarray(picture, format=layout)
            frame.pts = number if times is None else times[number]
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def tracked(capsys, path, folder, *options):
    """The table of a film that is tracked: x in metres, and what the command told."""
    status, out, err = run(capsys, "track", path, "--output", folder / "a.csv", "--json", *options)
    assert status == 0, err
    (time_s, x_m, _), _ = read_track(folder / "a.csv")
    return time_s, x_m, json.loads(out)


# --- films that are measured right ----------------------------------------------------------------


def shaded(frames):
    """A lens that darkens the corners and shows a square as a trapezium, by a little."""
    height, width = frames[0].shape
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    moved = corners + np.array([[0, 0.2], [0, -0.2], [0, 0.2], [0, -0.2]], np.float32)
    tilt = cv2.getPerspectiveTransform(corners, moved)
    across, along = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    dark = 1 - 0.15 * (along**2 + across**2)
    return [
        (cv2.warpPerspective(f, tilt, (width, height), borderMode=1) * dark).astype(np.uint8)
        for f in frames
    ]


def covered(frames):
    """A hand over the block in some frames."""
    frames = frames.copy()
    frames[20:26, :60, 200:] = 150
    return frames


def tape_partly_hidden(frames):
    """Something dark on the tape."""
    frames = frames.copy()
    frames[:, 64:, 200:260] = 40
    return frames


RIGHT = {
    "as it is": lambda path: written(path, WHOLE),
    "upside down": lambda path: written(path, WHOLE[:, ::-1, ::-1]),
    "mirrored": lambda path: written(path, WHOLE[:, :, ::-1]),
    "upside down and mirrored": lambda path: written(path, WHOLE[:, ::-1]),
    "odd sizes": lambda path: encoded(path.with_suffix(".mkv"), WHOLE[:, :87, :479], "ffv1", "gray"),
    "hand": lambda path: written(path, covered(WHOLE)),
    "tape partly hidden": lambda path: written(path, tape_partly_hidden(WHOLE)),
    "vignetting and perspective": lambda path: written(path, shaded(WHOLE)),
    "gif": lambda path: encoded(path.with_suffix(".gif"), WHOLE, "gif", "gray"),
    "h265": lambda path: encoded(path, WHOLE, "libx265", "yuv420p", **{"x265-params": "log-level=none"}),
    "h265 10 bit": lambda path: encoded(
        path.with_suffix(".mov"), WHOLE, "libx265", "yuv420p10le", **{"x265-params": "log-level=none"}
    ),
    "vp9": lambda path: encoded(
        path.with_suffix(".webm"), WHOLE, "libvpx-vp9", "yuv420p", **{"cpu-used": "8", "deadline": "realtime", "crf": "20", "b": "0"}
    ),
    "mjpeg": lambda path: encoded(path.with_suffix(".avi"), WHOLE, "mjpeg", "yuvj420p", qmin="2", qmax="3"),
    "mpeg4": lambda path: encoded(path.with_suffix(".avi"), WHOLE, "mpeg4", "yuv420p", qmin="2", qmax="3"),
    "transport stream": lambda path: encoded(path.with_suffix(".ts"), WHOLE, "libx264", "yuv420p"),
}  # fmt: skip


@pytest.mark.parametrize("kind", RIGHT)
def test_films_that_are_measured_right(tmp_path, capsys, kind):
    path = RIGHT[kind](tmp_path / "film.mp4")
    time_s, x_m, told = tracked(capsys, path, tmp_path)
    assert len(x_m) >= len(TRUE) - 6
    # A gif tells instants in hundredths of a second.
    times = np.round(time_s * FRAMES_PER_SECOND) / FRAMES_PER_SECOND
    true = np.interp(times, MOVEMENT.time_s, TRUE)
    error = (x_m - true) / SCALE
    print(kind, error.mean(), error.std(), len(x_m), told["metres_per_pixel"] / SCALE - 1)
    assert abs(error.mean()) < 0.5
    assert error.std() < 0.3
    assert told["metres_per_pixel"] == pytest.approx(SCALE, rel=2e-3)
    assert x_m.std() / x_m.mean() == pytest.approx(true.std() / true.mean(), rel=5e-3)
