"""Audits of runs: sound ones pass, and each defect is seen by the audit that is to see it."""

import dataclasses

import numpy as np
import pytest
from test_engine import limit_cycle

from beltrepro import ChainParameters, audit, simulate
from beltrepro.simulation.audit import motion


def disguised(run, **claimed):
    """A run that says of itself that it has another law."""
    return dataclasses.replace(run, parameters=dataclasses.replace(run.parameters, **claimed))


@pytest.fixture(scope="module", params=["verlet", "event"])
def quiet(request):
    return simulate(ChainParameters(5, 20.0), duration=150, method=request.param)


@pytest.fixture(scope="module", params=["verlet", "event"])
def noisy(request):
    return simulate(ChainParameters(5, 20.0, 2.2), duration=1500, method=request.param)


@pytest.mark.thorough
def test_the_motion_computed_anew_has_the_closed_form_of_one_block():
    slip_time, period, _ = limit_cycle()
    chain = ChainParameters(1, 1.0)
    start = np.array([50.0 + 20 + 100 * np.log(1.514) - 2.0]), np.array([1.0])
    # it sticks, slips two time units later, sticks, and is back after a period
    positions, velocities = motion(*start, 2.0 + slip_time / 2, chain)
    assert velocities[0] != 1.0
    positions, velocities = motion(*start, period, chain)
    assert positions[0] == pytest.approx(start[0][0], abs=1e-5)
    assert velocities[0] == 1.0


@pytest.mark.filterwarnings("ignore:loading")
def test_events_within_one_step_are_taken_in_their_order(monkeypatch):
    chain = ChainParameters(7, 10.0)
    run = simulate(chain, duration=90.0, sample_interval=1.0)
    # so long a step has two events now and then
    monkeypatch.setattr("beltrepro.simulation.audit._STEP", 0.05)
    positions, _ = motion(run.positions[60], run.velocities[60], 30.0, chain)
    np.testing.assert_allclose(positions, run.positions[90], atol=0.01)


def test_sound_runs_pass(quiet):
    audited = audit(quiet, windows=8)
    exact = quiet.method == "event"
    assert audited.windows == 8
    assert audited.deviation < (1e-6 if exact else 0.05)
    assert audited.wrong_way <= (1e-9 if exact else 0.1)
    assert 0.9 < audited.overload < 1.003
    assert np.isnan(audited.noise_ratio)


def test_wrong_events_are_seen_where_the_energy_closes(quiet):
    # the same kinetic friction, so the same motion and energy; but blocks slip a little later
    threshold = 1.02 * 71.4
    chain = ChainParameters(5, 20.0, static_friction=threshold, friction_ratio=0.45 / 1.02)
    run = simulate(chain, duration=150, method=quiet.method)
    wrong = disguised(run, static_friction=71.4, friction_ratio=0.45)
    audited = audit(wrong, windows=8)
    assert abs(audited.energy_residual) < 1e-4
    assert audited.deviation > 0.1
    assert audited.overload > 1.01


def test_a_block_that_does_not_stick_is_seen(quiet):
    # from then on it moves against the direction of its slip, and friction pushes it on
    relative = quiet.velocities - 20.0
    friction = quiet.friction.copy()
    pushed = np.argmax(np.abs(relative[:, 2]))
    friction[pushed, 2] *= -1
    wrong = dataclasses.replace(quiet, friction=friction)
    assert audit(wrong, windows=0).wrong_way == np.abs(relative[:, 2]).max() > 5


def test_the_strength_of_noise_is_seen(noisy):
    audited = audit(noisy)
    assert np.isnan(audited.deviation) and audited.windows == 0
    assert 0.02 < audited.noise_error < 0.06
    # error rate 1e-6
    assert abs(audited.noise_ratio - 1) < 5 * audited.noise_error
    stronger = audit(disguised(noisy, noise=3.0))
    assert abs(stronger.noise_ratio - 1) > 5 * stronger.noise_error


def test_runs_with_few_samples_are_audited_as_far_as_they_go():
    for chain in (ChainParameters(1, 5.0), ChainParameters(1, 5.0, 1.0)):
        for interval in (None, 10.0):
            audited = audit(simulate(chain, duration=15, sample_interval=interval))
            assert np.isnan(audited.noise_ratio)
            assert audited.windows in (0, 1)
