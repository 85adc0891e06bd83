"""More chains than one group holds, of mixed kinds, in one call: each as if it were alone."""

from dataclasses import fields, replace

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, Setup, catalogue, scan, simulate
from beltrepro import time_to_continuous_slip as escapes
from beltrepro.engine.noise import stream_key
from beltrepro.simulation.groups import groups

MORE_THAN_A_GROUP = 35
SPREAD = 0.5
CHAIN = ChainParameters(2, 15.0, noise=3.0)
MEMBERS = {"chains": [CHAIN] * MORE_THAN_A_GROUP, "replicate": range(MORE_THAN_A_GROUP),
           "initial_spread": SPREAD, "method": "verlet"}  # fmt: skip


def start(chain, replicate, seed=1):
    """Declared initial positions: undeformed for replicate 0, normal about them for others."""
    normals = np.random.default_rng(stream_key(chain, seed, replicate, 1)).standard_normal(2)
    return chain.rest_positions + (SPREAD * normals if replicate else 0.0)


def alone(replicate, **lengths):
    """One chain followed by itself from its declared state."""
    begin = {"replicate": replicate, "initial_positions": start(CHAIN, replicate)}
    return simulate(CHAIN, method="verlet", **begin, **lengths)


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


def test_runs_of_mixed_kinds_come_back_in_their_order():
    chains = [ChainParameters(1 + k % 2, 3.0 + k, noise=k % 3) for k in range(MORE_THAN_A_GROUP)]
    options = {"duration": 20, "sample_interval": 1.0, "method": "verlet"}
    for chain, run in list(zip(chains, simulate(chains, **options), strict=True))[::8]:
        assert run.parameters == chain
        np.testing.assert_array_equal(run.positions, simulate(chain, **options).positions)


def test_a_catalogue_of_more_chains_than_a_group_keeps_them_apart():
    lengths = {"duration": 80.0, "transient": 20.0}
    found = catalogue(**MEMBERS, section_block=1, section_position=90.0, **lengths)
    slips, avalanches, section = (found[name] for name in ("slips", "avalanches", "section"))
    for records in (slips, avalanches, section):
        assert np.array_equal(np.unique(records["point"]), np.arange(MORE_THAN_A_GROUP))
        assert np.all(np.diff(records["point"]) >= 0)
    for chain in (0, 1, 31, 32, 34):
        run = alone(chain, sample_interval=0.001, **lengths)
        starts = run.events[(run.events["kind"] == "slip") & (run.events["time"] >= 20.0)]
        own = slips[slips["point"] == chain]
        assert set(own["start_time"]) <= set(starts["time"])
        assert len(starts) - len(own) <= 2  # those still going on at the end
        first, last = (avalanches[avalanches["point"] == chain][k] for k in (0, -1))
        assert first["start_time"] in starts["time"]
        assert last["stop_time"] in run.events["time"][run.events["kind"] == "stick"]
        x = run.positions[:, 0]
        down = (x[:-1] >= 90.0) & (x[1:] < 90.0) & (run.time[1:] >= 20.0)
        crossed = section[section["point"] == chain]
        np.testing.assert_allclose(crossed["time"], run.time[1:][down], atol=0.001)
        np.testing.assert_allclose(crossed["positions"][:, 0], 90.0)
        np.testing.assert_allclose(crossed["velocities"], run.velocities[1:][down], atol=0.3)


def test_escapes_of_more_members_than_a_group_keep_them_apart():
    found = escapes(**MEMBERS, duration=60.0, settle_time=30.0, laminar_time=2.0)
    assert found["replicate"].tolist() == list(range(MORE_THAN_A_GROUP))
    np.testing.assert_array_equal(found["belt_velocity"], CHAIN.belt_velocity)
    assert 0 < found["escaped"].sum() < MORE_THAN_A_GROUP
    for member in (0, 1, 31, 32, 33, 34):
        run = alone(member, duration=60.0, transient=30.0, sample_interval=0.1)
        late = run.positions[run.time >= 30.0, -1]
        assert found["final_mean_length"][member] == run.mean_length
        assert found["final_disorder"][member] == run.disorder_parameter
        np.testing.assert_allclose(found["final_amplitude"][member], np.ptp(late))
        sticks = run.events[run.events["kind"] == "stick"]
        for block in (1, 2):
            count = np.sum((sticks["block"] == block) & (sticks["time"] >= 30.0))
            assert found["final_stick_rate"][member, block - 1] == count / 30.0
        own = run.events[run.events["block"] == 2]
        slipping = own["kind"][-1] == "slip" and 60.0 - own["time"][-1] > 2.0
        assert found["escaped"][member] == slipping
        last = sticks["time"][sticks["block"] == 2].max(initial=0.0)
        assert found["lifetime"][member] == (last if slipping else 60.0)


def points_of(changes):
    """Two points that differ in what `changes` says: a field of the chain, or what it is told."""
    usual = {"method": "event", "time_step": 0.001, "tolerance": None, "seed": 1, "replicate": 1,
             "initial_positions": None, "initial_spread": 0.1, "initial_state": None}  # fmt: skip
    told: dict = {name: [value] * 2 for name, value in usual.items()}
    told["initial_positions"] = None
    chain, other = [ChainParameters(2, 20.0, noise=0.01)] * 2
    for name, value in changes.items():
        if name == "initial_positions":
            told[name] = [chain.rest_positions, value]
        elif name in told:
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


def test_chains_of_several_tolerances_keep_their_own():
    chain = ChainParameters(5, 20.0)
    tolerances = [1e-3, None, 1e-13]
    options = {"method": "event", "sample_interval": None, "duration": 60.0}
    together = simulate([chain] * 3, tolerance=tolerances, **options)
    for tolerance, run in zip(tolerances, together, strict=True):
        assert run == simulate(chain, tolerance=tolerance, **options)
    assert len({run.final_state.positions.tobytes() for run in together}) == 3
