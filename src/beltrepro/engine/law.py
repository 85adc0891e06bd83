"""The spring law as kernels need it (Sec. III, Fig. 6)."""

import math
from typing import NamedTuple

from beltrepro.engine.simd import fma, select
from beltrepro.engine.vector import LOG2_E, exp2, inlined
from beltrepro.model import ChainParameters
from beltrepro.model.friction import next_direction_rule, slip_direction_rule


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
    rest_length: float  # a spring of this compression has no length: blocks meet


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
        rest_length=parameters.rest_length,
    )


@inlined
def curved_branch(excess, compressed, law):
    """Slope, rate c and 1/c of a spring that is deformed by `excess` beyond its linear branch.

    The tension is softness (slope - 1) more than at the end of the linear branch, where the slope
    is 1, and every derivative is `rate` times the one before. For a float64 or a vector of them.
    """
    rate = select(compressed, -law.compression_rate, law.extension_rate)
    rate_2 = select(compressed, -law.compression_rate_2, law.extension_rate_2)
    softness = select(compressed, -law.compression_softness, law.extension_softness)
    return exp2(excess, rate_2), rate, softness


@inlined
def expand_spring(deformation, law):
    """-F_e(dl), its derivative, and rate c and 1/c of the branch there; c = 0 if it is linear."""
    limit = law.linear_limit
    linear = select(deformation > limit, limit, deformation)
    linear = select(linear < -limit, -limit, linear)
    excess = deformation - linear
    slope, rate, softness = curved_branch(excess, deformation < 0.0, law)
    pull = fma(softness, slope - 1.0, linear)
    return pull, slope, select(excess == 0.0, 0.0, rate), softness


@inlined
def tension(deformation, law):
    """-F_e(dl): the force with which a spring pulls, for a float64 or a vector of them."""
    pull, _, _, _ = expand_spring(deformation, law)
    return pull


@inlined
def extension(tension, law):
    """Deformation at which a spring pulls with the given tension (float64)."""
    size = abs(tension)
    limit = law.linear_limit
    if size <= limit:
        return tension
    rate = law.extension_rate if tension > 0.0 else law.compression_rate
    return math.copysign(limit + math.log1p(rate * (size - limit)) / rate, tension)


@inlined
def stored_energy(deformation, law):
    """Potential energy of a spring (float64)."""
    size = abs(deformation)
    limit = law.linear_limit
    if size <= limit:
        return 0.5 * size * size
    rate = law.extension_rate if deformation > 0.0 else law.compression_rate
    excess = size - limit
    return limit * (0.5 * limit + excess) + (math.expm1(rate * excess) / rate - excess) / rate


@inlined
def branch_at(deformation, law):
    """Branch of the spring law: -1, 0, 1 compressed, linear, stretched (float64)."""
    if deformation > law.linear_limit:
        return 1.0
    return -1.0 if deformation < -law.linear_limit else 0.0


slip_direction = inlined(slip_direction_rule(select))
next_direction = inlined(next_direction_rule(select, slip_direction))


@inlined
def kinetic_friction(law):
    """Mean kinetic friction force."""
    return law.static_friction * law.friction_ratio
