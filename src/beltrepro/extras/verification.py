"""Results compared with a published list: bits on a like machine, bounds on another one.

A list has for each dataset what it was told, and for each array a checksum, and number, mean and
standard deviation of its values; for each table a checksum; and the verdict on each claim. Kernels
compiled for other instructions round differently. Then paths that are too short for chaos to show
it agree to `TOLERANCE`, and means over the points of long runs to `DEVIATIONS` standard errors.
What a dataset was told agrees always. A difference matters if a claim gets another verdict.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel, ValidationError, create_model

from beltrepro.base import provenance, reading, seal, store
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import files, manifest, tables
from beltrepro.replication.plan.points import QUANTITIES

SHORT = 500.0  # model time; a distance grows e-fold in 60 and more
TOLERANCE = 1e-6  # of means in short runs, as a share of mean plus standard deviation
DEVIATIONS = 6.0  # standard errors between means of long runs
SAME, NEAR, WRONG = "the same bits", "within the bounds of another machine", "wrong"

_TOLD: Any = dict.fromkeys((*files.IDENTITY, "digest"), (Any, ...))


class _ListedArray(BaseModel):
    checksum: str
    values: dict


class _ListedDataset(BaseModel):
    told: create_model("_Told", **_TOLD)  # type: ignore[valid-type]
    duration: float
    arrays: dict[str, _ListedArray]


class _List(BaseModel):
    preset: str
    run: str
    machine: dict
    datasets: dict[str, _ListedDataset]
    tables: dict
    verdicts: dict = {}


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
    datasets = {path.stem: files.read_any(path) for path in paths}
    first = next(iter(datasets.values())).attributes
    manifest.check(results, [_below(path, results) for path in _tables(results)], first)
    return {
        **{name: first[name] for name in ("preset", "run", "code_version")},
        "machine": {name: first[name] for name in provenance.machine()},
        "datasets": {name: _described(dataset) for name, dataset in datasets.items()},
        "tables": {path.stem: seal.digest_of(path)[:16] for path in _tables(results)},
        "verdicts": _verdicts(results),
    }


def write_list(path: Path, results: Path) -> int:
    """Write the list of the results of a run as JSON."""
    listed = make_list(results)
    with replacing(path) as unfinished:
        unfinished.write_text(json.dumps(listed, indent=1) + "\n", encoding="utf-8")
    return len(listed["datasets"])


def read_list(path: Path) -> dict:
    """Read a list."""
    if not path.exists():
        raise InputError(f"{path}: no such list; --list FILE takes another one, --write makes one")
    listed = reading.json_object(path)
    try:
        _List.model_validate(listed)
    except ValidationError as error:
        fault = error.errors()[0]
        place = ".".join(map(str, fault["loc"]))
        raise InputError(f"{path}: not a list of results ({place}: {fault['msg']})") from None
    return listed


def compare(results: Path, listed: dict) -> Iterator[Comparison]:
    """Compare results with a list."""
    run = {"preset": listed["preset"], "run": listed["run"]}
    same_machines = True
    for name, entry in listed["datasets"].items():
        path = results / "datasets" / f"{name}.h5"
        try:
            dataset = files.read(path, entry["told"])
        except InputError as error:
            yield Comparison(name, WRONG, str(error))
            continue
        machine = {part: dataset.attributes.get(part) for part in listed["machine"]}
        same_machine = machine == listed["machine"]
        same_machines &= same_machine
        outcome, words = _compare_arrays(dataset, entry, same_machine)
        if outcome == WRONG:
            words = f"{path}: {words}; {files.repair(path, run)}"
        yield Comparison(name, outcome, words)
    tables = {path.stem: path for path in _tables(results)}
    for name, checksum in listed["tables"].items():
        if name in tables:
            yield _compare_table(results, tables[name], checksum, run, same_machines)
        else:
            yield Comparison(name, WRONG, f"{results}: table {name} is missing")
    try:
        verdicts = _verdicts(results)
    except InputError as error:
        yield Comparison("claims", WRONG, f"{error}; {files.repair(results / 'claims.csv', run)}")
        return
    for claim, verdict in listed.get("verdicts", {}).items():
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


def _compare_table(
    results: Path, path: Path, listed: str, run: dict, same_machine: bool
) -> Comparison:
    try:
        manifest.check(results, [_below(path, results)], run)
    except InputError as error:
        return Comparison(path.stem, WRONG, str(error))
    if seal.digest_of(path)[:16] == listed:
        return Comparison(path.stem, SAME)
    if not same_machine:
        return Comparison(path.stem, NEAR)
    words = f"{path}: differs from the list; {files.repair(path, run)}"
    return Comparison(path.stem, WRONG, words)


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


def _compare_arrays(dataset: store.Dataset, entry: dict, same_machine: bool) -> tuple[str, str]:
    """Outcome for a dataset, and what is not as the list says."""
    if set(dataset.arrays) != set(entry["arrays"]):
        return WRONG, "has other arrays than the list"
    outcome, faults = SAME, []
    n_points = len(dataset.arrays["n_blocks"])
    for name, array in dataset.arrays.items():
        listed = entry["arrays"][name]
        if store.checksum(array) == listed["checksum"]:
            continue
        outcome = NEAR
        if same_machine or name in QUANTITIES:
            faults.append(f"{name} has other bits")
        elif any(
            _apart(summary, listed["values"].get(part), entry["duration"], n_points)
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
    if not path.exists():
        return {}
    try:
        rows = tables.read_as_text(path)
        verdicts = rows["replicated"] + " and " + rows["robust"]
        return dict(zip(rows["id"], verdicts, strict=True))
    except KeyError as error:
        raise InputError(f"{path}: not a table of claims: it lacks {error}") from None


def _below(path: Path, results: Path) -> str:
    return path.relative_to(results).as_posix()


def _tables(results: Path) -> list[Path]:
    return sorted([*results.glob("*.csv"), *(results / "tables").glob("*.csv")])
