"""Periodic orbits: closed forms, differences, exponents, continuation, and what has no orbit."""

from math import atan, pi

import numpy as np
import pytest

from advancing import sliding
from beltrepro import (
    ChainParameters,
    ChainState,
    classify,
    periodic_orbit,
    simulate,
)
from beltrepro.base.errors import InputError
from beltrepro.chaos.periodic_orbits import close_orbit

ELSEWHERE = {"replicate": 1, "initial_spread": 1.0}
LENGTHS = {"duration": 4000.0, "transient": 2000.0, **ELSEWHERE}


@pytest.fixture(scope="module")
def two():
    return periodic_orbit(ChainParameters(2, 5.0), **LENGTHS)


@pytest.fixture(scope="module")
def five():
    return periodic_orbit(ChainParameters(5, 16.0), duration=60000, transient=50000, **ELSEWHERE)


def after(state, time):
    return simulate(
        state.parameters, duration=time, method="event", initial_state=state, sample_interval=None
    ).final_state


def numbers(state):
    return np.concatenate([state.displacements, state.relative_velocities])


@pytest.mark.parametrize("belt_velocity", [0.5, 3.0, 20.0])
def test_one_block_on_a_linear_spring_has_the_period_of_the_closed_form(belt_velocity):
    """From F_st the block swings about k to 2 k - F_st, then the belt carries it back."""
    chain = ChainParameters(1, belt_velocity, linear_limit=1000.0)
    reach = chain.static_friction * (1 - chain.friction_ratio)
    period = 2 * (pi - atan(reach / belt_velocity)) + 2 * reach / belt_velocity
    orbit = periodic_orbit(chain, duration=12 * period, transient=6 * period)
    assert orbit.period_time == pytest.approx(period, rel=1e-12)
    assert (orbit.period_events, orbit.period_returns, orbit.erased) == (1, 1, 1)
    # no deviation but that of the instant outlives the first stick
    assert orbit.multipliers.tolist() == [1, 0]
    assert (orbit.largest_multiplier, orbit.exponent) == (0, -np.inf)


def test_the_orbit_closes(five):
    """At rest on the belt together, five blocks have no velocity of their own: 5 of 10 remain."""
    assert (five.period_time, five.period_events) == (pytest.approx(41.0466877, abs=1e-6), 18)
    assert five.residual < 1e-13
    run = five.run(sample_interval=None)
    moved = np.abs(numbers(run.final_state) - numbers(five.state)).max()
    assert moved < 1e-13 * np.abs(numbers(five.state)).max()
    assert np.sum(run.events["kind"] == "slip") == 18
    assert five.erased == np.sum(five.multipliers == 0) == 5
    assert five.multipliers[five.trivial] == 1
    assert abs(five.largest_multiplier) < 1


def test_r_and_mean_length_are_those_of_a_run_of_whole_periods(two):
    """Samples every 0.1 in one, samples that divide the period in the other."""
    how = {"initial_state": two.state, "sample_interval": None}
    run = simulate(two.parameters, duration=100 * two.period_time, **how)
    assert run.disorder_parameter == pytest.approx(two.disorder_parameter, rel=1e-4)
    assert run.mean_length == pytest.approx(two.mean_length, rel=1e-5)
    motion = classify([two.parameters], **LENGTHS)
    assert motion["period_time"][0] == pytest.approx(two.period_time, abs=1e-9)
    for name in ("period_events", "period_returns"):
        assert motion[name][0] == getattr(two, name)


def test_the_monodromy_is_that_of_central_differences(five):
    """One coordinate at a time, 1e-5 to either side; all blocks are stuck at the state."""
    apart = 1e-5
    for block in range(5):
        shift = apart * np.eye(5)[block]
        ahead, behind = (
            after(five.state.moved(positions=five.state.positions + side * shift), five.period_time)
            for side in (1, -1)
        )
        column = (ahead.displacements - behind.displacements) / (2 * apart)
        assert np.abs(column - five.monodromy[:, block]).max() < 1e-6


def test_any_instant_of_the_orbit_will_do(five):
    """States of the orbit by turns of a period, with some blocks slipping."""
    states = [after(five.state, share * five.period_time) for share in (0.21, 0.55, 0.83)]
    assert any(np.any(state.directions != 0) for state in states)
    for state in states:
        orbit = close_orbit(state, five.period_time)
        assert orbit.period_time == pytest.approx(five.period_time, abs=1e-10)
        assert orbit.multipliers == pytest.approx(five.multipliers, abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"chains": ChainParameters(2, 5.0, 1.0)}, "noise = 1: must be 0"),
        ({"chains": ChainParameters(7, 10.0)}, "N=7, u=10, sigma=0: no state comes back"),
        ({"duration": 2010.0}, "N=2, u=5, sigma=0: no state comes back in the last 10 time units"),
        ({"transient": 0.0}, "transient = 0: must be greater than 0"),
    ],
)
def test_bad_input_is_one_line(changes, message):
    settings = {"chains": ChainParameters(2, 5.0), **LENGTHS} | changes
    with pytest.raises(InputError) as caught:
        periodic_orbit(**settings)
    assert message in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("chain", "message"),
    [
        (ChainParameters(7, 10.0), "no orbit closes near the state after about the time 50"),
        (ChainParameters(3, 60.0), "equilibrium slip"),
    ],
)
def test_what_does_not_come_back_is_one_line(chain, message):
    if chain.n_blocks == 7:
        begin = ChainState.at_rest(chain, chain.rest_positions + np.arange(7.0))
        state = after(begin, 3000.0)
    else:
        state = sliding(chain, np.array([0.5, -1.0, 1.5]))
    with pytest.raises(InputError, match=message):
        close_orbit(state, 50.0)
