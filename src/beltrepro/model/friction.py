"""Friction law of Sec. III: Coulomb friction whose threshold is drawn anew at every new place."""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from beltrepro.base.checks import shown
from beltrepro.model.parameters import ChainParameters

# Largest noise of the force with which a slip begins, over its mean, for which the integrator
# `event` is checked (docs/trust.md).
START_NOISE = 0.3


def direction_rules(
    select: Callable, compiled: Callable[[Callable], Callable] = lambda rule: rule
) -> tuple[Callable, Callable]:
    """The stick and slip rules, written once for NumPy arrays and for the vectors of the kernels.

    The first: the way of a block that may slip, towards F_ex if |F_ex| > F_st, else 0. The second:
    as `next_direction`.
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


_, _next_direction = direction_rules(np.where)


def next_direction(
    direction: npt.ArrayLike,
    relative_velocity: npt.ArrayLike,
    external_force: npt.ArrayLike,
    threshold: npt.ArrayLike,
) -> np.ndarray:
    """Direction of slip after the stick and slip rules of Sec. III and the Appendix.

    A stuck block (direction 0) starts to slip when |F_ex| > F_st, towards F_ex. A slipping block
    whose relative velocity has changed sign sticks if |F_ex| <= F_st and otherwise slips on
    towards F_ex. Any other slipping block keeps its direction. A negative threshold holds nothing:
    where F_ex is zero then, the block slips with the belt (+1). Arrays of one shape, model units.

    The integrators apply the same rules (`beltrepro.engine.law`).
    """
    return _next_direction(
        np.asarray(direction), np.asarray(relative_velocity), np.asarray(external_force), threshold
    )


def start_noise(parameters: ChainParameters) -> float:
    """Noise of the force with which a slip begins, as a share of its mean.

    A slip begins where |F_ex| = F_st, and friction falls to f_s F_st with another F_st. The
    resultant has the mean (1 - f_s) F_st0 and the standard deviation sigma sqrt(1 + f_s^2). Of
    blocks that differ the greatest counts.
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
    share = start_noise(parameters)
    if share <= START_NOISE:
        return ""
    return (
        f"= {parameters.noise:g}: with friction_ratio = {shown(parameters.friction_ratio)} and "
        f"static_friction = {shown(parameters.static_friction)}, method 'event' is checked up to "
        f"{parameters.noise * START_NOISE / share:.3g}; beyond that take 'verlet'"
    )


def kinetic_friction(parameters: ChainParameters, speed: npt.ArrayLike = 0.0) -> np.ndarray:
    """Mean force (..., N) that brakes blocks which slip at |v_r| = speed over the belt."""
    speed = np.abs(speed)
    falling = np.asarray(parameters.friction_ratio) * np.asarray(parameters.static_friction)
    dry = falling / (1 + speed / parameters.weakening_velocity)
    return np.broadcast_to(
        dry + parameters.viscosity * speed,
        np.broadcast_shapes(speed.shape, (parameters.n_blocks,)),
    )


def mean_kinetic_friction(parameters: ChainParameters) -> float:
    """Mean kinetic friction of a block that hardly slips, over all blocks of a chain."""
    if parameters.varied:
        return float(kinetic_friction(parameters).mean())
    return parameters.friction_ratio * parameters.static_friction


def equivalent_displacement(belt_velocity: float, time_step: float) -> float:
    """Standard deviation of normal displacements that disturb slips as much as the scheme does.

    The scheme looks for events once in a step dt, so a slip begins late by a time between 0 and dt.
    In its first step the block moves by a dt^2 instead of half of that, as if it had begun dt / 2
    earlier. So it begins late by a time t that is uniform between -dt / 2 and dt / 2, with the
    standard deviation dt / sqrt(12). This is the only error of first order that each slip makes: a
    stick that comes late by t is wrong by a t^2 / 2 in place.

    What a late start leaves behind follows from one block between neighbours at rest, an oscillator
    about some place x_0. It slips from x_s with the speed u of the belt and sticks when it has the
    speed u again, at 2 x_0 - x_s. If it starts late by t, it sticks u t less far along, and t
    later: 2 u t less far on the belt. If it is moved by s as it starts, it sticks s less far. So
    s = 2 u t. A threshold that is larger by f lets the slip start f / 2 further on: u t = f / 2 and
    s = f.
    """
    return belt_velocity * time_step / math.sqrt(3.0)
