"""Results compared with a published list: bits on a like machine, bounds on another one.

A list has for each dataset what it was told, and for each array a checksum, and number, mean and
standard deviation of its values; for each table a checksum; and the verdict on each claim. Kernels
compiled for other instructions round differently. Then paths that are too short for chaos to show
it agree to `TOLERANCE`, and means over the points of long runs to `DEVIATIONS` standard errors.
What a dataset was told agrees always. A difference matters if a claim gets another verdict.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from jsonschema import Draft202012Validator

from beltrepro.base import provenance, store
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import files
from beltrepro.replication.plan.described import checksum, metadata_path
from beltrepro.replication.plan.points import QUANTITIES

SHORT = 500.0  # model time; a distance grows e-fold in 60 and more
TOLERANCE = 1e-6  # of means in short runs, as a share of mean plus standard deviation
DEVIATIONS = 6.0  # standard errors between means of long runs
_LIST = {
    "type": "object",
    "required": ["preset", "run", "machine", "datasets", "tables"],
    "properties": {
        "datasets": {
            "type": "object",
            "additionalProperties": {
                "type": "object",
                "required": ["told", "duration", "arrays"],
                "properties": {
                    "told": {"type": "object", "required": [*files.IDENTITY, "digest"]},
                    "duration": {"type": "number"},
                    "arrays": {
                        "type": "object",
                        "additionalProperties": {
                            "type": "object",
                            "required": ["checksum", "values"],
                        },
                    },
                },
            },
        },
        **{name: {"type": "object"} for name in ("machine", "tables", "verdicts")},
    },
}
SAME, NEAR, WRONG = "the same bits", "within the bounds of another machine", "wrong"


@dataclass(frozen=True)
class Finding:
    """What was found of one file."""

    name: str  # of the dataset or table
    outcome: str  # SAME, NEAR or WRONG
    words: str = ""  # what is wrong and how to repair it; empty otherwise


def make_list(results: Path) -> dict:
    """The list of the results of a run."""
    paths = sorted((results / "datasets").glob("*.h5"))
    if not paths:
        raise InputError(f"{results}: no datasets there")
    found = {path.stem: files.read_any(path) for path in paths}
    first = next(iter(found.values())).attributes
    return {
        **{name: first[name] for name in ("preset", "run", "code_version")},
        "machine": {name: first[name] for name in provenance.machine()},
        "datasets": {name: _described(each) for name, each in found.items()},
        "tables": {path.stem: checksum(path.read_bytes()) for path in _tables(results)},
        "verdicts": _verdicts(results),
    }


def write_list(path: Path, results: Path) -> int:
    """Write the list of the results of a run as JSON."""
    made = make_list(results)
    with replacing(path) as unfinished:
        unfinished.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")
    return len(made["datasets"])


def read_list(path: Path) -> dict:
    """Read a list."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(
            f"{path}: no such list; --list FILE takes another one, --write makes one"
        ) from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: not a readable list ({error})") from None
    if fault := next(Draft202012Validator(_LIST).iter_errors(found), None):
        raise InputError(f"{path}: not a list of results ({fault.message[:80]})")
    return found


def compare(results: Path, known: dict) -> Iterator[Finding]:
    """Compare results with a list."""
    told = {"preset": known["preset"], "run": known["run"]}
    alike = True
    for name, entry in known["datasets"].items():
        path = results / "datasets" / f"{name}.h5"
        try:
            found = files.read(path, entry["told"])
        except InputError as error:
            yield Finding(name, WRONG, str(error))
            continue
        machine = {each: found.attributes.get(each) for each in known["machine"]}
        same_machine = machine == known["machine"]
        alike &= same_machine
        differing = list(_differing(found, entry, same_machine))
        if differing:
            words = f"{path}: {'; '.join(differing)}; {files.repair(path, told)}"
            yield Finding(name, WRONG, words)
        else:
            same = _checksums(found) == _listed(entry)
            yield Finding(name, SAME if same else NEAR)
    tables = {path.stem: path for path in _tables(results)}
    for name, listed in known["tables"].items():
        if name in tables:
            yield _compare_table(tables[name], listed, told, alike)
        else:
            yield Finding(name, WRONG, f"{results}: table {name} is missing")
    try:
        verdicts = _verdicts(results)
    except InputError as error:
        yield Finding("claims", WRONG, f"{error}; {files.repair(results / 'claims.csv', told)}")
        return
    for claim, verdict in known.get("verdicts", {}).items():
        own = verdicts.get(claim, "missing")
        if own != verdict:
            words = f"claim {claim}: {own} here, {verdict} in the list; this matters"
            yield Finding(claim, WRONG, words)


def conclusion(findings: list[Finding]) -> str:
    """What the findings mean together, in a sentence."""
    outcomes = {each.outcome for each in findings}
    if WRONG in outcomes:
        return "different: see the lines above"
    if NEAR in outcomes:
        return (
            "equal within the bounds of another machine: this does not matter, "
            "each claim has its verdict of the list"
        )
    return "equal: every bit of the list"


def _compare_table(path: Path, listed: str, told: dict, same_machine: bool) -> Finding:
    try:
        own = checksum(path.read_bytes())
    except OSError as error:
        words = f"{path}: cannot be read ({error.strerror}); {files.repair(path, told)}"
        return Finding(path.stem, WRONG, words)
    try:
        said = json.loads(metadata_path(path).read_text(encoding="utf-8"))["beltrepro:checksum"]
    except (OSError, ValueError, KeyError):
        said = None
    if own == listed:
        return Finding(path.stem, SAME)
    if own == said and not same_machine:
        return Finding(path.stem, NEAR)
    reason = "differs from the list" if own == said else "does not have its checksum"
    return Finding(path.stem, WRONG, f"{path}: {reason}; {files.repair(path, told)}")


def _described(dataset: store.Dataset) -> dict:
    about = dataset.attributes
    return {
        "told": {name: about[name] for name in (*files.IDENTITY, "digest")},
        "duration": about["duration"],
        "arrays": {
            name: {"checksum": store.checksum(array), "values": _summaries(array)}
            for name, array in dataset.arrays.items()
        },
    }


def _checksums(dataset: store.Dataset) -> dict[str, str]:
    return {name: store.checksum(array) for name, array in dataset.arrays.items()}


def _listed(entry: dict) -> dict[str, str]:
    return {name: each["checksum"] for name, each in entry["arrays"].items()}


def _differing(dataset: store.Dataset, entry: dict, same_machine: bool) -> Iterator[str]:
    """What is not as the list says."""
    if set(dataset.arrays) != set(entry["arrays"]):
        yield "has other arrays than the list"
        return
    n_points = len(dataset.arrays["n_blocks"])
    for name, array in dataset.arrays.items():
        listed = entry["arrays"][name]
        if store.checksum(array) == listed["checksum"]:
            continue
        if same_machine or name in QUANTITIES:
            yield f"{name} has other bits"
        elif any(
            _apart(found, listed["values"].get(part), entry["duration"], n_points)
            for part, found in _summaries(array).items()
        ):
            yield f"{name} is beyond the bounds"


def _apart(found: list, listed: list | None, duration: float, n_points: int) -> bool:
    """Whether summaries differ by more than the machines explain."""
    if listed is None:
        return True
    (_, mean, _), (_, other, deviation) = found, listed
    if duration <= SHORT:
        return abs(mean - other) > TOLERANCE * (abs(other) + deviation)
    # the list is right, and its scatter that of the points
    error = deviation * np.sqrt(2 / n_points)
    return abs(mean - other) > DEVIATIONS * error + TOLERANCE * abs(other)


def _summaries(array: np.ndarray) -> dict[str, list[Any]]:
    """Number of finite values, their mean and standard deviation; of records for each field."""
    parts = {name: array[name] for name in array.dtype.names} if array.dtype.names else {"": array}
    return {name: _summary(values) for name, values in parts.items() if values.dtype.kind in "fiub"}


def _summary(values: np.ndarray) -> list[Any]:
    finite = values[np.isfinite(values)].astype(float)
    if not finite.size:
        return [0, 0.0, 0.0]
    return [int(finite.size), *(float(f"{each:.9g}") for each in (finite.mean(), finite.std()))]


def _verdicts(results: Path) -> dict[str, str]:
    """Verdict by claim; none where claims were not measured."""
    path = results / "claims.csv"
    if not path.exists():
        return {}
    try:
        rows = pd.read_csv(path, dtype=str, keep_default_na=False)
        whole = rows[rows["variant"] == ""]
        return dict(zip(whole["id"], whole["verdict"], strict=True))
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path}: not a table of claims ({error})") from None


def _tables(results: Path) -> list[Path]:
    """Tables with the same content for the same numbers: not that of times."""
    found = [*results.glob("*.csv"), *(results / "tables").glob("*.csv")]
    return sorted(path for path in found if path.stem != "timing")
