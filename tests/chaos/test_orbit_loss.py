"""What loses an orbit, on made-up returns and runs: limits at 0.8 and 1.2 of them, naive twins."""

from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState
from beltrepro.chaos import orbit_loss

PERIOD = 10.0
CHAIN = ChainParameters(2, 5.0)
STATES = np.array([[1.0, 2, 3, 4], [5.0, 7, 6, 8], [9.0, 12, 10, 11]])  # at the returns of an orbit


@pytest.fixture
def track():
    orbit = SimpleNamespace(period_time=PERIOD, parameters=CHAIN)
    return orbit_loss.Track(orbit, 50.0, np.array([2.0, 5.0, 9.0]), STATES)


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


def test_the_section_is_where_the_slowest_crossing_is_fastest():
    # down from 10 to 0 with a step of 0.5 above 6 and of 2 below, up by 1: two ways through 6
    lengths = np.concatenate([np.arange(0, 10.0), np.arange(10, 6, -0.5), np.arange(6, 0, -2.0)])
    length = orbit_loss._fastest_crossed(lengths)
    assert length < 6 and orbit_loss._fastest_crossed(lengths + 3.0) == pytest.approx(length + 3)


def leaving(thresholds):
    """Shares of runs that leave: each run at a disturbance above a threshold of its own."""

    def shares(track, disturbance, sizes, *, duration, replicates):
        return {size: float(np.mean(size > np.array(thresholds))) for size in sizes}

    return shares


@pytest.mark.parametrize("disturbance", ["kick", "time_step", "noise"])
def test_half_of_the_runs_leave_at_the_mean_of_the_logarithms(monkeypatch, disturbance):
    largest = orbit_loss.LARGEST[disturbance]
    thresholds = largest * np.array([0.011, 0.013, 0.02, 0.05, 0.3])
    monkeypatch.setattr(orbit_loss, "_shares", leaving(thresholds))
    loss = orbit_loss.loss(None, disturbance, duration=1.0, replicates=5)
    fine = 10**0.13  # the step of the sizes, and what rounding the number of steps adds
    assert loss.size == pytest.approx(np.exp(np.log(thresholds).mean()), rel=np.sqrt(fine) - 1)
    assert thresholds[0] / fine <= loss.low <= thresholds[0]
    assert thresholds[-1] <= loss.high <= thresholds[-1] * fine


def test_orbits_that_no_size_loses_or_all_do(monkeypatch):
    for threshold, expected in ((3.0, (np.inf, 2.0, np.inf)), (1e-9, (0.0, 0.0, 2e-8))):
        monkeypatch.setattr(orbit_loss, "_shares", leaving([threshold]))
        loss = orbit_loss.loss(None, "kick", duration=1.0, replicates=3)
        assert (loss.size, loss.low, loss.high) == pytest.approx(expected)


def test_shares_that_do_not_rise_steadily_by_hand():
    loss = orbit_loss._threshold({16: 1.0, 1: 0.0, 2: 0.5, 4: 0.0, 8: 0.75, 32: 1.0}, 24)
    assert (loss.low, loss.high, loss.runs) == (1, 16, 24)
    assert np.log2(loss.size) == pytest.approx(0.5 * 0.5 + 0.25 * 2.5 + 0.25 * 3.5)
    never_all = orbit_loss._threshold({1: 0.0, 2: 0.0, 4: 0.5}, 3)
    assert (never_all.size, never_all.low, never_all.high) == (np.inf, 2, np.inf)


# --- a single kick --------------------------------------------------------------------------------


@pytest.fixture
def kicked(track, monkeypatch):
    """The sizes that were tried, and the slips, where an orbit has six events."""
    events = np.zeros(6, [("kind", "U5"), ("time", float), ("block", int)])
    events["kind"] = ["stick", "slip", "slip", "stick", "slip", "slip"]
    events["time"], events["block"] = [0.5, 1, 3, 4, 6, 8], [1, 2, 1, 1, 2, 1]
    monkeypatch.setattr(orbit_loss, "follow", lambda *_: SimpleNamespace(events=events))
    monkeypatch.setattr(orbit_loss.Track, "at", lambda track, time: time)
    track.orbit.state = None
    return track


@pytest.mark.parametrize(("least", "margin"), [(0.055, 0.064), (1.9, np.inf), (0.001, 0.016)])
def test_the_margin_is_the_first_of_sizes_a_third_of_an_octave_apart(
    kicked, monkeypatch, least, margin
):
    tried = []

    def lost(track, slips, size, periods):
        tried.append(size)
        assert [(time, block) for _, time, block in slips] == [(1, 1), (3, 0), (8, 0)]
        assert [state - time for state, time, _ in slips] == pytest.approx([1e-6] * 3)
        return size > least

    monkeypatch.setattr(orbit_loss, "_lost", lost)
    size = orbit_loss.margin(kicked, begin=0.016, periods=4, slips=3)
    assert size == pytest.approx(margin) and tried[0] == 0.016
    assert np.diff(np.log2(tried)) == pytest.approx(1 / 3) or len(tried) == 1
    assert max(tried) < 2


def test_each_slip_is_kicked_forward_and_back():
    asked = {}

    def left(cases, begun, duration):
        places = np.array([case.state.displacements for case in cases])
        asked.update(places=places, begun=begun, duration=duration)
        return np.array([np.inf, np.inf, np.inf, 12.0])

    track = SimpleNamespace(left=left, orbit=SimpleNamespace(period_time=PERIOD))
    state = ChainState.in_motion(CHAIN, np.add(CHAIN.rest_positions, [1.0, 4.0]), [0.0, 0.0])
    assert orbit_loss._lost(track, [(state, 1.5, 1), (state, 7.0, 0)], 0.25, 3)
    expected = [[1, 3.75], [1, 4.25], [0.75, 4], [1.25, 4]]
    assert asked["places"] == pytest.approx(np.array(expected))
    assert asked["begun"] == [1.5, 1.5, 7.0, 7.0] and asked["duration"] == 30.0


def test_the_scatter_is_the_root_mean_square_of_the_later_returns(monkeypatch, track):
    lengths = [5, 8, 11, 6, 9, 12, 7, 10]  # returns of each of the runs
    away = [np.linspace(1, 3 + run, count) * 1e-9 for run, count in enumerate(lengths)]
    phases = [0.0, 0.3, 0.6]

    class Log:
        def returns(self, lane):
            first = np.searchsorted(track.times, phases[lane % 3] * PERIOD)
            states = STATES[(first + np.arange(lengths[lane])) % 3].copy()
            states[np.arange(lengths[lane]), np.arange(lengths[lane]) % 4] += away[lane]
            return np.arange(lengths[lane], dtype=float), states, None

    monkeypatch.setattr(orbit_loss, "_disturbed", lambda *of: None)
    monkeypatch.setattr(orbit_loss, "_returns", lambda *of: Log())
    monkeypatch.setattr(orbit_loss.Track, "phases", phases)
    late = [distance for run in away for distance in run[len(run) // 2 :]]
    assert track.scatter(duration=50.0) == pytest.approx(
        1e9 * np.sqrt(np.mean(np.square(late))), rel=1e-5
    )
