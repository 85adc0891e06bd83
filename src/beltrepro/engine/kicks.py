"""Random kicks: `event`, disturbed at each start of a slip as a scheme in time steps disturbs it.

A scheme in time steps lets slips start late (`beltrepro.model.scheme_error`). A kick does what a
late start does: it moves a block along the chain at the instant at which its slip starts. Its speed
does not change. The energy that the springs lose counts as a loss of the block, so that the energy
balance closes.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from beltrepro.engine.event import SLIP, Hooks, stretch
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.law import branch_at, spring_energy
from beltrepro.engine.noise import normal_pair
from beltrepro.engine.vector import aligned, inlined


class Kicks(NamedTuple):
    """What W chains are kicked by."""

    size: np.ndarray  # (W,) standard deviation of a kick; chains with 0 draw no random number


@inlined
def kick(kind, block, lane, i, group, scratch, kicks):
    """Hook: moves a block that starts to slip."""
    chain = lane + i
    size = kicks.size[chain]
    if kind == SLIP and size > 0.0:
        deviate, _ = normal_pair(group.chains.streams, chain)
        _displace(block, chain, size * deviate, group)


@inlined
def _displace(block, chain, change, group):
    chains = group.chains
    before = _stored_beside(block, chain, group)
    chains.displacement[block, chain] += change
    chains.dissipated[block, chain] += before - _stored_beside(block, chain, group)
    for spring in range(block, min(block + 2, chains.direction.shape[0])):
        deformation = stretch(spring, chain, chains.displacement)
        chains.branch[spring, chain] = branch_at(deformation, group.law)
        chains.branch_changed[spring, chain] = 0.0


@inlined
def _stored_beside(block, chain, group):
    """Energy of the springs on both sides of a block of one chain."""
    displacement = group.chains.displacement
    energy = spring_energy(block, stretch(block, chain, displacement), group.law, group.varied)
    if block < group.chains.direction.shape[0] - 1:
        following = stretch(block + 1, chain, displacement)
        energy += spring_energy(block + 1, following, group.law, group.varied)
    return energy


HOOKS = Hooks(event_applied=kick)


class KickedIntegrator(EventIntegrator):
    """Chains integrated by `event`, with a random kick at each start of a slip.

    Parameters as for `EventIntegrator`, and sizes : standard deviation of the kicks of each of the
    W chains, model length. The deviates come from the streams of the chains, which their states
    carry: a run goes on where it has stopped.
    """

    _hooks = HOOKS

    def __init__(self, states, *, sizes: Sequence[float], **settings):
        super().__init__(states, **settings)
        self._companion = Kicks(aligned(np.asarray(sizes, dtype=float)[self._source]))
