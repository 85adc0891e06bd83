"""The laws of friction and springs as kernels need them (Sec. III, Fig. 6).

`Law` holds what all blocks have in common. `Varied` holds the rest where blocks differ or friction
depends on the velocity; for the law of the paper kernels get None in its place and are compiled
without a trace of it.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types
from numba.extending import overload

from beltrepro.engine.simd import fma, select
from beltrepro.engine.vector import LOG2_E, exp2, inlined
from beltrepro.model import ChainParameters
from beltrepro.model.friction import direction_rules


class Law(NamedTuple):
    """The constants of the friction and spring law as the kernels read them."""

    # those of a block are NaN where blocks differ
    static_friction: float  # mean F_st
    friction_ratio: float  # f_s
    linear_limit: float  # dl_max
    compression_rate: float  # b_1
    extension_rate: float  # b_2
    compression_rate_2: float  # b / ln 2
    extension_rate_2: float
    compression_softness: float  # 1 / b, in a kernel a vector division at every step
    extension_softness: float
    rest_length: float  # a spring of this compression has no length: blocks meet


class Varied(NamedTuple):
    """Constants of the blocks and of the springs before them, and how friction varies."""

    static_friction: np.ndarray  # (N,) mean F_st
    kinetic_friction: np.ndarray  # (N,) mean f_s F_st
    noise_share: np.ndarray  # (N,) f_s over the greatest of them
    inverse_mass: np.ndarray  # (N,)
    stiffness: np.ndarray  # (N,) of the springs
    rest_length: np.ndarray  # (N,)
    weakening: float  # 1 / v_w
    viscosity: float  # eta


def of_blocks(parameters: ChainParameters) -> Varied:
    """The constants block by block, of any chain."""
    ratio = parameters.by_block("friction_ratio")
    static = parameters.by_block("static_friction")
    return Varied(
        static_friction=static,
        kinetic_friction=ratio * static,
        noise_share=ratio / max(ratio.max(), np.finfo(float).tiny),
        inverse_mass=1.0 / parameters.by_block("mass"),
        stiffness=parameters.by_block("stiffness"),
        rest_length=parameters.by_block("rest_length"),
        weakening=1.0 / parameters.weakening_velocity,
        viscosity=parameters.viscosity,
    )


def law_constants(parameters: ChainParameters) -> Law:
    """The constants of the law of a chain."""
    of_block = (parameters.static_friction, parameters.friction_ratio, parameters.rest_length)
    static, ratio, rest = (math.nan if isinstance(one, tuple) else one for one in of_block)
    return Law(
        static_friction=static,
        friction_ratio=ratio,
        linear_limit=parameters.linear_limit,
        compression_rate=parameters.compression_rate,
        extension_rate=parameters.extension_rate,
        compression_rate_2=parameters.compression_rate * LOG2_E,
        extension_rate_2=parameters.extension_rate * LOG2_E,
        compression_softness=1.0 / parameters.compression_rate,
        extension_softness=1.0 / parameters.extension_rate,
        rest_length=rest,
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
def branch_at(deformation, law):
    """Branch of the spring law: -1, 0, 1 compressed, linear, stretched (float64)."""
    if deformation > law.linear_limit:
        return 1.0
    return -1.0 if deformation < -law.linear_limit else 0.0


slip_direction, next_direction = direction_rules(select, inlined)


@inlined
def kinetic_friction(law):
    """Mean kinetic friction force of blocks that are alike."""
    return law.static_friction * law.friction_ratio


def braking(law, varied, block, speed):
    """Mean force that brakes a block which slips at |v_r| = speed (float64 or a vector)."""


# chosen by the type of `varied`: the one gives a number, the other a vector where speed is one
@overload(braking, jit_options={"forceinline": True, "error_model": "numpy"})
def _overload_braking(law, varied, block, speed):
    def _alike(law, varied, block, speed):
        return kinetic_friction(law)

    def _varied(law, varied, block, speed):
        dry = varied.kinetic_friction[block] / (1.0 + varied.weakening * speed)
        return dry + varied.viscosity * speed

    return _alike if isinstance(varied, types.NoneType) else _varied


@inlined
def mean_threshold(law, varied, block):
    """Mean static friction of a block."""
    if varied is None:
        return law.static_friction
    return varied.static_friction[block]


@inlined
def inverse_mass(varied, block):
    """1 / m of a block."""
    return 1.0 if varied is None else varied.inverse_mass[block]


@inlined
def stiffness(varied, spring):
    """Factor of the tension of a spring."""
    return 1.0 if varied is None else varied.stiffness[spring]


@inlined
def rest_length(law, varied, spring):
    """Undeformed length of a spring."""
    return law.rest_length if varied is None else varied.rest_length[spring]


@inlined
def noise_share(varied, block):
    """Strength of the noise of a block, over that of the noisiest."""
    return 1.0 if varied is None else varied.noise_share[block]


@inlined
def pull_and_slope(spring, deformation, law, varied):
    """Tension of a spring and its derivative."""
    pull, slope, _, _ = expand_spring(deformation, law)
    return pull * stiffness(varied, spring), slope * stiffness(varied, spring)


@inlined
def spring_energy(spring, deformation, law, varied):
    """Potential energy of a spring (float64)."""
    size = abs(deformation)
    limit = law.linear_limit
    if size <= limit:
        energy = 0.5 * size * size
    else:
        rate = law.extension_rate if deformation > 0.0 else law.compression_rate
        excess = size - limit
        beyond = (math.expm1(rate * excess) / rate - excess) / rate
        energy = limit * (0.5 * limit + excess) + beyond
    return energy * stiffness(varied, spring)
