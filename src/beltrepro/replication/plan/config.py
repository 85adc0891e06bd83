"""config.yaml: what it may hold, as one typed description, and one line for whatever is wrong.

Types, limits, words and defaults of quantities, settings and the camera stand in `points`, `kinds`
and `films`. `python -m beltrepro.replication.plan.config` prints the schema as YAML, for editors:
`make schema` keeps it in workflow/schemas/.
"""

import datetime
import itertools
import json
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn, get_args

import yaml
from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Strict,
    Tag,
    ValidationError,
    create_model,
)
from typing_extensions import TypeAliasType

from beltrepro.base import reading
from beltrepro.base.checks import LONGEST_GRID, shown
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint
from beltrepro.model.parameters import LARGEST
from beltrepro.replication.plan.filming import CAMERA
from beltrepro.replication.plan.kinds import KINDS, LIST, SETTINGS
from beltrepro.replication.plan.points import LAW, QUANTITIES, Described, Key, Method, Number, Whole

SOURCE = "config.yaml"
MOST_POINTS = 1_000_000  # of a dataset; each is a run
MOST_BYTES = 1_000_000  # of a file of settings, and values in it, with all that repeats itself
MOST_VALUES = 100_000
DEEPEST = 50


class _Bounded(yaml.composer.Composer):
    """Refuses what is nested without end, or is short only because it repeats itself."""

    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> yaml.Node | None:
        self._depth += 1
        if self._depth > DEEPEST:
            raise InputError(f"nested more than {DEEPEST} deep")
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node

    def get_single_node(self) -> yaml.Node | None:
        whole = super().get_single_node()
        left, nodes = MOST_VALUES, [whole]
        while nodes:
            node, left = nodes.pop(), left - 1
            if left < 0:
                raise InputError(f"more than {MOST_VALUES} values, perhaps without end")
            if isinstance(node, yaml.MappingNode):
                nodes += itertools.chain(*node.value)
            elif isinstance(node, yaml.SequenceNode):
                nodes += node.value
        return whole


class _Words(_Bounded, yaml.BaseLoader):
    """Takes every value as text, as Snakemake does on the command line."""


class _Loader(_Bounded, yaml.SafeLoader):
    """Refuses what Snakemake's loader takes for something else than it looks like.

    That one reads YAML 1.1, in which 5:30 is 330, 010 is 8, and on is true; and of a key that is
    given twice it takes the last value.
    """

    def compose_scalar_node(self, anchor: Any) -> yaml.ScalarNode:
        node = super().compose_scalar_node(anchor)
        form = _FORMS.get(node.tag.rpartition(":")[2]) if node.style is None else None
        if form and not re.fullmatch(form, node.value):
            right = "write numbers as 330 or 5.5, text in quotes, choices as true or false"
            _stop(node, f"{shown(node.value)} can be read in two ways: {right}")
        return node

    def construct_mapping(self, node: Any, deep: bool = False) -> dict:
        earlier = set()
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            if key.value in earlier:
                _stop(key, f"the key {shown(key.value)} is given twice")
            earlier.add(key.value)
            read = str(self.construct_object(value)) if value.tag.endswith(":float") else ""
            if key.value == "run" and read not in ("", value.value):
                _stop(value, f"run = {value.value}: is read as the number {read}; quote it")
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


def check_text(text: str, name: str) -> None:
    """Refuse a value of the command line on which Snakemake would not end."""
    try:
        yaml.compose(text, _Words)
    except yaml.YAMLError:
        return  # it stays text
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def load_config(path: str | Path) -> dict:
    """Read a YAML file."""
    text = reading.text(path, MOST_BYTES)
    try:
        content = yaml.load(text, _Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f", line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}{place}: {error.context or ''} {error.problem}") from None
    except yaml.YAMLError as error:  # a character that no YAML file may have
        raise InputError(f"{path}: not YAML: {error}") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: must be a mapping of keys to values")
    return content


def refuse(text: str, word: str = "", allowed: Iterable[str] = ()) -> NoReturn:
    """Raise one line about the configuration, with what may be meant by a word of it."""
    raise InputError(f"{SOURCE}: {text}{hint(word, allowed)}")


def checked(config: dict) -> dict:
    """The configuration with each value of its type; InputError for what is not allowed."""
    try:
        return Config.model_validate(_plain(config, ())).model_dump(
            exclude_unset=True, warnings=False
        )
    except ValidationError as error:
        problems = error.errors(include_url=False)
    # A misspelt key is also a missing one: speak of the cause.
    _explain(min(problems, key=lambda problem: problem["type"] != "extra_forbidden"))


# --- what it may hold -----------------------------------------------------------------------------


class _Keys(BaseModel):
    """Keys with values, and no other keys."""

    model_config = ConfigDict(extra="forbid")


NAME = Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,99}$")]  # also that of a file
Text = Annotated[str, Strict()]
_PREFIX = "#"  # of the tags of alternatives, which are no part of the path to a value


def _keys(
    name: str, doc: str, base: type[BaseModel] = _Keys, /, *, required: tuple = (), **types: Any
) -> Any:
    """A type of keys with values, of which only those required must be given."""
    fields: dict[str, Any] = {
        key: (type_, ... if key in required else None) for key, type_ in types.items()
    }
    return create_model(name, __base__=base, __doc__=doc, **fields)


class Offset(_Keys):
    """So much above the seed of the top level."""

    offset: Annotated[Whole, Field(ge=0, description="Added to the seed of the top level.")]


class Count(_Keys):
    """The first so many."""

    count: Annotated[Whole, Field(ge=1, le=LONGEST_GRID, description="Number of replicates.")]


class Methods(_Keys):
    """For points with sigma = 0 and others."""

    without_noise: Method
    with_noise: Method


SPECIAL: dict[str, type[BaseModel]] = {"seed": Offset, "replicate": Count, "method": Methods}


def words_of(about: Described) -> str:
    """Symbol and description of a quantity or setting, and for a quantity what its axis can be."""
    symbol = f"{about.symbol}: " if about.symbol else ""
    if about.name not in QUANTITIES:
        return symbol + about.description
    ways = [] if about.name == "method" else ["{start, stop, step} with both ends"]
    if special := SPECIAL.get(about.name):
        meaning = str(special.__doc__)
        ways.append(f"{{{', '.join(special.model_fields)}}}: {meaning[0].lower()}{meaning[1:-1]}")
    if about.name not in ("n_blocks", "method"):
        ways.append("a table N -> such values")
    alternatives = "".join(f", or {way}" for way in ways)
    return f"{symbol}{about.description} One value, a list{alternatives}."


def _axis(about: Described) -> Any:
    """One value, a list, a range, what is special to a quantity, or a table N -> these."""
    name = about.name
    one: Any = about.type
    special = SPECIAL.get(name)
    grid: Any = Annotated[one, Tag("#value")] | Annotated[list[one], *LIST, Tag("#list")]
    if special:
        grid |= Annotated[special, Tag("#special")]
    if name != "method":
        number: Any = Whole if name in ("n_blocks", "seed", "replicate") else Number
        end = Annotated[number, *one.__metadata__[1:]]  # of the quantity, but never null
        least = Field(gt=0, description="Distance of values.")
        range_ = _keys(
            f"Range_{name}",
            "Both ends and all between.",
            required=("start", "stop", "step"),
            **{"start": end, "stop": end, "step": Annotated[number, least]},
        )
        grid |= Annotated[range_, Tag("#range")]

    def way(value: object) -> str:
        if isinstance(value, list):
            return "#list"
        if not isinstance(value, dict):
            return "#value"
        if special and special.model_fields.keys() & value.keys():
            return "#special"
        return "#value" if name == "method" else "#range"

    grid = Annotated[grid, Discriminator(way)]
    if name not in ("n_blocks", "method"):
        # an alias has a name in the schema, and stands there once
        rule: Any = TypeAliasType(f"Grid_{name}", grid)
        table: Any = dict[Annotated[str, Field(pattern="^[1-9][0-9]*$")], rule]
        grid = Annotated[rule, Tag("#grid")] | Annotated[table, Tag("#table")]
        grid = Annotated[grid, Discriminator(_grid_or_table)]
    axis = Annotated[grid, Field(description=words_of(about))]
    return TypeAliasType(f"Axis_{name}", axis)


def _grid_or_table(value: object) -> str:
    is_table = isinstance(value, dict) and value and all(str(key).isdigit() for key in value)
    return "#table" if is_table else "#grid"


def _setting(about: Described) -> Any:
    return Annotated[about.type, Field(description=words_of(about))]


Defaults = _keys(
    "Defaults",
    "Quantities and settings of every dataset that gives no own.",
    **{name: _axis(about) for name, about in QUANTITIES.items()},
    **{name: _setting(about) for name, about in SETTINGS.items()},
    points_per_job=Annotated[
        Whole,
        Field(
            ge=1,
            le=MOST_POINTS,
            description="Points that one job advances together; multiples of 32 are quick.",
        ),
    ],
)
MoreRuns = _keys(
    "MoreRuns",
    "Runs are added to a point, in rounds, while the mean of a number over its runs is not known "
    "well enough there or at a neighbour along the axis with the most values: `by` at a time, to "
    "`up_to`, until the 95 % interval of the mean of `of` is within `half_width` "
    "(docs/workflow.md).",
    required=("by", "up_to", "of", "half_width"),
    by=Annotated[Whole, Field(ge=1, le=LONGEST_GRID, description="Runs added in a round.")],
    up_to=Annotated[Whole, Field(ge=1, le=LONGEST_GRID, description="Runs at a point, at most.")],
    of=Annotated[Text, Field(description="The number: an array with one value for each point.")],
    half_width=Annotated[
        Number,
        Field(
            gt=0,
            le=LARGEST,
            description="Largest half-width allowed of the 95 % interval of its mean, in its unit.",
        ),
    ],
)
Dataset = _keys(
    "Dataset",
    "A table of points: every combination of its axes, each a value, a list or a range. The "
    "settings allowed are those of its kind: "
    + "; ".join(f"{kind.name}: {', '.join(kind.settings)}" for kind in KINDS.values())
    + ".",
    Defaults,
    kind=Annotated[
        Literal[tuple(KINDS)],
        Field(
            description="What is recorded: "
            + " ".join(f"{kind.name}: {kind.description}" for kind in KINDS.values())
        ),
    ],
    like=Annotated[
        Text,
        Field(description="Name of a dataset of which this one takes all that it does not give."),
    ],
    more_runs=Annotated[
        MoreRuns | None,
        Field(description="When points get more runs than `replicate` says; null for never."),
    ],
    own_method=Annotated[
        bool,
        Strict(),
        Field(
            description="Keep the method, whatever the key `method` of the top level says: for "
            "comparisons of methods."
        ),
    ],
)
Camera = _keys(
    "Camera",
    "The virtual camera above the belt (docs/experiment.md).",
    **{name: _setting(about) for name, about in CAMERA.items()},
)


Film = _keys(
    "Film",
    "A film. What it gives for the camera stands over `camera` of the top level.",
    required=("of",),
    of=Annotated[
        Text,
        Field(
            description="Name of the dataset that is filmed: a series of one point, sampled at the "
            "instants of the frames."
        ),
    ],
    seconds=Annotated[
        Number,
        Field(gt=0, description="How much of it is filmed, from its beginning; all if absent."),
    ],
    camera=Camera,
)


def _named(keys: Any, description: str, **limits: Any) -> Any:
    """A mapping of names to keys of one type."""
    return Annotated[dict[NAME, keys], Field(description=description, **limits)]


Preset = _keys(
    "Preset",
    "What one preset gives: all of it stands over the keys of the top level.",
    based_on=Annotated[
        Text,
        Field(description="Name of a preset from which this one takes what it does not give."),
    ],
    defaults=Defaults,
    datasets=_named(Dataset, "What this preset changes in single datasets, or adds."),
)
Law = _keys(
    "Law",
    "Constants of the chain and of the friction (Sec. III), for every dataset that does not give "
    "its own.",
    **{about.name: _setting(about) for about in LAW},
)


Config = _keys(
    "Config",
    "Every key of config.yaml. Model units throughout (Sec. III of the paper): mass of a block and "
    "spring constant are 1, the unit of length is 1.4 mm. Symbols, equations and sections are the "
    "paper's.",
    required=("preset", "seed", "datasets", "presets"),
    preset=Annotated[Text, Field(description="Which of `presets` to compute.")],
    run=Annotated[
        Text,
        Field(
            description="Name of the folder below results/; that of the preset if absent.",
            pattern="^[A-Za-z0-9][A-Za-z0-9_.-]*$",
            max_length=100,
        ),
    ],
    seed=Annotated[Key, Field(description=QUANTITIES["seed"].description)],
    method=Annotated[
        Method,
        Field(
            description="One method for every dataset but those with own_method: true; absent, "
            "each dataset has its own."
        ),
    ],
    model=Law,
    defaults=Defaults,
    datasets=_named(Dataset, "What each dataset is, in all presets."),
    camera=Camera,
    films=_named(Film, "Films that the virtual camera takes of datasets."),
    presets=_named(Preset, "Lengths and grids, and what else a variant changes.", min_length=1),
)


def schema() -> dict:
    """The schema of config.yaml (JSON Schema 2020-12)."""
    made = {"$schema": "https://json-schema.org/draft/2020-12/schema"} | Config.model_json_schema()
    return _tidy(made) | {"title": "Configuration of the workflow"}


def schema_as_yaml() -> str:
    """The schema as the text of the file for editors."""
    header = "# Made by `make schema` from src/beltrepro: do not edit. For editors, and to read.\n"
    return header + yaml.safe_dump(schema(), sort_keys=False, width=100, allow_unicode=True)


def _tidy(node: Any) -> Any:
    """A schema of pydantic without titles and defaults made up of names, limits by their names."""
    if isinstance(node, list):
        return [_tidy(part) for part in node]
    if not isinstance(node, dict):
        return node
    made_up = {key for key in ("title", "default") if not isinstance(node.get(key), dict)}
    closed = {"additionalProperties": False} if "patternProperties" in node else {}
    kept = {_JSON.get(key, key): _tidy(part) for key, part in node.items() if key not in made_up}
    return kept | closed


# Pydantic leaves these as they are where a validator of ours stands before the limit.
_JSON = {
    "gt": "exclusiveMinimum",
    "ge": "minimum",
    "lt": "exclusiveMaximum",
    "le": "maximum",
    "multiple_of": "multipleOf",
}


# --- what is wrong --------------------------------------------------------------------------------


def _plain(node: Any, path: tuple) -> Any:
    """A value of the config without what YAML and Snakemake made of it.

    YAML reads 2e6 as text, and Snakemake every number inside `--config 'presets={...}'`; both read
    the name of a run as a number or a date if it looks like one.
    """
    if path == ("run",) and isinstance(node, str | int | float | datetime.date):
        return node if isinstance(node, bool) else str(node)
    if isinstance(node, dict):
        return {str(key): _plain(value, (*path, key)) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [_plain(value, (*path, place)) for place, value in enumerate(node)]
    number = node
    if isinstance(node, str) and re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", node):
        number = float(node)
        if re.fullmatch(r"[+-]?\d+", node) and abs(number) <= sys.float_info.max:
            number = int(node)
    is_number = isinstance(number, int | float) and not isinstance(number, bool)
    if is_number and not abs(number) <= sys.float_info.max:
        refuse(f"{_dotted(path)} = {shown(node)}: a finite number is needed")
    if not isinstance(number, str | int | float | None):
        allowed = "a number, text, true or false, null, a list or a mapping"
        refuse(f"{_dotted(path)} = {shown(node)}: must be {allowed}")
    return number


_LIMITS = {
    "greater_than": ("gt", "must be greater than {:g}"),
    "greater_than_equal": ("ge", "must be at least {:g}"),
    "less_than": ("lt", "must be less than {:g}"),
    "less_than_equal": ("le", "must be at most {:g}"),
    "multiple_of": ("multiple_of", "must be a multiple of {:g}"),
}
_TYPES = {
    "model_type": "a mapping of keys to values",
    "dict_type": "a mapping of keys to values",
    "list_type": "a list",
    "string_type": "text",
    "bool_type": "true or false",
    "float_type": "a number",
    "int_type": "a whole number",
}


def _explain(problem: Any) -> NoReturn:
    """Raise what pydantic says of a value as one line of ours."""
    path = [part for part in problem["loc"] if not str(part).startswith(_PREFIX)]
    value, context, kind = problem["input"], problem.get("ctx", {}), problem["type"]
    if path[-1] == "[key]" or kind == "extra_forbidden":
        *parents, key = path if kind == "extra_forbidden" else path[:-1]
        place = f" in {_dotted(parents)}" if parents else ""
        allowed = _known(parents)
        if "pattern" in context and not allowed:
            form = f"a name that matches {context['pattern']} is needed"
            refuse(f"unknown key {shown(key)}{place}: {form}")
        listed = f": allowed are {', '.join(allowed)}" if 0 < len(allowed) < 20 else ""
        refuse(f"unknown key {shown(key)}{place}{hint(str(key), allowed) or listed}")
    where = _dotted(path)
    if kind == "missing":
        refuse(f"{where} is missing")
    if kind == "literal_error":
        allowed = re.findall(r"'(\w+)'", context["expected"])
        refuse(f"{where} = {shown(value)}: allowed are {', '.join(allowed)}", str(value), allowed)
    if kind == "string_pattern_mismatch":
        text = "must begin with a letter or digit and hold only these, '.', '-' and '_'"
        refuse(f"{where} = {shown(value)}: {text}")
    if kind == "string_too_long":
        refuse(f"{where} has {len(value)} characters: allowed are {context['max_length']}")
    if kind == "too_short":
        refuse(f"{where} is empty: at least one entry is needed")
    if kind in _LIMITS:
        name, words = _LIMITS[kind]
        refuse(f"{where} = {shown(value)}: {words.format(context[name])}")
    if kind in _TYPES:
        nullable = {**QUANTITIES, **SETTINGS, **CAMERA}.get(str(path[-1]))
        is_nullable = nullable and type(None) in getattr(nullable.type.__origin__, "__args__", ())
        refuse(f"{where} = {_json(value)}: must be {_TYPES[kind]}{' or null' * bool(is_nullable)}")
    refuse(f"{where} = {_json(value)}: {problem['msg']}")


def _known(path: list) -> list[str]:
    """Keys that are allowed at a place of the configuration."""
    node: Any = Config
    for key in path:
        fields = getattr(node, "model_fields", None)
        node = _not_null(fields[key].annotation) if fields else node
        if not fields and getattr(node, "__origin__", None) is dict:
            node = node.__args__[1]
    if fields := getattr(node, "model_fields", None):
        return list(fields)
    name = next((part for part in reversed(path) if not str(part).isdigit()), "")
    special = SPECIAL[name].model_fields if name in SPECIAL else ()
    return [*special, *("start", "stop", "step") * (name in QUANTITIES and name != "method")]


def _not_null(type_: Any) -> Any:
    """The type of a value that may be null, if it is not."""
    parts = get_args(type_)
    return parts[0] if type(None) in parts else type_


def _dotted(path: Iterable) -> str:
    """Path to a value as in `presets.smoke.datasets.n5_map.noise[2]`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return "".join(parts).removeprefix(".")


def _json(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


if __name__ == "__main__":
    print(schema_as_yaml(), end="")
