"""The kinds of datasets: for each what it is told besides its points, what records it, and which
arrays that makes.

From here follow what config.yaml may give, what a job is told, how files of batches are joined, and
what every array in a file says of itself. The code behind a dataset is that of its function.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pkgutil import resolve_name
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from beltrepro.model.friction import noise_beyond_event
from beltrepro.model.parameters import LARGEST, LIMITS, LONGEST
from beltrepro.replication.plan.points import (
    QUANTITIES,
    UNITS,
    About,
    Number,
    Point,
    Whole,
    chain,
    columns,
    described,
)

POINT = "point"  # name of the axis along which batches are joined

Arrays = dict[str, np.ndarray]
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Array:
    """One array of a file."""

    name: str  # these four as of a quantity; the unit of a table of records is empty
    symbol: str
    unit: str
    # names of its axes. Batches are joined along "point". A table of records has one axis of
    # another name and a field `point`, the row of its run
    dimensions: tuple[str, ...]
    description: str
    # of a table of records, the unit of each field
    fields: dict[str, str] = field(default_factory=dict, hash=False)

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

    name: str  # its name in config.yaml; one sentence
    description: str
    settings: tuple[str, ...]  # what it is told besides points: names in SETTINGS
    record: str  # the function that records it, as module:function
    recorded: tuple[Array, ...]  # what it records besides a column for each quantity
    checks: tuple[Callable[[dict, Sequence[Point]], Complaint], ...] = ()
    kicks: bool = False  # whether its runs can be kicked

    def complaint(self, settings: dict, points: Sequence[Point]) -> Complaint:
        """The first value that fits its type and still cannot be meant."""
        complaints = [_kicked(self, points), _of_event(points), _law(points)]
        complaints += [check(settings, points) for check in self.checks]
        return next(filter(None, complaints), None)

    @property
    def arrays(self) -> dict[str, Array]:
        """All arrays of a file by name: the columns of the points and what is recorded."""
        of_points = [
            Array(name, about.symbol, about.unit, (POINT,), about.description)
            for name, about in QUANTITIES.items()
        ]
        return {array.name: array for array in (*of_points, *self.recorded)}


# --- settings -------------------------------------------------------------------------------------


def different(values: list) -> list:
    """Refuse a list in which a value occurs twice."""
    if any(value in values[:place] for place, value in enumerate(values)):
        raise PydanticCustomError("repeated", "the same value occurs twice")
    return values


LIST = (Field(min_length=1, json_schema_extra={"uniqueItems": True}), AfterValidator(different))
_TIME = Field(**LIMITS["duration"])


class Settings:
    """What all points of a dataset share and no axis can vary."""

    duration: Annotated[
        Number,
        About("t | time | Length of a run, transient included (Sec. IV.A; 2e6 in the paper)."),
        _TIME,
    ]
    transient: Annotated[
        Number,
        About(
            "t_trans | time | The part of the duration that is not measured (Sec. IV.A; 1e6 in the"
            " paper)."
        ),
        Field(ge=0, le=LONGEST),
    ]
    section_position: Annotated[
        Number | None,
        About(
            " | length | Position of the Poincare section, crossed with dx/dt < 0: of the last "
            "block in a scan, of section_block in a catalogue (Fig. 10, x_2 = 304.3). Null, only "
            "for the last block: 615 with five blocks (Fig. 12), the same share of the length at "
            "balance for other chains.",
            None,
        ),
        Field(gt=0, le=LARGEST),
    ]
    section_values: Annotated[
        Whole,
        About(
            " | 1 | How many values of v_N are kept at crossings of the section (Figs. 12, 14, 17,"
            " 22).",
            500,
        ),
        Field(ge=1, le=100_000),
    ]
    laminar_time: Annotated[
        Number,
        About(
            " | time | The last block must slip for longer than this without sticking to be in a "
            "laminar phase (Sec. IV.B, intermittency; the paper states no criterion).",
            200.0,
        ),
        _TIME,
    ]
    sample_interval: Annotated[
        Number,
        About(" | time | Time between samples (Figs. 7, 8, 11, 16, 20).", 0.1),
        _TIME,
    ]
    samples: Annotated[
        list[Literal["positions", "velocities", "friction"]],
        About(" | 1 | Which arrays of samples are kept.", ["positions", "velocities", "friction"]),
        *LIST,
    ]
    section_block: Annotated[
        Whole | None,
        About(
            " | 1 | Number of the block whose position defines the Poincare section (Fig. 10, "
            "block 2); null for the last one.",
            None,
        ),
        Field(**LIMITS["n_blocks"]),
    ]
    settle_time: Annotated[
        Number,
        About(" | time | Length of the end of a run by which the attractor reached is described."),
        _TIME,
    ]
    noise_clock: Annotated[
        Literal["rest", "laboratory"],
        About(
            " | 1 | What is the same noise for two chains: by the time since a rest of the whole "
            "chain, or by the time in the laboratory (docs/chaos.md).",
            "rest",
        ),
    ]
    closed: Annotated[
        Number,
        About(
            " | 1 | Distance of two states that count as one, as a share of the largest "
            "coordinate.",
            1e-8,
        ),
        Field(gt=0, lt=1),
    ]
    energies: Annotated[
        list[Annotated[Number, Field(ge=1e-3, le=1e4)]],
        About(
            " | energy | Energies H for each block of slipping states from which runs begin too "
            "(docs/physics.md).",
            [60.0, 200.0, 600.0],
        ),
        *LIST,
    ]
    distances: Annotated[
        list[Annotated[Number, Field(gt=0, le=10)]],
        About(
            " | length | How far the twins of a chain are moved at first, each by one of these.",
            [1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 1.0],
        ),
        *LIST,
    ]


SETTINGS = described(Settings)


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


def _kicked(kind: Kind, points: Sequence[Point]) -> Complaint:
    kicks = [point.kick for point in points if point.kick > 0]
    if kicks and not kind.kicks:
        return "kick", f"= {kicks[0]:g}: kind {kind.name} has none"
    return None


def _of_event(points: Sequence[Point]) -> Complaint:
    for point in points:
        for name, value in (("kick", point.kick or None), ("tolerance", point.tolerance)):
            if value is not None and point.method != "event":
                return name, f"= {value:g}: method {point.method} has none, only event"
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

    names = ("method", "time_step", "tolerance", "seed", "replicate", "initial_spread", "kick")
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
        "allowed_error": np.array([run.tolerance for run in runs], dtype=float),
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


def _arrays(*rows: str) -> tuple[Array, ...]:
    """Arrays from rows of name, symbol, unit, dimensions and description.

    A table of records has its fields with their units in place of symbol and unit.
    """
    made = []
    for row in rows:
        name, *middle, dimensions, text = row.split(" | ")
        symbol, unit = middle if len(middle) == 2 else ("", "")
        fields = {} if len(middle) == 2 else dict(part.split(" ") for part in middle[0].split(", "))
        made.append(Array(name, symbol, unit, tuple(dimensions.split(", ")), text, fields))
    return tuple(made)


_LENGTH = _arrays(
    "mean_length | <x_N> | length | point | Mean position of the last block after the transient.",
    "disorder_parameter | r | 1 | point | Standard deviation of x_N over its mean (Eq. 4).",
)

_RESIDUAL = _arrays(
    "energy_residual |  | 1 | point | Share of the belt's work that the energy audit does not "
    "account for.",
)

_PERIOD = _arrays(
    "period_time | T | time | point | Length of a period; NaN if the orbit does not close.",
    "period_events |  | 1 | point | Slips of all blocks in a period; 0 if it does not close.",
    "period_returns |  | 1 | point | Returns to the mean length in a period; 0 if it does not "
    "close.",
)

SCAN = Kind(
    "scan",
    "Numbers of each point: r, section velocities, slips, laminar phases (Figs. 12 to 22).",
    ("duration", "transient", "section_position", "section_values", "laminar_time"),
    "beltrepro.simulation.scans:scan",
    (
        *_LENGTH,
        *_arrays(
            "minimum_length |  | length | point | Smallest x_N after the transient.",
            "maximum_length |  | length | point | Largest x_N after the transient.",
        ),
        *_RESIDUAL,
        *_arrays(
            "section_position |  | length | point | Position of x_N that defines the section.",
            "section_count |  | 1 | point | Downward crossings of the section after the transient.",
            "section_velocity | v_N | velocity | point, crossing | Velocity of the last block "
            "(laboratory frame) at its first crossings; then NaN.",
            "slip_count |  | 1 | point, block | Slips of each block after the transient; 0 for "
            "blocks that a chain lacks.",
            "laminar_fraction |  | 1 | point | Share of the time in laminar phases.",
            "laminar_count |  | 1 | point | Number of laminar phases.",
            "laminar_mean |  | time | point | Mean length of a laminar phase.",
            "laminar_longest |  | time | point | Length of the longest laminar phase.",
            "last_stick_time |  | time | point | Last stick of the last block; NaN if it never "
            "stuck.",
        ),
    ),
    (_transient,),
)

SERIES = Kind(
    "series",
    "Sampled runs, from the end of the transient on, with their events (Figs. 7, 8, 11, 16, 20).",
    ("duration", "transient", "sample_interval", "samples"),
    "beltrepro.replication.plan.kinds:series",
    (
        *_LENGTH,
        *_RESIDUAL,
        *_arrays(
            "allowed_error |  | force | point | Truncation error allowed in a step; NaN for a "
            "method without a tolerance.",
            "time | t | time | time | Instants of the samples.",
            "positions | x_i | length | point, time, block | From the wall.",
            "velocities |  | velocity | point, time, block | Laboratory frame.",
            "friction | F_f | force | point, time, block | Friction force on each block; while it "
            "is stuck minus the external force.",
            "events | point 1, time time, block 1, kind 1, force force, position length, "
            "dissipated energy | event | Slips and sticks in order of run and time; a reversal is "
            "a stick and a slip at once.",
        ),
    ),
    (_transient, _samples),
)

CATALOGUE = Kind(
    "catalogue",
    "Slips, avalanches and section points of each run after the transient (Figs. 9, 10).",
    ("duration", "transient", "section_block", "section_position"),
    "beltrepro.simulation.catalogues:catalogue",
    _arrays(
        "slips | point 1, block 1, start_time time, stop_time time, start_position length, "
        "stop_position length, dissipated energy | slip | Slips of every block that start after "
        "the transient.",
        "avalanches | point 1, start_time time, stop_time time, slips 1, blocks 1, dissipated "
        "energy, spring_energy_drop energy, last_block_displacement length | avalanche | "
        "Overlapping slips of all blocks, from the first start to the last stop.",
        "section | point 1, time time, positions length, velocities velocity | crossing | States "
        "at the crossings of the section, in the laboratory frame.",
    ),
    (_transient, _section),
)

ESCAPES = Kind(
    "escapes",
    "When the last block of each run came to slip for good, and the state then (inset of Fig. 12).",
    ("duration", "settle_time", "laminar_time"),
    "beltrepro.simulation.scans:time_to_continuous_slip",
    _arrays(
        "lifetime | tau | time | point | Last stick of the last block; duration if not escaped.",
        "escaped |  | 1 | point | Whether the last block slips on to the end of the run.",
        "final_disorder | r | 1 | point | r over the end of the run (settle_time).",
        "final_mean_length | <x_N> | length | point | Mean of x_N over the end of the run.",
        "final_amplitude |  | length | point | Range of x_N over the end of the run.",
        "final_stick_rate |  | 1/time | point, block | Sticks of each block per time over the end "
        "of the run.",
    ),
    (_settle_time,),
)

MOTION = Kind(
    "motion",
    "Name, period and largest Lyapunov exponent of the motion after the transient (docs/chaos.md).",
    ("duration", "transient", "noise_clock"),
    "beltrepro.chaos:classify",
    (
        *_arrays(
            "state |  | 1 | point | Name of the motion.",
        ),
        *_PERIOD,
        *_arrays(
            "largest_exponent | lambda_1 | 1/time | point | Largest Lyapunov exponent after the "
            "transient.",
            "standard_error |  | 1/time | point | Its standard error.",
        ),
        *_LENGTH,
    ),
    (_transient, _tangent),
)

SETTLING = Kind(
    "settling",
    "How long the motion is irregular, and what it settles on (docs/chaos.md).",
    ("duration", "closed"),
    "beltrepro.chaos:time_to_orbit",
    (
        *_arrays(
            "settled |  | 1 | point | Whether the motion settled within the duration.",
            "lifetime | tau | time | point | How long the motion was irregular; the duration if it"
            " did not settle.",
            "state |  | 1 | point | Name of the motion at the end.",
        ),
        *_PERIOD,
        *_arrays(
            "irregular_exponent | lambda_1 | 1/time | point | Largest Lyapunov exponent of the "
            "irregular motion; NaN if that was short.",
            "irregular_error |  | 1/time | point | Its standard error.",
            "irregular_time |  | time | point | Time over which it was measured.",
        ),
        *_LENGTH,
        *_arrays(
            "return_state |  |  | point, coordinate | Displacements, then relative velocities, at "
            "the last return to a section of the last block; model lengths and velocities, NaN "
            "padded.",
        ),
    ),
    kicks=True,
)

SEPARATION = Kind(
    "separation",
    "When runs that begin close together are first apart by each of several levels "
    "(docs/chaos.md).",
    ("duration", "transient", "distances"),
    "beltrepro.chaos:separation",
    _arrays(
        "levels |  | length | level | Distances, in ascending order.",
        "distances |  | length | twin | How far the twins of a chain are at first.",
        "passage_time |  | time | point, twin, level | Time since the twins were moved at which "
        "one was first further away than a level; NaN where it never was, or begins further away.",
    ),
    (_transient,),
    kicks=True,
)

BASINS = Kind(
    "basins",
    "Which attractor each start reaches, from rest and from slipping states, and the branches of "
    "orbits along u (docs/chaos.md).",
    ("duration", "energies"),
    "beltrepro.replication.plan.attractors:basin_starts",
    _arrays(
        "start_energy |  | energy | start | Energy H for each block of the slipping state in which "
        "runs begin; 0 for starts at rest.",
        "attractor |  | 1 | point, start | Label of the attractor reached; holds for one N.",
        "state |  | 1 | point, start | Name of the motion reached.",
        "lifetime | tau | time | point, start | How long the motion was irregular; the duration if "
        "it did not settle.",
        "period_events |  | 1 | point, start | Slips of all blocks in a period; 0 without.",
        "disorder_parameter | r | 1 | point, start | r of the settled motion, or of the end.",
        "attractors | point 1, attractor 1, state 1, period_time time, period_events 1, "
        "largest_multiplier 1, disorder_parameter 1 | attractor | Attractors at each belt velocity,"
        " by its first point; also those that no start reached.",
        "branches | point 1, attractor 1, belt_velocity velocity, disorder_parameter 1, "
        "period_time time, period_events 1, end 1, end_block 1 | orbit | Orbits of each branch, "
        "followed along u, and how it ends at its first and last; by the first point of the lowest "
        "belt velocity of its attractor.",
    ),
    (_tangent,),
)

SWEEP = Kind(
    "sweep",
    "r on the way up in u and down again, each point from the end of the one before.",
    ("duration", "transient"),
    "beltrepro.replication.plan.attractors:sweeps",
    _arrays(
        "mean_length | <x_N> | length | point, way | Mean position of the last block after the "
        "transient; up, then down.",
        "disorder_parameter | r | 1 | point, way | r of the same.",
    ),
    (_transient,),
)

TRIAL = Kind(
    "trial",
    "What a recording of the experiment's kind would tell of each run: r, stretches of small "
    "amplitude (docs/experiment.md).",
    ("duration", "transient", "sample_interval", "laminar_time"),
    "beltrepro.replication.camera.trials:trials",
    (
        *_LENGTH,
        *_arrays(
            "small_share |  | 1 | point | Share of the time with small amplitude, as in a film.",
            "lasting_share |  | 1 | point | Share of the time in small amplitudes that last.",
            "lasting_count |  | 1 | point | Number of stretches of small amplitude that last.",
            "lasting_longest |  | time | point | Length of the longest of them.",
            "lively_longest |  | time | point | Longest time between them.",
            "slip_longest |  | time | point | Longest time in which the last block does not stick.",
            "all_slip_longest |  | time | point | Longest time in which no block sticks.",
        ),
    ),
    (_transient,),
)

KINDS = {
    kind.name: kind
    for kind in (
        *(SCAN, SERIES, CATALOGUE, ESCAPES, MOTION, SETTLING, SEPARATION, TRIAL),
        *(BASINS, SWEEP),
    )
}
