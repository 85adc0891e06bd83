"""The reference of config.yaml, from its schema; and what each kind of dataset records."""

import json

from pydantic import TypeAdapter

from beltrepro.replication.plan import config, filming, kinds, points
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
    lines = [markdown.plain(whole["description"]), "## Top level", _keys(whole, parts)]
    titles = {"Dataset": "A dataset", "MoreRuns": "More runs", "Film": "A film"}
    titles |= {"Camera": "The camera", "Preset": "A preset"}
    for name, title in titles.items():
        lines += [f"## {title}", markdown.plain(parts[name]["description"])]
        lines.append(_keys(parts[name], parts))
        if name == "Dataset":
            also = "It also takes every quantity and the settings of its kind. So does `defaults`."
            lines.append(also)
    lines += ["## Quantities", "Any of them can be an axis of a dataset."]
    lines += [_values(points.QUANTITIES), "## Settings", "They belong to a whole dataset."]
    return "\n\n".join([*lines, _values(kinds.SETTINGS)])


def recorded() -> str:
    """What each kind of dataset records: its settings and arrays."""
    return "\n\n".join(_kind(kind) for kind in kinds.KINDS.values())


def _keys(whole: dict, parts: dict) -> str:
    """The keys of a part; quantities and settings of a dataset have tables of their own."""
    rows = []
    for name, about in whole["properties"].items():
        if whole is parts["Dataset"] and name in points.QUANTITIES | kinds.SETTINGS:
            continue
        about = parts.get(about.get("$ref", "").rpartition("/")[2], about)
        allowed = _allowed(about) + (", required" if name in whole.get("required", ()) else "")
        rows.append([markdown.code(name), markdown.plain(about.get("description", "")), allowed])
    return markdown.table(["key", "what it is", "allowed"], rows)


def _values(described: dict) -> str:
    rows = []
    for name, about in described.items():
        required = about.default is points.REQUIRED
        default = "required" if required else markdown.code(json.dumps(about.default))
        unit = markdown.plain(points.UNITS[about.unit])
        allowed = _allowed(TypeAdapter(config.type_of(about.type, **about.limits)).json_schema())
        words = markdown.plain(config.words_of(about))
        rows.append([markdown.code(name), words, unit, allowed, default])
    return markdown.table(["key", "what it is", "unit", "allowed", "default"], rows)


def _allowed(told: dict) -> str:
    """What a value may be, in words."""
    if "anyOf" in told:
        return " or ".join(map(_allowed, told["anyOf"]))
    if "$ref" in told:
        return "keys with values"
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
    rows = []
    for array in kind.recorded:
        unit, axes = points.UNITS.get(array.unit, array.unit), f"({', '.join(array.dimensions)})"
        words = map(markdown.plain, (array.symbol, unit, axes, array.description))
        rows.append([markdown.code(array.name), *words])
    settings = f"Settings: {', '.join(map(markdown.code, kind.settings))}."
    table = markdown.table(["array", "symbol", "unit", "dimensions", "what it is"], rows)
    return "\n\n".join([f"### {kind.name}", markdown.plain(kind.description), settings, table])


def setup(app) -> dict:
    """Called by Sphinx."""
    sources = (config, filming, kinds, points)
    app.add_directive("config-keys", markdown.directive(keys, *sources))
    app.add_directive("dataset-kinds", markdown.directive(recorded, *sources))
    return {"parallel_read_safe": True}
