"""Files appear whole or not at all: kills, failures and a full disk."""

import os
import subprocess
import sys

import pytest

from beltrepro.base import atomic
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError

LIMITED = """
import resource, sys
import numpy as np
from beltrepro.base import store
from beltrepro.base.errors import InputError

resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
try:
    store.write(sys.argv[1], {"values": np.random.default_rng(1).random(100_000)}, {})
except InputError as error:
    sys.exit(f"error: {error}")
"""


def test_a_file_appears_when_it_is_complete(tmp_path):
    path = tmp_path / "new" / "a.txt"
    with replacing(path) as unfinished:
        unfinished.write_text("all of it")
        assert not path.exists()
        assert unfinished.suffix == path.suffix
    assert path.read_text() == "all of it"
    assert list(path.parent.iterdir()) == [path]


def test_a_file_is_on_the_disk_before_it_has_its_name_and_then_its_name_is(tmp_path, monkeypatch):
    path, flushed = tmp_path / "a.txt", []

    def fsync(descriptor):
        flushed.append((os.fstat(descriptor).st_ino, path.exists()))

    monkeypatch.setattr(os, "fsync", fsync)
    with replacing(path) as unfinished:
        unfinished.write_text("all of it")
    assert flushed == [(path.stat().st_ino, False), (tmp_path.stat().st_ino, True)]


def test_a_failure_leaves_the_earlier_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("before")
    with pytest.raises(ZeroDivisionError), replacing(path) as unfinished:
        unfinished.write_text("half")
        1 / 0  # noqa: B018
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", [".", "file/a.h5", f"{'x' * 300}.h5"])
def test_a_place_where_no_file_can_be_is_one_line(tmp_path, name):
    (tmp_path / "file").write_text("whole")
    refused = pytest.raises(InputError, match=r": cannot be written \([A-Z][a-z ]+\)$")
    with refused as caught, replacing(tmp_path / name):
        raise AssertionError("begun")
    assert str(caught.value).startswith(f"{tmp_path / name}: ")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert not list(tmp_path.parent.glob(f"{atomic.UNFINISHED}*"))


def killed_at_work_on(path):
    kill = (
        "import os, sys; from beltrepro.base.atomic import replacing\n"
        "with replacing(sys.argv[1]) as part: part.write_text('half'); os.kill(os.getpid(), 9)"
    )
    subprocess.run([sys.executable, "-c", kill, str(path)], check=False)


def test_what_a_kill_leaves_is_cleared(tmp_path):
    folder = tmp_path / "datasets"
    killed_at_work_on(folder / "a.h5")
    assert len(list(folder.iterdir())) == 1
    (folder / "b.h5").write_text("whole")
    atomic.clear(tmp_path)
    assert [path.name for path in folder.iterdir()] == ["b.h5"]


@pytest.mark.thorough
def test_a_full_disk_is_one_line_and_harms_nothing(tmp_path):
    path = tmp_path / "a.h5"
    path.write_text("before")
    words = [sys.executable, "-c", LIMITED, str(path)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"error: {path}: cannot be written (File too large); earlier results")
    assert path.read_text() == "before"
    assert not list(tmp_path.glob(".*"))
