"""The kinds of datasets: what each is told besides its points, and which arrays it records.

From these tables follow the schema of config.yaml, what a job is told, how files of batches are
joined, and what every array in a file says of itself. `running` has the function of each kind.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from beltrepro.model.friction import noise_beyond_event
from beltrepro.model.parameters import LARGEST, LONGEST
from beltrepro.replication.plan.points import Point, chain
from beltrepro.replication.plan.quantities import QUANTITIES, REQUIRED, UNITS

POINT = "point"  # name of the axis along which batches are joined
MAXIMUM_SCAN_BLOCKS = 10  # columns of slip_count


@dataclass(frozen=True)
class Setting:
    """What all points of a dataset share and no axis can vary; fields as of `Quantity`."""

    name: str
    symbol: str
    unit: str
    description: str
    schema: dict = field(hash=False)
    default: object = REQUIRED


@dataclass(frozen=True)
class Array:
    """One array of a file."""

    name: str  # as of `Quantity`; the unit of a table of records is empty
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


@dataclass(frozen=True)
class Kind:
    """What is recorded of the points of a dataset."""

    name: str  # its name in config.yaml; one sentence
    description: str
    settings: tuple[Setting, ...]  # what it is told besides points
    recorded: tuple[Array, ...]  # what it records besides a column for each quantity
    # complaint(settings, points) -> (key, text) of the first value that no schema can refuse, or
    # None
    complaint: Callable[[dict, Sequence[Point]], tuple[str, str] | None]
    kicks: bool = False  # whether its runs can be kicked

    def first_complaint(self, settings: dict, points: Sequence[Point]) -> tuple[str, str] | None:
        """Key and text of the first value that no schema can refuse."""
        complaints = _kicked(self, points), _tolerance(points), _law(points)
        return _first(*complaints, self.complaint(settings, points))

    @property
    def arrays(self) -> dict[str, Array]:
        """All arrays of a file by name: the columns of the points and what is recorded."""
        columns = {
            each.name: Array(each.name, each.symbol, each.unit, (POINT,), each.description)
            for each in QUANTITIES.values()
        }
        return columns | {each.name: each for each in self.recorded}


# --- settings -------------------------------------------------------------------------------------

_TIME = {"type": "number", "exclusiveMinimum": 0, "maximum": LONGEST}

DURATION = Setting(
    "duration",
    "t",
    "time",
    "Length of a run, transient included (Sec. IV.A; 2e6 in the paper).",
    _TIME,
)
TRANSIENT = Setting(
    "transient",
    "t_trans",
    "time",
    "The part of the duration that is not measured (Sec. IV.A; 1e6 in the paper).",
    {"type": "number", "minimum": 0, "maximum": LONGEST},
)
LAMINAR_TIME = Setting(
    "laminar_time",
    "",
    "time",
    "The last block must slip for longer than this without sticking to be in a laminar phase "
    "(Sec. IV.B, intermittency; the paper states no criterion).",
    _TIME,
    200.0,
)
SECTION_VALUES = Setting(
    "section_values",
    "",
    "1",
    "How many values of v_N are kept at crossings of the section (Figs. 12, 14, 17, 22).",
    {"type": "integer", "minimum": 1, "maximum": 100_000},
    500,
)
SECTION_POSITION = Setting(
    "section_position",
    "",
    "length",
    "Position of the Poincare section, crossed with dx/dt < 0: of the last block in a scan, of "
    "section_block in a catalogue (Fig. 10, x_2 = 304.3). Null, only for the last block: 615 with "
    "five blocks (Fig. 12), the same share of the length at balance for other chains.",
    {"type": ["number", "null"], "exclusiveMinimum": 0, "maximum": LARGEST},
    None,
)
SECTION_BLOCK = Setting(
    "section_block",
    "",
    "1",
    "Number of the block whose position defines the Poincare section (Fig. 10, block 2); null for "
    "the last one.",
    {"type": ["integer", "null"], "minimum": 1, "maximum": 64},
    None,
)
SAMPLE_INTERVAL = Setting(
    "sample_interval",
    "",
    "time",
    "Time between samples (Figs. 7, 8, 11, 16, 20).",
    _TIME,
    0.1,
)
SAMPLES = Setting(
    "samples",
    "",
    "1",
    "Which arrays of samples are kept.",
    {
        "type": "array",
        "minItems": 1,
        "uniqueItems": True,
        "items": {"enum": ["positions", "velocities", "friction"]},
    },
    ["positions", "velocities", "friction"],
)
SETTLE_TIME = Setting(
    "settle_time",
    "",
    "time",
    "Length of the end of a run by which the attractor reached is described.",
    _TIME,
)

NOISE_CLOCK = Setting(
    "noise_clock",
    "",
    "1",
    "What is the same noise for two chains: by the time since a rest of the whole chain, or by the "
    "time in the laboratory (docs/chaos.md).",
    {"enum": ["rest", "laboratory"]},
    "rest",
)
CLOSED = Setting(
    "closed",
    "",
    "1",
    "Distance of two states that count as one, as a share of the largest coordinate.",
    {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1},
    1e-8,
)

DISTANCES = Setting(
    "distances",
    "",
    "length",
    "How far the twins of a chain are moved at first, each by one of these.",
    {
        "type": "array",
        "minItems": 1,
        "uniqueItems": True,
        "items": {"type": "number", "exclusiveMinimum": 0, "maximum": 10},
    },
    [1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 1.0],
)


def _first(*complaints):
    return next((found for found in complaints if found), None)


def _lengths(settings: dict) -> tuple[str, str] | None:
    duration, transient = settings["duration"], settings["transient"]
    if transient >= duration:
        return "transient", f"= {transient:g}: must be less than duration = {duration:g}"
    return None


def _settle_time(settings: dict, points: Sequence[Point]) -> tuple[str, str] | None:
    duration, settle_time = settings["duration"], settings["settle_time"]
    if settle_time >= duration:
        return "settle_time", f"= {settle_time:g}: must be less than duration = {duration:g}"
    return None


def _sizes(points, limit):
    largest = max(point.n_blocks for point in points)
    if largest > limit:
        return "n_blocks", f"= {largest}: a scan takes at most {limit} blocks"
    return None


def _section(settings, points):
    block, smallest = settings["section_block"], min(point.n_blocks for point in points)
    if block is None:
        return None
    if block > smallest:
        return "section_block", f"= {block}: the chain has {smallest} blocks"
    if settings["section_position"] is None:
        return "section_position", "is missing: only for the last block there is a rule"
    return None


def _kicked(kind, points):
    for point in points:
        if point.kick > 0 and not kind.kicks:
            return "kick", f"= {point.kick:g}: kind {kind.name} has none"
        if point.kick > 0 and point.method != "event":
            return "kick", f"= {point.kick:g}: method {point.method} has none, only event"
    return None


def _tolerance(points):
    for point in points:
        if point.tolerance is not None and point.method != "event":
            return "tolerance", f"= {point.tolerance:g}: method {point.method} has none, only event"
    return None


def _law(points):
    chains = {point[:8]: point for point in points if point.method == "event"}  # all but u
    wrong = (noise_beyond_event(chain(point)) for point in chains.values())
    return next((("noise", text) for text in wrong if text), None)


def _samples(settings, points):
    interval = settings["sample_interval"]
    for step in {point.time_step for point in points if point.method == "verlet"}:
        count = round(interval / step)
        if count < 1 or abs(count * step - interval) > 1e-9 * interval:  # as in simulation/sampling
            text = f"= {interval:g}: method verlet needs a multiple of time_step = {step:g}"
            return "sample_interval", text
    return None


def _tangent(points):
    methods = {point.method for point in points} - {"event"}
    if methods:
        return "method", f"= {methods.pop()}: only event has a tangent dynamics"
    return None


# --- arrays ---------------------------------------------------------------------------------------


def _of_points(*rows: tuple[str, str, str, str]) -> tuple[Array, ...]:
    """Arrays (P,) from rows of name, symbol, unit and description."""
    return tuple(Array(name, symbol, unit, (POINT,), text) for name, symbol, unit, text in rows)


_LENGTH = _of_points(
    ("mean_length", "<x_N>", "length", "Mean position of the last block after the transient."),
    ("disorder_parameter", "r", "1", "Standard deviation of x_N over its mean (Eq. 4)."),
)
_RESIDUAL = _of_points(
    (
        "energy_residual",
        "",
        "1",
        "Share of the belt's work that the energy audit does not account for.",
    ),
)

_PERIOD = _of_points(
    ("period_time", "T", "time", "Length of a period; NaN if the orbit does not close."),
    ("period_events", "", "1", "Slips of all blocks in a period; 0 if it does not close."),
    ("period_returns", "", "1", "Returns to the mean length in a period; 0 if it does not close."),
)

SCAN = Kind(
    "scan",
    "Numbers of each point: r, section velocities, slips, laminar phases (Figs. 12 to 22).",
    (DURATION, TRANSIENT, SECTION_POSITION, SECTION_VALUES, LAMINAR_TIME),
    (
        *_LENGTH,
        *_of_points(
            ("minimum_length", "", "length", "Smallest x_N after the transient."),
            ("maximum_length", "", "length", "Largest x_N after the transient."),
        ),
        *_RESIDUAL,
        *_of_points(
            ("section_position", "", "length", "Position of x_N that defines the section."),
            ("section_count", "", "1", "Downward crossings of the section after the transient."),
        ),
        Array(
            "section_velocity",
            "v_N",
            "velocity",
            (POINT, "crossing"),
            "Velocity of the last block (laboratory frame) at its first crossings; then NaN.",
        ),
        Array(
            "slip_count",
            "",
            "1",
            (POINT, "block"),
            "Slips of each block after the transient; 0 for blocks that a chain lacks.",
        ),
        *_of_points(
            ("laminar_fraction", "", "1", "Share of the time in laminar phases."),
            ("laminar_count", "", "1", "Number of laminar phases."),
            ("laminar_mean", "", "time", "Mean length of a laminar phase."),
            ("laminar_longest", "", "time", "Length of the longest laminar phase."),
            ("last_stick_time", "", "time", "Last stick of the last block; NaN if it never stuck."),
        ),
    ),
    lambda settings, points: _first(_lengths(settings), _sizes(points, MAXIMUM_SCAN_BLOCKS)),
)

SERIES = Kind(
    "series",
    "Sampled runs, from the end of the transient on, with their events (Figs. 7, 8, 11, 16, 20).",
    (DURATION, TRANSIENT, SAMPLE_INTERVAL, SAMPLES),
    (
        *_LENGTH,
        *_RESIDUAL,
        *_of_points(
            (
                "allowed_error",
                "",
                "force",
                "Truncation error allowed in a step; NaN for a method without a tolerance.",
            ),
        ),
        Array("time", "t", "time", ("time",), "Instants of the samples."),
        Array("positions", "x_i", "length", (POINT, "time", "block"), "From the wall."),
        Array("velocities", "", "velocity", (POINT, "time", "block"), "Laboratory frame."),
        Array(
            "friction",
            "F_f",
            "force",
            (POINT, "time", "block"),
            "Friction force on each block; while it is stuck minus the external force.",
        ),
        Array(
            "events",
            "",
            "",
            ("event",),
            "Slips and sticks in order of run and time; a reversal is a stick and a slip at once.",
            {
                "point": "1",
                "time": "time",
                "block": "1",
                "kind": "1",
                "force": "force",
                "position": "length",
                "dissipated": "energy",
            },
        ),
    ),
    lambda settings, points: _first(_lengths(settings), _samples(settings, points)),
)

CATALOGUE = Kind(
    "catalogue",
    "Slips, avalanches and section points of each run after the transient (Figs. 9, 10).",
    (DURATION, TRANSIENT, SECTION_BLOCK, SECTION_POSITION),
    (
        Array(
            "slips",
            "",
            "",
            ("slip",),
            "Slips of every block that start after the transient.",
            {
                "point": "1",
                "block": "1",
                "start_time": "time",
                "stop_time": "time",
                "start_position": "length",
                "stop_position": "length",
                "dissipated": "energy",
            },
        ),
        Array(
            "avalanches",
            "",
            "",
            ("avalanche",),
            "Overlapping slips of all blocks, from the first start to the last stop.",
            {
                "point": "1",
                "start_time": "time",
                "stop_time": "time",
                "slips": "1",
                "blocks": "1",
                "dissipated": "energy",
                "spring_energy_drop": "energy",
                "last_block_displacement": "length",
            },
        ),
        Array(
            "section",
            "",
            "",
            ("crossing",),
            "States at the crossings of the section, in the laboratory frame.",
            {"point": "1", "time": "time", "positions": "length", "velocities": "velocity"},
        ),
    ),
    lambda settings, points: _first(_lengths(settings), _section(settings, points)),
)

ESCAPES = Kind(
    "escapes",
    "When each run left the chaotic saddle, and the state that it reached (inset of Fig. 12).",
    (DURATION, SETTLE_TIME, LAMINAR_TIME),
    (
        *_of_points(
            ("lifetime", "tau", "time", "Last stick of the last block; duration if not escaped."),
            ("escaped", "", "1", "Whether the last block slips on to the end of the run."),
            ("final_disorder", "r", "1", "r over the end of the run (settle_time)."),
            ("final_mean_length", "<x_N>", "length", "Mean of x_N over the end of the run."),
            ("final_amplitude", "", "length", "Range of x_N over the end of the run."),
        ),
        Array(
            "final_stick_rate",
            "",
            "1/time",
            (POINT, "block"),
            "Sticks of each block per time over the end of the run.",
        ),
    ),
    _settle_time,
)

MOTION = Kind(
    "motion",
    "Name, period and largest Lyapunov exponent of the motion after the transient (docs/chaos.md).",
    (DURATION, TRANSIENT, NOISE_CLOCK),
    (
        *_of_points(("state", "", "1", "Name of the motion.")),
        *_PERIOD,
        *_of_points(
            (
                "largest_exponent",
                "lambda_1",
                "1/time",
                "Largest Lyapunov exponent after the transient.",
            ),
            ("standard_error", "", "1/time", "Its standard error."),
        ),
        *_LENGTH,
    ),
    lambda settings, points: _first(_lengths(settings), _tangent(points)),
)

SETTLING = Kind(
    "settling",
    "How long the motion is irregular, and what it settles on (docs/chaos.md).",
    (DURATION, CLOSED),
    (
        *_of_points(
            ("settled", "", "1", "Whether the motion settled within the duration."),
            (
                "lifetime",
                "tau",
                "time",
                "How long the motion was irregular; the duration if it did not settle.",
            ),
            ("state", "", "1", "Name of the motion at the end."),
        ),
        *_PERIOD,
        *_of_points(
            (
                "irregular_exponent",
                "lambda_1",
                "1/time",
                "Largest Lyapunov exponent of the irregular motion; NaN if that was short.",
            ),
            ("irregular_error", "", "1/time", "Its standard error."),
            ("irregular_time", "", "time", "Time over which it was measured."),
        ),
        *_LENGTH,
        Array(
            "return_state",
            "",
            "",
            (POINT, "coordinate"),
            "Displacements, then relative velocities, at the last return to a section of the last "
            "block; model lengths and velocities, NaN padded.",
        ),
    ),
    lambda settings, points: None,
    kicks=True,
)

SEPARATION = Kind(
    "separation",
    "When runs that begin close together are first apart by each of several levels "
    "(docs/chaos.md).",
    (DURATION, TRANSIENT, DISTANCES),
    (
        Array("levels", "", "length", ("level",), "Distances, in ascending order."),
        Array("distances", "", "length", ("twin",), "How far the twins of a chain are at first."),
        Array(
            "passage_time",
            "",
            "time",
            (POINT, "twin", "level"),
            "Time since the twins were moved at which one was first further away than a level; NaN "
            "where it never was, or begins further away.",
        ),
    ),
    lambda settings, points: _lengths(settings),
    kicks=True,
)

TRIAL = Kind(
    "trial",
    "What a recording of the experiment's kind would tell of each run: r, stretches of small "
    "amplitude (docs/experiment.md).",
    (DURATION, TRANSIENT, SAMPLE_INTERVAL, LAMINAR_TIME),
    (
        *_LENGTH,
        *_of_points(
            ("small_share", "", "1", "Share of the time with small amplitude, as in a film."),
            ("lasting_share", "", "1", "Share of the time in small amplitudes that last."),
            ("lasting_count", "", "1", "Number of stretches of small amplitude that last."),
            ("lasting_longest", "", "time", "Length of the longest of them."),
            ("lively_longest", "", "time", "Longest time between them."),
            ("slip_longest", "", "time", "Longest time in which the last block does not stick."),
            ("all_slip_longest", "", "time", "Longest time in which no block sticks."),
        ),
    ),
    lambda settings, points: _lengths(settings),
)

_ALL = (SCAN, SERIES, CATALOGUE, ESCAPES, MOTION, SETTLING, SEPARATION, TRIAL)
KINDS = {kind.name: kind for kind in _ALL}
SETTINGS = {each.name: each for kind in KINDS.values() for each in kind.settings}
"""All settings of all kinds."""
