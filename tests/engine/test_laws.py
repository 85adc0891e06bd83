"""Other laws than the paper's: blocks that differ, friction that depends on the velocity.

Each is held against the motion computed anew from the equations (`replay`), against closed forms,
and against what must not change when units do.
"""

import dataclasses
import math

import numpy as np
import pytest

import replay
from beltrepro import (
    ChainParameters,
    ChainState,
    catalogue,
    mode_energies,
    orbit_branch,
    periodic_orbit,
    scan,
    simulate,
    sliding_energy,
    slipping_state,
)
from beltrepro.base.errors import InputError
from beltrepro.chaos.periodic_orbits import coordinates, flow

DISORDER = {
    "static_friction": (60.0, 71.4, 80.0),
    "friction_ratio": (0.3, 0.45, 0.6),
    "rest_length": (40.0, 50.0, 60.0),
    "mass": (0.5, 1.0, 2.0),
    "stiffness": (1.0, 2.0, 0.5),
}
LAWS = {
    "blocks differ": DISORDER,
    "weakening": {"weakening_velocity": 20.0},
    "viscous": {"viscosity": 0.3},
    "all": {**DISORDER, "weakening_velocity": 20.0, "viscosity": 0.1, "linear_limit": 10.0},
}


@pytest.fixture(params=LAWS)
def chain(request):
    return ChainParameters(3, 10.0, **LAWS[request.param])


def test_the_scheme_comes_to_the_exact_motion_at_first_order(chain):
    exact = simulate(chain, duration=14.0, method="event").final_state.positions
    runs = [
        simulate(chain, duration=14.0, method="verlet", time_step=step) for step in (8e-4, 1e-4)
    ]
    errors = [np.abs(run.final_state.positions - exact).max() for run in runs]
    assert errors[1] < 0.3 * errors[0] and errors[1] < 0.01


def test_energy_is_balanced_and_the_motion_is_that_of_plain_python(chain):
    run = simulate(chain, duration=200.0, transient=50.0, sample_interval=0.1)
    assert abs(run.energy_residual) < 1e-13
    assert replay.deviation(run, windows=20) < 1e-4
    assert replay.wrong_way(run) == 0 and replay.overload(run) < 1 + 1e-12
    scheme = simulate(chain, duration=200.0, transient=50.0, method="verlet")
    assert abs(scheme.energy_residual) < 1e-4
    if chain.friction_varies:
        assert np.isnan(run.sum_rule_residual)
    else:
        assert abs(run.sum_rule_residual) < 1e-12


def test_wrong_events_are_seen_where_the_energy_closes():
    """The same kinetic friction, so the same slips; but blocks slip a little later."""
    law = {"static_friction": 1.02 * 71.4, "friction_ratio": 0.45 / 1.02}
    run = simulate(ChainParameters(5, 20.0, **law), duration=150.0)
    wrong = dataclasses.replace(run, parameters=ChainParameters(5, 20.0))
    assert replay.deviation(run, windows=8) < 1e-6
    assert replay.deviation(wrong, windows=8) > 0.1 and replay.overload(wrong) > 1.01


@pytest.mark.parametrize("method", ["event", "verlet"])
def test_units_do_not_matter(method):
    """Masses m, springs k and lengths a: time goes as sqrt(m/k), forces as k a."""
    m, k, a = 4.0, 9.0, 1.0
    time = math.sqrt(m / k)
    usual = ChainParameters(4, 10.0)
    other = ChainParameters(4, 10.0 * a / time, static_friction=71.4 * k * a, mass=m, stiffness=k)
    one, two = (
        simulate(chain, duration=40.0 * unit, time_step=0.001 * unit, method=method)
        for chain, unit in ((usual, 1.0), (other, time))
    )
    atol = 1e-9 if method == "event" else 1e-7
    ends = two.final_state.positions, one.final_state.positions
    np.testing.assert_allclose(*ends, rtol=0, atol=atol)
    assert len(two.events) == len(one.events)


def test_a_block_that_slides_oscillates_as_its_mass_and_spring_say():
    chain = ChainParameters(1, 50.0, mass=4.0, stiffness=9.0, linear_limit=math.inf)
    balance = 50 + 0.45 * 71.4 / 9.0
    start = ChainState.in_motion(chain, [balance + 2.0], [0.0])
    quarter = math.pi / 2 / 1.5
    end = simulate(chain, duration=quarter, initial_state=start).final_state
    assert end.positions[0] == pytest.approx(balance, abs=1e-12)
    assert end.velocities[0] == pytest.approx(-2.0 * 1.5, abs=1e-12)
    assert sliding_energy(chain, [balance + 2.0], [0.0]) == pytest.approx(9.0 * 4.0 / 2)
    assert mode_energies(chain, [balance], [-3.0])[0] == pytest.approx(18.0)


def test_a_viscous_block_comes_to_rest_exponentially():
    law = {"mass": 2.0, "stiffness": 1e-9, "viscosity": 0.5, "friction_ratio": 0.0}
    chain = ChainParameters(1, 50.0, linear_limit=math.inf, **law)
    start = ChainState.in_motion(chain, [1e3], [20.0])
    end = simulate(chain, duration=3.0, initial_state=start).final_state
    # it comes to the velocity of the belt, with the rate eta / m
    assert 50.0 - end.velocities[0] == pytest.approx(30.0 * math.exp(-3.0 * 0.25), rel=1e-6)


def test_many_slipping_states_of_one_energy_have_it(chain):
    if chain.friction_varies:
        with pytest.raises(InputError, match="energy is kept only where kinetic friction"):
            slipping_state(chain, 40.0)
        return
    for replicate in range(5):
        state = slipping_state(chain, 20.0, replicate=replicate)
        energy = sliding_energy(chain, state.positions, state.velocities)
        assert energy == pytest.approx(20.0) and np.all(state.directions == -1)
        run = simulate(chain, duration=20.0, initial_state=state)
        later = sliding_energy(chain, run.final_state.positions, run.final_state.velocities)
        assert later == pytest.approx(20.0) and len(run.events) == 0
    modes = mode_energies(chain, state.positions, state.velocities)
    assert modes.shape == (3,) and np.all(modes > 0)


def test_the_flow_is_the_rate_at_which_a_run_goes_on(chain):
    state = simulate(chain, duration=80.0).final_state
    while not state.directions.any():
        state = simulate(chain, duration=0.5, initial_state=state).final_state
    later = simulate(chain, duration=1e-5, initial_state=state).final_state
    assert np.array_equal(later.directions, state.directions)
    rates = (coordinates(later) - coordinates(state)) / 1e-5
    assert rates == pytest.approx(flow(state), abs=2e-2)


def test_orbits_are_found_and_followed_in_a_constant_of_another_law():
    chain = ChainParameters(2, 10.0, weakening_velocity=200.0, viscosity=0.05, mass=(1.0, 1.1))
    orbit = periodic_orbit(chain, duration=3000.0, transient=2000.0)
    again = simulate(chain, duration=orbit.period_time, initial_state=orbit.state)
    ends = again.final_state.positions, orbit.state.positions
    np.testing.assert_allclose(*ends, rtol=0, atol=1e-8)
    branch = orbit_branch(orbit, quantity="viscosity", lower=0.04, upper=0.06)
    values = [one.parameters.viscosity for one in branch.orbits]
    assert min(values) < 0.05 < max(values) and len(values) > 5
    with pytest.raises(InputError, match="differs among the blocks"):
        orbit_branch(orbit, quantity="mass", lower=0.9, upper=1.1)


@pytest.mark.parametrize("method", ["event", "verlet"])
def test_noise_moves_each_block_by_its_own_friction_and_mass(method):
    """Free blocks that slip: their velocity diffuses with the power (f sigma / m)^2 dt."""
    blocks = {"friction_ratio": (0.2, 0.4), "mass": (0.5, 2.0)}
    chain = ChainParameters(2, 1000.0, 0.5, stiffness=1e-6, rest_length=1e4, **blocks)
    start = ChainState.in_motion(chain, [1e4, 2e4], [0.0, 0.0])
    runs = simulate(chain, replicate=range(400), duration=2.0, method=method, initial_state=start)
    ends = np.array([run.final_state.velocities for run in runs])
    power = (np.array([0.2, 0.4]) * 0.5 / np.array([0.5, 2.0])) ** 2 * 0.001
    measured = ends.var(axis=0) / (2.0 * power)
    assert measured == pytest.approx(1.0, abs=4 * math.sqrt(2 / 400))
    steady = 0.001 / 0.001 * np.array([0.2, 0.4]) * 71.4 / np.array([0.5, 2.0]) * 2.0
    assert ends.mean(axis=0) == pytest.approx(steady, rel=1e-3)


@pytest.mark.parametrize("law", [{"mass": 1e-4}, {"stiffness": 1e4}])
def test_noise_heats_a_fast_block_as_a_slow_one(law):
    """By q / 2m in a unit of time. Its period is 0.06, and noise within a cell of 0.5 is smooth."""
    chain = ChainParameters(1, 1e5, 5.0, linear_limit=math.inf, rest_length=1e4, **law)
    balance = 1e4 + 0.45 * 71.4 / chain.stiffness
    start = ChainState.in_motion(chain, [balance], [0.0])
    settings = {"initial_state": start, "sample_interval": None}
    ends = [
        run.final_state for run in simulate(chain, duration=20, replicate=range(200), **settings)
    ]
    energies = [float(sliding_energy(chain, end.positions, end.velocities)) for end in ends]
    due = (0.45 * 5.0) ** 2 * 0.001 / (2 * chain.mass) * 20
    assert np.mean(energies) == pytest.approx(due, rel=4 / math.sqrt(200))


def test_r_of_fast_chains_is_that_of_slow_ones():
    usual = ChainParameters(3, 10.0)
    fast = ChainParameters(3, 1000.0, mass=1e-4)
    one, other = (
        scan(chain, duration=6000 * unit, transient=2000 * unit)["disorder_parameter"]
        for chain, unit in ((usual, 1.0), (fast, 0.01))
    )
    assert other == pytest.approx(one, rel=1e-3)
    for method in ("event", "verlet"):
        run = simulate(fast, duration=2.0, transient=1.0, method=method, time_step=1e-4)
        usual_run = simulate(usual, duration=200.0, transient=100.0)
        assert run.disorder_parameter == pytest.approx(usual_run.disorder_parameter, rel=0.02)


def test_weakening_noise_is_left_to_the_scheme():
    chain = ChainParameters(3, 10.0, 1.0, weakening_velocity=5.0)
    with pytest.raises(InputError, match=r"its strength depends on the velocity.*take 'verlet'"):
        simulate(chain, duration=20.0, method="event")
    run = simulate(chain, duration=60.0, transient=30.0, method="verlet")
    assert abs(run.energy_residual) < 1e-3 and len(run.events) > 5


def test_noise_weakens_with_the_speed_as_friction_does():
    """A free block that slips at the velocity at which friction has fallen by half."""
    free = {"stiffness": 1e-6, "rest_length": 1e4, "weakening_velocity": 1000.0}
    chain = ChainParameters(1, 1000.0, 0.5, **free)
    start = ChainState.in_motion(chain, [1e4], [0.0])
    runs = simulate(chain, replicate=range(400), duration=2.0, method="verlet", initial_state=start)
    ends = np.array([run.final_state.velocities[0] for run in runs])
    power = (0.45 * 0.5 / 2) ** 2 * 0.001
    assert ends.var() / (2.0 * power) == pytest.approx(1.0, abs=4 * math.sqrt(2 / 400))


def test_thresholds_are_drawn_about_the_mean_of_each_block():
    chain = ChainParameters(3, 10.0, 2.0, **DISORDER)
    states = [ChainState.at_rest(chain, replicate=number) for number in range(500)]
    thresholds = np.array([state.thresholds for state in states])
    assert thresholds.mean(axis=0) == pytest.approx(DISORDER["static_friction"], abs=0.4)
    assert thresholds.std(axis=0) == pytest.approx(2.0, abs=0.25)
    run = simulate(chain, duration=100.0, transient=20.0)
    slips = run.events[run.events["kind"] == "slip"]
    for block, mean in enumerate(DISORDER["static_friction"], start=1):
        forces = np.abs(slips["force"][slips["block"] == block])
        assert np.abs(forces - mean).max() < 6 * 2.0


def test_equal_numbers_are_one_number_and_give_the_same_bits():
    one = ChainParameters(3, 10.0, static_friction=[71.4] * 3, mass=np.ones(3))
    assert one == ChainParameters(3, 10.0) and not one.varied
    assert repr(one) == "ChainParameters(n_blocks=3, belt_velocity=10.0)"
    assert ChainParameters(2, 10.0, mass=[1, 2]).mass == (1.0, 2.0)


def test_the_energy_of_avalanches_is_that_of_the_springs_that_differ():
    chain = ChainParameters(3, 1e-3, **DISORDER)
    avalanches = catalogue(chain, duration=1e6, transient=2e5)["avalanches"]
    # at u -> 0 the belt does no work in an avalanche
    dropped, lost = avalanches["spring_energy_drop"], avalanches["dissipated"]
    assert len(dropped) > 5 and dropped == pytest.approx(lost, rel=1e-2)
