"""Spring law of Sec. III (Fig. 6): linear up to a limit, exponential beyond it; and its balance.

Springs may differ by a factor, their stiffness: then the last axis of an array is that of the N
springs.
"""

import math
from functools import cache

import numpy as np
import numpy.typing as npt

from beltrepro.model.friction import kinetic_friction
from beltrepro.model.parameters import ChainParameters

SECTION_POSITION = 615.0  # of the last of five blocks (Sec. IV.A, Fig. 12)
_FIVE = ChainParameters(5, belt_velocity=1.0)


def spring_force(deformation: npt.ArrayLike, parameters: ChainParameters) -> np.ndarray:
    """Elastic force F_e(dl) of one spring on the block at its far end (Sec. III, Fig. 6)."""
    deformation = np.asarray(deformation, dtype=float)
    rate, linear, excess = _branches(deformation, parameters)
    pull = np.copysign(linear + np.expm1(rate * excess) / rate, deformation)
    return -pull * np.asarray(parameters.stiffness)


def spring_energy(deformation: npt.ArrayLike, parameters: ChainParameters) -> np.ndarray:
    """Potential energy of one spring: minus the integral of `spring_force` from 0 to dl."""
    deformation = np.asarray(deformation, dtype=float)
    rate, linear, excess = _branches(deformation, parameters)
    beyond = np.expm1(rate * excess) / rate
    energy = linear**2 / 2 + excess * linear + (beyond - excess) / rate
    return energy * np.asarray(parameters.stiffness)


def spring_extension(force: npt.ArrayLike, parameters: ChainParameters) -> np.ndarray:
    """Deformation dl at which the spring pulls with the given tension -F_e (inverse of the law)."""
    force = np.asarray(force, dtype=float) / np.asarray(parameters.stiffness)
    rate = np.where(force < 0, parameters.compression_rate, parameters.extension_rate)
    excess = np.maximum(np.abs(force) - parameters.linear_limit, 0.0)
    linear = np.minimum(np.abs(force), parameters.linear_limit)
    return np.copysign(linear + np.log1p(rate * excess) / rate, force)


def spring_stiffness(deformation: npt.ArrayLike, parameters: ChainParameters) -> np.ndarray:
    """Slope of the tension -F_e(dl): the stiffness on the linear branch, more beyond it."""
    rate, _, excess = _branches(np.asarray(deformation, dtype=float), parameters)
    return np.exp(rate * excess) * np.asarray(parameters.stiffness)


def balance_tension(parameters: ChainParameters) -> np.ndarray:
    """Tension (N,) of the springs that hold the blocks beyond them against kinetic friction."""
    kinetic = kinetic_friction(parameters, parameters.belt_velocity)
    if parameters.varied:
        return np.cumsum(kinetic[::-1])[::-1]
    return kinetic * np.arange(parameters.n_blocks, 0, -1)


def balance_length(parameters: ChainParameters, blocks: int | None = None) -> float:
    """Length of the chain, or of its first blocks, at which springs balance kinetic friction."""
    # only friction that depends on the velocity lets the balance depend on the belt
    speed = parameters.belt_velocity if parameters.friction_varies else 1.0
    return _balance_length(parameters.n_blocks, speed, parameters.law, blocks)


@cache  # a scan asks it of each of its chains
def _balance_length(n_blocks: int, speed: float, law: tuple, blocks: int | None) -> float:
    chain = ChainParameters(n_blocks, speed, 0.0, *law)
    extension = spring_extension(balance_tension(chain), chain)
    return float(np.sum((np.asarray(chain.rest_length) + extension)[:blocks]))


def section_position(parameters: ChainParameters, block: int | None = None) -> float:
    """Position at which the velocity of a block, the last one unless told, is recorded (Fig. 12).

    The paper gives 615 for the last of five blocks, 0.998 of its place where springs balance
    kinetic friction; other blocks and chains have the same share of theirs.
    """
    share = SECTION_POSITION / balance_length(_FIVE)
    place = share * balance_length(parameters, block or parameters.n_blocks)
    # a decimal as in the paper, more where the unit of length is a longer one
    return round(place, 1 if place >= 10 else 3 - math.floor(math.log10(place)))


def chain_deformations(positions: npt.ArrayLike, parameters: ChainParameters) -> np.ndarray:
    """Deformations of the N springs of a chain; the first spring hangs on the wall at 0."""
    positions = np.asarray(positions, dtype=float)
    return np.diff(positions, axis=-1, prepend=0.0) - parameters.rest_length


def external_force(positions: npt.ArrayLike, parameters: ChainParameters) -> np.ndarray:
    """Resultant spring force F_ex on each block (Eq. 1)."""
    force = spring_force(chain_deformations(positions, parameters), parameters)
    force[..., :-1] -= force[..., 1:]  # a spring pulls back what it pulls on
    return force


def acceleration(
    positions: npt.ArrayLike,
    relative_velocities: npt.ArrayLike,
    directions: npt.ArrayLike,
    parameters: ChainParameters,
    noise: float | np.ndarray = 0.0,
) -> np.ndarray:
    """Acceleration (..., N) of blocks that slip over the belt in these directions; 0 where stuck.

    noise : what the force of the noise adds to that of the springs.
    """
    braked = kinetic_friction(parameters, relative_velocities) * directions
    force = external_force(positions, parameters) - braked + noise
    return np.where(np.asarray(directions) != 0, force / np.asarray(parameters.mass), 0.0)


def potential_energy(positions: npt.ArrayLike, parameters: ChainParameters) -> np.ndarray:
    """Energy stored in all springs of the chain."""
    deformations = chain_deformations(positions, parameters)
    return spring_energy(deformations, parameters).sum(axis=-1)


def _branches(
    deformation: np.ndarray, parameters: ChainParameters
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rate of the branch, and the parts of |dl| on and beyond the linear branch."""
    size = np.abs(deformation)
    rate = np.where(deformation < 0, parameters.compression_rate, parameters.extension_rate)
    linear = np.minimum(size, parameters.linear_limit)
    return rate, linear, size - linear
