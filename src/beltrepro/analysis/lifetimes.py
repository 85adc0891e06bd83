"""Lifetimes of chaotic transients and the attractors that follow them (inset of Fig. 12)."""

import numpy as np

from beltrepro.analysis.errors import require

# Disorder parameter that separates the attractors on which the last block slips continuously:
# between the plateau of small oscillations (0.02 in the paper) and the chaotic one (0.13).
LARGE_AMPLITUDE = 0.05

STICK_SLIP = "stick-slip"
SMALL_SLIP = "continuous slip, small amplitude"
LARGE_SLIP = "continuous slip, large amplitude"
ATTRACTORS = (STICK_SLIP, SMALL_SLIP, LARGE_SLIP)


def mean_lifetime(lifetime, escaped, duration, *, start=0.0):
    """Mean of an exponential distribution of lifetimes, by maximum likelihood with censoring.

    Parameters
    ----------
    lifetime : (M,) time of escape; the value is ignored for members that did not escape.
    escaped : (M,) bool. duration : time at which those that did not escape were given up.
    start : members that escape before are left out and time counts from here; use it to skip the
        time in which the runs have not yet spread over the saddle.

    Returns
    -------
    (tau, error) : total time under observation / number of escapes, and tau / sqrt(escapes).
    Raises NotEnoughDataError with fewer than 3 escapes.
    """
    escaped = np.asarray(escaped, dtype=bool)
    observed = np.where(escaped, np.asarray(lifetime, dtype=float), duration)
    late = observed >= start
    escapes = int(np.sum(late & escaped))
    require(escapes >= 3, f"{escapes} of {observed.size} members escaped, 3 are needed")
    tau = float(np.sum(observed[late] - start) / escapes)
    return tau, tau / np.sqrt(escapes)


def survival(lifetime, escaped, duration):
    """Share of the runs still on the saddle: (time (M,), share (M,)), in order of time."""
    escaped = np.asarray(escaped, dtype=bool)
    times = np.sort(np.where(escaped, np.asarray(lifetime, dtype=float), np.inf))
    times = times[np.isfinite(times) & (times <= duration)]
    return times, 1 - np.arange(1, times.size + 1) / escaped.size


def by_belt_velocity(runs, duration, *, start=0.0):
    """Lifetimes for each belt velocity.

    runs : a dataset of kind escapes, or its arrays. Returns a dict of arrays, one entry per
    belt velocity in rising order: belt_velocity, members, escaped (share), tau and tau_error (NaN
    where fewer than 3 members escaped), median (inf where half did not escape).
    """
    arrays = getattr(runs, "arrays", runs)
    table = {
        name: [] for name in ("belt_velocity", "members", "escaped", "tau", "tau_error", "median")
    }
    for belt_velocity in np.unique(arrays["belt_velocity"]):
        member = arrays["belt_velocity"] == belt_velocity
        lifetime, escaped = arrays["lifetime"][member], arrays["escaped"][member].astype(bool)
        try:
            tau, error = mean_lifetime(lifetime, escaped, duration, start=start)
        except ValueError:
            tau, error = np.nan, np.nan
        table["belt_velocity"].append(belt_velocity)
        table["members"].append(lifetime.size)
        table["escaped"].append(escaped.mean())
        table["tau"].append(tau)
        table["tau_error"].append(error)
        table["median"].append(np.median(np.where(escaped, lifetime, np.inf)))
    return {name: np.array(values) for name, values in table.items()}


def label_attractors(escaped, final_disorder, final_stick_rate):
    """Name the state in which each run ends.

    Criterion: "stick-slip" when the last block still sticks in the settled part of the run or the
    member did not escape (a chaotic saddle or a stick-slip attractor: a run of finite length
    cannot tell); otherwise continuous slip, of large amplitude when r there is at least
    LARGE_AMPLITUDE.

    escaped : (M,) bool; final_disorder : (M,); final_stick_rate : (M, N), last block in the last
    column.  Returns (M,) strings out of ATTRACTORS.
    """
    sticks = np.asarray(final_stick_rate)[:, -1] > 0
    slips = np.where(np.asarray(final_disorder) >= LARGE_AMPLITUDE, LARGE_SLIP, SMALL_SLIP)
    return np.where(sticks | ~np.asarray(escaped, dtype=bool), STICK_SLIP, slips)
