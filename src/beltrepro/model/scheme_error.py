"""How much the paper's scheme disturbs each slip, in terms of a displacement.

The scheme looks for events once in a step dt. So the step in which a block begins to slip begins
late, by a time between 0 and dt. The block then moves by a dt^2 in its first step, where the exact
motion would move it by half of that. (a is the relative acceleration.) This is as if it had begun
dt / 2 earlier. So the slip begins late by a time t that is uniform between -dt / 2 and dt / 2. The
belt carries the block on by u t until then. This is the only error of first order that each slip
makes. At the end of a slip the speed over the belt is zero, so a stick that comes late by t is
wrong by a t^2 / 2 in place. Between events the scheme is of second order.

What a late start leaves behind follows from one block between neighbours at rest, an oscillator
about some place x_0. It slips from x_s with the speed u of the belt and sticks when it has the
speed u again, at 2 x_0 - x_s. If it starts late, it sticks u t less far along, and a time t later:
2 u t less far on the belt. If it starts in time and is moved by s at that instant, it sticks s less
far, on the belt too. So a move by s = 2 u t does what a start late by t does. The standard
deviation of t is dt / sqrt(12).

Noise acts through the threshold F_st. One that is larger by f lets the slip of a block between two
springs start f / 2 further on, since the spring constant is 1. So u t = f / 2 and s = f.
"""

import math


def equivalent_kick(belt_velocity: float, time_step: float) -> float:
    """Standard deviation of normal displacements that disturb slips as much as the scheme does."""
    return belt_velocity * time_step / math.sqrt(3.0)
