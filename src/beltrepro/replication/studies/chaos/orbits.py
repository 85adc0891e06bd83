"""Catalogue of the attractors that runs at one point reach from different starts."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from beltrepro.base.errors import require
from beltrepro.stats.estimates import Estimate, share
from beltrepro.stats.motion import PERIODIC

# Relative difference up to which two periods are one: states close to 1e-8, while different orbits
# of equal numbers of slips differ by far more.
SAME_PERIOD = 1e-6
# Relative difference up to which two r are one: r is measured over a time that is no multiple of
# the period, and may be as short as a few periods. It tells large amplitudes from small ones.
SAME_DISORDER = 0.25

_EXACT = ("state", "period_events", "period_returns")
_MEDIAN = ("disorder_parameter", "mean_length")


@dataclass(frozen=True)
class Attractor:
    """A periodic orbit, or the runs of another state."""

    state: str  # "periodic", "equilibrium slip" or "irregular"
    runs: int  # runs that ended on it
    basin: Estimate  # its share of all runs: of the starts, the part that leads to it
    period_time: float  # length of a period, median over the runs; NaN if it is not periodic
    period_events: int  # slips of all blocks in a period; 0 if it is not periodic
    period_returns: int  # returns to the section in a period; 0 if it is not periodic
    disorder_parameter: float  # r, median over the runs
    mean_length: float  # <x_N>, median over the runs


def catalogue(runs: Mapping[str, npt.ArrayLike]) -> list[Attractor]:
    """The attractors that the runs at one point end on.

    Two periodic runs are on one orbit if they have the same number of slips in a period, periods
    that agree to 1e-6 and r that agree to 25 %. All runs of another state count as one: equilibrium
    slip keeps the amplitude that it happens to have, and irregular motion has no period. A run that
    closes after a whole multiple of a shorter period is on that orbit: where a motion alternates
    about an orbit while it approaches it, its state comes back sooner after two periods.
    """
    arrays = {name: np.asarray(runs[name]) for name in (*_EXACT, "period_time", *_MEDIAN)}
    arrays["state"] = arrays["state"].astype(str)
    count = arrays["state"].size
    require(count, "no runs, 1 is needed")
    attractors = []
    for members in _alike(arrays):
        exact: dict[str, Any] = {name: arrays[name][members[0]].item() for name in _EXACT}
        middle: dict[str, Any] = {name: float(np.median(arrays[name][members])) for name in _MEDIAN}
        once = members[arrays["period_events"][members] == exact["period_events"]]
        attractors.append(
            Attractor(
                runs=members.size,
                basin=share(members.size, count),
                period_time=float(np.median(arrays["period_time"][once])),
                **exact,
                **middle,
            )
        )
    return sorted(attractors, key=_rank)


def _rank(one: Attractor) -> tuple:
    length = np.inf if np.isnan(one.period_time) else one.period_time
    return -one.runs, length, one.disorder_parameter, one.state


def _alike(arrays: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Indices of the runs that share an attractor."""
    others = [
        np.flatnonzero(arrays["state"] == name)
        for name in np.unique(arrays["state"])
        if name != PERIODIC
    ]
    orbits, runs = [], np.flatnonzero(arrays["state"] == PERIODIC)
    for number in np.unique(arrays["period_events"][runs]):
        same = runs[arrays["period_events"][runs] == number]
        for orbit in _clusters(same, arrays["period_time"], SAME_PERIOD):
            orbits += _clusters(orbit, arrays["disorder_parameter"], SAME_DISORDER)
    return others + _with_multiples(orbits, arrays)


def _with_multiples(orbits: list[np.ndarray], arrays: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Orbits with those that are a whole multiple of them; the first run has the single period."""
    families: list[list[np.ndarray]] = []
    for runs in sorted(orbits, key=lambda runs: float(np.median(arrays["period_time"][runs]))):
        base = next((base for base in families if _is_multiple(runs, base[0], arrays)), None)
        if base is None:
            families.append([runs])
        else:
            base.append(runs)
    return [np.concatenate(family) for family in families]


def _is_multiple(runs: np.ndarray, shorter: np.ndarray, arrays: dict[str, np.ndarray]) -> bool:
    time, disorder = (
        [float(np.median(arrays[name][orbit])) for orbit in (runs, shorter)]
        for name in ("period_time", "disorder_parameter")
    )
    events = [arrays["period_events"][orbit[0]] for orbit in (runs, shorter)]
    multiple = round(time[0] / time[1])
    return bool(
        multiple > 1
        and np.isclose(time[0], multiple * time[1], rtol=SAME_PERIOD, atol=0)
        and np.isclose(disorder[0], disorder[1], rtol=SAME_DISORDER, atol=0)
        and events[0] == multiple * events[1]
    )


def _clusters(runs: np.ndarray, values: np.ndarray, tolerance: float) -> list[np.ndarray]:
    """Runs in groups: the value of each is within a relative tolerance of the next smaller one."""
    ordered = runs[np.argsort(values[runs], kind="stable")]
    sizes = values[ordered]
    return np.split(ordered, np.flatnonzero(np.diff(sizes) > tolerance * np.abs(sizes[1:])) + 1)
