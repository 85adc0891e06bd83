"""Periods that runs end on: made-up runs of known orbits, and runs of the chain."""

import numpy as np
import pytest

from beltrepro import ChainParameters, motions
from beltrepro.analysis.periods import orbits_reached, period_quantiles, tell_orbits
from beltrepro.store import Dataset
from beltrepro.tables import periods


def made_up(rows):
    """Runs from (n_blocks, belt_velocity, state, period_time, period_events)."""
    names = ("n_blocks", "belt_velocity", "state", "period_time", "period_events")
    columns = zip(*rows, strict=True)
    arrays = {name: np.array(values) for name, values in zip(names, columns, strict=True)}
    numbers = np.arange(len(rows))
    return arrays | {"period_returns": numbers, "disorder_parameter": numbers / 10}


def test_runs_on_one_orbit_are_told_by_time_and_slips():
    """Times as a recurrence finds them; two orbits may share one of the two numbers."""
    time = np.array([41.0, 20.0, np.nan, 41.0 + 1e-9, 41.0, 20.0 - 1e-9, 41.01])
    slips = np.array([18, 9, 0, 18, 19, 9, 18])
    number = tell_orbits(time, slips)
    assert number[2] == -1
    assert number[1] == number[5] == 0
    assert number[0] == number[3]
    assert sorted({number[0], number[4], number[6]}) == [1, 2, 3]
    assert tell_orbits([], []).size == 0


RUNS = made_up(
    [
        (5, 16.0, "periodic", 41.0, 18),
        (5, 16.0, "periodic", 106.0, 57),
        (5, 16.0, "periodic", 41.0, 18),
        (5, 16.0, "irregular", np.nan, 0),
        (5, 7.0, "equilibrium slip", 12.0, 3),  # what is not called periodic has no period
        (5, 7.0, "irregular", np.nan, 0),
        (3, 7.0, "periodic", 30.0, 6),
    ]
)


def test_each_orbit_has_the_runs_that_end_on_it():
    found = orbits_reached(RUNS)
    assert found["n_blocks"].tolist() == [3, 5, 5]
    assert found["belt_velocity"].tolist() == [7.0, 16.0, 16.0]
    assert found["period_time"].tolist() == [30.0, 41.0, 106.0]
    assert found["period_events"].tolist() == [6, 18, 57]
    assert found["period_returns"].tolist() == [6, 0, 1]
    assert found["runs"].tolist() == [1, 2, 1]
    assert found["share"].tolist() == [1.0, 0.5, 0.25]


def test_quantiles_are_those_of_the_periodic_runs():
    found = period_quantiles(RUNS)
    assert found["n_blocks"].tolist() == [3, 5, 5]
    assert found["runs"].tolist() == [1, 2, 4]
    assert found["periodic"].tolist() == [1, 0, 3]
    assert found["orbits"].tolist() == [1, 0, 2]
    np.testing.assert_array_equal(found["time_50"], [30.0, np.nan, 41.0])
    np.testing.assert_array_equal(found["events_75"], [6.0, np.nan, 57.0])
    np.testing.assert_array_equal(found["longest_time"], [30.0, np.nan, 106.0])


def test_the_table_has_a_row_for_each_orbit():
    table = periods.derive({"survival": Dataset(RUNS, {})})
    assert table["period_events"].tolist() == [6, 18, 57]
    assert set(periods.ENTRY.columns) <= set(table)


def test_no_runs_give_no_rows():
    empty = {name: values[:0] for name, values in RUNS.items()}
    assert orbits_reached(empty)["runs"].size == 0
    assert period_quantiles(empty) == {}


def test_two_blocks_end_on_one_of_two_orbits():
    """Every run of two blocks at u = 20 closes; the periods are 21.10 and 21.65."""
    count = 8
    chains, lengths = [ChainParameters(2, 20.0)] * count, {"duration": 2000.0, "transient": 1000.0}
    runs = motions(chains, replicate=range(count), initial_spread=12.0, seed=1, **lengths)
    points = {"n_blocks": np.full(count, 2), "belt_velocity": np.full(count, 20.0)}
    found = orbits_reached(runs | points)
    assert found["period_events"].tolist() == [5, 6]
    assert found["period_time"] == pytest.approx([21.104, 21.648], abs=1e-3)
    assert found["runs"].sum() == count
