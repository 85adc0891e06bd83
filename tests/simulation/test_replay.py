"""Runs agree with their motion in plain Python, and each defect is seen by the check that is to."""

import dataclasses

import numpy as np
import pytest
from test_engine import limit_cycle

import replay
from beltrepro import ChainParameters, simulate


def disguised(run, **claimed):
    """A run that says of itself that it has another law."""
    return dataclasses.replace(run, parameters=dataclasses.replace(run.parameters, **claimed))


@pytest.fixture(scope="module", params=["verlet", "event"])
def quiet(request):
    return simulate(ChainParameters(5, 20.0), duration=150, method=request.param)


@pytest.mark.thorough
def test_the_motion_computed_anew_has_the_closed_form_of_one_block():
    slip_time, period, _ = limit_cycle()
    chain = ChainParameters(1, 1.0)
    start = np.array([50.0 + 20 + 100 * np.log(1.514) - 2.0]), np.array([1.0])
    # it sticks, slips two time units later, sticks, and is back after a period
    positions, velocities = replay.motion(*start, 2.0 + slip_time / 2, chain)
    assert velocities[0] != 1.0
    positions, velocities = replay.motion(*start, period, chain)
    assert positions[0] == pytest.approx(start[0][0], abs=1e-5)
    assert velocities[0] == 1.0


def test_sound_runs_pass(quiet):
    exact = quiet.method == "event"
    assert replay.deviation(quiet, windows=8) < (1e-6 if exact else 0.05)
    assert replay.wrong_way(quiet) <= (1e-9 if exact else 0.1)
    assert 0.9 < replay.overload(quiet) < 1.003


def test_wrong_events_are_seen_where_the_energy_closes(quiet):
    # the same kinetic friction, so the same motion and energy; but blocks slip a little later
    chain = ChainParameters(5, 20.0, static_friction=1.02 * 71.4, friction_ratio=0.45 / 1.02)
    run = simulate(chain, duration=150, method=quiet.method)
    wrong = disguised(run, static_friction=71.4, friction_ratio=0.45)
    assert abs(wrong.energy_residual) < 1e-4
    assert replay.deviation(wrong, windows=8) > 0.1
    assert replay.overload(wrong) > 1.01


@pytest.mark.parametrize("method", ["verlet", "event"])
def test_the_strength_of_noise_is_seen(method):
    run = simulate(ChainParameters(5, 20.0, 2.2), duration=1500, method=method)
    ratio, error = replay.noise_ratio(run)
    assert 0.02 < error < 0.06 and abs(ratio - 1) < 5 * error  # error rate 1e-6
    ratio, error = replay.noise_ratio(disguised(run, noise=3.0))
    assert abs(ratio - 1) > 5 * error
