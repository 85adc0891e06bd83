"""The commands film, track and analyse: a way from a chain to r, and errors in one line."""

import json

import numpy as np
import pytest

from beltrepro.cli import app as cli
from beltrepro.replication.camera.camera import film
from beltrepro.replication.camera.track_file import Track
from filming import swaying

HEADER = "time_s,x_m,error_m\n"


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    """A film of three seconds."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    film(swaying(3.0), path)
    return path


def run(capsys, *words, status=0):
    """What the command wrote to stdout, or its one line of error."""
    try:
        ended = cli.main([str(word) for word in words])
    except SystemExit as stop:  # argparse
        ended = stop.code
    out, err = capsys.readouterr()
    assert ended == status, err
    assert not status or (not out and err.startswith("error: ") and err.count("\n") == 1)
    return err if status else out


def test_a_chain_is_filmed_tracked_and_analysed(tmp_path, capsys):
    movie, table, picture = (tmp_path / name for name in ("a.mp4", "a.csv", "a.png"))
    chain = ("--n-blocks=2", "--belt-velocity=15", "--duration=160", "--transient=60")
    filmed = json.loads(run(capsys, "film", *chain, "--output", movie, "--dropped=0.02", "--json"))
    assert filmed["seconds"] == pytest.approx(100 * 0.0765, abs=0.1)
    tracked = json.loads(run(capsys, "track", movie, "--output", table, "--json"))
    assert (tracked["frames"], tracked["lost_s"]) == (filmed["frames"], [])
    track = Track.load(table)
    assert len(track.time_s) == tracked["frames"]
    assert tracked["seconds"] == pytest.approx(np.ptp(track.time_s))
    assert tracked["error_m"] == pytest.approx(np.sqrt(np.mean(track.error_m**2)))
    assert tracked["metres_per_pixel"] == pytest.approx(track.metres_per_pixel)
    assert abs(tracked["tilt"]) < 0.5 and 0 < tracked["misfit_of_marks_m"] < 5e-4
    printed = json.loads(run(capsys, "analyse", table, "--output", picture, "--json"))
    assert printed["disorder_parameter"] == pytest.approx(filmed["disorder_parameter"], rel=0.01)
    assert printed["mean_length_model"] == pytest.approx(printed["mean_length"] / 1.4e-3)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_tables_for_people(video, tmp_path, capsys):
    out = run(capsys, "track", video, "--output", tmp_path / "a.csv")
    assert "metres_per_pixel" in out and out.splitlines()[-1].split() == ["lost_s", "none"]
    assert "disorder_parameter" in run(capsys, "analyse", tmp_path / "a.csv")


ROWS = "".join(f"{row / 24},{0.8 + 0.01 * (row % 9)},1e-4\n" for row in range(60))


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
    assert np.array_equal([other.time_s, other.x_m], [plain.time_s, plain.x_m])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--transient=-1"], "transient"),
        (["--transient=500"], "0 samples"),
        (["--window=0"], "window"),
        (["--window=0.1"], "window = 0.1: it must hold 3 samples or more"),
        (["--quiet=nan"], "quiet"),
        (["--block-length=-1"], "block_length = -1"),
        (["--block-length=0.2"], "0.8 m: less than the 0.9 m of blocks in it"),
        (["--n-blocks=0"], "n_blocks = 0"),
        (["--output=figure.mp3"], "must end in .png"),
    ],
)
def test_wrong_options_of_analyse_are_refused_in_a_line(tmp_path, capsys, options, words):
    (tmp_path / "a.csv").write_text(HEADER + ROWS)
    assert words in run(capsys, "analyse", tmp_path / "a.csv", *options, status=2)


def test_each_option_of_analyse_changes_what_is_printed(tmp_path, capsys):
    time = np.arange(2400) / 24
    place = 0.9 + np.where(time < 60, 0.1, 0.01) * np.sin(3 * time) * (1 + 0.3 * np.sin(0.4 * time))
    rows = "".join(f"{t},{x}\n" for t, x in zip(time, place, strict=True))
    (tmp_path / "a.csv").write_text("time_s,x_m\n" + rows)
    outputs = {
        run(capsys, "analyse", tmp_path / "a.csv", "--json", *option)
        for option in (
            [],
            ["--transient=20"],
            ["--window=2"],
            ["--quiet=0.09"],
            ["--block-length=0.04"],
            ["--block-length=0.04", "--n-blocks=4"],
        )
    }
    assert len(outputs) == 6 and "" not in outputs


def test_analyse_says_what_its_intervals_hold(tmp_path, capsys):
    """Errors that a track tells widen them; what is not known, and blocks in x_N, are said."""
    (tmp_path / "a.csv").write_text(HEADER + ROWS)
    (tmp_path / "b.csv").write_text(
        '# {"scale_error": 0.03, "zero_error_m": 0.2}\n' + HEADER + ROWS
    )
    plain, wide, of_springs = (
        json.loads(run(capsys, "analyse", tmp_path / name, "--json", *options))
        for name, options in (("a.csv", ()), ("b.csv", ()), ("b.csv", ["--block-length=0.1"]))
    )
    for name in ("disorder_parameter", "mean_length"):
        assert plain[name] == wide[name]
        reach = [shown[f"{name}_high"] - shown[f"{name}_low"] for shown in (plain, wide)]
        assert reach[0] < 0.5 * wide[name] < reach[1]
    common = ("scale_error", "zero_error_m", "blocks_m")
    assert [plain[name] for name in common] == [None, None, 0]
    assert [of_springs[name] for name in common] == [0.03, 0.2, 0.45]
    assert of_springs["mean_length"] == pytest.approx(plain["mean_length"] - 0.45)
    said = run(capsys, "analyse", tmp_path / "a.csv")
    assert said.count("not known, and not in the intervals") == 2
    assert "--block-length takes them off" in said
    said = run(capsys, "analyse", tmp_path / "b.csv", "--block-length=0.1")
    assert "not known" not in said and "takes them off" not in said
