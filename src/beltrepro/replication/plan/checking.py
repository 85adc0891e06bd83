"""Reading and checking of config.yaml: one line for whatever is wrong."""

import datetime
import json
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import jsonschema
import yaml

from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint

SOURCE = "config.yaml"
TEXTS = ("run",)  # keys that stay text even if they look like numbers


def load(path: str | Path) -> dict:
    """Read a YAML file."""
    try:
        content = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except yaml.YAMLError as error:
        raise InputError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: must be a mapping of keys to values")
    return content


def complain(text: str, found: str = "", known: Iterable[str] = ()) -> InputError:
    """One line about the config."""
    return InputError(f"{SOURCE}: {text}{hint(found, known)}")


def normalised(config: dict) -> dict:
    """The config with text keys only, and with numbers that were read as text as numbers.

    YAML reads 2e6 as text, and Snakemake every number inside `--config 'presets={...}'`.
    """
    texts = {key: config[key] for key in TEXTS if _is_name(config.get(key))}
    others = {key: value for key, value in config.items() if key not in texts}
    return _normalised(others, ()) | {key: str(value) for key, value in texts.items()}


def fault(config: dict, schema: dict) -> InputError | None:
    """The first thing that the schema refuses."""
    errors = jsonschema.Draft202012Validator(schema).iter_errors(config)
    # A misspelt key is also a missing one: speak of the cause.
    first = min(errors, key=lambda error: error.validator != "additionalProperties", default=None)
    return None if first is None else _explained(first)


def _is_name(value: object) -> bool:
    """Whether a value is a text, or something that YAML reads of one."""
    return isinstance(value, str | int | float | datetime.date) and not isinstance(value, bool)


def _normalised(node: Any, path: tuple) -> Any:
    """A value of the config without what YAML and Snakemake made of it."""
    if isinstance(node, dict):
        return {str(key): _normalised(value, (*path, key)) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [_normalised(value, (*path, place)) for place, value in enumerate(node)]
    if isinstance(node, str) and re.fullmatch(_NUMBER, node):
        _check_size(float(node), node, path)
        return int(node) if re.fullmatch(_WHOLE, node) else float(node)
    if isinstance(node, int | float) and not isinstance(node, bool):
        _check_size(node, node, path)
    if not isinstance(node, str | int | float | None):
        text = "must be a number, text, true or false, null, a list or a mapping"
        raise complain(f"{_dotted(path)} = {shown(node)}: {text}")
    return node


_NUMBER = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"
_WHOLE = r"[+-]?\d+"


def _check_size(number: float, value: object, path: tuple) -> None:
    """That a number is finite, and small enough to be one in other programs."""
    if not abs(number) <= sys.float_info.max:
        raise complain(f"{_dotted(path)} = {shown(value)}: a finite number is needed")


def _explained(error: jsonschema.ValidationError) -> InputError:
    where = _dotted(error.absolute_path)
    allowed = error.validator_value
    value = error.instance
    match error.validator:
        case "additionalProperties":
            known = list(error.schema.get("properties", {}))
            patterns = error.schema.get("patternProperties", {})
            unknown = next(key for key in value if not _is_known(key, known, patterns))
            place = f" in {where}" if where else ""
            return complain(f"unknown key {unknown!r}{place}", unknown, known)
        case "required":
            missing = next(key for key in allowed if key not in value)
            return complain(f"{'.'.join(filter(None, [where, missing]))} is missing")
        case "enum":
            text = f"{where} = {shown(value)}: allowed are {', '.join(allowed)}"
            return complain(text, str(value), allowed)
        case "pattern":
            text = "must begin with a letter or digit and hold only these, '.', '-' and '_'"
            return complain(f"{where} = {shown(value)}: {text}")
        case "type":
            names = [allowed] if isinstance(allowed, str) else allowed
            text = " or ".join(_TYPES[name] for name in names)
            return complain(f"{where} = {_json(value)}: must be {text}")
        case "minimum" | "maximum" | "exclusiveMinimum" | "exclusiveMaximum":
            return complain(
                f"{where} = {shown(value)}: must be {_LIMITS[error.validator]} {allowed:g}"
            )
        case "multipleOf":
            return complain(f"{where} = {shown(value)}: must be a multiple of {allowed:g}")
        case "maxLength":
            return complain(f"{where} has {len(value)} characters: allowed are {allowed}")
        case "minItems" | "minProperties" | "minLength":
            return complain(f"{where} is empty: at least one entry is needed")
        case "uniqueItems":
            return complain(f"{where} = {_json(value)}: the same value occurs twice")
    return complain(f"{where} = {_json(value)}: not allowed by {error.validator} = {allowed!r}")


_TYPES = {
    "object": "a mapping of keys to values",
    "array": "a list",
    "string": "text",
    "boolean": "true or false",
    "number": "a number",
    "integer": "a whole number",
    "null": "null",
}
_LIMITS = {
    "minimum": "at least",
    "maximum": "at most",
    "exclusiveMinimum": "greater than",
    "exclusiveMaximum": "less than",
}


def _is_known(key: str, names: list[str], patterns: dict) -> bool:
    return key in names or any(re.search(pattern, key) for pattern in patterns)


def _dotted(path: Iterable) -> str:
    """Path to a value as in `presets.smoke.datasets.n5_map.noise[2]`."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return "".join(parts).removeprefix(".")


def _json(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
