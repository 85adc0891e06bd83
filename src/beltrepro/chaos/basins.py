"""Basins of attraction: on which motion each start ends, and the same along a constant."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.chaos.continuation import QUANTITIES, OrbitBranch, orbit_branch
from beltrepro.chaos.irregular import IRREGULAR, time_to_orbit
from beltrepro.chaos.periodic_orbits import (
    MOMENTS,
    PeriodicOrbit,
    advanced,
    check_exact,
    close_orbit,
    exact_case,
)
from beltrepro.chaos.vectors import part
from beltrepro.engine.state import ChainState
from beltrepro.observe.crossings import ReturnLog
from beltrepro.simulation.groups import Report, check_progress
from beltrepro.simulation.results import Results
from beltrepro.simulation.setup import Chains, Setup, setup_of, with_setup
from beltrepro.simulation.tables import Tabled, brief, one_panel
from beltrepro.stats import estimates
from beltrepro.stats.motion import EQUILIBRIUM, PERIODIC

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_RUNS = 0.8  # share of the work, about, that the runs are
_SAME = 1e-5  # share by which periods, and states at the section, of one orbit may differ
_LONGEST = 200  # slips of an orbit that is followed: longer ones end within little of the quantity
_ALIKE = 0.5  # e-foldings of r by which neighbours of one irregular motion may differ
_COLUMNS = ("label", "state", "reached_by", "starts", "period_time", "period_events", *MOMENTS)


@dataclass(eq=False, repr=False)
class Attractor:
    """An attractor at one value of the quantity; that of the same label elsewhere is its branch."""

    value: float  # of the quantity
    starts: int  # all of this value
    state: str  # "periodic", "equilibrium slip" or "irregular"
    period_time: float  # NaN without
    period_events: int  # slips of all blocks in it, 0 without
    disorder_parameter: float
    mean_length: float
    orbit: PeriodicOrbit | None = None
    rows: list[int] = field(default_factory=list)  # of the runs that reach it
    label: int = 0  # from 1; 0 until it is known

    def __repr__(self) -> str:
        return f"Attractor({brief(self)})"

    @classmethod
    def of_runs(cls, value: float, starts: int, runs: Results, rows: list[int]) -> Attractor:
        """That of some runs."""
        names = "state", "period_time", "period_events"
        state, time, events = (runs[name][rows[0]].item() for name in names)
        r, length = (float(np.mean(runs[name][rows])) for name in MOMENTS)
        return cls(value, starts, state, time, events, r, length, rows=rows)

    @property
    def reached_by(self) -> int:
        """Starts; 0: it is there, and none of them reaches it."""
        return len(self.rows)

    def close(self, state: ChainState) -> None:
        """Find its orbit, near one of its states, if it is not too long."""
        if self.period_events > _LONGEST:
            return
        try:
            self.orbit = close_orbit(state, self.period_time)
        except (InputError, ModelStateError):
            return  # two events at one instant, say: the motion is periodic all the same
        for name in ("period_time", *MOMENTS):
            setattr(self, name, getattr(self.orbit, name))

    def is_of(self, period_time: float, period_events: int, crossing: np.ndarray) -> bool:
        """Whether it is a periodic motion that comes down through a length in this state (2N,)."""
        same = period_events == self.period_events
        same = same and abs(period_time / self.period_time - 1) < _SAME
        if not same or self.orbit is None:
            return same
        rests = self.orbit.parameters.rest_positions
        length = crossing[len(rests) - 1] + rests[-1]
        apart = np.abs(_crossings(self.orbit, length) - crossing).max(axis=1)
        return bool(np.any(apart < _SAME * np.abs(crossing).max()))

    def apart(self, other: Attractor) -> float:
        """How far another one without an orbit is: by r, and by <x_N> in its deviations."""
        if self.state != other.state or self.state == PERIODIC:
            return np.inf
        if self.state == EQUILIBRIUM:
            return 0.0
        r, lengths = ([getattr(one, name) for one in (self, other)] for name in MOMENTS)
        scale = max(r) * min(lengths)
        return float(np.hypot(np.log(r[0] / r[1]), (lengths[0] - lengths[1]) / scale))


def _crossings(orbit: PeriodicOrbit, length: float) -> np.ndarray:
    """States (K, 2N) in which an orbit comes down through a length in a period."""
    log = ReturnLog(1)
    advanced([exact_case(orbit.state)], orbit.period_time, log, length=length)
    return log.returns(0)[1]


@dataclass(frozen=True, eq=False, repr=False)
class Basins(Tabled):
    """Which attractor each of P starts reaches.

    Attractors are `periodic`, `irregular` (not settled within the duration: a transient perhaps)
    or `equilibrium slip`, the motions without any stick, which count as one family.

    Attributes
    ----------
    quantity : str
        The constant of the chain that differs; "belt_velocity" if none does.
    attractors : tuple
        By value of the quantity, then label: `value`, `label`, `state`, how many of the `starts` it
        is `reached_by`, `period_time`, `period_events`, `disorder_parameter`, `mean_length` and
        `orbit`, a PeriodicOrbit or None.
    branches : dict of OrbitBranch
        By label, of the periodic ones that were followed: where they end, and how.
    runs : Results
        What `time_to_orbit` says of each start, with its `attractor` (P,), a label.
    """

    quantity: str
    attractors: tuple[Attractor, ...]
    branches: dict[int, OrbitBranch]
    runs: Results

    @property
    def values(self) -> np.ndarray:
        """Values (K,) of the quantity, rising."""
        return np.unique(self.runs[self.quantity])

    def _columns(self) -> dict[str, Any]:
        """What each attractor is, and the share of the starts that reach it with its interval."""
        rows = []
        for attractor in self.attractors:
            row = {self.quantity: attractor.value}
            row |= {name: getattr(attractor, name) for name in _COLUMNS}
            orbit = attractor.orbit
            row["largest_multiplier"] = np.nan if orbit is None else abs(orbit.largest_multiplier)
            share = estimates.share(attractor.reached_by, attractor.starts)
            rows.append(row | share.named("share", "share_low", "share_high"))
        return {name: [row[name] for row in rows] for name in rows[0]}

    @one_panel
    def plot(self, path: str | Path | None = None, *, ax: Any = None, **look: Any) -> Axes:
        """Draw r of branches and attractors; marks are as large as the shares of the starts."""
        from beltrepro.simulation import plots

        return plots.basins(ax, self, look)

    @one_panel
    def plot_shares(self, path: str | Path | None = None, *, ax: Any = None, **look: Any) -> Axes:
        """Draw the shares of the starts that reach each attractor, on top of each other."""
        from beltrepro.simulation import plots

        return plots.shares(ax, self, look)

    def __repr__(self) -> str:
        count, values = len({one.label for one in self.attractors}), self.values
        span = f"{values[0]:g}" if values.size == 1 else f"{values[0]:g} to {values[-1]:g}"
        starts = len(self.runs["attractor"])
        return f"Basins({count} attractors of {starts} starts, {self.quantity} {span})"


@with_setup
def basins(
    chains: Chains, *, duration: float, progress: Report | None = None, **setup: Any
) -> Basins:
    """On which attractor each of P chains ends, by where it begins.

    Starts at rest come of `replicate=range(200), initial_spread=10` or of `initial_positions`, all
    others of `initial_state`, such as `slipping_state` makes. Chains may differ in one constant:
    there an attractor keeps its label along the branch of its orbit (`orbit_branch`), also where no
    start reaches it. Two runs reach one orbit if they have its period and its states at a section
    of the last block. Orbits of more than 200 slips are not followed, and have labels of their own.
    Irregular motions of neighbouring values are one if their r and <x_N> are about the same.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        P chains of one number of blocks, without noise, of the method "event".
    duration : float
        Model time after which a run counts as irregular.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

    Returns
    -------
    Basins
        Attractors with the shares of the starts, branches, and what each start reaches.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    made = setup_of(chains, setup)
    check_exact(made.cases)
    quantity = _differing(made)
    check_progress(progress)
    runs = time_to_orbit(made, duration=duration, progress=part(progress, 0, _RUNS))
    values = np.unique(runs[quantity])
    by_value = [_attractors(made, runs, quantity, value) for value in values.tolist()]
    branches = _label(by_value, quantity, values, part(progress, _RUNS, 1))
    attractors = sorted(chain.from_iterable(by_value), key=lambda one: (one.value, one.label))
    runs["attractor"] = np.zeros(len(made.cases), dtype=int)
    for attractor in attractors:
        runs["attractor"][attractor.rows] = attractor.label
    return Basins(quantity, tuple(attractors), branches, runs)


def _differing(made: Setup) -> str:
    """The constant in which the chains differ."""
    chains = {case.parameters for case in made.cases}
    if len(sizes := {one.n_blocks for one in chains}) > 1:
        raise InputError(f"chains: of {len(sizes)} numbers of blocks, one is needed")
    values = {name: {getattr(one, name) for one in chains} for name in QUANTITIES}
    differing = [name for name in QUANTITIES if len(values[name]) > 1]
    if len(differing) > 1:
        raise InputError(f"chains: differ in {', '.join(differing)}, in one of them they may")
    quantity = differing[0] if differing else "belt_velocity"
    if any(isinstance(value, tuple) for value in values[quantity]):
        raise InputError(f"chains: {quantity} differs among the blocks, one number is needed")
    return quantity


def _attractors(made: Setup, runs: Results, quantity: str, value: float) -> list[Attractor]:
    """The attractors on which the runs of one value end, those of many starts first."""
    rows = np.flatnonzero(runs[quantity] == value)
    state, new = runs["state"][rows], partial(Attractor.of_runs, value, len(rows), runs)
    together = [*_parted(runs, rows[state == IRREGULAR]), rows[state == EQUILIBRIUM]]
    attractors = [new(part.tolist()) for part in together if part.size]
    for row in rows[state == PERIODIC].tolist():
        crossing = runs["return_state"][row]
        period = float(runs["period_time"][row]), int(runs["period_events"][row])
        reached = next((one for one in attractors if one.is_of(*period, crossing)), None)
        if reached is None:
            attractors.append(reached := new([row]))
            parameters, (places, speeds) = made.cases[row].parameters, np.split(crossing, 2)
            places, speeds = places + parameters.rest_positions, speeds + parameters.belt_velocity
            reached.close(ChainState.in_motion(parameters, places, speeds))
        else:
            reached.rows.append(row)
    return sorted(attractors, key=lambda attractor: -attractor.reached_by)


def _parted(runs: Results, rows: np.ndarray) -> list[np.ndarray]:
    """Runs of irregular motions: those with a gap between their r are not one."""
    rows = rows[np.argsort(runs["disorder_parameter"][rows], kind="stable")]
    gaps = np.diff(np.log(runs["disorder_parameter"][rows])) > _ALIKE
    return np.split(rows, np.flatnonzero(gaps) + 1)


def _label(
    by_value: list[list[Attractor]], quantity: str, values: np.ndarray, report: Report
) -> dict[int, OrbitBranch]:
    """Number all attractors, one number for each branch; those that no start reached are added."""
    branches: dict[int, OrbitBranch] = {}
    number, lower, upper = 0, float(values[0]), float(values[-1])
    for place, attractors in enumerate(by_value):
        for attractor in list(attractors):
            if attractor.label:
                continue
            attractor.label = number = number + 1
            if attractor.orbit is None:
                _spread(attractor, by_value[place + 1 :])
            elif len(values) > 1:
                try:
                    branch = orbit_branch(attractor.orbit, quantity, lower=lower, upper=upper)
                except (InputError, ModelStateError):  # the run went several times around
                    continue
                branches[number] = branch
                _join(branch, number, by_value)
        report((place + 1) / len(values))
    return branches


def _spread(attractor: Attractor, by_value: list[list[Attractor]]) -> None:
    """Number from there on those that are one with an attractor by what they are alone."""
    for attractors in by_value:
        alike = [(attractor.apart(other), other) for other in attractors if not other.label]
        nearest, other = min(alike, key=lambda pair: pair[0], default=(np.inf, attractor))
        if nearest < _ALIKE:
            other.label, attractor = attractor.label, other


def _join(branch: OrbitBranch, number: int, by_value: list[list[Attractor]]) -> None:
    """Number the attractors on a branch; add it where it is and no start has reached it."""
    for attractors in by_value:
        value, starts = attractors[0].value, attractors[0].starts
        if any(one.label == number for one in attractors):
            continue
        if not branch.lower <= value <= branch.upper or not (orbit := _orbit_at(branch, value)):
            continue
        period = orbit.period_time, orbit.period_events
        crossing = _crossings(orbit, orbit.mean_length)[0]
        on_it = [one for one in attractors if one.orbit and one.is_of(*period, crossing)]
        if not on_it:
            lengths = orbit.disorder_parameter, orbit.mean_length
            on_it = [Attractor(value, starts, PERIODIC, *period, *lengths, orbit)]
            attractors += on_it
        on_it[0].label = on_it[0].label or number


def _orbit_at(branch: OrbitBranch, value: float) -> PeriodicOrbit | None:
    """The orbit of a branch at a value between its ends."""
    nearest = int(np.argmin(np.abs(branch.parameter - value)))
    orbit, at = branch.orbits[nearest], branch.parameter[nearest]
    if at == value:
        return orbit
    lower, upper = sorted((float(at), value))
    piece = orbit_branch(orbit, branch.quantity, lower=lower, upper=upper, step=upper - lower)
    orbit = piece.orbits[0 if value < at else -1]
    return orbit if getattr(orbit.parameters, branch.quantity) == value else None
