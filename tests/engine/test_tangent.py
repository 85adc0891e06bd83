"""Deviations from chains: against twins, closed forms, conserved volume and 40 digits."""

import dataclasses

import numpy as np
import pytest

from advancing import at_rest, integrator
from beltrepro import ChainParameters, simulate
from beltrepro.engine.tangent import TangentIntegrator


def of_states(states, n_vectors=1, **settings):
    return integrator(TangentIntegrator, states, n_vectors=n_vectors, **settings)


def advance(chains, until):
    """Advance; returns the events of each chain on the way, as (time, block, 1 slip or 0 stick)."""
    events = [[] for _ in chains.parameters]
    for chunk in chains.advance(until):
        for lane, rows in enumerate(events):
            rows += chunk.events[lane, : chunk.event_count[lane], :3].tolist()
    return events


def n_stuck(chains):
    """Blocks of the first chain that are stuck now."""
    return int(np.sum(chains.state()[0].directions == 0))


def states_now(chains):
    return np.concatenate([chains.positions(), chains.velocities()], axis=1)


def carries_twins(chains, way, apart, until, least, most_stuck):
    """That chain 0 carries the central difference of its twins 1 and 2, over many events."""
    n_blocks = len(way)
    deviation = np.zeros_like(chains.deviations())
    deviation[:, :n_blocks, 0] = way
    chains.set_deviations(deviation)
    events, stuck = [[], [], []], 0
    for time in np.arange(chains.time + 0.5, until + 0.25, 0.5):
        for seen, new in zip(events, advance(chains, time), strict=True):
            seen += new
        stuck = max(stuck, n_stuck(chains))
    assert len(events[0]) >= least
    assert most_stuck is None or (stuck == n_blocks) == most_stuck
    assert [event[1:] for event in events[1]] == [event[1:] for event in events[2]]
    ahead, behind = states_now(chains)[1:]
    carried = chains.deviations()[0, : 2 * n_blocks, 0]
    assert np.abs((ahead - behind) / (2 * apart) - carried).max() < 1e-6 * np.abs(carried).max()


VARYING = {"viscosity": 0.05, "weakening_velocity": 50.0, "mass": 1.5}


@pytest.mark.parametrize(
    ("n_blocks", "belt_velocity", "until", "least", "law"),
    [
        (1, 3.0, 150.0, 10, {}),
        (2, 6.0, 230.0, 50, {}),
        (5, 20.0, 60.0, 50, {}),
        (10, 30.0, 45.0, 50, {}),
        (3, 10.0, 100.0, 20, VARYING),
    ],
)
def test_deviations_are_the_differences_of_twins(n_blocks, belt_velocity, until, least, law):
    """Central differences of twins 1e-5 apart: their own error is 1e-10 / 1e-5 of rounding."""
    chain = ChainParameters(n_blocks, belt_velocity, **law)
    random, apart = np.random.default_rng(2), 1e-5
    start = chain.rest_positions + random.standard_normal(n_blocks)
    way = random.standard_normal(n_blocks)
    starts = [start, start + apart * way, start - apart * way]
    chains = of_states(at_rest([chain] * 3, starts))
    carries_twins(chains, way, apart, until, least, most_stuck=None)


@pytest.mark.parametrize(
    ("n_blocks", "belt_velocity", "noise", "span", "least", "rests"),
    [
        (5, 40.0, 2.0, 40.0, 10, False),
        (10, 30.0, 1.0, 40.0, 30, False),
        (2, 20.0, 1.0, 60.0, 30, True),
        (5, 20.0, 1.0, 60.0, 60, True),
    ],
)
@pytest.mark.parametrize("law", [{}, {"mass": 2.0, "friction_ratio": 0.4, "stiffness": 1.5}])
def test_deviations_under_noise_are_the_differences_of_twins(
    n_blocks, belt_velocity, noise, span, least, rests, law
):
    """Twins with one cell of the noise and one stream.

    They have the same noise at the same instants until the whole chain rests. It begins anew with
    the first slip after that, which comes at different instants, and so does all noise after it.
    """
    chain, apart = ChainParameters(n_blocks, belt_velocity, noise, **law), 1e-4
    least, rests = (6, None) if law else (least, rests)
    state = simulate(chain, duration=500.0, method="event", tolerance=1e-12).final_state
    way = np.random.default_rng(2).standard_normal(n_blocks)
    twins = [
        dataclasses.replace(state, displacements=state.displacements + side * apart * way)
        for side in (0, 1, -1)
    ]
    chains = of_states(twins, tolerance=1e-12, noise_share=0.0)
    carries_twins(chains, way, apart, 500.0 + span, least, rests)


@pytest.mark.parametrize(
    ("velocity", "noise", "law"), [(20.0, 0.0, {}), (7.0, 1.0, {}), (10.0, 0.0, VARYING)]
)
def test_the_flow_is_carried_into_the_flow(velocity, noise, law):
    """The deviation along the motion itself: velocity and acceleration, through every event."""
    chain = ChainParameters(5, velocity, noise, **law)
    start = chain.rest_positions + np.random.default_rng(5).standard_normal(5)
    chains = of_states(at_rest([chain], [start]), tolerance=1e-12, noise_share=0.0)
    flow = chains.flow()
    assert flow[0, :5] == pytest.approx(velocity) and not flow[0, 5:10].any()
    chains.set_deviations(flow[..., None])
    events, stuck = advance(chains, 260.0), 0
    for time in np.arange(260.5, 301.0, 0.5):
        advance(chains, time)
        stuck = max(stuck, n_stuck(chains))
        assert chains.deviations()[..., 0] == pytest.approx(chains.flow(), rel=1e-6, abs=1e-6)
    assert len(events[0]) > 100
    assert not noise or (stuck == 5 and flow[0, 10] == -1.0)


def test_volume_shrinks_in_a_reversal_by_the_accelerations():
    """det M = (|F| - k) / (|F| + k) for each reversal without sticking, F the external force."""
    chain = ChainParameters(1, 2.0, friction_ratio=0.1)
    chains = of_states(at_rest([chain], [chain.rest_positions + 120.0]), n_vectors=2)
    advance(chains, 0.01)
    chains.set_deviations(np.eye(2)[None])
    parts = [chunk.events[0, : chunk.event_count[0], :4].copy() for chunk in chains.advance(8.0)]
    times, _, slips, force = np.concatenate(parts).T  # each stick with the slip that goes on
    assert len(times) >= 4 and np.all(times[::2] == times[1::2])
    assert not slips[::2].any() and slips[1::2].all() and not n_stuck(chains)
    kinetic, pull = chain.friction_ratio * chain.static_friction, np.abs(force[::2])
    expected = np.prod((pull - kinetic) / (pull + kinetic))
    assert np.linalg.det(chains.deviations()[0]) == pytest.approx(expected, rel=1e-8)
