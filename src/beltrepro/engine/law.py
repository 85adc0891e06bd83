"""The spring law as vector code (Sec. III, Fig. 6)."""

import numpy as np

from beltrepro.engine.vector import LOG2_E, copysign, exp2, fma, inlined
from beltrepro.model import ChainParameters

# Columns of the array that carries the constants of the law into the kernels.
STATIC_FRICTION, FRICTION_RATIO, LINEAR_LIMIT, COMPRESSION_RATE, EXTENSION_RATE = range(5)


def law_constants(parameters: ChainParameters) -> np.ndarray:
    """The constants of the friction and spring law as the kernels read them, (5,)."""
    return np.array(
        [
            parameters.static_friction,
            parameters.friction_ratio,
            parameters.linear_limit,
            parameters.compression_rate,
            parameters.extension_rate,
        ]
    )


@inlined
def tension(deformation, limit, compression_rate, extension_rate):
    """-F_e(dl) of one spring: the force with which it pulls, without branches."""
    size = abs(deformation)
    excess = size - limit
    excess = excess if excess > 0.0 else 0.0
    rate = compression_rate if deformation < 0.0 else extension_rate
    softness = 1.0 / compression_rate if deformation < 0.0 else 1.0 / extension_rate
    growth = exp2(excess * (rate * LOG2_E)) - 1.0
    return copysign(fma(softness, growth, size - excess), deformation)
