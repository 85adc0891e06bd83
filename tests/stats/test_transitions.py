"""Falls and rises of r: by hand, against a plain loop, and whether their intervals cover."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats import estimates, transitions
from beltrepro.stats.transitions import fall, find_fall, find_rise, rise

RNG = np.random.default_rng
VELOCITY = np.arange(1.0, 41)
STRAIGHT = np.interp(VELOCITY, [10, 20], [0.12, 0.02])


# --- by hand --------------------------------------------------------------------------------------


def test_a_fall_without_scatter_by_hand():
    """The step is fitted at 15: r_high is 0.11 at first, the median from 7.5 on.

    Of this fall of 0.09, 90 % are kept at r = 0.101, u = 11.9, and 10 % at r = 0.029, u = 19.1.
    Beside these edges the plateaus are 0.12 (6 to 11) and 0.02, so that the edges are 11 and 19.
    """
    first = find_fall(VELOCITY, STRAIGHT, rounds=0)
    assert (first.r_high, first.r_low) == pytest.approx((0.11, 0.02))
    assert (first.lower, first.critical, first.upper) == pytest.approx((11.9, 15.5, 19.1))
    last = find_fall(VELOCITY, STRAIGHT)
    assert (last.r_high, last.r_low) == pytest.approx((0.12, 0.02))
    assert (last.lower, last.critical, last.upper) == pytest.approx((11, 15, 19))
    assert last.width == pytest.approx(8) and last.contrast == pytest.approx(6) and last.exists


def test_plateaus_reach_from_half_the_lower_edge_to_twice_the_upper_one():
    r = np.select([VELOCITY < 7, VELOCITY < 14.5, VELOCITY <= 29], [0.13, 0.12, 0.02], 0.025)
    transition = find_fall(VELOCITY, r)
    assert (transition.r_high, transition.r_low) == (0.12, 0.02)
    assert find_fall(VELOCITY, np.where(VELOCITY < 12, r, 0.02)).r_low == 0.02


def test_a_window_of_low_r_before_the_fall_is_no_end_of_it():
    r = np.where((VELOCITY < 21) & ~np.isin(VELOCITY, (13, 14)), 0.12, 0.02)
    transition = find_fall(VELOCITY, r)
    assert (transition.lower, transition.upper) == pytest.approx((20.1, 20.9))


@pytest.mark.parametrize(("low", "exists"), [(0.05, True), (0.0501, False)])
def test_a_transition_needs_the_stated_contrast(low, exists):
    r = np.where(VELOCITY < 15.5, 0.1, low)
    result = find_fall(VELOCITY, r)
    assert result.exists == exists and (result.r_high, result.r_low) == (0.1, low)
    assert np.isnan(result.critical) != exists
    factor = 1.3 if exists else 1.29
    assert find_rise(VELOCITY, np.where(VELOCITY < 9, low, factor * low)).exists == exists
    assert not find_fall(VELOCITY, 0.01 * VELOCITY).exists


@pytest.mark.parametrize("step", [10.5, 30.5])
def test_a_fall_that_a_window_hides_is_not_found(step):
    """The median over all points is one of the plateaus everywhere."""
    transition = find_fall(VELOCITY, np.where(step > VELOCITY, 0.1, 0.02), window=100.0)
    assert (
        not transition.exists
        and np.isnan([transition.lower, transition.upper, transition.critical]).all()
    )
    assert (transition.r_high, transition.r_low) == (0.1, 0.02)


def test_a_rise_without_scatter_by_hand():
    r = np.interp(VELOCITY, [10, 20], [1.0, 2.0])
    for repeats in (1, 3):
        transition = find_rise(np.repeat(VELOCITY, repeats), np.repeat(r, repeats))
        assert (transition.r_low, transition.r_high) == (1, 2)
        assert (transition.lower, transition.critical, transition.upper) == pytest.approx(
            (11, 15, 19)
        )


def test_replicates_and_dips_weigh_in_the_monotone_curve():
    """One dip among three replicates: the isotonic mean is that of the pooled points."""
    noise = np.repeat(np.arange(8.0), 3)
    r = np.repeat([1.0, 1, 1, 3, 3, 3, 3, 3], 3)
    r[9:12] = [3, 3, 0]  # at sigma = 3 the mean is 2, half way
    assert find_rise(noise, r).critical == pytest.approx(3)
    r[6:9], r[9:12] = 2.5, 1.5  # pooled: 2 at both
    pooled = find_rise(noise, r)
    assert (pooled.lower, pooled.critical) == pytest.approx((1.2, 2))
    # 2.5 once and 1.5 three times are 1.75 together; half way, 2, lies a fifth of a step on
    noise = np.repeat(np.arange(10.0), [3, 3, 1, 3, 3, 3, 3, 3, 3, 3])
    r = np.select([noise < 2, noise < 3, noise < 4], [1.0, 2.5, 1.5], 3.0)
    assert find_rise(noise, r).critical == pytest.approx(3.2)


@pytest.mark.parametrize(("share", "level", "place"), [(0.9, 0.2, 0), (0.4, 0.5, 2), (0.9, 0.8, 1)])
def test_a_curve_that_begins_or_ends_in_the_rise(share, level, place):
    curve = np.array([0.2, 0.8, share]) if share > 0.5 else np.array([0.2, 0.3, share])
    assert transitions._first_passage(np.arange(3.0), curve, level) == pytest.approx(place)


def test_order_ties_and_missing_values_do_not_matter():
    velocity = np.concatenate([VELOCITY, VELOCITY[:7], [np.nan, 3.0]])
    r = np.concatenate([STRAIGHT, np.full(7, 0.11), [9, np.inf]])
    order = RNG(13).permutation(velocity.size)
    assert find_fall(velocity[order], r[order]) == find_fall(velocity, r)
    for find, count, least in ((find_fall, 7, 8), (find_rise, 4, 5)):
        with pytest.raises(NotEnoughDataError, match=f"{count} points along the curve, {least} "):
            find(np.repeat(VELOCITY[:count], 3), np.ones(3 * count))
        assert not find(VELOCITY[:least], np.ones(least)).exists


def test_the_running_median_reaches_half_its_width():
    places, medians = transitions.running_median(
        np.array([0.0, 1, 1, 2, 4]), np.array([5.0, 1, 2, 9, 7]), 2.0
    )
    assert places.tolist() == [0, 1, 2, 4] and medians.tolist() == [2, 3.5, 2, 7]


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
    assert transitions.step(x, y, falling=falling) == min(best, key=best.get)


@pytest.mark.parametrize(("lower", "upper"), [(15.0, 18.0), (23.0, 32.0), (27.0, 40.0)])
def test_a_fall_is_found_among_outliers_in_single_runs(lower, upper):
    """A straight fall with 5 % scatter, periodic windows below it and large amplitudes beyond."""
    velocity = np.arange(0.5, 50.1, 0.5)
    r = np.interp(velocity, [lower, upper], [0.13, 0.02]) * RNG(0).normal(1, 0.05, velocity.size)
    r[np.searchsorted(velocity, [5.0, 7.0])] = 0.06
    r[np.searchsorted(velocity, [upper + 3, upper + 4, upper + 5])] = 0.11
    numbers = fall(velocity, r)
    inset = 0.1 * (upper - lower)  # of a straight fall 10 % to 90 % are 80 % of its width
    assert numbers["lower"].value == pytest.approx(lower + inset, abs=1.0)
    assert numbers["upper"].value == pytest.approx(upper - inset, abs=1.0)
    assert numbers["r_high"].value == pytest.approx(0.13, abs=0.01)
    assert numbers["r_low"].value == pytest.approx(0.02, abs=0.01)
    # one run a point tells no error, and takes a window
    assert {(one.low, one.high, one.runs) for one in numbers.values()} == {(-np.inf, np.inf, 1)}
    window = transitions.SINGLE_RUNS_WINDOW
    assert numbers["critical"].value == find_fall(velocity, r, window=window).critical


# --- estimates ------------------------------------------------------------------------------------


def test_runs_are_drawn_anew_at_each_place_by_itself(monkeypatch):
    """Against a plain loop, with 4, 7 and 5 runs at three kinds of places."""
    monkeypatch.setattr(estimates, "RESAMPLES", 7)
    rng = RNG(3)
    count = np.resize([4, 7, 5], VELOCITY.size)
    noise, r = np.repeat(VELOCITY, count), np.repeat(0.2 - STRAIGHT, count)
    r = r * rng.lognormal(0, 0.3, r.size)
    rng, samples = RNG(0), []
    for _ in range(7):
        numbers, drawn = rng.random(r.size), []
        for place in VELOCITY:
            chosen = r[noise == place]
            drawn += [chosen[int(number * chosen.size)] for number in numbers[noise == place]]
        samples.append(find_rise(noise, np.array(drawn)).r_low)
    expected = estimates.from_resamples(find_rise(noise, r).r_low, np.array(samples), 4)
    order = rng.permutation(r.size)
    assert rise(noise, r)["r_low"] == expected
    assert rise(noise[order], r[order])["critical"].value == rise(noise, r)["critical"].value


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
    assert np.isnan(fall(VELOCITY, 0.1 + 0 * VELOCITY)["critical"].low)  # of single runs too
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
