"""Reading and checking of config.yaml: one line for whatever is wrong."""

import difflib
import json
import math
import re
from collections.abc import Iterable
from pathlib import Path

import jsonschema
import yaml

from beltrepro.errors import InputError

SOURCE = "config.yaml"
TEXTS = ("run",)  # keys that stay text even if they look like numbers


def load(path: str | Path) -> dict:
    """Read a YAML file.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    dict
        Its content.

    Raises
    ------
    InputError
        If it is missing, is not YAML or is not a mapping.
    """
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
    """One line about the config.

    Parameters
    ----------
    text : str
        What is wrong: key, value and what is allowed.
    found : str
        A name that is not known.
    known : iterable of str
        Names that are; the nearest is suggested.

    Returns
    -------
    InputError
        To be raised.
    """
    nearest = difflib.get_close_matches(found, list(known), n=1, cutoff=0.6)
    hint = f"; did you mean {nearest[0]!r}?" if nearest else ""
    return InputError(f"{SOURCE}: {text}{hint}")


def normalised(config: dict) -> dict:
    """The config with text keys only, and with numbers that were read as text as numbers.

    YAML reads 2e6 as text, and Snakemake every number inside `--config 'presets={...}'`.

    Parameters
    ----------
    config : dict
        Content of config.yaml, with what the command line changed.

    Returns
    -------
    dict
        A copy.

    Raises
    ------
    InputError
        If a number is not finite.
    """
    texts = {key: str(config[key]) for key in TEXTS if key in config}
    return _normalised(config) | texts


def fault(config: dict, schema: dict) -> InputError | None:
    """The first thing that the schema refuses.

    Parameters
    ----------
    config : dict
        Content of config.yaml, with what the command line changed.
    schema : dict
        `schema.config_schema`.

    Returns
    -------
    InputError or None
        To be raised; None if the config is as the schema says.
    """
    errors = jsonschema.Draft202012Validator(schema).iter_errors(config)
    # A misspelt key is also a missing one: speak of the cause.
    first = min(errors, key=lambda error: error.validator != "additionalProperties", default=None)
    return None if first is None else _explained(first)


def _normalised(node):
    if isinstance(node, dict):
        return {str(key): _normalised(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [_normalised(value) for value in node]
    if isinstance(node, str) and re.fullmatch(r"[+-]?\d+", node):
        return int(node)
    if isinstance(node, str) and re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", node):
        return float(node)
    if isinstance(node, float) and not math.isfinite(node):
        raise complain(f"{node} is not allowed as a value: a finite number is needed")
    return node


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
            text = f"{where} = {value!r}: allowed are {', '.join(allowed)}"
            return complain(text, str(value), allowed)
        case "pattern":
            text = "must begin with a letter or digit and hold only these, '.', '-' and '_'"
            return complain(f"{where} = {value!r}: {text}")
        case "type":
            names = [allowed] if isinstance(allowed, str) else allowed
            text = " or ".join(_TYPES[name] for name in names)
            return complain(f"{where} = {_shown(value)}: must be {text}")
        case "minimum" | "maximum" | "exclusiveMinimum" | "exclusiveMaximum":
            return complain(f"{where} = {value!r}: must be {_LIMITS[error.validator]} {allowed:g}")
        case "multipleOf":
            return complain(f"{where} = {value!r}: must be a multiple of {allowed:g}")
        case "minItems" | "minProperties" | "minLength":
            return complain(f"{where} is empty: at least one entry is needed")
        case "uniqueItems":
            return complain(f"{where} = {_shown(value)}: the same value occurs twice")
    return complain(f"{where}: {error.message}")


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


def _shown(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
