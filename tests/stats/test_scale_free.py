"""Power laws with ends and cutoffs: fits against tops of the likelihood, and tests of fit."""

import numpy as np
import pytest
from scipy import optimize

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats import estimates, scale_free

RNG = np.random.default_rng


def power_law(exponent, low, high, size, seed=0):
    rate = exponent + 1
    ends = np.array([low, high]) ** rate
    return (ends[0] + RNG(seed).random(size) * np.diff(ends)) ** (1 / rate)


def with_cutoff(exponent, decay, low, high, size, seed=0):
    """By rejection."""
    values = power_law(exponent, low, high, 40 * size, seed)
    kept = RNG(seed + 1).random(values.size) < np.exp(-decay * (values - low))
    assert kept.sum() >= size
    return values[kept][:size]


@pytest.mark.parametrize("exponent", [-0.87, -1.47, -2.5, 0.7])
@pytest.mark.parametrize("decay", [0.0, 0.01])
def test_laws_are_recovered_over_less_than_a_decade(exponent, decay):
    values = with_cutoff(exponent, decay, 60, 400, 40_000)
    if decay == 0:
        law = scale_free.fit_values(values, 60, 400)
        assert law.exponent == pytest.approx(exponent, abs=0.04) and law.decay == 0
    law = scale_free.fit_values(values, 60, 400, decay=True)
    assert law.exponent == pytest.approx(exponent, abs=0.2)
    assert law.decay == pytest.approx(decay, abs=1.2e-3)
    assert (law.low, law.high) == (60, 400)


@pytest.mark.parametrize("kind", [{}, {"decay": True}, {"power": False, "decay": True}])
def test_a_fit_is_the_top_of_the_likelihood(kind):
    values = with_cutoff(-1.2, 0.004, 60, 400, 3000)
    x = np.geomspace(60, 400, 20_001)
    power, decay = kind.get("power", True), kind.get("decay", False)

    def minus(factors):
        own = list(factors)
        exponent = own.pop(0) if power else 0.0
        rate = own.pop(0) / 100 if decay else 0.0
        norm = np.trapezoid(x**exponent * np.exp(-rate * x), x)
        return -np.mean(exponent * np.log(values) - rate * values) + np.log(norm)

    start = np.zeros(power + decay)
    best = optimize.minimize(
        minus, start, method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-13}
    )
    law = scale_free.fit_values(values, 60, 400, **kind)
    expected = list(best.x)
    if power:
        assert law.exponent == pytest.approx(expected.pop(0), abs=1e-4)
    if decay:
        assert 100 * law.decay == pytest.approx(expected.pop(0), abs=1e-4)
    assert np.mean(law.log_density(values)) == pytest.approx(-best.fun, abs=1e-6)
    assert np.trapezoid(np.exp(law.log_density(x)), x) == pytest.approx(1, rel=1e-6)


def means_of(law):
    """Of ln x and of x, by a fine sum."""
    x = np.geomspace(law.low, law.high, 400_001)
    density = np.exp(law.log_density(x))
    return np.trapezoid(density * np.log(x), x), np.trapezoid(density * x, x)


@pytest.mark.parametrize("decay", [False, True])
def test_a_fitted_law_has_the_means_of_the_values(decay):
    values = with_cutoff(-1.2, 0.004, 60, 400, 3000)
    law = scale_free.fit_values(values, 60, 400, decay=decay)
    mean_log, mean = means_of(law)
    assert mean_log == pytest.approx(np.log(values).mean(), rel=1e-9)
    if decay:
        assert mean == pytest.approx(values.mean(), rel=1e-9)


def test_a_law_is_found_also_where_the_root_of_the_slopes_is_not(monkeypatch):
    values = with_cutoff(-1.2, 0.004, 60, 400, 3000)
    law = scale_free.fit_values(values, 60, 400, decay=True)
    lost = optimize.OptimizeResult(success=False, x=np.full(2, 1e9))
    monkeypatch.setattr(optimize, "root", lambda *args, **kwargs: lost)
    again = scale_free.fit_values(values, 60, 400, decay=True)
    assert again != law
    assert again.exponent == pytest.approx(law.exponent, abs=1e-3)
    assert again.decay == pytest.approx(law.decay, abs=1e-5)


def test_a_fit_needs_values_in_a_range():
    with pytest.raises(NotEnoughDataError, match="49 values between 1 and 2, 50 are needed"):
        scale_free.fit_values(np.full(49, 1.5), 1, 2)
    with pytest.raises(NotEnoughDataError, match="span no range"):
        scale_free.fit_law(0.0, 1.0, 1.0, 1.0)
    with pytest.raises(NotEnoughDataError, match="at one end"):
        scale_free.fit_law(np.log(2.0), 2.0, 1.0, 2.0)


def test_values_that_repeat_within_chains_are_worth_less():
    rng = RNG(2)
    chain = np.repeat(np.arange(50), 40)
    alone = scale_free.independent_values(rng.normal(size=2000), chain)
    assert 1000 < alone <= 2000
    repeated = scale_free.independent_values(np.repeat(rng.normal(size=200), 10), chain)
    assert 120 < repeated < 330
    assert scale_free.independent_values(np.ones(2000), chain) == 50


@pytest.mark.thorough
def test_the_p_value_of_a_power_law_is_uniform_and_that_of_others_is_small():
    found = [
        scale_free.goodness_of_fit(power_law(-1.47, 60, 400, 300, seed), [60.0], samples=60).p
        for seed in range(30)
    ]
    assert 0.35 < np.mean(found) < 0.65 and np.mean(np.array(found) < 0.1) < 0.25
    exponential = 60 + RNG(3).exponential(60, 1000)
    assert scale_free.goodness_of_fit(exponential, [60.0], samples=60).p == 0
    # so few values could not tell
    assert scale_free.goodness_of_fit(exponential, [60.0], independent=60, samples=60).p > 0.1


def test_the_range_of_a_power_law_is_found():
    below = RNG(4).uniform(20, 100, 1500)
    values = np.r_[below, power_law(-1.8, 100, 2000, 3000, 5)]
    lows = np.array([20.0, 50.0, 100.0, 200.0])
    fit = scale_free.goodness_of_fit(values, lows, samples=40)
    assert fit.law.low in (100.0, 200.0) and fit.p > 0.05
    assert fit.law.exponent == pytest.approx(-1.8, abs=0.15)
    assert scale_free.goodness_of_fit(values, lows[:1], samples=40).p == 0
    with pytest.raises(NotEnoughDataError, match=r"1 values above 2e\+03, 50 are needed"):
        scale_free.goodness_of_fit(values, [20.0, 1999.0], samples=1)


@pytest.mark.parametrize("seed", range(3))
def test_the_nearest_law_is_that_of_a_plain_search(seed):
    """Over whole ends, which are values themselves; the longest distance on either side counts."""
    values = np.ceil(power_law(-1.8, 10, 300, 400, seed))
    lows = [10.0, 25.0, 17.0]
    tried = []
    for low in lows:
        law = scale_free.fit_values(values, low, values.max())
        tail = np.sort(values[values >= low])
        x = np.geomspace(law.low, law.high, 20_001)
        density = np.exp(law.log_density(x))
        below = np.r_[0, np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(x))]
        rank = np.interp(tail, x, below)
        distances = [abs(np.arange(k, k + tail.size) / tail.size - rank).max() for k in (0, 1)]
        tried.append((max(distances), law))
    fit = scale_free.goodness_of_fit(values, lows, samples=1)
    distance, law = min(tried, key=lambda pair: pair[0])
    assert fit.distance == pytest.approx(distance, abs=1e-6)
    assert (fit.law.low, fit.law.high) == (law.low, values.max())
    assert fit.law.exponent == pytest.approx(law.exponent)


@pytest.mark.slow
@pytest.mark.parametrize("decay", [0.0, 0.01])
def test_the_interval_of_a_cutoff_covers_it(decay):
    """Chains drawn anew, as for the claims."""
    found = []
    for seed in range(40):
        values = with_cutoff(-1.47, decay, 60, 400, 3200, seed).reshape(16, -1)
        sums = np.stack([np.log(values).sum(1), values.sum(1)], axis=1)

        def rate(drawn, count=values.shape[1]):
            means = drawn.mean(axis=0) / count
            return scale_free.fit_law(*means, 60, 400, decay=True).decay

        found.append(estimates.bootstrap(rate, [sums], resamples=100))
    assert sum(each.low <= decay <= each.high for each in found) >= 34
