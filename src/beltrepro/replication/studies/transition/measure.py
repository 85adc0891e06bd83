"""Where r falls with the belt velocity, how long transients last, and the attractors that follow.

Two times are told apart: until the motion rests on an orbit, which may have sticks, and until the
last block slips for good. A run on a stick-slip orbit never comes to the second.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.replication.verdicts.motions import N_BLOCKS, between
from beltrepro.stats import estimates, survival
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.motion import find_recurrence
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
            row = {"dataset": name, "n_blocks": int(n_blocks), "noise": noise}
            row |= {"runs": region["critical"].runs}
            row |= region["critical"].named("critical", "low", "high")
            rows.append(row | {edge: region[edge].value for edge in ("lower", "upper")})
    return pd.DataFrame(rows)


# --- how long transients of five blocks last (inset of Fig. 12) -----------------------------------

# Runs on one orbit have the same range of x_N, up to where the samples lie, and as many sticks in
# the settled part, give or take the ends. Chaotic runs agree so closely by chance in pairs at most.
SAME_RANGE = 1e-3
COMPANIONS = 2


@dataclass(frozen=True)
class Ends:
    """Lifetimes of runs of five blocks, and the estimator of their mean that takes them rightly."""

    belt_velocity: np.ndarray
    lifetime: np.ndarray
    ended: np.ndarray
    mean_of: Callable[..., Estimate]  # of lifetimes and which runs ended

    @classmethod
    def of(cls, runs, ended: str, horizon: float, mean_of: Callable, **where: float) -> "Ends":
        """Of the runs of five blocks with these values."""
        where |= {"n_blocks": N_BLOCKS}
        chosen = [np.isclose(runs.arrays[name], value) for name, value in where.items()]
        chosen = np.all(chosen, axis=0)
        require(chosen.any(), "no lifetimes of five blocks")
        names = ("belt_velocity", "lifetime", ended)
        velocity, lifetime, end = (runs.arrays[name][chosen] for name in names)
        return cls(velocity, *survival.observed(lifetime, end, horizon=horizon), mean_of)

    def mean(self, low: float, high: float) -> Estimate:
        """Mean lifetime of the runs with low <= u <= high."""
        inside = between(self.belt_velocity, low, high)
        require(inside.any(), f"no lifetimes for {low:g} <= u <= {high:g}")
        try:
            return self.mean_of(self.lifetime[inside], self.ended[inside])
        except NotEnoughDataError as error:
            raise NotEnoughDataError(f"u = {low:g} to {high:g}: {error}") from None

    def longest(self) -> Estimate:
        """u at which the mean is longest, and the range of those at which it may be."""
        means = {}
        for u in np.unique(self.belt_velocity):
            with suppress(NotEnoughDataError):
                means[u] = self.mean(u, u)
        if not means:
            return estimates.absent()
        best = max(means, key=lambda u: means[u].value)
        may = [u for u, mean in means.items() if mean.high >= means[best].low]
        return Estimate(float(best), float(min(may)), float(max(may)), means[best].runs)


def until_settled(runs, spread: float) -> Ends:
    """How long motion from starts of this spread is irregular, until it rests on any orbit.

    The runs are of kind settling.
    """
    horizon = survival.SEEN * float(runs.attributes["duration"])
    return Ends.of(runs, "settled", horizon, survival.mean_lifetime, initial_spread=spread)


def until_last_stick(runs) -> Ends:
    """How long the last block still sticks now and then: runs of kind escapes.

    Runs that do not escape may be on a stick-slip orbit, so only the others count.
    """
    horizon = float(runs.attributes["duration"]) - float(runs.attributes["settle_time"])
    return Ends.of(runs, "escaped", horizon, partial(survival.mean_of_ended, horizon=horizon))


def saddle(runs: Mapping[str, np.ndarray], duration: float, *, since: float) -> dict[str, Estimate]:
    """Exponent, mean lifetime and their product, of motion that is irregular after a time.

    Both are of the survivors, as for a chaotic saddle: the exponent a mean over the time in which
    runs measure it, the lifetime one over the rate of ends. The runs are of kind settling.
    """
    horizon = survival.SEEN * duration
    late = np.minimum(runs["lifetime"], horizon) >= since
    lived = survival.observed(runs["lifetime"], runs["settled"], start=since, horizon=horizon)
    exponent = runs["irregular_exponent"][late]
    measured = np.where(np.isfinite(exponent), runs["irregular_time"][late], 0.0)
    sums = np.column_stack([np.nan_to_num(exponent) * measured, measured, *lived])

    def over(statistic: Callable[..., float]) -> Estimate:
        return estimates.bootstrap(lambda rows: statistic(*rows.sum(axis=0)), [sums])

    with np.errstate(invalid="ignore", divide="ignore"):  # none measured, or none that ended
        return {
            "exponent": over(lambda growth, measured, lived, ends: growth / measured),
            "lifetime": over(lambda growth, measured, lived, ends: lived / ends),
            "e-foldings": over(
                lambda growth, measured, lived, ends: growth / measured * lived / ends
            ),
        }


def on_shared_orbits(runs: Mapping[str, np.ndarray], settle_time: float) -> np.ndarray:
    """Which runs end on an orbit that at least two others end on: no chaos looks so alike."""
    reach, rates = runs["final_amplitude"], np.nan_to_num(runs["final_stick_rate"])
    shared = np.zeros(len(reach), dtype=bool)
    for index in range(len(reach)):
        alike = np.abs(reach - reach[index]) <= SAME_RANGE * reach[index]
        alike &= np.all(np.abs(rates - rates[index]) * settle_time < 2.5, axis=1)
        shared[index] = alike.sum() > COMPANIONS
    return shared


# --- a sampled run (Fig. 11) ----------------------------------------------------------------------

# Of the largest swing at the end: how near a state must come to that of a period before. Samples
# give a state at a crossing to less than this, and on a chaotic set states come as near now and
# then, but not all states of so many crossings.
CLOSED = 0.01
CROSSINGS = 24


def settled_orbit(
    time: np.ndarray, positions: np.ndarray, velocities: np.ndarray
) -> tuple[float, float] | None:
    """From when on a series repeats itself and its period then; None if its end does not.

    States are compared where the last block crosses its median position downwards, interpolated
    linearly.
    """
    end = slice(-(len(time) // 4) or None, None)
    last, level = positions[:, -1], np.median(positions[end, -1])
    before = np.flatnonzero((last[:-1] > level) & (last[1:] <= level))
    if len(before) < CROSSINGS + 3:
        return None
    part = (last[before] - level) / (last[before] - last[before + 1])
    instants, states = (
        values[before] + (part * (values[before + 1] - values[before]).T).T
        for values in (time, np.hstack([positions, velocities]))
    )
    near = CLOSED * float(np.ptp(positions[end], axis=0).max())
    recurrence = find_recurrence(states, instants, closed=0.0, distance=near, crossings=CROSSINGS)
    return recurrence and (float(instants[recurrence.since]), recurrence.time)
