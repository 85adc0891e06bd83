"""Results compared with a published list: bits on a like machine, bounds on another one.

A list has for each dataset what it was told, and for each array a checksum, and number, mean and
standard deviation of its values; for each table a checksum of its rows; and the verdict on each
claim. Kernels compiled for other instructions round differently. Then paths that are too short for
chaos to show it agree to `TOLERANCE`, and means over the points of long runs to `DEVIATIONS`
standard errors. What a dataset was told agrees always. A difference matters if a claim gets another
verdict.
"""

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel, ValidationError

from beltrepro.base import provenance, reading, seal, store
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io
from beltrepro.replication.plan.points import QUANTITIES

SHORT = 500.0  # model time; a distance grows e-fold in 60 and more
TOLERANCE = 1e-6  # of means in short runs, as a share of mean plus standard deviation
DEVIATIONS = 6.0  # standard errors between means of long runs
SAME, NEAR, WRONG = "the same bits", "within the bounds of another machine", "wrong"
# What a run has besides datasets and tables; what kills left has names that begin with a dot.
SHOWN = ("figures/[!.]*", "experiment/[!.]*", "report.html")


class _ListedArray(BaseModel):
    checksum: str
    values: dict[str, list]


class _ListedDataset(BaseModel):
    told: dict[str, str]
    duration: float
    arrays: dict[str, _ListedArray]


class Listed(BaseModel):
    """A list, as JSON has it."""

    machine: dict[str, str]
    datasets: dict[str, _ListedDataset]
    tables: dict[str, str]
    verdicts: dict[str, str] = {}


class Comparison(NamedTuple):
    """What was found of one file."""

    name: str  # of the dataset or table
    outcome: str  # SAME, NEAR or WRONG
    words: str = ""  # what is wrong and how to repair it; empty otherwise


def make_list(results: Path) -> dict:
    """The list of the results of a run."""
    paths = sorted((results / "datasets").glob("*.h5"))
    if not paths:
        raise InputError(f"{results}: no datasets there")
    datasets = {path.stem: store.read(path) for path in paths}
    first = next(iter(datasets.values())).attributes
    return {
        **{name: first[name] for name in ("preset", "run", "code_version")},
        "machine": {name: first[name] for name in provenance.machine()},
        "datasets": {name: _described(dataset) for name, dataset in datasets.items()},
        "tables": {name: _digest(path) for name, path in _tables(results).items()},
        "verdicts": _verdicts(results),
    }


def write_list(path: Path, results: Path) -> int:
    """Write the list of the results of a run as JSON."""
    listed = make_list(results)
    with replacing(path) as unfinished:
        unfinished.write_text(json.dumps(listed, indent=1) + "\n", encoding="utf-8")
    return len(listed["datasets"])


def read_list(path: Path) -> Listed:
    """Read a list."""
    if not path.exists():
        raise InputError(f"{path}: no such list; --list FILE takes another one, --write makes one")
    try:
        return Listed.model_validate_json(reading.text(path))
    except ValidationError as error:
        fault = error.errors()[0]
        place = ".".join(map(str, fault["loc"]))
        raise InputError(f"{path}: not a list of results ({place}: {fault['msg']})") from None


def compare(results: Path, listed: Listed) -> Iterator[Comparison]:
    """Compare results with a list: its datasets, tables and verdicts, and all files' seals."""
    same_machines = True
    for name, entry in listed.datasets.items():
        path = results / "datasets" / f"{name}.h5"
        try:
            dataset = store.read(path)
        except InputError as error:
            yield Comparison(name, WRONG, str(error))
            continue
        same_machine = dataset.attributes.items() >= listed.machine.items()
        same_machines &= same_machine
        outcome, words = _compare_arrays(dataset, entry, same_machine)
        yield Comparison(name, outcome, words and f"{path}: {words}: {seal.REMEDY}")
    tables = _tables(results)
    for name, digest in listed.tables.items():
        path = tables.get(name, results / f"{name}.csv")
        try:
            is_same = _digest(path) == digest
        except InputError as error:
            yield Comparison(name, WRONG, str(error))
            continue
        if is_same or not same_machines:
            yield Comparison(name, SAME if is_same else NEAR)
        else:
            yield Comparison(name, WRONG, f"{path}: differs from the list: {seal.REMEDY}")
    for path in (path for pattern in SHOWN for path in sorted(results.glob(pattern))):
        try:
            seal.check(path)
        except InputError as error:
            yield Comparison(path.name, WRONG, str(error))
    try:
        verdicts = _verdicts(results)
    except InputError as error:
        yield Comparison("claims", WRONG, str(error))
        return
    for claim, verdict in listed.verdicts.items():
        if (here := verdicts.get(claim, "missing")) != verdict:
            words = f"claim {claim}: {here} here, {verdict} in the list; this matters"
            yield Comparison(claim, WRONG, words)


def conclusion(comparisons: list[Comparison]) -> str:
    """What the comparisons mean together, in a sentence."""
    outcomes = {file.outcome for file in comparisons}
    if WRONG in outcomes:
        return "different: see the lines above"
    if NEAR in outcomes:
        return (
            "equal within the bounds of another machine: this does not matter, "
            "each claim has its verdict of the list"
        )
    return "equal: every bit of the list"


def _described(dataset: store.Dataset) -> dict:
    about = dataset.attributes
    return {
        "told": {name: about[name] for name in io.IDENTITY},
        "duration": about["duration"],
        "arrays": {
            name: {"checksum": store.checksum(array), "values": _summaries(array)}
            for name, array in dataset.arrays.items()
        },
    }


def _compare_arrays(
    dataset: store.Dataset, entry: _ListedDataset, same_machine: bool
) -> tuple[str, str]:
    """Outcome for a dataset, and what is not as the list says."""
    if not dataset.attributes.items() >= entry.told.items():
        return WRONG, "holds another dataset, or one of other settings"
    if set(dataset.arrays) != set(entry.arrays):
        return WRONG, "has other arrays than the list"
    outcome, faults = SAME, []
    n_points = len(dataset.arrays["n_blocks"])
    for name, array in dataset.arrays.items():
        listed = entry.arrays[name]
        if store.checksum(array) == listed.checksum:
            continue
        outcome = NEAR
        if same_machine or name in QUANTITIES:
            faults.append(f"{name} has other bits")
        elif any(
            _apart(summary, listed.values.get(part), entry.duration, n_points)
            for part, summary in _summaries(array).items()
        ):
            faults.append(f"{name} is beyond the bounds")
    return (WRONG if faults else outcome), "; ".join(faults)


def _apart(summary: list, listed: list | None, duration: float, n_points: int) -> bool:
    """Whether summaries differ by more than the machines explain."""
    if listed is None:
        return True
    (_, mean, _), (_, other, deviation) = summary, listed
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
    return [int(finite.size), *(float(f"{moment:.9g}") for moment in (finite.mean(), finite.std()))]


def _verdicts(results: Path) -> dict[str, str]:
    """Both verdicts by claim, as "yes and no"; none where claims were not measured."""
    path = results / "claims.csv"
    rows = io.read_as_text(path) if path.exists() else []
    try:
        return {row["id"]: f"{row['replicated']} and {row['robust']}" for row in rows}
    except KeyError as error:
        raise InputError(f"{path}: not a table of claims: it lacks {error}") from None


def _tables(results: Path) -> dict[str, Path]:
    paths = sorted([*results.glob("*.csv"), *(results / "tables").glob("*.csv")])
    return {path.stem: path for path in paths}


def _digest(path: Path) -> str:
    """Text that differs for tables of other rows: what made them is not compared."""
    seal.check(path)
    return hashlib.sha256(io.rows(path).encode()).hexdigest()[:16]
