"""The reference of config.yaml, from its schema; and what each kind of dataset records."""

from pathlib import Path

from beltrepro.replication.camera.scene import camera_settings
from beltrepro.replication.plan import kinds, points
from beltrepro.replication.plan.config import Config
from extensions import plain, table, write

_LIMITS = {"ge": "{} or more", "gt": "more than {}", "le": "at most {}", "lt": "less than {}"}
_LIMITS |= {"minimum": _LIMITS["ge"], "exclusiveMinimum": _LIMITS["gt"]}
_LIMITS |= {"maximum": _LIMITS["le"], "exclusiveMaximum": _LIMITS["lt"], "pattern": "matches {}"}


def page() -> str:
    """Every key: where it stands, what it is, what is allowed; and the arrays of each kind."""
    schema = Config.model_json_schema()
    parts = schema["$defs"]
    text = ["# Configuration", plain(schema["description"]), "## Top level", _keys(schema)]
    of_dataset = parts["Dataset"]["properties"].keys()
    for name, part in parts.items():
        keys = part.get("properties", {}).keys()
        if "description" in part and keys and not keys < of_dataset:  # else it stands there
            text += [f"## {name}", plain(part["description"]), _keys(part)]
    camera = {name: plain(one.metadata["words"]) for name, one in camera_settings().items()}
    rows = [(f"`{name}`", words) for name, words in camera.items()]
    text += ["## Camera", table(["key", "what it is"], rows)]
    text.append("## Kinds of datasets")
    for kind in kinds.KINDS.values():
        settings = ", ".join(f"`{name}`" for name in kind.settings)
        rows = [
            (f"`{name}`", plain(one.symbol), f"({', '.join(one.dimensions)})", plain(words))
            for name, one in kind.recorded.items()
            for words in [f"{one.description} {points.UNITS.get(one.unit, '')}"]
        ]
        heads = ["array", "symbol", "dimensions", "what it is, and its unit"]
        text += [f"### {kind.name}", plain(kind.description), f"Settings: {settings}."]
        text.append(table(heads, rows))
    return "\n\n".join(text) + "\n"


def _keys(part: dict) -> str:
    rows = []
    for name, about in part["properties"].items():
        words = about.get("description") or _words(name)
        required = ", required" if name in part.get("required", ()) else ""
        rows.append((f"`{name}`", plain(words), plain(_allowed(about)) + required))
    return table(["key", "what it is", "allowed"], rows)


def _words(name: str) -> str:
    """What a quantity or a setting is."""
    row = (points.WORDS["quantities"] | points.WORDS["settings"]).get(name, "")
    return row.rpartition("|")[2].strip()


def _allowed(about: dict) -> str:
    """What a value may be, in words; of a grid, what one value of it may be."""
    while "oneOf" in about:
        about = about["oneOf"][0]
    if "anyOf" in about:
        return " or ".join(map(_allowed, about["anyOf"]))
    if "$ref" in about:
        name = about["$ref"].rpartition("/")[2]
        return "keys of a dataset" if name in ("Axes", "Defaults") else f"see {name}"
    values = about.get("enum") or ([about["const"]] if "const" in about else [])
    if values:
        return ", ".join(f"`{value}`" for value in values)
    words = [about.get("type", "").replace("object", "keys with values").replace("array", "list")]
    words += [text.format(f"`{about[limit]}`") for limit, text in _LIMITS.items() if limit in about]
    if "items" in about:
        words.append(f"of {_allowed(about['items'])}")
    return ", ".join(filter(None, words))


def setup(app) -> dict:
    """Called by Sphinx."""
    folder = Path(app.srcdir) / "reference"
    app.connect("builder-inited", lambda _: write(folder, {"configuration.md": page()}))
    return {"parallel_read_safe": True}
