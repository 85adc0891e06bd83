"""States and runs as values: a run that is cut goes on as if it had not been."""

import copy
import dataclasses
from itertools import product

import numpy as np
import pytest

from beltrepro import (
    ChainParameters,
    ChainState,
    Run,
    Setup,
    catalogue,
    scan,
    simulate,
    slipping_state,
    time_to_continuous_slip,
)
from beltrepro.base import store
from beltrepro.base.errors import InputError
from beltrepro.engine.state import settled
from beltrepro.model.spring import potential_energy
from beltrepro.simulation.groups import integrator_of

METHODS = ("verlet", "event")
BELT_VELOCITIES = {1: 1.0, 5: 7.5, 10: 30.0}
CASES = [
    (method, ChainParameters(n_blocks, BELT_VELOCITIES[n_blocks], noise))
    for method, noise, n_blocks in product(METHODS, (0.0, 1.0), (1, 5, 10))
]
SLIDING = ChainParameters(1, 5.0, static_friction=10.0)  # slips for ever once its spring is linear


def names(case):
    method, chain = case
    return f"{method}-{chain.n_blocks}-{chain.noise:g}"


def joined(parts, name):
    return np.concatenate([getattr(part, name) for part in parts])


def assert_joined(parts, whole):
    """That pieces of a run have the bits of the whole, and its end."""
    for name in ("time", "positions", "velocities", "friction", "events"):
        np.testing.assert_array_equal(joined(parts, name), getattr(whole, name), err_msg=name)
    assert parts[-1].energy_residual == whole.energy_residual
    assert parts[-1].final_state == whole.final_state


# --- a run that is cut ---


@pytest.mark.parametrize(("method", "chain"), CASES, ids=map(names, CASES))
def test_cut_and_continued_equals_uncut(method, chain):
    # cut in other company than that in which it goes on
    others = [ChainParameters(chain.n_blocks, u, chain.noise) for u in (2.0, 20.0)]
    whole = simulate(chain, duration=600, method=method, seed=3)
    first = simulate([*others, chain], duration=250, method=method, seed=3)[-1]
    second = simulate(chain, duration=250, method=method, initial_state=first.final_state)
    third = simulate(chain, duration=100, method=method, initial_state=second.final_state)
    assert len(whole.events) > 10 and third.final_state.time == 600
    assert (second.seed, second.replicate) == (3, 0)
    assert_joined([first, second, third], whole)


@pytest.mark.parametrize("method", METHODS)
def test_the_grid_of_cuts_does_not_depend_on_the_sampling(method):
    # more samples than a chunk holds, and an interval of which 250 is no multiple
    chain = ChainParameters(2, 6.0)
    for interval in (0.02, 0.3):
        options = {"method": method, "sample_interval": interval}
        whole = simulate(chain, duration=500, **options)
        first = simulate(chain, duration=250, **options)
        second = simulate(chain, duration=250, initial_state=first.final_state, **options)
        assert_joined([first, second], whole)


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize(("method", "cut"), [("event", 33.3333), ("verlet", 33.333)])
def test_cut_elsewhere_equals_uncut_to_rounding(method, noise, cut):
    chain = ChainParameters(5, 7.5, noise)
    whole = simulate(chain, duration=cut + 10.0, method=method)
    first = simulate(chain, duration=cut, method=method)
    second = simulate(chain, duration=10.0, method=method, initial_state=first.final_state)
    for name in ("time", "positions", "velocities"):
        np.testing.assert_allclose(
            joined([first, second], name), getattr(whole, name), rtol=0, atol=1e-8, err_msg=name
        )
    kinds = joined([first, second], "events")
    assert kinds[["block", "kind"]].tolist() == whole.events[["block", "kind"]].tolist()
    # with noise a step of the event method ends at the cut, where its truncation shows
    tolerance = 1e-6 if (method, noise) == ("event", 1.0) else 1e-9
    np.testing.assert_allclose(kinds["time"], whole.events["time"], rtol=0, atol=tolerance)


@pytest.mark.parametrize("method", METHODS)
def test_a_transient_counts_from_the_state(method):
    chain = ChainParameters(3, 12.0)
    state = simulate(chain, duration=250, method=method, sample_interval=None).final_state
    options = {"duration": 250, "method": method, "initial_state": state}
    run = simulate(chain, transient=100, sample_start=60, **options)
    assert run.time[0] == pytest.approx(310) and run.time[-1] == pytest.approx(500)
    length = run.positions[run.time > 349.95, -1]
    assert len(length) == 1501
    assert run.mean_length == pytest.approx(length.mean(), rel=1e-12)
    table = scan(chain, transient=100, section_position=300.0, **options)
    assert table["mean_length"][0] == run.mean_length
    late = run.events[run.events["time"] >= 350]
    slips = late["block"][late["kind"] == "slip"]
    counts = np.bincount(slips, minlength=4)[1:]
    np.testing.assert_array_equal(table["slip_count"][0, :3], counts)
    assert counts.min() > 3
    x = run.positions[:, -1]
    down = (x[:-1] >= 300) & (x[1:] < 300) & (run.time[1:] > 350)
    assert table["section_count"][0] == down.sum() > 3
    every, some = (catalogue(chain, transient=first, **options) for first in (0, 100))
    for name, key in (("slips", "start_time"), ("avalanches", "start_time"), ("section", "time")):
        expected = every[name][every[name][key] >= 350]
        np.testing.assert_array_equal(some[name], expected)
        assert 0 < len(expected) < len(every[name])
    table = time_to_continuous_slip(chain, settle_time=150, **options)
    assert table["final_mean_length"][0] == run.mean_length


def test_laminar_phases_and_lifetimes_count_from_the_state():
    # the block slips from the state on, and never sticks
    state = ChainState.in_motion(SLIDING, [57.0], [0.0], time=40.0)
    table = scan(SLIDING, duration=300, initial_state=state, laminar_time=100)
    assert table["laminar_count"][0] == 1 and table["laminar_longest"][0] == 300
    table = time_to_continuous_slip(SLIDING, duration=300, initial_state=state, laminar_time=100)
    assert table["escaped"][0] and table["lifetime"][0] == 0
    stuck = time_to_continuous_slip(
        ChainParameters(1, 0.01), duration=300, laminar_time=100, settle_time=50
    )
    assert not stuck["escaped"][0] and stuck["lifetime"][0] == 300


@pytest.mark.parametrize("method", METHODS)
def test_a_catalogue_goes_on_from_moving_blocks_with_what_begins_later(method):
    chains = [ChainParameters(3, 12.0, 1.0)] * 16
    how = {"method": method, "section_block": 2, "duration": 250.0}
    begun = simulate(chains, duration=250.0, method=method, replicate=range(16))
    states = [run.final_state for run in begun]
    assert 0 < sum(np.any(state.directions != 0) for state in states) < 16
    whole = catalogue(chains, transient=250.0, replicate=range(16), **how | {"duration": 500.0})
    for name, rows in catalogue(chains, initial_state=states, **how).items():
        assert len(rows) == len(whole[name]) > 50
        for field in rows.dtype.names:
            np.testing.assert_allclose(rows[field], whole[name][field], atol=1e-8, err_msg=field)


# --- states from anywhere ---


@pytest.mark.parametrize("method", METHODS)
def test_a_fresh_run_is_one_from_a_state_at_rest(method):
    chain = ChainParameters(3, 20.0, 1.0)
    start = [50.0, 101.0, 149.0]
    options = {"duration": 30, "method": method}
    fresh = simulate(chain, seed=4, replicate=2, initial_positions=start, **options)
    state = ChainState.at_rest(chain, start, seed=4, replicate=2)
    again = simulate(chain, initial_state=state, **options)
    assert fresh == again and fresh.initial_state == state
    assert (again.seed, again.replicate) == (4, 2)


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize("method", METHODS)
def test_states_of_any_origin_go_on_together_as_alone(method, noise):
    chains = [ChainParameters(3, u, noise) for u in (4.0, 7.0, 11.0, 20.0, 6.0)]
    made = {"duration": 50.0, "sample_interval": None}
    states = [
        ChainState.in_motion(chains[0], [45.0, 130.0, 170.0], [3.0, 4.0, 5.0], time=50.0),
        simulate(chains[1], method=method, **made).final_state,
        simulate(chains[2], method=METHODS[method == "verlet"], **made).final_state,
        simulate(chains[3], method=method, time_step=0.002, **made).final_state,
        ChainState.at_rest(chains[4], time=50.0, seed=3),
    ]
    together = simulate(chains, duration=20.0, method=method, initial_state=states)
    for chain, state, run in zip(chains, states, together, strict=True):
        alone = simulate(chain, duration=20.0, method=method, initial_state=state)
        # "verlet" draws the threshold of a slipping block anew in every step
        stuck = alone.final_state.directions == 0
        np.testing.assert_array_equal(
            run.final_state.thresholds[stuck], alone.final_state.thresholds[stuck]
        )
        final = dataclasses.replace(run.final_state, thresholds=alone.final_state.thresholds)
        assert dataclasses.replace(run, final_state=final) == alone


def test_a_state_with_the_variables_of_the_scheme_is_taken_as_it_is():
    """One without them is settled first: here its blocks move back over the belt, and stick."""
    (case,) = Setup(ChainParameters(3, 7.0), method="verlet").cases
    (whole,) = integrator_of([case]).state()
    turning = {"directions": np.ones(3), "relative_velocities": np.full(3, -0.1)}
    states = [
        dataclasses.replace(whole, scheme=scheme, **turning) for scheme in (None, whole.scheme)
    ]
    cases = [dataclasses.replace(case, state=states[number]) for number in (1, 0, 1)]
    for held, start in zip(integrator_of(cases).state(), (1, 0, 1), strict=True):
        np.testing.assert_array_equal(held.directions, start)
        np.testing.assert_allclose(held.relative_velocities, -0.1 * start, rtol=1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_a_state_stays_as_it_is_while_its_chain_goes_on(method):
    cases = Setup(ChainParameters(1, 7.0, 1.0), method=method).cases
    integrator = integrator_of(cases)
    before = integrator.state()
    kept = copy.deepcopy(before)
    for _ in integrator.advance(100.0):
        pass
    assert before == kept and integrator.state() != kept


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("block", [0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_block_at_rest_slips_at_once_where_its_own_threshold_is_passed(method, block, sign):
    """Of blocks at rest that are pulled those slip whose own thresholds are lower, and no other."""
    # kinetic friction below all forces: what slips goes on; with noise thresholds differ
    chain = ChainParameters(3, 1.0, noise=0.01, friction_ratio=0.1)
    start = chain.rest_positions
    start[block] -= sign * 19.0
    state = ChainState.at_rest(chain, start)
    force = np.abs(state.forces)
    assert np.sign(state.forces[block]) == sign
    pulled = np.arange(3) == block
    for passed in (pulled, ~pulled & (force > 0), np.zeros(3, bool)):
        thresholds = np.where(passed, 0.9 * force, 2 * force.max())
        held = dataclasses.replace(state, thresholds=thresholds)
        run = simulate(chain, duration=0.02, method=method, initial_state=held)
        assert set(run.events["block"]) == set(1 + np.flatnonzero(passed))
        assert set(run.events["kind"]) <= {"slip"} and np.all(run.events["time"] <= 0.001)
        assert run.final_state.directions[block] == (sign if passed[block] else 0.0)


@pytest.mark.parametrize("mass", [1.0, (0.5, 1.0, 2.0)])
def test_the_scheme_starts_from_a_state_to_second_order(mass):
    chain = ChainParameters(3, 20.0, mass=mass)
    state = simulate(chain, duration=1, initial_state=slipping_state(chain, 80.0)).final_state
    assert state.directions.all()
    exact = simulate(chain, duration=0.5, tolerance=1e-13, initial_state=state)
    assert len(exact.events) == 0
    errors = []
    for time_step in (0.004, 0.002, 0.001):
        steps = {"method": "verlet", "time_step": time_step}
        run = simulate(chain, duration=0.5, initial_state=state, **steps)
        assert len(run.events) == 0
        errors.append(np.abs(run.final_state.positions - exact.final_state.positions).max())
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(order, 2, atol=0.1)


KEPT = ("displacements", "relative_velocities", "directions", "thresholds", "friction_losses",
        "wall_impulse", "initial_energy", "initial_momentum", "stream", "time")  # fmt: skip


@pytest.mark.parametrize(
    ("method", "time_step", "noise"),
    [
        ("verlet", 0.001, 0.0),  # in leaps
        ("verlet", 0.004, 0.0),  # step by step
        ("verlet", 0.002, 1.0),
        ("event", 0.001, 0.0),
        ("event", 0.002, 1.0),
    ],
)
def test_an_integrator_that_takes_over_holds_the_state_that_it_was_given(method, time_step, noise):
    """Nothing of a state of another scheme is lost or changes its unit before the first step."""
    chain = ChainParameters(5, 7.5, noise)
    before = METHODS[method == "verlet"]
    state = simulate(chain, duration=50.0, method=before).final_state
    directions, relative = settled(
        state.directions, state.relative_velocities, state.forces, state.thresholds
    )
    state = dataclasses.replace(
        state, directions=directions, relative_velocities=relative, scheme=None
    )
    assert 0 < np.count_nonzero(state.directions) < 5
    assert state.friction_losses.max() > 100 and abs(state.wall_impulse) > 100
    cases = Setup(chain, method=method, time_step=time_step, initial_state=state).cases
    integrator = integrator_of(cases, sampled_blocks=5)
    (held,) = integrator.state()
    for name in KEPT:
        np.testing.assert_allclose(
            getattr(held, name), getattr(state, name), rtol=1e-12, err_msg=name
        )
    # the same balance of energy as by hand
    work = 7.5 * (state.velocities.sum() - state.initial_momentum + state.wall_impulse)
    energy = potential_energy(state.positions, chain) + (state.velocities**2).sum() / 2
    missing = work - state.friction_losses.sum() - (energy - state.initial_energy)
    assert integrator.energy_residual()[0] == pytest.approx(missing / work, abs=1e-12)


CHANGES = [("belt_velocity", 9.0), ("belt_velocity", 2.0), ("noise", 2.0), ("noise", 0.0),
           ("static_friction", 80.0), ("friction_ratio", 0.3), ("rest_length", 47.0),
           ("linear_limit", 15.0), ("compression_rate", 0.1), ("extension_rate", 0.02),
           ("mass", (0.5, 1.0, 1.0, 2.0, 1.5)), ("stiffness", 2.0), ("viscosity", 0.1),
           ("weakening_velocity", 500.0)]  # fmt: skip


assert {name for name, _ in CHANGES} == set(ChainParameters.__annotations__) - {"n_blocks"}


@pytest.mark.parametrize(("field", "value"), CHANGES)
def test_a_state_under_another_constant_is_the_same_motion(field, value):
    # friction that weakens cannot be noisy
    old = ChainParameters(5, 7.5, 1.0 * (field != "weakening_velocity"))
    new = dataclasses.replace(old, **{field: value})
    state = simulate(old, duration=65.0 if old.noise else 68.0, seed=3, replicate=2).final_state
    stuck = state.directions == 0
    assert 0 < stuck.sum() < 5
    there = state.under(new)
    assert there.parameters == new and there.scheme is None
    np.testing.assert_allclose(there.positions, state.positions, rtol=1e-14)
    np.testing.assert_allclose(there.velocities[~stuck], state.velocities[~stuck], rtol=1e-12)
    np.testing.assert_array_equal(there.velocities[stuck], new.belt_velocity)
    np.testing.assert_array_equal(there.relative_velocities[stuck], 0.0)
    later = simulate(new, duration=20.0, initial_state=state)
    assert later.initial_state == there and abs(later.energy_residual) < 1e-8
    # a slower belt may be overtaken by a block that lagged behind
    np.testing.assert_array_equal(there.directions, np.sign(there.relative_velocities))
    overtakes = (there.directions > 0) & (state.directions < 0)
    assert overtakes.any() == (value == 2.0 and field == "belt_velocity")
    deviates = (state.thresholds - old.static_friction) / (old.noise or 1.0)
    np.testing.assert_allclose(there.thresholds, new.static_friction + new.noise * deviates)
    assert (there.time, there.seed, there.replicate) == (state.time, 3, 2)
    np.testing.assert_array_equal(there.stream, state.stream)
    assert there.wall_impulse == 0 and not there.friction_losses.any()
    mass = np.asarray(new.mass)
    energy = potential_energy(there.positions, new) + (mass * there.velocities**2).sum() / 2
    assert there.initial_energy == pytest.approx(energy, rel=1e-12)
    assert there.initial_momentum == pytest.approx((mass * there.velocities).sum(), rel=1e-12)


def test_a_state_goes_on_with_its_own_random_numbers_or_with_others():
    chain = ChainParameters(2, 20.0, 1.0)
    first = simulate(chain, duration=20, seed=5, sample_interval=None)
    later = {"duration": 20, "initial_state": first.final_state}
    runs = simulate(chain, seed=[5, 5, 5, 6], replicate=[0, 1, 2, 0], **later)
    unkeyed = simulate(chain, **later)
    assert runs[0].final_state == unkeyed.final_state
    ends = np.array([run.final_state.positions for run in runs])
    assert len(np.unique(ends, axis=0)) == 4
    assert [run.seed for run in runs] == [5, 5, 5, 6]
    for run in runs[1:]:  # from its beginning, as if the chain had had that key all the time
        new = ChainState.at_rest(chain, seed=run.seed, replicate=run.replicate)
        np.testing.assert_array_equal(run.initial_state.stream, new.stream)


# --- runs ---


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("interval", [0.5, None])
def test_a_run_is_equal_to_what_it_saved(tmp_path, method, interval):
    lengths = {"duration": 40, "transient": 10, "sample_interval": interval, "sample_start": 5}
    chain = ChainParameters(3, 20.0, 1.0, friction_ratio=0.5)
    run = simulate(chain, method=method, **lengths, seed=7, replicate=3, initial_spread=0.1)
    run.save(tmp_path / "run.h5")
    loaded = Run.load(tmp_path / "run.h5")
    assert loaded == run
    assert (loaded.duration, loaded.transient, loaded.time_step) == (40, 10, 0.001)
    assert (loaded.seed, loaded.replicate, loaded.sample_interval) == (7, 3, interval)
    assert simulate(chain, method=method, initial_state=loaded.initial_state, **lengths) == run
    assert len(repr(run)) < 150 and len(repr(run.final_state)) < 100 and "\n" not in repr(run)


def test_a_file_keeps_each_constant_of_a_chain_and_how_it_was_told(tmp_path):
    chain = ChainParameters(5, **dict(CHANGES) | {"belt_velocity": 9.0})
    begin = simulate(chain, duration=13.0, replicate=2, initial_spread=1.0).final_state
    told = {"duration": 9.0, "transient": 2.0, "sample_start": 4.0, "tolerance": 1e-8}
    run = simulate(chain, initial_state=begin, **told)
    run.save(tmp_path / "run.h5")
    loaded = Run.load(tmp_path / "run.h5")
    assert loaded == run and loaded.final_state.scheme.variables
    assert {name: loaded[name] for name in told} == told


def test_a_file_keeps_the_scheme_of_a_state_that_came_from_another(tmp_path):
    chain = ChainParameters(3, 20.0)
    lengths = {"duration": 5, "transient": 0, "method": "verlet", "sample_interval": 0.5}
    coarse = simulate(chain, time_step=0.002, **lengths).final_state
    run = simulate(chain, initial_state=coarse, **lengths)
    run.save(tmp_path / "run.h5")
    assert Run.load(tmp_path / "run.h5").initial_state.scheme.time_step == 0.002


def test_a_file_that_holds_no_run_is_refused_in_one_line(tmp_path):
    (tmp_path / "text.h5").write_text("no")
    store.write(tmp_path / "scan.h5", {"x": np.zeros(3)}, {"kind": "scan"})
    store.write(tmp_path / "part.h5", {"x": np.zeros(3)}, {"kind": "run"})
    refusals = {"missing": "no such file", "text": "has no seal"}
    refusals |= {"scan": "not a run, but of kind 'scan'", "part": "a run without 'n_blocks'"}
    for name, words in refusals.items():
        with pytest.raises(InputError) as caught:
            Run.load(tmp_path / f"{name}.h5")
        assert words in str(caught.value) and "\n" not in str(caught.value)
