"""config.yaml: what may stand in it, and one line for whatever is wrong.

The words of quantities and settings stand in words.yaml, their limits where the library has them.
"""

import re
from collections.abc import Callable, Collection, Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn, TypeVar

import yaml
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from beltrepro.base import reading
from beltrepro.base.checks import LONGEST_GRID, shown, spaced
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint
from beltrepro.model.parameters import LIMITS, LONGEST

SOURCE = "config.yaml"
MOST_POINTS = 1_000_000  # of a dataset; each is a run
MOST_BYTES = 1_000_000  # of a file of settings

# --- the file -------------------------------------------------------------------------------------

# What YAML 1.1 takes for a number or a choice, and everybody reads as that.
_NUMBER = r"(?i)[-+]?(0|[1-9]\d*|(\d+\.\d*|\.\d+)(e[-+]\d+)?|\.(inf|nan))"
_FORMS = {"int": _NUMBER, "float": _NUMBER, "bool": "(?i)true|false"}


class _Loader(yaml.SafeLoader):
    """Refuses what Snakemake's loader takes for something else than it looks like.

    That one reads YAML 1.1, in which 5:30 is 330, 010 is 8, and on is true; of a key that is given
    twice it takes the last value.
    """

    def compose_scalar_node(self, anchor: Any) -> yaml.ScalarNode:
        node = super().compose_scalar_node(anchor)
        form = None if node.style else _FORMS.get(node.tag.rpartition(":")[2])
        if form and not re.fullmatch(form, node.value):
            right = "write numbers as 330 or 5.5, text in quotes, choices as true or false"
            _stop(node, f"{shown(node.value)} can be read in two ways: {right}")
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> dict:
        given: list = []
        for key, _ in node.value:
            if key.value in given:
                _stop(key, f"the key {shown(key.value)} is given twice")
            given.append(key.value)
        return super().construct_mapping(node, deep)


def _stop(place: Any, problem: str) -> NoReturn:
    raise yaml.MarkedYAMLError(problem=problem, problem_mark=place.start_mark)


def load_config(path: str | Path) -> dict:
    """Read a YAML file."""
    text = reading.text(path, MOST_BYTES)
    try:
        content = yaml.load(text, _Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f", line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}{place}: {error.context or ''} {error.problem}") from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:  # as of a 30th of February
        raise InputError(f"{path}: not YAML: {error}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: must be a mapping of keys to values")
    return content


# --- values and grids -----------------------------------------------------------------------------

UNSET: Any = "unset"  # default of what need not be given, and is then looked for elsewhere
_TEXT = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"
T = TypeVar("T")


def _number(value: object) -> object:
    """YAML 1.1 has 2e6 as text, and Snakemake all numbers inside of `--config`."""
    if isinstance(value, str) and re.fullmatch(_TEXT, value):
        return float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticCustomError("number", "a number is needed")
    return value


def _several(values: list) -> list:
    if not values:
        raise PydanticCustomError("empty", "at least one value is needed")
    if len(set(values)) < len(values):
        raise PydanticCustomError("repeated", "the same value occurs twice")
    return values


Number = Annotated[float, Field(allow_inf_nan=False), BeforeValidator(_number)]
Whole = Annotated[int, BeforeValidator(_number)]
Positive = Annotated[Number, Field(**LIMITS["belt_velocity"])]
NotNegative = Annotated[Number, Field(**LIMITS["noise"])]
Rate = Annotated[Number, Field(**LIMITS["extension_rate"])]
Ratio = Annotated[Number, Field(**LIMITS["friction_ratio"])]
Step = Annotated[Number, Field(**LIMITS["time_step"])]
Duration = Annotated[Number, Field(**LIMITS["duration"])]
Blocks = Annotated[Whole, Field(**LIMITS["n_blocks"])]
Key = Annotated[Whole, Field(ge=0, le=2**32 - 1)]  # what random numbers are drawn by
Method = Literal["verlet", "event"]
Sampled = Literal["positions", "velocities", "friction"]
Flag = Annotated[bool, Field(strict=True)]
Several = Annotated[list[T], Field(strict=True), AfterValidator(_several)]
Named = dict[Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,99}$")], T]  # names files, too


class Keys(BaseModel):
    """Keys with values, and no other keys."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, values: object) -> object:
        for key in values if isinstance(values, dict) else ():
            if key not in cls.model_fields:
                about = {"key": key, "meant": meant_by(str(key), cls.model_fields)}
                raise PydanticCustomError("unknown", "{key}{meant}", about)
        return values


class Range(Keys):
    """From one number to another, both included."""

    start: Number
    stop: Number
    step: Number


class Count(Keys):
    """The first so many."""

    count: Annotated[Whole, Field(ge=1, le=LONGEST_GRID)]


class Offset(Keys):
    """So much above the seed of the top level."""

    offset: Annotated[Whole, Field(ge=0)]


class Methods(Keys):
    """For points without noise and others."""

    without_noise: Method
    with_noise: Method


def _grid(value: Any, one: Callable[[Any], Any]) -> tuple:
    """The values of a grid, rising: of a value, a list or a range."""
    if isinstance(value, dict):
        value = [*spaced("", **Range.model_validate(value).model_dump())]
    values = value if isinstance(value, list) else [value]
    return tuple(sorted(_several(list(map(one, values)))))


def _by_size(value: Any, grid: Callable[[Any], Any]) -> Any:
    """A grid, or one for each N of a table."""
    if not is_by_size(value):
        return grid(value)
    return {int(size): grid(values) for size, values in value.items()}


def is_by_size(grid: object) -> bool:
    """Whether a grid is a table N -> grid."""
    if not isinstance(grid, dict) or not grid:
        return False
    return all(re.fullmatch(r"[1-9]\d{0,9}", str(key)) for key in grid)


def _or(form: type[Keys], made: Callable[[Any], Any] = BaseModel.model_dump) -> WrapValidator:
    """A grid, or what is made of other keys than those of a range."""

    def either(value: Any, grid: Callable[[Any], Any]) -> Any:
        is_form = isinstance(value, dict) and value.keys().isdisjoint(Range.model_fields)
        return made(form.model_validate(value)) if is_form else grid(value)

    return WrapValidator(either)


Grid = Annotated[T, WrapValidator(_grid)]
Table = Annotated[T, WrapValidator(_by_size)]
Seeds = Annotated[Grid[Key], _or(Offset)]
Replicates = Annotated[Grid[Key], _or(Count, lambda first: tuple(range(first.count)))]


# --- the whole ------------------------------------------------------------------------------------


class Axes(Keys):
    """Values of quantities."""

    n_blocks: Grid[Blocks] = UNSET
    static_friction: Table[Grid[Positive]] = UNSET
    friction_ratio: Table[Grid[Ratio]] = UNSET
    rest_length: Table[Grid[Positive]] = UNSET
    linear_limit: Table[Grid[Positive]] = UNSET
    compression_rate: Table[Grid[Rate]] = UNSET
    extension_rate: Table[Grid[Rate]] = UNSET
    mass: Table[Grid[Positive]] = UNSET
    stiffness: Table[Grid[Positive]] = UNSET
    weakening_velocity: Table[Grid[Positive]] = UNSET
    viscosity: Table[Grid[NotNegative]] = UNSET
    noise: Table[Grid[NotNegative]] = UNSET
    belt_velocity: Table[Grid[Positive]] = UNSET
    initial_spread: Table[Grid[NotNegative]] = UNSET
    method: Annotated[Grid[Method], _or(Methods)] = UNSET
    time_step: Table[Grid[Step]] = UNSET
    seed: Table[Seeds] = UNSET
    replicate: Table[Replicates] = UNSET


class Settings(Keys):
    """What all points of a dataset share and no axis can vary."""

    duration: Duration = UNSET
    transient: Annotated[Number, Field(ge=0, le=LONGEST)] = UNSET
    section_position: Positive | None = None
    section_values: Annotated[Whole, Field(ge=1, le=100_000)] = 500
    section_from: Annotated[Number, Field(lt=0)] = -120.0
    section_bins: Annotated[Whole, Field(ge=1, le=100_000)] = 600
    laminar_time: Duration = 200.0
    sample_interval: Duration = 0.1
    samples: Several[Sampled] = ["positions", "velocities", "friction"]
    section_block: Blocks | None = None
    settle_time: Duration = UNSET
    noise_clock: Literal["rest", "laboratory"] = "rest"
    closed: Annotated[Number, Field(gt=0, lt=1)] = 1e-8
    energies: Several[Annotated[Number, Field(ge=1e-3, le=1e4)]] = [60.0, 200.0, 600.0]
    slips: Several[Annotated[Whole, Field(ge=1, le=200)]] = [5, 11, 22, 23]
    friction_ratios: Several[Ratio] = [0.4, 0.45, 0.5, 0.55, 0.6]


class Defaults(Axes, Settings):
    """Quantities and settings of every dataset that gives no own."""

    points_per_job: Annotated[Whole, Field(ge=1, le=MOST_POINTS)] = UNSET
    """Points that one job advances together; multiples of 32 are quick."""


class Dataset(Defaults):
    """A table of points: every combination of its axes, each a value, a list or a range.

    Of `replicate` also {count: n}, the first n; of `seed` {offset: n}, n above that of the top
    level; of `method` {without_noise: ..., with_noise: ...}, by the noise of a point.
    """

    kind: str = UNSET
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


class Config(Keys):
    """Every key of config.yaml, in model units (Sec. III), with symbols of the paper."""

    preset: str
    """Which of `presets` to compute."""
    run: Annotated[
        str, Field(pattern="^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$", coerce_numbers_to_str=True)
    ] = UNSET
    """Name of the folder below results/; that of the preset if absent."""
    seed: Key
    """Seed of all random numbers."""
    method: Method = UNSET
    """One for every dataset but those with own_method: true; absent, each dataset has its own."""
    defaults: Defaults = UNSET
    datasets: Named[Dataset]
    """What each dataset is, in all presets."""
    camera: dict[str, Any] = UNSET
    """The virtual camera above the belt (docs/experiment.md)."""
    films: list[str] = UNSET
    """Datasets that the camera films: each a series of one point, sampled at each frame."""
    presets: Annotated[Named[Preset], Field(min_length=1)]
    """Lengths and grids, and what else a variant changes."""


# --- what is wrong --------------------------------------------------------------------------------


def refuse(text: str, word: str = "", allowed: Iterable[str] = ()) -> NoReturn:
    """Raise one line about the configuration, with what may be meant by a word of it."""
    raise InputError(f"{SOURCE}: {text}{hint(word, allowed)}")


def meant_by(key: str, allowed: Collection[str]) -> str:
    """What may be meant by a key, or what is allowed in its place if that is short."""
    listed = f": allowed are {', '.join(allowed)}" if len(allowed) < 20 else ""
    return hint(key, allowed) or listed


def checked(config: dict) -> dict:
    """The configuration with each value of its type; InputError for what is not allowed."""
    try:
        return Config.model_validate(config).model_dump(exclude_unset=True, warnings=False)
    except ValidationError as error:
        problems = error.errors(include_url=False)
    # A misspelt key is also a missing one: speak of the cause.
    problem = min(problems, key=lambda problem: problem["type"] != "unknown")
    context: Any = problem.get("ctx", {})
    path = [part for part in problem["loc"] if str(part)[:1] not in ("#", "[")]
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    where = "".join(parts).removeprefix(".")
    if problem["type"] == "unknown":
        place = f" in {where}" if where else ""
        refuse(f"unknown key {shown(context['key'])}{place}{context['meant']}")
    if problem["type"] == "missing":
        refuse(f"{where} is missing")
    if problem["type"] == "value_error":  # of what makes a range, by its end
        refuse(f"{where}{context['error']}")
    text = problem["msg"].replace("a valid integer", "a whole number").replace("valid ", "")
    text = re.sub("^Input should|should", "must", text)
    words = re.findall(r"'(\w+)'", context["expected"]) if "expected" in context else []
    refuse(f"{where} = {shown(problem['input'])}: {text}", str(problem["input"]), words)
