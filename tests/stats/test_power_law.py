"""Power laws: fits against sums over the law, tests of fit, and straight lines."""

import math

import numpy as np
import pytest
from scipy import stats

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats import power_law as laws
from samples import power_law

RNG = np.random.default_rng


@pytest.mark.parametrize("exponent", [-0.87, -1.0, -1.0001, -1.47, -2.5, 0.7])
@pytest.mark.parametrize(("low", "high"), [(60, 400), (1e-3, 40.0)])
def test_a_fit_has_the_mean_logarithm_of_the_values(exponent, low, high):
    """The top of the likelihood: where the law has the mean of ln x that the values have."""
    x = np.geomspace(low, high, 400_001)
    shape = x**exponent
    mean_log = np.trapezoid(shape * np.log(x), x) / np.trapezoid(shape, x)
    assert laws.fit_exponent(mean_log, low, high) == pytest.approx(exponent, abs=1e-6)


def test_a_fit_needs_values_in_a_range():
    with pytest.raises(NotEnoughDataError, match="span no range"):
        laws.fit_exponent(0.0, 1.0, 1.0)
    for mean_log in (np.log(2.0), 0.0, 1e-9, np.log(2.0) - 1e-9):
        with pytest.raises(NotEnoughDataError, match="at one end"):
            laws.fit_exponent(mean_log, 1.0, 2.0)


def test_values_that_repeat_within_chains_are_worth_less():
    rng = RNG(2)
    chain = np.repeat(np.arange(50), 40)
    alone = laws.independent_values(rng.normal(size=2000), chain)
    assert 1000 < alone <= 2000
    repeated = laws.independent_values(np.repeat(rng.normal(size=200), 10), chain)
    assert 120 < repeated < 330
    assert laws.independent_values(np.ones(2000), chain) == 50
    # one value that is a chain by itself is far from the mean by chance
    longer, values = np.append(np.repeat(np.arange(9), 100), 9), rng.normal(size=901)
    values[-1] = 3.0
    assert laws.independent_values(values, longer) > 300


@pytest.mark.parametrize("step", [1.0, 0.3])
def test_rounded_values_are_refused(step):
    """Their steps would decide: p = 0 for whole numbers of a power law itself."""
    values = power_law(-1.5, 1, 100, 2000)
    with pytest.raises(NotEnoughDataError, match=f"in steps of {step:g}"):
        laws.goodness_of_fit(0.25 + step * np.rint(values / step), [1.25], 2000, samples=20)
    for step in (0.0, 1e-4):  # rounded to more digits than matter, or in orbits that repeat
        fine = step * np.rint(values / step) if step else np.repeat(values[:400], 5)
        assert laws.goodness_of_fit(fine, [fine.min()], 200, samples=20).p > 0.1


def test_a_few_values_up_to_rounding_are_told_as_such():
    values = np.repeat([1.0, 1.5, 2.7], 40) + np.tile([0.0, 2.0**-50], 60)
    with pytest.raises(NotEnoughDataError, match="only 3 distinct values"):
        laws.goodness_of_fit(values, [1.0], 120)


@pytest.mark.parametrize("seed", range(3))
def test_the_nearest_law_is_that_of_a_plain_search(seed):
    """Over ends that are values themselves; the longest distance on either side counts."""
    lows = [10.0, 25.0, 17.0]
    values = np.r_[lows, power_law(-1.8, 10, 300, 400, seed)]
    tried = []
    for low in lows:
        tail = np.sort(values[values >= low])
        exponent = laws.fit_exponent(np.log(tail).mean(), low, values.max())
        x = np.geomspace(low, values.max(), 20_001)
        density = x**exponent
        below = np.r_[0, np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(x))]
        rank = np.interp(tail, x, below / below[-1])
        distances = [abs(np.arange(k, k + tail.size) / tail.size - rank).max() for k in (0, 1)]
        tried.append((max(distances), low, exponent))
    fit = laws.goodness_of_fit(values, lows, values.size, samples=1)
    _, low, exponent = min(tried)
    assert (fit.exponent, fit.low, fit.high) == (pytest.approx(exponent), low, values.max())


# --- straight lines -------------------------------------------------------------------------------


def test_a_line_has_the_slope_of_least_squares_where_weights_repeat_points():
    x = np.geomspace(0.5, 60, 9)
    y = 3 * x**-1.3 * np.exp(0.2 * RNG(0).standard_normal(9))
    count = np.array([1, 3, 1, 2, 5, 1, 1, 4, 2])
    fit = laws.fit_log_log(x, y, low=0.5, high=60, weight=count)
    line = stats.linregress(np.log(np.repeat(x, count)), np.log(np.repeat(y, count)))
    assert fit.exponent == pytest.approx(line.slope)
    assert fit.prefactor == pytest.approx(math.exp(line.intercept))
    assert (fit.low, fit.high, fit.sample_size) == (0.5, 60, 9)
    assert fit(2.0) == pytest.approx(fit.prefactor * 2**line.slope)


def test_a_fit_takes_the_points_in_its_range_that_have_a_logarithm_and_a_weight():
    x = np.array([-1.0, 0.0, 1, 2, 4, 8, 16, 32, 64])
    y = np.array([5.0, 5, 1, 2, 0, 8, 16, 32, 1e9])
    weight = np.array([1.0, 1, 1, 1, 1, 1, 0, 1, 1])
    fit = laws.fit_log_log(x, y, low=-2, high=32, weight=weight)
    assert fit.sample_size == 4 and fit.exponent == pytest.approx(1)
    assert laws.fit_log_log(x, y, low=1, high=32).sample_size == 5
    with pytest.raises(NotEnoughDataError, match="3 points between 2 and 32, 4 are needed"):
        laws.fit_log_log(x, y, low=2, high=32, weight=weight)
