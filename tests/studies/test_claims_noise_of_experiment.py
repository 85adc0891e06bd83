"""Claims on the noise of the experiment: made-up runs and trials with a known answer."""

from types import SimpleNamespace

import numpy as np
import pytest

from alternating import experiments
from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.studies.experiment.films import disorder_of
from beltrepro.replication.studies.experiment.measure import between
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, UNDECIDED
from made_up import LEDGER, grades, measured, replicates


@pytest.fixture(autouse=True)
def no_smoothing(monkeypatch):
    monkeypatch.setattr("beltrepro.replication.studies.experiment.observations.BANDWIDTH", {})


def components(name, reading=None, /, **datasets):
    """Verdicts in the order of the criterion."""
    verdict = grades(name, reading, **datasets)
    return [verdict[each] for each in LEDGER[name].criterion["allowed"]]


# --- r --------------------------------------------------------------------------------------------


def with_r(first, second, *, scatter=0.002, noise=1.0):
    """Runs with these r near u = 12 and 15.3 at a noise, and another far from them."""
    made = replicates(dict.fromkeys((0.0, 0.5, 1.0, 2.2, 5.0), 30.0))
    arrays, rng = made.arrays, np.random.default_rng(3)
    u, own = arrays["belt_velocity"], arrays["noise"] == noise
    arrays["disorder_parameter"][:] = 9.0
    for places, value in (((12,), first), ((15, 15.5), second)):
        near = own & np.isin(u, places)
        arrays["disorder_parameter"][near] = value + scatter * rng.standard_normal(near.sum())
    return {"n5_replicates": made}


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (0.132, 0.134, [HOLDS, HOLDS, HOLDS, HOLDS]),
        (0.160, 0.134, [FAILS, HOLDS, HOLDS, HOLDS]),
        (0.132, 0.105, [HOLDS, FAILS, HOLDS, HOLDS]),
        (0.132, 0.145, [HOLDS, UNDECIDED, HOLDS, HOLDS]),
        (0.300, 0.012, [FAILS, FAILS, FAILS, FAILS]),
    ],
)
def test_r_at_the_speeds_of_the_experiment(first, second, expected):
    assert components("r-experiment", **with_r(first, second)) == expected


def test_r_has_an_interval_from_runs():
    r_028 = measured("r-experiment", **with_r(0.132, 0.134, scatter=0.02)).judged["r_028"]
    assert r_028.runs == 16 and 0.01 < r_028.high - r_028.low < 0.04
    other = measured("r-experiment", "sigma = 2.2", **with_r(0.1, 0.2, noise=2.2)).judged
    assert other["r_022"].value == pytest.approx(0.1, abs=0.003)
    assert other["r_022 over the experiment's"].value == pytest.approx(0.1 / 0.072, rel=0.03)


def film(ratio, *, seconds=1000.0, seed=1):
    """Track of x_5 about 0.8 m whose standard deviation is a ratio of that."""
    time = np.arange(0, seconds, 1 / 24)
    drift = np.random.default_rng(seed).standard_normal(time.size)
    return SimpleNamespace(time_s=time, x_m=0.8 * (1 + ratio * drift))


def test_r_in_films():
    made = with_r(0.132, 0.134) | {"belt_022_track": film(0.13), "belt_028_track": film(0.10)}
    measurement = measured("r-experiment", "films, sigma = 1", **made)
    assert measurement.judged["r_022"].value == pytest.approx(0.13, rel=0.02)
    assert 0 < measurement.judged["r_022"].high - measurement.judged["r_022"].low < 0.005
    assert components("r-experiment", "films, sigma = 1", **made) == [HOLDS, FAILS, HOLDS, HOLDS]
    assert measurement.runs == 10
    short = made | {"belt_022_track": film(0.13, seconds=890.0)}
    with pytest.raises(NotEnoughDataError, match="belt_022 has 890 s, 900 are needed"):
        measured("r-experiment", "films, sigma = 1", **short)


def test_r_of_a_film_with_a_gap_is_that_of_its_frames():
    """Figs. 4 and 5 print it; a straight line across a gap would count as frames."""
    whole = film(0.13)
    seen = (whole.time_s < 300) | (whole.time_s > 420)
    rest = SimpleNamespace(time_s=whole.time_s[seen], x_m=whole.x_m[seen])
    estimate, full = disorder_of(rest), disorder_of(whole)
    assert estimate.value == pytest.approx(rest.x_m.std() / rest.x_m.mean(), rel=1e-3)
    reach = [side - estimate.value for side in (estimate.low, estimate.high)]
    assert reach[0] < 0 < reach[1] and np.ptp(reach) > full.high - full.low


# --- intermittency --------------------------------------------------------------------------------


def alternating(share_of_runs, agreeing, *, fraction=0.4):
    """Runs of which a share is intermittent at the speeds, and trials that alternate at noises."""
    made = replicates(dict.fromkeys((1.0, 2.2), 17.0), noises=(1.0, 2.2))
    arrays = made.arrays
    chosen = arrays["replicate"] <= 8 * share_of_runs
    arrays["laminar_fraction"] = np.where(chosen & (arrays["noise"] == 1), fraction, 0.0)
    return {"n5_replicates": made, "trials": experiments(agreeing, runs=80)["trials"]}


@pytest.mark.parametrize(
    ("made", "expected"),
    [
        (alternating(1, [1.0]), [HOLDS] * 4),
        (alternating(0, [2.8]), [FAILS] * 4),
        (alternating(1, [1.0], fraction=0.99), [FAILS, FAILS, HOLDS, HOLDS]),
        (alternating(0.25, [1.0], fraction=0.3), [UNDECIDED, UNDECIDED, HOLDS, HOLDS]),
    ],
)
def test_intermittency_at_the_speeds_of_the_experiment(made, expected):
    assert components("intermittency-experiment", **made) == expected


def test_runs_with_laminar_phases_at_the_speeds():
    made = alternating(0.25, [1.0])
    arrays = made["n5_replicates"].arrays
    arrays["laminar_count"] = np.where(arrays["laminar_fraction"] > 0, 3, 0)
    arrays["laminar_longest"] = np.where(arrays["belt_velocity"] == 15.5, 800.0, 300.0)
    also = measured("intermittency-experiment", **made).also
    for speed, longest in (("0.22 m/s", 300.0), ("0.28 m/s", 800.0)):
        assert also[f"runs with laminar phases, {speed}"].value == 0.25
        assert also[f"longest laminar phase, {speed}"].value == longest


def test_each_speed_has_its_own_trials():
    made = alternating(1, [1.0])
    arrays = made["trials"].arrays
    arrays["lasting_longest"][arrays["belt_velocity"] > 13] = 0.0
    assert components("intermittency-experiment", **made) == [HOLDS, HOLDS, HOLDS, FAILS]


def test_trials_of_the_noise_of_the_reading_count():
    made = alternating(1, [2.8])
    assert components("intermittency-experiment", **made)[2:] == [FAILS, FAILS]
    reading = "sigma = 2.2, trials 2 to 2.8"
    assert components("intermittency-experiment", reading, **made) == [FAILS, FAILS, HOLDS, HOLDS]
    few = made["trials"].arrays
    few["lasting_longest"][:] = 0.0
    lucky = np.flatnonzero(np.isin(few["noise"], (2.0, 2.8)))[::20]
    few["lasting_longest"][lucky] = 900.0  # 5 % of them
    assert components("intermittency-experiment", reading, **made)[2:] == [UNDECIDED] * 2


# --- sigma ----------------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("best", "agree", "posterior"),
    [
        ([1.0, 1.4], HOLDS, HOLDS),
        ([0.5], FAILS, FAILS),
        ([1.4, 4.0], HOLDS, UNDECIDED),
        ([4.0], FAILS, FAILS),
        ([0.5, 1.4, 2.8, 4.0], HOLDS, FAILS),
    ],
)
def test_the_noise_of_the_experiment(best, agree, posterior):
    made = experiments(best, runs=30)
    if posterior == UNDECIDED:
        made["trials_free"] = some_agree({1.4: 15, 4.0: 15})
    assert components("sigma-experiment", **made) == [agree, agree, posterior]


def some_agree(count, *, runs=30):
    """Free trials of which so many agree at each noise, with both recordings."""
    made = experiments(list(count), runs=runs)["trials_free"]
    number = np.arange(made.arrays["noise"].size) % runs
    of = np.array([count.get(level, 0) for level in made.arrays["noise"]])
    made.arrays["lasting_longest"] = np.where(number < of, 1000.0, 0.0)
    return made


def test_agreement_of_few_trials_is_undecided():
    made = experiments([1.0, 1.4, 2.0], runs=30)
    made["trials"] = some_agree({1.0: 2, 1.4: 2, 2.0: 2})  # 6 of 90
    verdict = components("sigma-experiment", **made)
    assert verdict == [UNDECIDED, UNDECIDED, HOLDS]


def test_what_is_needed_for_the_noise_of_the_experiment():
    with pytest.raises(NotEnoughDataError, match="78 trials, 80 are needed"):
        measured("sigma-experiment", **experiments([1.0], runs=26))
    few = experiments([1.0], runs=30) | {"trials_free": experiments([1.0], runs=19)["trials_free"]}
    with pytest.raises(NotEnoughDataError, match="19 trials agree with a recording, 20 are needed"):
        measured("sigma-experiment", **few)


def test_levels_stand_for_the_noises_around_them():
    coarse, fine = np.array([0.5, 1.0, 2.0, 4.0]), np.geomspace(0.5, 4, 13)
    for levels in (coarse, fine):
        flat = np.full(levels.size, 1 / levels.size)
        span = levels.size * np.log(levels[1] / levels[0])
        assert between(levels, flat, (1.0, 2.0)) == pytest.approx(np.log(2) / span)
    assert between(coarse, np.array([0, 1.0, 0, 0]), (1.0, 2.0)) == pytest.approx(0.5)
    assert between(coarse, np.array([0, 1.0, 0, 0]), (0.7, 1.5)) == pytest.approx(1.0, abs=0.02)
