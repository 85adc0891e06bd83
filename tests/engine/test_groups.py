"""More chains than one group holds, of mixed kinds, in one call: each as if it were alone."""

from dataclasses import fields, replace

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, Setup, catalogue, scan, simulate
from beltrepro import time_to_continuous_slip as escapes
from beltrepro.simulation.groups import groups

MORE_THAN_A_GROUP = 35
SPREAD = 0.5


def test_points_of_mixed_laws_sizes_and_noise_are_those_of_single_calls():
    laws = [{}, {"friction_ratio": 0.6}, {"linear_limit": 5.0, "extension_rate": 0.03}]
    chains = [
        replace(ChainParameters(2 + k % 2, 3.0 + k, noise=0.5 * (k % 5 == 0)), **laws[k % 3])
        for k in range(2 * MORE_THAN_A_GROUP)
    ]
    # one law and size fills more than a group
    chains += [ChainParameters(2, 4.5 + k) for k in range(MORE_THAN_A_GROUP)]
    sections = [110.0 + k for k in range(len(chains))]
    replicates = [k % 3 for k in range(len(chains))]
    lengths = {"duration": 30.0, "transient": 10.0, "initial_spread": SPREAD, "method": "verlet"}
    whole = scan(chains, section_position=sections, replicate=replicates, **lengths)
    for name in ("n_blocks", "belt_velocity", "noise"):
        np.testing.assert_array_equal(whole[name], [getattr(chain, name) for chain in chains])
    np.testing.assert_array_equal(whole["replicate"], replicates)
    np.testing.assert_array_equal(whole["section_position"], sections)
    assert len(np.unique(whole["mean_length"])) == len(chains)
    for row in (0, 1, 2, 5, 40, 69, 70, 101, 102, 104):
        place = {"section_position": sections[row], "replicate": replicates[row]}
        one = scan(chains[row], **place, **lengths)
        for name, values in one.items():
            np.testing.assert_array_equal(whole[name][row], values[0], err_msg=f"{name} {row}")


@pytest.mark.parametrize("function", [catalogue, escapes])
def test_tables_of_more_chains_than_a_group_keep_them_apart(function):
    """Mixed noise; each member is that of a call for it alone."""
    count = MORE_THAN_A_GROUP
    members = {"replicate": range(count), "initial_spread": SPREAD, "method": "verlet"}
    members |= (
        {"duration": 80.0, "transient": 20.0} if function is catalogue else {"duration": 60.0}
    )
    members |= {"section_block": 1, "section_position": 90.0} if function is catalogue else {}
    chain = ChainParameters(2, 15.0, noise=3.0)
    together = function([chain] * count, **members)
    for member in (0, 1, 31, 32, 33, 34):
        alone = function([chain], **members | {"replicate": [member]})
        for name, values in together.items():
            if function is catalogue:
                rows = values[values["point"] == member]
                assert len(rows) == len(alone[name]) > 0 and np.all(np.diff(values["point"]) >= 0)
                fields_of = [field for field in rows.dtype.names if field != "point"]
                np.testing.assert_array_equal(rows[fields_of], alone[name][fields_of])
            else:
                np.testing.assert_array_equal(values[member], alone[name][0], err_msg=name)


def points_of(changes):
    """Two points that differ in what `changes` says: a field of the chain, or what it is told."""
    usual = {"method": "event", "time_step": 0.001, "tolerance": None, "kick": 0.1, "seed": 1,
             "replicate": 1, "initial_spread": 0.1}  # fmt: skip
    told: dict = {name: [value] * 2 for name, value in usual.items()} | {"kick": 0.0}
    chain, other = [ChainParameters(2, 20.0, noise=0.01)] * 2
    for name, value in changes.items():
        if name == "initial_positions":
            told[name] = [chain.rest_positions, value]
        elif name in usual:
            told[name] = [usual[name], value]
        elif name == "time":
            told |= {"initial_spread": [0.0] * 2}
            told["initial_state"] = [ChainState.at_rest(chain, time=t) for t in (0.0, value)]
        else:
            other = replace(chain, **{name: value})
    return Setup([chain, other], **told).cases


@pytest.mark.parametrize(
    ("changes", "together"),
    [
        ({"method": "verlet"}, False),
        ({"time_step": 0.002}, False),
        ({"tolerance": 1e-8}, False),
        ({"time": 0.5}, False),
        ({"noise": 0.0}, False),
        ({"n_blocks": 3}, False),
        *(({field.name: 0.3}, False) for field in fields(ChainParameters)[3:]),
        ({"kick": 0.0}, False),
        ({"kick": 0.2}, True),
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
    found = points_of(changes)
    parts = [group.tolist() for group, _ in groups(found, None)]
    assert parts == ([[0, 1]] if together else [[0], [1]])
    # and each of these makes another run of it
    assert found[0].identity != found[1].identity


@pytest.mark.parametrize("at_once", [1, 500, 2**15])  # one chain, two, all of them
@pytest.mark.parametrize("interval", [0.1, 0.25])  # with samples between them for r, or not
def test_samples_of_chains_together_are_those_of_each_alone(monkeypatch, interval, at_once):
    monkeypatch.setattr("beltrepro.simulation.sampling._AT_ONCE", at_once)
    chains = [ChainParameters(3, u, noise) for noise in (0.0, 0.5) for u in (9.0, 20.0, 14.0)]
    settings = {"duration": 12.0, "sample_interval": interval, "initial_spread": 1.0}
    replicates = [4, 0, 2, 1, 0, 3]
    together = simulate(chains, replicate=replicates, **settings)
    for chain, replicate, run in zip(chains, replicates, together, strict=True):
        assert run == simulate(chain, replicate=replicate, **settings)
        assert run.velocities.max() > 0.99 * chain.belt_velocity
        rides = run.velocities == chain.belt_velocity
        assert rides.any() and not rides.all()
