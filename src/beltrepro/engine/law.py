"""The spring law as vector code (Sec. III, Fig. 6)."""

import numpy as np

from beltrepro.engine.simd import fma, select
from beltrepro.engine.vector import LOG2_E, exp2, inlined
from beltrepro.model import ChainParameters

# Columns of the array that carries the constants of the law into the kernels.
STATIC_FRICTION, FRICTION_RATIO, LINEAR_LIMIT, COMPRESSION_RATE, EXTENSION_RATE = range(5)
COMPRESSION_RATE_2, EXTENSION_RATE_2, COMPRESSION_SOFTNESS, EXTENSION_SOFTNESS = range(5, 9)


def law_constants(parameters: ChainParameters) -> np.ndarray:
    """The constants of the friction and spring law as the kernels read them, (9,).

    Beside the parameters: the rates for base-2 exponentials, and 1/b. Computed in a kernel, 1/b
    would become a vector division at every step.
    """
    return np.array(
        [
            parameters.static_friction,
            parameters.friction_ratio,
            parameters.linear_limit,
            parameters.compression_rate,
            parameters.extension_rate,
            parameters.compression_rate * LOG2_E,
            parameters.extension_rate * LOG2_E,
            1.0 / parameters.compression_rate,
            1.0 / parameters.extension_rate,
        ]
    )


@inlined
def spring_law(constants):
    """The constants that `tension_and_slope` needs, as local scalars.

    Read inside the loop over chains, a choice between two of them would become a vector gather.
    """
    return (
        constants[LINEAR_LIMIT],
        constants[COMPRESSION_RATE_2],
        constants[EXTENSION_RATE_2],
        constants[COMPRESSION_SOFTNESS],
        constants[EXTENSION_SOFTNESS],
    )


@inlined
def tension_and_slope(deformation, law):
    """-F_e(dl), its derivative, and the part of dl beyond the linear branch (0 on it).

    For a float64 or a vector of them; the derivative grows exponentially with the third value.
    """
    limit, compression_rate, extension_rate, compression_softness, extension_softness = law
    linear = select(deformation > limit, limit, deformation)
    linear = select(linear < -limit, -limit, linear)
    excess = deformation - linear
    compressed = deformation < 0.0
    rate = select(compressed, -compression_rate, extension_rate)
    softness = select(compressed, -compression_softness, extension_softness)
    slope = exp2(excess, rate)
    return fma(softness, slope - 1.0, linear), slope, excess


@inlined
def tension(deformation, law):
    """-F_e(dl): the force with which a spring pulls, for a float64 or a vector of them."""
    pull, _, _ = tension_and_slope(deformation, law)
    return pull
