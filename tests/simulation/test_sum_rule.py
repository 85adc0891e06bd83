"""The sum rule: what the wall pulls with on average, for every chain, and what breaks it."""

import dataclasses

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, simulate
from beltrepro.model.spring import chain_deformations, spring_force

KINETIC = 71.4 * 0.45


@pytest.mark.parametrize("noise", [0.0, 2.2, 10.0])
@pytest.mark.parametrize("method", ["event", "verlet"])
def test_the_wall_pulls_with_the_friction_of_all_blocks(method, noise):
    chains = [ChainParameters(5, speed, noise) for speed in (1.0, 8.0, 20.0, 45.0)]
    for run in simulate(chains, duration=200, method=method):
        speed, power = run.parameters.belt_velocity, (0.45 * noise) ** 2 * 1e-3
        relative = ((run.velocities - speed) ** 2).sum(axis=1).mean() * 200
        # of the work of noise on the blocks that slip, as a share of N k u t
        deviation = np.sqrt(power * relative) / (speed * 200 * 5 * KINETIC)
        rounding = 1e-13 if method == "event" else 5e-5
        assert abs(run.sum_rule_residual) < 5 * deviation + rounding


def test_the_mean_pull_is_that_of_the_first_spring():
    run = simulate(ChainParameters(3, 10.0), duration=300, sample_interval=0.01)
    pull = -spring_force(chain_deformations(run.positions, run.parameters)[:, 0], run.parameters)
    assert run.mean_wall_tension == pytest.approx((pull[1:] + pull[:-1]).mean() / 2, rel=1e-5)
    # by the sum rule, up to H / (u t)
    assert run.mean_wall_tension == pytest.approx(3 * KINETIC, rel=0.03)
    half = simulate(run.parameters, duration=100)
    rest = simulate(run.parameters, duration=200, initial_state=half.final_state)
    assert (half.mean_wall_tension + 2 * rest.mean_wall_tension) / 3 == pytest.approx(
        run.mean_wall_tension, rel=1e-12
    )
    assert abs(rest.sum_rule_residual) < 1e-13


@pytest.mark.parametrize("duration", [0.3, 1.0, 40.0])
def test_slips_that_are_faster_than_the_belt_are_counted(duration):
    # compressed springs throw the last block forward; so does a start in such a slip
    thrown = [
        ChainState.at_rest(ChainParameters(2, 10.0), [20.0, 40.0]),
        ChainState.in_motion(ChainParameters(2, 10.0), None, [50.0, 60.0]),
    ]
    for start in thrown:
        run = simulate(start.parameters, duration=duration, initial_state=start)
        assert abs(run.sum_rule_residual) < 1e-13
        assert abs(run.mean_wall_tension / (2 * KINETIC) - 1) > 1e-3


def test_wrong_friction_is_seen_where_the_energy_closes():
    run = simulate(ChainParameters(5, 20.0, friction_ratio=0.46), duration=3000)
    assert abs(run.energy_residual) < 1e-13
    claimed = {"initial_state", "final_state"}
    right = dataclasses.replace(run.parameters, friction_ratio=0.45)
    states = {name: dataclasses.replace(getattr(run, name), parameters=right) for name in claimed}
    wrong = dataclasses.replace(run, parameters=right, **states)
    assert wrong.sum_rule_residual == pytest.approx(0.46 / 0.45 - 1, rel=0.01)


def test_a_share_of_no_friction_is_not_a_number():
    run = simulate(ChainParameters(2, 5.0, friction_ratio=0.0), duration=20, transient=10)
    assert np.isnan(run.sum_rule_residual) and run.mean_wall_tension > 0
