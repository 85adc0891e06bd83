"""Friction law of Sec. III: Coulomb friction whose threshold is drawn anew at every new place."""

import numpy as np
import numpy.typing as npt


def next_direction(
    direction: npt.ArrayLike,
    relative_velocity: npt.ArrayLike,
    external_force: npt.ArrayLike,
    threshold: npt.ArrayLike,
) -> np.ndarray:
    """Direction of slip after the stick and slip rules of Sec. III and the Appendix.

    A stuck block (direction 0) starts to slip when |F_ex| > F_st, towards F_ex. A slipping block
    whose relative velocity has changed sign sticks if |F_ex| <= F_st and otherwise slips on
    towards F_ex. Any other slipping block keeps its direction. Arrays of one shape, model units.

    Parameters
    ----------
    direction : array
        Direction of slip before: -1, 0 (stuck) or +1.
    relative_velocity : array
        Velocity of the block relative to the belt, v - u.
    external_force : array
        Resultant F_ex of the spring forces on the block.
    threshold : array
        Static friction F_st at the place of the block.

    Returns
    -------
    array
        Direction of slip after: -1.0, 0.0 or +1.0.
    """
    free = np.where(np.abs(external_force) > threshold, np.sign(external_force), 0.0)
    undecided = np.asarray(direction) * relative_velocity <= 0
    return np.where(undecided, free, direction)


def friction_force(
    direction: npt.ArrayLike,
    external_force: npt.ArrayLike,
    threshold: npt.ArrayLike,
    friction_ratio: float,
) -> np.ndarray:
    """Friction force on a block (Eq. 3): cancels F_ex while stuck, -direction*f_s*F_st in slip.

    Arrays of one shape, model units.

    Parameters
    ----------
    direction : array
        Direction of slip: -1, 0 (stuck) or +1.
    external_force : array
        Resultant F_ex of the spring forces on the block.
    threshold : array or float
        Static friction F_st at the place of the block.
    friction_ratio : float
        Kinetic over static friction, f_s.

    Returns
    -------
    array
        Friction force.
    """
    kinetic = -np.asarray(direction) * friction_ratio * np.asarray(threshold)
    return np.where(np.asarray(direction) == 0, -np.asarray(external_force), kinetic)
