"""Lifetimes of chaotic transients and the attractors that follow them (inset of Fig. 12)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from beltrepro.stats.errors import NotEnoughDataError
from beltrepro.stats.survival import MINIMUM_ENDS, mean_lifetime

# Disorder parameter that separates the attractors on which the last block slips continuously:
# between the plateau of small oscillations (0.02 in the paper) and the chaotic one (0.13).
LARGE_AMPLITUDE = 0.05
# Runs on one orbit have the same range of x_N, up to where the samples lie, and as many sticks in
# the settled part, give or take the ends. Chaotic runs agree so closely by chance in pairs at most.
SAME_RANGE = 1e-3
COMPANIONS = 2

STICK_SLIP = "stick-slip"
SMALL_SLIP = "continuous slip, small amplitude"
LARGE_SLIP = "continuous slip, large amplitude"
ATTRACTORS = (STICK_SLIP, SMALL_SLIP, LARGE_SLIP)


def by_belt_velocity(runs: Any, duration: float, *, start: float = 0.0) -> dict[str, np.ndarray]:
    """Lifetimes for each belt velocity."""
    arrays = getattr(runs, "arrays", runs)
    names = ("belt_velocity", "members", "escaped", "tau", "tau_error", "tau_lower", "median")
    table: dict[str, list] = {name: [] for name in names}
    for belt_velocity in np.unique(arrays["belt_velocity"]):
        run = arrays["belt_velocity"] == belt_velocity
        lifetime, escaped = arrays["lifetime"][run], arrays["escaped"][run].astype(bool)
        tau, error, lower = _tau(np.where(escaped, lifetime, duration), escaped, start)
        table["belt_velocity"].append(belt_velocity)
        table["members"].append(lifetime.size)
        table["escaped"].append(escaped.mean())
        table["tau"].append(tau)
        table["tau_error"].append(error)
        table["tau_lower"].append(lower)
        table["median"].append(np.median(np.where(escaped, lifetime, np.inf)))
    return {name: np.array(values) for name, values in table.items()}


def _tau(lifetime: np.ndarray, escaped: np.ndarray, start: float) -> tuple[float, float, float]:
    try:
        found = mean_lifetime(lifetime, escaped, start=start)
    except NotEnoughDataError:
        return np.nan, np.nan, np.nan
    if found.ended < MINIMUM_ENDS:
        return np.nan, np.nan, found.lower
    return found.mean, found.error, found.lower


def on_shared_orbits(runs: Mapping[str, np.ndarray], settle_time: float) -> np.ndarray:
    """Which runs end on an orbit that at least two others end on: no chaos looks so alike."""
    reach, rates = runs["final_amplitude"], np.nan_to_num(runs["final_stick_rate"])
    shared = np.zeros(len(reach), dtype=bool)
    for index in range(len(reach)):
        alike = np.abs(reach - reach[index]) <= SAME_RANGE * reach[index]
        alike &= np.all(np.abs(rates - rates[index]) * settle_time < 2.5, axis=1)
        shared[index] = alike.sum() > COMPANIONS
    return shared


def label_attractors(
    escaped: npt.ArrayLike, final_disorder: npt.ArrayLike, final_stick_rate: npt.ArrayLike
) -> np.ndarray:
    """Name the state in which each run ends.

    Criterion: "stick-slip" when the last block still sticks in the settled part of the run or the
    run did not escape (a chaotic saddle or a stick-slip attractor: a run of finite length cannot
    tell); otherwise continuous slip, of large amplitude when r there is at least LARGE_AMPLITUDE.
    """
    rates = np.asarray(final_stick_rate, dtype=float)
    last = np.isfinite(rates).sum(axis=1) - 1
    sticks = rates[np.arange(len(rates)), last] > 0
    slips = np.where(np.asarray(final_disorder) >= LARGE_AMPLITUDE, LARGE_SLIP, SMALL_SLIP)
    return np.where(sticks | ~np.asarray(escaped, dtype=bool), STICK_SLIP, slips)


def labels_of(runs: Mapping[str, np.ndarray]) -> np.ndarray:
    """`label_attractors` of runs of a dataset of kind escapes."""
    return label_attractors(runs["escaped"], runs["final_disorder"], runs["final_stick_rate"])
