"""Scans over grids: every combination, the numbers of `scan`, tables and files; the command."""

import itertools
import json

import numpy as np
import pandas as pd
import pytest

from beltrepro import ChainParameters, scan, scan_grid
from beltrepro.base import store
from beltrepro.base.errors import InputError
from beltrepro.cli import app as cli

SHORT = {"duration": 60.0, "transient": 20.0}
AXES = {"n_blocks": [3, 2], "belt_velocity": [5.0, 20.0], "friction_ratio": [0.45, 0.6]}
WORDS = ["--n-blocks=2,3", "--belt-velocity=5:20:15", "--duration=60", "--transient=20"]


@pytest.fixture(scope="module")
def found():
    return scan_grid(**AXES, noise=1.0, replicates=2, seed=4, **SHORT)


def test_points_are_all_combinations_and_the_numbers_those_of_scan(found):
    points = list(itertools.product(*AXES.values(), range(2)))
    arrays = found.arrays
    names = (*AXES, "replicate")
    assert list(zip(*(arrays[name].tolist() for name in names), strict=True)) == points
    chains = [ChainParameters(n, u, 1.0, friction_ratio=ratio) for n, u, ratio, _ in points]
    replicates = [replicate for *_, replicate in points]
    direct = scan(chains, replicate=replicates, seed=4, method="event", initial_spread=1.0, **SHORT)
    for name in ("disorder_parameter", "mean_length", "slip_count", "section_count"):
        assert np.array_equal(arrays[name], direct[name], equal_nan=True)
    assert len(np.unique(arrays["disorder_parameter"])) == len(points)
    assert found.axes == ["n_blocks", "belt_velocity", "friction_ratio", "replicate"]


def test_single_values_make_one_point():
    one = scan_grid(n_blocks=2, belt_velocity=5, **SHORT)
    assert len(one.table()) == 1 and one.axes == []
    assert repr(one) == "GridScan(1 points of one chain)"


def test_table_and_files_hold_the_same(found, tmp_path):
    table = found.table()
    assert len(table) == 16 and "slip_count" not in table
    assert set(table["static_friction"]) == {71.4}
    found.save(tmp_path / "scan.csv")
    pd.testing.assert_frame_equal(pd.read_csv(tmp_path / "scan.csv"), table, check_dtype=False)
    found.save(tmp_path / "scan.h5")
    data = store.read(tmp_path / "scan.h5")
    for name, values in found.arrays.items():
        assert np.array_equal(data.arrays[name], values, equal_nan=True)
    assert data.attributes["duration"] == 60.0 and data.attributes["seed"] == 4
    assert "code_version" in data.attributes and "tolerance" not in data.attributes


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"n_blocks": []}, "n_blocks is empty"),
        ({"n_blocks": 11}, "at most 10 blocks"),
        ({"replicates": 0}, "replicates: makes 0 points, allowed are 1 to 1000000"),
        ({"noise": np.linspace(0, 1, 1001), "replicates": 1000}, "noise: makes 1001000 points"),
        ({"method": ["event", "verlet"]}, "one value is needed, for all points"),
    ],
)
def test_a_grid_that_cannot_be_is_one_line(changes, words):
    with pytest.raises(InputError, match=words):
        scan_grid(**{"n_blocks": 2, "belt_velocity": 5.0} | SHORT | changes)


def test_progress_ends_at_one():
    told = []
    scan_grid(n_blocks=2, belt_velocity=[5.0, 6.0], **SHORT, progress=told.append)
    assert told == sorted(told) and told[-1] == pytest.approx(1.0)


def test_the_command_takes_lists_and_ranges(capsys, tmp_path):
    more = ["--friction-ratio=0.45,0.6", "--noise=1", "--replicates=2", "--seed=4"]
    assert cli.main(["scan", *WORDS, *more, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    direct = scan_grid(**AXES | {"n_blocks": [2, 3]}, noise=1.0, replicates=2, seed=4, **SHORT)
    values = [row["disorder_parameter"] for row in rows]
    assert values == pytest.approx(direct.arrays["disorder_parameter"].tolist(), rel=1e-12)
    assert [row["belt_velocity"] for row in rows[:8]] == [5.0] * 4 + [20.0] * 4
    path = tmp_path / "scan.csv"
    assert cli.main(["scan", *WORDS, f"--output={path}"]) == 0
    assert len(pd.read_csv(path)) == 4
    assert capsys.readouterr().out == f"{path}: 4 points\n"
    assert cli.main(["scan", *WORDS]) == 0
    heading = capsys.readouterr().out.splitlines()[0].split()
    assert heading[:3] == ["n_blocks", "belt_velocity", "disorder_parameter"]


def test_a_range_has_both_ends(capsys):
    words = ["--n-blocks=1", "--belt-velocity=1:2:0.2,5", "--duration=5", "--json"]
    assert cli.main(["scan", *words]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["belt_velocity"] for row in rows] == [1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 5.0]


def test_the_command_refuses_endings_and_files_that_are_there(capsys, tmp_path):
    (tmp_path / "scan.h5").write_text("mine")
    for name, words in (("scan.xlsx", "must end in .csv, .h5"), ("scan.h5", "is there already")):
        assert cli.main(["scan", *WORDS, f"--output={tmp_path / name}"]) == 2
        assert words in capsys.readouterr().err
    assert (tmp_path / "scan.h5").read_text() == "mine"
    assert cli.main(["scan", *WORDS, f"--output={tmp_path / 'scan.h5'}", "--force"]) == 0
    assert len(store.read(tmp_path / "scan.h5").arrays["noise"]) == 4
