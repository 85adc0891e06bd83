"""Friction law of Sec. III: Coulomb friction whose threshold is drawn anew at every new place."""

from collections.abc import Callable

import numpy as np


def slip_direction_rule(select: Callable, copysign: Callable) -> Callable:
    """The rule for a block that may choose, for one kind of numbers.

    select, copysign : as numpy.where and numpy.copysign.

    Returns a function of external_force F_ex and threshold F_st, which gives the direction in which
    a block starts to slip: towards F_ex if |F_ex| > F_st, else 0. A negative threshold holds
    nothing: where F_ex is zero then, the sign of this zero decides.
    """

    def slip_direction(external_force, threshold):
        towards = copysign(1.0, external_force)
        return select(abs(external_force) > threshold, towards, 0.0)

    return slip_direction


def next_direction_rule(select: Callable, slip_direction: Callable) -> Callable:
    """The stick and slip rules, for one kind of numbers; see `next_direction`.

    slip_direction : from `slip_direction_rule`.
    """

    def next_direction(direction, relative_velocity, external_force, threshold):
        undecided = direction * relative_velocity <= 0.0
        return select(undecided, slip_direction(external_force, threshold), direction)

    return next_direction


_slip_direction = slip_direction_rule(np.where, np.copysign)
_next_direction = next_direction_rule(np.where, _slip_direction)


def next_direction(direction, relative_velocity, external_force, threshold):
    """Direction of slip after the stick and slip rules of Sec. III and the Appendix.

    A stuck block (direction 0) starts to slip when |F_ex| > F_st, towards F_ex. A slipping block
    whose relative velocity has changed sign sticks if |F_ex| <= F_st and otherwise slips on
    towards F_ex. Any other slipping block keeps its direction. The integrators apply the same
    rules (`beltrepro.engine.friction`).

    direction : -1, 0 (stuck) or +1; relative_velocity : v - u; external_force : F_ex;
    threshold : F_st. Arrays of one shape, model units.  Returns the new direction.
    """
    return _next_direction(np.asarray(direction), relative_velocity, external_force, threshold)


def friction_force(direction, external_force, threshold, friction_ratio):
    """Friction force on a block (Eq. 3): cancels F_ex while stuck, -direction*f_s*F_st in slip."""
    kinetic = -np.asarray(direction) * friction_ratio * threshold
    return np.where(np.asarray(direction) == 0, -np.asarray(external_force), kinetic)
