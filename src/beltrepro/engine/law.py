"""The spring law as vector code (Sec. III, Fig. 6)."""

from typing import NamedTuple

from beltrepro.engine.simd import fma, select
from beltrepro.engine.vector import LOG2_E, exp2, inlined
from beltrepro.model import ChainParameters


class Law(NamedTuple):
    """The constants of the friction and spring law as the kernels read them.

    Beside the parameters: the rates for base-2 exponentials, and 1/b. Computed in a kernel, 1/b
    would become a vector division at every step.
    """

    static_friction: float  # mean F_st
    friction_ratio: float  # f_s
    linear_limit: float  # dl_max
    compression_rate: float  # b_1
    extension_rate: float  # b_2
    compression_rate_2: float  # b / ln 2
    extension_rate_2: float
    compression_softness: float  # 1 / b
    extension_softness: float


def law_constants(parameters: ChainParameters) -> Law:
    """The constants of the law of a chain."""
    return Law(
        static_friction=parameters.static_friction,
        friction_ratio=parameters.friction_ratio,
        linear_limit=parameters.linear_limit,
        compression_rate=parameters.compression_rate,
        extension_rate=parameters.extension_rate,
        compression_rate_2=parameters.compression_rate * LOG2_E,
        extension_rate_2=parameters.extension_rate * LOG2_E,
        compression_softness=1.0 / parameters.compression_rate,
        extension_softness=1.0 / parameters.extension_rate,
    )


@inlined
def kinetic_friction(law):
    """Mean kinetic friction force."""
    return law.static_friction * law.friction_ratio


@inlined
def tension_and_slope(deformation, law):
    """-F_e(dl), its derivative, and the part of dl beyond the linear branch (0 on it).

    For a float64 or a vector of them; the derivative grows exponentially with the third value.
    """
    limit = law.linear_limit
    linear = select(deformation > limit, limit, deformation)
    linear = select(linear < -limit, -limit, linear)
    excess = deformation - linear
    compressed = deformation < 0.0
    rate = select(compressed, -law.compression_rate_2, law.extension_rate_2)
    softness = select(compressed, -law.compression_softness, law.extension_softness)
    slope = exp2(excess, rate)
    return fma(softness, slope - 1.0, linear), slope, excess


@inlined
def tension(deformation, law):
    """-F_e(dl): the force with which a spring pulls, for a float64 or a vector of them."""
    pull, _, _ = tension_and_slope(deformation, law)
    return pull
