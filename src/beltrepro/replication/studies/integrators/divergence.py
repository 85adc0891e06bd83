"""How trajectories of two integrators from the same state part, and how that depends on the step.

Arrays of trajectories are those of a dataset of kind series, with one row for each run: n_blocks,
belt_velocity, replicate, time_step, allowed_error (NaN for a method without a tolerance) (R,);
positions (R, T, N), NaN for blocks that a chain lacks, at the instants time (T,); events, a
structured array with point (the row), time, block and kind, in order of row and time; and step
(R,), see `with_steps`. Model units.
"""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from operator import itemgetter

import numpy as np
import numpy.typing as npt
import pandas as pd
import scipy

from beltrepro.model import ChainParameters
from beltrepro.replication.plan.points import CHAIN
from beltrepro.replication.studies.integrators.steps import mean_step

PLACE = ("n_blocks", "belt_velocity")
AFTER_EVENTS = (0, 1, 2, 5, 10, 20, 50)  # numbers of events after which errors are taken
FIRST_EVENTS = 10
PARTED = 1.0  # trajectories are apart when a block differs by this; springs are 50 long
_EVENT_TOLERANCE = 0.5  # events of one block further apart in time than this are different ones
ROUNDING = 1e-9  # errors below come from rounding, not from the step
ROUNDING_OF_LONG_STEPS = 1e-11  # of steps that a tolerance allows: there are a thousandth as many


Runs = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Pair:
    """One run and its reference, which began in the same state."""

    time: np.ndarray = field(repr=False)  # instants of the samples, model time
    separation: np.ndarray = field(repr=False)  # largest distance of any block between the two
    event_time: np.ndarray = field(repr=False)  # instants of shared events in the reference
    event_shift: np.ndarray = field(repr=False)  # how much later they come in the run
    reference_events: np.ndarray = field(repr=False)  # instants of all events of the reference

    @property
    def parting_time(self) -> float:
        """First instant at which the separation exceeds PARTED; inf if it never does."""
        beyond = np.flatnonzero(self.separation > PARTED)
        return float(self.time[beyond[0]]) if beyond.size else np.inf

    def error_after(self, n_events: int) -> float:
        """Separation at the first sample after so many events."""
        if n_events == 0:
            before = self.time < self.reference_events.min(initial=np.inf)
            return float(self.separation[before].max(initial=0.0))
        if n_events > self.reference_events.size:
            return np.nan
        sample = np.searchsorted(self.time, self.reference_events[n_events - 1], side="right")
        return float(self.separation[sample]) if sample < self.time.size else np.nan


def with_steps(runs: Runs) -> Runs:
    """Add the mean length of the steps: dt, or what the allowed error permits."""
    steps = runs["time_step"].copy()
    for row in np.flatnonzero(np.isfinite(runs["allowed_error"])):
        chain = ChainParameters(**{name: runs[name][row].item() for name in CHAIN})
        positions, velocities = (
            runs[name][row][:, : chain.n_blocks] for name in ("positions", "velocities")
        )
        steps[row] = mean_step(positions, velocities, chain, runs["allowed_error"][row])
    return {**runs, "step": steps}


def equal(values: np.ndarray, value: float) -> np.ndarray:
    """Which of the values are this one, up to rounding."""
    return np.isclose(values, value, rtol=1e-9, atol=0)


def pairs(
    runs: Runs, reference: Runs, *, rows: np.ndarray, reference_rows: np.ndarray
) -> dict[tuple, list[Pair]]:
    """Some runs beside their references; a run without a reference is left out."""
    base = {_key(reference, row): row for row in np.flatnonzero(reference_rows).tolist()}
    by_place: dict[tuple, list[Pair]] = {}
    for row in np.flatnonzero(rows).tolist():
        key = _key(runs, row)
        if key in base:
            by_place.setdefault(key[:2], []).append(_pair(runs, row, reference, base[key]))
    return by_place


def match_events(tested: np.ndarray, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Events that two runs share.

    Block by block, events correspond in their order until the kinds differ or the times by more
    than 0.5; what comes later in that block is not shared.
    """
    times, shifts = [np.empty(0)], [np.empty(0)]
    for block in np.unique(reference["block"]):
        sides = [events[events["block"] == block] for events in (tested, reference)]
        count = min(side.size for side in sides)
        first, second = (side[:count] for side in sides)
        shift = first["time"] - second["time"]
        same = (first["kind"] == second["kind"]) & (np.abs(shift) < _EVENT_TOLERANCE)
        shared = count if same.all() else int(np.argmin(same))
        times.append(second["time"][:shared])
        shifts.append(shift[:shared])
    times, shifts = np.concatenate(times), np.concatenate(shifts)
    order = np.argsort(times, kind="stable")
    return times[order], shifts[order]


def root_mean_square(errors: np.ndarray) -> np.ndarray:
    """Over the first axis: the starts."""
    return np.sqrt(np.mean(errors**2, axis=0))


def convergence_order(
    step: npt.ArrayLike, error: npt.ArrayLike, *, rounding: float = ROUNDING
) -> tuple[float, float]:
    """Order q of error = c * step**q, from a straight line through the logarithms."""
    step, error = np.asarray(step, dtype=float), np.asarray(error, dtype=float)
    above = error > rounding
    if above.sum() < 3:
        return np.nan, np.nan
    line = scipy.stats.linregress(np.log(step[above]), np.log(error[above]))
    return float(line.slope), float(line.stderr)


# --- rows of partings.csv and convergence.csv -----------------------------------------------------


def partings(runs: Runs, reference: Runs) -> list[dict]:
    """When runs part from those of the reference with the smallest step: a row a point and step."""
    return [
        {name: at_point[name] for name in (*PLACE, "time_step")} | _summary(members)
        for at_point, members in _by_step(runs, reference)
    ]


def errors_by_step(runs: Runs, reference: Runs) -> list[dict]:
    """Errors against the runs of the reference with the smallest step."""
    errors = [
        {"varied": "time_step"} | row
        for at_point, members in _by_step(runs, reference)
        for row in _errors(at_point, members)
    ]
    return _with_orders(errors, rounding=ROUNDING)


def errors_by_tolerance(runs: Runs) -> list[dict]:
    """Errors of runs with several tolerances against those with the tightest."""
    allowed = runs["allowed_error"]
    tolerances = np.unique(allowed[np.isfinite(allowed)])
    errors = []
    for tolerance in tolerances[:0:-1]:
        rows, tightest = equal(allowed, tolerance), equal(allowed, tolerances[0])
        for at_point, members in _by_point(runs, rows, runs, tightest):
            errors += [{"varied": "tolerance"} | row for row in _errors(at_point, members)]
    return _with_orders(errors, rounding=ROUNDING_OF_LONG_STEPS)


def _by_step(runs: Runs, reference: Runs) -> Iterator[tuple[dict, list[Pair]]]:
    """Pairs of each time step and point; a run of the reference is not compared with itself."""
    smallest = reference["time_step"].min()
    for step in np.unique(runs["time_step"]):
        if runs is not reference or not equal(step, smallest):
            rows, base = equal(runs["time_step"], step), equal(reference["time_step"], smallest)
            yield from _by_point(runs, rows, reference, base)


def _by_point(
    runs: Runs, rows: np.ndarray, reference: Runs, reference_rows: np.ndarray
) -> Iterator[tuple[dict, list[Pair]]]:
    """Pairs of each point, with the point, time_step, tolerance and mean step of the runs."""
    by_place = pairs(runs, reference, rows=rows, reference_rows=reference_rows)
    for place, members in sorted(by_place.items()):
        here = rows & np.all([runs[name] == at for name, at in zip(PLACE, place, strict=True)], 0)
        first = np.flatnonzero(here)[0]
        yield (
            dict(zip(PLACE, place, strict=True))
            | {
                "time_step": float(runs["time_step"][first]),
                "tolerance": float(runs["allowed_error"][first]),
                "step": float(runs["step"][here].mean()),
            },
            members,
        )


def _summary(members: list[Pair]) -> dict[str, float]:
    """Pairs of one point in numbers, medians over its members."""
    numbers = [
        {
            "parting_time": pair.parting_time,
            "shared_events": pair.event_time.size,
            "reference_events": pair.reference_events.size,
            "first_shift": np.abs(pair.event_shift[:FIRST_EVENTS]).max(initial=-1),
            "shift": np.abs(pair.event_shift).max(initial=-1),
        }
        for pair in members
    ]
    shifts = pd.DataFrame(numbers).mask(lambda table: table < 0)  # no shared event, no shift
    return {"members": len(members)} | shifts.median().to_dict()


def _errors(at_step: dict, members: list[Pair]) -> list[dict]:
    """Root-mean-square error after each number of AFTER_EVENTS that all members have.

    The phase of an event within a step decides its error, so one member alone tells little.
    """
    rows = []
    for n_events in AFTER_EVENTS:
        values = np.array([pair.error_after(n_events) for pair in members])
        if np.isfinite(values).all():
            after = {"after_events": n_events, "members": values.size}
            rows.append(at_step | after | {"error": float(root_mean_square(values))})
    return rows


def _with_orders(errors: list[dict], *, rounding: float) -> list[dict]:
    point = itemgetter(*PLACE, "after_events")
    rows = []
    for _, group in itertools.groupby(sorted(errors, key=point), point):
        at_point = list(group)
        steps, sizes = ([row[name] for row in at_point] for name in ("step", "error"))
        order, order_error = convergence_order(steps, sizes, rounding=rounding)
        rows += [row | {"order": order, "order_error": order_error} for row in at_point]
    return rows


# --- pairs ----------------------------------------------------------------------------------------


def _pair(runs: Runs, row: int, reference: Runs, base: int) -> Pair:
    events = reference["events"][reference["events"]["point"] == base]
    shared = match_events(runs["events"][runs["events"]["point"] == row], events)
    difference = (runs["positions"][row] - reference["positions"][base])[:, : runs["n_blocks"][row]]
    separation = np.abs(difference).max(axis=1)
    return Pair(runs["time"], separation, *shared, np.sort(events["time"]))


def _key(runs: Runs, row: int) -> tuple:
    return tuple(runs[name][row].item() for name in (*PLACE, "replicate"))
