"""More chains than one group holds, of mixed kinds, in one call: each as if it were alone."""

from dataclasses import fields, replace

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, Setup, catalogue
from beltrepro import time_to_continuous_slip as escapes
from beltrepro.simulation.groups import in_groups

MORE_THAN_A_GROUP = 35
SPREAD = 0.5


@pytest.mark.parametrize("function", [catalogue, escapes])
def test_tables_of_more_chains_than_a_group_keep_them_apart(function):
    """Two sizes; each member is that of a call for it alone, and what it lacks is nan."""
    count, several = MORE_THAN_A_GROUP, function is catalogue
    members = {"replicate": range(2 * count), "initial_spread": SPREAD, "method": "verlet"}
    members |= {"section_block": 1, "section_position": 90.0} if several else {"settle_time": 30.0}
    chains = [ChainParameters(2 + k % 2, 15.0, noise=3.0) for k in range(2 * count)]
    together = function(chains, duration=60.0, **members)
    for member in (0, 1, 31, 62, 63, 64, 65, 69):
        alone = function([chains[member]], duration=60.0, **members | {"replicate": [member]})
        for name, values in together.items():
            rows = values[values["point"] == member] if several else values[[member]]
            assert len(rows) == len(alone[name]) > 0
            for field in rows.dtype.names or [None]:
                column, single = (v if field is None else v[field] for v in (rows, alone[name]))
                size = single.shape[-1] if single.ndim > 1 else None
                if field != "point":
                    np.testing.assert_array_equal(column[..., :size], single, err_msg=name)
                    assert size is None or np.all(np.isnan(column[..., size:]))
    assert not several or all(np.all(np.diff(v["point"]) >= 0) for v in together.values())


LAW = [field.name for field in fields(ChainParameters)[3:]]


def points_of(changes):
    """Two points that differ in what `changes` says: a field of the chain, or what it is told."""
    usual = {"method": "event", "time_step": 0.001, "tolerance": None, "seed": 1,
             "replicate": 1, "initial_spread": 0.1}  # fmt: skip
    options: dict = {name: [value] * 2 for name, value in usual.items()}
    chain, other = [ChainParameters(2, 20.0, noise=0.01)] * 2
    for name, value in changes.items():
        if name == "initial_positions":
            options[name] = [chain.rest_positions, value]
        elif name in usual:
            options[name] = [usual[name], value]
        elif name == "time":
            options |= {"initial_spread": [0.0] * 2}
            options["initial_state"] = [ChainState.at_rest(chain, time=t) for t in (0.0, value)]
        else:
            other = replace(chain, **{name: value})
    return Setup([chain, other], **options).cases


@pytest.mark.parametrize(
    ("changes", "together"),
    [
        ({"method": "verlet"}, False),
        ({"time_step": 0.002}, False),
        ({"tolerance": 1e-8}, False),
        ({"time": 0.5}, False),
        ({"noise": 0.0}, False),
        ({"n_blocks": 3}, False),
        # friction that weakens cannot be noisy, as these chains are
        *(({name: 0.3}, False) for name in LAW if name != "weakening_velocity"),
        ({"noise": 2.0}, True),
        ({"belt_velocity": 21.0}, True),
        ({"seed": 2}, True),
        ({"replicate": 2}, True),
        ({"initial_spread": 0.2}, True),
        ({"initial_positions": [51.0, 103.0]}, True),
    ],
)
def test_chains_advance_together_that_share_all_an_integrator_takes_from_the_first(
    changes, together
):
    made_points = points_of(changes)
    parts = [group.tolist() for group, _ in in_groups(made_points, lambda group: None, None)]
    assert parts == ([[0, 1]] if together else [[0], [1]])
    # and each of these makes another run of it
    assert made_points[0].identity != made_points[1].identity
