"""When a sampled motion has settled on a periodic orbit (Fig. 11)."""

from dataclasses import dataclass

import numpy as np

from beltrepro.stats.recurrence import find_recurrence

# Of the largest swing at the end: how near a state must come to that of a period before. Samples
# give a state at a crossing to less than this, and on a chaotic set states come as near now and
# then, but not all states of so many crossings.
CLOSED = 0.01
CROSSINGS = 24


@dataclass(frozen=True)
class SettledOrbit:
    """A periodic orbit on which a motion stays to its end."""

    since: float  # instant from which the motion repeats itself
    period: float  # length of a period, the unit of time


def settled_orbit(
    time: np.ndarray, positions: np.ndarray, velocities: np.ndarray
) -> SettledOrbit | None:
    """The periodic orbit on which a series ends, None if its end does not repeat itself.

    States are compared where the last block crosses its median position downwards.
    """
    if not len(time):
        return None
    end = slice(-(len(time) // 4) or None, None)
    level = np.median(positions[end, -1])
    instants, states = _crossings(time, np.hstack([positions, velocities]), positions, level)
    if len(instants) < CROSSINGS + 3:
        return None
    swing = float(np.ptp(positions[end], axis=0).max())
    found = find_recurrence(
        states, instants, closed=0.0, distance=CLOSED * swing, crossings=CROSSINGS
    )
    if found is None:
        return None
    return SettledOrbit(since=float(instants[found.since]), period=found.time)


def _crossings(
    time: np.ndarray, states: np.ndarray, positions: np.ndarray, level: float
) -> tuple[np.ndarray, np.ndarray]:
    """Instants and states where the last block falls through a level, interpolated linearly."""
    last = positions[:, -1]
    before = np.flatnonzero((last[:-1] > level) & (last[1:] <= level))
    part = (last[before] - level) / (last[before] - last[before + 1])
    instants = time[before] + part * (time[before + 1] - time[before])
    states = states[before] + part[:, np.newaxis] * (states[before + 1] - states[before])
    return instants, states
