"""Intervals of estimates: closed forms, and how often they cover what they estimate."""

import math

import numpy as np
import pytest
from scipy import stats

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate

TRIALS = 400
# of 400 trials at 95 %, 359 to 396 cover with a probability of 99.999 %
FEWEST, MOST = stats.binom.ppf([5e-6, 1 - 5e-6], TRIALS, 0.95)


def covered(truth, numbers):
    return sum(one.low <= truth <= one.high for one in numbers)


def test_a_mean_covers_its_expectation_in_95_percent():
    rng = np.random.default_rng(1)
    numbers = [estimates.mean(rng.normal(3.0, 2.0, 8)) for _ in range(TRIALS)]
    assert FEWEST <= covered(3.0, numbers) <= MOST
    assert numbers[0].runs == 8
    with pytest.raises(NotEnoughDataError, match="1 runs"):
        estimates.mean([1.0])


def test_bootstrap_of_eight_runs_covers_in_95_percent():
    """With percentiles of 2.5 and 97.5 % it would be 90 %."""
    rng = np.random.default_rng(6)
    groups = ([rng.normal(3, 2, 8)] for _ in range(TRIALS))
    numbers = [estimates.bootstrap(np.mean, group, resamples=250) for group in groups]
    assert FEWEST <= covered(3.0, numbers) <= MOST


def test_groups_are_drawn_by_themselves():
    """Groups that differ among themselves but not within have no error."""
    constant = estimates.bootstrap(lambda *g: float(np.ptp(g)), [np.full(8, k) for k in range(5)])
    assert (constant.value, constant.low, constant.high) == (4, 4, 4)
    spaced = estimates.bootstrap(lambda *g: 1.0, [np.zeros(8)], grid_spacing=0.5)
    assert (spaced.low, spaced.high) == (0.75, 1.25)
    single = estimates.bootstrap(lambda one, two: one.mean() + two.mean(), [[1.0], [2.0, 3.0]])
    assert single == Estimate(3.5, -math.inf, math.inf, 1)


def test_what_is_often_not_found_has_no_interval():
    samples = np.r_[np.ones(94), np.full(6, math.nan)]
    assert math.isnan(estimates.from_resamples(1.0, samples, 8).low)
    samples[94] = 1.0
    assert estimates.from_resamples(1.0, samples, 8).low == 1.0
    assert math.isnan(estimates.from_resamples(math.nan, samples, 8).value)


def test_a_value_beyond_its_own_resamples_is_an_end_of_the_interval():
    for value, ends in ((1.0, (1, 2)), (3.0, (2, 3))):
        assert estimates.from_resamples(value, np.full(99, 2.0), 8).numbers == (value, *ends)


def test_differences_and_ratios():
    one, other = Estimate(5.0, 4.0, 8.0, 9), Estimate(2.0, 1.0, 6.0, 8)
    estimate = estimates.difference(one, other)
    assert estimate == Estimate(3.0, 3 - math.hypot(1, 4), 3 + math.hypot(3, 1), 8)
    assert estimates.ratio(one, one).value == 1.0
    wide = estimates.ratio(Estimate(8.0, 4.0, 16.0, 9), Estimate(2.0, 2.0, 2.0))
    assert (wide.value, wide.low, wide.high) == pytest.approx((4, 2, 8))


def test_a_slope_covers_and_scatter_widens_it():
    rng = np.random.default_rng(4)
    places = np.arange(6.0)

    def line(error, said):
        values = 1 + 0.5 * places + rng.normal(0, error, 6)
        points = [Estimate(v, v - 1.96 * said, v + 1.96 * said, 8) for v in values]
        return estimates.slope(places, points)

    results = [line(0.2, 0.2) for _ in range(TRIALS)]
    assert covered(0.5, results) >= FEWEST
    assert covered(0.5, [line(0.2, 0.05) for _ in range(TRIALS)]) >= 0.88 * TRIALS
    with pytest.raises(NotEnoughDataError, match="2 points"):
        estimates.slope([1, 2], [Estimate(1, 0, 2), Estimate(1, 0, 2)])


def test_a_trend_is_the_slope_of_least_squares_with_the_errors_of_its_points():
    places = [5, 6, 7, 10]
    points = [Estimate(v, v - 0.1, v + 0.3, 8) for v in (1.0, 3.0, 2.0, 0.0)]
    estimate = estimates.trend(places, points)
    rises = (np.array([10]) - 7) / 14, (np.array([5, 6]) - 7) / 14
    assert estimate.value == pytest.approx(np.polyfit(places, [1, 3, 2, 0], 1)[0])
    sides = estimate.value - estimate.low, estimate.high - estimate.value
    for side, (up, down) in zip(sides, ((0.1, 0.3), (0.3, 0.1)), strict=True):
        assert side == pytest.approx(math.hypot(*(up * rises[0]), *(down * rises[1])))
    # one in the middle has no weight, one elsewhere has
    unknown = Estimate(1.0, -math.inf, math.inf, 1)
    middle = estimates.trend(places, [*points[:2], unknown, points[3]])
    assert math.isfinite(middle.low) and middle.runs == 1
    assert estimates.trend(places, [unknown, *points[1:]]).high == math.inf


@pytest.mark.parametrize("runs", [5, 30])
def test_intervals_hold_the_true_share_as_often_as_they_say(runs):
    """Summed over all counts: 95 % or more, and that of what is open covers both ends."""
    for true in (0.02, 0.3, 0.5):
        chance = stats.binom.pmf(np.arange(runs + 1), runs, true)
        numbers = [estimates.share(count, runs) for count in range(runs + 1)]
        held = [one.low <= true <= one.high for one in numbers]
        assert chance @ held >= 0.95 and all(one.low <= one.value <= one.high for one in numbers)
    having, unknown = np.arange(runs) < 1, np.arange(runs) < 4  # what is known is not open
    both = estimates.share_of(having, unknown)
    assert (both.low, both.high) == (estimates.share(1, runs).low, estimates.share(4, runs).high)


def test_few_values_make_no_stretches():
    """Empty stretches would count as independent ones."""
    with pytest.raises(NotEnoughDataError, match="31 values, 32 are needed"):
        estimates.sums_in_stretches(np.arange(31.0), np.ones(31))


@pytest.mark.parametrize("unlike", [True, False])
def test_stretches_unlike_their_neighbours_are_runs_and_of_others_fewer_count(unlike):
    number = np.arange(16)
    values = number**1.5 * (-1) ** number if unlike else np.cos(np.pi / 3 * number)
    parts = np.column_stack([np.ones(16), values])
    one = estimates.from_stretches(lambda sums: 5 * sums[1] / sums[0], parts)
    apart = values - values.mean()
    alike = 0.0 if unlike else apart[1:] @ apart[:-1] / (apart @ apart)
    count = 16 * (1 - alike) / (1 + alike)
    reach = stats.t.ppf(0.975, count - 1) * 5 * values.std(ddof=1) / np.sqrt(count)
    expected = 5 * values.mean() + reach * np.array([0, -1, 1])
    assert one.numbers == pytest.approx(expected) and one.runs == int(count)
    lost = estimates.from_stretches(lambda sums: np.nan if sums[0] < 16 else 1, parts)
    assert (lost.value, lost.runs) == (1, 1) and math.isnan(lost.high)
