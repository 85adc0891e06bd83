"""Sections, dimension, transitions, intermittency, states: estimators on maps and made-up scans."""

import numpy as np
import pytest

from beltrepro.replication.studies.noise import measure
from beltrepro.stats import dimension, intermittency, sections, states
from beltrepro.stats.errors import NotEnoughDataError


def logistic(rate, size, start=0.3):
    """Orbit of the logistic map after a transient."""
    orbit = np.empty(2000 + size)
    value = start
    for step in range(orbit.size):
        value = rate * value * (1 - value)
        orbit[step] = value
    return orbit[2000:]


def henon(size):
    """Orbit of the Henon map with its usual parameters."""
    orbit = np.empty((size + 100, 2))
    x, y = 0.1, 0.1
    for step in range(orbit.shape[0]):
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        orbit[step] = x, y
    return orbit[100:]


def scan(**arrays):
    """A scan in the layout of `scan`, filled with defaults."""
    size = len(arrays["belt_velocity"])
    defaults = {
        "n_blocks": np.full(size, 5),
        "noise": np.zeros(size),
        "replicate": np.zeros(size, dtype=int),
        "disorder_parameter": np.full(size, 0.1),
        "section_velocity": np.full((size, 100), np.nan),
        "laminar_fraction": np.zeros(size),
        "laminar_count": np.zeros(size, dtype=int),
        "last_stick_time": np.full(size, 1000.0),
    }
    return defaults | {name: np.asarray(values) for name, values in arrays.items()}


# --- sections -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("rate", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.83, 3), (3.55, 8)])
def test_periods_of_the_logistic_map(rate, period):
    orbit = logistic(rate, 120)
    assert sections.find_period(orbit, tolerance=1e-4) == period


def test_chaos_and_quasi_periodic_motion_have_no_period():
    assert sections.find_period(100 * logistic(4.0, 200)) == 0
    assert sections.find_period(10 * np.cos(2 * np.pi * 0.618034 * np.arange(200))) == 0


def test_the_period_tolerates_the_scatter_of_the_scheme_and_no_more():
    scatter = np.random.default_rng(0).uniform(-0.5, 0.5, 120)
    orbit = np.tile([-50.0, -10.0, -30.0], 40)
    assert sections.find_period(orbit + 0.7 * scatter) == 3
    assert sections.find_period(orbit + 4.0 * scatter) == 0


def test_few_crossings_are_refused():
    with pytest.raises(NotEnoughDataError, match="3 crossings"):
        sections.find_period([1.0, 2.0, np.nan, 3.0])


def test_the_0_1_test_tells_chaos_from_regular_motion():
    assert sections.zero_one_test(logistic(4.0, 400)) > 0.9
    assert sections.zero_one_test(logistic(3.97, 400)) > 0.8
    assert abs(sections.zero_one_test(logistic(3.5, 400))) < 0.2
    rotation = np.cos(2 * np.pi * 0.618034 * np.arange(400))
    assert sections.zero_one_test(rotation) < 0.2


def test_occupied_share_of_lines_and_bands():
    line, band = np.full(200, 3.3), np.linspace(0, 10, 1000)
    assert sections.occupied_share(line, range=(0, 10)) == pytest.approx(0.01)
    assert sections.occupied_share(band, range=(0, 10)) == pytest.approx(0.9, abs=0.02)


def test_rows_and_columns_are_cut_and_sorted():
    table = scan(
        belt_velocity=[3.0, 1.0, 2.0, 1.0, 7.0],
        noise=[0.0, 0.0, 0.0, 0.5, 0.1 + 0.2],
        n_blocks=[5, 5, 4, 5, 5],
        replicate=[0, 1, 0, 0, 0],
    )
    assert sections.rows(table, n_blocks=5, noise=0.0)["belt_velocity"].tolist() == [1, 3]
    assert sections.rows(table, n_blocks=5, noise=0.3)["belt_velocity"].tolist() == [7]
    assert sections.columns(table, n_blocks=5, belt_velocity=1)["noise"].tolist() == [0, 0.5]
    assert sections.rows(table, n_blocks=9, noise=0.0)["noise"].size == 0


# --- density --------------------------------------------------------------------------------------


def test_each_column_of_the_velocity_density_is_normalised():
    velocities = np.random.default_rng(0).normal(0, 1, (3, 100))
    velocities[1] = np.nan
    row = scan(belt_velocity=[1.0, 2.0, 4.0], section_velocity=velocities)
    u_edges, v_edges, found = measure.velocity_density(row, bins=20, range=(-5, 5))
    assert u_edges.tolist() == [0.5, 1.5, 3.0, 5.0]
    assert v_edges.size == 21
    assert np.sum(found[:, 0]) * 0.5 == pytest.approx(1)
    assert np.isnan(found[:, 1]).all()


# --- correlation dimension ------------------------------------------------------------------------


def test_the_correlation_dimension_of_the_henon_attractor():
    found = dimension.correlation_dimension(henon(5000))
    assert found.dimension == pytest.approx(1.2, abs=0.04)
    assert found.error < 0.1


@pytest.mark.parametrize("true", [1, 2])
def test_the_correlation_dimension_of_a_curve_and_of_a_surface(true):
    parameters = np.random.default_rng(0).random((4000, true))
    embedding = np.random.default_rng(1).normal(size=(true, 6))
    found = dimension.correlation_dimension(parameters @ embedding)
    assert found.dimension == pytest.approx(true, abs=0.1)


def test_a_dimension_needs_points_in_more_than_a_few_places():
    with pytest.raises(NotEnoughDataError, match="500 are needed"):
        dimension.correlation_dimension(np.zeros((10, 2)))
    with pytest.raises(NotEnoughDataError, match="few places"):
        dimension.correlation_dimension(np.tile([[0.0, 0.0], [1.0, 2.0]], (400, 1)))


# --- intermittency --------------------------------------------------------------------------------


def test_points_are_intermittent_by_share_and_number_of_laminar_phases():
    points = {
        "laminar_fraction": np.array([0.0, 0.5, 0.5, 0.99, 0.06]),
        "laminar_count": np.array([0, 1, 2, 8, 3]),
    }
    mask = intermittency.intermittent_mask(points)
    assert mask.tolist() == [False, False, True, False, True]


def test_laminar_phases_are_the_long_slips():
    starts, stops = np.array([1.0, 10.0, 70.0]), np.array([5.0, 60.0])
    phases = intermittency.laminar_phases(starts, stops, 20.0, start=0.0, stop=100.0)
    assert phases.tolist() == [[10.0, 60.0], [70.0, 100.0]]


def test_laminar_phases_of_a_series_are_those_of_its_last_block():
    fields = [("time", "f8"), ("block", "i8"), ("kind", "U5")]
    rows = [(1, 2, "slip"), (5, 3, "slip"), (40, 2, "stick"), (41, 3, "stick"), (60, 3, "slip")]
    events = np.array(rows, fields)
    phases = intermittency.last_block_phases(events, 3, 30.0, start=0.0, stop=100.0)
    np.testing.assert_array_equal(phases, [[5, 41], [60, 100]])
    phases = intermittency.last_block_phases(events, 2, 30.0, start=5.0, stop=100.0)
    np.testing.assert_array_equal(phases, [[5, 40]])


def test_laminar_phases_are_cut_at_the_ends_of_the_record():
    phases = intermittency.laminar_phases([50.0], [30.0, 90.0], 5.0, start=10.0, stop=80.0)
    assert phases.tolist() == [[10.0, 30.0], [50.0, 80.0]]
    none = intermittency.laminar_phases([], [], 5.0, start=0.0, stop=1.0)
    assert none.shape == (0, 2)


# --- states ---------------------------------------------------------------------------------------


def test_states_of_points():
    velocities = np.full((7, 300), np.nan)
    velocities[0] = -50 * logistic(4.0, 300)
    velocities[1] = np.tile([-20.0, -40.0], 150)
    velocities[2] = -20 + 9 * np.cos(2 * np.pi * 0.618034 * np.arange(300))
    velocities[3:6] = velocities[0]
    points = scan(
        belt_velocity=np.arange(1.0, 8),
        section_velocity=velocities,
        last_stick_time=[999, 999, 999, 400, 600, 999, 999],
        laminar_fraction=[0, 0, 0, 1, 0.8, 0.5, 0],
        laminar_count=[0, 0, 0, 1, 1, 4, 0],
    )
    labels = states.label_states(points, transient=500.0, duration=1000.0)
    assert labels.tolist() == [
        states.CHAOTIC,
        states.PERIODIC,
        states.QUASI_PERIODIC,
        states.CONTINUOUS,
        states.TRANSIENT,
        states.INTERMITTENT,
        states.UNDECIDED,
    ]


def test_states_near_an_earlier_one_are_repeated():
    orbit = 100 * np.random.default_rng(3).random((7, 4))
    jitter = np.random.default_rng(4).uniform(-0.1, 0.1, (21, 4))
    states = np.vstack([orbit] * 3) + jitter
    np.testing.assert_array_equal(sections.repeated(states), np.arange(21) >= 7)
    assert not sections.repeated(states, near=1e-5).any()
    assert sections.repeated(np.empty((0, 4))).shape == (0,)


def test_new_states_are_apart_and_all_others_near_one_of_them():
    """Also over more states than are compared at once."""
    states = np.random.default_rng(5).random((2600, 2))
    again = sections.repeated(states, near=0.05)
    limit = 0.05 * np.ptp(states, axis=0).max()
    new = []
    for index, state in enumerate(states):
        near = any(np.hypot(*(state - states[other])) <= limit for other in new)
        assert again[index] == near
        if not near:
            new.append(index)
    assert 50 < len(new) < 500
