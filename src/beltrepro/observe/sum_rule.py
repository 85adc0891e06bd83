"""The sum rule: on average the wall pulls as strongly as friction does on all blocks together.

The energy balance closes whatever friction takes; this rule says what it takes (docs/physics.md).
It needs the rare slips in which blocks are faster than the belt, where friction drags them back.
"""

from collections.abc import Sequence

import numpy as np

from beltrepro.engine.integrator import Chunk
from beltrepro.engine.records import (
    EVENT_BLOCK,
    EVENT_FORCE,
    EVENT_POSITION,
    EVENT_SLIP,
    EVENT_TIME,
)
from beltrepro.engine.state import ChainState
from beltrepro.engine.vector import kernel
from beltrepro.model.energy import excess_energy, kinetic_energy
from beltrepro.model.friction import kinetic_friction, mean_kinetic_friction
from beltrepro.model.spring import chain_deformations


def mean_wall_tension(begin: Sequence[ChainState], end: Sequence[ChainState]) -> np.ndarray:
    """Exact mean (W,) of the first spring's pull between two states of each of W runs."""
    pairs = zip(begin, end, strict=True)
    return np.array([(b.wall_impulse - a.wall_impulse) / (b.time - a.time) for a, b in pairs])


def sum_rule_residual(
    begin: Sequence[ChainState], end: Sequence[ChainState], forward_slip: np.ndarray
) -> np.ndarray:
    """What the sum rule does not explain of the mean pull of the wall (W,), as a share of N k.

    Where blocks differ k is the mean of their friction; NaN where it is 0 or depends on velocity.
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
    return missing / (np.where(kinetic > 0, kinetic, np.nan) * chains[0].n_blocks)


def _belt_energies(states: Sequence[ChainState]) -> np.ndarray:
    """The sliding energies (W,) in the frame of the belt of chains of one law."""
    chain = states[0].parameters
    displacements = np.array([state.displacements for state in states])
    relative = np.array([state.relative_velocities for state in states])
    stretched = chain_deformations(displacements + chain.rest_positions, chain)
    return excess_energy(stretched, chain).sum(axis=-1) + kinetic_energy(chain, relative)


class ForwardSlip:
    """Way of all blocks in their forward slips, for each of W chains: integral of (v - u)^+.

    Where blocks differ each counts in proportion to its kinetic friction.
    """

    def __init__(self, states: Sequence[ChainState]) -> None:
        self._belt_velocity = np.array([state.parameters.belt_velocity for state in states])
        # place on the belt where the forward slip going on began; NaN for the other blocks
        self._begun = np.array([np.where(s.directions > 0, _places(s), np.nan) for s in states])
        self._way = np.zeros(len(states))
        self._weights = np.array([_weights(state) for state in states])

    def observe(self, chunk: Chunk) -> None:
        self.follow(chunk.events, chunk.event_count)

    def follow(self, events: np.ndarray, count: np.ndarray) -> None:
        """Follow events (W, E, 6), of which the first `count` (W,) count."""
        _follow_forward(events, count, self._belt_velocity, self._begun, self._weights, self._way)

    def way(self, states: Sequence[ChainState]) -> np.ndarray:
        """The way (W,) until these states, the slips going on included."""
        going_on = np.array([_places(state) for state in states]) - self._begun
        return self._way + np.nansum(self._weights * going_on, axis=1)


def _places(state: ChainState) -> np.ndarray:
    """Where blocks are on the belt."""
    return state.displacements - state.parameters.belt_velocity * state.time


def _weights(state: ChainState) -> np.ndarray:
    """Kinetic friction of each block over that of all on average."""
    chain = state.parameters
    return kinetic_friction(chain) / max(mean_kinetic_friction(chain), np.finfo(float).tiny)


@kernel
def _follow_forward(events, count, belt_velocity, begun, weights, way):
    for lane in range(len(way)):
        for index in range(count[lane]):
            block = int(events[lane, index, EVENT_BLOCK])
            place = events[lane, index, EVENT_POSITION]
            place -= belt_velocity[lane] * events[lane, index, EVENT_TIME]
            if events[lane, index, EVENT_SLIP] > 0.0:
                # towards F_ex, see `model.friction`
                begun[lane, block] = np.nan if events[lane, index, EVENT_FORCE] < 0.0 else place
            elif not np.isnan(begun[lane, block]):
                way[lane] += weights[lane, block] * (place - begun[lane, block])
                begun[lane, block] = np.nan
