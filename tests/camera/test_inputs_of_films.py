"""What people give to the commands: each input is measured right, or refused in one line."""

import json
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from beltrepro.base.errors import InputError
from beltrepro.cli import app as cli
from beltrepro.replication.camera.camera import Framing, pictures
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.track_file import Track
from beltrepro.replication.camera.tracking import track
from beltrepro.replication.camera.video import Frame, write_video
from filming import FRAMES_PER_SECOND, swaying

MOVEMENT = swaying(2.0)
CAMERA = Camera(width=480, height=88)
SCALE = Framing.of(MOVEMENT, Scene(), CAMERA).metres_per_pixel
LEFT = Framing.of(MOVEMENT, Scene(), CAMERA).left
WHOLE = np.array([f.picture for f in pictures(MOVEMENT, camera=CAMERA)])
TRUE = MOVEMENT.x_m[:, -1]


def run(capsys, *words):
    """Exit status, and what the command wrote to stdout and stderr."""
    try:
        status = cli.main([str(word) for word in words])
    except SystemExit as stop:  # argparse
        status = stop.code
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


def encoded(path, frames, codec, pixels, *, layout="gray", container=None, **options):
    """A film by any codec."""
    with av.open(str(path), "w", options=container or {}) as container:
        stream = container.add_stream(codec, rate=24, options=options)
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = pixels
        for picture in frames:
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format=layout)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def tracked(capsys, path, folder, *options):
    """The table of a film that is tracked: x in metres, and what the command told."""
    output = ["--output", folder / "a.csv", "--force"]
    status, out, err = run(capsys, "track", path, *output, "--json", *options)
    assert status == 0, err
    table = Track.load(folder / "a.csv")
    return table.time_s, table.x_m, json.loads(out)


# --- films that are measured right ----------------------------------------------------------------


def painted(value, rows, columns):
    """The film with a rectangle of one brightness."""
    frames = WHOLE.copy()
    frames[:, rows, columns] = value
    return frames


ALL = slice(None)
BLOCKS = slice(60)  # rows; those of the tape follow
RIGHT = {
    "as it is": lambda path: written(path, WHOLE),
    "upside down": lambda path: written(path, WHOLE[:, ::-1, ::-1]),
    "upside down and mirrored": lambda path: written(path, WHOLE[:, ::-1]),
    "odd sizes": lambda p: encoded(p.with_suffix(".mkv"), WHOLE[:, :87, :479], "ffv1", "gray"),
    "colours": lambda p: encoded(p, [np.dstack([f, f, 0.9 * f]).astype(np.uint8) for f in WHOLE],
        "mpeg4", "yuv420p", layout="rgb24", qscale="2"),
    "gif": lambda path: encoded(path.with_suffix(".gif"), WHOLE, "gif", "gray"),
    "transparent": lambda p: encoded(p.with_suffix(".mov"),
        [np.dstack([f, f, f, f // 2]) for f in WHOLE], "png", "rgba", layout="rgba"),
    "16 bits": lambda p: encoded(
        p.with_suffix(".mkv"), WHOLE.astype(np.uint16) * 257, "ffv1", "gray16le", layout="gray16le"
    ),
    "transport stream": lambda p: encoded(p.with_suffix(".ts"), WHOLE, "libx264", "yuv420p"),
}  # fmt: skip


@pytest.mark.thorough
@pytest.mark.parametrize("kind", RIGHT)
def test_films_that_are_measured_right(tmp_path, capsys, kind):
    path = RIGHT[kind](tmp_path / "film.mp4")
    time_s, x_m, printed = tracked(capsys, path, tmp_path)
    assert len(x_m) >= len(TRUE) - 6
    # A gif tells instants in hundredths of a second.
    times = np.round(time_s * FRAMES_PER_SECOND) / FRAMES_PER_SECOND
    true = np.interp(times, MOVEMENT.time_s, TRUE)
    error = (x_m - true) / SCALE
    assert abs(error.mean()) < 0.5
    assert error.std() < 0.3
    assert printed["metres_per_pixel"] == pytest.approx(SCALE, rel=2e-3)
    assert x_m.std() / x_m.mean() == pytest.approx(true.std() / true.mean(), rel=5e-3)


# --- films that are not ---------------------------------------------------------------------------


def cut(path, share, *, index_first):
    """A film of which only the beginning was copied, with its index before or after the frames."""
    options = {"movflags": "faststart"} if index_first else {}
    encoded(path, WHOLE, "libx264", "yuv420p", container=options)
    whole = path.read_bytes()
    return kept(path, whole[: int(share * len(whole))])


# Springs as bright as the belt.
NO_SPRING = [f.picture for f in pictures(MOVEMENT, scene=Scene(spring=Scene().belt), camera=CAMERA)]


HUGE = np.zeros((1, 6000, 6000), np.uint8)


def packets(path, frames, times):
    """A film whose packets have the instants that are told, whatever they are."""
    path = path.with_suffix(".mkv")
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=24)
        stream.height, stream.width, stream.pix_fmt = 88, 480, "yuvj420p"
        for order, (picture, pts) in enumerate(zip(frames, times, strict=True)):
            encoder = av.CodecContext.create("mjpeg", "w")
            encoder.height, encoder.width = picture.shape
            encoder.pix_fmt, encoder.time_base = "yuvj420p", Fraction(1, 24)
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="gray")
            for packet in encoder.encode(frame) + encoder.encode():
                packet.stream, packet.time_base = stream, Fraction(1, 24)
                packet.pts, packet.dts = pts, min(order, pts)
                container.mux(packet)
    return path


def changing(path):
    """A film whose pictures get larger on the way."""
    frames = [*WHOLE[:4], *(np.tile(one, (2, 2)) for one in WHOLE[:4])]
    return packets(path, frames, range(8))


def backwards(path):
    """Instants that go back."""
    times = np.arange(len(WHOLE)) + 60
    times[20] = 70
    return packets(path, WHOLE, times.tolist())


def kept(path, content):
    """A file with some bytes."""
    path.write_bytes(content)
    return path


WRONG = {
    "missing": (lambda path: path, "no such file"),
    "a folder": (lambda path: path.parent, "directory"),
    "text": (lambda path: kept(path, b"time_s,x_m\n0,1\n"), "not a video"),
    "empty": (lambda path: kept(path, b""), "not a video"),
    "only the header": (lambda path: cut(path, 0.2, index_first=True), "no frame|not a video"),
    "broken off": (lambda path: cut(path, 0.6, index_first=False), "not a video"),
    "png": (lambda p: kept(p, cv2.imencode(".png", WHOLE[0])[1].tobytes()), "a single picture"),
    "one frame": (lambda path: written(path, WHOLE[:1]), "1 of the frames"),
    "black": (lambda path: written(path, np.zeros_like(WHOLE)), "no white block"),
    "tiny": (lambda path: written(path, np.full((12, 16, 16), 99, np.uint8)), "no white block"),
    "huge": (lambda p: encoded(p.with_suffix(".mkv"), HUGE, "ffv1", "gray"), "6000 x 6000"),
    "changing size": (changing, "another size"),
    "no white block": (
        lambda p: written(p, np.where(WHOLE > 215, np.uint8(10), WHOLE)), "film a white block"),
    "two white blocks": (
        lambda p: written(p, painted(235, slice(9, 61), slice(440, 466))), "2 white blocks"),
    "a hand all the time": (
        lambda p: written(p, painted(150, BLOCKS, slice(100, None))), "film a white block"),
    "no spring": (lambda path: written(path, NO_SPRING), "--support left or right"),
    "no tape": (lambda p: written(p, painted(28, slice(64, None), ALL)), "no tape measure"),
    "tape without its end": (lambda path: written(path, WHOLE[:, :, 60:]), "--first-mark"),
    "on its side": (lambda path: written(path, np.rot90(WHOLE, axes=(1, 2))), "left to right"),
    "time goes back": (backwards, "earlier than"),
}  # fmt: skip


@pytest.mark.thorough
@pytest.mark.parametrize("kind", WRONG)
def test_films_that_are_refused(tmp_path, capsys, kind):
    make, words = WRONG[kind]
    path = make(tmp_path / "film.mp4")
    refused(run(capsys, "track", path, "--output", tmp_path / "a.csv"), path, words)
    assert not (tmp_path / "a.csv").exists()


def test_a_film_that_breaks_off_is_measured_up_to_there(tmp_path, capsys):
    path = cut(tmp_path / "film.mp4", 0.7, index_first=True)
    _, x_m, _ = tracked(capsys, path, tmp_path)
    assert 12 <= len(x_m) < len(TRUE)
    np.testing.assert_allclose(x_m, TRUE[: len(x_m)], atol=0.3 * SCALE)


def test_a_block_that_leaves_the_picture_is_told(tmp_path, capsys):
    edge = int(LEFT + np.quantile(TRUE, 0.7) / SCALE) + 14
    frames = WHOLE[:, :, : edge - edge % 2]
    time_s, x_m, printed = tracked(capsys, written(tmp_path / "film.mp4", frames), tmp_path)
    np.testing.assert_allclose(x_m, np.interp(time_s, MOVEMENT.time_s, TRUE), atol=0.3 * SCALE)
    beyond = frames.shape[2] < LEFT + (TRUE + 0.02) / SCALE
    lost = np.zeros(len(TRUE), bool)
    for begin, end in printed["lost_s"]:
        lost |= (MOVEMENT.time_s > begin - 1e-3) & (MOVEMENT.time_s < end + 1e-3)
    assert lost[beyond].all()
    assert lost.sum() < beyond.sum() + 12


@pytest.mark.parametrize(
    "rows", [[0, 1], [0] * 30, None], ids=["two frames", "frozen", "repeated frames"]
)
def test_few_or_repeated_pictures_are_measured(tmp_path, capsys, rows):
    """Frames at one instant count once."""
    if rows is None:
        rows = list(range(len(WHOLE)))
        numbers = np.repeat(rows, [1 + (row % 7 == 0) for row in rows])
        path = packets(tmp_path / "film.mkv", WHOLE[numbers], numbers.tolist())
    else:
        path = written(tmp_path / "film.mp4", WHOLE[rows])
    _, x_m, _ = tracked(capsys, path, tmp_path)
    np.testing.assert_allclose(x_m, TRUE[rows], atol=0.3 * SCALE)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--scale=0"], "metres_per_pixel = 0: must be at least"),
        (["--scale=nan"], "metres_per_pixel = nan: a finite number"),
        (["--scale=0.12"], "metres_per_pixel = 0.12: must be at least 1e-06 and at most 0.1"),
        (["--scale=0.08"], "no white block"),
        (["--scale=8e-7"], "metres_per_pixel = 8e-07"),
        (["--first-mark=-5.5"], "first_mark = -5.5: must be at least -5 and at most 5"),
        (["--block-length=0"], "block_length = 0: must be greater than 0"),
        (["--output=film.mp4"], "must end in .csv"),
        (["--output=old.csv"], "--force overwrites it"),
        (["--support=up"], "left, right, auto"),
    ],
)
def test_options_of_track_that_are_refused(tmp_path, capsys, monkeypatch, options, words):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "film.mp4", WHOLE[:12])
    (tmp_path / "old.csv").write_text("old\n")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    refused(run(capsys, "track", "film.mp4", "--output=a.csv", *options), "", words)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


# --- tables ---------------------------------------------------------------------------------------

TIMES = np.arange(80) / 24
PLACES = 0.8 + 0.01 * (np.arange(80) % 9)


def table(time_s=TIMES, x_m=PLACES, header="time_s,x_m"):
    """The text of a recording."""
    rows = (f"{t},{x}" for t, x in zip(time_s, x_m, strict=True))
    return "\n".join([header, *rows]) + "\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "no such file"),
        ("", "lacks the column time_s, x_m"),
        (table(header="t,x"), "lacks the column time_s, x_m; its first line is 't,x'"),
        (table([], []), "has no rows"),
        (table(x_m=["fast", *PLACES[1:]]), "'fast' is not a number"),
        (table(x_m=['"0,9"', *PLACES[1:]]), "x_m: '0,9' is not a number"),
        (table(x_m=["nan", *PLACES[1:]]), "x_m in row 1 is not a finite number"),
        (table([*TIMES[1:], "inf"]), "time_s in row 80 is not a finite number"),
        (table([*TIMES[1:], 5e5]), "row 80 is 5e+05 s later than in the row before"),
        (table() + "9\n", "row 81 has 1 values, 2 are needed"),
        ("time_s,x_m,x_m\n0,1,2\n", "2 columns x_m"),
        ("time_s,x_m,error_m\n0,1,1\n1,1,-1\n", "error_m in row 2 is less than 0"),
        ('# {"scale_error": "x"}\n' + table(), "its first line has scale_error = 'x'"),
        ('# {"lost_s": [[[1]]]}\n' + table(), "its first line has lost_s"),
        ("time_s,x_m\n\0\0\0", "not a number|values"),
        (table(TIMES[:1], PLACES[:1]), "1 sample"),
        (table(np.repeat(TIMES[::2], 2)), "time_s in row 2 is not later"),
        (table(x_m=[-0.1, *PLACES[1:]]), "measured from the support"),
        (table(x_m=100 * PLACES), "become metres"),
        (b"\x89PNG\r\n\xff\xfe", "not a text file"),
    ],
)
def test_tables_that_are_refused(tmp_path, capsys, text, words):
    path = tmp_path / "a.csv"
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    refused(run(capsys, "analyse", path), path, words)


# --- what is written ------------------------------------------------------------------------------


FILM = ("film", "--output=a.mp4")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("film", "--output=a.txt"), "must end in"),
        (("watch", "--output=a.txt"), "must end in"),
        (("film", "--output=no/such/folder/a.mp4"), "folder"),
        (("watch", "--output=/proc/a.mp4"), "/proc/a.mp4"),
        (("watch", "--output=a.mp4", "--transient=-1"), "transient"),
        ((*FILM, "--duration=nan"), "duration"),
        ((*FILM, "--width=33"), "width = 33: must be an even number"),
        ((*FILM, "--metres-per-pixel=1e-5"), "take a larger"),
        ((*FILM, "--transient=50"), "transient = 50"),
    ],
)
def test_films_that_are_not_made(tmp_path, capsys, monkeypatch, options, words):
    monkeypatch.chdir(tmp_path)
    chain = ["--n-blocks=2", "--belt-velocity=15", "--duration=5"]
    refused(run(capsys, options[0], *chain, *options[1:]), "", words)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("path", [None, 5, "a\0b"])
def test_a_path_that_is_none_is_refused(path):
    for function in (track, Track.load):
        with pytest.raises(InputError, match="the path of a file is needed"):
            function(path)
