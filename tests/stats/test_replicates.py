"""Quantiles over replicates along an axis."""

import numpy as np
import pytest

from beltrepro.stats.replicates import spread


def test_quantiles_means_and_errors_at_each_place():
    rng = np.random.default_rng(1)
    places = rng.permutation(np.repeat([3.0, -1.0, 7.5], [11, 2, 1]))
    values = places**2 + rng.exponential(size=places.size)
    summary = spread(places, values, share=0.5)
    np.testing.assert_array_equal(summary.place, [-1, 3, 7.5])
    np.testing.assert_array_equal(summary.count, [2, 11, 1])
    of_three = np.sort(values[places == 3])
    assert (summary.low[1], summary.median[1], summary.high[1]) == pytest.approx(
        ((of_three[2] + of_three[3]) / 2, of_three[5], (of_three[7] + of_three[8]) / 2)
    )
    assert summary.mean[1] == pytest.approx(of_three.sum() / 11)
    scatter = np.sqrt(np.sum((of_three - summary.mean[1]) ** 2) / 10)
    assert summary.error[1] == pytest.approx(scatter / np.sqrt(11))
    assert summary.low[2] == summary.median[2] == summary.high[2] == values[places == 7.5]
    assert np.isnan(summary.error[2])


def test_the_band_holds_its_share_of_many_runs():
    values = np.random.default_rng(2).standard_normal(20_000)
    summary = spread(np.zeros(values.size), values)
    assert np.mean((values > summary.low) & (values < summary.high)) == pytest.approx(0.8, abs=1e-3)
    assert summary.high[0] == pytest.approx(1.2816, abs=0.03)


def test_unknown_values_and_places_without_any_are_left_out():
    summary = spread([1, 1, 2, 2], [np.nan, 4.0, np.nan, np.inf])
    assert (summary.place.tolist(), summary.median.tolist(), summary.count.tolist()) == (
        [1],
        [4],
        [1],
    )
    empty = spread([], [])
    assert empty.place.size == empty.low.size == empty.mean.size == empty.error.size == 0
