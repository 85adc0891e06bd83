"""The margin of an orbit, on made-up returns and runs: limits at 0.8 and 1.2 of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from beltrepro import ChainParameters, ChainState, Setup, periodic_orbit, time_to_orbit
from beltrepro.base.errors import InputError
from beltrepro.chaos import margin
from beltrepro.chaos.periodic_orbits import close_orbit, follow
from beltrepro.model.spring import external_force

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
    assert track.left((times, states, None), begin, 30.0) == leaves


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
    assert track.left((np.array(times), states, None), 0.0, duration) == leaves


@pytest.mark.parametrize("way", [-1, 1])
def test_an_orbit_is_lost_by_whichever_way_of_a_block_loses_it(track, way, monkeypatch):
    """Where only displacements of 0.003 or more forward, or back, lead away."""
    state = ChainState.at_rest(CHAIN)

    def returns(cases, length, duration):
        moved = [way * (case.state.displacements - state.displacements).sum() for case in cases]
        states = [STATES + 100.0 * (size > 0.003) for size in moved]
        return SimpleNamespace(returns=lambda lane: (track.times, states[lane], None))

    monkeypatch.setattr(margin, "_returns", returns)
    for size in (0.002, 0.004):
        assert margin._lost(track, [(state, 0.0, 1)], size, 1) == (size > 0.003)


@pytest.fixture(scope="module")
def orbit():
    """The orbit of 18 slips at u = 16."""
    chain = ChainParameters(5, 16.0)
    runs = time_to_orbit(chain, replicate=[1, 2], initial_spread=10.0, duration=40_000)
    (run,) = np.flatnonzero(runs["period_events"] == 18)[:1]
    places, velocities = np.split(runs["return_state"][run], 2)
    state = ChainState.in_motion(
        chain, chain.rest_positions + places, chain.belt_velocity + velocities
    )
    return close_orbit(state, float(runs["period_time"][run]))


def test_a_chain_comes_back_from_less_than_the_margin_and_not_from_more(orbit):
    size = margin.margin(orbit, begin=0.8)
    assert 0.8 < size < margin.LARGEST
    track = margin.Track.of(orbit)
    starts = margin._slips(orbit, 32)
    assert not margin._lost(track, starts, 0.5 * size, 20)
    assert margin._lost(track, starts, size, 40)


def test_the_margin_tells_what_noise_loses_an_orbit(orbit):
    """As derived in docs/physics.md: the largest of so many normal thresholds reaches it."""
    duration, track = 10_000.0, margin.Track.of(orbit)
    slips = orbit.period_events * duration / orbit.period_time
    carried = [2 * orbit.parameters.belt_velocity / rate for rate in _rates_of_pull(orbit)]
    share = norm.isf(np.log(2) / (2 * slips)) * np.sqrt(np.mean(np.square(carried)))
    predicted = margin.margin(orbit, begin=0.8) / share
    for factor, leaves in ((1 / 3, 0), (3, 8)):
        chain = replace(orbit.parameters, noise=factor * predicted)
        runs = Setup(chain, initial_state=orbit.state.under(chain), replicate=range(8)).cases
        log = margin._returns(runs, track.length, duration)
        left = [track.left(log.returns(lane), 0.0, duration) for lane in range(8)]
        assert np.isfinite(left).sum() == leaves


def _rates_of_pull(orbit):
    """How fast the force on a block grows as its slip begins, for each slip of the orbit."""
    for event in follow(orbit.state, orbit.period_time)[1]:
        if event["kind"] == "slip" and event["time"] > 1e-5:
            state, _ = follow(orbit.state, float(event["time"]) - 1e-5)
            positions = orbit.parameters.rest_positions + state.displacements
            force = external_force(positions, orbit.parameters)[event["block"] - 1]
            yield (event["force"] - force) / 1e-5


@pytest.mark.parametrize(("k", "m"), [(1.0, 1.0), (4.0, 4.0), (16.0, 1.0)])
def test_the_margin_is_a_length_whatever_the_units_of_mass_and_force(k, m):
    times, chain = np.sqrt(m / k), {"stiffness": k, "mass": m, "static_friction": 71.4 * k}
    chain = ChainParameters(3, 12.0 / times, **chain)
    orbit = periodic_orbit(chain, duration=400 * times, transient=200 * times)
    assert margin.margin(orbit, slips=4) == pytest.approx(0.0252, rel=1e-3)


def test_a_large_displacement_of_a_stiff_chain_is_no_loss():
    chain = ChainParameters(1, 3.0, stiffness=9.0, linear_limit=np.inf)
    orbit = periodic_orbit(chain, duration=200, transient=100)
    assert margin.margin(orbit, slips=4) == np.inf


def test_where_the_first_size_loses_an_orbit_smaller_ones_are_tried(monkeypatch):
    """Of a chain that bears 0.003 alone: from 0.5 down by tenths to 0.0005, then up again."""
    tried = []
    monkeypatch.setattr(margin, "_lost", lambda *run: tried.append(run[2]) or run[2] > 0.003)
    monkeypatch.setattr(margin, "_slips", lambda orbit, slips: [])
    orbit = periodic_orbit(ChainParameters(1, 5.0), duration=200, transient=100)
    size = margin.margin(orbit, begin=0.5)
    assert 0.003 < size < 0.003 * 2 ** (1 / 3)
    assert tried[:5] == pytest.approx([0.5, 0.05, 0.005, 0.0005, 0.0005])
    assert margin.margin(orbit) < 0.003 * 2 ** (1 / 3)
    for changes, message in (
        ({"orbit": 5}, "orbit = 5: a PeriodicOrbit is needed"),
        ({"begin": 0.0}, "begin = 0: must be at least 1e-08 and below 2"),
        ({"periods": 0}, "periods = 0: must be at least 1"),
        ({"slips": 1.5}, "slips = 1.5: a whole number is needed"),
    ):
        with pytest.raises(InputError) as caught:
            margin.margin(**{"orbit": orbit} | changes)
        assert str(caught.value) == message
