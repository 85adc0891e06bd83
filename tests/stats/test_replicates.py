"""Quantiles over replicates along an axis."""

import numpy as np
import pytest

from beltrepro.stats.replicates import spread


def test_quantiles_means_and_errors_at_each_place():
    rng = np.random.default_rng(1)
    places = rng.permutation(np.repeat([3.0, -1.0, 7.5], [11, 2, 1]))
    values = places**2 + rng.exponential(size=places.size)
    found = spread(places, values, share=0.5)
    np.testing.assert_array_equal(found.place, [-1, 3, 7.5])
    np.testing.assert_array_equal(found.count, [2, 11, 1])
    of_three = np.sort(values[places == 3])
    assert (found.low[1], found.median[1], found.high[1]) == pytest.approx(
        ((of_three[2] + of_three[3]) / 2, of_three[5], (of_three[7] + of_three[8]) / 2)
    )
    assert found.mean[1] == pytest.approx(of_three.sum() / 11)
    scatter = np.sqrt(np.sum((of_three - found.mean[1]) ** 2) / 10)
    assert found.error[1] == pytest.approx(scatter / np.sqrt(11))
    assert found.low[2] == found.median[2] == found.high[2] == values[places == 7.5]
    assert np.isnan(found.error[2])


def test_the_band_holds_its_share_of_many_runs():
    values = np.random.default_rng(2).standard_normal(20_000)
    found = spread(np.zeros(values.size), values)
    assert np.mean((values > found.low) & (values < found.high)) == pytest.approx(0.8, abs=1e-3)
    assert found.high[0] == pytest.approx(1.2816, abs=0.03)


def test_unknown_values_and_places_without_any_are_left_out():
    found = spread([1, 1, 2, 2], [np.nan, 4.0, np.nan, np.inf])
    assert (found.place.tolist(), found.median.tolist(), found.count.tolist()) == ([1], [4], [1])
    empty = spread([], [])
    assert empty.place.size == empty.low.size == empty.mean.size == empty.error.size == 0
