"""`beltrepro scan`: the numbers of `scan` over a grid that lists and ranges say."""

import json

import pandas as pd
import pytest

from beltrepro import Grid, scan
from beltrepro.base import store
from beltrepro.cli import app as cli

WORDS = ["--n-blocks=2,3", "--belt-velocity=5:20:15", "--duration=60", "--transient=20"]


def test_the_command_takes_lists_and_ranges(capsys, tmp_path):
    more = ["--friction-ratio=0.45,0.6", "--noise=1", "--replicates=2", "--seed=4"]
    assert cli.main(["scan", *WORDS, *more, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    grid = Grid([2, 3], [5.0, 20.0], 1.0, friction_ratio=[0.45, 0.6], replicates=2)
    direct = scan(grid, seed=4, duration=60.0, transient=20.0)
    values = [row["disorder_parameter"] for row in rows]
    assert values == pytest.approx(direct["disorder_parameter"].tolist(), rel=1e-12)
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
