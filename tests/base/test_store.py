"""What is written comes back, and the same content gives the same bytes; provenance."""

import ast
import importlib
import inspect
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from beltrepro.base import provenance, store
from beltrepro.engine import vector

ENGINE = Path(vector.__file__).parent
ROOT = Path(__file__).parents[2]
EVENT = np.dtype([("time", "f8"), ("block", "i8"), ("kind", "U5"), ("place", "f8", (3,))])
EVENTS = np.array([(0.5, 1, "slip", (1, 2, 3)), (0.7, 5, "stick", (4, 5, 6))], dtype=EVENT)
ARRAYS = {
    "velocity": np.array([[1.5, np.nan], [0.0, -2.0]], dtype="f4"),
    "count": np.arange(3),
    "long": np.linspace(0, 1, 40_000),
    "escaped": np.array([True, False]),
    "events": EVENTS,
    "empty": np.empty((0, 4)),
}
ATTRIBUTES = {"kind": "series", "n_blocks": 5, "noise": 2.2, "units": "model units"}


def test_what_is_written_comes_back_and_the_same_content_has_the_same_bytes(tmp_path):
    path, other = tmp_path / "deep" / "er" / "data.h5", tmp_path / "other.h5"
    store.write(path, ARRAYS, ATTRIBUTES)
    time.sleep(1 - time.time() % 1)  # HDF5 counts times in seconds
    store.write(other, dict(reversed(ARRAYS.items())), dict(reversed(ATTRIBUTES.items())))
    assert path.read_bytes() == other.read_bytes()
    dataset = store.read(path)
    assert dataset.attributes == ATTRIBUTES
    assert {type(value) for value in dataset.attributes.values()} == {str, int, float}
    assert set(dataset.arrays) == set(ARRAYS)
    for name, array in ARRAYS.items():
        assert dataset.arrays[name].dtype == array.dtype
        np.testing.assert_array_equal(dataset.arrays[name], array)


def test_checksums_tell_type_shape_and_bits_apart():
    array = np.zeros((2, 4))
    others = [array.astype("i8"), array.astype("f4"), array.reshape(4, 2), -array, EVENTS]
    checksums = {store.checksum(one) for one in [array, *others]}
    assert len(checksums) == 6 and store.checksum(array.T.copy().T) in checksums


@pytest.fixture
def version_of(tmp_path, monkeypatch):
    """The version that a tree with the package in src/beltrepro has now, and the tree."""
    monkeypatch.setattr(provenance, "ROOT", tmp_path / "src" / "beltrepro")
    monkeypatch.setattr(provenance, "VERSION", "1.2")
    provenance.ROOT.mkdir(parents=True)
    (provenance.ROOT / "a.py").write_text("")

    def version():
        provenance._noted.cache_clear()
        return provenance.code_version()

    yield version
    provenance._noted.cache_clear()


def git(tree, *arguments):
    names = ["-c", "user.name=a", "-c", "user.email=a@b"]
    words = ["git", "-C", str(tree), *names, *arguments]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def test_code_version_names_the_commit_and_changes_to_it(version_of, tmp_path):
    assert version_of() == "1.2"  # no checkout
    git(tmp_path, "init", "-q")
    git(tmp_path, "commit", "-q", "--allow-empty", "-m", "of another project")
    assert version_of() == "1.2"
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "first")
    commit = git(tmp_path, "rev-parse", "HEAD")[:12]
    assert version_of() == f"1.2+g{commit}"
    (tmp_path / "notes.txt").write_text("files that git does not follow change nothing")
    assert version_of() == f"1.2+g{commit}"
    (tmp_path / ".git" / "info" / "exclude").write_text("b.py")
    (provenance.ROOT / "b.py").write_text("new = 1\n")
    assert version_of() == f"1.2+g{commit}.dirty"
    (provenance.ROOT / "b.py").rename(provenance.ROOT / "a.py")
    assert version_of() == f"1.2+g{commit}.dirty"
    git(tmp_path, "update-index", "--assume-unchanged", "src/beltrepro/a.py")
    assert version_of() == f"1.2+g{commit}.dirty"
    parts = [provenance.origin() | {"code_version": number} for number in ("1.0", "1.1")]
    assert provenance.of_all([*parts, parts[0]])["code_version"] == "1.0; 1.1"


def test_code_that_git_is_told_to_see_otherwise_is_dirty(version_of, tmp_path):
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "first")
    clean, first = version_of(), git(tmp_path, "rev-parse", "HEAD")
    (provenance.ROOT / "a.py").write_text("a = 2\n")
    git(tmp_path, "commit", "-qam", "second")
    assert version_of() != clean and not version_of().endswith(".dirty")
    second = git(tmp_path, "rev-parse", "HEAD")
    git(tmp_path, "reset", "-q", "--hard", first)
    git(tmp_path, "replace", first, second)
    git(tmp_path, "reset", "-q", "--hard")
    assert (provenance.ROOT / "a.py").read_text() == "a = 2\n"
    assert version_of() == f"{clean}.dirty"
    git(tmp_path, "replace", "-d", first)
    git(tmp_path, "reset", "-q", "--hard")
    assert version_of() == clean
    (tmp_path / ".git" / "info" / "attributes").write_text("*.py filter=empty")
    git(tmp_path, "config", "filter.empty.clean", "true")
    (provenance.ROOT / "a.py").write_text("a = 2\n")
    git(tmp_path, "add", ".")
    assert not git(tmp_path, "status", "--short")
    assert version_of() == f"{clean}.dirty"


def test_code_behind_links_is_that_where_they_lead(version_of, tmp_path):
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / "beltrepro").symlink_to(ROOT / "src" / "beltrepro")
    asked = "from beltrepro.base.provenance import ROOT; print(ROOT)"
    about = {"env": os.environ | {"PYTHONPATH": str(tmp_path / "linked")}, "text": True}
    root = subprocess.check_output([sys.executable, "-c", asked], **about).strip()
    assert Path(root) == (ROOT / "src" / "beltrepro").resolve()
    (tmp_path / "elsewhere.py").write_text("")
    (provenance.ROOT / "linked.py").symlink_to(tmp_path / "elsewhere.py")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "first")
    assert version_of().endswith(".dirty")


@pytest.mark.parametrize("late", ["late", "part"])
def test_code_that_is_loaded_after_it_was_edited_is_dirty(version_of, tmp_path, monkeypatch, late):
    files = {"early": "early.py", "late": "late.py", "part": "part/__init__.py"}
    for name in files.values():
        (provenance.ROOT / name).parent.mkdir(exist_ok=True)
        (provenance.ROOT / name).write_text("")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "first")
    monkeypatch.setitem(sys.modules, "beltrepro.early", None)
    first = version_of()
    monkeypatch.setitem(sys.modules, "beltrepro.a", None)  # later, and not edited
    assert provenance.code_version() == first
    for name in ("a.py", *files.values()):
        (provenance.ROOT / name).write_text("new = 1\n")
    git(tmp_path, "commit", "-qam", "second")
    assert provenance.code_version() == first  # what was loaded is of the first
    monkeypatch.setitem(sys.modules, f"beltrepro.{late}", None)
    for _ in range(2):
        assert provenance.code_version() == f"{first}.dirty"
    (provenance.ROOT / "late.py").write_text("new = 2\n")
    monkeypatch.delitem(sys.modules, f"beltrepro.{late}")
    second = version_of()
    assert second != first and second.endswith(".dirty")
    (provenance.ROOT / files[late]).unlink()
    monkeypatch.setitem(sys.modules, f"beltrepro.{late}", None)
    assert provenance.code_version() == second


def test_the_commit_is_that_of_the_tree_whoever_asks_and_owns_it(version_of, tmp_path, monkeypatch):
    for tree, text in ((tmp_path, "ours"), (tmp_path / "other", "another")):
        git(tmp_path, "init", "-q", str(tree))
        git(tree, "add", ".")
        git(tree, "commit", "-q", "--allow-empty", "-m", text)
    (tmp_path / ".git" / "info" / "exclude").write_text("*")
    commit = git(tmp_path, "rev-parse", "HEAD")[:12]
    for name, folder in (("DIR", ".git"), ("WORK_TREE", "."), ("INDEX_FILE", ".git/index")):
        monkeypatch.setenv(f"GIT_{name}", str(tmp_path / "other" / folder))  # as in a hook
    assert version_of() == f"1.2+g{commit}"
    if os.geteuid() == 0:
        for path in (tmp_path, tmp_path / ".git"):
            os.chown(path, 12345, 12345)
        assert version_of() == f"1.2+g{commit}"


def test_an_archive_without_git_names_its_commit_and_changes_to_it(
    version_of, tmp_path, monkeypatch
):
    sources, archive = tmp_path / "sources", tmp_path / "unpacked" / "archive"
    git(tmp_path, "init", "-q", str(sources))
    for name in (".gitattributes", ".gitignore", provenance.COMMIT_FILE):
        shutil.copy(ROOT / name, sources)
    for name in (
        "src/beltrepro/a.py",
        "src/beltrepro/b.py",
        "workflow/\u00e9.smk",
        "results/README.md",
    ):
        (sources / name).parent.mkdir(parents=True, exist_ok=True)
        (sources / name).write_text("a = 1\n")
    git(sources, "add", ".")
    git(sources, "commit", "-qm", "first")
    git(sources, "archive", "-o", str(tmp_path / "first.zip"), "HEAD")
    commit = f"1.2+g{git(sources, 'rev-parse', 'HEAD')[:12]}"
    code = archive / "src" / "beltrepro"
    monkeypatch.setattr(provenance, "ROOT", code)

    def unpacked():
        shutil.rmtree(archive.parent, ignore_errors=True)
        shutil.unpack_archive(tmp_path / "first.zip", archive)
        return version_of()

    assert unpacked() == commit
    for made in ("src/beltrepro/__pycache__/a.pyc", "results/smoke/a.h5", ".venv/a.py"):
        (archive / made).parent.mkdir(parents=True, exist_ok=True)
        (archive / made).write_text("")
    assert version_of() == commit
    with monkeypatch.context() as inherited:
        inherited.setenv("GIT_DIR", str(sources / ".git"))
        inherited.setenv("XDG_CONFIG_HOME", str(tmp_path))
        (tmp_path / "git").mkdir()
        (tmp_path / "git" / "ignore").write_text("*.smk")  # what a user never wants to see
        assert version_of() == commit
        inherited.setenv("PATH", str(tmp_path))
        assert version_of() == f"{commit}.unverified"
    for change in (
        lambda: (code / "a.py").write_text("a = 2\n"),
        lambda: (code / "a.py").unlink(),
        lambda: (code / os.fsdecode(b"\xff.py")).write_text(""),
        lambda: (code / "b.py").rename(code / "c.py"),
    ):
        assert unpacked() == commit
        change()
        assert version_of() == f"{commit}.dirty"
        shutil.copytree(archive, archive.parent / "copy")  # with times of today
        monkeypatch.setattr(provenance, "ROOT", archive.parent / "copy" / "src" / "beltrepro")
        assert version_of() == f"{commit}.dirty"
        monkeypatch.setattr(provenance, "ROOT", code)
    (archive / provenance.COMMIT_FILE).write_text("node: $Format:%H$\ntree: $Format:%T$\n")
    assert version_of() == "1.2"  # files of a checkout without its .git


# What numba compiles, by the decorators of `beltrepro.engine.vector` or by calls of them.
COMPILED = re.compile(r"^@(kernel|inlined)$|= inlined\(", re.M)


def outside_sources():
    """Files outside the engine whose functions and constants its kernels are made of.

    A class of Python cannot be in a kernel; what else a module with kernels imports may be.
    """
    result = set()
    for path in ENGINE.glob("*.py"):
        text = path.read_text()
        if not COMPILED.search(text):
            continue
        for node in ast.walk(ast.parse(text)):
            origin = getattr(node, "module", None) or ""
            if not origin.startswith("beltrepro.") or origin.startswith("beltrepro.engine"):
                continue
            module = importlib.import_module(origin)
            if any(not inspect.isclass(getattr(module, alias.name)) for alias in node.names):
                result.add(Path(module.__file__))
    return result


def test_compiled_kernels_are_keyed_by_all_sources_they_are_made_of(monkeypatch):
    contents = {path: path.read_bytes() for path in {*ENGINE.glob("*.py"), *outside_sources()}}
    assert {path.name for path in outside_sources()} == {"friction.py"}
    changed = None
    monkeypatch.setattr(
        Path, "read_bytes", lambda path: contents[path] + (b"#" if path == changed else b"")
    )
    version = vector._engine_version.__wrapped__
    usual = version()
    for changed in contents:
        assert version() != usual, changed


def test_a_checksum_tells_names_and_types_of_fields_apart():
    rows = np.array([(0.5, 1.0), (0.7, 2.0)], [("time", "f8"), ("place", "f8")])
    others = [("place", "f8"), ("time", "f8")], [("time", "f8"), ("place", "i8")]
    assert len({store.checksum(same) for same in (rows, *map(rows.view, others))}) == 3
