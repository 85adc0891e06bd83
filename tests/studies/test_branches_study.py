"""Branches and basins: what is recorded of small chains, and tables of made-up data."""

import numpy as np
import pytest

import figure_data
from beltrepro import ChainParameters, Setup, orbit_branch, periodic_orbit
from beltrepro.replication.plan.attractors import basin_starts, sweeps
from beltrepro.replication.studies.branches import measure
from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN, YES
from made_up import data, few_resamples, grades, measured  # noqa: F401

ELSEWHERE = {"duration": 4000.0, "transient": 2000.0}


@pytest.fixture(scope="module")
def recorded():
    """Two blocks at two belt velocities, three starts each."""
    chains = [ChainParameters(2, u) for u in (19.0, 20.0) for _ in range(3)]
    setup = Setup(chains, replicate=2 * [1, 2, 3], initial_spread=5.0)
    return basin_starts(setup, duration=4000.0, energies=[1.0, 600.0])


def test_starts_of_each_kind_are_recorded(recorded):
    assert recorded["attractor"].shape == recorded["disorder_parameter"].shape == (6, 3)
    assert recorded["start_energy"].tolist() == [0.0, 1.0, 600.0]
    # H below u^2 / 2: no block reaches the belt
    assert np.all(recorded["state"][:, 1] == "equilibrium slip")
    assert np.all(recorded["state"][:, 0] == "periodic")
    # by the first point of each u; each label that a start reaches is there
    assert set(recorded["attractors"]["point"]) == {0, 3}
    for point in (0, 3):
        there = recorded["attractors"]["attractor"][recorded["attractors"]["point"] == point]
        assert set(recorded["attractor"][point : point + 3].ravel()) <= set(there)


def test_branches_are_recorded_with_their_ends(recorded):
    orbits = recorded["branches"]
    orbit = periodic_orbit(ChainParameters(2, 19.0), **ELSEWHERE)
    branch = orbit_branch(orbit, lower=19.0, upper=20.0)
    alike = orbits[(orbits["point"] == 0) & (orbits["period_events"] == orbit.period_events)]
    first = alike[alike["attractor"] == alike["attractor"][0]]
    assert first["belt_velocity"][-1] == branch.upper
    assert [*first["end"][[0, -1]]] == [branch.lower_end.kind, branch.upper_end.kind]
    assert not np.any(first["end"][1:-1])
    r = branch.disorder_parameter[[0, -1]]
    assert first["disorder_parameter"][[0, -1]] == pytest.approx(r, rel=1e-6)


def test_a_sweep_goes_on_from_the_point_before():
    # of two blocks one orbit is left at the ends; between them the way decides
    chains = [ChainParameters(2, u) for u in (23.0, 19.75, 18.8, 20.0, 19.0, 20.5, 19.5)]
    swept = sweeps(Setup(chains), duration=400.0, transient=200.0)["disorder_parameter"]
    assert swept.shape == (7, 2)
    order = np.argsort([chain.belt_velocity for chain in chains])
    up, down = swept[order].T
    assert up[[0, -1]] == pytest.approx(down[[0, -1]], rel=0.03)
    assert np.all(np.abs(up[3:5] / down[3:5] - 1) > 0.05)  # hysteresis, of two orbits


def test_shares_of_made_up_starts():
    data = figure_data.branching()
    table = measure.basin_shares(data)
    assert len(table) == 3 * 6 * 3 and np.all(table["runs"] == 4)
    # at u = 20 of five blocks starts at rest end at small r from run 1 on, those of H = 600 never
    at = table[(table["n_blocks"] == 5) & (table["belt_velocity"] == 20)]
    assert at[at["start_energy"] == 0]["share"].item() == 0.75
    assert at[at["start_energy"] == 600]["share"].item() == 0.0
    assert np.all(at["low"] <= at["share"]) and np.all(at["share"] <= at["high"])


# --- what explains the fall of r ------------------------------------------------------------------

VELOCITIES = np.arange(14.0, 22)


def starts(begin=17.1, first=18.0, below=0.0, runs=20):
    """Most runs from a velocity on are on an orbit that begins somewhere, and some are below."""
    u = np.repeat(VELOCITIES, runs)
    run = np.tile(np.arange(runs), VELOCITIES.size)
    small = (np.where(u >= first, 0.9, below) * runs > run)[:, np.newaxis]
    orbits = np.zeros(4, [("attractor", int), ("belt_velocity", float)])
    orbits["attractor"], orbits["belt_velocity"] = (3, 3, 4, 4), (30, begin, 15, 30)
    arrays = {
        "belt_velocity": u,
        "attractor": np.where(small, np.where(run == 0, 4, 3)[:, np.newaxis], 1),
        "disorder_parameter": np.where(small, 0.02, 0.12),
        "state": np.full(small.shape, "periodic"),
        "branches": orbits,
    }
    return data(arrays)


def upwards(fall, runs=8):
    """Sweeps with two noises, without which they fall at u, some of them one later."""
    u, noise, run = map(np.ravel, np.meshgrid(VELOCITIES, [0.0, 1.0], np.arange(runs)))
    small = np.where(noise == 0, u >= fall + (run % 3 == 0), u >= 15)
    r = np.stack([np.where(small, 0.02, 0.12), np.full(u.size, 0.02)], axis=1)  # down: small
    arrays = {"belt_velocity": u, "noise": noise, "replicate": run, "disorder_parameter": r}
    return data(arrays)


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, YES),  # the orbit of a single run begins at 15: irregular motion does not find it
        ({"first": 20.0, "begin": 19.2}, IN_PART),
        ({"first": 20.0, "begin": 18.1, "below": 0.3}, NO),
        ({"below": 0.05}, YES),  # one of sixty
        ({"below": 0.4}, IN_PART),
    ],
)
def test_the_begin_of_the_orbits_that_are_found(changes, verdict):
    assert grades("orbits-of-small-r", basins=starts(**changes))[""] == verdict
    numbers = measured("orbits-of-small-r", basins=starts(**changes)).numbers
    value = changes.get("begin", 17.1)
    assert numbers["first begin"].numbers == pytest.approx((value, value - 1e-3, value + 1e-3))


@pytest.mark.parametrize(
    ("falls", "verdict"),
    [
        ((20, 19, 18), YES),
        ((18, 18, 18), OPEN),
        ((18, 19, 20), IN_PART),  # the wrong way
        ((15, 15, 16), NO),
    ],
)
def test_when_sweeps_fall(falls, verdict):
    names = ("sweeps_fast", "sweeps", "sweeps_slow")
    swept = {name: upwards(fall) for name, fall in zip(names, falls, strict=True)}
    assert grades("fall-by-hold", basins=starts(), **swept)[""] == verdict
    numbers = measured("fall-by-hold", basins=starts(), **swept).numbers
    assert [numbers[name].value for name in ("shortest", "longest")] == [falls[0], falls[-1]]
