"""Steps and rises of r: by hand, and whether their intervals cover."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats import estimates, transition
from beltrepro.stats.transition import contrast_of_step, find_rise, rise

RNG = np.random.default_rng
VELOCITY = np.arange(1.0, 41)
STRAIGHT = np.interp(VELOCITY, [10, 20], [0.12, 0.02])


# --- by hand --------------------------------------------------------------------------------------


def test_a_rise_without_scatter_by_hand():
    r = np.interp(VELOCITY, [10, 20], [1.0, 2.0])
    for repeats in (1, 3):
        rising = find_rise(np.repeat(VELOCITY, repeats), np.repeat(r, repeats))
        assert (rising["r_low"], rising["r_high"], rising["contrast"]) == (1, 2, 2)
        edges = [rising[name] for name in ("lower", "critical", "upper", "width")]
        assert edges == pytest.approx([11, 15, 19, 8])
    single = rise(VELOCITY, r)["critical"]
    assert single.numbers == pytest.approx((15, -np.inf, np.inf)) and single.runs == 1


def test_replicates_and_dips_weigh_in_the_monotone_curve():
    """One dip among three replicates: the isotonic mean is that of the pooled points."""
    noise = np.repeat(np.arange(8.0), 3)
    r = np.repeat([1.0, 1, 1, 3, 3, 3, 3, 3], 3)
    r[9:12] = [3, 3, 0]  # at sigma = 3 the mean is 2, half way
    assert find_rise(noise, r)["critical"] == pytest.approx(3)
    r[6:9], r[9:12] = 2.5, 1.5  # pooled: 2 at both
    pooled = find_rise(noise, r)
    assert (pooled["lower"], pooled["critical"]) == pytest.approx((1.2, 2))
    # 2.5 once and 1.5 three times are 1.75 together; half way, 2, lies a fifth of a step on
    noise = np.repeat(np.arange(10.0), [3, 3, 1, 3, 3, 3, 3, 3, 3, 3])
    r = np.select([noise < 2, noise < 3, noise < 4], [1.0, 2.5, 1.5], 3.0)
    assert find_rise(noise, r)["critical"] == pytest.approx(3.2)


@pytest.mark.parametrize(("high", "there"), [(1.3, True), (1.29, False)])
def test_a_rise_needs_its_contrast_and_five_points(high, there):
    rising = find_rise(VELOCITY, np.where(VELOCITY < 9, 1.0, high))
    assert np.isfinite(rising["critical"]) == there and rising["contrast"] == high
    with pytest.raises(NotEnoughDataError, match="4 points along the curve, 5 are needed"):
        find_rise(VELOCITY[:4], VELOCITY[:4])


def test_levels_beside_a_step_reach_from_half_its_position_to_twice_it():
    """The step of a straight fall from 0.12 to 0.02 is at 15: medians from 7.5 and up to 30."""
    assert contrast_of_step(VELOCITY[::-1], STRAIGHT[::-1]) == pytest.approx(0.11 / 0.02)
    assert np.isnan(contrast_of_step(VELOCITY, VELOCITY))  # r falls nowhere


@pytest.mark.parametrize("falling", [True, False])
def test_the_step_is_the_best_of_all_two_level_steps(falling):
    """All splits tried, each level a median; the other direction is left out."""
    rng = RNG(14)
    x = np.sort(rng.choice(12, 30).astype(float))
    y = rng.random(30) + np.where(x < 5, 0.6, 0.0) * (1 if falling else -1)
    best = {}
    for cut in np.unique(x)[:-1]:
        low, high = y[x <= cut], y[x > cut]
        if (np.median(low) > np.median(high)) == falling:
            cost = sum(np.abs(side - np.median(side)).sum() for side in (low, high))
            best[(cut + np.unique(x)[np.unique(x) > cut][0]) / 2] = cost
    assert transition.best_step(x, y, falling=falling) == min(best, key=best.get)


# --- estimates ------------------------------------------------------------------------------------


def test_sharp_rises_are_known_to_the_spacing_of_the_grid():
    """Resampling moves nothing; a jump anywhere between 15 and 15.5 is covered."""
    noise = np.repeat(np.arange(1.0, 41, 0.5), 8)
    numbers = rise(noise, np.where(noise < 15.2, 0.08, 0.18))
    assert numbers["r_high"].low == numbers["r_high"].high == numbers["r_high"].value
    for name in ("critical", "lower", "upper"):
        assert numbers[name].low < 15.0 + 1e-9 and numbers[name].high > 15.5 - 1e-9, name
    assert numbers["width"].low <= 0
    assert numbers["critical"].high - numbers["critical"].low == pytest.approx(0.5)


def test_few_runs_and_no_transition():
    noise = np.repeat(VELOCITY, 4)
    flat = rise(noise, np.where(noise < 15, 0.08, 0.1))
    assert np.isnan([flat["critical"].value, flat["width"].low]).all()
    assert flat["contrast"].value == pytest.approx(1.25) and flat["critical"].runs == 4
    for runs in (2, 3):
        with pytest.raises(NotEnoughDataError, match=f"{runs} runs at a point, 4 are needed"):
            rise(np.repeat(VELOCITY, runs), np.repeat(STRAIGHT, runs))


# --- coverage -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("scatter", [0.0, 0.3])
def test_intervals_of_the_critical_noise_cover_the_truth(scatter, monkeypatch):
    """Gradual rises of each run, and runs on two branches."""
    monkeypatch.setattr(estimates, "RESAMPLES", 100)
    noise, covered, rng = np.repeat(np.arange(0.1, 2.01, 0.1), 8), 0, RNG(3)
    for truth in rng.uniform(0.6, 1.2, 60):
        part = np.clip((noise - truth) / 0.3 + 0.5, 0, 1)
        if scatter:
            part = rng.random(noise.size) < 1 / (1 + np.exp((truth - noise) / 0.08))
        critical = rise(noise, 0.06 + 0.07 * part + 0.003 * rng.standard_normal(noise.size))[
            "critical"
        ]
        covered += critical.low <= truth <= critical.high
    assert covered >= 54
