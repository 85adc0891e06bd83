"""The sum rule: on average the wall pulls as strongly as friction does on all blocks together.

The energy balance closes whatever friction takes; this rule says what it takes (docs/physics.md).
"""

from collections.abc import Sequence

import numpy as np

from beltrepro.engine.state import ChainState
from beltrepro.model.energy import excess_energy, kinetic_energy
from beltrepro.model.friction import mean_kinetic_friction
from beltrepro.model.spring import chain_deformations


def mean_wall_tension(begin: Sequence[ChainState], end: Sequence[ChainState]) -> np.ndarray:
    """Exact mean (W,) of the first spring's pull between two states of each of W runs."""
    return np.array(
        [
            (b.wall_impulse - a.wall_impulse) / (b.time - a.time)
            for a, b in zip(begin, end, strict=True)
        ]
    )


def sum_rule_residual(
    begin: Sequence[ChainState], end: Sequence[ChainState], forward_slip: np.ndarray
) -> np.ndarray:
    """What the sum rule does not explain of the mean pull of the wall (W,), as a share of N k.

    Where blocks differ k is the mean of their friction; NaN where it depends on the velocity.
    forward_slip : way (W,) that blocks slipped forward, from `ForwardSlip`.
    """
    chains = [state.parameters for state in begin]
    if chains[0].friction_varies:
        return np.full(len(chains), np.nan)
    speed = np.array([chain.belt_velocity for chain in chains])
    time = np.array([b.time - a.time for a, b in zip(begin, end, strict=True)])
    kinetic = np.array([mean_kinetic_friction(chain) for chain in chains])
    gained = _belt_energies(end) - _belt_energies(begin)
    due = kinetic * (chains[0].n_blocks + 2 * forward_slip / (speed * time))
    missing = mean_wall_tension(begin, end) - due - gained / (speed * time)
    return missing / (kinetic * chains[0].n_blocks)


def _belt_energies(states: Sequence[ChainState]) -> np.ndarray:
    """The sliding energies (W,) in the frame of the belt of chains of one law."""
    chain = states[0].parameters
    displacements = np.array([state.displacements for state in states])
    relative = np.array([state.relative_velocities for state in states])
    stretched = chain_deformations(displacements + chain.rest_positions, chain)
    return excess_energy(stretched, chain).sum(axis=-1) + kinetic_energy(chain, relative)
