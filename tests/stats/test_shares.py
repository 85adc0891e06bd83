"""Shares of runs by a quantity, and the disturbance of a run."""

import dataclasses

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState
from beltrepro.chaos.disturbance import SCATTERS, WIDEST, disturbance, scatters
from beltrepro.simulation.setup import Case
from beltrepro.stats.shares import shares


def test_shares_by_value():
    found = shares([2.0, 1.0, 2.0, 1.0, 2.0, 2.0], [True, False, False, False, False, False])
    assert found.quantity.tolist() == [1.0, 2.0]
    assert found.value.tolist() == [0.0, 0.25]
    assert np.all((found.lower <= found.value) & (found.value <= found.upper))
    assert found.upper[0] > 0


@pytest.mark.thorough
def test_intervals_hold_the_true_share_at_least_as_often_as_they_say():
    """Of 4000 samples of 30 runs each: 0.95 or more, less four standard errors of 0.0034."""
    random = np.random.default_rng(1)
    runs = np.repeat(np.arange(4000), 30)
    found = shares(runs, random.random(runs.size) < 0.3)
    held = np.mean((found.lower <= 0.3) & (found.upper >= 0.3))
    assert 0.936 < held < 0.99


STATE = ChainState.at_rest(ChainParameters(5, 6.0))
EXACT = Case(STATE, "event", 0.001, None)


def noisy(noise):
    return ChainState.at_rest(ChainParameters(5, 6.0, noise=noise))


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({}, 0.0),
        ({"time_step": 0.1}, 0.0),
        ({"kick": 0.02}, 0.02),
        ({"method": "verlet"}, 6.0 * 0.001 / 3**0.5),
        ({"method": "verlet", "time_step": 0.004}, 6.0 * 0.004 / 3**0.5),
        ({"state": noisy(0.3)}, 0.3),
        ({"state": noisy(0.3), "kick": 0.4}, 0.5),
    ],
)
def test_disturbance_of_a_run(changed, expected):
    point = dataclasses.replace(EXACT, **changed)
    assert disturbance(point) == pytest.approx(expected)
    widest = WIDEST * 71.4
    limits = [each * expected for each in SCATTERS if each * expected < widest]
    assert scatters(point) == pytest.approx([*limits, widest] if expected else [])
