"""Chains of a thousand blocks: the same motion by both integrators, with and without noise."""

import numpy as np
import pytest

import replay
from beltrepro import ChainParameters, catalogue, scan, simulate

pytestmark = pytest.mark.filterwarnings("ignore:.*loading is measured:UserWarning")
CHAIN = ChainParameters(1000, 20.0)
# springs that hold too much, now here, now there: nearly all blocks slip
START = CHAIN.rest_positions + np.tile([0.0, 32.0], 500) + np.sin(np.arange(1000))


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_thousand_blocks_move_alike_by_both_integrators(noise):
    chain = ChainParameters(1000, 20.0, noise)
    settings = {"duration": 1.0, "initial_positions": START}
    event, verlet = (simulate(chain, method=name, **settings) for name in ("event", "verlet"))
    assert np.abs(event.positions - verlet.positions).max() < 0.1 * (1 + noise)
    assert len(np.unique(event.events["block"])) > 900
    for run in (event, verlet):
        assert abs(run.energy_residual) < 0.01
        assert replay.wrong_way(run) < 0.2


def test_results_have_a_column_for_each_of_a_thousand_blocks():
    settings = {"duration": 4, "initial_positions": [START]}
    scanned = scan([CHAIN], **settings)["slip_count"]
    slips = catalogue([CHAIN], **settings)["slips"]
    assert scanned.shape == (1, 1000)
    ended = np.bincount(slips["block"], minlength=1001)[1:]
    assert set(scanned[0] - ended) <= {0, 1}  # the last slip of a block may go on
    assert ended.sum() > 400
