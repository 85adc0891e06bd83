"""Starts: slipping states by their volume in phase space, and stuck ones near the balance."""

import numpy as np
import pytest

from beltrepro import (
    ChainParameters,
    ChainState,
    Setup,
    scan,
    simulate,
    sliding_energy,
    slipping_state,
)
from beltrepro.base.errors import InputError
from beltrepro.model.spring import balance_length, balance_tension, spring_extension


@pytest.mark.parametrize("energy", [1e-3, 300.0, 1e5])
@pytest.mark.parametrize("n_blocks", [1, 5, 64])
def test_all_blocks_slip_with_the_energy_asked_for(n_blocks, energy):
    chain = ChainParameters(n_blocks, 20.0)
    state = slipping_state(chain, energy)
    assert (state.directions == -1).all()
    assert sliding_energy(chain, state.positions, state.velocities) == pytest.approx(
        energy, rel=1e-9, abs=1e-9
    )


def test_the_key_makes_the_state_and_the_run_from_it():
    chain = ChainParameters(3, 15.0, 1.0)
    starts = [slipping_state(chain, 500.0, replicate=number) for number in (0, 1, 0)]
    assert starts[0] == starts[2] != starts[1]
    assert starts[0] != slipping_state(chain, 500.0, seed=2)
    setup = Setup(chain, initial_state=starts[:2])
    runs = simulate(setup, duration=20)
    assert [run.replicate for run in runs] == [0, 1]
    assert runs[1] == simulate(chain, duration=20, initial_state=starts[1])


def test_states_are_as_likely_as_their_volume():
    """A block alone passes all states of its energy: their volume is the time it spends there."""
    chain = ChainParameters(1, 200.0, extension_rate=0.1)
    states = [slipping_state(chain, 1000.0, replicate=number) for number in range(100)]
    balance = 50 + spring_extension(balance_tension(chain), chain)[0]
    stretched = np.mean([state.positions[0] > balance for state in states])
    run = simulate(chain, duration=200, initial_state=states[0])
    share = np.mean(run.positions > balance)
    # the stretched spring is the stiffer one, and the block is soon back; without that it is 1/2
    assert share < 0.35
    assert abs(stretched - share) < 3 * np.sqrt(share * (1 - share) / 100)


def test_no_block_is_faster_than_the_belt_whatever_its_mass():
    chain = ChainParameters(2, 5.0, mass=(0.25, 4.0))
    states = [slipping_state(chain, 400.0, replicate=number) for number in range(40)]
    fastest = np.max([state.velocities for state in states], axis=0)
    # H would do for 14 and more, and all velocities below 5 are possible
    assert np.all((fastest > 3.5) & (fastest < 5.0))


def test_an_energy_out_of_range_is_refused():
    for energy in (0.8e-3, 1.2e6):
        with pytest.raises(InputError, match=r"energy = .*: must be at least"):
            slipping_state(ChainParameters(2, 5.0), energy)


# --- stuck near the balance ---

LAWS = [
    {"noise": 3.0},
    {"mass": range(1, 6), "stiffness": (1, 2, 0.5, 3, 1), "static_friction": range(40, 90, 10)},
    {"friction_ratio": (0.0, 0.2, 0.4, 0.6, 0.99)},
    {"linear_limit": np.inf, "rest_length": (30.0, 40.0, 50.0, 60.0, 70.0)},
    {"weakening_velocity": 20.0},
    {"viscosity": 0.3},
    {"viscosity": 30.0},  # holds more than static friction: nothing sticks there for long
]


@pytest.mark.parametrize("spread", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(
    "chain",
    [ChainParameters(size, 4.0) for size in (1, 5, 500)]
    + [ChainParameters(5, 4.0, **law) for law in LAWS],
    ids=lambda chain: chain.describe(),
)
def test_no_block_is_pulled_beyond_its_threshold(chain, spread):
    states = [ChainState.at_balance(chain, spread=spread, replicate=i) for i in range(20)]
    for state in states:
        assert np.all(np.abs(state.forces) < state.thresholds)
        assert not state.directions.any() and state.time == 0
        assert np.all(np.diff(state.positions, prepend=0.0) > 0)
    pulls = -np.mean([state.forces for state in states], axis=0)
    if chain.viscosity < 1:  # on average that of the balance
        due = -np.diff(balance_tension(chain), append=0.0)
        width = spread * (chain.by_block("static_friction") - due) / np.sqrt(3 * 20)
        assert np.all(np.abs(pulls - due) < 4.5 * width + 5 * chain.noise / np.sqrt(20) + 1e-6)


def test_a_start_at_the_balance_is_made_by_its_key():
    chain = ChainParameters(20, 1.0, 1.0)
    one, same, other = (ChainState.at_balance(chain, seed=5, replicate=i) for i in (2, 2, 3))
    assert one == same != other
    np.testing.assert_array_equal(
        one.thresholds, ChainState.at_rest(chain, seed=5, replicate=2).thresholds
    )
    with pytest.raises(InputError, match="spread = 1: springs as short as rest_length"):
        for number in range(20):
            short = ChainParameters(20, 1.0, rest_length=0.1, friction_ratio=0.1)
            ChainState.at_balance(short, replicate=number)


@pytest.mark.filterwarnings("ignore:loading is measured")
def test_slips_begin_at_once_where_loading_takes_28000():
    chain = ChainParameters(100, 1.0)
    loading = balance_length(chain) - chain.rest_positions[-1]
    run = simulate(chain, duration=20, initial_state=ChainState.at_balance(chain))
    assert loading > 28_000 and run.events["time"][0] < 1e-4 * loading
    assert abs(run.positions[-1, -1] / balance_length(chain) - 1) < 0.02
    assert len(np.unique(run.events["block"])) > 10


@pytest.mark.thorough
def test_after_a_transient_it_moves_as_a_chain_that_has_loaded():
    chain, lengths = ChainParameters(10, 1.0, 1.0), {"duration": 4000.0, "transient": 1000.0}
    states = [ChainState.at_balance(chain, replicate=number) for number in range(16)]
    near = scan([chain] * 16, initial_state=states, **lengths)
    longer = {name: time + 1000.0 for name, time in lengths.items()}
    loaded = scan(chain, replicate=range(16, 32), **longer)
    for name in ("disorder_parameter", "mean_length", "slip_count"):
        pair = [results[name].reshape(16, -1)[:, :10].mean(axis=1) for results in (near, loaded)]
        error = np.hypot(*(one.std(ddof=1) / 4 for one in pair))
        assert abs(pair[0].mean() - pair[1].mean()) < 3.5 * error, name
