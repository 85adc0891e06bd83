"""The virtual camera: exact coverage, light, lens and noise; films have their instants."""

import numpy as np
import pytest

from beltrepro import ChainParameters, simulate
from beltrepro.base.errors import InputError
from beltrepro.model.units import TIME_S
from beltrepro.replication.camera import camera as virtual
from beltrepro.replication.camera.camera import Framing, Movement, film, pictures
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.video import read_video
from filming import FRAMES_PER_SECOND, swaying

NOTHING = "blur", "sensor_noise", "light_unevenness", "light_drift", "exposure", "compression"
IDEAL = dict.fromkeys(NOTHING, 0)


@pytest.mark.parametrize(("begin", "end"), [(3.3, 3.3), (2.25, 6.5), (6.5, 2.25), (-4.0, 1.5)])
def test_a_moving_edge_covers_what_the_mean_over_its_places_covers(begin, end):
    pixels = np.arange(12)
    places = begin + (end - begin) * (np.arange(20000) + 0.5) / 20000
    expected = np.clip(pixels + 1 - places[:, np.newaxis], 0, 1).mean(axis=0)
    changes = virtual.step_changes(np.array([[begin]]), np.array([[end]]), np.array([1.0]), 12)[0]
    np.testing.assert_allclose(np.cumsum(changes), expected, atol=1e-8)


def test_steps_and_bands_beyond_the_picture_do_no_harm():
    edges = np.array([[-30.0, 5.5, 40.0]])
    changes = virtual.step_changes(edges, edges, np.array([2.0, 1.0, 7.0]), 8)[0]
    np.testing.assert_allclose(np.cumsum(changes), [2, 2, 2, 2, 2, 2.5, 3, 3])
    np.testing.assert_allclose(virtual.band(1.25, 4.5, 7), [0, 0.75, 1, 1, 0.5, 0, 0])
    assert virtual.band(-3.0, 20.0, 7).sum() == 7


def test_a_scale_that_the_camera_chooses_fits_whatever_the_rounding():
    for farthest in np.linspace(0.5, 1.5, 1001):
        movement = Movement(np.zeros(1), np.array([[farthest]]), np.zeros((1, 1)))
        view = Framing.of(movement, Scene(), Camera())
        assert view.along(farthest + 0.02) < view.width


def test_the_white_block_brightens_by_its_area():
    movement, scene = swaying(0.2), Scene(spring=28.0)
    camera = Camera(**IDEAL, metres_per_pixel=0.0013)
    black = Scene(spring=28.0, white_block=scene.block)
    first, second = (
        next(pictures(movement, scene=one, camera=camera)).picture.astype(float)
        for one in (scene, black)
    )
    area = (first - second).sum() / (scene.white_block - scene.block)
    expected = scene.block_length * scene.block_width / camera.metres_per_pixel**2
    assert area == pytest.approx(expected, rel=2e-3)  # 8 bits round
    columns = (first - second).sum(axis=0)
    centre = np.arange(camera.width) @ columns / columns.sum() + 0.5
    view = Framing.of(movement, scene, camera)
    assert centre == pytest.approx(view.along(movement.x_m[0, -1]), abs=0.01)


def test_exposure_blurs_by_the_way_of_the_block():
    movement = Movement(np.zeros(1), np.array([[0.5]]), np.array([[0.4]]))
    scene, exposure = Scene(belt=28, tape=28, mark=28, support=28, spring=28), 0.04
    ideal = IDEAL | {"exposure": exposure, "metres_per_pixel": 0.001, "height": 160}
    picture = next(pictures(movement, scene=scene, camera=Camera(**ideal))).picture
    row = picture[picture.sum(axis=1).argmax()].astype(float)
    partly = (row > scene.belt + 1) & (row < scene.white_block - 1)
    assert partly.sum() == pytest.approx(2 * 0.4 * exposure / 0.001, abs=3)  # both edges


def test_noise_light_and_drift_are_as_strong_as_asked():
    movement = swaying(0.2)
    ideal = next(pictures(movement, camera=Camera(**IDEAL))).picture.astype(float)
    noisy = next(pictures(movement, camera=Camera(**IDEAL | {"sensor_noise": 5}))).picture
    middle = (ideal > 20) & (ideal < 230)
    assert (noisy - ideal)[middle].std() == pytest.approx(5, rel=0.05)
    uneven = next(pictures(movement, camera=Camera(**IDEAL | {"light_unevenness": 0.3}))).picture
    belt = ideal == Scene().belt
    ratio = np.where(belt, uneven / ideal, np.nan)
    assert np.nanmean(ratio[:, -8:]) == pytest.approx(1.3, abs=0.03)
    assert np.nanmean(ratio[:, 320:330]) == pytest.approx(1.0, abs=0.03)


def test_a_frame_does_not_depend_on_those_that_are_drawn_with_it():
    movement = swaying(6.0)
    camera = Camera(**IDEAL | {"exposure": 0.02, "blur": 0.8}, metres_per_pixel=0.0015)
    together = [frame.picture for frame in pictures(movement, camera=camera)]
    assert len(together) == len(movement.time_s)
    for index in (0, 63, 64, 65, 100, 143):  # 64 frames are drawn in one go
        one = slice(index, index + 1)
        alone = Movement(movement.time_s[one], movement.x_m[one], movement.v_m_s[one])
        (frame,) = pictures(alone, camera=camera)
        np.testing.assert_array_equal(together[index], frame.picture)


def test_the_film_has_the_instants_of_the_samples_and_gaps_where_frames_are_dropped(tmp_path):
    path = tmp_path / "film.mp4"
    count = film(swaying(4.0), path, camera=Camera(dropped=0.2, width=320, height=64))
    instants = np.array([frame.time_s for frame in read_video(path)])
    assert 60 < count == len(instants) < 90
    steps = np.diff(instants) * FRAMES_PER_SECOND
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-3)
    assert steps.max() > 1.5


def test_the_same_seed_gives_the_same_pictures():
    first, again, other = (next(pictures(swaying(0.1), camera=Camera(seed=n))) for n in (3, 3, 4))
    assert np.array_equal(first.picture, again.picture)
    assert not np.array_equal(first.picture, other.picture)


def test_a_run_is_filmed_at_its_instants(tmp_path):
    chain = ChainParameters(2, 15.0)
    every = 1 / FRAMES_PER_SECOND / TIME_S
    run = simulate(chain, duration=10.0, method="event", sample_interval=every)
    camera = Camera(width=200, height=64)
    assert film(run, tmp_path / "film.mp4", camera=camera) == len(run.time)
    wrong = simulate(chain, duration=10.0, method="event")
    with pytest.raises(InputError, match=r"sample_interval = 0.5448\d+"):
        film(wrong, tmp_path / "film.mp4", camera=camera)
    none = simulate(chain, duration=10.0, method="event", sample_interval=None)
    with pytest.raises(InputError, match="motion = None: a Run or a Movement is needed"):
        film(None, tmp_path / "film.mp4")
    with pytest.raises(InputError, match="no samples"):
        film(none, tmp_path / "film.mp4")


# As documented, written here once more: numbers near the ends of a range, on both sides.
RANGES = {
    "frames_per_second": ([50], [0]),
    "metres_per_pixel": ([1e-3], [-1, float("nan")]),
    "width": ([16, 8192], [641, 14, 8194]),
    "exposure": ([0, 1 / 24], [0.05, -0.01]),
    "blur": ([0, 16], [24, -0.1]),
    "sensor_noise": ([0, 204], [300, "much"]),
    "light_unevenness": ([0.8], [1.2]),
    "angle": ([-36, 45], [-54, 46]),
    "dropped": ([0, 0.72], [0.95, -0.1]),
    "compression": ([0, 51], [52, 17.5]),
    "seed": ([0], [-1]),
}


@pytest.mark.parametrize("name", RANGES)
def test_numbers_of_a_camera_have_ranges(name):
    allowed, refused = RANGES[name]
    for value in allowed:
        assert getattr(Camera(**{name: value}), name) == value
    for value in refused:
        with pytest.raises(InputError, match=f"^{name} = "):
            Camera(**{name: value})


def test_what_does_not_fit_is_refused(tmp_path):
    with pytest.raises(InputError, match="larger metres_per_pixel"):
        film(swaying(0.1), tmp_path / "film.mp4", camera=Camera(metres_per_pixel=0.0005))
    with pytest.raises(InputError, match=r"must end in \.mp4"):
        film(swaying(0.1), tmp_path / "film.avi")
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="belt = 300"):
        Scene(belt=300)
    with pytest.raises(InputError, match="block_length = 0"):
        Scene(block_length=0)
