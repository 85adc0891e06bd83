"""The kinds of datasets: for each what it is told besides its points, what records it, and which
arrays that makes.

From here follow what config.yaml may give, what a job is told, how files of batches are joined, and
what every array in a file says of itself. The code behind a dataset is that of its function.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pkgutil import resolve_name
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from beltrepro.model.friction import noise_beyond_event
from beltrepro.replication.plan.points import (
    QUANTITIES,
    UNITS,
    WORDS,
    Point,
    chain,
    columns,
    described,
)

POINT = "point"  # name of the axis along which batches are joined
SETTINGS = described(WORDS["settings"])
"""What all points of a dataset share and no axis can vary; types and defaults: config.Settings."""

Arrays = dict[str, np.ndarray]
Progress = Callable[[float], None]


class Array(NamedTuple):
    """One array of a file."""

    name: str
    unit: str  # a key of UNITS; empty for a table of records
    # names of its axes. Batches are joined along "point". A table of records has one axis of
    # another name and a field `point`, the row of its run
    dimensions: tuple[str, ...]
    symbol: str
    description: str
    fields: Mapping[str, str] = MappingProxyType(
        {}
    )  # of a table of records, the unit of each field

    def attributes(self) -> dict[str, str]:
        """Symbol, unit, dimensions and description, by name, as a file carries them."""
        words = {
            "symbol": self.symbol,
            "unit": UNITS[self.unit] if self.unit else "by field",
            "dimensions": ", ".join(self.dimensions),
            "description": self.description,
        }
        if self.fields:
            units = [f"{name}: {UNITS[unit]}" for name, unit in self.fields.items()]
            words["field_units"] = "; ".join(units)
        return words


Complaint = tuple[str, str] | None
"""Key and text of a value that fits its type and still cannot be meant."""


@dataclass(frozen=True)
class Kind:
    """What is recorded of the points of a dataset."""

    name: str  # its name in config.yaml
    settings: tuple[str, ...]  # what it is told besides points: names in SETTINGS
    record: str  # the function that records it, as module:function
    checks: tuple[Callable[[dict, Sequence[Point]], Complaint], ...] = ()

    @property
    def description(self) -> str:
        """One sentence."""
        return WORDS["kinds"][self.name]["description"]

    @property
    def recorded(self) -> tuple[Array, ...]:
        """What it records besides a column for each quantity."""
        return tuple(_array(*row) for row in WORDS["kinds"][self.name]["arrays"].items())

    def complaint(self, settings: dict, points: Sequence[Point]) -> Complaint:
        """The first value that fits its type and still cannot be meant."""
        complaints = [_law(points), *(check(settings, points) for check in self.checks)]
        return next(filter(None, complaints), None)

    @property
    def arrays(self) -> dict[str, Array]:
        """All arrays of a file by name: the columns of the points and what is recorded."""
        of_points = [
            Array(name, words.unit, (POINT,), words.symbol, words.description)
            for name, words in QUANTITIES.items()
        ]
        return {array.name: array for array in (*of_points, *self.recorded)}


def _array(name: str, row: str) -> Array:
    """An array as its row in words.yaml describes it."""
    unit, dimensions, symbol, text = map(str.strip, row.split("|", 3))
    fields = {}
    if " " in unit:  # a table of records
        fields, unit = dict(part.split(" ") for part in unit.split(", ")), ""
    return Array(name, unit, tuple(dimensions.split(", ")), symbol, text, fields)


# --- what fits its type and still cannot be meant -------------------------------------------------


def _shorter(name: str, settings: dict, points: Sequence[Point]) -> Complaint:
    if settings[name] < settings["duration"]:
        return None
    return name, f"= {settings[name]:g}: must be less than duration = {settings['duration']:g}"


_transient, _settle_time = (partial(_shorter, name) for name in ("transient", "settle_time"))


def _section(settings: dict, points: Sequence[Point]) -> Complaint:
    block, smallest = settings["section_block"], min(point.n_blocks for point in points)
    if block is None:
        return None
    if block > smallest:
        return "section_block", f"= {block}: the chain has {smallest} blocks"
    if settings["section_position"] is None:
        return "section_position", "is missing: only for the last block there is a rule"
    return None


def _samples(settings: dict, points: Sequence[Point]) -> Complaint:
    interval = settings["sample_interval"]
    for step in {point.time_step for point in points if point.method == "verlet"}:
        count = round(interval / step)
        if count < 1 or abs(count * step - interval) > 1e-9 * interval:  # as in simulation/sampling
            text = f"= {interval:g}: method verlet needs a multiple of time_step = {step:g}"
            return "sample_interval", text
    return None


def _tangent(settings: dict, points: Sequence[Point]) -> Complaint:
    methods = {point.method for point in points} - {"event"}
    if methods:
        return "method", f"= {methods.pop()}: only event has a tangent dynamics"
    return None


def _law(points: Sequence[Point]) -> Complaint:
    chains = {point[:8]: point for point in points if point.method == "event"}  # all but u
    wrong = (noise_beyond_event(chain(point)) for point in chains.values())
    return next((("noise", text) for text in wrong if text), None)


# --- functions ------------------------------------------------------------------------------------
# They are named, and imported where they run: to plan must not wait for numba.


def record(
    kind: str, points: Sequence[Point], settings: dict, progress: Progress | None = None
) -> Arrays:
    """Simulate points and record what their kind says."""
    from beltrepro.simulation.setup import Setup

    names = ("method", "time_step", "seed", "replicate", "initial_spread")
    numerics: dict = {name: [getattr(point, name) for point in points] for name in names}
    setup = Setup([chain(point) for point in points], **numerics)
    simulate: Callable[..., Arrays] = resolve_name(KINDS[kind].record)
    measured = simulate(setup, **settings, progress=progress)
    # a scan has more than its file: the sum rule, which says of each number that it is N k
    kept = {array.name for array in KINDS[kind].recorded}
    return columns(points) | {name: measured[name] for name in measured if name in kept}


def series(setup, *, samples, transient, **settings):
    """Samples from the transient on, those of smaller chains filled up with NaN, and events."""
    from beltrepro.simulation.trajectories import simulate

    runs = simulate(setup, transient=transient, sample_start=transient, **settings)
    shape = len(runs), runs[0].time.size, max(run.parameters.n_blocks for run in runs)
    sampled = {name: np.full(shape, np.nan) for name in samples}
    for row, run in enumerate(runs):
        for name, values in sampled.items():
            values[row, :, : run.parameters.n_blocks] = getattr(run, name)
    late = [run.events[run.events["time"] >= transient] for run in runs]
    return {
        "mean_length": np.array([run.mean_length for run in runs]),
        "disorder_parameter": np.array([run.disorder_parameter for run in runs]),
        "energy_residual": np.array([run.energy_residual for run in runs]),
        "time": runs[0].time,
        **sampled,
        "events": _with_point(late),
    }


def _with_point(tables: list[np.ndarray]) -> np.ndarray:
    """Tables of records, one for each run, as one with the row of the run in the field `point`."""
    fields = tables[0].dtype.descr
    joined = np.empty(sum(map(len, tables)), dtype=[("point", "i4"), *fields])
    joined["point"] = np.repeat(np.arange(len(tables)), list(map(len, tables)))
    for name, *_ in fields:
        joined[name] = np.concatenate([table[name] for table in tables])
    return joined


# --- kinds ----------------------------------------------------------------------------------------

KINDS = {
    kind.name: kind
    for kind in (
        Kind(
            "scan",
            ("duration", "transient", "section_position", "section_values", "laminar_time"),
            "beltrepro.simulation.scans:scan",
            (_transient,),
        ),
        Kind(
            "series",
            ("duration", "transient", "sample_interval", "samples"),
            "beltrepro.replication.plan.kinds:series",
            (_transient, _samples),
        ),
        Kind(
            "catalogue",
            ("duration", "transient", "section_block", "section_position"),
            "beltrepro.simulation.catalogues:catalogue",
            (_transient, _section),
        ),
        Kind(
            "escapes",
            ("duration", "settle_time", "laminar_time"),
            "beltrepro.simulation.scans:time_to_continuous_slip",
            (_settle_time,),
        ),
        Kind(
            "motion",
            ("duration", "transient", "noise_clock"),
            "beltrepro.chaos.naming:classify",
            (_transient, _tangent),
        ),
        Kind("settling", ("duration", "closed"), "beltrepro.chaos.irregular:time_to_orbit"),
        Kind(
            "trial",
            ("duration", "transient", "sample_interval", "laminar_time"),
            "beltrepro.replication.camera.trials:trials",
            (_transient,),
        ),
        Kind(
            "basins",
            ("duration", "energies"),
            "beltrepro.replication.plan.attractors:basin_starts",
            (_tangent,),
        ),
        Kind(
            "sweep",
            ("duration", "transient"),
            "beltrepro.replication.plan.attractors:sweeps",
            (_transient,),
        ),
    )
}
