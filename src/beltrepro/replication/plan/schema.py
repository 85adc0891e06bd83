"""The schema of config.yaml, made from the quantities and the kinds of datasets.

`python -m beltrepro.replication.plan.schema` prints it as YAML, for editors: `make schema` keeps it
in workflow/schemas/.
"""

import yaml

from beltrepro.replication.plan.films import CAMERA
from beltrepro.replication.plan.grids import LONGEST_GRID, MOST_POINTS
from beltrepro.replication.plan.kinds import KINDS, SETTINGS, Setting
from beltrepro.replication.plan.quantities import LAW, METHODS, QUANTITIES, Quantity

NAME = "^[a-z][a-z0-9_]*$"
RUN = "^[A-Za-z0-9][A-Za-z0-9_.-]*$"
POINTS_PER_JOB = {
    "description": "Points that one job advances together; multiples of 32 are quick.",
    "type": "integer",
    "minimum": 1,
    "maximum": MOST_POINTS,
}

_HEADER = """\
# Made by `make schema` from src/beltrepro/datasets: do not edit. For editors, and to read.
"""


def config_schema() -> dict:
    """The schema of config.yaml (JSON Schema 2020-12)."""
    law = {each.name for each in LAW}
    return _object(
        {
            "preset": {
                "description": "Which of `presets` to compute.",
                "type": "string",
            },
            "run": {
                "description": "Name of the folder below results/; that of the preset if absent.",
                "type": "string",
                "pattern": RUN,
                "maxLength": 100,
            },
            "seed": QUANTITIES["seed"].schema | {"description": QUANTITIES["seed"].description},
            "method": {
                "description": "One method for every dataset but those with own_method: true; "
                "absent, each dataset has its own.",
                "enum": list(METHODS),
            },
            "model": _object(
                {name: _ref(name) for name in QUANTITIES if name in law},
                "Constants of the chain and of the friction (Sec. III), for every dataset that "
                "does not give its own.",
            ),
            "defaults": _ref("defaults"),
            "datasets": _named("dataset", "What each dataset is, in all presets."),
            "camera": _ref("camera"),
            "films": _named("film", "Films that the virtual camera takes of datasets."),
            "presets": _named("preset", "Lengths and grids, and what else a variant changes.")
            | {"minProperties": 1},
        },
        "Every key of config.yaml. Model units throughout (Sec. III of the paper): mass of a block "
        "and spring constant are 1, the unit of length is 1.4 mm. Symbols, equations and sections "
        "are the paper's.",
        required=["preset", "seed", "datasets", "presets"],
    ) | {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Configuration of the workflow",
        "$defs": _definitions(),
    }


def as_yaml() -> str:
    """The schema as the text of the file for editors."""
    return _HEADER + yaml.safe_dump(config_schema(), sort_keys=False, width=100, allow_unicode=True)


def _definitions() -> dict:
    single = {
        name: _described(each) | each.schema for name, each in (QUANTITIES | SETTINGS).items()
    }
    axes = {f"{name}_axis": _axis(each) for name, each in QUANTITIES.items()}
    told = {name: _ref(f"{name}_axis") for name in QUANTITIES}
    told |= {name: _ref(name) for name in SETTINGS}
    told |= {"points_per_job": _ref("points_per_job")}
    kind = {
        "description": "What is recorded: "
        + " ".join(f"{each.name}: {each.description}" for each in KINDS.values()),
        "enum": list(KINDS),
    }
    own_method = {
        "description": "Keep the method, whatever the key `method` of the top level says: for "
        "comparisons of methods.",
        "type": "boolean",
    }
    like = {
        "description": "Name of a dataset of which this one takes all that it does not give.",
        "type": "string",
    }
    dataset = _object(
        {"kind": kind, "like": like, "own_method": own_method} | told,
        "A table of points: every combination of its axes, each a value, a list or a range. The "
        "settings allowed are those of its kind: "
        + "; ".join(
            f"{each.name}: {', '.join(setting.name for setting in each.settings)}"
            for each in KINDS.values()
        )
        + ".",
    )
    preset = _object(
        {
            "based_on": {
                "description": "Name of a preset from which this one takes what it does not give.",
                "type": "string",
            },
            "defaults": _ref("defaults"),
            "datasets": _named("dataset", "What this preset changes in single datasets, or adds."),
        },
        "What one preset gives: all of it stands over the keys of the top level.",
    )
    return {
        **single,
        **axes,
        "points_per_job": POINTS_PER_JOB,
        "defaults": _object(told, "Quantities and settings of every dataset that gives no own."),
        "dataset": dataset,
        "preset": preset,
        "camera": _object(
            {name: _described(each) | each.schema for name, each in CAMERA.items()},
            "The virtual camera above the belt (docs/experiment.md).",
        ),
        "film": _film(),
    }


def _film() -> dict:
    return _object(
        {
            "of": {
                "description": "Name of the dataset that is filmed: a series of one point, sampled "
                "at the instants of the frames.",
                "type": "string",
            },
            "seconds": {
                "description": "How much of it is filmed, from its beginning; all if absent.",
                "type": "number",
                "exclusiveMinimum": 0,
            },
            "camera": _ref("camera"),
        },
        "A film. What it gives for the camera stands over `camera` of the top level.",
        required=["of"],
    )


def _described(each: Quantity | Setting) -> dict:
    symbol = f"{each.symbol}: " if each.symbol else ""
    return {"description": symbol + each.description}


def _axis(quantity: Quantity) -> dict:
    """One value, a list, a range, a table N -> these, or what is special to a quantity."""
    one = _ref(quantity.name)
    grid = {
        "if": {"type": "array"},
        "then": {"minItems": 1, "uniqueItems": True, "items": one},
        "else": one,
    }
    special, words = _SPECIAL.get(quantity.name, (None, ""))
    types = quantity.schema.get("type", "")
    words = [words] if words else []
    if "number" in types or types == "integer":
        step = {"type": "integer", "minimum": 1} if types == "integer" else _STEP
        limits = {"start": one, "stop": one, "step": {"description": "Distance of values."} | step}
        grid["else"] = {
            "if": {"type": "object"},
            "then": _object(limits, required=list(limits)),
            "else": one,
        }
        words.insert(0, "{start, stop, step} with both ends")
    if special is not None:
        key = next(iter(special["properties"]))
        grid = {"if": {"type": "object", "required": [key]}, "then": special, "else": grid}
    if quantity.name not in ("n_blocks", "method"):
        tables = {"type": "object", "minProperties": 1, "propertyNames": {"pattern": "^[0-9]+$"}}
        by_size = {"type": "object", "additionalProperties": False}
        by_size["patternProperties"] = {"^[1-9][0-9]*$": grid}
        grid = {"if": tables, "then": by_size, "else": grid}
        words.append("a table N -> such values")
    alternatives = "".join(f", or {each}" for each in words)
    text = f"{_described(quantity)['description']} One value, a list{alternatives}."
    return {"description": text} | grid


_STEP = {"type": "number", "exclusiveMinimum": 0}
_INTEGER = {"type": "integer", "minimum": 0}
_COUNT = {"type": "integer", "minimum": 1, "maximum": LONGEST_GRID}


def _ref(name: str) -> dict:
    return {"$ref": f"#/$defs/{name}"}


def _object(properties: dict, description: str = "", required: list[str] | None = None) -> dict:
    return {
        **({"description": description} if description else {}),
        "type": "object",
        "additionalProperties": False,
        **({"required": required} if required else {}),
        "properties": properties,
    }


def _named(definition: str, description: str) -> dict:
    """A mapping of names to values of one definition."""
    return {
        "description": description,
        "type": "object",
        "additionalProperties": False,
        "patternProperties": {NAME: _ref(definition)},
    }


_SPECIAL = {
    "method": (
        _object(
            {"without_noise": _ref("method"), "with_noise": _ref("method")},
            required=["without_noise", "with_noise"],
        ),
        "{without_noise, with_noise} for points with sigma = 0 and others",
    ),
    "seed": (
        _object({"offset": {"description": "Added to the seed of the top level."} | _INTEGER}),
        "{offset}: so much above the seed of the top level",
    ),
    "replicate": (
        _object({"count": {"description": "Number of replicates."} | _COUNT}),
        "{count}: the first so many",
    ),
}

if __name__ == "__main__":
    print(as_yaml(), end="")
