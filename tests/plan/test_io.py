"""Files of results: what they say of themselves, batches that are joined, inputs of jobs."""

import json

import h5py
import numpy as np
import pandas as pd
import pytest

import small_plans
from beltrepro import ChainParameters
from beltrepro.base import provenance, seal, store
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import io
from beltrepro.replication.plan.points import columns
from beltrepro.simulation.run import EVENT

ABOUT = {"title": "A table.", "columns": {"runs": "number of them"}}


def plan(**changes):
    """Eight points, in batches of three, three and two."""
    points = {"n_blocks": [2, 5, 7, 9], "belt_velocity": [10, 20], "points_per_job": 3}
    return small_plans.planned(name="rows", **points | changes)


def write(path, planned, batch="0000", **settings):
    points, spec = columns(planned.datasets["rows"].batches[batch]), planned.spec("rows", batch)
    spec["settings"] = spec["settings"] | settings
    count, longest = len(points["n_blocks"]), max(points["n_blocks"])
    recorded = {"disorder_parameter": np.arange(count) / 7}
    recorded["slip_count"] = np.ones((count, longest), int)
    io.write(path, spec, points | recorded)
    return store.read(path)


# --- datasets ---


def test_a_file_says_what_it_holds_and_what_made_it(tmp_path):
    path = tmp_path / "0000.h5"
    said = write(path, plan()).attributes
    words = {"dataset": "rows", "kind": "scan", "preset": "own", "run": "own", "method": "event"}
    assert said.items() >= (words | {"duration": 100.0, "seed": 3}).items()
    assert "n_blocks" not in said and "section_position" not in said
    assert json.loads(said["config"]) == plan().spec("rows", "0000")
    assert said["units"] == "model units" and "numpy" in json.loads(said["library_versions"])
    with h5py.File(path) as file:
        for array in file.values():
            assert array.attrs["unit"] and array.attrs["dimensions"] and array.attrs["description"]
        assert file["belt_velocity"].attrs["symbol"] == "u"
        assert file["belt_velocity"].attrs["unit"] == "model velocity (0.0183 m/s)"
    for place in (provenance.ROOT.parents[1], tmp_path):
        assert str(place).encode() not in path.read_bytes()
    assert write(path, plan(), duration=101.0).attributes["digest"] != said["digest"]


def test_batches_are_joined_in_their_order(tmp_path):
    names = plan().datasets["rows"].batches
    parts = [write(tmp_path / f"{name}.h5", plan(), name) for name in names]
    whole = io.join(parts, "scan")
    assert whole["n_blocks"].tolist() == [2, 2, 5, 5, 7, 7, 9, 9]
    assert whole["belt_velocity"].tolist() == [10, 20] * 4
    np.testing.assert_array_equal(7 * whole["disorder_parameter"], [0, 1, 2, 0, 1, 2, 0, 1])
    assert whole["slip_count"].dtype == int
    assert whole["slip_count"].sum(axis=1).tolist() == [5] * 3 + [7] * 3 + [9] * 2


def test_constants_beyond_the_paper_are_columns_where_they_are_not_its_own(tmp_path):
    planned = plan(n_blocks=[2, 3], belt_velocity=10, viscosity=[0, 0.1], mass=2, points_per_job=1)
    names = planned.datasets["rows"].batches
    parts = [write(tmp_path / f"{name}.h5", planned, name) for name in names]
    whole = io.join(parts, "scan")
    assert whole["viscosity"].tolist() == [0, 0.1] * 2 and whole["mass"].tolist() == [2] * 4
    assert "weakening_velocity" not in whole and "viscosity" not in parts[0].arrays
    assert planned.spec("rows")["points"]["viscosity"] == [0, 0.1]
    assert io.chain(parts[1]) == ChainParameters(2, 10.0, viscosity=0.1, mass=2)
    assert not {"mass", "viscosity"} & {*write(tmp_path / "a.h5", plan()).arrays}
    assert not {"mass", "viscosity"} & {*plan().spec("rows")["points"], *plan().settings()["model"]}


def test_joining_counts_points_on_and_fills_up_smaller_chains():
    def part(n_blocks, n_points, n_events):
        events = np.zeros(n_events, [("point", "i4"), ("time", "f8"), ("at", "f8", (n_blocks,))])
        events["point"], events["at"] = np.arange(n_events) % n_points, 1.0
        arrays = {"n_blocks": np.full(n_points, n_blocks), "time": np.arange(3.0), "events": events}
        return store.Dataset(arrays | {"positions": np.ones((n_points, 3, n_blocks))}, {})

    whole = io.join([part(2, 2, 3), part(5, 1, 2)], "series")
    assert whole["time"].tolist() == [0, 1, 2]
    assert whole["positions"].shape == (3, 3, 5)
    assert np.isnan(whole["positions"][:2, :, 2:]).all() and (whole["positions"][2] == 1).all()
    assert whole["events"]["point"].tolist() == [0, 1, 0, 2, 2]
    assert whole["events"].dtype["point"] == "i4"
    assert whole["events"]["at"].shape == (5, 5) and np.isnan(whole["events"]["at"][0, 2:]).all()
    late = part(2, 1, 0)
    late.arrays["time"] += 1
    with pytest.raises(InputError, match="differ in time"):
        io.join([part(2, 1, 0), late], "series")


# --- tables, and what jobs read ---


def test_a_table_says_in_its_first_line_what_it_is(tmp_path):
    table = pd.DataFrame({"belt_velocity": [1.5], "runs": [3], "test": ["# t"], "r": [1 / 3]})
    path, sources = tmp_path / "deep" / "some.csv", {"rows": {"digest": "a"}}
    io.write_table(path, table, sources=sources, **ABOUT)
    assert io.rows(path) == "belt_velocity,runs,test,r\n1.5,3,# t,0.333333\n"
    said = io.said(path)
    assert said["title"] == "A table." and said["sources"] == sources
    assert said.items() >= provenance.origin().items()
    assert "0.0183 m/s" in said["columns"].pop("belt_velocity")
    assert said["columns"] == {"runs": "number of them"}
    assert io.read_table(path).to_dict("list") == {
        "belt_velocity": [1.5], "runs": [3], "test": ["# t"], "r": [0.333333]
    }  # fmt: skip
    plain = pd.read_csv(path, comment="#")
    assert list(plain) == list(table) and len(plain) == 1


def test_a_damaged_table_is_refused_and_one_of_version_1_0_is_read(tmp_path):
    path = tmp_path / "t.csv"
    io.write_table(path, pd.DataFrame({"a": [1, 2]}), sources={}, **ABOUT)
    whole = path.read_bytes()
    for damaged in (whole.replace(b"1", b"3"), whole[: seal.check(path)], b"", b"\xff\xfe"):
        path.write_bytes(damaged)
        with pytest.raises(InputError, match=r"t\.csv: ") as caught:
            io.read_table(path)
        assert "\n" not in str(caught.value)
    path.write_text("a,b\nx,1,2\ny,3,4\n")  # pandas would take the first for names
    with pytest.raises(InputError, match=r"t.csv: its rows have more cells than its first line"):
        io.read_as_text(path)
    path.write_text("a\n1\n")
    assert io.read_as_text(path) == [{"a": "1"}] and io.said(path) == {}


def test_jobs_read_datasets_and_tables_and_what_is_behind_them(tmp_path):
    written = write(tmp_path / "rows.h5", plan(points_per_job=99))
    for name, sources in (("first", {"u1": {}, "u2": {}}), ("last", {"u3": {}})):
        io.write_table(tmp_path / f"{name}.csv", pd.DataFrame({"a": [1]}), sources=sources, **ABOUT)
    paths = {name: str(tmp_path / name) for name in ("first.csv", "rows.h5", "last.csv")}
    data, sources = io.load(paths)
    assert data["rows.h5"].attributes == written.attributes
    assert data["last.csv"]["a"].tolist() == [1]
    assert list(sources) == ["rows.h5", "u1", "u2", "u3"]
    assert sources["rows.h5"] == {
        name: written.attributes[name] for name in ("preset", "run", "digest", "code_version")
    }


@pytest.mark.parametrize("velocities", [[10], [10, 20]])
def test_a_series_of_one_point_is_read_as_that_run(tmp_path, velocities):
    made, count = small_plans.planned("series", belt_velocity=velocities), len(velocities)
    points, several = columns(made.datasets["one"].points), count > 1
    points |= {"time": np.arange(5.0), "positions": np.ones((count, 5, 2))}
    events = np.zeros(4, [("point", "i4"), *EVENT.descr])
    points |= {"mean_length": np.ones(count), "events": events}
    io.write(tmp_path / "one.h5", made.spec("one"), points)
    read = io.load({"one": str(tmp_path / "one.h5")})[0]["one"].arrays
    shapes = {name: read[name].shape for name in ("time", "n_blocks", "positions", "mean_length")}
    first = (count,) * several
    assert [*shapes.values()] == [(5,), first, (*first, 5, 2), first]
    assert read["events"].dtype.names == events.dtype.names[not several :]
