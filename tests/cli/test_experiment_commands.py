"""The commands film, track and analyse: a way from a chain to r, and errors in one line."""

import json

import numpy as np
import pytest

from beltrepro.cli import app as cli
from beltrepro.replication.camera.track import Track

HEADER = "time_s,x_m\n"


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
    known = (f"--scale={filmed['scale']}", f"--zero={filmed['zero']}")
    tracked = json.loads(run(capsys, "track", movie, *known, "--output", table, "--json"))
    assert (tracked["frames"], tracked["lost_s"]) == (filmed["frames"], [])
    track = Track.load(table)
    assert len(track.time_s) == tracked["frames"]
    assert tracked["seconds"] == pytest.approx(np.ptp(track.time_s))
    assert abs(tracked["angle"]) < 0.1
    printed = json.loads(run(capsys, "analyse", table, "--output", picture, "--json"))
    assert printed["disorder_parameter"] == pytest.approx(filmed["disorder_parameter"], rel=0.01)
    assert printed["mean_length_model"] == pytest.approx(printed["mean_length"] / 1.4e-3)
    assert picture.read_bytes().startswith(b"\x89PNG")


ROWS = "".join(f"{row / 24},{0.8 + 0.01 * (row % 9)}\n" for row in range(60))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--transient=-1"], "transient"),
        (["--transient=500"], "0 samples"),
        (["--window=0"], "window"),
        (["--window=0.1"], "window = 0.1: it must hold 3 samples or more"),
        (["--quiet=nan"], "quiet"),
        (["--block-length=-1"], "block_length = -1"),
        (
            ["--block-length=0.2"],
            "0.8 m: it must be measured from the support, and hold the 0.9 m of",
        ),
        (["--n-blocks=0"], "n_blocks = 0"),
        (["--output=figure.mp3"], "must end in .png"),
    ],
)
def test_wrong_options_of_analyse_are_refused_in_a_line(tmp_path, capsys, options, words):
    (tmp_path / "a.csv").write_text(HEADER + ROWS)
    assert words in run(capsys, "analyse", tmp_path / "a.csv", *options, status=2)


def test_analyse_says_whether_blocks_are_in_x(tmp_path, capsys):
    (tmp_path / "a.csv").write_text(HEADER + ROWS)
    plain, of_springs = (
        json.loads(run(capsys, "analyse", tmp_path / "a.csv", "--json", *options))
        for options in ((), ["--block-length=0.1"])
    )
    assert [shown["blocks_m"] for shown in (plain, of_springs)] == [0, 0.45]
    assert of_springs["mean_length"] == pytest.approx(plain["mean_length"] - 0.45)
    assert "--block-length takes them off" in run(capsys, "analyse", tmp_path / "a.csv")


FILM = ("film", "--output=a.mp4")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("film", "--output=a.txt"), "must end in"),
        (("film", "--output=no/such/folder/a.mp4"), "folder"),
        ((*FILM, "--duration=nan"), "duration"),
        ((*FILM, "--width=33"), "width = 33: must be an even number"),
        ((*FILM, "--metres-per-pixel=1e-5"), "take a larger"),
        ((*FILM, "--transient=50"), "transient = 50"),
    ],
)
def test_films_that_are_not_made(tmp_path, capsys, monkeypatch, options, words):
    monkeypatch.chdir(tmp_path)
    chain = ["--n-blocks=2", "--belt-velocity=15", "--duration=5"]
    assert words in run(capsys, options[0], *chain, *options[1:], status=2)
    assert not list(tmp_path.iterdir())
