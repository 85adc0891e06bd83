"""Share of time in laminar phases, from the cycles of one long run."""

import numpy as np
import scipy

from beltrepro.stats.errors import require
from beltrepro.stats.estimates import CONFIDENCE, Estimate

LEAST_CYCLES = 5


def share_of_time(phases: np.ndarray) -> Estimate:
    """Share of the time in phases, where these and the times between them are independent.

    A cycle is a phase and the time until the next one begins. A run of chaotic motion under noise
    forgets its past within a cycle, so that cycles are independent of each other and stand for
    independent runs (regenerative method: M. A. Crane and A. J. Lemoine, An Introduction to the
    Regenerative Method for Simulation Analysis, 1977). The interval is that of Student's t for the
    logarithm of the odds, so that it stays between 0 and 1.

    phases : array (L, 2), begin and end of each phase, in order. What is before the first of them
    and after the beginning of the last one belongs to no whole cycle and is left out.
    """
    inside = np.diff(phases[:-1], axis=1)[:, 0]
    between = phases[1:, 0] - phases[:-1, 1]
    cycles = inside.size
    require(cycles >= LEAST_CYCLES, f"{cycles} whole cycles, {LEAST_CYCLES} are needed")
    odds = inside.mean() / between.mean()
    scatter = inside / inside.mean() - between / between.mean()
    error = scatter.std(ddof=1) / np.sqrt(cycles)
    reach = float(scipy.stats.t.ppf((1 + CONFIDENCE) / 2, cycles - 1)) * error
    value, low, high = (float(scipy.special.expit(np.log(odds) + x)) for x in (0.0, -reach, reach))
    return Estimate(value, low, high, cycles)
