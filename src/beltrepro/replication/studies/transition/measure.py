"""Where r falls with the belt velocity, how long transients last, and the attractors that follow.

Two times are told apart: until the motion rests on an orbit, which may have sticks, and until the
last block slips for good. A run on a stick-slip orbit never comes to the second.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.chaos.measure import N_BLOCKS, between
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import estimates, survival
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.recurrence import find_recurrence
from beltrepro.stats.survival import MeanLifetime
from beltrepro.stats.transition import QUANTITIES

TABLES = {
    "critical_velocities": Table(
        uses=("n5_replicates", "n5_replicates_check", "n5_replicates_wide", "size_replicates")
    )
}


def fall(scan, n_blocks: int, noise: float) -> dict[str, Estimate]:
    """The fall of r in a row of a scan; nothing found where there are too few runs for one."""
    try:
        return Cut.of(scan, n_blocks=n_blocks, noise=noise).fall
    except NotEnoughDataError:
        return dict.fromkeys(QUANTITIES, estimates.absent())


def critical_velocities(data) -> pd.DataFrame:
    """A row for each dataset, number of blocks and noise."""
    rows = []
    for name in TABLES["critical_velocities"].uses:
        arrays = data[name].arrays
        points = np.column_stack([arrays["n_blocks"], arrays["noise"]])
        for n_blocks, noise in np.unique(points, axis=0):
            region = fall(data[name], int(n_blocks), noise)
            critical = region["critical"]
            row = {"dataset": name, "n_blocks": int(n_blocks), "noise": noise}
            row |= {"runs": critical.runs, "critical": critical.value}
            row |= {"low": critical.low, "high": critical.high}
            rows.append(row | {edge: region[edge].value for edge in ("lower", "upper")})
    return pd.DataFrame(rows)


# --- how long transients of five blocks last (inset of Fig. 12) -----------------------------------

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

Lifetime = Callable[..., MeanLifetime]  # of `ends`: takes lifetimes and which runs ended


@dataclass(frozen=True)
class Ends:
    """Lifetimes of runs of five blocks, and the estimator of their mean that takes them rightly."""

    belt_velocity: np.ndarray
    lifetime: np.ndarray
    ended: np.ndarray
    mean_of: Lifetime

    def mean(self, low: float, high: float, **options: float) -> MeanLifetime:
        """Mean lifetime of the runs with low <= u <= high; options of the estimator."""
        inside = between(self.belt_velocity, low, high)
        require(inside.any(), f"no lifetimes for {low:g} <= u <= {high:g}")
        try:
            return self.mean_of(self.lifetime[inside], self.ended[inside], **options)
        except NotEnoughDataError as error:
            raise NotEnoughDataError(f"u = {low:g} to {high:g}: {error}") from None


def until_settled(runs: Any, spread: float | None = None) -> Ends:
    """How long motion is irregular, until it rests on any orbit: runs of kind settling.

    spread : of the starts, if only those with this one are wanted.
    """
    chosen = runs.arrays["n_blocks"] == N_BLOCKS
    if spread is not None:
        chosen &= np.isclose(runs.arrays["initial_spread"], spread)
    horizon = survival.SEEN * float(runs.attributes["duration"])
    return _ends(runs, chosen, "settled", partial(survival.mean_lifetime, horizon=horizon))


def until_last_stick(runs: Any) -> Ends:
    """How long the last block still sticks now and then: runs of kind escapes.

    Runs that do not escape may be on a stick-slip orbit, so only the others count.
    """
    chosen = runs.arrays["n_blocks"] == N_BLOCKS
    horizon = float(runs.attributes["duration"]) - float(runs.attributes["settle_time"])
    return _ends(runs, chosen, "escaped", partial(survival.mean_of_ended, horizon=horizon))


def _ends(runs: Any, chosen: np.ndarray, ended: str, mean_of: Lifetime) -> Ends:
    require(chosen.any(), "no lifetimes of five blocks")
    names = ("belt_velocity", "lifetime", ended)
    velocity, lifetime, end = (runs.arrays[name][chosen] for name in names)
    return Ends(velocity, lifetime, end.astype(bool), mean_of)


def on_shared_orbits(runs: Mapping[str, np.ndarray], settle_time: float) -> np.ndarray:
    """Which runs end on an orbit that at least two others end on: no chaos looks so alike."""
    reach, rates = runs["final_amplitude"], np.nan_to_num(runs["final_stick_rate"])
    shared = np.zeros(len(reach), dtype=bool)
    for index in range(len(reach)):
        alike = np.abs(reach - reach[index]) <= SAME_RANGE * reach[index]
        alike &= np.all(np.abs(rates - rates[index]) * settle_time < 2.5, axis=1)
        shared[index] = alike.sum() > COMPANIONS
    return shared


def labels_of(runs: Mapping[str, np.ndarray]) -> np.ndarray:
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


# --- a sampled run (Fig. 11) ----------------------------------------------------------------------

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
    recurrence = find_recurrence(
        states, instants, closed=0.0, distance=CLOSED * swing, crossings=CROSSINGS
    )
    if recurrence is None:
        return None
    return SettledOrbit(since=float(instants[recurrence.since]), period=recurrence.time)


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
