"""Claims on the experiment: trials and tracks that alternate as often as they are made to."""

import itertools

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.model.units import LENGTH_M, TIME_S
from beltrepro.replication.camera.tracking import Track
from made_up import columns, few_resamples, judged  # noqa: F401

INTERVAL_S = 1 / 24
SPEEDS = (12.0176, 15.2951)


def track(x_m, *, lost_s=(), places=None):
    time = INTERVAL_S * np.arange(x_m.size)
    chosen = slice(None) if places is None else places
    lost = np.array(lost_s, dtype=float).reshape(-1, 2)
    return Track(time[chosen], x_m[chosen], np.full(time[chosen].size, 2e-5), 0.002, 0.0, lost)


def noise_like(seconds, seed, *, slope=1.0):
    """Positions whose spectrum is smooth: an autoregression with a mean of 0.8 m, spread 0.1 m."""
    rng = np.random.default_rng(seed)
    size = round(seconds / INTERVAL_S)
    kicks = rng.standard_normal(size + 50)
    weight = slope ** np.arange(50)
    return 0.8 + 0.1 * np.convolve(kicks, weight / np.linalg.norm(weight), "valid")[:size]


def periodic(seconds, lines_hz=(0.4, 0.8, 1.2, 1.6, 2.0, 2.4)):
    time = INTERVAL_S * np.arange(round(seconds / INTERVAL_S))
    lines = sum(np.cos(2 * np.pi * line * time + k) for k, line in enumerate(lines_hz))
    rng = np.random.default_rng(0)
    return 0.8 + 0.004 * lines + 1e-5 * rng.standard_normal(time.size)


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
    verdict, parts, found = judged("threshold", films(**errors))
    assert parts.get(failing, "fails") == "fails" and found.runs == 20
    assert (verdict == "holds") == (failing is None)


def test_frames_in_which_the_block_is_lost_or_taken_for_another():
    made = films(error=1e-4)
    assert judged("snapshot", made)[0] == "holds"
    x_m = noise_like(200, 1, slope=0.8)
    kept = np.ones(x_m.size, dtype=bool)
    kept[1000:1100] = False
    lost = made | {"belt_028_track": track(x_m, places=kept, lost_s=[(41.67, 45.79)])}
    assert judged("snapshot", lost)[1]["share of the frames with the block"] == "fails"
    kept[1000:1100] = True
    wrong = x_m + 0.03 * (np.arange(x_m.size) == 700)
    parts = judged("snapshot", made | {"belt_028_track": track(wrong)})[1]
    assert list(parts.values()) == ["holds", "fails"]


# --- small and large amplitudes -------------------------------------------------------------------


def trials(alternating, slipping_s, *, noise=1.0, count=100, duration=15_691.0):
    """Trials at both speeds: shares that alternate, and longest slips."""
    size = 2 * count
    number = np.tile(np.arange(count), 2)
    arrays = columns(
        belt_velocity=np.repeat(SPEEDS, count),
        noise=noise,
        lasting_share=np.where(number < alternating, 0.3, np.where(number % 2, 0.0, 1.0)),
        lasting_longest=np.full(size, 20 / TIME_S),
        slip_longest=np.full(size, 61 / TIME_S),
        all_slip_longest=np.resize(np.asarray(slipping_s, dtype=float), size) / TIME_S,
    )
    return {"trials": Dataset(arrays, {"duration": duration, "transient": 2615.0})}


def alternating_film(small=periodic, *, pieces=10):
    parts = [part for k in range(pieces) for part in (noise_like(60, k, slope=0.8), small(40))]
    return {"belt_028_track": track(np.concatenate(parts))}


def test_a_model_that_alternates_holds():
    made = trials(20, [1.0]) | alternating_film()
    verdict, parts, found = judged("experiment-028", made)
    assert verdict == "holds", (parts, found.words)
    assert "multiples of 0.4" in found.note
    assert found.judged["trials that alternate"].runs == 100


def test_a_trial_alternates_from_a_twentieth_of_the_time_on():
    made = trials(0, [1.0])
    shares = np.resize([0.04, 0.06, 0.94, 0.96, 0.0], 200)
    made["trials"].arrays["lasting_share"] = shares
    judgement = judged("experiment-028", made | alternating_film())[2]
    assert judgement.judged["trials that alternate"].value == pytest.approx(0.4)


def test_stretches_shorter_than_a_segment_of_the_spectrum_are_left_out():
    """Of 15.3 s and more they last, but a spectrum of lines needs 20 s."""
    parts = [(noise_like(60, k, slope=0.8), periodic(40 if k % 3 else 16)) for k in range(12)]
    film = {"belt_028_track": track(np.concatenate([piece for pair in parts for piece in pair]))}
    measurement = judged("experiment-028", trials(20, [1.0]) | film)[2]
    assert measurement.judged["small stretches with peaks at equal distances"].runs == 8


@pytest.mark.thorough
@pytest.mark.parametrize(("count", "part"), [(0, "fails"), (9, "undecided"), (25, "holds")])
def test_how_often_trials_alternate(count, part):
    made = trials(count, [1.0], count=200) | alternating_film()
    assert judged("experiment-028", made)[1]["trials that alternate"] == part


def test_what_small_amplitudes_must_be():
    seeds = itertools.count(100)

    def hum(seconds):
        return 0.8 + 0.02 * (noise_like(seconds, next(seeds), slope=0.8) - 0.8)

    parts = judged("experiment-028", trials(20, [1.0]) | alternating_film(hum))[1]
    assert parts["small stretches with peaks at equal distances"] == "fails"
    assert parts["flatness, large minus small"] != "holds" and parts["flatness, large"] == "holds"
    only_large = {"belt_028_track": track(noise_like(1000, 4, slope=0.8))}
    verdict, parts, found = judged("experiment-028", trials(0, [1.0]) | only_large)
    assert verdict == "partly" and parts["flatness, large"] == "holds"
    assert "0 stretches of small amplitude" in found.note


def test_peaks_at_other_distances_are_told_from_multiples():
    def irregular(seconds):
        return periodic(seconds, (0.43, 0.97, 1.31, 2.03, 2.57, 3.49))

    parts = judged("experiment-028", trials(20, [1.0]) | alternating_film(irregular))[1]
    assert parts.pop("small stretches with peaks at equal distances") == "fails"
    assert set(parts.values()) == {"holds"}


def test_recordings_are_as_long_as_the_papers():
    short = {"belt_028_track": track(noise_like(800, 4, slope=0.8))}
    with pytest.raises(NotEnoughDataError, match="the film belt_028 has 800 s"):
        judged("experiment-028", trials(20, [1.0]) | short)
    with pytest.raises(NotEnoughDataError, match="trials of 800 s"):
        judged("experiment-028", trials(20, [1.0], duration=13_076.0) | alternating_film())
    with pytest.raises(NotEnoughDataError, match=r"no trials at u = 15\.3, sigma = 1"):
        judged("experiment-028", trials(20, [1.0], noise=2.0) | alternating_film())


# --- continuous slip ------------------------------------------------------------------------------


def films_of_spectra(slope):
    """Of 0.22 m/s with another spectrum, and of 0.28 m/s."""
    one, other = noise_like(1000, 5, slope=slope), noise_like(1000, 6, slope=0.8)
    return {"belt_022_track": track(one), "belt_028_track": track(other)}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("slips", "slope", "verdict"),
    [
        ([61.0, 10.0], 0.8, "holds"),
        ([59.0, 10.0], 0.8, "partly"),
        ([59.0, 10.0], -0.3, "fails"),
        ([61.0] * 4 + [1.0] * 96, 0.8, "undecided"),
    ],
)
def test_a_minute_of_slip_of_all_blocks(slips, slope, verdict):
    made = trials(0, slips) | films_of_spectra(slope)
    found = judged("experiment-022", made)
    assert found[0] == verdict, found[2].words
    minute = "trials with a minute of slip of all blocks"
    last = judged("experiment-022", made, "sigma = 1, the last block slips")
    small = judged("experiment-022", made, "sigma = 1, small amplitude")
    assert last[1][minute] == "holds" and small[2].judged[minute].value == 0


def test_equal_spectra_differ_by_no_more_than_their_noise():
    found = judged("experiment-022", trials(0, [61.0]) | films_of_spectra(0.8))[2]
    assert found.judged["factor between the spectra"].high < 1.2
