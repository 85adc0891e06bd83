"""The sum rule: on average the wall pulls as strongly as friction does on all blocks together.

The energy balance closes whatever friction takes; this rule says what it takes (docs/physics.md).
"""

from collections.abc import Sequence

import numpy as np

from beltrepro.engine.state import ChainState
from beltrepro.model.energy import sliding_energy
from beltrepro.model.friction import mean_kinetic_friction


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
    gained = np.array([_belt_energy(b) - _belt_energy(a) for a, b in zip(begin, end, strict=True)])
    due = kinetic * (chains[0].n_blocks + 2 * forward_slip / (speed * time))
    missing = mean_wall_tension(begin, end) - due - gained / (speed * time)
    return missing / (kinetic * chains[0].n_blocks)


def _belt_energy(state: ChainState) -> float:
    """The sliding energy in the frame of the belt."""
    return float(sliding_energy(state.parameters, state.positions, state.relative_velocities))
