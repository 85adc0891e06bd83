"""Friction law of Sec. III: Coulomb friction whose threshold is drawn anew at every new place."""

import numpy as np


def next_direction(direction, relative_velocity, external_force, threshold):
    """Direction of slip after the stick and slip rules of Sec. III and the Appendix.

    A stuck block (direction 0) starts to slip when |F_ex| > F_st, towards F_ex. A slipping block
    whose relative velocity has changed sign sticks if |F_ex| <= F_st and otherwise slips on
    towards F_ex. Any other slipping block keeps its direction.

    direction : -1, 0 (stuck) or +1; relative_velocity : v - u; external_force : F_ex;
    threshold : F_st. Arrays of one shape, model units.  Returns the new direction.
    """
    free = np.where(np.abs(external_force) > threshold, np.sign(external_force), 0.0)
    undecided = np.asarray(direction) * relative_velocity <= 0
    return np.where(undecided, free, direction)


def friction_force(direction, external_force, threshold, friction_ratio):
    """Friction force on a block (Eq. 3): cancels F_ex while stuck, -direction*f_s*F_st in slip."""
    kinetic = -np.asarray(direction) * friction_ratio * threshold
    return np.where(np.asarray(direction) == 0, -np.asarray(external_force), kinetic)
