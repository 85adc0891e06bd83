"""The margin of an orbit, on made-up returns and runs: limits at 0.8 and 1.2 of them."""

from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, time_to_orbit
from beltrepro.chaos import margin
from beltrepro.chaos.periodic_orbits import close_orbit

PERIOD = 10.0
CHAIN = ChainParameters(2, 5.0)
STATES = np.array([[1.0, 2, 3, 4], [5.0, 7, 6, 8], [9.0, 12, 10, 11]])  # at the returns of an orbit


@pytest.fixture
def track():
    orbit = SimpleNamespace(period_time=PERIOD, parameters=CHAIN)
    return margin.Track(orbit, 50.0, np.array([2.0, 5.0, 9.0]), STATES)


@pytest.mark.parametrize(("begin", "first"), [(0.0, 0), (3.0, 1), (6.0, 2), (9.5, 3)])
@pytest.mark.parametrize(("share", "leaves"), [(0.8, np.inf), (1.2, 14.0), (-1.2, 14.0)])
def test_a_run_has_left_at_its_first_return_too_far_away(track, begin, first, share, leaves):
    times = np.array([3.0, 7.0, 14.0, 21.0, 26.0])
    states = STATES[(first + np.arange(5)) % 3].copy()
    states[2:4, 2] += share * 0.15 * CHAIN.static_friction  # one coordinate, and twice
    assert track._first_away((times, states, None), begin, 30.0) == leaves


@pytest.mark.parametrize(
    ("times", "duration", "leaves"),
    [
        ([], 24.0, np.inf),  # of 30: three periods
        ([], 36.0, 0.0),
        ([24.0, 27.0], 51.0, np.inf),
        ([36.0, 40.0], 41.0, 0.0),
        ([4.0, 8.0, 44.0], 80.0, 8.0),
        ([4.0, 8.0, 11.0], 47.0, 11.0),
    ],
)
def test_a_run_has_left_at_the_last_return_before_three_periods_without(
    track, times, duration, leaves
):
    states = STATES[np.arange(len(times)) % 3]
    assert track._first_away((np.array(times), states, None), 0.0, duration) == leaves


@pytest.mark.parametrize(("least", "expected"), [(0.055, 0.064), (1.9, np.inf), (0.001, 0.016)])
def test_the_margin_is_the_first_of_sizes_a_third_of_an_octave_apart(
    track, monkeypatch, least, expected
):
    events = np.zeros(6, [("kind", "U5"), ("time", float), ("block", int)])
    events["kind"] = ["stick", "slip", "slip", "stick", "slip", "slip"]
    events["time"], events["block"] = [0.5, 1, 3, 4, 6, 8], [1, 2, 1, 1, 2, 1]
    monkeypatch.setattr(margin, "follow", lambda *_: SimpleNamespace(events=events))
    monkeypatch.setattr(margin, "_at", lambda orbit, time: time)
    monkeypatch.setattr(margin.Track, "of", lambda orbit: track)
    track.orbit.state = None
    tried = []

    def lost(track, slips, size, periods):
        tried.append(size)
        assert [(time, block) for _, time, block in slips] == [(1, 1), (3, 0), (8, 0)]
        assert [state - time for state, time, _ in slips] == pytest.approx([1e-6] * 3)
        return size > least

    monkeypatch.setattr(margin, "_lost", lost)
    size = margin.margin(track.orbit, begin=0.016, periods=4, slips=3)
    assert size == pytest.approx(expected) and tried[0] == 0.016
    assert np.diff(np.log2(tried)) == pytest.approx(1 / 3) or len(tried) == 1
    assert max(tried) < 2


def test_each_slip_is_displaced_forward_and_back():
    asked = {}

    def left(cases, begun, duration):
        places = np.array([case.state.displacements for case in cases])
        asked.update(places=places, begun=begun, duration=duration)
        return np.array([np.inf, np.inf, np.inf, 12.0])

    track = SimpleNamespace(left=left, orbit=SimpleNamespace(period_time=PERIOD))
    state = ChainState.in_motion(CHAIN, np.add(CHAIN.rest_positions, [1.0, 4.0]), [0.0, 0.0])
    assert margin._lost(track, [(state, 1.5, 1), (state, 7.0, 0)], 0.25, 3)
    expected = [[1, 3.75], [1, 4.25], [0.75, 4], [1.25, 4]]
    assert asked["places"] == pytest.approx(np.array(expected))
    assert asked["begun"] == [1.5, 1.5, 7.0, 7.0] and asked["duration"] == 30.0


def test_a_chain_comes_back_from_less_than_the_margin_and_not_from_more():
    """The orbit of 18 slips at u = 16."""
    chain = ChainParameters(5, 16.0)
    runs = time_to_orbit(chain, replicate=[1, 2], initial_spread=10.0, duration=40_000)
    (run,) = np.flatnonzero(runs["period_events"] == 18)[:1]
    places, velocities = np.split(runs["return_state"][run], 2)
    state = ChainState.in_motion(
        chain, chain.rest_positions + places, chain.belt_velocity + velocities
    )
    orbit = close_orbit(state, float(runs["period_time"][run]))
    size = margin.margin(orbit, begin=0.8, periods=20, slips=32)
    assert 0.8 < size < margin.LARGEST
    track = margin.Track.of(orbit)
    starts = margin._slips(orbit, 32)
    assert not margin._lost(track, starts, 0.5 * size, 20)
    assert margin._lost(track, starts, size, 40)
