"""The trailer of HDF5 files: no damaged byte reaches libhdf5, which some of them kill.

The damages of all kinds of files are in `test_integrity.py`.
"""

import faulthandler
import os
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

import damages
import small_plans
from beltrepro.base import atomic, provenance, seal, store
from beltrepro.base.errors import InputError
from beltrepro.extras import verification
from beltrepro.replication.plan import files, inputs
from beltrepro.replication.plan.points import columns
from beltrepro.replication.report.material import Material

TEXT = b"\x19\x01\x01"  # datatype of an attribute: class 9 of version 1, variable length; a text
DAMAGED = "damaged: its bytes do not have their checksum; to make it again: rm "


def write(path):
    """A small dataset; what its file must say of itself."""
    plan = small_plans.planned(name="rows", n_blocks=5, belt_velocity=[5, 10], duration=2000)
    spec, points = plan.spec("rows"), plan.datasets["rows"].points
    files.write(path, spec, columns(points) | {"disorder_parameter": np.array([0.1, 0.2])})
    return files.expected(spec)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A whole file and what is expected of it."""
    path = tmp_path_factory.mktemp("made") / "rows.h5"
    return path, write(path)


@pytest.fixture
def copy(made, tmp_path):
    """A file to damage, its bytes, and what is expected of it."""
    whole, expected = made
    path = tmp_path / "rows.h5"
    path.write_bytes(whole.read_bytes())
    return path, whole.read_bytes(), expected


def flip(path, bit):
    content = bytearray(path.read_bytes())
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)


def outcomes(path, bits, expected, whole):
    """What becomes of the file with one of these bits flipped: each outcome and its bits."""
    bits_by_outcome = {}
    with path.open("r+b") as file:
        for bit in bits:
            place, byte = bit // 8, os.pread(file.fileno(), 1, bit // 8)
            os.pwrite(file.fileno(), bytes([byte[0] ^ 1 << bit % 8]), place)
            bits_by_outcome.setdefault(damages.outcome(path, expected, whole), []).append(bit)
            os.pwrite(file.fileno(), byte, place)
    return bits_by_outcome


def killed(*spec):
    faulthandler.disable()  # the traceback of a death that is meant
    return damages.outcome(*spec)


def test_hdf5_looks_no_further_than_its_end(copy):
    path, content, _ = copy
    assert content[8] == 0  # a superblock of version 0, with the end at byte 40
    assert int.from_bytes(content[40:48], "little") == len(content) - seal.LENGTH
    with_trailer = store.read(path)
    path.write_bytes(content[: -seal.LENGTH])
    assert damages.same(store.read(path), with_trailer)


def test_a_file_that_is_opened_for_writing_loses_the_trailer(copy):
    path, content, _ = copy
    with h5py.File(path, "r+"):
        pass
    assert path.read_bytes()[-seal.LENGTH :].find(seal.MARKER) < 0
    seal.put(path)
    assert path.read_bytes() == content


def test_no_flipped_bit_reaches_the_library(made, copy):
    (whole, _), (path, content, expected) = made, copy
    end = 8 * (len(content) - seal.LENGTH)
    heap = 8 * content.index(b"GCOL")
    bits = sorted({*range(0, end, 31), *range(heap, heap + 8 * 4096, 7)})
    outcome = damages.by_itself(outcomes, path, bits, expected, whole)
    assert outcome == {"refused": bits}


def test_a_bit_that_kills_the_library_is_one_line(copy, made):
    path, content, expected = copy
    flip(path, 8 * (content.index(TEXT) + 1) + 1)
    assert damages.by_itself(damages.outcome, path, expected, made[0]) == "refused"
    path.write_bytes(path.read_bytes()[: -seal.LENGTH])
    assert damages.by_itself(killed, path, expected, made[0]) == "crashed"


def test_a_file_without_a_trailer_is_read_and_has_its_own_checksum(copy, made):
    path, content, expected = copy
    path.write_bytes(content[: -seal.LENGTH])
    assert damages.same(files.read(path, expected), store.read(made[0]))
    place = content.index(np.array([0.1, 0.2]).tobytes())
    flip(path, 8 * place)
    with pytest.raises(InputError, match="its content does not have its checksum; to make it"):
        files.read(path, expected)


def test_a_flipped_bit_of_the_trailer_is_refused_or_harmless(copy, made):
    path, content, expected = copy
    first = 8 * (len(content) - seal.LENGTH)
    digits = first + 8 * len(seal.MARKER)
    harmless, refused = range(first, digits, 11), range(digits, 8 * len(content))
    outcome = damages.by_itself(outcomes, path, [*harmless, *refused], expected, made[0])
    assert outcome == {"harmless": [*harmless], "refused": [*refused]}


def test_a_cut_trailer_is_refused_or_harmless(copy, made):
    path, content, expected = copy
    for cut in (1, 20, 63, 64, 65, 70, seal.LENGTH, seal.LENGTH + 1, seal.LENGTH + 8):
        path.write_bytes(content[:-cut])
        outcome = damages.by_itself(damages.outcome, path, expected, made[0])
        harmless = 64 < cut <= seal.LENGTH  # a part of the marker is left
        assert outcome == ("harmless" if harmless else "refused"), cut


@pytest.mark.parametrize("more", [b"\0", b"x" * seal.LENGTH])
def test_bytes_behind_the_trailer_are_refused_or_harmless(copy, made, more):
    path, content, expected = copy
    path.write_bytes(content + more)
    assert damages.outcome(path, expected, made[0]) in ("refused", "harmless")


def readers():
    """What reads a dataset of the workflow, by name: each is given its path and the expectation."""
    return {
        "check": inputs.check,
        "load": lambda path, expected: inputs.load({"rows": path}, {"rows": expected}),
        "list": lambda path, expected: verification.make_list(path.parents[1]),
        "report": lambda path, _: Material("own", {}, {"datasets": [path]}, path).datasets,
    }


@pytest.mark.parametrize("reader", readers())
def test_each_reader_looks_at_the_trailer(tmp_path, reader):
    path = tmp_path / "datasets" / "rows.h5"
    expected = write(path)
    readers()[reader](path, expected)
    flip(path, 8 * path.stat().st_size - 1)  # the content is whole
    with pytest.raises(InputError, match=f"^{re.escape(str(path))}: damaged: its bytes"):
        readers()[reader](path, expected)


def test_nobody_else_opens_a_file_of_the_workflow():
    root = provenance.ROOT
    scripts = root.parents[1] / "workflow"
    texts = {path: path.read_text() for path in [*root.rglob("*.py"), *scripts.rglob("*.py")]}
    reading = [path for path, text in texts.items() if "store.read(" in text]
    assert sorted(path.relative_to(root).as_posix() for path in reading) == [
        "replication/plan/files.py",
        "simulation/results.py",  # results of the user
        "simulation/run_file.py",  # a run of the user
    ]


@pytest.mark.parametrize("place", ["base.store.look_for_room", "base.seal.put"])
def test_a_full_disk_is_one_line_and_harms_nothing(copy, monkeypatch, place):
    path, content, _ = copy

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(f"beltrepro.{place}", fail)
    with pytest.raises(InputError) as caught:
        write(path)
    assert str(caught.value).startswith(f"{path}: cannot be written (No space left on device);")
    assert atomic.UNFINISHED not in str(caught.value)
    assert path.read_bytes() == content and list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize(("name", "words"), [("none.h5", "no such file"), ("", "cannot be read")])
def test_what_cannot_be_read_is_one_line(tmp_path, name, words):
    with pytest.raises(InputError, match=f"{re.escape(str(Path(tmp_path, name)))}: {words}"):
        seal.check(tmp_path / name)
