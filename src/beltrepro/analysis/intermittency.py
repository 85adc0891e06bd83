"""Laminar phases and the region of intermittency (Figs. 16, 18 and 20)."""

from itertools import pairwise

import numpy as np

LAMINAR_SHARE = (0.05, 0.95)
MINIMUM_PHASES = 2


def intermittent_mask(
    points, *, low=LAMINAR_SHARE[0], high=LAMINAR_SHARE[1], minimum_phases=MINIMUM_PHASES
):
    """Which points of a scan are intermittent: the paper gives no criterion, this one is ours.

    A laminar phase is an interval longer than `laminar_time` in which the last block does not
    stick. A point is intermittent when laminar phases take between `low` and `high` of the time
    after the transient and there are at least `minimum_phases` of them (so that a single escape
    from a transient does not count).

    points : arrays with laminar_fraction and laminar_count, one shape.  Returns a bool array.
    """
    share = np.asarray(points["laminar_fraction"], dtype=float)
    count = np.asarray(points["laminar_count"])
    return (share >= low) & (share <= high) & (count >= minimum_phases)


def boundary(belt_velocity, noise, mask):
    """Edges in u of the intermittent region for each noise level.

    The region at one noise level is the longest run of intermittent points along u; single points
    in between that are not do not break it. A run of one point has two equal edges.

    Parameters
    ----------
    belt_velocity, noise, mask : (P,) points of a scan in any order; replicates of a point count
        as intermittent when at least half of them are.

    Returns
    -------
    levels, u_low, u_high : (S,) noise levels in rising order and the edges, NaN without a region.
    """
    levels = np.unique(noise)
    edges = np.full((2, levels.size), np.nan)
    for index, level in enumerate(levels):
        row = noise == level
        velocities, place = np.unique(belt_velocity[row], return_inverse=True)
        share = np.bincount(place, np.asarray(mask)[row].astype(float)) / np.bincount(place)
        inside = np.flatnonzero(share >= 0.5)
        if inside.size:
            runs = np.split(inside, np.flatnonzero(np.diff(inside) > 2) + 1)
            longest = max(runs, key=len)
            edges[:, index] = velocities[longest[0]], velocities[longest[-1]]
    return levels, edges[0], edges[1]


def laminar_phases(slip_start, slip_stop, laminar_time, *, start, stop):
    """Intervals longer than `laminar_time` without a stick, between `start` and `stop`.

    slip_start, slip_stop : (S,) instants at which slips of the last block begin and end, in order;
    a slip under way at the end of the run may lack its stop, and one under way at the start its
    start. Intervals are cut at start and stop.  Returns (L, 2) begin and end.
    """
    slip_start = np.asarray(slip_start, dtype=float)
    slip_stop = np.asarray(slip_stop, dtype=float)
    if slip_stop.size and (not slip_start.size or slip_stop[0] < slip_start[0]):
        slip_start = np.concatenate([[-np.inf], slip_start])
    if slip_start.size > slip_stop.size:
        slip_stop = np.concatenate([slip_stop, [np.inf]])
    phases = np.column_stack([np.maximum(slip_start, start), np.minimum(slip_stop, stop)])
    return phases[phases[:, 1] - phases[:, 0] > laminar_time]


def sampled_laminar_phases(time, relative_velocity, laminar_time, *, tolerance=1e-6):
    """Laminar phases of a sampled series: intervals in which no sample of the last block sticks.

    time, relative_velocity : (T,) samples of v_rN, which vanishes while the block sticks (within
    `tolerance`). Sticks shorter than the sample interval are missed: prefer `laminar_phases` where
    events are at hand.  Returns (L, 2) begin and end.
    """
    time = np.asarray(time, dtype=float)
    slipping = np.abs(relative_velocity) > tolerance
    change = np.flatnonzero(np.diff(slipping.astype(np.int8))) + 1
    edges = np.concatenate([[0], change, [time.size]])
    begins = [(a, b) for a, b in pairwise(edges) if slipping[a]]
    phases = np.array([(time[a], time[b - 1]) for a, b in begins]).reshape(-1, 2)
    return phases[phases[:, 1] - phases[:, 0] > laminar_time]
