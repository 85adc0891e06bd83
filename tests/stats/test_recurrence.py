"""Recurrence of full states on maps whose periods are known."""

import numpy as np
import pytest

from beltrepro.stats.motion import CLOSED, NEAR, find_recurrence
from samples import henon, logistic, orbit


def instants(states):
    return 2.5 * np.arange(len(states))


@pytest.mark.parametrize(
    ("rate", "period"), [(2.9, 1), (3.2, 2), (3.5, 4), (3.55, 8), (3.83, 3), (3.739, 5)]
)
def test_periods_of_the_logistic_map(rate, period):
    states = orbit(logistic(rate), 0.3, 400, skip=20000)
    recurrence = find_recurrence(states, instants(states))
    assert recurrence.crossings == period
    assert recurrence.time == pytest.approx(2.5 * period)


def test_a_long_period_is_found_and_its_half_is_not():
    """A permutation of 700 states, of which one coordinate alone repeats after 350 already."""
    once = np.random.default_rng(3).normal(size=350)
    values = np.concatenate([once, once])
    states = np.column_stack([values, np.repeat([0.0, 1.0], 350)])
    states = np.concatenate([states, states, states[:100]])
    assert find_recurrence(states, instants(states)).crossings == 700
    assert find_recurrence(states[:, :1], instants(states)).crossings == 350
    # seen less than twice, a period cannot be told
    assert find_recurrence(states[:1390], instants(states[:1390])) is None


@pytest.mark.parametrize(
    "states",
    [
        orbit(logistic(4.0 - 1e-9), 0.3, 20000),
        orbit(henon(1.4), [0.1, 0.1], 20000, skip=100),
        # quasi-periodic: golden rotation, which comes back to 1/K after K turns
        np.exp(2j * np.pi * 0.6180339887498949 * np.arange(20000)).view(float).reshape(-1, 2),
    ],
    ids=["logistic", "henon", "rotation"],
)
def test_irregular_and_quasi_periodic_motion_does_not_close(states):
    assert find_recurrence(states, instants(states)) is None


def test_a_disturbed_orbit_closes_within_a_distance():
    """The largest of 420 differences of normal deviates times 1.4 is above 5 once in 800 times."""
    random = np.random.default_rng(2)
    states = np.tile(random.normal(size=(7, 3)), (60, 1)) + 1e-4 * random.normal(size=(420, 3))
    recurrence = find_recurrence(states, instants(states), distance=7e-4, crossings=210)
    assert (recurrence.crossings, recurrence.since) == (7, 0)
    assert find_recurrence(states, instants(states), distance=2e-4, crossings=210) is None


def test_a_laminar_phase_of_irregular_motion_is_not_an_orbit():
    """Just below its window of period 3 the logistic map stays near that orbit now and then."""
    states = orbit(logistic(3.8282), 0.3, 5000)
    apart = np.abs(states[3:, 0] - states[:-3, 0])
    near = np.flatnonzero((apart[2:] < 1e-3) & (apart[1:-1] < 1e-3) & (apart[:-2] < 1e-3))
    states = states[: near[-1] + 6]  # up to the end of a state within such a phase
    assert find_recurrence(states, instants(states), distance=1e-3).crossings == 3
    assert find_recurrence(states, instants(states), distance=1e-3, crossings=300) is None


def test_all_states_of_the_last_period_must_come_back():
    states = np.random.default_rng(5).normal(size=(40, 2))
    states[[20, 39]] = states[0]  # one return only
    assert find_recurrence(states, instants(states)) is None


def test_since_tells_when_the_orbit_was_reached():
    states = orbit(logistic(3.2), 0.3, 3000)
    recurrence = find_recurrence(states, instants(states))
    size = np.abs(states).max()
    apart = np.abs(states[2:, 0] - states[:-2, 0])
    assert apart[recurrence.since :].max() <= CLOSED * size < apart[recurrence.since - 1]
    assert 3 < recurrence.since < 200


def test_edges():
    still = np.ones((4, 2))
    assert find_recurrence(still, instants(still)).crossings == 1
    for few in (still[:2], still[:0]):
        assert find_recurrence(few, instants(few)) is None


def test_an_orbit_approached_from_alternate_sides_has_its_own_period():
    """States a period apart differ by (-0.98)^k: two periods apart they are nearer by far."""
    number = np.arange(2000)
    phase = np.array([0.0, 1.0, 3.0])[number % 3]
    states = np.column_stack([phase + (-0.98) ** (number // 3), 5.0 + phase])
    assert (
        np.abs(states[-1] - states[-7]).max() < CLOSED * 8 < np.abs(states[-1] - states[-4]).max()
    )
    recurrence = find_recurrence(states, 2.0 * number)
    assert (recurrence.crossings, recurrence.time) == (3, 6.0)


def test_a_doubled_orbit_keeps_its_period():
    states = np.array([0.0, 1.0, 3.0, 0.0, 1.0, 3.0 + 1e-4])[np.arange(600) % 6][:, None]
    assert find_recurrence(states, np.arange(600.0)).crossings == 6


@pytest.mark.parametrize(("offset", "time"), [(1e-3, 9_000), (1e-4, 70_000)])
def test_beside_a_period_doubling_the_period_is_that_of_its_side(offset, time):
    """The logistic map doubles at 3: before, states still come nearer to the orbit of period 1."""
    for rate, period in ((3.0 - offset, 1), (3.0 + offset, 2)):
        states = orbit(logistic(rate), 0.3, time // 10, skip=time)
        assert np.abs(states[-1] - states[-2]) > NEAR
        recurrence = find_recurrence(states, instants(states))
        assert (recurrence.crossings, recurrence.time) == (period, 2.5 * period)
        assert recurrence.back == 5.0
