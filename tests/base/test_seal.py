"""The seal of a file: each flipped bit is found, and none reaches the HDF5 library."""

import hashlib
import os
import re
from contextlib import contextmanager

import h5py
import numpy as np
import pytest

from beltrepro.base import reading, seal, store
from beltrepro.base.errors import InputError

BYTES = np.random.default_rng(1).bytes(300)


@contextmanager
def flipped(path, place):
    """The file with one bit of this byte flipped, in place: to truncate it each time is slow."""
    with path.open("r+b", buffering=0) as file:
        byte = os.pread(file.fileno(), 1, place)
        os.pwrite(file.fileno(), bytes([byte[0] ^ 1 << place % 8]), place)
        yield
        os.pwrite(file.fileno(), byte, place)


@pytest.mark.parametrize("ending", [".png", ".pdf", ".csv", ".html", ".mp4", ".svg"])
def test_each_flipped_missing_or_added_byte_is_found(tmp_path, ending):
    path = tmp_path / f"a{ending}"
    path.write_bytes(BYTES)
    refused = pytest.raises(InputError, match=rf"a{ending}: (damaged|has no seal): .* make it aga")
    with refused:
        seal.check(path)
    seal.put(path)
    assert path.read_bytes().startswith(BYTES) and seal.check(path) == len(BYTES)
    size = path.stat().st_size
    for place in range(size):
        with flipped(path, place), refused:
            seal.check(path)
    for length in (size + 1, *range(size - 1, -1, -7)):
        os.truncate(path, length)
        with refused:
            seal.check(path)


def test_each_piece_of_a_long_file_counts(tmp_path):
    path = tmp_path / "a.mp4"
    path.write_bytes(8000 * BYTES)
    seal.put(path)
    assert seal.check(path) == 8000 * len(BYTES)
    for place in range(0, 8000 * len(BYTES), 1 << 19):
        with flipped(path, place), pytest.raises(InputError, match="damaged"):
            seal.check(path)


@pytest.fixture
def saved(tmp_path):
    """A file of HDF5."""
    path = tmp_path / "a.h5"
    store.write(path, {"x": np.linspace(0, 1, 9)}, {"kind": "a text in a heap", "n": 3})
    return path


def test_no_damage_reaches_the_hdf5_library(saved, monkeypatch):
    monkeypatch.setattr(h5py, "File", None)
    for place in range(saved.stat().st_size):
        with flipped(saved, place), pytest.raises(InputError, match=r"a\.h5: (damaged|has no sea)"):
            store.read(saved)


def test_hdf5_looks_no_further_than_its_end_and_loses_the_seal_when_it_writes(saved):
    content = saved.read_bytes()
    assert content[8] == 0  # a superblock of version 0, with the end of the file at byte 40
    assert int.from_bytes(content[40:48], "little") == seal.check(saved)
    with h5py.File(saved, "r+") as file:
        file.attrs["n"] = 4
    with pytest.raises(InputError, match="has no seal: another program made it or changed it; if"):
        store.read(saved)


def test_a_file_of_version_1_0_is_read(saved):
    """It has the same seal, and a checksum among its attributes."""
    attributes = store.read(saved).attributes
    with h5py.File(saved, "r+") as file:
        file.attrs["checksum"] = "0123"
    content = saved.read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    saved.write_bytes(content + b"\nbeltrepro sha256 " + digest.encode())
    assert store.read(saved).attributes == attributes


@pytest.mark.parametrize("name", ["none.h5", ".", "pipe"])
def test_what_cannot_be_read_is_one_line(tmp_path, name):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match=f"{re.escape(str(tmp_path / name))}: (no such|cannot be)"):
        seal.check(tmp_path / name)


def test_a_text_that_is_too_large_or_none_is_one_line(tmp_path):
    (tmp_path / "a").write_bytes(b"\xff" * 9)
    with pytest.raises(InputError, match=r"a: too large: 9e-06 MB, at most 8e-06 MB"):
        reading.text(tmp_path / "a", 8)
    with pytest.raises(InputError, match="a: not a text file in UTF-8"):
        reading.text(tmp_path / "a")
