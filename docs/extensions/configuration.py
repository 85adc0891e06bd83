"""The reference of config.yaml, from its schema; and what each kind of dataset records."""

import json

from beltrepro.replication.camera.scene import camera_settings
from beltrepro.replication.plan import config, kinds, points
from extensions import markdown

_LIMITS = {
    "ge": "{} or more",
    "gt": "more than {}",
    "le": "at most {}",
    "lt": "less than {}",
    "minItems": "at least {} of them",
    "pattern": "matches {}",
}
_GRIDS = """One value, a list, `{start, stop, step}` with both ends, or, but for `n_blocks` and `method`,
a table N -> such values. `seed` can be `{offset: 1}`, which is added to the seed of the top level,
`replicate` the first so many, `{count: 32}`, and `method` `{without_noise: verlet, with_noise: event}`.
"""


def keys() -> str:
    """Every key of config.yaml: where it stands, what it is, what is allowed."""
    whole = config.Config.model_json_schema()
    parts = {"Config": whole} | whole["$defs"]
    lines = []
    titles = {"Config": "Top level", "Dataset": "A dataset", "Film": "A film"}
    titles |= {"Preset": "A preset", "Thin": "A thinner preset"}
    for name, title in titles.items():
        lines += [f"## {title}", markdown.plain(parts[name]["description"])]
        lines.append(_keys(parts[name], parts))
        if name == "Dataset":
            also = "It also takes every quantity and the settings of its kind. So does `defaults`."
            lines.append(also)
    camera = {name: setting.metadata for name, setting in camera_settings().items()}
    rows = [[markdown.code(name), about["words"]] for name, about in camera.items()]
    lines += ["## The camera", markdown.table(["key", "what it is"], rows)]
    lines += ["## Quantities", "Any of them can be an axis of a dataset.", _GRIDS]
    lines.append(_values(points.QUANTITIES, parts["Axes"], points.DEFAULTS))
    lines += ["## Settings", "They belong to a whole dataset."]
    defaults = {name: field.default for name, field in config.Settings.model_fields.items()}
    lines.append(_values(kinds.SETTINGS, parts["Defaults"], defaults))
    return "\n\n".join(lines)


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


def _values(described: dict, part: dict, defaults: dict) -> str:
    rows = []
    for name, about in described.items():
        default = defaults[name]
        default = default if default == points.REQUIRED else markdown.code(json.dumps(default))
        symbol = f"{about.symbol}: " if about.symbol else ""
        words = markdown.plain(symbol + about.description)
        unit = markdown.plain(points.UNITS[about.unit])
        allowed = _allowed(part["properties"][name])
        rows.append([markdown.code(name), words, unit, allowed, default])
    return markdown.table(["key", "what it is", "unit", "allowed", "default"], rows)


def _allowed(told: dict) -> str:
    """What a value may be, in words; of a grid, what one value of it may be."""
    while "oneOf" in told:
        told = told["oneOf"][0]
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
    sources = (config, kinds, points)
    app.add_directive("config-keys", markdown.directive(keys, *sources))
    app.add_directive("dataset-kinds", markdown.directive(recorded, *sources))
    return {"parallel_read_safe": True}
