"""Whatever befalls a film: its track is as right as it says, or it is refused in one line."""

import dataclasses

import cv2
import numpy as np
import pytest

from beltrepro.base.errors import InputError
from beltrepro.replication.camera import check_picture
from beltrepro.replication.camera.camera import Movement
from beltrepro.replication.camera.scene import Scene
from beltrepro.replication.camera.tracking import track
from optics import COMBINED, DISTURBANCES, NO_TAPE, Pose, Shot, chain_motion, film, pictures

FILMS = DISTURBANCES | COMBINED
HEIGHTS = (0.01, 0.005, -0.005, -0.01)  # metres of the tops of the blocks above the tape
# A film of these must be measured; others may be refused.
MEASURED = {
    "clean",
    "mirrored",
    "vignetted",
    "jpeg",
    "hands",
    "dropped",
    "cloth along 1",
    "roll -6 lights",
}
# What cannot be measured, and what is said of it.
REFUSED = {
    "tape 2 cm deeper": "by the tape the white block has",
    "zero hidden to a ten": "the chain moves before the first mark",
}


def judge(path, time, truth, **how):
    """Refusal in one line, or nothing where the track holds what it promises.

    99 of 100 frames are within three times the error that is told, or half a millimetre where that
    is more, and none is farther off than twice that.
    """
    try:
        tracked = track(path, **how)
    except InputError as refusal:
        assert str(path) in str(refusal)
        assert "\n" not in str(refusal)
        return str(refusal)
    frame = np.abs(tracked.time_s[:, np.newaxis] - time).argmin(axis=1)
    np.testing.assert_allclose(tracked.time_s, time[frame], atol=1e-3)
    assert len(frame) > 0.7 * len(time)
    error, x = np.abs(tracked.x_m - truth[frame]), truth[frame]
    share = error / np.maximum(3 * tracked.error_m, 0.5e-3)
    worst = f"{1e3 * error.max():.2f} mm, told {1e3 * np.median(tracked.error_m):.2f} mm"
    assert np.quantile(share, 0.99) < 1, worst
    assert share.max() < 2, worst
    r = tracked.x_m.std() / tracked.x_m.mean()
    assert r == pytest.approx(x.std() / x.mean(), rel=0.01)
    return None


def case(name):
    quick = name in ("clean", "along 1", "tape 2 cm deeper")
    mark = pytest.mark.thorough if name == "roll -6 lights" else pytest.mark.slow
    return pytest.param(name, marks=[] if quick else [mark])


@pytest.mark.parametrize("name", [case(name) for name in FILMS])
def test_a_disturbed_film_is_measured_as_well_as_it_says_or_refused(tmp_path, name):
    path = tmp_path / "film.mp4"
    # its tape is as high as the blocks, or too far off to be measured
    refusal = judge(path, *film(chain_motion(), path, FILMS[name]), tape_height_error=0.0)
    assert not (refusal and name in MEASURED), refusal
    assert REFUSED.get(name, "") in (refusal or "")


@pytest.mark.parametrize(
    "height", [pytest.param(z, marks=[] if z == 0.01 else [pytest.mark.slow]) for z in HEIGHTS]
)
def test_the_error_holds_a_tape_that_lies_a_little_too_high_or_deep(tmp_path, height):
    path = tmp_path / "film.mp4"
    assert judge(path, *film(chain_motion(), path, Shot(block_height=height))) is None


@pytest.mark.thorough
def test_without_a_tape_scale_and_zero_are_those_that_are_given(tmp_path):
    path = tmp_path / "film.mp4"
    time, truth = film(chain_motion(), path, NO_TAPE)
    with pytest.raises(InputError, match=r"no tape measure .*both the scale and the zero"):
        track(path)
    scale = NO_TAPE.metres_per_pixel
    left = NO_TAPE.aim[0] - scale * (NO_TAPE.width - 1) / 2  # the middle of the first pixel
    tracked = track(path, metres_per_pixel=scale, first_mark=left)
    np.testing.assert_allclose(tracked.time_s, time, atol=1e-3)
    np.testing.assert_allclose(tracked.x_m, truth, atol=0.3 * scale)
    assert np.isnan(tracked.scale_error) and np.isnan(tracked.zero_error_m)
    with pytest.raises(InputError, match="no tape measure found, so the zero is not known"):
        track(path, metres_per_pixel=scale)


# --- the films themselves -------------------------------------------------------------------------

FLAT = Scene(spring=28, support=28, tape=28, mark=28, block=28)  # on a belt of 28
IDEAL = Shot(blur=0, noise=0, unevenness=0, gamma=1, exposure=0, scene=FLAT)


def seen_at(pose, shot, x, y, z):
    """Column and row at which a pinhole shows a point, if its lens does not distort."""
    s, c = (
        np.sin([pose.along, pose.across, pose.roll]),
        np.cos([pose.along, pose.across, pose.roll]),
    )
    x, y, down = x - pose.x, y - pose.y, pose.height - z
    x, down = c[0] * x - s[0] * down, s[0] * x + c[0] * down  # undo one turn after the other
    y, down = c[1] * y - s[1] * down, s[1] * y + c[1] * down
    x, y = c[2] * x + s[2] * y, -s[2] * x + c[2] * y
    column, row = pose.focal * x / down, pose.focal * y / down / shot.aspect
    return column + shot.width / 2, row + shot.height / 2


@pytest.mark.parametrize(
    "change",
    [{}, {"along": 4.0}, {"across": -6.0}, {"along": -3.0, "across": 4.0, "roll": 5.0},
     {"along": 3.0, "block_height": 0.03}, {"aspect": 1.2, "roll": 3.0}],
)  # fmt: skip
def test_a_block_covers_the_pixels_between_the_images_of_its_corners(change):
    shot = dataclasses.replace(IDEAL, **change)
    pose, middle = Pose.of(shot, 0.0, None), 0.873
    still = Movement(np.zeros(1), np.array([[middle]]), np.zeros((1, 1)))
    light = next(pictures(still, shot))[1] - 28.0
    sides = [
        (middle + a, b) for a, b in ((0.02, 0.04), (0.02, -0.04), (-0.02, -0.04), (-0.02, 0.04))
    ]
    columns, rows = np.transpose([seen_at(pose, shot, x, y, shot.block_height) for x, y in sides])
    # area and centre of mass of a polygon, from its corners
    cross = columns * np.roll(rows, -1) - np.roll(columns, -1) * rows
    area = cross.sum() / 2
    centre = [((side + np.roll(side, -1)) * cross).sum() / (6 * area) for side in (columns, rows)]
    weight = light / light.sum()
    assert light.sum() / (235 - 28) == pytest.approx(abs(area), rel=3e-3)
    assert (np.arange(shot.width) + 0.5) @ weight.sum(axis=0) == pytest.approx(centre[0], abs=0.02)
    assert (np.arange(shot.height) + 0.5) @ weight.sum(axis=1) == pytest.approx(centre[1], abs=0.02)


def test_a_barrel_draws_the_ends_of_the_picture_inwards():
    still = Movement(np.zeros(1), np.array([[1.1]]), np.zeros((1, 1)))
    columns = []
    for barrel in (0.0, 0.02):
        shot = dataclasses.replace(IDEAL, barrel=barrel)
        light = (next(pictures(still, shot))[1] - 28.0).sum(axis=0)
        columns.append((np.arange(640) + 0.5) @ light / light.sum() - 320)
    straight, bent = columns
    assert straight == pytest.approx(bent * (1 + 0.02 * (bent / 320) ** 2), abs=0.05)


def test_the_blur_of_an_exposure_does_not_move_the_block():
    still = Movement(np.zeros(1), np.array([[0.8]]), np.array([[2.0]]))
    shot = dataclasses.replace(IDEAL, exposure=0.01)
    light = (next(pictures(still, shot))[1] - 28.0).sum(axis=0)
    places = np.arange(640) + 0.5
    mean = places @ light / light.sum()
    assert mean == pytest.approx(seen_at(Pose.of(shot, 0, None), shot, 0.8, 0, 0)[0], abs=0.02)
    # two boxes, of the block and of its way, have the sum of their variances
    variance = (0.04**2 + 0.02**2) / 12 / shot.metres_per_pixel**2
    assert (places - mean) ** 2 @ light / light.sum() == pytest.approx(variance, rel=0.02)


# --- the picture by which somebody sees it --------------------------------------------------------


def pixels_of(picture, colour):
    """Rows and columns of all pixels drawn in a colour (blue, green, red)."""
    return np.argwhere((np.abs(picture.astype(int) - colour) < 3).all(axis=-1)).T


@pytest.mark.parametrize("name", ["clean", pytest.param("mirrored", marks=pytest.mark.thorough)])
def test_the_check_picture_frames_the_block_and_shows_zero_and_marks(tmp_path, name):
    path = tmp_path / "film.mp4"
    _, truth = film(chain_motion(), path, FILMS[name])
    tracked = track(path)
    check_picture.write(tracked.survey, tmp_path / "check.png")
    picture = cv2.imread(str(tmp_path / "check.png"))
    enlarged = picture.shape[1] // tracked.survey.frame.shape[1]
    seen = picture[: enlarged * tracked.survey.frame.shape[0]]
    rows, columns = pixels_of(seen, check_picture._BLOCK)
    light = cv2.cvtColor(seen, cv2.COLOR_BGR2GRAY).astype(float)
    (top, bottom), (left, right) = ((np.min(v), np.max(v)) for v in (rows, columns))
    inside = light[top + 3 : bottom - 2, left + 3 : right - 2]
    beside = light[top:bottom, right + 6 : right + 12]
    assert inside.mean() > beside.mean() + 60 and np.median(inside) > 150
    scale = tracked.metres_per_pixel / enlarged
    assert (right - left) * scale == pytest.approx(0.04, abs=0.003)
    assert (bottom - top) * scale == pytest.approx(0.08, abs=0.004)
    zero = np.median(pixels_of(seen, check_picture._ZERO)[1])
    away = abs((left + right) / 2 - zero) * scale
    assert np.abs(truth - away).min() < 0.004  # where the block is in one of the frames
    marks = np.unique(pixels_of(seen, check_picture._MARK)[1])
    assert len(marks) > 0.9 * len(tracked.survey.measure.places)
