"""The virtual camera: exact coverage, light, lens and noise; films have their instants."""

import numpy as np
import pytest

from beltrepro import ChainParameters, simulate
from beltrepro.base.errors import InputError
from beltrepro.model.units import TIME_S
from beltrepro.replication.camera.camera import SCENE, Framing, Movement, film, lane, pictures
from beltrepro.replication.camera.scene import Camera, Scene
from beltrepro.replication.camera.video import read_video
from recorded import RATE, swaying

NOTHING = "blur", "sensor_noise", "light_unevenness", "light_drift", "exposure", "compression"
IDEAL = dict.fromkeys(NOTHING, 0)


def first_picture(movement=None, *, scene=SCENE, **camera):
    """The first frame of a film by an ideal camera but for these settings."""
    movement = swaying(0.1) if movement is None else movement
    frames = pictures(movement, scene=scene, camera=Camera(**IDEAL | camera))
    return next(frames).picture.astype(float)


@pytest.mark.parametrize(("begin", "end"), [(3.3, 3.3), (2.25, 6.5), (6.5, 2.25), (-4.0, 1.5)])
def test_a_moving_edge_covers_what_the_mean_over_its_places_covers(begin, end):
    pixels, beyond = np.arange(12), np.full((2, 1), 40.0)
    places = begin + (end - begin) * (np.arange(20000) + 0.5) / 20000
    expected = np.clip(pixels + 1 - places[:, np.newaxis], 0, 1).mean(axis=0)
    seen = lane(np.array([[begin], [end]]), beyond, np.array([7.0]), 12)
    np.testing.assert_allclose(seen, 7 * expected, atol=1e-7)


def test_the_white_block_brightens_by_its_area():
    scene, black = Scene(spring=28.0), Scene(spring=28.0, white_block=Scene().block)
    first, second = (first_picture(scene=one, metres_per_pixel=0.0013) for one in (scene, black))
    area = (first - second).sum() / (scene.white_block - scene.block)
    assert area == pytest.approx(scene.block_length * scene.block_width / 0.0013**2, rel=2e-3)
    columns = (first - second).sum(axis=0)
    centre = np.arange(columns.size) @ columns / columns.sum() + 0.5
    view = Framing.of(swaying(0.1), scene, Camera(metres_per_pixel=0.0013))
    assert centre == pytest.approx(view.along(swaying(0.1).x_m[0, -1]), abs=0.01)


def test_exposure_blurs_by_the_way_of_the_block():
    movement = Movement(np.zeros(1), np.array([[0.5]]), np.array([[0.4]]))
    scene, how = Scene(tape=28, mark=28, support=28, spring=28), {"exposure": 0.04, "height": 160}
    picture = first_picture(movement, scene=scene, metres_per_pixel=0.001, **how)
    row = picture[picture.sum(axis=1).argmax()]
    partly = (row > scene.belt + 1) & (row < scene.white_block - 1)
    assert partly.sum() == pytest.approx(2 * 0.4 * 0.04 / 0.001, abs=3)  # both edges


def test_noise_and_light_are_as_strong_as_asked_and_fixed_by_the_seed():
    ideal, noisy, again = (
        first_picture(),
        first_picture(sensor_noise=5),
        first_picture(sensor_noise=5),
    )
    middle = (ideal > 20) & (ideal < 230)
    assert (noisy - ideal)[middle].std() == pytest.approx(5, rel=0.05)
    assert np.array_equal(noisy, again)
    assert not np.array_equal(noisy, first_picture(sensor_noise=5, seed=4))
    ratio = np.where(ideal == Scene().belt, first_picture(light_unevenness=0.3) / ideal, np.nan)
    assert np.nanmean(ratio[:, -8:]) == pytest.approx(1.3, abs=0.03)
    assert np.nanmean(ratio[:, 320:330]) == pytest.approx(1.0, abs=0.03)


def test_the_film_has_the_instants_of_the_samples_and_gaps_where_frames_are_dropped(tmp_path):
    path = tmp_path / "film.mp4"
    count = film(swaying(4.0), path, camera=Camera(dropped=0.2, width=320, height=64))
    instants = np.array([frame.time_s for frame in read_video(path)])
    assert 60 < count == len(instants) < 90
    steps = np.diff(instants) * RATE
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-3)
    assert steps.max() > 1.5


def test_a_run_is_filmed_at_its_instants(tmp_path):
    path, camera = tmp_path / "film.mp4", Camera(width=200, height=64)

    def run(**how):
        return simulate(ChainParameters(2, 15.0), duration=10.0, method="event", **how)

    sampled = run(sample_interval=1 / RATE / TIME_S)
    assert film(Movement.of(sampled), path, camera=camera) == len(sampled.time)
    path.unlink()
    with pytest.raises(InputError, match="has 1 samples to film, two are needed"):
        Movement.of(run(sample_interval=20.0))
    for movement, name, settings, words in (
        (Movement.of(run()), "film.mp4", {}, r"sample_interval = 0.5448\d+"),
        (swaying(0.1), "film.mp4", {"metres_per_pixel": 0.0005}, "larger metres_per_pixel"),
        (swaying(1.3), "film.mp4", {"angle": 30}, "out of the picture, .* larger height"),
        (
            swaying(1.3),
            "film.mp4",
            {"angle": -3, "metres_per_pixel": 0.00135},
            "out of the picture",
        ),
        (swaying(0.1), "film.avi", {}, r"must end in \.mp4"),
    ):
        with pytest.raises(InputError, match=words):
            film(movement, tmp_path / name, camera=Camera(**settings))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "allowed", "refused"),
    [
        ("metres_per_pixel", [1e-3], [-1, float("nan")]),
        ("width", [16, 8192], [641, 14, 8194]),
        ("exposure", [0, 1 / 24], [0.05, -0.01]),
        ("dropped", [0, 0.72], [0.95, -0.1]),
    ],
)
def test_numbers_of_a_camera_have_ranges(name, allowed, refused):
    for value in allowed:
        Camera(**{name: value})
    for value in refused:
        with pytest.raises(InputError, match=f"^{name} = "):
            Camera(**{name: value})
