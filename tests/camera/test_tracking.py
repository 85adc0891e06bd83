"""Tracking: places to parts of a pixel, in films of the package and of another renderer."""

import functools
import math

import cv2
import numpy as np
import pytest

from beltrepro.base.errors import InputError
from beltrepro.replication.camera import tape, tracking
from beltrepro.replication.camera.camera import Framing, film
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.video import Frame, read_video, write_video
from filming import swaying

# the tapes of all renderers here are as high as the blocks
track = functools.partial(tracking.track, tape_height_error=0.0)

CLEAN = Camera(blur=0, sensor_noise=0, light_unevenness=0, light_drift=0, compression=10)
POOR = Camera(
    blur=1.2, sensor_noise=6, light_unevenness=0.3, light_drift=0.3, dropped=0.02, angle=1.5
)


def scale_of(movement, camera=None, scene=None):
    """Metres per pixel."""
    return Framing.of(movement, scene or Scene(), camera or Camera()).metres_per_pixel


def errors(tracked, movement, scale):
    """Errors of a track in pixels, at the frames it has."""
    frame = np.searchsorted(movement.time_s, tracked.time_s - 1e-3)
    np.testing.assert_allclose(movement.time_s[frame], tracked.time_s, atol=1e-3)
    return (tracked.x_m - movement.x_m[frame, -1]) / scale


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def filmed(movement, path, **how):
    """The frames of a film, read again."""
    film(movement, path, **how)
    return list(read_video(path))


def tracked_again(frames, path, change=lambda picture: picture, **how):
    """The track of a film of changed pictures at the instants of these frames."""
    changed = [Frame(time_s, np.ascontiguousarray(change(picture))) for time_s, picture in frames]
    write_video(path, changed, frames_per_second=24)
    return track(path, **how)


@pytest.mark.parametrize(("camera", "limit"), [(CLEAN, 0.2), (Camera(), 0.2), (POOR, 1.0)])
def test_the_block_is_placed_to_parts_of_a_pixel(tmp_path, camera, limit):
    movement = swaying(4.0)
    film(movement, tmp_path / "film.mp4", camera=camera)
    tracked, scale = track(tmp_path / "film.mp4"), scale_of(movement, camera)
    error = errors(tracked, movement, scale)
    assert rms(error) < limit
    assert len(tracked.time_s) > 0.9 * len(movement.time_s)
    assert tracked.metres_per_pixel == pytest.approx(scale, rel=2e-3)
    assert tracked.angle == pytest.approx(camera.angle, abs=0.1)
    # The error told is that of the scatter about the mean, within a factor of three.
    assert rms(error - error.mean()) < 3 * np.median(tracked.error_m) / scale
    assert np.median(tracked.error_m) / scale < 0.2
    x = movement.x_m[np.rint(tracked.time_s * 24).astype(int), -1]
    r = tracked.x_m.std() / tracked.x_m.mean()
    assert r == pytest.approx(x.std() / x.mean(), rel=0.01)


@pytest.mark.parametrize(
    "scene",
    [
        Scene(tape=30, mark=240, belt=30),  # bright marks on a dark tape
        Scene(belt=160, block=30, white_block=250, tape=230),  # a bright belt
        Scene(belt=90, block=60, white_block=170, tape=150, mark=80, spring=110),  # little contrast
        Scene(white_block=255, tape=255, spring=250),  # springs as bright as the block
        Scene(mark_spacing=0.0127),  # marks at another distance
        Scene(mark_spacing=0.0085),
    ],
)
def test_other_colours_and_tapes(tmp_path, scene):
    movement, options = swaying(0.6), {}
    film(movement, tmp_path / "film.mp4", scene=scene)
    if scene.mark_spacing != Scene().mark_spacing:
        with pytest.raises(InputError, match=r"block has .* cm, and not 4 x 8: .*--mark-spac"):
            track(tmp_path / "film.mp4")
        options = {"scene": scene}
    tracked = track(tmp_path / "film.mp4", **options)
    assert len(tracked.time_s) == len(movement.time_s)
    assert rms(errors(tracked, movement, scale_of(movement, scene=scene))) < 0.3


def test_a_film_that_a_phone_has_marked_as_turned(tmp_path):
    movement = swaying(0.6)
    frames = filmed(movement, tmp_path / "film.mp4")
    path = tmp_path / "upright.mp4"
    with pytest.raises(InputError, match="left to right"):
        tracked_again(frames, path, np.rot90)
    # The matrix of the track header: turn by a quarter, clockwise, to show it.
    content = bytearray(path.read_bytes())
    place = content.index(b"tkhd") + 4 + 40
    assert content[place : place + 4] == (1 << 16).to_bytes(4)  # the unit matrix
    matrix = np.array([0, 1 << 16, 0, -(1 << 16), 0, 0, 0, 0, 1 << 30], ">i4")
    content[place : place + 36] = matrix.tobytes()
    path.write_bytes(content)
    assert rms(errors(track(path), movement, scale_of(movement))) < 0.3


def test_cropped_and_turned_films(tmp_path):
    movement = swaying(1.5)
    frames = filmed(movement, tmp_path / "film.mp4")
    view = Framing.of(movement, Scene(), Camera())
    # The first 120 pixels are cut off: the first mark that is left reads something else.
    cut = math.ceil((120 - view.left) * view.metres_per_pixel / 0.01) * 0.01
    for part, how in (
        ((slice(4, 92), slice(120, None)), {"first_mark": cut}),
        ((slice(None, None, -1), slice(None, None, -1)), {"support": "right"}),
    ):
        tracked = tracked_again(frames, tmp_path / "part.mp4", lambda p, part=part: p[part], **how)
        assert rms(errors(tracked, movement, view.metres_per_pixel)) < 0.3


def test_frames_at_uneven_instants_keep_them(tmp_path):
    movement = swaying(2.0, frames_per_second=60.0)
    chosen = np.sort(np.random.default_rng(5).choice(120, 60, replace=False))
    camera = Camera(frames_per_second=60)
    frames = filmed(movement, tmp_path / "all.mp4", camera=camera)
    write_video(tmp_path / "some.mp4", [frames[row] for row in chosen], frames_per_second=30)
    tracked = track(tmp_path / "some.mp4")
    time = movement.time_s[chosen] - movement.time_s[chosen[0]]
    np.testing.assert_allclose(tracked.time_s, time, atol=1e-3)
    error = (tracked.x_m - movement.x_m[chosen, -1]) / scale_of(movement, camera)
    assert rms(error) < 0.2


def test_a_hand_in_the_picture_is_told_with_its_instants(tmp_path):
    movement = swaying(3.0)
    frames = filmed(movement, tmp_path / "film.mp4")
    for _, picture in frames[30:42]:  # comes from above and covers half of the blocks' lane
        cv2.ellipse(picture, (380, 10), (300, 45), 0, 0, 360, 150, -1)
    tracked = tracked_again(frames, tmp_path / "hand.mp4")
    np.testing.assert_allclose(tracked.lost_s, [[30 / 24, 41 / 24]], atol=1e-3)
    assert len(tracked.time_s) == len(frames) - 12
    assert rms(errors(tracked, movement, scale_of(movement))) < 0.2


def test_a_glare_that_the_block_passes_is_not_taken_for_a_spring(tmp_path):
    movement, scene = swaying(8.0), Scene(white_block=200)
    camera = Camera(metres_per_pixel=0.0012)
    frames = filmed(movement, tmp_path / "film.mp4", scene=scene, camera=camera)
    left = Framing.of(movement, scene, camera).left
    spot = round(left + 0.56 / 0.0012), frames[0].picture.shape[0] // 2 - 10
    for _, picture in frames:
        cv2.circle(picture, spot, 12, 255, -1)
    tracked = tracked_again(frames, tmp_path / "glare.mp4")
    assert len(tracked.time_s) > 0.6 * len(frames)
    assert np.median(np.abs(errors(tracked, movement, 0.0012))) < 0.2


def test_a_given_scale_counts(tmp_path):
    movement = swaying(1.0)
    film(movement, tmp_path / "film.mp4")
    scale = 1.02 * scale_of(movement)
    tracked = track(tmp_path / "film.mp4", metres_per_pixel=scale)
    assert tracked.metres_per_pixel == pytest.approx(scale)
    assert tracked.x_m.mean() == pytest.approx(1.02 * movement.x_m[:, -1].mean(), rel=1e-3)


def test_a_track_is_kept_in_a_table(tmp_path):
    film(swaying(1.0), tmp_path / "film.mp4")
    tracked = track(tmp_path / "film.mp4")
    tracked.save(tmp_path / "track.csv")
    again = type(tracked).load(tmp_path / "track.csv")
    for name in ("time_s", "x_m", "error_m"):
        np.testing.assert_allclose(getattr(again, name), getattr(tracked, name), rtol=1e-8)
    assert (again.metres_per_pixel, again.angle) == (tracked.metres_per_pixel, tracked.angle)
    assert again.lost_s.shape == (0, 2) and again.survey is None


def test_a_tape_of_doubtful_height_makes_scale_and_zero_doubtful(tmp_path):
    """About the middle of the picture, from a camera 0.8 widths of the picture away."""
    movement, height = swaying(0.5), 0.0035
    film(movement, tmp_path / "film.mp4")
    sure = track(tmp_path / "film.mp4")
    doubtful = track(tmp_path / "film.mp4", tape_height_error=height)
    view = Framing.of(movement, Scene(), Camera())
    middle = (view.width / 2 - view.left) * view.metres_per_pixel
    more = [
        math.sqrt(getattr(doubtful, name) ** 2 - getattr(sure, name) ** 2)
        for name in ("scale_error", "zero_error_m")
    ]
    off = height / (0.8 * view.width * view.metres_per_pixel)
    assert more == pytest.approx([off, off * middle], rel=0.01)


@pytest.mark.parametrize(
    ("long", "expected"), [((10, 10), (3, 10)), ((10, 8), (3, 5)), ((4, 4), None)]
)
def test_long_marks_tell_tens_or_fives(long, expected):
    """Marks of 4 pixels, in which every tenth and every fifth have these lengths."""
    numbers = np.arange(60)
    picture = np.full((30, 600), 200.0)
    for number in numbers:
        length = long[0] if number % 10 == 3 else 4
        if long[1] != long[0] and number % 10 == 8:
            length = long[1]
        picture[10 : 10 + length, 10 * number + 5] = 20.0
    rows, places = slice(10, 14), 10.0 * numbers + 5
    assert tape._long_marks(picture, rows, places, numbers, 10.0) == expected
