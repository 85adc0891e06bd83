"""The reference of config.yaml, from its schema; and what each kind of dataset records."""

import json
from collections.abc import Iterable

from pydantic import TypeAdapter

from beltrepro.replication.plan import config, films, kinds, points
from extensions import markdown

_LIMITS = {
    "minimum": "{} or more",
    "exclusiveMinimum": "more than {}",
    "maximum": "at most {}",
    "exclusiveMaximum": "less than {}",
    "minItems": "at least {} of them",
    "pattern": "matches {}",
}


def keys() -> str:
    """Every key of config.yaml: where it stands, what it is, what is allowed."""
    whole = config.schema()
    parts = whole["$defs"]
    return "\n\n".join(
        [
            markdown.plain(whole["description"]),
            "## Top level",
            _keys(whole["properties"], parts, whole["required"]),
            "## A dataset",
            markdown.plain(parts["Dataset"]["description"]),
            _keys(_own(parts["Dataset"]["properties"]), parts),
            "It also takes every quantity and the settings of its kind. So does `defaults`.",
            "## A film",
            markdown.plain(parts["Film"]["description"]),
            _keys(parts["Film"]["properties"], parts, parts["Film"]["required"]),
            "## The camera",
            markdown.plain(parts["Camera"]["description"]),
            _keys(parts["Camera"]["properties"], parts),
            "## A preset",
            markdown.plain(parts["Preset"]["description"]),
            _keys(parts["Preset"]["properties"], parts),
            "## Quantities",
            "Any of them can be an axis of a dataset.",
            _values(points.QUANTITIES),
            "## Settings",
            "They belong to a whole dataset.",
            _values(kinds.SETTINGS),
        ]
    )


def recorded() -> str:
    """What each kind of dataset records: its settings and arrays."""
    return "\n\n".join(_kind(kind) for kind in kinds.KINDS.values())


def _keys(properties: dict, parts: dict, required: Iterable[str] = ()) -> str:
    rows = []
    for name, told in properties.items():
        told = parts.get(told.get("$ref", "").rpartition("/")[2], told)
        allowed = _allowed(told) + (", required" if name in required else "")
        words = markdown.plain(told.get("description", ""))
        rows.append([markdown.code(name), words, allowed])
    return markdown.table(["key", "what it is", "allowed"], rows)


def _own(properties: dict) -> dict:
    """The keys of a dataset that are neither quantities nor settings."""
    values = points.QUANTITIES | kinds.SETTINGS
    return {name: told for name, told in properties.items() if name not in values}


def _values(described: dict) -> str:
    rows = []
    for name, about in described.items():
        required = about.default is points.REQUIRED
        default = "required" if required else markdown.code(json.dumps(about.default))
        unit = markdown.plain(points.UNITS[about.unit])
        allowed = _allowed(TypeAdapter(about.type).json_schema())
        words = markdown.plain(config.words_of(about))
        rows.append([markdown.code(name), words, unit, allowed, default])
    return markdown.table(["key", "what it is", "unit", "allowed", "default"], rows)


def _allowed(told: dict) -> str:
    """What a value may be, in words."""
    if "anyOf" in told:
        return " or ".join(map(_allowed, told["anyOf"]))
    if "enum" in told:
        return ", ".join(map(markdown.code, told["enum"]))
    words = [told.get("type", "").replace("object", "keys with values").replace("array", "list")]
    words += [
        text.format(markdown.code(told[limit])) for limit, text in _LIMITS.items() if limit in told
    ]
    if "items" in told and "enum" in told["items"]:
        words.append("of " + ", ".join(map(markdown.code, told["items"]["enum"])))
    return ", ".join(filter(None, words))


def _kind(kind: kinds.Kind) -> str:
    rows = [
        [
            markdown.code(each.name),
            markdown.plain(each.symbol),
            markdown.plain(points.UNITS.get(each.unit, each.unit)),
            markdown.plain(f"({', '.join(each.dimensions)})"),
            markdown.plain(each.description),
        ]
        for each in kind.recorded
    ]
    settings = ", ".join(map(markdown.code, kind.settings))
    heads = ["array", "symbol", "unit", "dimensions", "what it is"]
    return "\n\n".join(
        [
            f"### {kind.name}",
            markdown.plain(kind.description),
            f"Settings: {settings}.",
            markdown.table(heads, rows),
        ]
    )


def setup(app) -> dict:
    """Called by Sphinx."""
    sources = (config, films, kinds, points)
    app.add_directive("config-keys", markdown.directive(keys, *sources))
    app.add_directive("dataset-kinds", markdown.directive(recorded, *sources))
    return {"parallel_read_safe": True}
