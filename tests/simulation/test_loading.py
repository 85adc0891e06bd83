"""Runs that are measured while the chain still loads say so, and others do not."""

import re
import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, Grid, catalogue, scan, simulate, sweep
from beltrepro.model.spring import balance_length
from beltrepro.simulation.loading import beginning

SLOW = ChainParameters(10, 1.0)
NO_SAMPLES = {"sample_interval": None}


def lines(called, *chains, **settings) -> list[str]:
    """The warnings of a call, one line each."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        called(*chains, **settings)
    assert all("\n" not in str(warning.message) for warning in caught)
    assert all(warning.filename == __file__ for warning in caught)
    return [str(warning.message) for warning in caught]


@pytest.mark.parametrize(
    ("called", "settings"), [(simulate, NO_SAMPLES), (scan, {}), (catalogue, {})]
)
def test_a_run_over_the_loading_names_a_transient_that_would_do(called, settings):
    """Ten blocks at u = 1 take 1069 to their length at balance; r is 0.232 with them."""
    (line,) = lines(called, SLOW, duration=5000.0, **settings)
    assert "N=10, u=1, sigma=0: r = 0.1" in line or "r = 0.2" in line
    transient = float(re.search(r"transient=(\S+)", line)[1])
    assert 1000 <= transient <= 1500
    assert not lines(called, SLOW, duration=5000.0, transient=transient, **settings)


@pytest.mark.parametrize(("mass", "unit"), [(1.0, 1.0), (1e-4, 0.01), (1e4, 100.0)])
def test_light_and_heavy_blocks_are_told_as_those_of_the_paper_are(mass, unit):
    chain = ChainParameters(5, 10.0 / unit, mass=mass)
    (line,) = lines(scan, chain, duration=1000 * unit)
    assert 40 <= float(re.search(r"transient=(\S+);? ", line)[1]) / unit <= 60


def test_a_run_that_ends_while_it_loads_is_told_how_long_that_takes():
    """Fifty blocks at u = 1 take 11,000."""
    line = lines(catalogue, ChainParameters(50, 1.0), duration=4000.0)[0]
    transient, duration = map(float, re.search(r"=(\d+) and duration=(\S+) leave", line).groups())
    assert 11_000 <= transient <= 15_000 and duration == 10 * transient


def test_a_run_of_less_than_the_slow_unit_of_its_chain_is_told_too():
    (line,) = lines(scan, ChainParameters(3, 1.0, mass=1e4), duration=90.0)  # 164 to the balance
    assert "r = 0.133); transient=210 and" in line


def test_a_viscous_chain_that_creeps_on_for_all_of_a_run_is_not_promised_an_early_end():
    """The belt takes 163 to the balance, the creep up to it eta / k of the slowest mode, 252."""
    (line,) = lines(scan, ChainParameters(3, 3.0, viscosity=50.0), duration=1500.0, transient=100.0)
    assert "transient=1900 and duration=19000 leave it out" in line


@pytest.mark.parametrize(
    ("chain", "duration"),
    [
        (ChainParameters(2, 0.1, viscosity=2.0), 3600.0),
        (ChainParameters(3, 2.0, viscosity=1.0), 300.0),
    ],
)
def test_a_viscous_chain_is_told_to_wait_until_it_has_slid_back(chain, duration):
    """It stretches to static friction first: 1.4 times as long as to the balance."""
    (line,) = lines(scan, chain, duration=duration)
    transient = float(re.search(r"transient=(\S+)", line)[1])
    lengths = {"duration": 2 * transient, "transient": transient}
    assert not lines(scan, chain, **lengths)
    assert scan(chain, **lengths)["disorder_parameter"] < 1e-6


@pytest.mark.parametrize(
    ("chain", "duration", "transient"),
    [
        (ChainParameters(1, 20.0, viscosity=0.3), 27.0, 7.0),  # swings: r = 0.05
        (ChainParameters(1, 20.0, viscosity=1.0), 25.0, 4.0),  # and sooner stops: r = 0.04
        (ChainParameters(5, 20.0, viscosity=10.0), 160.0, 54.0),  # creeps: r = 0.02
    ],
)
def test_a_transient_that_ends_before_an_overshoot_does_is_told_of(chain, duration, transient):
    """The belt has brought the last block to its balance by then, about which it still moves."""
    assert lines(scan, chain, duration=transient + 0.01, transient=transient)  # one sample
    (line,) = lines(scan, chain, duration=duration, transient=transient)
    longer = float(re.search(r"loading is measured too .* transient=(\S+)", line)[1])
    lengths = {"duration": longer + duration, "transient": longer}
    assert longer > transient and not lines(scan, chain, **lengths)
    assert scan(chain, **lengths)["disorder_parameter"] < 4e-3


def test_very_slow_chains_get_advice_that_helps_or_hear_that_none_does():
    chain = ChainParameters(1, 1e-3)
    for transient, advice in ((0.0, r"transient=40000 and"), (4e4, r"a longer duration has more")):
        (line,) = lines(
            simulate, chain, duration=transient + 2e4, transient=transient, **NO_SAMPLES
        )
        assert re.search(advice, line)
    assert not lines(simulate, chain, duration=2e5, transient=4e4, **NO_SAMPLES)
    (line,) = lines(scan, ChainParameters(1, 1e-300), duration=300.0)
    assert line.endswith("; it lasts longer than a run may (1e+12)")


def test_a_late_window_of_less_than_a_slow_motion_is_told_of():
    """r = 0.23, 0.18 and 0.12 over many cycles; all three windows lie in a rise of the springs."""
    grid, longer = Grid([1, 2, 5], 0.05), r"3 of 3 chains: less than a slow motion is measured"
    (line,) = lines(scan, grid, duration=40_300.0, transient=40_000.0)
    assert re.match(longer, line)
    assert not lines(scan, grid, duration=45_000.0, transient=40_000.0)


@pytest.mark.parametrize("chain", [ChainParameters(1, 0.01), ChainParameters(5, 0.1)])
def test_a_late_run_of_less_than_two_sticks_is_told_though_a_slip_is_in_it(chain):
    """Of a single block the belt carries each 63 of at most 79 far: r = 0.227, not 0.274."""
    transient = 460.0 / chain.belt_velocity
    two_sticks = 2 * 2 * 0.55 * 71.4 / chain.belt_velocity
    for share, told in ((0.7, 1), (1.1, 0)):
        duration = transient + share * two_sticks
        caught = lines(scan, chain, duration=duration, transient=transient)
        assert [line[:35] for line in caught] == ["less than a slow motion is measured"] * told


def test_several_chains_get_one_line_with_the_one_that_takes_longest():
    (line,) = lines(scan, Grid([2, 5, 10], [1.0, 30.0]), duration=3000.0)
    assert re.match(r"\d of 6 chains: loading is measured too \(N=10, u=1", line)


def test_a_later_state_of_undeformed_springs_has_loaded_nothing():
    state = ChainState.at_rest(SLOW, time=5000.0)
    assert lines(simulate, SLOW, duration=2000.0, initial_state=state, **NO_SAMPLES)


def test_going_on_from_a_loaded_state_needs_no_transient():
    with pytest.warns(match="less than a slow motion"):
        loaded = simulate(SLOW, duration=1400.0, transient=1300.0, **NO_SAMPLES).final_state
    assert not lines(simulate, SLOW, duration=2000.0, initial_state=loaded, **NO_SAMPLES)


@pytest.mark.parametrize(
    ("length", "velocities"),
    [(10.0, [5.0] * 60), (300.0, [0.5] * 20), (20.0, np.arange(1.0, 21.0, 0.2)),
     (50.0, np.arange(20.0, 2.0, -0.2))],
)  # fmt: skip
def test_pieces_of_a_run_are_told_of_while_the_chain_loads_and_never_later(length, velocities):
    """At constant u, and in a ramp that a chain goes up or down."""
    state, begun = None, (balance_length(ChainParameters(5, 1.0)) - 250.0) / velocities[0]
    for number, velocity in enumerate(velocities):
        chain = ChainParameters(5, velocity)
        options = {"duration": length, "initial_state": state, **NO_SAMPLES}
        told = lines(simulate, chain, **options)
        assert number > 0 or told
        assert number * length <= 1.1 * begun or not told
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            state = simulate(chain, **options).final_state


SLOW_FIVE = ChainParameters(5, 0.2, 1.0)
LATE = {"duration": 3000.0, "transient": 1000.0}


@pytest.mark.parametrize(
    ("chain", "name", "values", "lengths"),
    [
        (ChainParameters(5, 1.0), "stiffness", [4.0, 1.0], {"duration": 3000.0, "transient": 50.0}),
        (
            SLOW_FIVE,
            "stiffness",
            [1.0, 0.25],
            {"duration": 1400.0, "transient": 1300.0},
        ),  # all of it
        (
            ChainParameters(5, 1.0),
            "static_friction",
            [10.0, 71.4],
            {"duration": 3000.0, "transient": 100.0},
        ),
        (
            ChainParameters(5, 1.0),
            "belt_velocity",
            [0.001, 1.0],
            {"duration": 3000.0, "transient": 100.0},
        ),
    ],
)
def test_a_chain_that_is_changed_loads_anew_as_far_as_it_has_to(chain, name, values, lengths):
    first, changed = (replace(chain, **{name: value}) for value in values)
    with warnings.catch_warnings(action="ignore"):
        state = simulate(first, duration=5000.0, **NO_SAMPLES).final_state
    (line,) = lines(scan, changed, initial_state=state, **lengths)
    transient = float(re.search(r"loading is measured too .* transient=(\S+?);? ", line)[1])
    way = balance_length(changed) - state.positions[-1]
    assert way <= transient * changed.belt_velocity <= 1.5 * way
    longer = {"duration": 4 * transient, "transient": transient}
    assert not lines(scan, changed, initial_state=state, **longer)


@pytest.mark.parametrize(
    ("chain", "sweep_of"),
    [
        (ChainParameters(5, 1.0), {"belt_velocity": [1, 3, 10, 20, 10, 3, 1]}),
        (ChainParameters(5, 10.0), {"friction_ratio": [0.5, 0.3, 0.4, 0.5]}),
        (ChainParameters(5, 10.0), {"stiffness": [1.0, 2.0, 0.7]}),
    ],
)
def test_a_sweep_that_leaves_out_what_changes_is_not_warned_of(chain, sweep_of):
    assert not lines(sweep, chain, **LATE, **sweep_of)


def test_a_belt_that_goes_on_faster_loads_sooner():
    """Of the way of 366 it goes 100 at the first velocity, and the rest at the second."""
    chain, belt = ChainParameters(5, 0.05), [(2000.0, 1.0)]
    lengths = {"duration": 4000.0, "transient": 2010.0}
    (line,) = lines(simulate, chain, belt=belt, **lengths, **NO_SAMPLES)
    transient = float(re.search(r"transient=(\S+)", line)[1])
    way = balance_length(ChainParameters(5, 1.0)) - 250.0
    assert 1900 + way <= transient <= 1.29 * (1900 + way)
    lengths = {"duration": 9000.0, "transient": transient}
    assert not lines(simulate, chain, belt=belt, **lengths, **NO_SAMPLES)


def test_hardly_a_run_of_stationary_motion_is_taken_for_loading():
    """Regular, chaotic, laminar and noisy ones; of 12,000 others of 200 and longer 0.3 % were."""
    grid = Grid([2, 3, 5], np.linspace(2.0, 60.0, 15), [0.0, 1.0], replicates=3)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scan(grid, duration=1300.0, transient=1000.0, initial_spread=1.0)
    alarms = [int(re.match(r"(\d+) of", str(one.message))[1]) for one in caught]
    assert sum(alarms) <= 3  # of 270


def begun(values: np.ndarray) -> tuple:
    """The beginning of one run, from bins of ten samples each."""
    parts = values.reshape(-1, 10, 1)
    history = SimpleNamespace(
        edges=np.arange(len(parts) + 1.0),
        count=np.full(len(parts), 10),
        mean=parts.mean(axis=1),
        squares=(parts**2).mean(axis=1),
        low=parts.min(axis=1),
        high=parts.max(axis=1),
    )
    return beginning(history)


def test_only_what_does_not_come_back_is_a_beginning():
    time = np.arange(0, 100, 0.1)
    wave = np.sin(time)
    ramp = np.minimum(time - 20.0, 0.0)
    still = 0 * wave  # equal to all that comes later
    for values, length in (
        (still, 0),
        (wave, 0),
        (wave + ramp, 19),
        (wave - ramp, 19),
        (wave + time, np.inf),
    ):
        found, matters, *_ = begun(values)
        assert found == pytest.approx(length, abs=1) and matters == (length > 0)
    _, _, whole, rest = begun(wave + ramp)
    assert rest.deviation < 0.8 < 1.5 < whole.deviation
    assert not begun(np.repeat(wave[::200], 200))[1]  # laminar: one value long
