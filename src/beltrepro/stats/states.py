"""Laminar phases, and names for the long-time state of each point of a scan (Figs. 12 to 22)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats import sections

CONTINUOUS = "continuous slip"
PERIODIC = "periodic stick-slip"
INTERMITTENT = "intermittent"
CHAOTIC = "chaotic"
QUASI_PERIODIC = "quasi-periodic stick-slip"
TRANSIENT = "transient"
UNDECIDED = "undecided"

# of the 0-1 test
CHAOS = 0.8
REGULAR = 0.2

LAMINAR_SHARE = (0.05, 0.95)
MINIMUM_PHASES = 2  # a single escape from a transient does not count
_STUCK = 1e-9  # a smaller relative velocity is 0 but for rounding


# --- laminar phases -------------------------------------------------------------------------------


def intermittent_mask(
    points: Mapping[str, np.ndarray], limits: tuple[float, float] = LAMINAR_SHARE
) -> np.ndarray:
    """Which points of a scan are intermittent, by a criterion of ours: the paper gives none.

    A laminar phase is an interval longer than `laminar_time` in which the last block does not
    stick. A point is intermittent when laminar phases take a share of the time after the transient
    within the limits and there are at least MINIMUM_PHASES of them.
    """
    (low, high), share = limits, points["laminar_fraction"]
    return (share >= low) & (share <= high) & (points["laminar_count"] >= MINIMUM_PHASES)


def laminar_phases(series: Any, laminar_time: float) -> np.ndarray:
    """Begin and end (L, 2) of the laminar phases of a series after its transient."""
    about, events = series.attributes, series.arrays["events"]
    events = events[events["block"] == about["n_blocks"]]
    begins, ends = (events["time"][events["kind"] == kind] for kind in ("slip", "stick"))
    # without an event the last block rides on the belt for good, or slips for good
    velocity = series.arrays["velocities"][:, -1]
    slips = np.any(velocity != about["belt_velocity"])
    if slips and not np.array_equal(events["kind"][:1], ["slip"]):
        begins = np.append(-np.inf, begins)
    if begins.size > ends.size:
        ends = np.append(ends, np.inf)
    start, stop = about["transient"], about["duration"]
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


# --- states ---------------------------------------------------------------------------------------


def label_states(
    points: Mapping[str, np.ndarray], *, transient: float, duration: float
) -> np.ndarray:
    """State of every point of a scan, from what was recorded after the transient.

    Criteria, in this order; N is the last block:
    - "undecided": N neither sticks in the last half of the time after the transient nor slips
      longer than `laminar_time` after it: it may ride on the belt;
    - "transient": N stuck after the transient, but not in the last half of the time after it: the
      run leaves a chaotic transient while it is measured;
    - "continuous slip": N never sticks after the transient;
    - "intermittent": `intermittent_mask`;
    - "periodic stick-slip": the section velocities repeat (`sections.find_period`);
    - "chaotic" or "quasi-periodic stick-slip": they do not, and the 0-1 test gives K > 0.8 or
      K < 0.2 (`sections.zero_one_test`);
    - "undecided": K in between, or too few crossings of the section.
    """
    last_stick = np.nan_to_num(points["last_stick_time"], nan=-1.0)
    settles = last_stick < transient + 0.5 * (duration - transient)
    rides = settles & ~(points["laminar_fraction"] > 0)
    states = np.select(
        [rides, last_stick <= transient, settles, intermittent_mask(points)],
        [UNDECIDED, CONTINUOUS, TRANSIENT, INTERMITTENT],
        "",
    ).astype(object)
    for index in np.flatnonzero(states == ""):
        states[index] = _stick_slip(points["section_velocity"][index])
    return states.astype(str)


def _stick_slip(velocities: np.ndarray) -> str:
    try:
        if sections.find_period(velocities):
            return PERIODIC
        chaos = sections.zero_one_test(velocities)
    except NotEnoughDataError:
        return UNDECIDED
    if chaos > CHAOS:
        return CHAOTIC
    return QUASI_PERIODIC if chaos < REGULAR else UNDECIDED


# --- of runs that were followed until the last block slips for good ------------------------------

# Disorder parameter that separates the attractors on which the last block slips continuously:
# between the plateau of small oscillations (0.02 in the paper) and the chaotic one (0.13).
LARGE_AMPLITUDE = 0.05
STICK_SLIP = "stick-slip"
SMALL_SLIP = "continuous slip, small amplitude"
LARGE_SLIP = "continuous slip, large amplitude"
ATTRACTORS = (STICK_SLIP, SMALL_SLIP, LARGE_SLIP)


def label_ends(runs: Mapping[str, np.ndarray]) -> np.ndarray:
    """The state in which each run of kind escapes ends, one of ATTRACTORS.

    Criterion: "stick-slip" when the last block still sticks in the settled part of the run or the
    run did not escape (a chaotic saddle or a stick-slip attractor: a run of finite length cannot
    tell); otherwise continuous slip, of large amplitude when r there is at least LARGE_AMPLITUDE.
    """
    rates = np.asarray(runs["final_stick_rate"], dtype=float)
    last = np.isfinite(rates).sum(axis=1) - 1  # shorter chains are padded
    sticks = rates[np.arange(len(rates)), last] > 0
    slips = np.where(runs["final_disorder"] >= LARGE_AMPLITUDE, LARGE_SLIP, SMALL_SLIP)
    return np.where(sticks | ~runs["escaped"].astype(bool), STICK_SLIP, slips)
