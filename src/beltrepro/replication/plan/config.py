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
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn, get_args, get_origin

import yaml
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Strict,
    Tag,
    ValidationError,
    WrapValidator,
    create_model,
)
from pydantic_core import PydanticCustomError
from typing_extensions import TypeAliasType

from beltrepro.base import reading
from beltrepro.base.checks import LONGEST_GRID, shown
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint
from beltrepro.replication.plan.filming import CAMERA
from beltrepro.replication.plan.kinds import KINDS, SETTINGS
from beltrepro.replication.plan.points import LAW, QUANTITIES, WORDS, Described, Method

SOURCE = "config.yaml"
MOST_POINTS = 1_000_000  # of a dataset; each is a run
MOST_BYTES = 1_000_000  # of a file of settings, and values in it, with all that repeats itself
MOST_VALUES = 100_000


class _Bounded(yaml.composer.Composer):
    """Refuses what is short only because it repeats itself, or is part of itself."""

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
    except (InputError, RecursionError) as error:
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
    except (yaml.YAMLError, RecursionError) as error:  # a character that no YAML file may have
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
    except RecursionError:
        refuse("a value is part of itself, or nested too deep")
    except ValidationError as error:
        problems = error.errors(include_url=False)
    # A misspelt key is also a missing one: speak of the cause.
    _explain(min(problems, key=lambda problem: problem["type"] != "extra_forbidden"))


# --- what it may hold -----------------------------------------------------------------------------


class _Keys(BaseModel):
    """Keys with values, and no other keys."""

    model_config = ConfigDict(extra="forbid")


def _whole(value: object) -> object:
    """2.0 is a whole number; what is none is left to be refused."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _different(values: list) -> list:
    """Refuse a list in which a value occurs twice."""
    if any(value in values[:place] for place, value in enumerate(values)):
        raise PydanticCustomError("repeated", "the same value occurs twice")
    return values


def _unchanged(value: object, check: Callable[[object], object]) -> object:
    """A film is known by a digest of its settings as text: 0 must not become 0.0."""
    check(value)
    return value


_BASIC: dict[Any, Any] = {
    float: Annotated[float, Strict()],
    int: Annotated[int, Strict(), BeforeValidator(_whole)],
    str: Annotated[str, Strict()],
    bool: Annotated[bool, Strict()],
}
_LIST = Field(min_length=1, json_schema_extra={"uniqueItems": True}), AfterValidator(_different)
_PREFIX = "#"  # of the tags of alternatives, which are no part of the path to a value


def type_of(type_: Any, **limits: Any) -> Any:
    """What pydantic checks a value by; limits : of a list, those of its values."""
    parts = get_args(type_)
    if get_origin(type_) is list:
        one: Any = type_of(parts[0], **limits)
        return Annotated[(list[one], *_LIST)]
    if type(None) in parts:
        return Annotated[_BASIC[parts[0]] | None, Field(**limits)]
    return Annotated[_BASIC[type_], Field(**limits)] if type_ in _BASIC else type_


def _type(about: Described) -> Any:
    return type_of(about.type, **about.limits)


def _not_null(type_: Any) -> Any:
    """The type of a value that may be null, if it is not."""
    parts = get_args(type_)
    return parts[0] if type(None) in parts else type_


def _keys(
    words: str,
    base: type[BaseModel] = _Keys,
    /,
    *,
    name: str = "",
    more_words: str = "",
    required: tuple = (),
    **types: Any,
) -> Any:
    """A type of keys with values, of which only those required must be given.

    words : where its words stand in words.yaml, to which `more_words` are added.
    """
    about = WORDS["keys"][words]
    fields: dict[str, Any] = {}
    for key, type_ in types.items():
        described = Annotated[type_, Field(description=about[key])] if key in about else type_
        fields[key] = (described, ... if key in required else None)
    return create_model(
        name or words, __base__=base, __doc__=about["description"] + more_words, **fields
    )


SPECIAL: dict[str, type[BaseModel]] = {
    "seed": _keys("Offset", required=("offset",), offset=type_of(int, ge=0)),
    "replicate": _keys("Count", required=("count",), count=type_of(int, ge=1, le=LONGEST_GRID)),
    "method": _keys(
        "Methods",
        required=("without_noise", "with_noise"),
        without_noise=Method,
        with_noise=Method,
    ),
}


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
    one: Any = _type(about)
    special = SPECIAL.get(name)
    grid: Any = Annotated[one, Tag("#value")]
    grid |= Annotated[(list[one], *_LIST, Tag("#list"))]
    if special:
        grid |= Annotated[special, Tag("#special")]
    if name != "method":
        end = type_of(_not_null(about.type), **about.limits)
        step = type_of(_not_null(about.type), gt=0)
        ends = {"start": end, "stop": end, "step": step}
        range_ = _keys("Range", name=f"Range_{name}", required=(*ends,), **ends)
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
    return TypeAliasType(f"Axis_{name}", Annotated[grid, Field(description=words_of(about))])


def _grid_or_table(value: object) -> str:
    is_table = isinstance(value, dict) and value and all(str(key).isdigit() for key in value)
    return "#table" if is_table else "#grid"


def _settings(settings: Iterable[Described], *more: Any) -> dict[str, Any]:
    """Types of settings, by name."""
    return {
        about.name: Annotated[(_type(about), *more, Field(description=words_of(about)))]
        for about in settings
    }


def _named(keys: Any, **limits: Any) -> Any:
    """A mapping of names, also of files, to keys of one type."""
    name = Annotated[str, Field(pattern="^[a-z][a-z0-9_]{0,99}$")]
    return Annotated[dict[name, keys], Field(**limits)]


Axes = _keys("Axes", **{name: _axis(about) for name, about in QUANTITIES.items()})
Defaults = _keys(
    "Defaults",
    Axes,
    **_settings(SETTINGS.values()),
    points_per_job=type_of(int, ge=1, le=MOST_POINTS),
)
_KIND = " ".join(f"{kind.name}: {kind.description}" for kind in KINDS.values())
_OF_KINDS = "; ".join(f"{kind.name}: {', '.join(kind.settings)}" for kind in KINDS.values())
Dataset = _keys(
    "Dataset",
    Defaults,
    more_words=f" {_OF_KINDS}.",
    kind=Annotated[Literal[tuple(KINDS)], Field(description=f"What is recorded: {_KIND}")],
    like=_BASIC[str],
    also=Axes | None,
    own_method=_BASIC[bool],
)
Camera = _keys("Camera", **_settings(CAMERA.values(), WrapValidator(_unchanged)))
Film = _keys("Film", required=("of",), of=_BASIC[str])
Preset = _keys("Preset", based_on=_BASIC[str], defaults=Defaults, datasets=_named(Dataset))
Law = _keys("Law", **_settings(LAW))
Config = _keys(
    "Config",
    required=("preset", "seed", "datasets", "presets"),
    preset=_BASIC[str],
    run=type_of(str, pattern="^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=100),
    seed=Annotated[_type(QUANTITIES["seed"]), Field(description=QUANTITIES["seed"].description)],
    method=Method,
    model=Law,
    defaults=Defaults,
    datasets=_named(Dataset),
    camera=Camera,
    films=_named(Film),
    presets=_named(Preset, min_length=1),
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


def _explain(problem: Any) -> NoReturn:
    """Raise what pydantic says of a value as one line of ours."""
    path = [part for part in problem["loc"] if not str(part).startswith(_PREFIX)]
    context, kind = problem.get("ctx", {}), problem["type"]
    if path[-1] == "[key]" or kind == "extra_forbidden":
        *parents, key = path if kind == "extra_forbidden" else path[:-1]
        place = f" in {_dotted(parents)}" if parents else ""
        allowed = _known(parents)
        text = f": allowed are {', '.join(allowed)}" if 0 < len(allowed) < 20 else ""
        if "pattern" in context and not allowed:
            text = f": a name that matches {context['pattern']} is needed"
        refuse(f"unknown key {shown(key)}{place}{hint(str(key), allowed) or text}")
    where, value = _dotted(path), problem["input"]
    if kind == "missing":
        refuse(f"{where} is missing")
    words = re.findall(r"'(\w+)'", context["expected"]) if kind == "literal_error" else []
    text = re.sub(r" or instance of \w+| after validation", "", problem["msg"])
    text = text.replace("a valid integer", "a whole number").replace("valid ", "")
    described = {**QUANTITIES, **SETTINGS, **CAMERA}.get(str(path[-1]))
    if kind.endswith("_type") and described and _not_null(described.type) != described.type:
        text += " or null"
    text = re.sub("^Input should|should", "must", text)
    refuse(f"{where} = {_json(value)}: {text}", str(value), words)


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


def _dotted(path: Iterable) -> str:
    """Path to a value as in `presets.smoke.datasets.n5_map.noise[2]`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return "".join(parts).removeprefix(".")


def _json(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


if __name__ == "__main__":
    print(schema_as_yaml(), end="")
