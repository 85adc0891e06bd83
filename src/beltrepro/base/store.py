"""HDF5 in and out: named arrays with attributes, written whole or not at all.

The same content gives the same bytes: nothing written depends on time, path or order of keys.
"""

import hashlib
import os
from collections.abc import Mapping, Sequence
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
_COMPRESSED = {"compression": "gzip", "compression_opts": 4, "shuffle": True}


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
    axes: Mapping[str, Sequence[str]] | None = None,
) -> None:
    """Write arrays with attributes; the file appears, sealed, when it is complete."""
    with replacing(path) as unfinished:
        look_for_room(unfinished, sum(np.asarray(array).nbytes for array in arrays.values()))
        with h5py.File(unfinished, "w", track_order=False) as file:
            for name in sorted(arrays):
                array = np.asarray(arrays[name])
                stored = array.astype(_with_text(array.dtype, "U", "S"))
                options = _COMPRESSED if stored.nbytes >= COMPRESS_FROM_BYTES else {}
                dataset = file.create_dataset(name, data=stored, track_times=False, **options)
                dataset.attrs.update(sorted((about or {}).get(name, {}).items()))
            _name_axes(file, axes or {})
            file.attrs.update(sorted(attributes.items()))
        seal.put(unfinished)


def read(path: str | os.PathLike) -> Dataset:
    """Read what `write` wrote: text comes back as str, arrays with their dtype and shape."""
    if Path(path).suffix.lower() == ".csv":
        raise InputError(f"path = {path}: pandas.read_csv reads a table; this needs an .h5")
    # Before libhdf5 has it, which does not survive every flipped bit: one in the type of a text is
    # a segmentation fault, after one in the heap of texts it reads on and on.
    seal.check(Path(path))
    try:
        with h5py.File(path, "r") as file:
            arrays = _arrays(file)
            attributes = {
                name: value.item() if isinstance(value, np.generic) else value
                for name, value in file.attrs.items()
            }
    except OSError as error:
        raise InputError(f"{path}: not a readable HDF5 file ({error})") from None
    attributes.pop("checksum", None)  # version 1.0 had one there
    return Dataset(arrays, attributes)


def checksum(array: np.ndarray) -> str:
    """Text that differs for arrays of different type, shape or bits."""
    stored = np.ascontiguousarray(array.astype(_with_text(array.dtype, "U", "S")))
    digest = hashlib.sha256(f"{stored.dtype.descr} {stored.shape}".encode())
    digest.update(stored.tobytes())
    return digest.hexdigest()[:16]


def _arrays(file: h5py.File) -> dict[str, np.ndarray]:
    """All arrays by their names, with those of the groups they are in: "group/array"."""
    items: dict[str, Any] = {}
    file.visititems(items.__setitem__)
    return {
        name: item[()].astype(_with_text(item.dtype, "S", "U"))
        for name, item in items.items()
        if isinstance(item, h5py.Dataset) and not item.is_scale
    }


def _name_axes(file: h5py.File, axes: Mapping[str, Sequence[str]]) -> None:
    """Make dimensions of netCDF of axes; its length is added to a name that another one has."""
    for name in sorted(axes):
        for size, word, axis in zip(file[name].shape, axes[name], file[name].dims, strict=False):
            if word in axes or (word in file and len(file[word]) != size):
                word = f"{word}_{size}"
            if word not in file:
                scale = file.create_dataset(word, (size,), "i4", track_times=False)
                scale.make_scale(f"This is a netCDF dimension but not a netCDF variable.{size:10}")
            axis.attach_scale(file[word])


def _with_text(dtype: np.dtype, kind: str, other: str) -> np.dtype:
    """The dtype with text of one kind (U: unicode, S: bytes) turned into the other."""
    if dtype.names:
        return np.dtype([(name, _with_text(dtype[name], kind, other)) for name in dtype.names])
    if dtype.kind != kind:
        return dtype
    return np.dtype(f"{other}{dtype.itemsize // (4 if kind == 'U' else 1)}")
