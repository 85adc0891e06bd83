"""Survival of irregular motion: known answers, and how often the statistics are wrong."""

from functools import partial

import numpy as np
import pytest
from scipy import stats

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats import survival
from beltrepro.stats.motion import above_zero, resolution

RNG = np.random.default_rng


def followed(lifetime, duration):
    """Lifetimes of runs that are given up at `duration`, and which of them ended."""
    return np.minimum(lifetime, duration), lifetime < duration


def within(count, runs, chance, *, errors=4.0):
    """Whether a count is that of a chance, to four standard errors of the binomial: 1 in 16000."""
    return abs(count / runs - chance) <= errors * np.sqrt(chance * (1 - chance) / runs)


# --- curves ---------------------------------------------------------------------------------------


def test_survival_of_runs_that_all_last_or_all_end():
    lasting = survival.kaplan_meier(np.array([7.0, 7.0, 9.0]), np.zeros(3, bool))
    assert set(lasting.share) == {1.0} and set(lasting.upper) == {1.0}
    np.testing.assert_allclose(lasting.lower, 0.025 ** (1 / 3))
    ending = survival.kaplan_meier(np.full(3, 7.0), np.ones(3, bool))
    assert ending.time.tolist() == [0, 7] and ending.share.tolist() == [1, 0]
    assert ending.lower[-1] == 0 and ending.upper[-1] == pytest.approx(1 - 0.025 ** (1 / 3))
    with pytest.raises(NotEnoughDataError, match="no runs"):
        survival.observed([], [])


def test_the_band_of_survival_holds_95_of_100_times():
    rng, trials, hits = RNG(1), 150, 0
    for _ in range(trials):
        ends, given_up = rng.exponential(1.0, 40), rng.uniform(0.5, 3, 40)
        curve = survival.kaplan_meier(np.minimum(ends, given_up), ends < given_up)
        last = np.searchsorted(curve.time, 0.5, side="right") - 1
        hits += curve.lower[last] <= np.exp(-0.5) <= curve.upper[last]
    # The band is an approximation: 94 to 96 %.
    assert within(hits, trials, 0.95)


# --- mean lifetime --------------------------------------------------------------------------------


def test_a_mean_lifetime_is_time_observed_over_ends():
    lifetime, ended = followed(np.array([2.0, 4, 6, 8, 99]), 10.0)
    estimate = survival.mean_lifetime(lifetime, ended)
    assert (estimate.value, estimate.runs) == (30 / 4, 5)
    later = survival.mean_lifetime(*survival.observed(lifetime, ended, start=4.0))
    assert (later.value, later.runs) == ((0 + 2 + 4 + 6) / 3, 4)


def test_without_an_end_there_is_a_lower_limit_only():
    """The exact one: 16 runs of the least mean lifetime all last with a chance of 2.5 %."""
    estimate = survival.mean_lifetime(np.full(16, 1000.0), np.zeros(16, bool))
    assert estimate.value == estimate.high == np.inf
    assert np.exp(-1000 / estimate.low) ** 16 == pytest.approx(0.025)


def test_the_interval_of_one_end_by_hand():
    """At the longest mean lifetime some run ends, at the shortest one at most, in 2.5 of 100."""
    estimate = survival.mean_lifetime(np.full(16, 1000.0), np.arange(16) == 0)
    assert 1 - np.exp(-16000 / estimate.high) == pytest.approx(0.025)
    expected = 16000 / estimate.low
    assert (1 + expected) * np.exp(-expected) == pytest.approx(0.025)


@pytest.mark.thorough
@pytest.mark.parametrize(("runs", "duration"), [(5, 1.0), (16, 0.1), (16, 0.5), (16, 3.0), (64, 1)])
def test_each_end_of_the_interval_is_wrong_in_at_most_25_of_1000(runs, duration):
    """Exponential lifetimes of mean 1, given up at `duration`."""
    rng, trials = RNG(runs), 2000
    above = below = 0
    for _ in range(trials):
        lifetime, ended = followed(rng.exponential(1.0, runs), duration)
        estimate = survival.mean_lifetime(lifetime, ended)
        above += estimate.low > 1
        below += estimate.high < 1
    most = 0.025 * trials + 4 * np.sqrt(0.025 * 0.975 * trials)
    assert above <= most and below <= most
    # It is not needlessly wide either: 95 to 98.6 %.
    assert above + below >= 0.01 * trials - 4 * np.sqrt(0.01 * trials)


@pytest.mark.parametrize(("mean", "runs"), [(0.15, 24), (0.4, 48), (0.4, 400)])
def test_escapes_are_known_though_some_runs_never_escape(mean, runs):
    """The interval of the runs that ended holds the mean in 95 of 100; that of all never does."""
    rng = RNG(runs)
    held, of_all, samples = 0, 0, 400
    for _ in range(samples):
        lifetime = np.where(rng.random(runs) < 0.4, np.inf, rng.exponential(mean, runs))
        ended, lifetime = lifetime <= 1, np.minimum(lifetime, 1)
        estimate = survival.mean_of_ended(lifetime, ended, horizon=1.0)
        held += estimate.low <= mean <= estimate.high
        every = survival.mean_lifetime(lifetime, ended)
        of_all += every.low <= mean <= every.high
    assert within(held, samples, 0.95)
    assert of_all / samples < 0.2


def test_a_mean_of_ended_runs_by_hand():
    """The exponential distribution that is cut off at the horizon has the mean of the ends."""
    for part in (0.2, 0.4):
        ends = np.array([0.5, 1.0, 1.5]) * part
        estimate = survival.mean_of_ended(100 * ends, np.full(3, True), horizon=100.0)
        rate = 100 / estimate.value
        assert 1 / rate - 1 / np.expm1(rate) == pytest.approx(part, abs=1e-9) and estimate.runs == 3


def test_ends_that_do_not_fall_off_have_no_mean():
    even = survival.mean_of_ended(np.linspace(1, 99, 50), np.full(50, True), horizon=100.0)
    assert even.value == even.high == np.inf and 30 < even.low < 300
    for few in (partial(survival.mean_of_ended, horizon=4.0), survival.weibull_test):
        with pytest.raises(NotEnoughDataError, match="2 runs ended, 3 are needed"):
            few(np.arange(1, 4.0), np.arange(3) < 2)


# --- exponential or not ---------------------------------------------------------------------------


def test_the_weibull_test_by_hand():
    """The likelihood that it maximises, on a grid of shapes; the scale is then a formula."""
    lifetime, ended = followed(RNG(3).exponential(40, 30), 60.0)
    shapes = np.linspace(0.5, 2, 3001)[:, np.newaxis]
    scale = (np.sum(lifetime**shapes, axis=1) / ended.sum()) ** (1 / shapes[:, 0])
    log_hazard = np.log(shapes) - shapes * np.log(scale)[:, np.newaxis]
    log_hazard = log_hazard + (shapes - 1) * np.log(lifetime[ended])
    likelihood = log_hazard.sum(axis=1) - ended.sum()  # sum of (t / scale)^shape = number of ends
    best = int(np.argmax(likelihood))
    exponential = np.flatnonzero(np.isclose(shapes[:, 0], 1))[0]
    p, shape = survival.weibull_test(lifetime, ended)
    assert shape == pytest.approx(shapes[best, 0], abs=1e-3)
    expected = stats.chi2.sf(2 * (likelihood[best] - likelihood[exponential]), 1)
    assert p == pytest.approx(expected, rel=1e-3)


def test_ends_at_the_very_start_say_nothing_of_the_shape():
    lifetime, ended = followed(RNG(3).exponential(40, 30), 60.0)
    with_others = np.append(lifetime, [0.0, 0.0]), np.append(ended, [True, True])
    expected = survival.weibull_test(lifetime, ended)
    assert survival.weibull_test(*with_others) == pytest.approx(expected, rel=1e-3)


# --- verdict --------------------------------------------------------------------------------------


def test_verdicts_by_hand():
    lasting = np.zeros(4, bool)
    assert survival.decide([3.0, 4, 5], [True] * 3, start=6) == survival.REGULAR
    assert survival.decide([3.0, 4, 9], [True] * 3, start=6) == survival.TRANSIENT
    assert survival.decide(np.full(4, 100.0), lasting) == survival.LASTING
    assert survival.decide(np.full(3, 100.0), lasting[:3]) == survival.OPEN
    # Two ends of 16: too few to tell one rate from two kinds of motion.
    ended = np.arange(16) < 2
    assert survival.decide(np.where(ended, 50.0, 100.0), ended) == survival.OPEN
    # What ended before the start does not count.
    assert survival.decide(np.where(ended, 5.0, 100.0), ended, start=10) == survival.LASTING


def test_a_rate_that_rises_does_not_keep_motion_from_being_transient():
    """Half of the runs end, at a rate that rises with time: the others will end too."""
    lifetime, ended = followed(RNG(13).gamma(6.0, 1.0, 60), 5.7)
    p, shape = survival.weibull_test(lifetime, ended)
    assert p < survival.LEVEL and shape > 1
    assert 20 < ended.sum() < 40 and survival.decide(lifetime, ended) == survival.TRANSIENT


def test_two_kinds_of_motion_stay_open():
    """Half of the runs settle early, half last: their rate of ends falls with time."""
    rng = RNG(9)
    for _ in range(10):
        lifetime = np.where(np.arange(16) < 8, rng.exponential(0.05, 16), np.inf)
        assert survival.decide(*followed(lifetime, 1.0)) == survival.OPEN


def test_runs_spread_in_five_e_foldings():
    def start(value, error, time, horizon=1e5):
        return survival.spreading_time(survival.PooledExponent(value, error, time, 9), horizon)

    assert start(0.01, 0.001, 1e4) == pytest.approx(500)
    assert start(0.01, 0.001, 1e4, horizon=3000) == 300  # at most a tenth of it
    assert start(0.01, 0.004, 1e4) == 0  # not above zero
    assert start(0.01, 0.001, 400) == 0  # not seen long enough
    assert start(np.nan, np.nan, 0.0) == 0
    assert resolution(0.001, 400) == 0.0125
    assert above_zero([0.013, 0.012], 0.001, 400).tolist() == [True, False]


# --- exponent of the irregular part ---------------------------------------------------------------


def test_exponents_are_weighted_by_their_time():
    pooled = survival.pool_exponents([0.02, 0.01, np.nan], [1e-3, 1e-3, np.nan], [100, 300, 5])
    assert pooled.value == pytest.approx(0.0125)
    assert (pooled.runs, pooled.time) == (2, 200)
    alike = survival.pool_exponents([0.02, 0.01, 0.06], [1e-3] * 3, [7, 7, 7])
    assert alike.error == pytest.approx(stats.sem([0.02, 0.01, 0.06]))
    one = survival.pool_exponents([0.02], [1e-3], [100])
    assert (one.value, one.error, one.runs) == (0.02, 1e-3, 1)
    none = survival.pool_exponents([np.nan], [np.nan], [0])
    assert np.isnan(none.value) and none.runs == 0


# --- ends that become known late ------------------------------------------------------------------


def test_ends_that_are_known_late_do_not_bias_what_ends_before_the_horizon():
    """Mean 1, given up at 1, and an end is known 0.4 later: counted to 0.5, the mean is found."""
    lifetime = RNG(12).exponential(1.0, 4000)
    expected = lifetime + 0.4 < 1
    seen = np.where(expected, lifetime, 1.0)
    cut = survival.observed(seen, expected, horizon=0.5)
    estimate = survival.mean_lifetime(*cut)
    assert estimate.low < 1 < estimate.high and estimate.high / estimate.low < 1.15
    assert survival.mean_lifetime(seen, expected).low > 1.3
    assert survival.weibull_test(*cut)[0] > 1e-3 and survival.weibull_test(seen, expected)[0] < 1e-6
    curve = survival.kaplan_meier(*cut)
    assert curve.time[-1] == 0.5 and curve.lower[-1] < np.exp(-0.5) < curve.upper[-1]


def test_an_end_after_the_horizon_keeps_motion_from_being_lasting():
    lifetime, ended = np.full(16, 1.0), np.zeros(16, bool)
    assert survival.decide(lifetime, ended, horizon=0.5) == survival.LASTING
    assert survival.decide(lifetime, ended, start=0.6, horizon=0.5) == survival.OPEN
    lifetime[3], ended[3] = 0.9, True
    assert survival.decide(lifetime, ended, horizon=0.5) == survival.OPEN
    assert survival.decide(np.full(4, 0.9), np.ones(4, bool), horizon=0.5) == survival.TRANSIENT
