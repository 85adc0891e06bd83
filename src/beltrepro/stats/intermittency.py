"""Laminar phases and the region of intermittency (Figs. 16, 18 and 20)."""

from collections.abc import Mapping

import numpy as np

LAMINAR_SHARE = (0.05, 0.95)
MINIMUM_PHASES = 2  # a single escape from a transient does not count
_STUCK = 1e-9  # a smaller relative velocity is 0 but for rounding


def intermittent_mask(
    points: Mapping[str, np.ndarray],
    *,
    low: float = LAMINAR_SHARE[0],
    high: float = LAMINAR_SHARE[1],
) -> np.ndarray:
    """Which points of a scan are intermittent, by a criterion of ours: the paper gives none.

    A laminar phase is an interval longer than `laminar_time` in which the last block does not
    stick. A point is intermittent when laminar phases take between `low` and `high` of the time
    after the transient and there are at least MINIMUM_PHASES of them.
    """
    share = np.asarray(points["laminar_fraction"], dtype=float)
    count = np.asarray(points["laminar_count"])
    return (share >= low) & (share <= high) & (count >= MINIMUM_PHASES)


def last_block_phases(
    events: np.ndarray, n_blocks: int, laminar_time: float, *, start: float, stop: float
) -> np.ndarray:
    """Laminar phases between `start` and `stop`, from the events of a series."""
    of_last = events[events["block"] == n_blocks]
    begins, ends = (of_last["time"][of_last["kind"] == kind] for kind in ("slip", "stick"))
    if len(of_last) and of_last["kind"][0] == "stick":
        begins = np.append(-np.inf, begins)
    if begins.size > ends.size:
        ends = np.append(ends, np.inf)
    phases = np.column_stack([np.maximum(begins, start), np.minimum(ends, stop)])
    return phases[phases[:, 1] - phases[:, 0] > laminar_time]


def slips_of_all(
    time: np.ndarray, relative_velocities: np.ndarray, events: np.ndarray
) -> np.ndarray:
    """Intervals of a sampled series in which all blocks slip and none sticks (Fig. 5)."""
    if not len(time):
        return np.empty((0, 2))
    later = events[(events["time"] > time[0]) & (events["time"] < time[-1])]
    edges = np.concatenate([time[:1], later["time"], time[-1:]])
    stuck = np.count_nonzero(np.abs(relative_velocities[0]) <= _STUCK)
    count = stuck + np.append(0, np.cumsum(np.where(later["kind"] == "stick", 1, -1)))
    spans = np.column_stack([edges[:-1], edges[1:]])[count == 0]
    return spans[spans[:, 1] > spans[:, 0]]
