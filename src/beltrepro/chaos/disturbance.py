"""How much each slip of a run is disturbed, and how far that scatters a periodic motion."""

import math

from beltrepro.engine.kicks import equivalent_kick
from beltrepro.simulation.points import Point

# Distance between a disturbed state and that a period earlier, in units of the disturbance. On the
# periodic orbits of five blocks the largest of some hundred is 10 to 60, while states of irregular
# motion that belong to no orbit are 70 model lengths and more apart.
SCATTER = 100.0
# No more than this share of F_st, which stretches a spring by about the size of the motion. What
# scatters more is not near any orbit.
WIDEST = 0.15


def disturbance(point: Point) -> float:
    """Standard deviation of kicks that disturb each slip as much as it is disturbed.

    By kicks as they are. By the steps of "verlet" as `engine.kicks.equivalent_kick` says. By noise
    through the threshold: one that is larger by f lets a slip start f / 2 further on, since two
    springs pull, and that does what a kick of f does (spring constant 1).

    Parameters
    ----------
    point : Point
        A chain, and by what means it is simulated.

    Returns
    -------
    float
        Model length; 0 for the exact motion.
    """
    chain = point.parameters
    steps = equivalent_kick(chain.belt_velocity, point.time_step) * (point.method == "verlet")
    return math.hypot(steps, point.kick, chain.noise)


def scatter(point: Point) -> float:
    """Distance at which two states of a disturbed motion count as one.

    Parameters
    ----------
    point : Point
        A chain, and by what means it is simulated.

    Returns
    -------
    float
        Model length; 0 for the exact motion.
    """
    widest = WIDEST * point.parameters.static_friction
    return min(SCATTER * disturbance(point), widest)
