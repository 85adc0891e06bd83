"""The energy of the sliding chain, and how its normal modes share it (docs/physics.md)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.model.friction import friction_fall
from beltrepro.model.parameters import LONGEST, ChainParameters, check_chain
from beltrepro.model.spring import (
    balance_tension,
    chain_deformations,
    spring_energy,
    spring_extension,
    spring_stiffness,
)

_RARE = 30  # times its mean, which the energy of a swing under noise exceeds for e^-30 of the time
_SMALL = 0.01  # velocity of a swing over that of the belt, up to which modes tell how it goes on


@names.checked
def sliding_energy(
    parameters: ChainParameters, positions: ArrayLike, velocities: ArrayLike
) -> np.ndarray:
    """Energy H that a chain keeps while all blocks slip and none is faster than the belt.

    Kinetic friction k is then a constant force on each block, and H = sum v_i^2 / 2 + sum V(dl_i) -
    k sum x_i, less its minimum, is conserved. Where H < u^2 / 2, no block ever reaches the belt.
    (Where blocks differ: sum m_i v_i^2 / 2, sum k_i x_i, and m u^2 / 2 of the lightest.)

    Parameters
    ----------
    parameters : ChainParameters
        The chain; with noise k is the mean kinetic friction.
    positions, velocities : array (N,) or (T, N)
        Of the blocks in the laboratory frame, model length and velocity.

    Returns
    -------
    array, () or (T,)
        H of each row, model energy; 0 where all blocks rest and the springs balance friction.

    Raises
    ------
    InputError
        The arrays do not fit the chain, or the positions do not increase.
    """
    positions, velocities = _checked(parameters, positions, velocities)
    return _swing_energy(parameters, positions, velocities)


def _swing_energy(
    parameters: ChainParameters, positions: np.ndarray, velocities: np.ndarray
) -> np.ndarray:
    """H of `sliding_energy`, about the balance at the velocity of the belt."""
    deformations = chain_deformations(positions, parameters)
    energy = excess_energy(deformations, parameters).sum(axis=-1)
    return energy + kinetic_energy(parameters, velocities)


def kinetic_energy(parameters: ChainParameters, velocities: np.ndarray) -> np.ndarray:
    """Energy of motion of rows (..., N) of velocities."""
    return (np.asarray(parameters.mass) * velocities**2).sum(axis=-1) / 2


@names.checked
def mode_energies(
    parameters: ChainParameters, positions: ArrayLike, velocities: ArrayLike
) -> np.ndarray:
    """Energy in each normal mode of small oscillations about the balance of springs and friction.

    Where the oscillations are small the energies of all modes add up to `sliding_energy`. The share
    of the lowest mode, in which all blocks swing together, is what r measures.

    Parameters
    ----------
    parameters : ChainParameters
        The chain.
    positions, velocities : array (N,) or (T, N)
        Of the blocks in the laboratory frame, model length and velocity.

    Returns
    -------
    array (N,) or (T, N)
        Model energy, the slowest mode first.

    Raises
    ------
    InputError
        The arrays do not fit the chain, or the positions do not increase.
    """
    positions, velocities = _checked(parameters, positions, velocities)
    frequencies, shapes = normal_modes(parameters)
    weights = np.sqrt(parameters.by_block("mass"))
    lengths = np.asarray(parameters.rest_length) + _balance(parameters)
    swing = (positions - np.cumsum(lengths)) * weights @ shapes * frequencies
    return ((velocities * weights @ shapes) ** 2 + swing**2) / 2


def normal_modes(parameters: ChainParameters) -> tuple[np.ndarray, np.ndarray]:
    """Angular frequencies (N,) of small oscillations about the balance, and shapes in columns."""
    stiffness = spring_stiffness(_balance(parameters), parameters)
    springs = np.eye(parameters.n_blocks) - np.eye(parameters.n_blocks, k=-1)  # dl_i of the x_j
    # displacements times the roots of the masses make the matrix symmetric
    springs = springs / np.sqrt(parameters.by_block("mass"))
    squares, shapes = np.linalg.eigh(springs.T @ (stiffness[:, None] * springs))
    return np.sqrt(squares), shapes


def swings_grow(parameters: ChainParameters) -> bool:
    """Whether some small swing grows while all blocks slip."""
    fall = friction_fall(parameters, parameters.belt_velocity)
    if not parameters.varied or fall.max() <= 0:
        return bool(fall.max() > 0)
    frequencies, shapes = normal_modes(parameters)
    damping = shapes.T @ ((fall / parameters.by_block("mass"))[:, None] * shapes)
    none, one = np.zeros_like(damping), np.eye(len(damping))
    rates = np.linalg.eigvals(np.block([[none, one], [-np.diag(frequencies**2), damping]]))
    return bool(rates.real.max() > 0)


def slips_for_good(
    parameters: ChainParameters, positions: np.ndarray, velocities: np.ndarray, time_step: float
) -> bool:
    """Whether blocks that all slip, at a state (N,), never stick: their swings are too small.

    All the energy H gives one block no more than a velocity, which is to be below that of the belt.
    H does not grow where friction falls with no speed that is reached. Of small swings the modes
    tell, also where friction falls for some blocks only. What noise brings is counted to H.
    """
    energy = float(_swing_energy(parameters, positions, velocities))
    energy = max(energy, 0.0) + _noise_energy(parameters, time_step)
    fastest = math.sqrt(2 * energy / parameters.by_block("mass").min())
    slowest = parameters.belt_velocity - fastest  # |v_r| of a block
    if slowest > 0 and friction_fall(parameters, slowest).max() <= 0:
        return True
    return fastest < _SMALL * parameters.belt_velocity and not swings_grow(parameters)


def _noise_energy(parameters: ChainParameters, time_step: float) -> float:
    """Energy that noise of kinetic friction hardly brings to sliding blocks in the longest run.

    Each of them gains power / 2m in the mean, for as long as friction does not take it away again.
    """
    mass = parameters.by_block("mass")
    power = (parameters.by_block("friction_ratio") * parameters.noise) ** 2 * time_step
    damping = -friction_fall(parameters, parameters.belt_velocity).max() / mass.max()
    return _RARE * float((power / mass).sum() / 2) / max(damping, 1 / LONGEST)


def slow_unit(parameters: ChainParameters) -> float:
    """Unit of time of the heaviest block on the softest spring: 1 in the paper's chain."""
    mass, stiffness = parameters.by_block("mass"), parameters.by_block("stiffness")
    return math.sqrt(mass.max() / stiffness.min())


def fast_unit(parameters: ChainParameters) -> float:
    """Unit of time of the lightest block on the stiffest spring: 1 in the paper's chain."""
    mass, stiffness = parameters.by_block("mass"), parameters.by_block("stiffness")
    return math.sqrt(mass.min() / stiffness.max())


def as_lengths(chain: ChainParameters) -> np.ndarray:
    """Factors (2N,) that make lengths of the displacements and velocities of a state."""
    # of a block that oscillates, they are as large as its displacements
    times = np.sqrt(chain.by_block("mass") / chain.by_block("stiffness"))
    return np.concatenate([np.ones(chain.n_blocks), times])


def times_as_fast(parameters: ChainParameters) -> int:
    """How many times as fast as in the paper's chain things may be in one of other constants."""
    mass = parameters.by_block("mass").min()
    rates = math.sqrt(parameters.by_block("stiffness").max() / mass), parameters.viscosity / mass
    return math.ceil(max(1.0, *rates))


def check_conserved(parameters: ChainParameters) -> None:
    """InputError for a chain that does not keep the energy H while it slides."""
    if parameters.friction_varies:
        raise InputError(
            f"weakening_velocity = {parameters.weakening_velocity:g} and "
            f"viscosity = {parameters.viscosity:g}: "
            "energy is kept only where kinetic friction does not depend on velocity"
        )


def _balance(parameters: ChainParameters) -> np.ndarray:
    """Deformations (N,) at which the springs balance kinetic friction."""
    return spring_extension(balance_tension(parameters), parameters)


def excess_energy(deformations: np.ndarray, parameters: ChainParameters) -> np.ndarray:
    """Energy of each spring (..., N) and of friction's pull on it, above that at the balance."""
    balance = _balance(parameters)
    stored = spring_energy(deformations, parameters) - spring_energy(balance, parameters)
    return stored - balance_tension(parameters) * (deformations - balance)


def _checked(
    parameters: ChainParameters, positions: ArrayLike, velocities: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    check_chain(parameters)
    check_conserved(parameters)
    positions = checks.positions("positions", positions, parameters.n_blocks, rows=True)
    velocities = checks.numbers("velocities", velocities, parameters.n_blocks, rows=True)
    if positions.shape != velocities.shape:
        needed = f"the shape {positions.shape} of the positions is needed"
        raise InputError(f"velocities of shape {velocities.shape}: {needed}")
    return positions, velocities
