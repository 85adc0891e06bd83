"""Tracking at a known scale: places to parts of a pixel, lost frames, refusals in one line."""

import warnings
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from beltrepro.base.errors import InputError
from beltrepro.cli import app as cli
from beltrepro.replication.camera.camera import Framing, film, pictures
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.track import Track, track
from beltrepro.replication.camera.video import Frame, write_video
from recorded import RATE, swaying

MOVEMENT = swaying(4.0)
TRUE = MOVEMENT.x_m[:, -1]
CLEAN = {"blur": 0, "sensor_noise": 0, "light_unevenness": 0, "light_drift": 0, "compression": 0}
WORKFLOW = {"blur": 0.8, "sensor_noise": 3, "light_unevenness": 0.3, "light_drift": 0.2}
WORKFLOW |= {"angle": 0.7, "dropped": 0.01, "compression": 26}
CAMERA = Camera(metres_per_pixel=0.0021, width=400, height=80)
VIEW = Framing.of(MOVEMENT, Scene(), CAMERA)
KNOWN = {"scale": VIEW.metres_per_pixel, "zero": VIEW.zero[0]}
WHOLE = [frame.picture for frame in pictures(MOVEMENT, camera=CAMERA)]


def written(path, frames):
    """A film of some pictures; None for one that is not there."""
    whole = ((k / RATE, np.ascontiguousarray(p)) for k, p in enumerate(frames) if p is not None)
    frames = (Frame(*frame) for frame in whole)
    write_video(path, frames, frames_per_second=RATE)
    return path


def errors(tracked):
    """Errors in pixels of the frames that were found."""
    frame = np.rint(tracked.time_s * RATE).astype(int)
    np.testing.assert_allclose(MOVEMENT.time_s[frame], tracked.time_s, atol=1e-3)
    return (tracked.x_m - TRUE[frame]) / tracked.metres_per_pixel


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


@pytest.mark.parametrize(
    ("settings", "limit"),
    [
        (CLEAN | {"exposure": 0}, 0.005),
        (CLEAN | {"exposure": 1 / 24}, 0.1),
        ({"blur": 1.2, "sensor_noise": 6, "light_unevenness": 0.3, "angle": -9.0}, 0.1),
        (WORKFLOW | {"compression": 38}, 0.2),
    ],
)
def test_the_block_is_placed_to_parts_of_a_pixel(tmp_path, settings, limit):
    camera = Camera(metres_per_pixel=0.0021, width=400, height=160, **settings)
    view = Framing.of(MOVEMENT, Scene(), camera)
    count = film(MOVEMENT, tmp_path / "film.mp4", camera=camera)
    tracked = track(tmp_path / "film.mp4", scale=view.metres_per_pixel, zero=view.zero[0])
    error = errors(tracked)
    assert len(error) == count and not tracked.lost_s.size
    assert rms(error) < limit
    assert tracked.angle == pytest.approx(camera.angle, abs=0.2)
    assert tracked.zero == pytest.approx(view.zero, abs=1.0)


def test_all_of_a_turned_belt_fits_into_the_picture(tmp_path):
    movement, camera = swaying(2.0, n_blocks=1, farthest=0.25), Camera(angle=4)
    view = Framing.of(movement, Scene(), camera)
    film(movement, tmp_path / "film.mp4", camera=camera)
    tracked = track(tmp_path / "film.mp4", scale=view.metres_per_pixel, zero=view.zero[0])
    assert tracked.angle == pytest.approx(4, abs=0.1) and not tracked.lost_s.size
    assert rms((tracked.x_m - movement.x_m[:, -1]) / view.metres_per_pixel) < 0.1


def test_a_block_that_the_edge_of_the_picture_cuts_is_not_seen(tmp_path):
    top = int(np.flatnonzero(WHOLE[0].max(axis=1) > 150)[0])  # of blocks of 38 pixels
    dark = np.zeros_like(WHOLE[0])
    above = [np.vstack([picture[top + 4 :], dark[: top + 4]]) for picture in WHOLE]
    below = [np.vstack([dark[top + 34 :], picture[: top + 34]]) for picture in WHOLE]
    for side, frames in {"above": above, "below": below}.items():
        with pytest.raises(InputError, match="away from the edges of the picture"):
            track(written(tmp_path / f"{side}.mp4", frames), **KNOWN)
    with pytest.warns(UserWarning, match="no block in 10 of 96 frames"):
        track(written(tmp_path / "few.mp4", above[:10] + WHOLE[10:]), **KNOWN)


def test_scale_zero_and_support_are_those_that_are_given(tmp_path):
    path = written(tmp_path / "film.mp4", WHOLE)
    tracked = track(path, **KNOWN)
    other = track(path, scale=2 * KNOWN["scale"] / 1.9, zero=KNOWN["zero"] + 10)
    np.testing.assert_allclose(other.x_m, (tracked.x_m - 10 * KNOWN["scale"]) * 2 / 1.9, rtol=1e-3)
    turned = written(tmp_path / "turned.mp4", [picture[::-1, ::-1] for picture in WHOLE])
    zero = CAMERA.width - 1 - KNOWN["zero"]
    upside_down = track(turned, scale=KNOWN["scale"], zero=zero, support="right")
    np.testing.assert_allclose(upside_down.x_m, tracked.x_m, atol=0.1 * KNOWN["scale"])
    with pytest.raises(InputError, match=r"on the side of the support, .* --support"):
        track(turned, scale=KNOWN["scale"], zero=zero)


def test_frames_without_the_block_are_lost_and_told(tmp_path):
    frames = [picture.copy() for picture in WHOLE]
    for picture in frames[30:42]:  # a hand from above, over half of the blocks' lane
        cv2.ellipse(picture, (300, 10), (200, 45), 0, 0, 360, 150, -1)
    frames[50][:] = 0
    frames[60:70] = [None] * 10
    frames[80:82] = [None] * 2  # too few to tell from a camera that is late
    with pytest.warns(UserWarning, match="no block in 13 of 84 frames"):
        tracked = track(written(tmp_path / "film.mp4", frames), **KNOWN)
    times = [[30, 41], [50, 50], [60, 69]]
    np.testing.assert_allclose(tracked.lost_s, np.array(times) / RATE, atol=1e-3)
    assert len(tracked.time_s) == len(frames) - 25
    assert rms(errors(tracked)) < 0.1
    few = [picture * (number not in range(30, 34)) for number, picture in enumerate(WHOLE)]
    with warnings.catch_warnings(action="error"):
        assert track(written(tmp_path / "few.mp4", few), **KNOWN).lost_s.shape == (1, 2)


def test_pixels_that_players_stretch_are_told(tmp_path):
    written(tmp_path / "a.mp4", WHOLE[:30])
    with av.open(str(tmp_path / "a.mp4")) as film, av.open(str(tmp_path / "b.mp4"), "w") as wide:
        stream = wide.add_stream("libx264", rate=24, width=400, height=80, pix_fmt="yuv420p")
        stream.codec_context.sample_aspect_ratio = Fraction(4, 3)
        for frame in film.decode(video=0):
            wide.mux(stream.encode(frame))
        wide.mux(stream.encode())
    with pytest.warns(UserWarning, match=r"its pixels are 1\.333 times as wide as high"):
        track(tmp_path / "b.mp4", **KNOWN)


def copied(path, other, lost=()):
    """The film in another file, without some of its packets."""
    with av.open(str(path)) as film, av.open(str(other), "w") as copy:
        stream = copy.add_stream_from_template(film.streams.video[0])
        for number, packet in enumerate(film.demux(video=0)):
            if packet.dts is not None and number not in lost:
                packet.stream = stream
                copy.mux(packet)
    return other


def test_packets_that_a_file_lost_and_films_that_were_joined_are_told(tmp_path):
    path = written(tmp_path / "a.mp4", WHOLE)
    with pytest.warns(UserWarning, match="frames are missing 1 times, first at 1.62 s; if the"):
        track(copied(path, tmp_path / "b.mp4", range(40, 50)), **KNOWN)
    twice = tmp_path / "c.ts"
    twice.write_bytes(2 * copied(path, tmp_path / "d.ts").read_bytes())
    with pytest.warns(UserWarning, match="9. frames that are no later than others left out"):
        track(twice, **KNOWN)
    later = ((k / RATE, picture[:60, :300]) for k, picture in enumerate(WHOLE, start=120))
    frames = (Frame(time_s, np.ascontiguousarray(picture)) for time_s, picture in later)
    write_video(tmp_path / "e.mp4", frames, frames_per_second=RATE)
    twice.write_bytes(
        (tmp_path / "d.ts").read_bytes()
        + copied(tmp_path / "e.mp4", tmp_path / "f.ts").read_bytes()
    )
    with pytest.raises(InputError, match="pictures have another size from "):
        track(twice, **KNOWN)


@pytest.mark.parametrize(
    ("suffix", "damage", "words"),
    [
        (
            "mkv",
            lambda film: film[: int(0.7 * len(film))],
            r"damaged or cut: it ends at 2\.\d+ s of 4",
        ),
        (
            "mp4",
            lambda film: _zeroed(film, 3000),
            r"damaged; frames left out: \d\d of 8\d, from 1\.96 s on",
        ),
        (
            "mkv",
            lambda film: _zeroed(film, 10),
            r"damaged; frames left out: \d\d of 96, from 1\.96 s on",
        ),
    ],
)
def test_of_a_damaged_film_the_whole_frames_are_measured_and_the_others_told(
    tmp_path, suffix, damage, words
):
    path = written(tmp_path / f"film.{suffix}", WHOLE)
    path.write_bytes(damage(path.read_bytes()))
    with pytest.warns(UserWarning, match=words) as caught:
        tracked = track(path, **KNOWN)
    assert len(caught) == 1 and rms(errors(tracked)) < 0.1
    assert 40 < len(tracked.time_s) < 80


def _zeroed(film, size):
    """A film whose bytes in the middle are lost."""
    middle = len(film) // 2
    return film[:middle] + bytes(size) + film[middle + size :]


def test_a_resting_block_is_placed_and_a_picture_that_stands_still_told(tmp_path):
    with pytest.warns(UserWarning, match=r"stands still from 0 s for 1\.21 s"):
        resting = track(written(tmp_path / "rest.mp4", WHOLE[:1] * 30), **KNOWN)
    assert resting.x_m == pytest.approx(np.full(30, TRUE[0]), abs=0.1 * KNOWN["scale"])
    frozen = [[*WHOLE[:40], *[WHOLE[40]] * number, *WHOLE[41:]] for number in (10, 15)]
    track(written(tmp_path / "short.mp4", frozen[0]), **KNOWN)  # for 0.375 s, where 0.5 is told
    with pytest.warns(UserWarning, match=r"stands still from 1\.67 s for 0\.583 s"):
        track(written(tmp_path / "long.mp4", frozen[1]), **KNOWN)
    twice = [picture for picture in WHOLE[::2] for _ in range(2)]
    with pytest.warns(UserWarning, match="46 of 96 pictures come again: the camera took fewer"):
        track(written(tmp_path / "twice.mp4", twice), **KNOWN)
    sixth = [WHOLE[k - (k % 6 == 1)] for k in range(len(WHOLE))]
    with pytest.warns(UserWarning, match="of 96 pictures come again"):
        track(written(tmp_path / "sixth.mp4", sixth), **KNOWN)
    seldom = [WHOLE[k - (k % 12 == 1)] for k in range(len(WHOLE))]
    with warnings.catch_warnings(action="error"):
        track(written(tmp_path / "seldom.mp4", seldom), **KNOWN)


# --- refusals -------------------------------------------------------------------------------------


def painted(columns):
    """The film with a second white block."""
    frames = [picture.copy() for picture in WHOLE]
    for picture in frames:
        picture[13:51, columns] = 235
    return frames


BLACK = Scene(white_block=Scene().block)
NO_BLOCK = [frame.picture for frame in pictures(MOVEMENT, scene=BLACK, camera=CAMERA)]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda path: path, "no such file"),
        (lambda path: path.write_bytes(b"time_s,x_m\n0,1\n") and path, "not a video"),
        (lambda path: written(path, NO_BLOCK), "half of them are needed"),
        (lambda path: written(path, painted(slice(20, 39))), "two white things"),
    ],
)
def test_films_that_are_refused(tmp_path, make, words):
    path = make(tmp_path / "film.mp4")
    with pytest.raises(InputError, match=words) as caught:
        track(path, **KNOWN)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


# --- tables ---------------------------------------------------------------------------------------

HEADER = "time_s,x_m\n"
ROWS = "".join(f"{row / 24},{0.8 + 0.01 * (row % 9)}\n" for row in range(60))


def test_a_track_is_kept_in_a_table(tmp_path):
    lost_s = np.array([[1.5, 2.0]])
    tracked = Track(np.arange(3.0), np.array([0.7, 0.8, 0.75]), lost_s, 0.0021, (13.9, 27.4), 0.7)
    tracked.save(tmp_path / "track.csv")
    again = Track.load(tmp_path / "track.csv")
    for name in ("time_s", "x_m", "lost_s"):
        np.testing.assert_array_equal(getattr(again, name), getattr(tracked, name))
    assert (again.metres_per_pixel, again.zero, again.angle) == (0.0021, (13.9, 27.4), 0.7)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t,x\n0,1\n", "lacks the column time_s, x_m"),
        (HEADER + "0,0,0,8\n" * 60, "more cells than its header: 0,5 is 0.5"),
        ("time_s,x_m,x_m\n0,1,2\n", "has the column x_m twice"),
        (HEADER + "0,fast\n", "row 1 has no finite number in time_s or x_m: 0, fast"),
        (HEADER + "0,True\n", "row 1 has no finite number in time_s or x_m: 0, True"),
        (HEADER + "0,0.#5\n", "row 1 has no finite number in time_s or x_m: 0, 0.#5"),
        (HEADER + "0,0.8\n1,0.8\n", "32 are needed"),
        (HEADER + "".join(f"{row},90\n" for row in range(60)), "centimetres"),
        (HEADER + ROWS + "1e9,1\n", "too far apart"),
        (HEADER + "0,0.8\n" * 60, "must rise"),
        (HEADER + "0,-0.8\n" + ROWS.partition("\n")[2], "measured from the support"),
    ],
)
def test_tables_that_are_refused(tmp_path, capsys, text, words):
    path = tmp_path / "a.csv"
    path.write_text(text)
    assert cli.main(["analyse", str(path)]) == 2
    out, err = capsys.readouterr()
    assert not out and words in err and str(path) in err and err.count("\n") == 1
