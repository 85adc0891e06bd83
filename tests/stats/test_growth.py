"""Finite-size exponents: growth whose exponent is known at every size."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats.growth import finite_size_exponents

LEVELS = np.geomspace(1e-6, 1.0, 13)


def passages(distance, times, levels):
    """First times (L,) at which distances (T,) are above each level."""
    place = np.searchsorted(np.maximum.accumulate(distance), levels)
    return np.append(times, np.nan)[np.minimum(place, len(times))]


def test_pure_exponential_growth_has_its_exponent_at_every_size_and_no_error():
    starts = 1e-6 * np.array([1.0, 0.5, 0.1])
    growth = finite_size_exponents(LEVELS, np.log(LEVELS / starts[:, None]) / 0.02, 1e4)
    np.testing.assert_allclose(growth.exponent, 0.02, rtol=1e-12)
    np.testing.assert_allclose(growth.standard_error, 0.0, atol=1e-15)
    np.testing.assert_allclose(growth.size, np.sqrt(LEVELS[1:] * LEVELS[:-1]))
    assert growth.passed.tolist() == [3] * 12


@pytest.mark.thorough
def test_a_random_walk_grows_the_slower_the_larger_it_is():
    """From a to b it takes (b^2 - a^2) / s^2 on average, so the exponent falls as size^-2."""
    random = np.random.default_rng(1)
    levels = np.geomspace(1.0, 10.0, 5)
    step, times = 0.05, []
    for _ in range(100):
        walk = np.abs(np.cumsum(step * random.standard_normal(300_000)))
        times.append(passages(walk, step**2 * np.arange(1.0, len(walk) + 1), levels))
    growth = finite_size_exponents(levels, times, step**2 * 300_000)
    # a level is passed by 0.58 steps more than it says
    moved = levels + 0.58 * step
    expected = np.diff(np.log(levels)) / np.diff(moved**2)
    assert np.all(np.abs(growth.exponent - expected) < 4 * growth.standard_error)
    assert np.all(growth.standard_error < 0.2 * growth.exponent)


def test_the_exponent_of_a_map_is_found_at_small_sizes():
    """The logistic map at 4: ln 2, though the growth of one step is anything from 0 to 4."""
    random = np.random.default_rng(2)
    one = random.uniform(0.1, 0.9, 4000)
    other = one + 1e-12
    apart = [np.abs(other - one)]
    for _ in range(80):
        one, other = 4 * one * (1 - one), 4 * other * (1 - other)
        apart.append(np.abs(other - one))
    levels = np.array([1e-10, 1e-8, 1e-6, 1e-4])
    times = [passages(run, np.arange(81.0), levels) for run in np.array(apart).T]
    growth = finite_size_exponents(levels, times, 80.0)
    # distances grow by about 2 a step, so a level is passed up to half a step late, of 6.6 steps
    assert growth.exponent == pytest.approx(np.full(3, np.log(2)), abs=0.03)
    assert np.all(growth.standard_error < 0.01)


def test_runs_that_stay_below_a_level_count_with_their_time():
    """A passage comes at the rate 0.1, and half of the runs are watched too short to see it."""
    random = np.random.default_rng(3)
    waits = random.exponential(10.0, 4000)
    watched = 7.0
    times = np.column_stack([np.zeros(4000), np.where(waits < watched, waits, np.nan)])
    growth = finite_size_exponents([1.0, np.e], times, watched)
    assert 0.4 < growth.passed[0] / 4000 < 0.6
    assert abs(growth.exponent[0] - 0.1) < 4 * growth.standard_error[0] < 0.01
    assert growth.standard_error[0] == pytest.approx(0.1 / np.sqrt(growth.passed[0]), rel=0.1)


def test_a_limit_is_the_rate_of_one_passage():
    times = [[0.0, np.nan, np.nan], [0.0, 30.0, np.nan], [np.nan, np.nan, np.nan]]
    growth = finite_size_exponents([1.0, np.e, np.e**3], times, 100.0)
    np.testing.assert_allclose(growth.limit, [1 / 130, 2 / 70])
    assert growth.passed.tolist() == [1, 0]
    nowhere = finite_size_exponents([1.0, np.e, np.e**3], [[0.0, np.nan, np.nan]], 100.0)
    np.testing.assert_array_equal(nowhere.limit, [0.01, np.nan])


def test_first_levels_may_be_left_out():
    """Runs that begin at several sizes: the first passage of each takes no time at all."""
    times = np.log(LEVELS / 1e-6) / 0.02
    times = np.array([times, times])
    times[0, 1:] -= times[0, 1]
    times[1, :4], times[1, 4:] = np.nan, times[1, 4:] - times[1, 5]
    times[1, 4] = 0.0
    growth = finite_size_exponents(LEVELS, times, 1e4, skipped=1)
    assert growth.passed.tolist() == [0, 1, 1, 1, 1] + [2] * 7
    np.testing.assert_allclose(growth.exponent[1:], 0.02, rtol=1e-12)
    assert np.isnan(growth.exponent[0])


def test_edges():
    alone = finite_size_exponents([1.0, 2.0], [[0.0, 4.0]], 10.0)
    assert alone.exponent[0] == pytest.approx(np.log(2) / 4)
    assert np.isnan(alone.standard_error[0])
    with pytest.raises(NotEnoughDataError, match="two levels and a run"):
        finite_size_exponents([1.0], [[0.0]], 10.0)
    with pytest.raises(NotEnoughDataError, match="two levels and a run"):
        finite_size_exponents([1.0, 2.0], np.empty((0, 2)), 10.0)
