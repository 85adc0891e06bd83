"""How much the paper's scheme disturbs each slip, in terms of a displacement.

The scheme looks for events once in a step dt, so a slip begins late by a time between 0 and dt. In
its first step the block moves by a dt^2 instead of half of that, as if it had begun dt / 2 earlier.
So it begins late by a time t that is uniform between -dt / 2 and dt / 2, with the standard
deviation dt / sqrt(12). This is the only error of first order that each slip makes: a stick that
comes late by t is wrong by a t^2 / 2 in place.

What a late start leaves behind follows from one block between neighbours at rest, an oscillator
about some place x_0. It slips from x_s with the speed u of the belt and sticks when it has the
speed u again, at 2 x_0 - x_s. If it starts late by t, it sticks u t less far along, and t later:
2 u t less far on the belt. If it is moved by s as it starts, it sticks s less far. So s = 2 u t.
A threshold that is larger by f lets the slip start f / 2 further on: u t = f / 2 and s = f.
"""

import math


def equivalent_displacement(belt_velocity: float, time_step: float) -> float:
    """Standard deviation of normal displacements that disturb slips as much as the scheme does."""
    return belt_velocity * time_step / math.sqrt(3.0)
