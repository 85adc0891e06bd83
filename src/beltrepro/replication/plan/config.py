"""config.yaml: what may stand in it, and one line for whatever is wrong.

The words of quantities and settings stand in words.yaml, their limits where the library has them.
"""

import datetime
import re
from collections.abc import Callable, Collection, Hashable, Iterable
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, NoReturn, TypeVar

import yaml
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    model_validator,
    with_config,
)
from pydantic_core import PydanticCustomError
from typing_extensions import TypedDict

from beltrepro.base import reading
from beltrepro.base.checks import LONGEST_GRID, shown
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint
from beltrepro.model.parameters import LIMITS, LONGEST
from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.plan.points import REQUIRED

SOURCE = "config.yaml"
MOST_POINTS = 1_000_000  # of a dataset; each is a run
MOST_BYTES = 1_000_000  # of a file of settings

# --- the file -------------------------------------------------------------------------------------


class _Loader(yaml.SafeLoader):
    """Refuses what Snakemake's loader takes for something else than it looks like.

    That one reads YAML 1.1, in which 5:30 is 330, 010 is 8, and on is true; and of a key that is
    given twice it takes the last value.
    """

    def compose_scalar_node(self, anchor: Any) -> Any:
        node = super().compose_scalar_node(anchor)
        form = _FORMS.get(node.tag.rpartition(":")[2]) if node.style is None else None
        if form and not re.fullmatch(form, node.value):
            right = "write numbers as 330 or 5.5, text in quotes, choices as true or false"
            _stop(node, f"{shown(node.value)} can be read in two ways: {right}")
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Hashable, Any]:
        keys = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        for place, key in enumerate(keys):
            if key.value in (earlier.value for earlier in keys[:place]):
                _stop(key, f"the key {shown(key.value)} is given twice")
        return super().construct_mapping(node, deep)

    def construct_object(self, node: Any, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep)
        except ValueError as error:  # a number of thousands of digits, a 30th of February
            _stop(node, f"{shown(node.value)}: {error}")


# What YAML 1.1 takes for a number or a choice, and everybody reads as that.
_NUMBER = r"(?i)[-+]?(0|[1-9]\d*|(\d+\.\d*|\.\d+)(e[-+]\d+)?|\.(inf|nan))"
_FORMS = {"int": _NUMBER, "float": _NUMBER, "bool": "(?i)true|false"}


def _stop(node: Any, problem: str) -> NoReturn:
    raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)


def load_config(path: str | Path) -> dict:
    """Read a YAML file."""
    try:
        content = yaml.load(reading.text(path, MOST_BYTES), _Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f", line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}{place}: {error.context or ''} {error.problem}") from None
    except (yaml.YAMLError, RecursionError) as error:  # a character that no YAML file may have
        raise InputError(f"{path}: not YAML: {error}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: must be a mapping of keys to values")
    return content


# --- single values --------------------------------------------------------------------------------

_TEXT = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"


def _number(value: object) -> object:
    """The number that a text is: YAML 1.1 has 2e6 as text, and Snakemake 1 inside of `--config`."""
    return float(value) if isinstance(value, str) and re.fullmatch(_TEXT, value) else value


def _whole(value: object) -> object:
    """2.0 is a whole number; what is none is left to be refused."""
    number = _number(value)
    return int(number) if isinstance(number, float) and number.is_integer() else number


def _name(value: object) -> object:
    """The text that YAML has read as a whole number or a date."""
    is_read = isinstance(value, int | datetime.date) and not isinstance(value, bool)
    return str(value) if is_read else value


def _different(values: list) -> list:
    if any(value in values[:place] for place, value in enumerate(values)):
        raise PydanticCustomError("repeated", "the same value occurs twice")
    return values


def _kind(name: str) -> str:
    if name not in KINDS:
        allowed = f"allowed are {', '.join(KINDS)}{hint(name, KINDS)}"
        raise PydanticCustomError("kind", "{allowed}", {"allowed": allowed})
    return name


UNSET: Any = None
"""Default of what need not be given, and is then looked for elsewhere."""
_REQUIRED: Any = REQUIRED
_ENDS = ("start", "stop", "step")
T = TypeVar("T")
S = TypeVar("S")
Number = Annotated[float, Field(strict=True, allow_inf_nan=False), BeforeValidator(_number)]
Whole = Annotated[int, Field(strict=True), BeforeValidator(_whole)]
Positive = Annotated[Number, Field(**LIMITS["belt_velocity"])]
NotNegative = Annotated[Number, Field(**LIMITS["noise"])]
Ratio = Annotated[Number, Field(**LIMITS["friction_ratio"])]
Step = Annotated[Number, Field(**LIMITS["time_step"])]
Duration = Annotated[Number, Field(**LIMITS["duration"])]
Blocks = Annotated[Whole, Field(**LIMITS["n_blocks"])]
Key = Annotated[Whole, Field(ge=0, le=2**32 - 1)]  # what random numbers are drawn by
Method = Literal["verlet", "event"]
Flag = Annotated[bool, Field(strict=True)]
Several = Annotated[list[T], Field(min_length=1, strict=True), AfterValidator(_different)]
Named = dict[Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,99}$")], T]  # names files, too

# --- keys and grids -------------------------------------------------------------------------------


class Keys(BaseModel):
    """Keys with values, and no other keys."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    @model_validator(mode="before")
    @classmethod
    def _no_other(cls, values: object) -> object:
        """Speak of a misspelt key before all else that is wrong."""
        for key in values if isinstance(values, dict) else ():
            if key not in cls.model_fields:
                about = {"key": shown(key), "allowed": _allowed(str(key), cls.model_fields)}
                raise PydanticCustomError("unknown", "{key}", about)
        return values


@with_config(ConfigDict(extra="forbid"))
class Range(TypedDict, Generic[T]):
    """Both ends and all between."""

    start: T
    stop: T
    step: Annotated[Number, Field(gt=0)]


class Offset(Keys):
    """So much above the seed of the top level."""

    offset: Annotated[Whole, Field(ge=0)]


class Count(Keys):
    """The first so many."""

    count: Annotated[Whole, Field(ge=1, le=LONGEST_GRID)]


class Methods(Keys):
    """For points without noise and others."""

    without_noise: Method
    with_noise: Method


def is_by_size(grid: object) -> bool:
    """Whether a grid is a table N -> grid."""
    return isinstance(grid, dict) and grid != {} and all(str(key).isdigit() for key in grid)


def _other_if(condition: Callable[[Any], bool]) -> Discriminator:
    """Which of two a value is meant as, so that a fault is told of that one alone."""
    return Discriminator(lambda value: "#other" if condition(value) else "#one")


# the mark in the tags tells them from keys, as they stand in pydantic's paths to values
_Either = Annotated[T, Tag("#one")] | Annotated[S, Tag("#other")]
_Size = Annotated[str, Field(pattern="^[1-9][0-9]*$"), BeforeValidator(str)]
Choice = Annotated[_Either[T, Several[T]], _other_if(lambda value: isinstance(value, list))]
Grid = Annotated[_Either[Choice[T], Range[T]], _other_if(lambda value: isinstance(value, dict))]
Special = Annotated[
    _Either[T, S],
    _other_if(lambda value: isinstance(value, dict) and value.keys().isdisjoint(_ENDS)),
]
Table = Annotated[_Either[T, dict[_Size, T]], _other_if(is_by_size)]


# --- the whole ------------------------------------------------------------------------------------
# Words of quantities and settings stand in words.yaml.


class Law(Keys):
    """Constants of chain and friction (Sec. III), for datasets that give no own."""

    static_friction: Positive = UNSET
    friction_ratio: Ratio = UNSET
    rest_length: Positive = UNSET
    linear_limit: Positive = UNSET
    compression_rate: Positive = UNSET
    extension_rate: Positive = UNSET


class Axes(Keys):
    """Values of quantities."""

    n_blocks: Grid[Blocks] = UNSET
    static_friction: Table[Grid[Positive]] = UNSET
    friction_ratio: Table[Grid[Ratio]] = UNSET
    rest_length: Table[Grid[Positive]] = UNSET
    linear_limit: Table[Grid[Positive]] = UNSET
    compression_rate: Table[Grid[Positive]] = UNSET
    extension_rate: Table[Grid[Positive]] = UNSET
    noise: Table[Grid[NotNegative]] = UNSET
    belt_velocity: Table[Grid[Positive]] = UNSET
    initial_spread: Table[Grid[NotNegative]] = UNSET
    method: Special[Choice[Method], Methods] = UNSET
    time_step: Table[Grid[Step]] = UNSET
    seed: Table[Special[Grid[Key], Offset]] = UNSET
    replicate: Table[Special[Grid[Key], Count]] = UNSET


class Settings(Keys):
    """What all points of a dataset share and no axis can vary."""

    duration: Duration = _REQUIRED
    transient: Annotated[Number, Field(ge=0, le=LONGEST)] = _REQUIRED
    section_position: Positive | None = None
    section_values: Annotated[Whole, Field(ge=1, le=100_000)] = 500
    laminar_time: Duration = 200.0
    sample_interval: Duration = 0.1
    samples: Several[Literal["positions", "velocities", "friction"]] = [
        *("positions", "velocities", "friction")
    ]
    section_block: Blocks | None = None
    settle_time: Duration = _REQUIRED
    noise_clock: Literal["rest", "laboratory"] = "rest"
    closed: Annotated[Number, Field(gt=0, lt=1)] = 1e-8
    energies: Several[Annotated[Number, Field(ge=1e-3, le=1e4)]] = [60.0, 200.0, 600.0]


class Defaults(Axes, Settings):
    """Quantities and settings of every dataset that gives no own."""

    points_per_job: Annotated[Whole, Field(ge=1, le=MOST_POINTS)] = UNSET
    """Points that one job advances together; multiples of 32 are quick."""


class Dataset(Defaults):
    """A table of points: every combination of its axes, each a value, a list or a range."""

    kind: Annotated[str, AfterValidator(_kind)] = UNSET
    """What is recorded; the settings are those of the kind."""
    like: str = UNSET
    """Name of a dataset of which this one takes all that it does not give."""
    also: Axes | None = UNSET
    """Further points, as more replicates where they decide: axes over those of the dataset."""
    own_method: Flag = UNSET
    """Keep the method, whatever that of the top level is: for comparisons of methods."""


class Thin(Keys):
    """How a preset makes smaller what it is based on; what it gives itself stays as it is."""

    values: Annotated[Whole, Field(ge=2)] = UNSET
    """At most so many values of a grid are kept: every second, third or further one."""
    replicates: Annotated[Whole, Field(ge=1)] = UNSET
    """One replicate of so many is kept, but two at least."""
    duration: Duration = UNSET
    """Longest run."""
    transient: Duration = UNSET
    """Longest transient."""
    settle_time: Duration = UNSET
    """Longest end of a run by which the attractor reached is described."""


class Preset(Keys):
    """What one preset gives: all of it stands over the keys of the top level."""

    based_on: str = UNSET
    """Name of a preset from which this one takes what it does not give."""
    thin: Thin = UNSET
    """How much smaller than those of `based_on` its datasets are."""
    defaults: Defaults = UNSET
    datasets: Named[Dataset] = UNSET
    """What this preset changes in single datasets, or adds."""


class Film(Keys):
    """A film, taken by the camera of the top level."""

    of: str
    """Name of the dataset: a series of one point, sampled at the instants of the frames."""


class Config(Keys):
    """Every key of config.yaml, in model units (Sec. III), with symbols of the paper."""

    preset: str
    """Which of `presets` to compute."""
    run: Annotated[
        str,
        Field(pattern="^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=100),
        BeforeValidator(_name),
    ] = UNSET
    """Name of the folder below results/; that of the preset if absent."""
    seed: Key
    """Seed of all random numbers."""
    method: Method = UNSET
    """One for every dataset but those with own_method: true; absent, each dataset has its own."""
    model: Law = UNSET
    defaults: Defaults = UNSET
    datasets: Named[Dataset]
    """What each dataset is, in all presets."""
    camera: dict[str, Any] = UNSET
    """The virtual camera above the belt (docs/experiment.md)."""
    films: Named[Film] = UNSET
    """Films that the camera takes of datasets."""
    presets: Annotated[Named[Preset], Field(min_length=1)]
    """Lengths and grids, and what else a variant changes."""


# --- what is wrong --------------------------------------------------------------------------------


def refuse(text: str, word: str = "", allowed: Iterable[str] = ()) -> NoReturn:
    """Raise one line about the configuration, with what may be meant by a word of it."""
    raise InputError(f"{SOURCE}: {text}{hint(word, allowed)}")


def checked(config: dict) -> dict:
    """The configuration with each value of its type; InputError for what is not allowed."""
    try:
        return Config.model_validate(config).model_dump(exclude_unset=True, warnings=False)
    except RecursionError:
        refuse("a value is part of itself, or nested too deep")
    except ValidationError as error:
        problems = error.errors(include_url=False)
    # A misspelt key is also a missing one: speak of the cause.
    _explain(min(problems, key=lambda problem: problem["type"] != "extra_forbidden"))


def _explain(problem: Any) -> NoReturn:
    """Raise what pydantic says of a value as one line of ours."""
    path = [part for part in problem["loc"] if not str(part).startswith("#")]
    kind, context = problem["type"], problem.get("ctx", {})
    if kind == "extra_forbidden":  # of a range: all else has its own line
        *path, key = path
        kind, context = "unknown", {"key": shown(key), "allowed": _allowed(str(key), _ENDS)}
    where = _dotted(path)
    if kind == "unknown":
        place = f" in {where}" if path else ""
        refuse(f"unknown key {context['key']}{place}{context['allowed']}")
    if path[-1] == "[key]":
        allowed = f"a name that matches {context.get('pattern')} is needed"
        refuse(f"unknown key {shown(path[-2])} in {_dotted(path[:-2])}: {allowed}")
    if kind == "missing":
        refuse(f"{where} is missing")
    text = problem["msg"].replace("a valid integer", "a whole number").replace("valid ", "")
    text = re.sub("^Input should|should", "must", text)
    words = re.findall(r"'(\w+)'", context["expected"]) if kind == "literal_error" else []
    refuse(f"{where} = {shown(problem['input'])}: {text}", str(problem["input"]), words)


def _allowed(key: str, allowed: Collection[str]) -> str:
    """What may be meant by a key, or what is allowed in its place if that is short."""
    listed = f": allowed are {', '.join(allowed)}" if len(allowed) < 20 else ""
    return hint(key, allowed) or listed


def _dotted(path: Iterable) -> str:
    """Path to a value as in `presets.smoke.datasets.n5_map.noise[2]`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return "".join(parts).removeprefix(".")
