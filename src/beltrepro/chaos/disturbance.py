"""How much each slip of a run is disturbed, and how far that scatters a periodic motion."""

import math

from beltrepro.model.disturbance import equivalent_kick
from beltrepro.simulation.points import Point

# Distance between a disturbed state and that a period earlier, in units of the disturbance. On the
# periodic orbits of five blocks the largest of some hundred is 10 to 60, and above 100 on the long
# ones. States of irregular motion that belong to no orbit are 70 model lengths and more apart.
SCATTER = 500.0
# No more than this share of F_st, which stretches a spring by about the size of the motion. What
# scatters more is not near any orbit.
WIDEST = 0.15


def disturbance(point: Point) -> float:
    """Standard deviation of kicks that disturb each slip as much as it is disturbed.

    By kicks as they are, by the steps of "verlet" and by the thresholds under noise as
    `beltrepro.model.disturbance` says. What the noise does during a slip is left out: it is less by
    a factor of about sqrt(dt).

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
