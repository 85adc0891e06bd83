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
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from pydantic import BaseModel, ValidationError

from beltrepro.base import provenance, reading, seal, store
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io
from beltrepro.replication.plan.points import QUANTITIES

T = TypeVar("T")

SHORT = 500.0  # model time; a distance grows e-fold in 60 and more
TOLERANCE = 1e-6  # of means in short runs, as a share of mean plus standard deviation
DEVIATIONS = 6.0  # standard errors between means of long runs
SAME, NEAR = "the same bits", "within the bounds of another machine"
MISSING, WRONG = "not made", "wrong"
# What they mean together: the worst of them decides.
MEANINGS = {
    WRONG: "different: see the lines above",
    MISSING: "so far right: {made} of {listed} are made",
    NEAR: "equal within the bounds of another machine: this does not matter, "
    "each claim has its verdict of the list",
    SAME: "equal: every bit of the list",
}
# What a run has besides datasets and tables; what kills left has names that begin with a dot.
SHOWN = ("figures/[!.]*", "experiment/[!.]*", "report.html")


class _Array(BaseModel):
    checksum: str
    values: dict[str, list]


class _Dataset(BaseModel):
    told: dict[str, str]
    duration: float
    arrays: dict[str, _Array]


class Listed(BaseModel):
    """A list, as JSON has it."""

    machine: dict[str, str]
    datasets: dict[str, _Dataset]
    tables: dict[str, str]
    verdicts: dict[str, str] = {}


class Comparison(NamedTuple):
    """What was found of one file."""

    name: str  # of the dataset or table
    outcome: str  # SAME, NEAR, MISSING or WRONG
    words: str = ""  # what is wrong and how to repair it; empty otherwise


def write_list(path: Path, results: Path) -> int:
    """Write the list of the results of a run as JSON, and return the number of its datasets."""
    datasets = {path.stem: store.read(path) for path in sorted(results.glob("datasets/*.h5"))}
    if not datasets:
        raise InputError(f"{results}: no datasets there")
    about = next(iter(datasets.values())).attributes
    try:
        listed = {
            **{name: about[name] for name in ("preset", "run", "code_version")},
            "machine": {name: about[name] for name in provenance.machine()},
            "datasets": {name: _described(dataset) for name, dataset in datasets.items()},
            "tables": {name: _digest(path) for name, path in _tables(results).items()},
            "verdicts": _verdicts(results),
        }
    except KeyError as error:
        raise InputError(f"{results}: a dataset without {error}: not of the workflow") from None
    with replacing(path) as unfinished:
        unfinished.write_text(json.dumps(listed, indent=1) + "\n", encoding="utf-8")
    return len(datasets)


def read_list(path: Path) -> Listed:
    """Read a list."""
    try:
        return Listed.model_validate_json(reading.text(path))
    except ValidationError as error:
        fault = error.errors()[0]
        place = ".".join(map(str, fault["loc"]))
        raise InputError(f"{path}: not a list of results ({place}: {fault['msg']})") from None


def compare(results: Path, listed: Listed) -> Iterator[Comparison]:
    """Compare results with a list: its datasets, tables and verdicts, and all files' seals."""
    like_machine = True
    for name, entry in listed.datasets.items():
        path = results / "datasets" / f"{name}.h5"
        if not path.exists():
            yield Comparison(name, MISSING)
            continue
        dataset, fault = _tried(store.read, path)
        others: list[str] = []
        if dataset:
            like_here = dataset.attributes.items() >= listed.machine.items()
            like_machine &= like_here
            others, faults = _differences(dataset, entry, like_here)
            fault = faults and f"{path}: {faults}: {seal.REMEDY}"
        yield Comparison(name, WRONG if fault else NEAR if others else SAME, fault)
    tables = _tables(results)
    for name, digest in listed.tables.items():
        if name not in tables:
            yield Comparison(name, MISSING)
            continue
        path = tables[name]
        here, fault = _tried(_digest, path)
        if here not in (None, digest) and like_machine:
            fault = f"{path}: differs from the list: {seal.REMEDY}"
        yield Comparison(name, WRONG if fault else SAME if here == digest else NEAR, fault)
    for path in (path for pattern in SHOWN for path in sorted(results.glob(pattern))):
        _, fault = _tried(seal.check, path)
        if fault:
            yield Comparison(path.name, WRONG, fault)
    # a table of claims that is damaged, or not there, is told above
    verdicts, _ = _tried(_verdicts, results) if "claims" in tables else (None, "")
    for claim, verdict in listed.verdicts.items():
        if verdicts is not None and (here := verdicts.get(claim, "missing")) != verdict:
            words = f"claim {claim}: {here} here, {verdict} in the list; this matters"
            yield Comparison(claim, WRONG, words)


def _tried(read: Callable[[Path], T], path: Path) -> tuple[T | None, str]:
    """What is read, or why it cannot be."""
    try:
        return read(path), ""
    except InputError as error:
        return None, str(error)


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


def _differences(
    dataset: store.Dataset, entry: _Dataset, like_machine: bool
) -> tuple[list[str], str]:
    """Arrays with other bits than listed, and which of them another machine does not explain."""
    arrays, listed = dataset.arrays, entry.arrays
    if not dataset.attributes.items() >= entry.told.items() or set(arrays) != set(listed):
        return [], "holds another dataset, or one of other settings"
    others = [name for name in arrays if store.checksum(arrays[name]) != listed[name].checksum]
    faults = []
    for name in others:
        if like_machine or name in QUANTITIES:
            faults.append(f"{name} has other bits")
        elif any(
            _apart(summary, listed[name].values.get(part), entry.duration, len(arrays["n_blocks"]))
            for part, summary in _summaries(arrays[name]).items()
        ):
            faults.append(f"{name} is beyond the bounds")
    return others, "; ".join(faults)


def _apart(summary: list, listed: list | None, duration: float, n_points: int) -> bool:
    """Whether summaries differ by more than the machines explain."""
    if listed is None:
        return True
    (size, mean, _), (listed_size, other, deviation) = summary, listed
    if size != listed_size and (duration <= SHORT or not size):
        return True
    if duration <= SHORT:
        return abs(mean - other) > TOLERANCE * (abs(other) + deviation)
    # the list is right, and its scatter that of the points
    error = deviation * np.sqrt(2 / n_points)
    return abs(mean - other) > DEVIATIONS * error + TOLERANCE * abs(other)


def _summaries(array: np.ndarray) -> dict[str, list[Any]]:
    """Number of finite values, their mean and standard deviation; of records for each field."""
    summaries = {}
    for name in array.dtype.names or [""]:
        values = array[name] if name else array
        if values.dtype.kind in "fiub":
            finite = values[np.isfinite(values)].astype(float)
            moments = (finite.mean(), finite.std()) if finite.size else (0.0, 0.0)
            summaries[name] = [finite.size, *(float(f"{moment:.9g}") for moment in moments)]
    return summaries


def _verdicts(results: Path) -> dict[str, str]:
    """Both verdicts by claim, as "yes and no"; none where claims were not measured."""
    path = results / "claims.csv"
    rows = io.read_as_text(path) if path.exists() else []
    return {row["id"]: f"{row.get('replicated')} and {row.get('robust')}" for row in rows}


def _tables(results: Path) -> dict[str, Path]:
    paths = sorted([*results.glob("*.csv"), *results.glob("tables/*.csv")])
    return {path.stem: path for path in paths}


def _digest(path: Path) -> str:
    """Text that differs for tables of other rows: what made them is not compared."""
    seal.check(path)
    return hashlib.sha256(io.rows(path).encode()).hexdigest()[:16]
