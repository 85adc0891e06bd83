"""Claims on the noise of the experiment: made-up runs and trials with a known answer."""

import numpy as np
import pytest

from alternating import experiments
from beltrepro.replication.verdicts.criteria import IN_PART, NO, NOT_TESTABLE, YES
from made_up import both, few_resamples, measured, replicates  # noqa: F401

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
        (0.132, 0.105, (IN_PART, IN_PART)),
        (0.140, 0.140, (IN_PART, IN_PART)),
        (0.005, 0.900, (NO, NO)),
        (0.022, 0.165, (NO, IN_PART)),  # of the same order
    ],
)
def test_r_at_the_speeds_of_the_experiment(first, second, verdicts):
    assert both("r-experiment", **with_r(first, second)) == verdicts


def test_r_is_a_mean_over_runs_at_one_noise():
    r_028 = measured("r-experiment", **with_r(0.132, 0.134, scatter=0.02)).judged["r_028"]
    assert r_028.runs == 16 and 0.01 < r_028.high - r_028.low < 0.04
    other = measured("r-experiment", "sigma = 1", **with_r(0.1, 0.2, noise=1.0)).judged
    assert other["r_022"].value == pytest.approx(0.1, abs=0.003)
    held = 0.84 / (0.84 + 4.5 * 0.04)  # <x_5> of 600 units, without and with 4.5 blocks, in metres
    for name, ratio in (("r_022", 0.1 / 0.072), ("r_028", 0.2 / 0.052)):
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


# --- sigma ----------------------------------------------------------------------------------------


def test_the_noise_of_the_experiment_is_not_testable_but_measured():
    made = experiments([1.0, 1.4], runs=30)
    assert both("sigma-experiment", **made) == (NOT_TESTABLE, NOT_TESTABLE)
    for best, agree in (([1.0, 1.4], 2 / 3), ([4.0], 0.0)):
        made = experiments(best, runs=30)
        shares = measured("sigma-experiment", **made).also
        assert [share.value for share in shares.values()] == pytest.approx([agree] * 2)
