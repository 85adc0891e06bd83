"""Basins of attraction: on which motion each start ends, and the same along a constant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError, ModelStateError, needing
from beltrepro.chaos.continuation import QUANTITIES, OrbitBranch, orbit_branch
from beltrepro.chaos.irregular import IRREGULAR, time_to_orbit
from beltrepro.chaos.periodic_orbits import PeriodicOrbit, check_noise, close_orbit, states_at
from beltrepro.chaos.vectors import check_method
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.simulation.groups import Report, check_progress
from beltrepro.simulation.results import Results
from beltrepro.simulation.setup import Chains, Setup, setup_of, with_setup
from beltrepro.simulation.tables import Tabled
from beltrepro.stats import estimates
from beltrepro.stats.motion import EQUILIBRIUM

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RUNS = 0.8  # share of the work, about, that the runs are
_SAME = 1e-5  # share by which periods, and states at the section, of one orbit may differ
_LONGEST = 200  # slips of an orbit that is followed: longer ones end within little of the quantity
_ALIKE = 0.5  # e-foldings of r by which neighbours of one irregular motion may differ


class Attractor(NamedTuple):
    """An attractor at one value of the quantity; that of the same label elsewhere is its branch."""

    value: float  # of the quantity
    label: int  # from 1
    state: str  # "periodic", "equilibrium slip" or "irregular"
    reached_by: int  # starts; 0: it is there, and none of them reaches it
    starts: int  # all of this value
    period_time: float  # NaN without
    period_events: int  # slips of all blocks in it, 0 without
    disorder_parameter: float
    mean_length: float
    orbit: PeriodicOrbit | None


@dataclass(frozen=True, eq=False, repr=False)
class Basins(Tabled):
    """Which attractor each of P starts reaches.

    Attractors are `periodic`, `irregular` (not settled within the duration: a transient perhaps)
    or `equilibrium slip`, the motion without any stick. Of the last there is one for each state of
    slipping blocks that never reach the belt; they count as one family.

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

    @property
    def labels(self) -> np.ndarray:
        """Labels of all attractors."""
        return np.unique([attractor.label for attractor in self.attractors])

    def _columns(self) -> dict[str, Any]:
        """What each attractor is, and the share of the starts that reach it with its interval."""
        rows = []
        for attractor in self.attractors:
            value, *columns = attractor[:-1]
            share = estimates.share(attractor.reached_by, attractor.starts)
            size = np.nan if attractor.orbit is None else abs(attractor.orbit.largest_multiplier)
            rows.append((value, *columns, size, *share.numbers))
        named = (self.quantity, *Attractor._fields[1:-1], "largest_multiplier")
        named += ("share", "share_low", "share_high")
        return dict(zip(named, zip(*rows, strict=True), strict=True))

    @names.checked
    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw r of the attractors and branches, and below the shares of the starts.

        Parameters
        ----------
        path : str or Path, optional
            A file for the figure, .png, .pdf or .svg; without it the figure is shown.

        Returns
        -------
        matplotlib.figure.Figure
            The figure.

        Raises
        ------
        InputError
            It is no path, or has another ending; or there is no display, or no matplotlib.
        """
        path = None if path is None else checks.path("path", path)
        with needing("the picture of basins"):
            from beltrepro.chaos.basins_picture import plot
        return plot(self, path)

    def __repr__(self) -> str:
        count, values = len(self.labels), self.values
        span = f"{values[0]:g}" if values.size == 1 else f"{values[0]:g} to {values[-1]:g}"
        starts = len(self.runs["attractor"])
        return f"Basins({count} attractors of {starts} starts, {self.quantity} {span})"


@with_setup
def basins(
    chains: Chains,
    *,
    duration: float,
    progress: Report | None = None,
    **setup: Any,
) -> Basins:
    """On which attractor each of P chains ends, by where it begins.

    Starts at rest come of `replicate=range(200), initial_spread=10` or of `initial_positions`, all
    others of `initial_state`, such as `slipping_state` makes. Chains may differ in one constant:
    there an attractor keeps its label as long as it is the same orbit (`orbit_branch`), which is
    followed up and down from wherever it was seen. So a branch is not lost where no start reaches
    it. Two runs reach one orbit if they have its period and its states at a section of the last
    block. Orbits of more than 200 slips are not followed, and have labels of their own. Irregular
    motions of neighbouring values are one if their r and <x_N> are about the same.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        P chains of one number of blocks, without noise.
    duration : float
        Model time after which a run counts as irregular.
    progress : callable, optional
        Called with the fraction done.
    **setup
        The keywords of `Setup`; the method must be "event".

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
    check_method(made.cases)
    for case in made.cases:
        check_noise(case.parameters)
    quantity = _differing(made)
    check_progress(progress)
    report = progress or (lambda done: None)
    runs = time_to_orbit(made, duration=duration, progress=lambda done: report(_RUNS * done))
    values, place = np.unique(runs[quantity], return_inverse=True)
    chains = [case.parameters for case in made.cases]
    by_value = [
        _motions(runs, chains, np.flatnonzero(place == number)) for number in range(len(values))
    ]
    branches = _label(by_value, quantity, values, lambda done: report(_RUNS + (1 - _RUNS) * done))
    label = np.zeros(len(place), dtype=int)
    for motion in (motion for motions in by_value for motion in motions):
        label[motion.starts] = motion.label
    runs["attractor"] = label
    counts = np.bincount(place)
    attractors = tuple(
        motion.attractor(float(value), int(count))
        for value, count, motions in zip(values, counts, by_value, strict=True)
        for motion in sorted(motions, key=lambda motion: motion.label)
    )
    return Basins(quantity, attractors, branches, runs)


def _differing(made: Setup) -> str:
    """The constant in which the chains differ."""
    first = made.cases[0].parameters
    chains = {case.parameters for case in made.cases}
    if len(sizes := {chain.n_blocks for chain in chains}) > 1:
        raise InputError(f"chains: of {len(sizes)} numbers of blocks, one is needed")
    differing = [
        name
        for name in QUANTITIES
        if any(getattr(chain, name) != getattr(first, name) for chain in chains)
    ]
    if len(differing) > 1:
        raise InputError(f"chains: differ in {', '.join(differing)}, in one of them they may")
    quantity = differing[0] if differing else "belt_velocity"
    if any(isinstance(getattr(chain, quantity), tuple) for chain in chains):
        raise InputError(f"chains: {quantity} differs among the blocks, one number is needed")
    return quantity


@dataclass(eq=False)
class _Motion:
    """An attractor at one value of the quantity."""

    state: str
    period_time: float
    period_events: int
    disorder_parameter: float
    mean_length: float
    orbit: PeriodicOrbit | None = None
    starts: list[int] = field(default_factory=list)  # rows of the runs that reach it
    label: int = 0  # none yet

    @classmethod
    def of_runs(cls, runs: Results, rows: Sequence[int]) -> _Motion:
        """That of some runs."""
        r, length = (
            float(np.mean(runs[name][rows])) for name in ("disorder_parameter", "mean_length")
        )
        first = rows[0]
        period = float(runs["period_time"][first]), int(runs["period_events"][first])
        return cls(str(runs["state"][first]), *period, r, length, starts=list(rows))

    @classmethod
    def of_orbit(cls, orbit: PeriodicOrbit) -> _Motion:
        """One that no start has reached."""
        period = orbit.period_time, orbit.period_events
        return cls("periodic", *period, orbit.disorder_parameter, orbit.mean_length, orbit)

    def close(self, state: ChainState) -> None:
        """Find its orbit, near one of its states, if it is not too long."""
        if self.period_events > _LONGEST:
            return
        try:
            self.orbit = close_orbit(state, self.period_time)
        except (
            InputError,
            ModelStateError,
        ):  # two events at one instant, say: the motion is periodic all the same
            return
        self.disorder_parameter = self.orbit.disorder_parameter
        self.mean_length = self.orbit.mean_length
        self.period_time = self.orbit.period_time

    def is_of(self, period_time: float, period_events: int, crossing: np.ndarray) -> bool:
        """Whether it is a periodic motion that comes down through a length in this state (2N,)."""
        same = period_events == self.period_events
        same = same and abs(period_time / self.period_time - 1) < _SAME
        if not same or self.orbit is None:
            return bool(same)
        state, n_blocks = self.orbit.state, len(crossing) // 2
        length = crossing[n_blocks - 1] + state.parameters.rest_positions[-1]
        apart = np.abs(states_at(state, self.period_time, length) - crossing).max(axis=1)
        return bool(np.any(apart < _SAME * np.abs(crossing).max()))

    def attractor(self, value: float, starts: int) -> Attractor:
        """It, as the result has it."""
        period = self.period_time, self.period_events
        numbers = self.disorder_parameter, self.mean_length
        count = len(self.starts)
        return Attractor(
            value, self.label, self.state, count, starts, *period, *numbers, self.orbit
        )


# --- at one value ---------------------------------------------------------------------------------


def _motions(runs: Results, chains: Sequence[ChainParameters], rows: np.ndarray) -> list[_Motion]:
    """The motions on which the runs of one value end, those of many starts first."""
    states = runs["state"][rows]
    motions = _irregular(runs, rows[states == IRREGULAR])
    if (sliding := rows[states == EQUILIBRIUM]).size:
        motions.append(_Motion.of_runs(runs, sliding.tolist()))
    periodic: list[_Motion] = []
    for row in rows[(states != IRREGULAR) & (states != EQUILIBRIUM)].tolist():
        crossing = runs["return_state"][row]
        period = float(runs["period_time"][row]), int(runs["period_events"][row])
        motion = next((motion for motion in periodic if motion.is_of(*period, crossing)), None)
        if motion is None:
            periodic.append(motion := _Motion.of_runs(runs, [row]))
            motion.close(_state_of(chains[row], crossing))
        else:
            motion.starts.append(row)
    return sorted([*motions, *periodic], key=lambda motion: -len(motion.starts))


def _irregular(runs: Results, rows: np.ndarray) -> list[_Motion]:
    """Irregular motions: those with a gap between their r are not one."""
    rows = rows[np.argsort(runs["disorder_parameter"][rows], kind="stable")]
    gaps = np.diff(np.log(runs["disorder_parameter"][rows])) > _ALIKE
    parts = np.split(rows, np.flatnonzero(gaps) + 1)
    return [_Motion.of_runs(runs, part.tolist()) for part in parts if part.size]


def _state_of(chain: ChainParameters, numbers: np.ndarray) -> ChainState:
    """The state of displacements and relative velocities, as `time_to_orbit` gives them."""
    displacements, relative = np.split(numbers, 2)
    return ChainState.in_motion(
        chain, displacements + chain.rest_positions, relative + chain.belt_velocity
    )


# --- along the quantity ---------------------------------------------------------------------------


def _label(
    by_value: list[list[_Motion]], quantity: str, values: np.ndarray, report: Report
) -> dict[int, OrbitBranch]:
    """Number all motions, one number for each branch; those that no start reached are added."""
    branches: dict[int, OrbitBranch] = {}
    number = 0
    for place in range(len(values)):
        for motion in list(by_value[place]):
            if motion.label:
                continue
            number += 1
            _spread(motion, number, place, by_value)
            if motion.orbit and len(values) > 1:
                branch = _branch(motion.orbit, quantity, values)
                if branch is not None:
                    branches[number] = branch
                    _join(branch, number, by_value, values)
        report((place + 1) / len(values))
    return branches


def _spread(motion: _Motion, number: int, place: int, by_value: list[list[_Motion]]) -> None:
    """Number a motion, and from there on those that are one with it by what they are alone."""
    motion.label = number
    for motions in by_value[place + 1 :] if motion.orbit is None else ():
        alike = [(_apart(motion, other), other) for other in motions if not other.label]
        nearest, other = min(alike, key=lambda pair: pair[0], default=(np.inf, motion))
        if nearest < _ALIKE:
            other.label, motion = number, other


def _apart(motion: _Motion, other: _Motion) -> float:
    """How far apart two motions without an orbit are: by r, and by <x_N> in its deviations."""
    if motion.state != other.state or motion.state == "periodic":
        return np.inf
    if motion.state == EQUILIBRIUM:
        return 0.0
    r = motion.disorder_parameter, other.disorder_parameter
    lengths = motion.mean_length, other.mean_length
    scale = max(r) * min(lengths)
    return float(np.hypot(np.log(r[0] / r[1]), (lengths[0] - lengths[1]) / scale))


def _branch(orbit: PeriodicOrbit, quantity: str, values: np.ndarray) -> OrbitBranch | None:
    """The branch of an orbit over all values."""
    try:
        return orbit_branch(orbit, quantity, lower=float(values[0]), upper=float(values[-1]))
    except (InputError, ModelStateError):  # the run went several times around
        return None


def _join(
    branch: OrbitBranch, number: int, by_value: list[list[_Motion]], values: np.ndarray
) -> None:
    """Number the motions on a branch; add it where it is and no start has reached it."""
    for value, motions in zip(values, by_value, strict=True):
        if not branch.lower <= value <= branch.upper:
            continue
        if any(motion.label == number for motion in motions):
            continue
        orbit = _orbit_at(branch, float(value))
        if orbit is None:
            continue
        period = orbit.period_time, orbit.period_events
        crossing = states_at(orbit.state, orbit.period_time, orbit.mean_length)[0]
        on_it = [motion for motion in motions if motion.orbit and motion.is_of(*period, crossing)]
        if not on_it:
            motions += (on_it := [_Motion.of_orbit(orbit)])
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
