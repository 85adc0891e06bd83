"""Files of results: datasets and their batches, tables, and what jobs read.

Each has a seal and says what it holds and what made it: a dataset in its attributes, a figure in
its texts, a table or track in its first line. That line begins with #, and so does the seal:
`pandas.read_csv(path, comment="#")` reads the rest.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import provenance, reading, seal, store
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.base.store import Dataset
from beltrepro.model import ChainParameters
from beltrepro.replication.plan.kinds import FILM, KINDS, POINT, TRACK
from beltrepro.replication.plan.points import CHAIN, DEFAULTS, QUANTITIES, UNITS

if TYPE_CHECKING:
    import pandas as pd

IDENTITY = ("dataset", "kind", "preset", "run", "digest")
DIGITS = "%.6g"  # of the numbers in tables


# --- datasets and their batches ---


def write(
    path: str | Path,
    spec: dict,
    arrays: dict[str, np.ndarray],
    origin: dict[str, str] | None = None,
) -> None:
    """Write arrays with what they are, what made them, and the quantities with a single value."""
    described = KINDS[spec["kind"]].arrays
    single = {
        name: arrays[name][0].item()
        for name in QUANTITIES
        if len(arrays.get(name, ())) and np.all(arrays[name] == arrays[name][0])
    }
    settings = {
        name: ", ".join(map(str, value)) if isinstance(value, list | tuple) else value
        for name, value in spec["settings"].items()
        if value is not None
    }
    config = json.dumps(spec, sort_keys=True)
    attributes = {
        **{name: spec[name] for name in IDENTITY[:-1]},
        "digest": hashlib.sha256(config.encode()).hexdigest()[:16],
        "config": config,
        **(origin or provenance.origin()),
        **settings,
        "method": ", ".join(np.unique(arrays["method"])),
        **single,
    }
    store.write(path, arrays, attributes, {name: described[name].attributes() for name in arrays})


def join(parts: Sequence[Dataset], kind: str) -> dict[str, np.ndarray]:
    """Arrays of a whole dataset from those of its batches, in their order.

    Arrays are joined along the axis of points; of records, `point` counts on. Arrays without points
    must agree.
    """
    counts = [len(part.arrays["n_blocks"]) for part in parts]
    first = np.cumsum([0, *counts[:-1]])
    arrays = {}
    for name in dict.fromkeys(name for part in parts for name in part.arrays):
        pieces = [
            part.arrays[name] if name in part.arrays else np.full(count, DEFAULTS[name])
            for part, count in zip(parts, counts, strict=True)
        ]
        described = KINDS[kind].arrays[name]
        if not described.fields and POINT not in described.dimensions:
            if not all(np.allclose(piece, pieces[0]) for piece in pieces):
                raise InputError(f"the batches differ in {name}")
            pieces = pieces[:1]
        arrays[name] = _joined(pieces)
        if described.fields:
            arrays[name][POINT] += np.repeat(first, list(map(len, pieces)))
    return arrays


def _joined(pieces: list[np.ndarray]) -> np.ndarray:
    """The pieces in one array; axes but the first are filled up, of records those of each field."""
    if names := pieces[0].dtype.names:
        columns = {name: _joined([piece[name] for piece in pieces]) for name in names}
        records = np.empty(
            sum(map(len, pieces)),
            [(name, column.dtype, column.shape[1:]) for name, column in columns.items()],
        )
        for name, column in columns.items():
            records[name] = column
        return records
    longest = np.max([piece.shape[1:] for piece in pieces], axis=0).astype(int)
    absent = np.nan if pieces[0].dtype.kind == "f" else 0
    filled = []
    for piece in pieces:
        missing = [(0, size) for size in longest - piece.shape[1:]]
        filled.append(np.pad(piece, [(0, 0), *missing], constant_values=absent))
    return np.concatenate(filled)


def chain(dataset: Dataset) -> ChainParameters:
    """The chain of a dataset in which all points have the same one."""
    given = dataset.attributes
    return ChainParameters(**{name: given[name] for name in CHAIN if name in given})


# --- tables ---


def about(title: str, columns: dict[str, str], sources: dict[str, dict]) -> dict[str, Any]:
    """What a table says of itself.

    columns : words on each; sources : the datasets behind it.
    """
    described = {"title": title, "columns": columns, "sources": sources}
    return described | provenance.origin()


def write_table(
    path: str | Path,
    table: pd.DataFrame,
    *,
    title: str,
    columns: dict[str, str],
    sources: dict[str, dict],
) -> None:
    """Write a table as CSV; columns : words on those that are no quantities of the model."""
    words = {
        name: f"{QUANTITIES[name].description} Unit: {UNITS[QUANTITIES[name].unit]}."
        for name in table
        if name in QUANTITIES
    }
    words |= {name: columns[name] for name in table if name in columns}
    with replacing(path) as unfinished:
        with unfinished.open("w", encoding="utf-8") as file:
            file.write(f"# {json.dumps(about(title, words, sources))}\n")
            table.to_csv(file, index=False, float_format=DIGITS)
        seal.put(unfinished)


def read_table(path: str | Path, **how: Any) -> pd.DataFrame:
    """Read a table as `pandas.read_csv`; how : more arguments of it."""
    import pandas as pd  # most figures need no table

    try:
        table = pd.read_csv(StringIO(rows(path)), **how)
    except (pd.errors.EmptyDataError, pd.errors.ParserError) as error:
        raise InputError(f"{path}: not a table of comma-separated values ({error})") from None
    if not isinstance(table.index, pd.RangeIndex):  # pandas takes the first cells for names
        raise InputError(f"{path}: its rows have more cells than its first line has columns")
    return table


def read_as_text(path: str | Path) -> list[dict[str, str]]:
    """The rows of a table by the names of its columns, each value as it is written."""
    return read_table(path, dtype=str, keep_default_na=False).to_dict("records")


def rows(path: str | Path) -> str:
    """The text of a table without the line that says what it is, and without its seal."""
    return _parts(Path(path))[1]


def said(path: str | Path) -> dict[str, Any]:
    """What a table or track says of itself."""
    return _parts(Path(path))[0]


def _parts(path: Path) -> tuple[dict[str, Any], str]:
    """What a table says of itself, and its rows. Those of version 1.0 have no seal, and say {}."""
    text = reading.text(path)
    if not text.startswith("# ") and seal.MARKER not in text:
        return {}, text
    first, _, table = seal.content(path).partition("\n")
    return json.loads(first[2:]), table


# --- inputs of jobs ---


def load(paths: dict[str, str]) -> tuple[dict[str, Any], dict[str, dict]]:
    """What jobs are made from, by name of the dataset, table, film or track, and its sources.

    Sources are the datasets behind all: what each was told, and the code it is of.
    """
    data: dict[str, Any] = {}
    sources: dict[str, dict] = {}
    for name, path in paths.items():
        data[name] = _load(name, Path(path))
        if isinstance(data[name], Dataset):
            keys = (*IDENTITY[2:], "code_version")
            sources[name] = {key: data[name].attributes[key] for key in keys}
        else:  # beside a film lies its track, of the same job
            sources |= said(Path(path).with_suffix(".csv"))["sources"]
    return data, dict(sorted(sources.items()))


def _load(name: str, path: Path) -> Any:
    if path.suffix == ".h5":
        dataset = store.read(path)
        is_run = dataset.attributes["kind"] == "series" and len(dataset.arrays["n_blocks"]) == 1
        return _single_run(dataset) if is_run else dataset
    if name.endswith(FILM):
        from beltrepro.replication.camera.video import read_video

        return partial(read_video, path)
    if name.endswith(TRACK):
        from beltrepro.replication.camera.track import Track

        return Track.load(path)
    return read_table(path)


def _single_run(series: Dataset) -> Dataset:
    """A series of one point as that run."""
    described = KINDS["series"].arrays
    arrays = {}
    for name, values in series.arrays.items():
        if described[name].fields:
            arrays[name] = values[[field for field in values.dtype.names or () if field != POINT]]
        else:
            arrays[name] = values[0] if POINT in described[name].dimensions else values
    return Dataset(arrays, series.attributes)
