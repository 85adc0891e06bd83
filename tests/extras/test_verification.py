"""Results compared with a list: bits here, bounds on another machine."""

import shutil

import numpy as np
import pandas as pd
import pytest

import small_plans
from beltrepro.base import seal, store
from beltrepro.base.errors import InputError
from beltrepro.cli import app as cli
from beltrepro.extras import verification
from beltrepro.extras.verification import MISSING, NEAR, SAME, WRONG
from beltrepro.replication.plan import io
from beltrepro.replication.plan.points import columns

OTHER = {"processor": "another processor"}


def plan(preset="own", **changes):
    rows = {"n_blocks": [2, 5], "belt_velocity": [5, 10, 15, 20], "noise": 1}
    rows |= {"replicate": {"count": 8}, "duration": 2000} | changes
    return small_plans.planned(name="rows", preset=preset, **rows)


def write(folder, made, noise=0.0, **others):
    """A scan: r of the points, to the share of noise, and other arrays."""
    points = made.datasets["rows"].points
    random = np.random.default_rng(1).standard_normal(len(points))
    disorder = np.linspace(0.1, 0.3, len(points)) * (1 + noise * random)
    arrays = columns(points) | {"disorder_parameter": disorder} | others
    io.write(folder / "datasets" / "rows.h5", made.spec("rows"), arrays)


def write_table(path, **columns):
    io.write_table(path, pd.DataFrame(columns), title="T.", columns={}, sources={})


@pytest.fixture
def compared(tmp_path):
    """A folder of results, and a function that compares it with the list of what it was first."""
    folder = tmp_path / "results" / "own"
    write_table(folder / "tables" / "t.csv", n=[1])
    write_table(folder / "claims.csv", id=["a", "b"], replicated=["yes"] * 2, robust=["yes", "no"])

    def compare(made=None, **machine):
        if made or not (tmp_path / "own.json").exists():
            write(folder, made or plan())
            verification.write_list(tmp_path / "own.json", folder)
        listed = verification.read_list(tmp_path / "own.json")
        listed.machine |= machine
        return {file.name: file for file in verification.compare(folder, listed)}

    compare()
    return folder, compare


def test_the_same_results_have_the_same_bits(compared):
    _, compare = compared
    for machine in ({}, OTHER):
        assert {file.outcome for file in compare(**machine).values()} == {SAME}


@pytest.mark.parametrize(
    ("duration", "noise", "machine", "outcome"),
    [
        (2000, 1e-15, {}, WRONG),
        (2000, 1e-15, OTHER, NEAR),
        (2000, 0.01, OTHER, NEAR),
        (2000, 30.0, OTHER, WRONG),
        (100, 1e-9, OTHER, NEAR),  # short runs agree closely
        (100, 1e-3, OTHER, WRONG),
    ],
)
def test_other_numbers_are_wrong_here_and_bounded_elsewhere(
    compared, duration, noise, machine, outcome
):
    folder, compare = compared
    compare(plan(duration=duration))
    write(folder, plan(duration=duration), noise)
    comparison = compare(**machine)["rows"]
    assert comparison.outcome == outcome
    if outcome == WRONG:
        assert "rows.h5: disorder_parameter " in comparison.words
        assert comparison.words.endswith(": delete it and make it again")


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("mean_length", "f8"),
        ("section_count", "i4"),
        ("laminar_count", "u2"),
        ("last_stick_time", "?"),
    ],
)
def test_numbers_of_each_type_are_bounded_elsewhere(compared, tmp_path, name, kind):
    folder, compare = compared
    most = np.arange(len(plan().datasets["rows"].points)) % 8 > 0
    write(folder, plan(), **{name: most.astype(kind)})
    verification.write_list(tmp_path / "own.json", folder)
    for other, outcome in ((most[::-1], NEAR), (~most, WRONG)):
        write(folder, plan(), **{name: other.astype(kind)})
        assert compare(**OTHER)["rows"].outcome == outcome


def test_what_points_are_and_what_they_were_told_agrees_everywhere(compared):
    folder, compare = compared
    velocity = columns(plan().datasets["rows"].points)["belt_velocity"]
    write(folder, plan(), belt_velocity=np.nextafter(velocity, 100.0))
    assert "belt_velocity has other bits" in compare(**OTHER)["rows"].words
    for other in (plan("other"), plan(duration=2001)):
        write(folder, other)
        assert "rows.h5: holds another dataset" in compare(**OTHER)["rows"].words


def test_tables_differ_rightly_where_any_dataset_is_of_another_machine(compared, tmp_path):
    folder, compare = compared
    early = folder / "datasets" / "early.h5"
    shutil.copy(folder / "datasets" / "rows.h5", early)
    verification.write_list(tmp_path / "own.json", folder)
    data = store.read(early)
    store.write(early, data.arrays, data.attributes | OTHER)
    write_table(folder / "tables" / "t.csv", n=[2])
    assert compare()["t"].outcome == NEAR


@pytest.mark.parametrize(
    "name",
    [f"figures/a.{ending}" for ending in ("png", "pdf")]
    + [f"experiment/a.{ending}" for ending in ("mp4", "csv", "h5")]
    + ["report.html", "claims.csv", "estimates.csv", "tables/a.csv"],
)
def test_a_damaged_file_of_any_kind_is_named(compared, tmp_path, name):
    folder, compare = compared
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    if name.endswith(".h5"):
        store.write(path, {"n": np.ones(1)}, {})
    elif name in ("estimates.csv", "tables/a.csv"):
        write_table(path, n=[1])
    elif not path.exists():
        path.write_bytes(b"as long as the words it has")
        seal.put(path)
    verification.write_list(tmp_path / "own.json", folder)
    assert {file.outcome for file in compare().values()} == {SAME}
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    (wrong,) = (file for file in compare().values() if file.outcome == WRONG)
    assert str(path) in wrong.words and "damaged" in wrong.words


def test_missing_and_damaged_files_are_named(compared, tmp_path):
    folder, compare = compared
    (folder / "figures").mkdir()
    (folder / "figures" / "fig01.png").write_bytes(b"no seal")
    assert "fig01.png: has no seal" in compare()["fig01.png"].words
    (folder / "datasets" / "rows.h5").unlink()
    assert compare()["rows"] == ("rows", MISSING, "")
    with pytest.raises(InputError, match="no datasets there"):
        verification.write_list(folder / "l.json", folder)
    store.write(folder / "datasets" / "mine.h5", {}, {"kind": "run"})
    with pytest.raises(InputError, match="a dataset without 'preset': not of the workflow"):
        verification.write_list(folder / "l.json", folder)
    for path in (folder / "tables" / "t.csv", folder / "claims.csv"):
        path.write_text(path.read_text().replace("\n", "\n\n", 1))
        assert f"{path}: damaged: its bytes" in compare()[path.stem].words
    (folder / "tables" / "t.csv").write_text("n\n1\n")
    assert "t.csv: has no seal" in compare()["t"].words
    (folder / "tables" / "t.csv").unlink()
    assert compare()["t"] == ("t", MISSING, "")
    write_table(folder / "tables" / "t.csv", n=[2])
    assert compare(**OTHER)["t"].outcome == WRONG  # the dataset is missing, so nothing tells where


def test_a_difference_matters_if_a_verdict_differs(compared):
    folder, compare = compared
    write(folder, plan(), 0.01)
    comparisons = list(compare(**OTHER).values())
    assert {file.outcome for file in comparisons} == {SAME, NEAR}
    write_table(folder / "claims.csv", id=["a", "b"], replicated=["yes"] * 2, robust=["yes"] * 2)
    (wrong,) = (file for file in compare(**OTHER).values() if file.outcome == WRONG)
    assert wrong.words == "claim b: yes and yes here, yes and no in the list; this matters"


def test_a_claim_that_is_missing_is_a_verdict_that_differs(compared):
    folder, compare = compared
    write_table(folder / "claims.csv", id=["b", "c"], replicated=["yes"] * 2, robust=["no"] * 2)
    assert compare(**OTHER)["a"].words.startswith("claim a: missing here, yes and yes in the list")


def test_the_command_says_what_it_found(compared, tmp_path, capsys):
    folder, _ = compared
    words = ["verify", str(folder), "--list", str(tmp_path / "own.json")]
    assert cli.main(words) == 0
    assert capsys.readouterr().out == "3 the same bits\nequal: every bit of the list\n"
    write(folder, plan(), 0.1)
    assert cli.main(words) == 1
    shown = capsys.readouterr()
    assert shown.out == "1 wrong, 2 the same bits\ndifferent: see the lines above\n"
    assert shown.err.startswith(f"error: {folder / 'datasets' / 'rows.h5'}: disorder_parameter has")
    assert cli.main([*words, "--write"]) == 0 and cli.main(words) == 0
    capsys.readouterr()
    for name in ("tables/t.csv", "claims.csv"):
        (folder / name).unlink()
    assert cli.main(words) == 1
    shown = ["not made: claims, t", "1 the same bits, 2 not made", "so far right: 1 of 3 are made"]
    assert capsys.readouterr() == ("\n".join([*shown, ""]), "")
    (folder / "datasets/rows.h5").unlink()
    assert cli.main(words) == 2 and "nothing of what" in capsys.readouterr().err


EMPTY_ENTRY = '{"preset": "a", "run": "a", "machine": {}, "tables": {}, "datasets": {"a": {}}}'


@pytest.mark.parametrize("content", ["", "{}", EMPTY_ENTRY])
def test_an_unreadable_list_is_one_line(tmp_path, content):
    path = tmp_path / "l.json"
    with pytest.raises(InputError, match="no such file"):
        verification.read_list(path)
    path.write_text(content)
    with pytest.raises(InputError, match="not a list of results"):
        verification.read_list(path)


@pytest.mark.parametrize("share", [-1.2, -0.8, 0.8, 1.2])
@pytest.mark.parametrize(
    ("duration", "bound"),
    [(500.0, 1e-6 * (3.0 + 0.5)), (501.0, 6 * 0.5 * np.sqrt(2 / 8) + 1e-6 * 3.0)],
)
def test_means_agree_up_to_the_bound(duration, bound, share):
    listed, here = [40, -3.0, 0.5], [40, -3.0 + share * bound, 0.7]
    assert verification._apart(here, listed, duration, 8) == (abs(share) > 1)


@pytest.mark.parametrize(
    ("size", "duration", "apart"),
    [(800, 500, False), (799, 500, True), (530, 501, False), (0, 501, True)],
)
def test_lost_values_are_told(size, duration, apart):
    listed = [800, 0.0, 0.5]
    assert verification._apart([size, 0.0, 0.5], listed, duration, 8) == apart


def test_summaries_are_of_finite_values_and_of_each_field():
    values = np.array([1.0, np.nan, 4.0, np.inf, 4.0])
    assert verification._summaries(values) == {"": [3, 3.0, np.sqrt(2).round(8)]}
    records = np.array([(1, 2.0, "a"), (5, 4.0, "b")], [("n", int), ("x", float), ("s", "U1")])
    assert verification._summaries(records) == {"n": [2, 3.0, 2.0], "x": [2, 3.0, 1.0]}
    assert verification._summaries(np.array([np.nan])) == {"": [0, 0.0, 0.0]}
