"""States in which all blocks slip, drawn at random among those of one energy."""

import numpy as np

from beltrepro.base import checks, names
from beltrepro.engine.noise import stream_states
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model.energy import check_conserved, excess_energy
from beltrepro.model.spring import (
    balance_tension,
    spring_extension,
    spring_force,
    spring_stiffness,
)

_SLIPPING = 2  # purpose of a random stream: slipping states, not friction or initial positions
_ENERGIES = {"ge": 1e-3, "le": 1e6}  # below, rounding of the positions is seen
_SWEEPS = 40  # of the Markov chain; energy has come to all blocks after log2(2 N)
_STRETCHED = 0.01  # share of the energy that is in the springs when it begins
_NEWTON_STEPS = 50  # at most; most springs take 5
_CLOSE = 1e-13  # share of the rest length


@names.checked
def slipping_state(
    parameters: ChainParameters, energy: float, *, seed: int = 1, replicate: int = 0
) -> ChainState:
    """A random state in which all blocks slip, none faster than the belt, of a given energy.

    All such states are equally likely: by their volume in phase space, which the motion keeps while
    all blocks slip. A run begins there with `initial_state`.

    Parameters
    ----------
    parameters : ChainParameters
        The chain.
    energy : float
        H as `sliding_energy` has it, model energy, 1e-3 to 1e6. Below m u^2 / 2 of the lightest
        block none ever sticks.
    seed, replicate : int
        Key of the state, with the parameters, and of the random numbers of a run from it.

    Returns
    -------
    ChainState
        At time 0.

    Raises
    ------
    InputError
        A value is not allowed.
    """
    state = ChainState.at_rest(parameters, seed=seed, replicate=replicate)
    check_conserved(parameters)
    energy = checks.within("energy", energy, **_ENERGIES)
    words = stream_states([parameters], [state.seed], [state.replicate], _SLIPPING)
    velocities, deformations = _mixed(parameters, energy, np.random.default_rng(words[:, 0]))
    return state.moved(np.cumsum(deformations + np.asarray(parameters.rest_length)), velocities)


def _mixed(
    parameters: ChainParameters, energy: float, random: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and deformations (N,) after so many sweeps of a Markov chain.

    H = sum (m_i v_i^2 + s_i^2) / 2, where s_i^2 / 2 is the energy of spring i above the balance
    and s_i has the sign of dl_i - dl_i*. A move turns two of the 2 N coordinates by a random angle,
    so that H stays. By Metropolis' rule states become as likely as prod d(dl_i)/d(s_i), their
    volume.
    """
    n_blocks = parameters.n_blocks
    start = np.sqrt(2 * energy / n_blocks * np.array([[1 - _STRETCHED], [_STRETCHED]]))
    coordinates = np.repeat(start * [[-1.0], [1.0]], n_blocks)  # velocities, then springs
    deformations, weight = _weighed(coordinates, parameters)
    for _ in range(_SWEEPS):
        one, other = random.permutation(2 * n_blocks).reshape(2, -1)
        size = np.hypot(coordinates[one], coordinates[other])
        angle = random.uniform(0.0, 2 * np.pi, n_blocks)
        turned = np.empty_like(coordinates)
        turned[one], turned[other] = size * np.cos(angle), size * np.sin(angle)
        stretched, new = _weighed(turned, parameters)
        gain = new[one] * new[other] / (weight[one] * weight[other])
        moves = np.zeros(2 * n_blocks, dtype=bool)
        moves[one] = moves[other] = random.random(n_blocks) < gain
        coordinates, weight = np.where(moves, turned, coordinates), np.where(moves, new, weight)
        deformations = np.where(moves[n_blocks:], stretched, deformations)
    return coordinates[:n_blocks] / np.sqrt(parameters.by_block("mass")), deformations


def _weighed(coordinates: np.ndarray, parameters: ChainParameters) -> tuple[np.ndarray, np.ndarray]:
    """Deformations (N,), and the density (2N,) of each coordinate, 0 where it is not allowed."""
    velocities, signed = np.split(coordinates, 2)
    tension = balance_tension(parameters)
    balance = spring_extension(tension, parameters)
    with np.errstate(over="ignore"):  # long springs never touch
        touching = excess_energy(-parameters.by_block("rest_length"), parameters)
    apart = signed > -np.sqrt(2 * touching)
    signed = np.where(apart, signed, 1.0)
    # |dl - dl*| <= |s| / sqrt(k), since springs are at least as stiff as k, and as at the balance
    # where they are stretched; from there Newton's method never passes the root
    stiffest = np.where(
        signed > 0, spring_stiffness(balance, parameters), parameters.by_block("stiffness")
    )
    beyond = signed / np.sqrt(stiffest)
    for _ in range(_NEWTON_STEPS):
        slope = -spring_force(balance + beyond, parameters) - tension
        step = (excess_energy(balance + beyond, parameters) - signed**2 / 2) / slope
        beyond = beyond - step
        if np.abs(step).max() < _CLOSE * np.min(parameters.rest_length):
            break
    slower = velocities < parameters.belt_velocity * np.sqrt(parameters.by_block("mass"))
    return balance + beyond, np.concatenate([slower, np.where(apart, signed / slope, 0.0)])
