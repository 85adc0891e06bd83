"""Claims on the experiment: trials and tracks that alternate as often as they are made to."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.model.units import LENGTH_M, TIME_S
from beltrepro.replication.camera.track import Track
from beltrepro.replication.verdicts.criteria import IN_PART, NO, NOT_TESTABLE, YES
from made_up import both, few_resamples, grades, measured  # noqa: F401

INTERVAL_S = 1 / 24
SPEEDS = (12.0176, 15.2951)


def track(x_m, *, lost_s=(), places=None):
    time = INTERVAL_S * np.arange(x_m.size)
    chosen = slice(None) if places is None else places
    lost = np.array(lost_s, dtype=float).reshape(-1, 2)
    return Track(time[chosen], x_m[chosen], lost, 0.002)


def noise_like(seconds, seed, *, slope=1.0):
    """Positions whose spectrum is smooth: an autoregression with a mean of 0.8 m, spread 0.1 m."""
    rng = np.random.default_rng(seed)
    size = round(seconds / INTERVAL_S)
    kicks = rng.standard_normal(size + 50)
    weight = slope ** np.arange(50)
    return 0.8 + 0.1 * np.convolve(kicks, weight / np.linalg.norm(weight), "valid")[:size]


def filmed(x_m, *, error=0.0, offset=0.0, scale=0.0, seed=0):
    """The run that was filmed, and its track with errors."""
    rng = np.random.default_rng(seed)
    seen = x_m + offset + scale * (x_m - x_m.mean()) + error * rng.standard_normal(x_m.size)
    run = Dataset({"positions": x_m[:, None] / LENGTH_M}, {"sample_interval": INTERVAL_S / TIME_S})
    return run, track(seen)


def films(**errors):
    made = {}
    for number, name in enumerate(("belt_022", "belt_028", "belt_035")):
        how = errors if number == 1 else {"error": 1e-5}
        made[name], made[f"{name}_track"] = filmed(noise_like(200, number, slope=0.8), **how)
    return made


# --- the measurement ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("errors", "failing"),
    [
        ({"error": 1e-4}, None),
        ({"error": 6e-4}, "scatter of x_5 (pixels)"),
        ({"offset": 5e-4, "error": 1e-5}, "offset of x_5 (pixels)"),
        ({"scale": 0.004, "error": 1e-5}, "error of the scale"),
        ({"scale": -0.02, "error": 1e-5}, "error of r"),
    ],
)
def test_the_film_with_the_largest_errors_counts(errors, failing):
    graded = grades("threshold", **films(**errors))
    assert graded[""] == (YES if failing is None else IN_PART)
    assert failing is None or graded[failing] == NO
    errors_of_x = measured("threshold", **films(**errors)).judged
    assert [error.runs for error in errors_of_x.values()] == [20] * 4


def test_frames_in_which_the_block_is_lost_or_taken_for_another():
    made = films(error=1e-4)
    assert grades("snapshot", **made)[""] == YES
    x_m = noise_like(200, 1, slope=0.8)
    kept = np.ones(x_m.size, dtype=bool)
    kept[1000:1100] = False
    lost = made | {"belt_028_track": track(x_m, places=kept, lost_s=[(41.67, 45.79)])}
    assert grades("snapshot", **lost)["share of the frames with the block"] == NO
    kept[1000:1100] = True
    wrong = x_m + 0.03 * (np.arange(x_m.size) == 700)
    made["belt_028_track"] = track(wrong)
    assert list(grades("snapshot", **made).values()) == [YES, NO, IN_PART]


# --- what the model shows beside the recordings ---------------------------------------------------

MINUTE = "trials with a minute of slip of all blocks"


def trials(*, noise=1.0, duration=15_691.0, **values):
    """Trials at both speeds, of which the second has these values, over and over."""
    size = 200
    arrays = {"belt_velocity": np.repeat(SPEEDS, size), "noise": np.full(2 * size, noise)}
    for name in ("lasting_share", "all_slip_longest"):
        arrays[name] = np.resize(np.asarray(values.get(name, 0.0), dtype=float), 2 * size)
    return {"trials": Dataset(arrays, {"duration": duration, "transient": 2615.0})}


def test_a_trial_alternates_from_a_twentieth_of_the_time_on():
    made = trials(lasting_share=[0.04, 0.06, 0.94, 0.96, 0.0])
    share = measured("experiment-028", **made).also["trials that alternate"]
    assert (share.value, share.runs) == (pytest.approx(0.4), 200)
    made = trials(all_slip_longest=np.array([59.0, 61.0, 10.0, 10.0, 61.5]) / TIME_S)
    also = measured("experiment-022", **made).also
    assert also[MINUTE].value == pytest.approx(0.4)
    assert also["longest slip (s)"].value == pytest.approx(61.5)


def test_trials_are_those_of_the_speed_and_noise_and_as_long_as_the_papers():
    made = trials(lasting_share=0.5)
    made["trials"].arrays["lasting_share"][:200] = 0.0  # at 0.22 m/s
    assert measured("experiment-028", **made).also["trials that alternate"].value == 1
    with pytest.raises(NotEnoughDataError, match="trials of 800 s"):
        measured("experiment-028", **trials(duration=13_076.0))
    with pytest.raises(NotEnoughDataError, match=r"no trials at u = 15\.3, sigma = 1"):
        measured("experiment-028", **trials(noise=2.0))


def test_recordings_are_not_testable():
    for name in ("experiment-028", "experiment-022"):
        assert both(name, trials=two_noises()) == (NOT_TESTABLE, NOT_TESTABLE)
    made = {"trials": two_noises()}
    shares = [measured("experiment-028", f"sigma = {noise}", **made).also for noise in (1, 2)]
    assert [share["trials that alternate"].value for share in shares] == [0.4, 1.0]


def two_noises():
    one, two = (
        trials(noise=noise, lasting_share=share)["trials"]
        for noise, share in ((1.0, [0.5, 0, 0, 0.5, 0]), (2.0, 0.5))
    )
    arrays = {name: np.r_[one.arrays[name], two.arrays[name]] for name in one.arrays}
    return Dataset(arrays, one.attributes)
