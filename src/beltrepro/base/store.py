"""HDF5 in and out: named arrays with attributes, written whole or not at all.

The same content gives the same bytes: nothing written depends on time, path or order of keys.
A file has checksums of its content, which readers compare: a damaged file is never taken for whole.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from beltrepro.base import seal
from beltrepro.base.atomic import look_for_room, replacing
from beltrepro.base.errors import InputError

COMPRESS_FROM_BYTES = 1 << 16  # smaller arrays gain nothing
CHECKSUM = "checksum"  # attribute of the file: over all arrays and attributes


@dataclass(frozen=True)
class Dataset:
    """Arrays and attributes of one file, in model units."""

    arrays: dict[str, np.ndarray]  # by name, any shape; structured ones too
    attributes: dict  # numbers and texts by name


def write(
    path: str | os.PathLike,
    arrays: Mapping[str, npt.ArrayLike],
    attributes: Mapping[str, Any],
    about: Mapping[str, Mapping[str, str]] | None = None,
) -> None:
    """Write arrays with attributes; the file appears, sealed, when it is complete."""
    with replacing(path) as unfinished:
        # HDF5 crashes on a full disk
        look_for_room(unfinished, sum(np.asarray(array).nbytes for array in arrays.values()))
        with h5py.File(unfinished, "w", track_order=False) as file:
            for name in sorted(arrays):
                _write_array(file, name, np.asarray(arrays[name]), (about or {}).get(name, {}))
            for name in sorted(attributes):
                file.attrs[name] = attributes[name]
            file.attrs[CHECKSUM] = _checksum_of(file, _arrays(file))
        seal.put(unfinished)


def read(path: str | os.PathLike, *, strict: bool = False) -> Dataset:
    """Read what `write` wrote: text comes back as str, arrays with their dtype and shape."""
    seal.check(Path(path))  # before libhdf5 has it
    try:
        with h5py.File(path, "r") as file:
            _check(file, Path(path).stat().st_size)
            arrays = _arrays(file)
            attributes = {name: _plain(value) for name, value in file.attrs.items()}
            written = attributes.pop(CHECKSUM, None)
            expected = _checksum_of(file, arrays) if written or strict else None
    except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:
        raise InputError(f"{path}: not a readable HDF5 file ({error})") from None
    if written != expected:
        reason = "its content does not have its checksum" if written else "it has no checksum"
        raise InputError(f"{path}: damaged or of an older version: {reason}")
    return Dataset(arrays, attributes)


def checksum(array: np.ndarray) -> str:
    """Text that differs for arrays of different type, shape or bits."""
    stored = np.ascontiguousarray(array.astype(_with_text(array.dtype, "U", "S")))
    digest = hashlib.sha256(f"{stored.dtype.descr} {stored.shape}".encode())
    digest.update(stored.tobytes())
    return digest.hexdigest()[:16]


def _checksum_of(file: h5py.File, arrays: dict[str, np.ndarray]) -> str:
    """Checksum of an open file: of its arrays, as they are in it, and of all attributes."""
    content = {name: [checksum(arrays[name]), _plain_attributes(file[name])] for name in arrays}
    text = json.dumps([content, _plain_attributes(file)], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _plain_attributes(item: Any) -> dict:
    return {name: _plain(value) for name, value in item.attrs.items() if name != CHECKSUM}


def _write_array(file: h5py.File, name: str, array: np.ndarray, about: Mapping[str, str]) -> None:
    stored = array.astype(_with_text(array.dtype, "U", "S"))
    options = {}
    if stored.nbytes >= COMPRESS_FROM_BYTES:
        options = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
    dataset = file.create_dataset(name, data=stored, track_times=False, **options)
    for key in sorted(about):
        dataset.attrs[key] = about[key]


def _check(file: h5py.File, size: int) -> None:
    """Refuse arrays of neither numbers nor text, or larger than a file of this size can hold.

    A file can claim a length without having a single value. What is compressed is smaller by a
    factor of 1032 at most (https://zlib.net/zlib_tech.html).
    """
    items: list[Any] = []
    file.visititems(lambda _, item: items.append(item))
    arrays = [item for item in items if isinstance(item, h5py.Dataset)]
    for array in arrays:
        if array.shape is None or array.dtype.kind == "O":
            raise ValueError(f"{array.name} is no array of numbers or text")
    if (claimed := sum(array.nbytes for array in arrays)) > 1032 * size:
        raise ValueError(f"its arrays claim {claimed / 1e6:.3g} MB")


def _arrays(file: h5py.File) -> dict[str, np.ndarray]:
    """All arrays by their names, with those of the groups they are in: "group/array"."""
    arrays: dict[str, np.ndarray] = {}

    def keep(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset):
            arrays[name] = item[()].astype(_with_text(item.dtype, "S", "U"))

    file.visititems(keep)
    return arrays


def _with_text(dtype: np.dtype, kind: str, other: str) -> np.dtype:
    """The dtype with text of one kind (U: unicode, S: bytes) turned into the other."""
    if dtype.names:
        return np.dtype([(name, _with_text(dtype[name], kind, other)) for name in dtype.names])
    if dtype.subdtype:
        base, shape = dtype.subdtype
        return np.dtype((_with_text(base, kind, other), shape))
    if dtype.kind != kind:
        return dtype
    return np.dtype(f"{other}{dtype.itemsize // (4 if kind == 'U' else 1)}")


def _plain(value: Any) -> Any:
    value = value.item() if isinstance(value, np.generic) else value
    return value.decode() if isinstance(value, bytes) else value
