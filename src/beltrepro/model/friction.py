"""Friction law of Sec. III: Coulomb friction whose threshold is drawn anew at every new place."""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from beltrepro.base.checks import rounded, shown
from beltrepro.model.parameters import ChainParameters

# Largest noise of the force with which a slip begins, over its mean, for which the integrator
# `event` is checked (docs/trust.md).
START_NOISE = 0.3


def direction_rules(
    select: Callable, compiled: Callable[[Callable], Callable] = lambda rule: rule
) -> tuple[Callable, Callable]:
    """The stick and slip rules of Sec. III and the Appendix, for NumPy and for the kernels.

    The way of a block that may slip, 0 if it does not; and the way of any block. A stuck block (way
    0), or one whose relative velocity has changed sign, slips towards F_ex if |F_ex| > F_st and
    else is stuck. Any other slipping block keeps its way. A negative threshold holds nothing: where
    F_ex is zero then, the block slips with the belt (+1).
    """

    @compiled
    def _slip_direction(external_force, threshold):
        # not copysign: a sum of forces that is zero has the one sign or the other by chance
        towards = select(external_force < 0.0, -1.0, 1.0)
        return select(abs(external_force) > threshold, towards, 0.0)

    @compiled
    def _next_direction(direction, relative_velocity, external_force, threshold):
        undecided = direction * relative_velocity <= 0.0
        return select(undecided, _slip_direction(external_force, threshold), direction)

    return _slip_direction, _next_direction


_, next_direction = direction_rules(np.where)


def start_noise(parameters: ChainParameters) -> float:
    """Noise of the force with which a slip begins, over its mean; the greatest of all blocks.

    |F_ex| = F_st there, and friction falls to f_s F_st with another F_st: the resultant has the
    mean (1 - f_s) F_st0 and the standard deviation sigma sqrt(1 + f_s^2).
    """
    ratio, mean = np.asarray(parameters.friction_ratio), np.asarray(parameters.static_friction)
    return float((parameters.noise * np.hypot(1.0, ratio) / ((1 - ratio) * mean)).max())


def noise_beyond_event(parameters: ChainParameters) -> str:
    """What is wrong with the noise of a chain that "event" is to integrate (docs/trust.md)."""
    if parameters.noise > 0 and math.isfinite(parameters.weakening_velocity):
        return (
            f"= {parameters.noise:g}: with weakening_velocity = {parameters.weakening_velocity:g} "
            "its strength depends on the velocity, which 'event' does not have; take 'verlet'"
        )
    if (share := start_noise(parameters)) <= START_NOISE:
        return ""
    return (
        f"= {parameters.noise:g}: with friction_ratio = {shown(parameters.friction_ratio)} and "
        f"static_friction = {shown(parameters.static_friction)}, method 'event' is checked up to "
        f"{rounded(parameters.noise * START_NOISE / share, up=False)}; beyond that take 'verlet'"
    )


def kinetic_friction(parameters: ChainParameters, speed: npt.ArrayLike = 0.0) -> np.ndarray:
    """Mean force (..., N) that brakes blocks which slip at |v_r| = speed over the belt."""
    speed = np.abs(speed)
    kinetic = np.asarray(parameters.friction_ratio) * np.asarray(parameters.static_friction)
    force = kinetic / (1 + speed / parameters.weakening_velocity) + parameters.viscosity * speed
    return np.broadcast_to(force, np.broadcast_shapes(speed.shape, (parameters.n_blocks,)))


def friction_fall(parameters: ChainParameters, speed: float) -> np.ndarray:
    """By how much kinetic friction falls with the speed |v_r| at a speed, of each block."""
    weak = parameters.weakening_velocity
    return kinetic_friction(parameters) / weak / (1 + speed / weak) ** 2 - parameters.viscosity


def mean_kinetic_friction(parameters: ChainParameters) -> float:
    """Mean kinetic friction of a block that hardly slips, over all blocks of a chain."""
    if parameters.varied:
        return float(kinetic_friction(parameters).mean())
    return parameters.friction_ratio * parameters.static_friction
