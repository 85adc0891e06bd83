"""Irregular and periodic motion: where runs end, how long they are irregular, and exponents.

Irregular motion may end after any time. Here it counts as lasting if it is seen for LONG. Runs that
are given up before, and those without an exponent above zero, are open: longer runs may show
either, and the interval of a share covers both.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import Evidence, by_point
from beltrepro.stats import estimates, sections, survival
from beltrepro.stats.estimates import Estimate, share, share_of
from beltrepro.stats.motion import CHAOTIC, MOTIONS, PERIODIC, TRANSIENT, above_zero

TABLES = {
    "motions": Table(uses=("motion_map",)),
    "noisy_motions": Table(uses=("noisy_motion",)),
    "mean_lifetimes": Table(uses=("survival", "survival_many", "survival_long")),
    "attractors": Table(uses=("survival", "survival_many", "survival_long")),
}

# Columns behind those of the point, of a table without rows too.
_LIFETIME = (
    *("runs", "settled", "share", "share_lower", "share_upper", "start", "horizon", "counted"),
    *("ended", "lifetime", "lifetime_lower", "lifetime_upper", "shape", "shape_p"),
    *("exponent", "exponent_error", "exponent_runs", "verdict"),
    *("attractor", "attractor_period", "attractor_events", "attractor_share"),
)
_ATTRACTOR = (
    *("runs", "number", "state", "reached", "share", "share_lower", "share_upper", "period_time"),
    *("period_events", "period_returns", "disorder_parameter", "mean_length"),
)
POINT = ("n_blocks", "belt_velocity", "initial_spread")
"""What tells the points of a dataset apart; runs that differ in the replicate share a row."""

_SHARE = ("share", "share_lower", "share_upper")


# --- runs of a given length -----------------------------------------------------------------------


def motions(data) -> pd.DataFrame:
    """A row for each number of blocks and belt velocity."""
    arrays = data["motion_map"].arrays
    rows = []
    for place, runs in by_point(arrays, "n_blocks", "belt_velocity"):
        state, disorder = arrays["state"][runs].astype(str), arrays["disorder_parameter"][runs]
        counts = {name: int(np.sum(state == name)) for name in MOTIONS}
        row = place | {"runs": runs.size} | counts | _exponent(arrays["largest_exponent"][runs])
        row["longest_period"] = int(arrays["period_events"][runs].max())
        row["r_periodic"] = pd.Series(disorder[state == PERIODIC]).mean()
        row["r_irregular"] = pd.Series(disorder[np.isin(state, (CHAOTIC, TRANSIENT))]).mean()
        rows.append(row)
    return pd.DataFrame(rows)


def noisy_motions(data) -> pd.DataFrame:
    """A row for each belt velocity and noise."""
    arrays = data["noisy_motion"].arrays
    rows = []
    for place, runs in by_point(arrays, "belt_velocity", "noise"):
        row = place | {"runs": runs.size} | _exponent(arrays["largest_exponent"][runs])
        rows.append(row | {"r": pd.Series(arrays["disorder_parameter"][runs]).mean()})
    return pd.DataFrame(rows)


def _exponent(exponents: np.ndarray) -> dict:
    """Mean over runs, and its error."""
    runs = pd.Series(exponents)
    return {"exponent": runs.mean(), "error": runs.std(ddof=1) / np.sqrt(runs.size)}


# --- runs that are followed until they settle -----------------------------------------------------


def mean_lifetimes(data) -> pd.DataFrame:
    """A row for each dataset, N, u and initial spread."""
    rows = []
    for name in TABLES["mean_lifetimes"].uses:
        horizon = survival.SEEN * float(data[name].attributes["duration"])
        for point, runs in by_point(data[name].arrays, *POINT):
            lasting = _lasting(sections.select(data[name].arrays, runs), horizon)
            rows.append({"dataset": name} | point | lasting)
    return pd.DataFrame(rows, columns=["dataset", *POINT, *_LIFETIME])


def attractors(data) -> pd.DataFrame:
    """A row for each attractor at each point of each dataset."""
    rows = []
    for name in TABLES["attractors"].uses:
        for point, runs in by_point(data[name].arrays, *POINT):
            reached = catalogue(sections.select(data[name].arrays, runs))
            for number, attractor in enumerate(reached, start=1):
                row = vars(attractor) | attractor.basin.named(*_SHARE) | point
                row |= {"dataset": name, "number": number, "reached": attractor.runs}
                rows.append(row | {"runs": runs.size})
    return pd.DataFrame(rows, columns=["dataset", *POINT, *_ATTRACTOR])


def _lasting(runs, horizon) -> dict:
    """The lifetimes of the runs of one point, their exponent, and where most of them end."""
    lifetime, settled = runs["lifetime"], runs["settled"].astype(bool)
    irregular = (runs[f"irregular_{name}"] for name in ("exponent", "error", "time"))
    exponent = survival.pool_exponents(*irregular)
    span = {"start": survival.spreading_time(exponent, horizon), "horizon": horizon}
    row = {"runs": settled.size, "settled": int(settled.sum())}
    row |= share_of(~settled).named(*_SHARE) | span | _lifetime(lifetime, settled, span)
    row |= {"exponent": exponent.value, "exponent_error": exponent.error}
    row |= {"exponent_runs": exponent.runs}
    # regular too where irregular motion is too short for an exponent
    regular = settled.all() and not exponent.runs
    row["verdict"] = survival.REGULAR if regular else survival.decide(lifetime, settled, **span)
    first = catalogue(runs)[0]
    row |= {"attractor": first.state, "attractor_period": first.period_time}
    row |= {"attractor_events": first.period_events, "attractor_share": first.basin.value}
    return row


def _lifetime(lifetime, settled, span) -> dict:
    """Mean lifetime and test; empty where too few runs carry them."""
    row: dict = {"counted": 0, "ended": 0}
    try:
        mean = survival.mean_lifetime(lifetime, settled, **span)
        row |= {"counted": mean.runs, "ended": mean.ended, "lifetime": mean.mean}
        row |= {"lifetime_lower": mean.lower, "lifetime_upper": mean.upper}
        test = survival.weibull_test(lifetime, settled, **span)
        row |= {"shape": test.shape, "shape_p": test.p}
    except NotEnoughDataError:
        pass
    return row


# --- attractors that runs at one point reach from different starts --------------------------------

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


# --- runs whose motion is named, or that were followed until it settled ---------------------------

N_BLOCKS = 5
LONG = 1e5  # ten times the longest mean lifetime of a transient that the paper allows
SCHEME, EXACT = "the paper's scheme", "exact dynamics"  # names of readings
# The runs of each reading: of the exact dynamics, the first dataset with runs at a point serves.
SETTLING = {
    SCHEME: ("survival_scheme",),
    EXACT: ("survival_many", "survival_long", "survival"),
}
SPREAD = 10.0  # of their starts
MINIMUM_EXPONENTS = 3


@dataclass(frozen=True)
class Motions:
    """What motion runs were found in at their end."""

    names: np.ndarray  # one of `motion.MOTIONS` each (R,)
    returns: np.ndarray  # to the mean length in a period (R,), 0 if the orbit does not close
    long: np.ndarray  # which runs were followed for LONG (R,)

    @property
    def open(self) -> np.ndarray:
        """Which runs are irregular, and may not be for long (R,)."""
        return (self.names == TRANSIENT) | ((self.names == CHAOTIC) & ~self.long)

    def share(self, name: str) -> Estimate:
        """Share of the runs with a motion of this name."""
        return estimates.share_of((self.names == name) & ~self.open, self.open)

    def and_also(self, others: Motions) -> Motions:
        """These runs and others."""
        pairs = zip(vars(self).values(), vars(others).values(), strict=True)
        return Motions(*map(np.concatenate, pairs))

    def where(self, chosen: np.ndarray) -> Motions:
        """Some of the runs."""
        return Motions(*sections.select(vars(self), chosen).values())

    @property
    def words(self) -> str:
        """How many runs have each name, and how many are open."""
        counts = zip(*np.unique(self.names, return_counts=True), strict=True)
        text = ", ".join(f"{count} {name}" for name, count in counts)
        return f"{text} ({self.open.sum()} of {self.names.size} are open)"


def motions_of(
    evidence: Evidence, n_blocks: int, low: float = 0.0, high: float = np.inf
) -> Motions:
    """Runs of `motion_map` of so many blocks with low <= u <= high.

    At each u there are as many as of the number of blocks that has the fewest: more runs find more
    orbits, and those at one u often end alike.
    """
    every = evidence.dataset("motion_map").arrays
    points = np.column_stack([every["n_blocks"], every["belt_velocity"]])
    fewest = np.unique(points, axis=0, return_counts=True)[1].min(initial=len(points))
    arrays, attributes = evidence.runs("motion_map", n_blocks=n_blocks)
    first = np.unique(every["replicate"])[:fewest]
    arrays = sections.select(arrays, np.isin(arrays["replicate"], first))
    runs = _named(arrays["state"].astype(str), arrays, attributes, low, high)
    require(runs.names.size, f"no runs with N = {n_blocks}, {low:g} <= u <= {high:g}")
    return runs


def motions_with(
    evidence: Evidence, other: str, low: float, high: float, spread: float = SPREAD
) -> Motions:
    """Runs of five blocks with low <= u <= high, and those of a dataset of kind settling.

    A run that has not settled is chaotic by its exponent. Starts of another spread than those of
    `motion_map` are taken, so that no run counts twice.
    """
    runs = motions_of(evidence, N_BLOCKS, low, high)
    if not evidence.has(other):
        return runs
    arrays, attributes = evidence.runs(other, n_blocks=N_BLOCKS, initial_spread=spread)
    exponent, error, time = (arrays[f"irregular_{name}"] for name in ("exponent", "error", "time"))
    irregular = np.where(above_zero(exponent, error, time), CHAOTIC, TRANSIENT)
    names = np.where(arrays["settled"].astype(bool), arrays["state"].astype(str), irregular)
    return runs.and_also(_named(names, arrays, attributes, low, high))


def _named(names: np.ndarray, arrays: dict, attributes: dict, low: float, high: float) -> Motions:
    long = np.full(names.size, attributes["duration"] >= LONG)
    inside = between(arrays["belt_velocity"], low, high)
    return Motions(names, arrays["period_returns"], long).where(inside)


def between(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Mask of low <= value <= high, to the rounding of a grid."""
    return (values >= low - 1e-9) & (values <= high + 1e-9)


@dataclass(frozen=True)
class Settling:
    """Runs from random starts, followed until they settled or were given up."""

    arrays: dict[str, np.ndarray]  # of kind settling
    duration: float

    @classmethod
    def of(cls, evidence: Evidence, names: tuple[str, ...], **place: float) -> Settling:
        """Runs of five blocks from the first of the datasets that has some at this place."""
        place |= {"n_blocks": N_BLOCKS, "initial_spread": SPREAD}
        arrays, attributes = evidence.runs(*names, **place)
        arrays |= {"settled": arrays["settled"].astype(bool), "state": arrays["state"].astype(str)}
        return cls(arrays, float(attributes["duration"]))

    def where(self, chosen: np.ndarray) -> Settling:
        """Some of the runs."""
        return Settling(sections.select(self.arrays, chosen), self.duration)

    def irregular_for(self, time: float) -> Estimate:
        """Share of the runs that are irregular for a time or longer."""
        lasting = self.arrays["lifetime"] >= time
        return estimates.share_of(lasting, ~lasting & ~self.arrays["settled"])

    @property
    def ends_periodic(self) -> Estimate:
        """Share of the runs that end in periodic stick-slip; those irregular for LONG do not."""
        settled = self.arrays["settled"]
        sticks = (self.arrays["state"] == PERIODIC) & (self.arrays["period_events"] > 0)
        unknown = ~settled & (self.arrays["lifetime"] < LONG)
        return estimates.share_of(settled & sticks, unknown)

    @property
    def half_life(self) -> Estimate:
        """Time by which half of the runs have settled, or the whole time if fewer have."""
        return estimates.sure(np.median(self.arrays["lifetime"]))

    @property
    def exponent(self) -> Estimate:
        """Mean largest exponent of the irregular motion; absent if all settled too soon for one."""
        return self._mean_over_runs(self.arrays["irregular_exponent"])

    @property
    def e_foldings(self) -> Estimate:
        """Mean number of times by which a small deviation grows e-fold until a run settles."""
        return self._mean_over_runs(self.arrays["irregular_exponent"] * self.arrays["lifetime"])

    def _mean_over_runs(self, values: np.ndarray) -> Estimate:
        values = values[np.isfinite(values)]
        if values.size >= MINIMUM_EXPONENTS:
            return estimates.mean(values)
        settled = self.arrays["settled"]
        require(settled.all(), f"{self.words}: longer runs are needed for an exponent")
        return estimates.absent(settled.size)

    @property
    def words(self) -> str:
        """How many runs settled, and after what time."""
        settled, half = self.arrays["settled"], self.half_life.value
        count = f"{settled.sum()} of {settled.size} runs settled within {self.duration:g}"
        return f"{count}, half of all by {half:.0f}" if 2 * settled.sum() >= settled.size else count


def by_method(
    evidence: Evidence, measure: Callable[[Settling, str], Measurement]
) -> dict[str, Callable[[], Measurement]]:
    """Readings of a claim on one belt velocity, by the paper's scheme and by the exact dynamics."""
    velocity = evidence.claim.parameters["belt_velocity"]

    def reading(name: str) -> Measurement:
        return measure(Settling.of(evidence, SETTLING[name], belt_velocity=velocity), name)

    return {name: partial(reading, name) for name in SETTLING}
