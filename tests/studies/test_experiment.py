"""The study of the experiment: films, trials and runs that show what they are made to."""

import numpy as np
import pytest
from scipy.signal import lfilter

from alternating import experiments
from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.model.units import LENGTH_M, TIME_S
from beltrepro.replication.camera.track import Track
from beltrepro.replication.studies.experiment import measure
from beltrepro.replication.verdicts.criteria import IN_PART, NO, YES
from made_up import both, few_resamples, grades, measured, replicates  # noqa: F401

INTERVAL_S = 1 / 24
SPEEDS = (12.0176, 15.2951)


def track(x_m, *, lost_s=(), places=None):
    time = INTERVAL_S * np.arange(x_m.size)
    chosen = slice(None) if places is None else places
    lost = np.array(lost_s, dtype=float).reshape(-1, 2)
    return Track(time[chosen], x_m[chosen], lost, 0.002)


def noise_like(seed):
    """Positions of 200 s whose spectrum is smooth, with a mean of 0.8 m and a spread of 0.1 m."""
    kicks = np.random.default_rng(seed).standard_normal(round(200 / INTERVAL_S))
    return 0.8 + 0.06 * lfilter([1], [1, -0.8], kicks)


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
        made[name], made[f"{name}_track"] = filmed(noise_like(number), **how)
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
    x_m = noise_like(1)
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
    with pytest.raises(NotEnoughDataError, match=r"no trials at 0\.28 m/s, sigma = 1"):
        measured("experiment-028", **trials(noise=2.0))


# --- r --------------------------------------------------------------------------------------------


def with_r(first, second, *, scatter=0.0005, noise=2.2):
    """Runs with these r near u = 12 and 15.3 at a noise, and another far from them."""
    made = replicates(dict.fromkeys((0.0, 0.5, 1.0, 2.2, 5.0), 30.0))
    arrays, rng = made.arrays, np.random.default_rng(3)
    u, chosen = arrays["belt_velocity"], arrays["noise"] == noise
    arrays["disorder_parameter"][:] = 9.0
    for places, value in (((12,), first), ((15, 15.5), second)):
        near = chosen & np.isin(u, places)
        arrays["disorder_parameter"][near] = value + scatter * rng.standard_normal(near.sum())
    return {"n5_replicates": made}


@pytest.mark.parametrize(
    ("first", "second", "verdicts"),
    [
        (0.132, 0.134, (YES, YES)),
        (0.160, 0.134, (IN_PART, IN_PART)),
        (0.005, 0.900, (NO, NO)),
        (0.022, 0.165, (NO, IN_PART)),  # of the same order
    ],
)
def test_r_at_the_speeds_of_the_experiment(first, second, verdicts):
    assert both("r-experiment", **with_r(first, second)) == verdicts


def test_r_is_a_mean_over_runs_at_one_noise():
    faster = measured("r-experiment", **with_r(0.132, 0.134, scatter=0.02)).judged["r at 0.28 m/s"]
    assert faster.runs == 16 and 0.01 < faster.high - faster.low < 0.04
    other = measured("r-experiment", "sigma = 1", **with_r(0.1, 0.2, noise=1.0)).judged
    assert other["r at 0.22 m/s"].value == pytest.approx(0.1, abs=0.003)
    held = 0.84 / (0.84 + 4.5 * 0.04)  # <x_5> of 600 units, without and with 4.5 blocks, in metres
    for name, ratio in (("r at 0.22 m/s", 0.1 / 0.072), ("r at 0.28 m/s", 0.2 / 0.052)):
        seen = other[f"{name} over the experiment's"].value
        assert seen == pytest.approx(held * ratio, rel=0.03)


# --- intermittency --------------------------------------------------------------------------------


@pytest.mark.parametrize(("critical", "verdict"), [(19.0, YES), (40.0, IN_PART), (60.0, NO)])
def test_the_critical_speed_beside_those_of_the_experiment(critical, verdict):
    """With the noise of the reading; 40 is 3.3 times the speed at 0.22 m/s."""
    velocities = np.linspace(0.5, 1.5, 25) * critical
    velocities = np.unique(np.r_[velocities, 12.0, 15.5])
    made = replicates({1.0: 5.0, 2.2: critical}, noises=(1.0, 2.2), velocities=velocities)
    chosen = made.arrays["noise"] == 2.2
    made.arrays["laminar_fraction"] = np.where(chosen & (made.arrays["replicate"] == 1), 0.4, 0.0)
    agree = experiments([2.8], runs=80)["trials"]
    agree.arrays["lasting_longest"][agree.arrays["belt_velocity"] > 13] = 0.0
    made = {"n5_replicates": made, "trials": agree}
    assert both("intermittency-experiment", **made) == (verdict, verdict)
    measurement = measured("intermittency-experiment", **made)
    ratio = measurement.judged["critical speed over 0.28 m/s"].value
    assert ratio == pytest.approx(critical / 15.295, rel=0.05)
    assert measurement.also["laminar share, 0.22 m/s"].value == pytest.approx(0.05)
    shares = [measurement.also[f"trials that alternate, {u} m/s"].value for u in (0.22, 0.28)]
    assert shares == [0.5, 0]  # of noises 2 and 2.8 one alternates


# --- trials ---------------------------------------------------------------------------------------


def of_model(along_tape):
    """r of x_5 without blocks, if <x_5> is 600 units of 1.4 mm and 4.5 blocks have 18 cm."""
    return along_tape * (0.84 + 0.18) / 0.84


def test_the_odds_are_those_of_a_plain_loop():
    """Trials in which no two properties go together, in cells of unequal size."""
    rng, first = np.random.default_rng(3), measure.EXPERIMENT[0]
    noise = np.repeat([1.0, 2.0, 3.0], (7, 12, 5))
    arrays = {
        "noise": noise,
        "belt_velocity": np.full(noise.size, first.belt_velocity),
        "mean_length": np.full(noise.size, 600.0),
        "disorder_parameter": of_model(0.072 * rng.uniform(0.8, 1.2, noise.size)),
        "lasting_share": rng.random(noise.size),
        "lasting_longest": rng.choice([100, 500, 1000], noise.size),
        "lively_longest": rng.choice([100, 1000, 3000], noise.size),
        "all_slip_longest": rng.uniform(0, 10, noise.size),
    }
    second = {name: values.copy() for name, values in arrays.items()}
    second["belt_velocity"][:] = measure.EXPERIMENT[1].belt_velocity
    both = {name: np.r_[values, second[name]] for name, values in arrays.items()}
    trials = Dataset(both, {"duration": 200.0, "transient": 50.0})
    table = measure.experiment_odds({"trials": trials, "trials_short": trials})
    for level in (1.0, 2.0, 3.0):
        row = table[(table["noise"] == level) & (table["speed_m_s"] == 0.22)].iloc[0]
        counts = dict.fromkeys(("below", "shows", "agrees", "both"), 0)
        chosen = np.flatnonzero(noise == level)
        for k in chosen:
            r = arrays["disorder_parameter"][k] * 0.84 / (0.84 + 4.5 * 0.04)  # in metres
            seconds = [TIME_S * arrays[name][k] for name in ("lasting_longest", "lively_longest")]
            shows = seconds[0] >= 60 and seconds[1] >= 125
            counts["below"] += r <= 0.072
            counts["shows"] += shows
            counts["agrees"] += shows and abs(np.log(r / 0.072)) <= 0.1
            counts["both"] += shows and r <= 0.072
        assert row["runs"] == chosen.size
        r = arrays["disorder_parameter"][chosen] * 0.84 / (0.84 + 4.5 * 0.04)
        ends = np.quantile(r, [0.025, 0.5, 0.975])
        assert row[["r_lower", "r", "r_upper"]].tolist() == pytest.approx(ends)
        for name, count in counts.items():
            assert row[name] == pytest.approx(count / chosen.size), name


def test_alternation_is_that_of_a_plain_loop():
    """Cells of unequal size; half of the trials are enough for a belt velocity to be named."""
    rng, runs = np.random.default_rng(6), (3, 8, 5)
    arrays = {
        "noise": np.repeat([1.0, 2.0, 4.0], runs),
        "friction_ratio": np.full(16, 0.45),
        "belt_velocity": np.full(16, 12.0),
        "lasting_longest": rng.choice([100.0, 300.0], 16),
        "lively_longest": rng.choice([100.0, 300.0], 16, p=[0.2, 0.8]),
        "all_slip_longest": rng.uniform(10, 70, 16) / TIME_S,
    }
    table = measure.alternation({"trials_free": Dataset(arrays, {})})
    for _, row in table.iterrows():
        cell = {name: values[arrays["noise"] == row["noise"]] for name, values in arrays.items()}
        slips = TIME_S * cell["all_slip_longest"]
        shows = np.minimum(cell["lasting_longest"], cell["lively_longest"]) == 300
        assert row["runs"] == shows.size and row["alternating"] == shows.sum()
        assert row["all_slip_longest_s"] == pytest.approx(slips.max())
        assert row["all_slip"] == np.sum(slips >= 60)
