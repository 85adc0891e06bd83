"""The energy of the sliding chain: its form, what keeps it, what a stick adds, its modes."""

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, mode_energies, simulate, sliding_energy
from beltrepro.model.energy import normal_modes, slips_for_good, swings_grow
from beltrepro.model.spring import (
    balance_tension,
    external_force,
    potential_energy,
    spring_extension,
)
from beltrepro.simulation.starts import slipping_state

KINETIC = 71.4 * 0.45


def balance(chain):
    """Positions at which the springs balance the kinetic friction of all blocks."""
    extension = spring_extension(balance_tension(chain), chain)
    return np.cumsum(chain.rest_length + extension)


def energies(run):
    return sliding_energy(run.parameters, run.positions, run.velocities)


@pytest.mark.parametrize("n_blocks", [1, 3, 8])
def test_the_energy_is_that_of_springs_and_a_constant_force_above_its_minimum(n_blocks):
    chain, random = ChainParameters(n_blocks, 20.0), np.random.default_rng(1)
    rest = balance(chain)
    assert np.allclose(external_force(rest, chain), -KINETIC)
    assert abs(sliding_energy(chain, rest, np.zeros(n_blocks))) < 1e-10
    places = rest + random.uniform(-20, 20, (7, n_blocks))
    speeds = random.uniform(-30, 30, (7, n_blocks))
    plain = (speeds**2).sum(axis=1) / 2 + potential_energy(places, chain)
    plain -= KINETIC * places.sum(axis=1)
    least = potential_energy(rest, chain) - KINETIC * rest.sum()
    assert np.allclose(sliding_energy(chain, places, speeds), plain - least, rtol=1e-12)


@pytest.mark.parametrize(("n_blocks", "replicate"), [(1, 0), (2, 1), (5, 2), (5, 3)])
def test_below_half_the_square_of_the_belt_velocity_no_block_ever_sticks(n_blocks, replicate):
    chain = ChainParameters(n_blocks, 20.0)
    for share in (0.8, 0.999):
        start = slipping_state(chain, share * 200, replicate=replicate)
        run = simulate(chain, duration=300, initial_state=start)
        assert len(run.events) == 0
        assert np.allclose(energies(run), share * 200, rtol=1e-12)


@pytest.mark.parametrize("distance", [30.0, 50.0, 75.0])
def test_a_stick_of_a_block_on_a_linear_spring_changes_the_energy_by_the_closed_form(distance):
    chain = ChainParameters(1, 10.0, linear_limit=1000)
    start = ChainState.in_motion(chain, balance(chain) - distance, [-5.0])
    run = simulate(chain, duration=30, initial_state=start)
    stick, slip = run.events["time"][:2]
    before, after = (energies(run)[run.time < stick][-1], energies(run)[run.time > slip][0])
    acceleration = run.events["force"][0] + KINETIC
    assert after - before == pytest.approx(((71.4 - KINETIC) ** 2 - acceleration**2) / 2)
    # a fast arrival takes energy, a slow one brings it
    assert (after > before) == (acceleration < 71.4 - KINETIC)


def test_only_stuck_blocks_change_the_energy():
    """By u times the friction on them beyond the kinetic one."""
    run = simulate(ChainParameters(3, 20.0), duration=60, sample_interval=0.002)
    stuck = run.velocities == 20.0
    power = 20.0 * np.where(stuck, run.friction - KINETIC, 0.0).sum(axis=1)
    gained = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * 0.002)])
    change = energies(run) - energies(run)[0]
    assert np.ptp(change) > 2000
    assert np.abs(change - gained).max() < 0.005 * np.ptp(change)


def test_modes_of_small_oscillations_keep_their_energies():
    chain = ChainParameters(4, 20.0)
    start = slipping_state(chain, 1e-3)
    run = simulate(chain, duration=50, initial_state=start)
    shares = mode_energies(chain, run.positions, run.velocities)
    assert shares.shape == (len(run.time), 4)
    assert np.allclose(shares.sum(axis=1), 1e-3, rtol=1e-3)
    assert np.allclose(shares, shares[0], atol=1e-5)


def test_the_lowest_mode_is_that_of_all_blocks_together():
    frequencies, shapes = normal_modes(ChainParameters(5, 20.0))
    assert np.all(np.diff(frequencies) > 0)
    assert [np.count_nonzero(np.diff(np.sign(shape))) for shape in shapes.T] == [0, 1, 2, 3, 4]
    (frequency,), _ = normal_modes(ChainParameters(1, 20.0))
    assert frequency == pytest.approx(np.sqrt(1 + 0.01 * (KINETIC - 20)))


@pytest.mark.parametrize(
    ("law", "grow"),
    [
        ({"mass": (1.0, 2.0, 3.0)}, False),
        ({"mass": (1.0, 2.0, 3.0), "viscosity": 5.0}, False),
        ({"weakening_velocity": 100.0}, True),
        ({"weakening_velocity": 100.0, "viscosity": 0.2}, False),
        ({"weakening_velocity": 100.0, "friction_ratio": (0.0, 0.0, 0.45)}, True),
    ],
)
def test_swings_grow_where_friction_falls_faster_than_viscosity_rises(law, grow):
    chain = ChainParameters(3, 50.0, rest_length=500.0, linear_limit=np.inf, **law)
    assert swings_grow(chain) == grow


def test_swings_of_which_only_small_ones_are_damped_end_if_they_are_small():
    """Friction falls faster with the lower speeds that a large swing reaches."""
    law = {"weakening_velocity": 1000.0, "viscosity": 0.02917}
    chain = ChainParameters(1, 50.0, rest_length=500.0, linear_limit=np.inf, **law)
    balance = [500 + KINETIC / 1.05 + 0.02917 * 50]
    assert slips_for_good(chain, np.array(balance), np.array([0.2]), 1e-3)
    assert not slips_for_good(chain, np.array(balance), np.array([15.0]), 1e-3)
