"""Random kicks: `event`, disturbed at each start of a slip as a scheme in time steps disturbs it.

The paper's scheme looks for events once in a step dt. So the step in which a block begins to slip
begins late, by a time between 0 and dt. The block then moves by a dt^2 in its first step, where the
exact motion would move it by half of that. (a is the relative acceleration.) This is as if it had
begun dt / 2 earlier. So the slip begins late by a time t that is uniform between -dt / 2 and dt /
2. The belt carries the block on by u t until then. This is the only error of first order that each
slip makes. At the end of a slip the speed over the belt is zero, so a stick that comes late by t is
wrong by a t^2 / 2 in place. Between events the scheme is of second order.

What a late start leaves behind follows from one block between neighbours at rest, an oscillator
about some place x_0. It slips from x_s with the speed u of the belt and sticks when it has the
speed u again, at 2 x_0 - x_s. If it starts late, it sticks u t less far along, and a time t later:
2 u t less far on the belt. If it starts in time and is moved by s at that instant, it sticks s less
far, on the belt too. So a move by s = 2 u t does what a start late by t does. The standard
deviation of t is dt / sqrt(12). So normal kicks with the standard deviation u dt / sqrt(3),
`equivalent_kick`, disturb as much as the scheme does.

A kick moves a block at the instant at which it starts to slip, along the chain and at rest on the
belt. Its speed does not change. The energy that the springs lose counts as a loss of the block, so
that the energy balance closes.
"""

import math
from typing import NamedTuple

import numpy as np

from beltrepro.engine.event import SLIP, Hooks
from beltrepro.engine.law import branch_at, stored_energy
from beltrepro.engine.noise import normal_pair
from beltrepro.engine.vector import inlined


class Kicks(NamedTuple):
    """What W chains are kicked by."""

    size: np.ndarray  # (W,) standard deviation of a kick; chains with 0 draw no random number


def equivalent_kick(belt_velocity, time_step):
    """Size of kicks that disturb as much as the late starts of the paper's scheme; model length."""
    return belt_velocity * time_step / math.sqrt(3.0)


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
        chains.branch[spring, chain] = branch_at(_stretch(spring, chain, chains), group.law)
        chains.branch_changed[spring, chain] = 0.0


@inlined
def _stored_beside(block, chain, group):
    """Energy of the springs on both sides of a block of one chain."""
    energy = stored_energy(_stretch(block, chain, group.chains), group.law)
    if block < group.chains.direction.shape[0] - 1:
        energy += stored_energy(_stretch(block + 1, chain, group.chains), group.law)
    return energy


@inlined
def _stretch(spring, chain, chains):
    """Deformation of a spring of one chain."""
    stretch = chains.displacement[spring, chain]
    if spring > 0:
        stretch -= chains.displacement[spring - 1, chain]
    return stretch


HOOKS = Hooks(event_applied=kick)
