"""Files of datasets: what they say of themselves, how batches are joined, what readers check."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from beltrepro.base import provenance, seal, store
from beltrepro.base.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.replication.plan.kinds import KINDS, POINT, Array
from beltrepro.replication.plan.points import CHAIN, QUANTITIES

IDENTITY = ("dataset", "kind", "preset", "run")


def write(
    path: str | Path,
    spec: dict,
    arrays: dict[str, np.ndarray],
    origin: dict[str, str] | None = None,
) -> None:
    """Write arrays with what they are."""
    described = KINDS[spec["kind"]].arrays
    about = {name: described[name].attributes() for name in arrays}
    attributes = _attributes(spec, arrays, origin or provenance.origin())
    store.write(path, arrays, attributes, about)


def _attributes(spec: dict, arrays: dict, origin: dict) -> dict:
    """What a file is, what made it, its settings, and the quantities with a single value."""
    single = {
        name: arrays[name][0].item()
        for name in QUANTITIES
        if len(arrays[name]) and np.all(arrays[name] == arrays[name][0])
    }
    settings = {name: value for name, value in spec["settings"].items() if value is not None}
    lists = {name: value for name, value in settings.items() if isinstance(value, list | tuple)}
    settings |= {name: ", ".join(map(str, value)) for name, value in lists.items()}
    return {
        **{name: spec[name] for name in IDENTITY},
        "digest": digest(spec),
        "config": json.dumps(spec, sort_keys=True),
        **origin,
        **settings,
        "method": _methods(arrays),
        **single,
    }


def digest(spec: dict) -> str:
    """Text that differs for files that were told different things."""
    return seal.digest(json.dumps(spec, sort_keys=True).encode())[:16]


def expected(spec: dict) -> dict:
    """What `read` compares with a file: small, to be a parameter of a rule."""
    return {name: spec[name] for name in IDENTITY} | {"digest": digest(spec)}


def read(path: str | Path, expected: dict) -> store.Dataset:
    """Read a file and check that it holds what is asked for."""
    try:
        dataset = read_any(path)
    except InputError as error:
        raise InputError(f"{error}; {repair(path, expected)}") from None
    if dataset.attributes.get("digest") != expected["digest"]:
        asked = _identity(expected)
        held = _identity(dataset.attributes)
        held = f"{held} with other settings" if held == asked else held
        raise InputError(f"{path}: holds {held}, expected {asked}; {repair(path, expected)}")
    return dataset


def read_any(path: str | Path) -> store.Dataset:
    """Read a file, whatever dataset or batch it holds, and check that it is whole."""
    return store.read(path, strict=True)


def repair(path: str | Path, expected: dict) -> str:
    """Words on how to make a file of results again."""
    command = f"rm -f {path} && snakemake --cores 2 --config preset={expected['preset']}"
    if expected["run"] != expected["preset"]:
        command += f" run={expected['run']}"
    return f"to make it again: {command}"


def join(parts: Sequence[store.Dataset], described: dict[str, Array]) -> dict[str, np.ndarray]:
    """Arrays of a whole dataset from those of its batches, in their order.

    Arrays are joined along the axis of points; of records, `point` counts on. Further axes of
    different lengths are filled up, with NaN or 0. Arrays without points must agree.
    """
    counts = [len(part.arrays["n_blocks"]) for part in parts]
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    arrays = {}
    for name in parts[0].arrays:
        pieces = [part.arrays[name] for part in parts]
        if described[name].fields:
            pieces = [_shifted(piece, by) for piece, by in zip(pieces, first, strict=True)]
        elif POINT not in described[name].dimensions:
            if not all(np.allclose(piece, pieces[0]) for piece in pieces):
                raise InputError(f"the batches differ in {name}")
            pieces = pieces[:1]
        arrays[name] = np.concatenate(_alike(pieces))
    return arrays


def single_run(series: store.Dataset) -> store.Dataset:
    """A series of one point as that run."""
    described = KINDS["series"].arrays
    arrays = {}
    for name, values in series.arrays.items():
        if described[name].fields:
            fields = [field for field in values.dtype.fields or () if field != POINT]
            arrays[name] = values[fields]
        else:
            arrays[name] = values[0] if POINT in described[name].dimensions else values
    return store.Dataset(arrays, series.attributes)


def is_single_run(dataset: store.Dataset) -> bool:
    """Whether a dataset is a series of one point."""
    return dataset.attributes["kind"] == "series" and len(dataset.arrays["n_blocks"]) == 1


def chain(dataset: store.Dataset) -> ChainParameters:
    """The chain of a dataset in which all points have the same one."""
    return ChainParameters(**{name: dataset.attributes[name] for name in CHAIN})


def _identity(attributes: dict) -> str:
    words = "dataset {dataset} ({kind}) of preset {preset}, run {run}"
    return words.format(**{name: attributes.get(name, "unknown") for name in IDENTITY})


def _methods(arrays: dict) -> str:
    """The methods of the points in words."""
    without, with_noise = (
        ", ".join(np.unique(arrays["method"][chosen]))
        for chosen in (arrays["noise"] == 0, arrays["noise"] > 0)
    )
    if not (without and with_noise) or without == with_noise:
        return without or with_noise
    return f"{without} (sigma = 0), {with_noise} (sigma > 0)"


def _shifted(records, by):
    moved = records.copy()
    moved[POINT] += by
    return moved


def _alike(pieces):
    """The pieces with all axes but the first as long as the longest, of records each field."""
    if pieces[0].dtype.names:
        widest = [
            (name, max((piece.dtype[name] for piece in pieces), key=lambda one: one.itemsize))
            for name in pieces[0].dtype.names
        ]
        return [_with_fields(piece, np.dtype(widest)) for piece in pieces]
    shape = np.max([piece.shape[1:] for piece in pieces], axis=0).astype(int)
    return [_filled(piece, (len(piece), *shape)) for piece in pieces]


def _with_fields(records, dtype):
    if records.dtype == dtype:
        return records
    wide = np.empty(len(records), dtype)
    for name in dtype.names:
        wide[name] = _filled(records[name], wide[name].shape)
    return wide


def _filled(values, shape):
    if values.shape == tuple(shape):
        return values
    whole = np.full(shape, np.nan if values.dtype.kind == "f" else 0, values.dtype)
    whole[tuple(slice(length) for length in values.shape)] = values
    return whole
