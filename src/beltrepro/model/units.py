"""Model units and SI (Sec. III).

The three base units are the block's mass, the spring constant and a length; time, velocity,
force and energy follow: [t] = sqrt([m]/[k]), [u] = [l]/[t], [F] = [k][l], [E] = [k][l]^2.
"""

import math
from typing import TypeVar

import numpy as np

Number = TypeVar("Number", float, np.ndarray)

MASS_KG = 0.1158
SPRING_CONSTANT_N_M = 19.8
LENGTH_M = 1.4e-3

TIME_S = math.sqrt(MASS_KG / SPRING_CONSTANT_N_M)
VELOCITY_M_S = LENGTH_M / TIME_S
FORCE_N = SPRING_CONSTANT_N_M * LENGTH_M
ENERGY_J = SPRING_CONSTANT_N_M * LENGTH_M**2

STATIC_FRICTION_N = 1.98
KINETIC_FRICTION_N = 0.89

_UNITS = {"mass": MASS_KG, "length": LENGTH_M, "time": TIME_S,
          "velocity": VELOCITY_M_S, "force": FORCE_N, "energy": ENERGY_J}  # fmt: skip


def to_si(value: Number, quantity: str) -> Number:
    """Convert a value from model units to SI."""
    return value * _UNITS[quantity]


def from_si(value: Number, quantity: str) -> Number:
    """Convert a value from SI to model units."""
    return value / _UNITS[quantity]
