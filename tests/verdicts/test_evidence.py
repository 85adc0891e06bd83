"""Cuts through scans, which claims read."""

import numpy as np
import pytest

from beltrepro.base.store import Dataset
from beltrepro.replication.verdicts import motions
from beltrepro.replication.verdicts.evidence import Cut, Evidence
from beltrepro.stats import transition

U = np.tile(np.arange(1.0, 41), 4)


def scan():
    """Four runs at each point of two rows, in no order; r falls at u = 12 or, with noise, at 25."""
    order = np.random.default_rng(2).permutation(2 * U.size)
    noise = np.repeat([0.0, 1.5], U.size)
    u, n_blocks = np.tile(U, 2), np.full(2 * U.size, 5)
    disorder = np.where(u < np.where(noise > 0, 25, 12), 0.1, 0.01)
    names = ("belt_velocity", "noise", "n_blocks", "disorder_parameter", "last_stick_time")
    stuck = np.full(u.size, 3e4)
    arrays = dict(zip(names, (u, noise, n_blocks, disorder, stuck), strict=True))
    arrays = {name: values[order] for name, values in arrays.items()}
    return Dataset(arrays, {"transient": 1e4, "duration": 3e4})


@pytest.mark.parametrize(("noise", "place"), [(0.0, 11.5), (1.5, 24.5)])
def test_a_row_is_that_of_its_noise_in_order(noise, place):
    row = Cut.of(scan(), n_blocks=5, noise=noise)
    assert row.belt_velocity.tolist() == sorted(U) and set(row.noise) == {noise}
    assert (row.transient, row.duration) == (1e4, 3e4)
    assert row.fall == transition.fall(row.belt_velocity, row.disorder)
    assert row.fall["critical"].value == pytest.approx(place, abs=0.1)


def test_runs_at_several_velocities_count_as_many_at_each():
    velocity = np.repeat([1.0, 5, 9, 12], [4, 9, 2, 6])
    row = Cut({"belt_velocity": velocity}, 1e5, 2e5)
    for low, high, most in ((0, 13, 2), (1, 5, 4), (5, 5, 9), (12, 12, 6), (20, 30, 0)):
        inside = (velocity >= low) & (velocity <= high)
        # the first of each, as the run at its place in the row tells
        rank = [np.count_nonzero(velocity[:row] == u) for row, u in enumerate(velocity)]
        assert row.between(low, high).tolist() == (inside & (np.array(rank) < most)).tolist()
    chosen = (velocity == 5) | (velocity == 12)
    assert velocity[row.evenly(chosen)].tolist() == [5] * 6 + [12] * 6


def test_both_ends_of_a_range_count_to_the_rounding_of_a_grid():
    values = np.array([0.5, 0.1 + 0.2, 0.4, 0.4 + 1e-8, 0.3 - 1e-8])
    assert motions.between(values, 0.3, 0.4).tolist() == [False, True, True, False, False]
    assert motions.between(values, 0.4, np.inf).tolist() == [True, False, True, True, False]


def test_periodic_attractors_beyond_the_fall_are_outliers():
    """At u = 6 half of the runs slip on; beyond it runs on orbits with sticks do not count."""
    u, run = np.repeat(np.arange(1.0, 11), 4), np.tile(np.arange(4), 10)
    slips = (u > 6) | (u == 6) & (run < 2)
    orbit = np.isin(u, (4, 8)) | (u == 9) & (run == 0) | (u == 6) & (run == 2)
    slips &= ~orbit
    velocity = np.where(
        orbit[:, None], np.tile([5.0, 9.0], 50), np.random.default_rng(0).random((40, 100))
    )
    points = {
        "belt_velocity": u,
        "disorder_parameter": np.where(slips, 0.01, 0.1),
        "last_stick_time": np.where(slips, 1e4, 3e4),
        "laminar_fraction": np.zeros(40),
        "laminar_count": np.zeros(40),
        "section_velocity": velocity,
    }
    row = Cut(points, 1e4, 3e4)
    assert np.flatnonzero(row.outliers).tolist() == [28, 29, 30, 31, 32]
    assert row.fall["critical"].value == pytest.approx(6, abs=0.5)
    single = Cut({name: values[::4] for name, values in points.items()}, 1e4, 3e4)
    assert not single.outliers.any()


@pytest.mark.parametrize("ways", [("row", "column"), ("column", "row")])
def test_a_row_and_a_column_of_one_number_are_two_cuts(ways):
    u, noise = map(np.ravel, np.meshgrid([1.0, 2, 3], [0.0, 1, 2]))
    arrays = {"n_blocks": np.full(9, 5), "belt_velocity": u, "noise": noise}
    evidence = Evidence({"map": Dataset(arrays, {"transient": 1e4, "duration": 3e4})}, {})
    cuts = {way: getattr(evidence, way)("map", 5, 1.0) for way in ways}
    assert set(cuts["row"].noise) == {1.0} and cuts["row"].belt_velocity.tolist() == [1, 2, 3]
    assert set(cuts["column"].belt_velocity) == {1.0} and cuts["column"].noise.tolist() == [0, 1, 2]
