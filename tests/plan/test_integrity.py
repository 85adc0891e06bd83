"""Damaged files are named and never used; results are compared with a list.

`test_workflow.py` damages every file of a smoke run.
"""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import damages
import small_plans
from beltrepro.base import seal, store
from beltrepro.base.errors import InputError
from beltrepro.cli import app as cli
from beltrepro.extras import verification
from beltrepro.extras.verification import NEAR, SAME, WRONG
from beltrepro.replication.drawing import style
from beltrepro.replication.plan import files, inputs, manifest, tables
from beltrepro.replication.plan.points import columns

OTHER = {"processor": "another processor"}


def plan(preset="own", **changes):
    rows = {"n_blocks": [2, 5], "belt_velocity": [5, 10, 15, 20], "noise": 1}
    rows |= {"replicate": {"count": 8}, "duration": 2000} | changes
    return small_plans.planned(name="rows", preset=preset, **rows)


def arrays_of(points, noise=0.0, seed=1):
    """Arrays of a scan: r of the points, about the same for any seed and to the share of noise."""
    random = np.random.default_rng(seed).standard_normal(len(points))
    regular = np.linspace(0.1, 0.3, len(points))
    return columns(points) | {"disorder_parameter": regular * (1 + noise * random)}


def write(path, made, **arrays):
    spec = made.spec("rows")
    points = made.datasets["rows"].points
    files.write(path, spec, arrays_of(points, **arrays))
    return files.expected(spec)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two datasets, tables and figures each, all of them whole, and what is expected of them."""
    made = tmp_path_factory.mktemp("made")
    expected = {"rows.h5": write(made / "rows.h5", plan())}
    write(made / "zz.h5", plan(), noise=0.1)
    about = {"preset": "own", "run": "own", "sources": {"rows": expected["rows.h5"]}}
    expected |= {"some.csv": about, "fig12.png": about}
    for number, name in enumerate(("some", "zz")):
        frame = pd.DataFrame({"n": [1, 2, number]})
        tables.write(made / f"{name}.csv", frame, title="T.", columns={}, sources=about["sources"])
    for number, name in enumerate(("fig12", "zz")):
        figure = style.page(3)
        figure.add_subplot().plot([0, number + 1])
        source = inputs.source(about)
        style.save(figure, made / f"{name}.png", made / f"{name}.pdf", source)
    return made, expected


def damaged(folder, name, damage, place):
    """Outcome of the damage of one file."""
    made, expected = folder
    whole, other = made / name, made / f"zz{name[name.index('.') :]}"
    place.mkdir(exist_ok=True)
    path = place / name
    shutil.copy(whole, path)
    if path.suffix == ".csv":
        shutil.copy(seal.metadata_path(whole), seal.metadata_path(path))
    inputs.check(path, expected[name])
    damage(path, other)
    return damages.outcome(path, expected[name], whole)


WHOLE_FILES = [
    damages.truncated,
    damages.without_end,
    damages.empty,
    damages.missing,
    damages.swapped,
    damages.of_older_version,
]


@pytest.mark.parametrize("damage", WHOLE_FILES, ids=lambda damage: damage.__name__)
@pytest.mark.parametrize("name", ["rows.h5", "some.csv", "fig12.png"])
def test_a_damaged_file_is_refused_with_the_remedy(folder, tmp_path, name, damage):
    if name == "rows.h5" and damage is damages.swapped:
        pytest.skip("two files of one dataset hold what was asked for")
    assert damaged(folder, name, damage, tmp_path / "copy") == "refused"


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["rows.h5", "some.csv", "fig12.png"])
def test_a_flipped_bit_is_refused_unless_it_means_nothing(folder, tmp_path, name):
    result = [
        damaged(folder, name, damages.flipped(place), tmp_path / "copy")
        for place in np.random.default_rng(2).random(60)
    ]
    assert set(result) <= {"refused", "harmless"}
    assert result.count("refused") > 50


@pytest.mark.parametrize("other", [plan("other"), plan(duration=3000)], ids=["preset", "version"])
def test_a_file_of_another_preset_or_version_is_refused(folder, tmp_path, other):
    made, expected = folder
    path = tmp_path / "rows.h5"
    sources = {"rows": write(path, other)}
    with pytest.raises(InputError, match=r"holds dataset rows \(scan\).*to make it again: rm "):
        inputs.check(path, expected["rows.h5"])
    about = expected["some.csv"] | {"sources": sources}
    with pytest.raises(InputError, match=r"was made from other datasets; to make it again"):
        inputs.check(made / "some.csv", about)
    with pytest.raises(InputError, match="another figure, fig12 of own, own, "):
        inputs.check(made / "fig12.png", about)


@pytest.mark.parametrize("part", ["disorder_parameter", "duration"])
def test_a_changed_number_is_refused_even_if_the_file_is_sound(folder, tmp_path, part):
    import h5py

    made, expected = folder
    path = tmp_path / "rows.h5"
    shutil.copy(made / "rows.h5", path)
    with h5py.File(path, "r+") as file:
        if part in file:
            file[part][3] += 1e-15
        else:
            file.attrs[part] = np.nextafter(file.attrs[part], 0.0)
    with pytest.raises(InputError, match="does not have its checksum"):
        inputs.check(path, expected["rows.h5"])


def test_a_file_of_a_user_may_lack_a_checksum(tmp_path):
    import h5py

    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["x"] = np.arange(3)
    assert store.read(tmp_path / "a.h5").arrays["x"].tolist() == [0, 1, 2]
    with pytest.raises(InputError, match="it has no checksum"):
        store.read(tmp_path / "a.h5", strict=True)


# --- files of all kinds, by the list of the run ---


@pytest.mark.parametrize(
    "name",
    ["rows.h5", "some.csv", "some.csv-metadata.json", "fig12.png", "fig12.pdf", "report.html"],
)
def test_what_the_run_did_not_write_is_refused_in_a_line(folder, tmp_path, name):
    made = Path(shutil.copytree(folder[0], tmp_path / "made"))
    (made / "report.html").write_text("<p>\n1 to 3</p>\n" * 9)
    manifest.add(made, made.iterdir())
    copy = Path(shutil.copytree(made, tmp_path / "copy"))
    outcomes = dict(damages.damage_in_run(made, name, copy))
    assert set(outcomes.values()) == {"refused", "harmless"}, outcomes
    assert len(outcomes) >= 12


def test_without_the_list_a_file_must_have_a_seal_of_its_own(folder, tmp_path):
    made = Path(shutil.copytree(folder[0], tmp_path / "made"))
    (made / "report.html").write_text("<p>")
    sealed = [path.name for path in made.iterdir() if path.name != "report.html"]
    manifest.check(made, sealed)
    with pytest.raises(InputError, match=r"report\.html: has no checksum: an older version"):
        manifest.check(made, ["report.html"])
    for name in sealed:
        if name.endswith(".json"):  # the seal there is that of the file beside it
            continue
        damages.by_hand(made / name, made)
        with pytest.raises(InputError, match=f"{name}: damaged"):
            manifest.check(made, [name])


def test_a_damaged_list_certifies_nothing_and_is_repaired_by_the_remedy(folder, tmp_path):
    made = Path(shutil.copytree(folder[0], tmp_path / "made"))
    manifest.add(made, made.iterdir())
    whole = (made / manifest.NAME).read_bytes()
    for place in range(0, len(whole), 7):
        (made / manifest.NAME).write_bytes(whole[:place] + b"\xff" + whole[place + 1 :])
        (made / "fig12.png").write_bytes(b"another")
        with pytest.raises(InputError, match="fig12"):
            manifest.check(made, ["fig12.png"])
        manifest.add(made, [made / "fig12.png"])  # as the job that makes it again
        manifest.check(made, ["fig12.png"])


# --- the list ---


@pytest.fixture
def results(tmp_path):
    """A folder of results, its list, and a function that compares it."""
    folder = tmp_path / "results" / "own"
    write(folder / "datasets" / "rows.h5", plan())
    tables.write(
        folder / "tables" / "t.csv", pd.DataFrame({"n": [1]}), title="T.", columns={}, sources={}
    )
    verification.write_list(tmp_path / "own.json", folder)
    listed = verification.read_list(tmp_path / "own.json")

    def compare(**machine):
        comparisons = verification.compare(
            folder, listed | {"machine": listed["machine"] | machine}
        )
        return {one.name: one for one in comparisons}

    return folder, compare


def test_the_same_results_have_the_same_bits(results):
    _, compare = results
    for machine in ({}, OTHER):
        assert {one.outcome for one in compare(**machine).values()} == {SAME}


@pytest.mark.parametrize(
    ("noise", "machine", "outcome"),
    [(1e-15, {}, WRONG), (1e-15, OTHER, NEAR), (0.01, OTHER, NEAR), (30.0, OTHER, WRONG)],
)
def test_other_numbers_are_wrong_here_and_bounded_elsewhere(results, noise, machine, outcome):
    folder, compare = results
    write(folder / "datasets" / "rows.h5", plan(), noise=noise)
    comparisons = compare(**machine)["rows"]
    assert comparisons.outcome == outcome
    if outcome == WRONG:
        assert "disorder_parameter" in comparisons.words and "rm " in comparisons.words


def test_short_runs_agree_closely_elsewhere(tmp_path):
    folder, short = tmp_path / "own", plan(duration=100)
    write(folder / "datasets" / "rows.h5", short)
    listed = verification.make_list(folder)
    listed["machine"] |= OTHER
    for noise, outcome in ((1e-9, NEAR), (1e-3, WRONG)):
        write(folder / "datasets" / "rows.h5", short, noise=noise)
        assert [one.outcome for one in verification.compare(folder, listed)] == [outcome]


def test_columns_of_quantities_agree_everywhere(results):
    folder, compare = results
    spec = plan().spec("rows")
    arrays = arrays_of(plan().datasets["rows"].points)
    arrays["belt_velocity"] = np.nextafter(arrays["belt_velocity"], 100.0)
    files.write(folder / "datasets" / "rows.h5", spec, arrays)
    assert "belt_velocity has other bits" in compare(**OTHER)["rows"].words


def test_missing_and_damaged_results_are_named(results):
    folder, compare = results
    (folder / "datasets" / "rows.h5").unlink()
    table = folder / "tables" / "t.csv"
    table.write_text("n\n2\n")
    comparisons = compare()
    assert "no such file" in comparisons["rows"].words
    assert "its bytes do not have their checksum" in comparisons["t"].words
    for one in comparisons.values():
        assert one.outcome == WRONG and "snakemake --cores 2 --config preset=own" in one.words


def test_the_command_says_what_it_found(results, tmp_path, capsys):
    folder, _ = results
    spec = ["verify", str(folder), "--list", str(tmp_path / "own.json")]
    assert cli.main(spec) == 0
    assert capsys.readouterr().out == "2 the same bits\nequal: every bit of the list\n"
    write(folder / "datasets" / "rows.h5", plan(), noise=0.1)
    assert cli.main(spec) == 1
    shown = capsys.readouterr()
    assert shown.out == "1 wrong, 1 the same bits\ndifferent: see the lines above\n"
    assert shown.err.startswith(f"error: {folder / 'datasets' / 'rows.h5'}: disorder_parameter has")
    assert cli.main([*spec, "--write"]) == 0 and cli.main(spec) == 0


def claims(folder, **verdicts):
    """A table of claims with both verdicts of each."""
    frame = pd.DataFrame(
        [(name, *pair) for name, pair in verdicts.items()], columns=["id", "replicated", "robust"]
    )
    tables.write(folder / "claims.csv", frame, title="T.", columns={}, sources={})


def test_a_difference_matters_if_a_verdict_differs(results):
    folder, _ = results
    claims(folder, a=("yes", "yes"), b=("yes", "in part"))
    listed = verification.make_list(folder)
    listed["machine"] |= OTHER
    write(folder / "datasets" / "rows.h5", plan(), noise=0.01)
    result = list(verification.compare(folder, listed))
    assert {one.outcome for one in result} == {SAME, NEAR}
    assert verification.conclusion(result).startswith("equal within the bounds")
    claims(folder, a=("yes", "yes"), b=("yes", "no"))
    wrong = [one for one in verification.compare(folder, listed) if one.outcome == WRONG]
    assert [one.words for one in wrong] == [
        "claim b: yes and no here, yes and in part in the list; this matters"
    ]
    assert verification.conclusion(wrong).startswith("different")


def test_missing_and_damaged_tables_are_named(results):
    folder, compare = results
    (folder / "claims.csv").write_bytes(b"")
    assert "claims.csv: not a table of comma-sep" in compare()["claims"].words
    with pytest.raises(InputError, match=r"claims\.csv: has no checksum"):
        verification.make_list(folder)
    (folder / "tables" / "t.csv").unlink()
    assert compare()["t"].words.endswith("table t is missing")
    (folder / "tables" / "t.csv").mkdir()
    assert "t.csv: cannot be read (Is a directory); to make" in compare()["t"].words


EMPTY_ENTRY = '{"preset": "a", "run": "a", "machine": {}, "tables": {}, "datasets": {"a": {}}}'


@pytest.mark.parametrize("content", [None, "", "{", "{}", "[]", EMPTY_ENTRY])
def test_an_unreadable_list_is_one_line(tmp_path, content, capsys):
    if content is not None:
        (tmp_path / "l.json").write_text(content)
    assert cli.main(["verify", str(tmp_path), "--list", str(tmp_path / "l.json")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
