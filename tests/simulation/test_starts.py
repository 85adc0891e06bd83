"""Random slipping states: of the energy asked for, reproducible, by their volume in phase space."""

import numpy as np
import pytest

from beltrepro import ChainParameters, Setup, simulate, sliding_energy, slipping_state
from beltrepro.base.errors import InputError
from beltrepro.model.spring import balance_tension, spring_extension


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
