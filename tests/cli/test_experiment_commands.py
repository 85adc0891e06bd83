"""The commands film, track and analyse: a way from a chain to r, and errors in one line."""

import json

import pytest

from beltrepro.cli import app as cli
from beltrepro.replication.camera.camera import film
from beltrepro.replication.camera.tracking import Track
from filming import swaying

HEADER = "time_s,x_m,error_m\n"


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    """A film of three seconds."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    film(swaying(3.0), path)
    return path


def run(capsys, *words):
    """Exit status, and what the command wrote to stdout and stderr."""
    try:
        status = cli.main([str(word) for word in words])
    except SystemExit as stop:  # argparse
        status = stop.code
    return (status, *capsys.readouterr())


@pytest.mark.thorough
def test_a_chain_is_filmed_tracked_and_analysed(tmp_path, capsys):
    movie, table, picture = (tmp_path / name for name in ("a.mp4", "a.csv", "a.png"))
    chain = ("--n-blocks=2", "--belt-velocity=15", "--duration=160", "--transient=60")
    status, out, err = run(capsys, "film", *chain, "--output", movie, "--dropped=0.02", "--json")
    assert status == 0, err
    filmed = json.loads(out)
    assert filmed["seconds"] == pytest.approx(100 * 0.0765, abs=0.1)

    status, out, err = run(capsys, "track", movie, "--output", table, "--json")
    assert status == 0, err
    found = json.loads(out)
    assert found["frames"] == filmed["frames"]
    assert found["lost_s"] == []
    assert len(Track.load(table).time_s) == found["frames"]

    status, out, err = run(capsys, "analyse", table, "--output", picture, "--json")
    assert status == 0, err
    told = json.loads(out)
    assert told["disorder_parameter"] == pytest.approx(filmed["disorder_parameter"], rel=0.01)
    assert told["mean_length_model"] == pytest.approx(told["mean_length"] / 1.4e-3)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_tables_for_people(video, tmp_path, capsys):
    status, out, _ = run(capsys, "track", video, "--output", tmp_path / "a.csv")
    assert status == 0
    assert "metres_per_pixel" in out
    assert out.splitlines()[-1].split() == ["lost_s", "none"]
    status, out, _ = run(capsys, "analyse", tmp_path / "a.csv")
    assert status == 0
    assert "disorder_parameter" in out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--scale=0"], "metres_per_pixel = 0: must be greater"),
        (["--scale=-1"], "metres_per_pixel = -1"),
        (["--scale=nan"], "finite"),
        (["--scale=50"], "from 1e-06 to 0.1"),
        (["--scale=0.05"], "no white block found"),
        (["--support=top"], "left, right"),
        (["--block-length=0"], "block_length = 0"),
        (["--mark-spacing=nan"], "mark_spacing"),
        (["--first-mark=inf"], "first_mark"),
        (["--first-mark=10"], "first_mark = 10: must be from -5 to 5, in metres"),
        (["--output=/no/such/folder/a.csv"], "folder does not exist"),
    ],
)
def test_wrong_options_of_track_are_refused_in_a_line(video, tmp_path, capsys, options, words):
    output = [] if "--output" in options[0] else [f"--output={tmp_path / 'a.csv'}"]
    status, out, err = run(capsys, "track", video, *options, *output)
    assert (status, out) == (2, "")
    assert words in err
    assert err.startswith("error: ") and err.count("\n") == 1
    assert not (tmp_path / "a.csv").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--output=a.txt"], "must end in"),
        (["--frames-per-second=0"], "frames_per_second = 0"),
        (["--width=33"], "even"),
        (["--metres-per-pixel=1e-5"], "take a larger"),
        (["--transient=50"], "transient"),
    ],
)
def test_wrong_options_of_film_are_refused_in_a_line(tmp_path, capsys, options, words):
    chain = ["--n-blocks=2", "--belt-velocity=15", "--duration=10"]
    output = [] if "--output" in options[0] else [f"--output={tmp_path / 'a.mp4'}"]
    status, out, err = run(capsys, "film", *chain, *output, *options)
    assert (status, out) == (2, "")
    assert words in err
    assert err.startswith("error: ") and err.count("\n") == 1
    assert not list(tmp_path.iterdir())


ROWS = "".join(f"{each / 24},{0.8 + 0.01 * (each % 9)},1e-4\n" for each in range(60))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "No such file"),
        ("", "lacks the column time_s, x_m"),
        ("no table at all", "lacks the column"),
        ("time_s,error_m\n0,1\n", "lacks the column x_m"),
        (HEADER, "has no rows"),
        (HEADER + "0,0.5,1e-4\n1,0.6,1e-4\n", "2 samples"),
        (HEADER + ROWS + "9,nan,1\n", "x_m in row 61 is not a finite number"),
        (HEADER + ROWS + "inf,0.9,1\n", "time_s in row 61"),
        (HEADER + ROWS + "9,,1\n", "'' is not a number"),
        (HEADER + ROWS + "9,fast,1\n", "'fast' is not a number"),
        (HEADER + ROWS + "9,0.9\n", "row 61 has 2 values, 3 are needed"),
        (HEADER + ROWS + "1,0.9,1\n", "row 61 is not later"),
        (HEADER + ROWS.replace(",0.8", ",-0.8"), "measured from the support"),
        (bytes(range(256)), "not a text file"),
        ("time_s,x_m\n\0\0\0", "not a number|values"),
        ("t;x\n0;1\n", "lacks the column time_s, x_m; its first line is 't;x'"),
        ("time_s,x_m,x_m\n0,1,2\n", "2 columns x_m"),
        (HEADER + ROWS + '9,"0,9",1e-4\n', "x_m: '0,9' is not a number"),
        (HEADER + ROWS + "1e9,0.9,1e-4\n", "row 61 is 1e+09 s later than in the row before"),
        ((HEADER + "größe\n").encode("latin-1"), "not a text file in UTF-8"),
    ],
)
def test_a_wrong_table_is_refused_in_a_line(tmp_path, capsys, text, words):
    path = tmp_path / "a.csv"
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    status, out, err = run(capsys, "analyse", path)
    assert (status, out) == (2, "")
    assert any(word in err for word in words.split("|")), err
    assert err.startswith("error: ") and err.count("\n") == 1


def german(text):
    """As a spreadsheet with decimal commas writes it."""
    return "\ufeff" + text.replace(",", ";").replace(".", ",").replace("\n", "\r\n")


@pytest.mark.parametrize(
    "text",
    [
        german(HEADER + ROWS),
        (HEADER + ROWS).replace(",", ";"),
        (HEADER + ROWS).replace(",", "\t"),
        (HEADER + ROWS).replace("time_s,x_m", "Time_s, X_m"),
        HEADER + ROWS.replace("1e-4", "") + ",,\n,,\n",
        (HEADER + ROWS).replace("error_m", "note").replace("1e-4", "a hand"),
        '"# {""angle"": 0,7";""\n' + german(HEADER + ROWS)[1:],
    ],
    ids=["German", "semicolons", "tabs", "capitals", "no errors", "words", "quoted remark"],
)
def test_a_table_of_a_spreadsheet_is_read(tmp_path, text):
    (tmp_path / "plain.csv").write_text(HEADER + ROWS)
    (tmp_path / "other.csv").write_text(text, newline="")
    plain, other = Track.load(tmp_path / "plain.csv"), Track.load(tmp_path / "other.csv")
    assert (other.time_s.tolist(), other.x_m.tolist()) == (
        plain.time_s.tolist(),
        plain.x_m.tolist(),
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--transient=-1"], "transient"),
        (["--transient=500"], "0 samples"),
        (["--window=0"], "window"),
        (["--window=0.1"], "window = 0.1: it must hold 3 samples or more"),
        (["--quiet=nan"], "quiet"),
        (["--output=figure.mp3"], "must end in .png"),
        (["--output=/no/such/folder/a.png"], "folder does not exist"),
    ],
)
def test_wrong_options_of_analyse_are_refused_in_a_line(tmp_path, capsys, options, words):
    (tmp_path / "a.csv").write_text(HEADER + ROWS)
    status, out, err = run(capsys, "analyse", tmp_path / "a.csv", *options)
    assert (status, out) == (2, "")
    assert words in err
    assert err.startswith("error: ") and err.count("\n") == 1


def test_a_folder_for_a_table(tmp_path, capsys):
    status, _, err = run(capsys, "analyse", tmp_path)
    assert status == 2
    assert err.count("\n") == 1
