"""The disturbance of a run."""

import dataclasses

import pytest

from beltrepro import ChainParameters, ChainState
from beltrepro.chaos.scatter import SCATTERS, WIDEST, disturbance, scatters
from beltrepro.simulation.setup import Case

STATE, NOISY = (ChainState.at_rest(ChainParameters(5, 6.0, noise)) for noise in (0.0, 0.3))
EXACT = Case(STATE, "event", 0.001, None)


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({}, 0.0),
        ({"time_step": 0.1}, 0.0),
        ({"kick": 0.02}, 0.02),
        ({"method": "verlet"}, 6.0 * 0.001 / 3**0.5),
        ({"method": "verlet", "time_step": 0.004}, 6.0 * 0.004 / 3**0.5),
        ({"state": NOISY}, 0.3),
        ({"state": NOISY, "kick": 0.4}, 0.5),
    ],
)
def test_disturbance_of_a_run(changed, expected):
    point = dataclasses.replace(EXACT, **changed)
    assert disturbance(point) == pytest.approx(expected)
    widest = WIDEST * 71.4
    limits = [each * expected for each in SCATTERS if each * expected < widest]
    assert scatters(point) == pytest.approx([*limits, widest] if expected else [])
