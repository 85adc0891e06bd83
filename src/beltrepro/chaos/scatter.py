"""How much each slip of a run is disturbed, and how far that scatters a periodic motion."""

import math

from beltrepro.model.scheme_error import equivalent_kick
from beltrepro.simulation.setup import Case

# Distances between a disturbed state and that a period earlier, in units of the disturbance. On
# orbits of 9, 631, 2052, 8089 and 8924 slips they reach 7, 300, 5000, 50000 and 8 millions.
SCATTERS = (1e2, 1e3, 1e4, 1e5, 1e6, 1e7)
# No more than this share of F_st, which stretches a spring by about the size of the motion. An
# orbit is lost before it scatters so much. Other irregular states differ by about F_st.
WIDEST = 0.15


def disturbance(case: Case) -> float:
    """Standard deviation of kicks that disturb each slip as much as it is disturbed.

    By kicks as they are, by the steps of "verlet" and by the thresholds under noise as
    `beltrepro.model.scheme_error` says. What the noise does during a slip is left out: it is less
    by a factor of about sqrt(dt).
    """
    chain = case.parameters
    steps = equivalent_kick(chain.belt_velocity, case.time_step) * (case.method == "verlet")
    return math.hypot(steps, case.kick, chain.noise)


def scatters(case: Case) -> tuple[float, ...]:
    """Distances at which two states of a disturbed motion may count as one."""
    size = disturbance(case)
    widest = WIDEST * case.parameters.static_friction
    return tuple(sorted({min(scatter * size, widest) for scatter in SCATTERS})) if size else ()
