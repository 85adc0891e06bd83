"""Files: what is written comes back, the same content gives the same bytes, never half a file."""

import ast
import importlib
import inspect
import json
import re
import subprocess
import time
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from beltrepro.base import provenance, store
from beltrepro.base.errors import InputError
from beltrepro.engine import vector
from beltrepro.replication.plan import files, inputs, tables
from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import columns, points_of

ENGINE = Path(vector.__file__).parent
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


def test_unreadable_file_is_one_line(tmp_path):
    text = tmp_path / "text.h5"
    text.write_text("no HDF5")
    for path in (text, tmp_path / "missing.h5", tmp_path):
        with pytest.raises(InputError, match=re.escape(str(path))) as caught:
            store.read(path)
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 200 + len(str(path))


# --- files of datasets ---


def spec_of(batch=None, **changes):
    """What the file of a small scan, or of one of its batches, is told."""
    point = {"kind": "scan", "n_blocks": [2, 5, 7, 9], "belt_velocity": [10, 20]}
    point["points_per_job"] = 3
    defaults = {"duration": 100, "transient": 50}
    presets = {"own": {"defaults": defaults, "datasets": {"rows": point | changes}}}
    config = {"preset": "own", "seed": 3, "datasets": {}, "presets": presets}
    plan = make_plan(config)
    return plan.spec("rows") if batch is None else plan.spec("rows", f"{batch:04d}")


def arrays_of(batch_spec, **more):
    count = batch_spec["points"]["count"]
    recorded = {"disorder_parameter": np.arange(count) / 7, "slip_count": np.ones((count, 10), int)}
    return columns(points_of(batch_spec["points"])) | recorded | more


def written(path, batch):
    files.write(path, spec_of(batch), arrays_of(spec_of(batch)))
    return files.read(path, files.expected(spec_of(batch)))


def test_a_damaged_file_is_one_line_with_the_remedy(tmp_path):
    path = tmp_path / "rows.h5"
    files.write(path, spec_of(0), arrays_of(spec_of(0)))
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(InputError) as caught:
        files.read(path, files.expected(spec_of(0) | {"run": "f06"}))
    message = str(caught.value)
    assert message.startswith(f"{path}: not a readable HDF5 file") and "\n" not in message
    assert message.endswith(f"rm -f {path} && snakemake --cores 2 --config preset=own run=f06")


def test_a_file_says_what_it_holds(tmp_path):
    said = written(tmp_path / "0000.h5", 0).attributes
    words = {"dataset": "rows", "kind": "scan", "preset": "own", "run": "own", "method": "event"}
    assert said.items() >= (words | {"duration": 100.0, "seed": 3}).items()
    assert "n_blocks" not in said and "section_position" not in said
    assert json.loads(said["config"]) == spec_of(0)
    assert said["units"] == "model units" and "numpy" in json.loads(said["library_versions"])
    with h5py.File(tmp_path / "0000.h5") as file:
        for array in file.values():
            assert array.attrs["unit"] and array.attrs["dimensions"] and array.attrs["description"]
        assert file["belt_velocity"].attrs["symbol"] == "u"
        assert file["belt_velocity"].attrs["unit"] == "model velocity (0.0183 m/s)"
    for place in (provenance.ROOT.parents[1], tmp_path):
        assert str(place).encode() not in (tmp_path / "0000.h5").read_bytes()


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"dataset": "columns"}, "holds dataset columns (scan) of preset own, run own"),
        ({"preset": "smoke", "run": "smoke"}, "dataset rows (scan) of preset smoke, run smoke"),
        ({"run": "f06"}, "of preset own, run f06"),
        ({"kind": "escapes"}, "holds dataset rows (escapes)"),
        ({"settings": spec_of()["settings"] | {"duration": 200.0}}, "run own with other settings"),
    ],
)
def test_a_file_of_something_else_is_refused_with_the_remedy(tmp_path, other, words):
    path = tmp_path / "rows.h5"
    values = {} if "kind" in other else {"disorder_parameter": np.ones(4)}
    whole = spec_of() | other
    points = columns(points_of(spec_of(0)["points"]))
    files.write(path, whole, points | {name: array[:3] for name, array in values.items()})
    with pytest.raises(InputError) as caught:
        files.read(path, files.expected(spec_of()))
    message = str(caught.value)
    assert "\n" not in message and words in message
    assert "expected dataset rows (scan) of preset own, run own" in message
    assert message.endswith(f"rm -f {path} && snakemake --cores 2 --config preset=own")


def test_batches_are_joined_in_their_order(tmp_path):
    parts = [written(tmp_path / f"{number}.h5", number) for number in range(3)]  # 3, 3, 2 points
    whole = files.join(parts, KINDS["scan"].arrays)
    assert whole["n_blocks"].tolist() == [2, 2, 5, 5, 7, 7, 9, 9]
    assert whole["belt_velocity"].tolist() == [10, 20] * 4
    np.testing.assert_array_equal(7 * whole["disorder_parameter"], [0, 1, 2, 0, 1, 2, 0, 1])
    assert whole["slip_count"].shape == (8, 10)


def test_joining_counts_points_on_and_fills_up_smaller_chains():
    def part(n_blocks, n_points, n_events):
        events = np.zeros(n_events, [("point", "i4"), ("time", "f8"), ("at", "f8", (n_blocks,))])
        events["point"], events["at"] = np.arange(n_events) % n_points, 1.0
        arrays = {"n_blocks": np.full(n_points, n_blocks), "time": np.arange(3.0), "events": events}
        return store.Dataset(arrays | {"positions": np.ones((n_points, 3, n_blocks))}, {})

    whole = files.join([part(2, 2, 3), part(5, 1, 2)], KINDS["series"].arrays)
    assert whole["time"].tolist() == [0, 1, 2]
    assert whole["positions"].shape == (3, 3, 5)
    assert np.isnan(whole["positions"][:2, :, 2:]).all() and (whole["positions"][2] == 1).all()
    assert whole["events"]["point"].tolist() == [0, 1, 0, 2, 2]
    assert whole["events"]["at"].shape == (5, 5) and np.isnan(whole["events"]["at"][0, 2:]).all()
    late = part(2, 1, 0)
    late.arrays["time"] += 1
    with pytest.raises(InputError, match="differ in time"):
        files.join([part(2, 1, 0), late], KINDS["series"].arrays)


# --- tables ---


def test_a_table_stays_plain_and_has_its_origin_beside_it(tmp_path):
    table = pd.DataFrame({"belt_velocity": [1.5], "runs": [3], "test": ["t"], "r": [1 / 3]})
    path = tmp_path / "deep" / "some.csv"
    sources = {"rows": files.expected(spec_of())}
    tables.write(path, table, title="A table.", columns={"runs": "number"}, sources=sources)
    assert path.read_text() == "belt_velocity,runs,test,r\n1.5,3,t,0.333333\n"
    about = json.loads((tmp_path / "deep" / "some.csv-metadata.json").read_text())
    assert about["@context"] == "http://www.w3.org/ns/csvw" and about["url"] == "some.csv"
    assert about["dc:source"]["rows"]["dataset"] == "rows"
    assert about["beltrepro:origin"] == provenance.origin()
    velocity, runs, test, r = about["tableSchema"]["columns"]
    assert velocity["titles"] == ["belt_velocity", "u"] and "0.0183 m/s" in velocity["unit"]
    assert runs == {"name": "runs", "datatype": "integer", "dc:description": "number"}
    assert (test["datatype"], r["datatype"]) == ("string", "number")


def test_figures_and_tables_read_datasets_and_tables(tmp_path):
    written(tmp_path / "rows.h5", 0)
    tables.write(tmp_path / "t.csv", pd.DataFrame({"a": [1]}), title="T.", columns={}, sources={})
    paths = {"rows": tmp_path / "rows.h5", "t": str(tmp_path / "t.csv")}
    loaded = inputs.load(paths, {"rows": files.expected(spec_of(0))})
    assert loaded["rows"].attributes["dataset"] == "rows" and loaded["t"]["a"].tolist() == [1]
    with pytest.raises(InputError, match="with other settings"):
        inputs.load(paths, {"rows": files.expected(spec_of(1))})


# --- provenance ---


@pytest.fixture
def version_of(tmp_path, monkeypatch):
    """The version that a tree with the package in src/beltrepro has now, and the tree."""
    monkeypatch.setattr(provenance, "ROOT", tmp_path / "src" / "beltrepro")
    monkeypatch.setattr(provenance, "version", lambda package: "1.2")
    provenance.ROOT.mkdir(parents=True)
    (provenance.ROOT / "a.py").write_text("")

    def version():
        provenance.code_version.cache_clear()
        return provenance.code_version()

    yield version
    provenance.code_version.cache_clear()


def git(tree, *arguments):
    names = ["-c", "user.name=a", "-c", "user.email=a@b"]
    words = ["git", "-C", str(tree), *names, *arguments]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def test_code_version_names_the_commit_and_changes_to_it(version_of, tmp_path):
    assert version_of() == "1.2"  # no checkout
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-qm", "first")
    commit = git(tmp_path, "rev-parse", "HEAD")[:12]
    assert version_of() == f"1.2+g{commit}"
    (tmp_path / "notes.txt").write_text("files that git does not follow change nothing")
    assert version_of() == f"1.2+g{commit}"
    (provenance.ROOT / "a.py").write_text("new = 1\n")
    assert version_of() == f"1.2+g{commit}.dirty"
    parts = [provenance.origin() | {"code_version": number} for number in ("1.0", "1.1")]
    assert provenance.of_all([*parts, parts[0]])["code_version"] == "1.0, 1.1"


@pytest.mark.parametrize(
    ("text", "commit"), [(f"node: {'0a' * 20}\n", "0a" * 20), ("node: $Format:%H$\n", ""), ("", "")]
)
def test_an_archive_without_git_names_its_commit(version_of, tmp_path, text, commit):
    (tmp_path / provenance.COMMIT_FILE).write_text(text)
    assert provenance.commit(tmp_path) == commit
    assert version_of() == (f"1.2+g{commit[:12]}" if commit else "1.2")


# What numba compiles, by the decorators of `beltrepro.engine.vector` or by calls of them.
COMPILED = re.compile(r"^@(kernel|allocating_kernel|inlined)$|= inlined\(", re.M)


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
