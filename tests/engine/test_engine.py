"""Both integrators against closed forms and the naive loop: order, energy, turns, branches."""

import itertools
from functools import partial

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import naive
import replay
from advancing import at_rest, integrator, recorded
from beltrepro import ChainParameters, ChainState, simulate
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.law import (
    branch_at,
    expand_spring,
    extension,
    law_constants,
    tension,
)
from beltrepro.engine.law import (
    spring_energy as kernel_energy,
)
from beltrepro.engine.vector import kernel
from beltrepro.engine.verlet_integrator import VerletIntegrator
from beltrepro.model.spring import (
    acceleration,
    chain_deformations,
    spring_energy,
    spring_extension,
    spring_force,
    spring_stiffness,
)

SINGLE = ChainParameters(1, 1.0)


def limit_cycle():
    """Slip time, period and r of one block (N=1, u=1, sigma=0): quadrature of the energy integral.

    It starts to slip at F_e = F_st with v = u; then v^2/2 + U(x) - F_k x is constant until v = u.
    """
    kinetic = 0.45 * 71.4
    high = float(spring_extension(71.4, SINGLE))

    def effective(x):
        return float(spring_energy(x, SINGLE)) - kinetic * x

    energy = 0.5 + effective(high)
    # v = +1 at `high`, turns, moves to lower x, turns again and reaches v = 1 at the same
    # effective potential below the minimum
    middle = float(spring_extension(kinetic, SINGLE))
    top = brentq(lambda x: effective(x) - energy, high, high + 50)
    bottom = brentq(lambda x: effective(x) - energy, -200, middle)
    low = brentq(lambda x: effective(x) - energy + 0.5, -200, middle)

    def moments(a, b):
        # substitution x = m + w sin(theta) removes the root at a turning point
        m, w = (a + b) / 2, (b - a) / 2

        def integrand(theta, power):
            x = m + w * np.sin(theta)
            speed = np.sqrt(max(2 * (energy - effective(x)), 1e-300))
            return (50 + x) ** power * w * np.cos(theta) / speed

        ends = -np.pi / 2, np.pi / 2
        return np.array([quad(integrand, *ends, p, epsabs=1e-11, limit=400)[0] for p in range(3)])

    slip = moments(high, top) + moments(bottom, top) + moments(bottom, low)
    stuck = np.array([((50 + high) ** (p + 1) - (50 + low) ** (p + 1)) / (p + 1) for p in range(3)])
    time, first, second = slip + stuck
    mean = first / time
    return slip[0], time, np.sqrt(second / time - mean**2) / mean


@pytest.mark.parametrize(
    ("method", "late", "error", "of_r"),
    [("verlet", 0.0011, 0.02, 1e-3), ("event", 1e-12, 1e-8, 1e-4)],
)
def test_one_block_follows_the_closed_form(method, late, error, of_r):
    slip_time, period, disorder = limit_cycle()
    assert (period, disorder) == (pytest.approx(65.895, abs=5e-4), pytest.approx(0.2297, abs=5e-5))
    lengths = {"duration": round(period * 61, 2), "transient": round(period, 2)}
    run = simulate(SINGLE, method=method, sample_interval=0.01, **lengths)
    slips, sticks = (run.events["time"][run.events["kind"] == kind] for kind in ("slip", "stick"))
    assert slips[0] == pytest.approx(20 + 100 * np.log(1.514), abs=late)
    np.testing.assert_allclose(np.diff(slips), period, rtol=0, atol=error)
    np.testing.assert_allclose(sticks - slips[: len(sticks)], slip_time, rtol=0, atol=error)
    assert run.disorder_parameter == pytest.approx(disorder, rel=of_r)


@kernel
def fill_law(x, law, columns):
    for i in range(len(x)):
        columns[0, i], columns[1, i], rate, softness = expand_spring(x[i], law)
        columns[2, i] = tension(x[i], law)
        columns[3, i] = extension(columns[2, i], law)
        columns[4, i] = kernel_energy(0, x[i], law, None)
        columns[5, i] = branch_at(x[i], law)
        columns[6, i] = rate
        columns[7, i] = rate * softness


@pytest.mark.parametrize(
    "law",
    [{}, {"linear_limit": 7.0, "compression_rate": 0.1, "extension_rate": 0.03},
     {"linear_limit": np.inf}],
)  # fmt: skip
def test_the_spring_law_of_kernels_is_the_model(law):
    chain = ChainParameters(1, 1.0, **law)
    x = np.linspace(-60, 300, 3601)
    columns = np.empty((8, len(x)))
    fill_law(x, law_constants(chain), columns)
    pull, slope, again, inverse, energy, branch, rate, product = columns
    for values, expected in (
        (pull, -spring_force(x, chain)),
        (slope, spring_stiffness(x, chain)),
        (inverse, x),
        (energy, spring_energy(x, chain)),
    ):
        np.testing.assert_allclose(values, expected, rtol=3e-14, atol=3e-13)
    np.testing.assert_array_equal(again, pull)
    curved = np.abs(x) > chain.linear_limit
    np.testing.assert_array_equal(branch, np.sign(x) * curved)
    rates = np.where(x < 0, -chain.compression_rate, chain.extension_rate)
    np.testing.assert_array_equal(rate, np.where(curved, rates, 0.0))
    np.testing.assert_allclose(product[curved], 1.0)


# --- against the naive loop ---


def assert_naive(chain, steps, time_step, atol):
    """The run is that of the naive loop, with the same events; returns its positions and events."""
    law = {"threshold": chain.static_friction, "limit": chain.linear_limit}
    positions, events = naive.verlet(chain.n_blocks, chain.belt_velocity, steps, time_step, **law)
    steps_of = {"time_step": time_step, "sample_interval": time_step, "method": "verlet"}
    run = simulate(chain, duration=steps * time_step, **steps_of)
    np.testing.assert_allclose(run.positions[1:], positions, rtol=0, atol=atol)
    results = [(round(e["time"], 6), e["block"], str(e["kind"])) for e in run.events]
    assert results == [(round(t, 6), block, kind) for t, block, kind in events]
    return np.array(positions), events


@pytest.mark.parametrize(
    ("n_blocks", "belt_velocity", "steps", "time_step", "least_events"),
    [
        # 2x(t) - x(t-dt) loses digits in every step that the kernel keeps: 1e-14 a step
        (1, 15.0, 12000, 0.001, 2),
        (3, 20.0, 12000, 0.001, 2),
        (5, 30.0, 12000, 0.001, 2),
        (5, 30.0, 3000, 0.004, 10),
        (3, 30.0, 3000, 0.02, 10),
        (64, 30.0, 3000, 0.01, 10),
        (5, 30.0, 3000, 0.05, 81),
        (5, 30.0, 3000, 0.1, 81),
    ],
)
def test_kernel_is_the_naive_loop(n_blocks, belt_velocity, steps, time_step, least_events):
    chain = ChainParameters(n_blocks, belt_velocity)
    _, events = assert_naive(chain, steps, time_step, 2e-9)
    assert len(events) >= least_events


@pytest.mark.parametrize("time_step", [0.004, 0.01])
def test_reversals_and_ends_of_the_branches_follow_the_naive_loop(time_step):
    # so little friction that a block often turns where |F_ex| > F_st
    chain = ChainParameters(3, 20.0, static_friction=3.05)
    _, events = assert_naive(chain, round(80 / time_step), time_step, 1e-8)
    pairs = itertools.pairwise(events)
    reversals = [a for a, b in pairs if a[:2] == b[:2] and (a[2], b[2]) == ("stick", "slip")]
    assert len(reversals) >= 3
    # with a short linear branch, springs pass its ends all the time
    chain = ChainParameters(4, 15.0, static_friction=30.0, linear_limit=2.0)
    positions, _ = assert_naive(chain, round(60 / time_step), time_step, 1e-8)
    deformations = chain_deformations(positions, chain)
    branch = np.sign(deformations) * (np.abs(deformations) > 2.0)
    assert np.abs(np.diff(branch, axis=0)).sum() > 20 and (branch < 0).any()


# --- states that go on ---

KINDS = (EventIntegrator, VerletIntegrator, partial(VerletIntegrator, literal=True))


@pytest.mark.parametrize("maker", KINDS)
def test_a_state_goes_on_in_any_scheme_and_step(maker):
    """The variables of another scheme, or of another time step, are made anew."""
    chains = [ChainParameters(3, u) for u in (20.0, 35.0, 60.0)]
    made = integrator(maker, at_rest(chains), time_step=0.001)
    for until in (6.0, 11.0):
        recorded(made, until)
        states = made.state()
        assert any(state.directions.any() for state in states)
        exact = recorded(integrator(EventIntegrator, states), until + 1.0)
        for kind in KINDS:
            for time_step in (0.002, 0.001, 0.0005):
                on = recorded(integrator(kind, states, time_step=time_step), until + 1.0)
                for one, other in zip(on, exact, strict=True):
                    assert np.abs(one.positions - other.positions).max() < 0.02


@pytest.mark.parametrize("law", [{}, {"mass": (1.0, 2.0, 0.5), "stiffness": (1.0, 2.0, 1.0)}])
def test_a_start_in_motion_has_the_step_before_it_to_the_third_order(law):
    """Beside the motion through the state, backwards in fine steps; and stuck blocks have none."""
    chain = ChainParameters(3, 10.0, **law)
    state = ChainState.in_motion(chain, [70.0, 135.0, 195.0], [-5.0, -8.0, -3.0])

    def rates(_, numbers):
        places, velocities = np.split(numbers, 2)
        pulls = acceleration(places, velocities - 10.0, state.directions, chain)
        return np.concatenate([velocities, pulls])

    begin, errors = np.concatenate([state.positions, state.velocities]), []
    for time_step in (0.02, 0.01):
        made = integrator(VerletIntegrator, [state], time_step=time_step, literal=True)._chains
        back = solve_ivp(rates, (0.0, -time_step), begin, rtol=1e-13, atol=1e-13).y[:, -1]
        step = state.positions - back[:3] - 10.0 * time_step
        before = rates(0.0, back)[3:] * time_step**2
        errors.append(np.abs([made.slip_step[:, 0] - step, made.acceleration[:, 0] - before]))
    # the fourth power of the time step in both
    assert np.all(errors[0] > 12 * errors[1]) and np.all(errors[1] < 1e-6)
    stuck = integrator(VerletIntegrator, at_rest([chain]), literal=True)._chains
    assert not stuck.slip_step.any() and not stuck.acceleration.any()


# --- long chains ---


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_thousand_blocks_move_alike_by_both_integrators(noise):
    chain = ChainParameters(1000, 20.0, noise)
    # springs that hold too much, now here, now there: nearly all blocks slip
    start = chain.rest_positions + np.tile([0.0, 32.0], 500) + np.sin(np.arange(1000))
    settings = {"duration": 1.0, "initial_positions": start}
    event, verlet = (simulate(chain, method=name, **settings) for name in ("event", "verlet"))
    assert np.abs(event.positions - verlet.positions).max() < 0.1 * (1 + noise)
    assert len(np.unique(event.events["block"])) > 900
    for run in (event, verlet):
        assert abs(run.energy_residual) < 0.01
        assert replay.wrong_way(run) < 0.2
