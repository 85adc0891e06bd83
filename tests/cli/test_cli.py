"""The command `beltrepro`: results as JSON or file, and errors in one line."""

import io
import json
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import beltrepro
from beltrepro import ChainParameters, Grid, Run, classify, scan, simulate
from beltrepro.base import store
from beltrepro.cli import app as cli
from beltrepro.replication.camera.track import Track
from beltrepro.simulation import picture

CHAIN = {"n_blocks": 3, "belt_velocity": 20, "noise": 1, "duration": 30, "transient": 10}
ORBIT = {"n_blocks": 2, "belt_velocity": 5, "duration": 2000, "transient": 1000}


@pytest.fixture
def command(capsys):
    """Runs a command; returns what it wrote to stdout, as values if asked, and to stderr."""

    def run(action, *words, status=0, **options):
        flags = [f"--{name.replace('_', '-')}={value}" for name, value in options.items()]
        assert cli.main([action, *map(str, words), *flags]) == status
        out, err = capsys.readouterr()
        return (json.loads(out) if "--json" in words else out), err

    return run


def test_json_is_what_simulate_returns(command):
    law = {"static_friction": 80.0, "friction_ratio": 0.3, "rest_length": 40.0}
    law |= {"linear_limit": 15.0, "compression_rate": 0.1, "extension_rate": 0.02}
    result, _ = command("simulate", "--json", seed=4, tolerance=1e-4, **CHAIN, **law)
    chain = ChainParameters(3, 20.0, 1.0, **law)
    how = {"seed": 4, "tolerance": 1e-4, "sample_interval": None}
    run = simulate(chain, duration=30.0, transient=10.0, **how)
    for name in ("disorder_parameter", "mean_length", "energy_residual"):
        assert result[name] == getattr(run, name)
    assert result["events"] == len(run.events) > 0
    expected = law | {"n_blocks": 3, "method": "event", "seed": 4, "tolerance": 1e-4}
    assert expected.items() <= result.items()
    infinite, _ = command("simulate", "--json", linear_limit="inf", **CHAIN)
    assert infinite["linear_limit"] == "Infinity"


def test_the_output_file_holds_the_samples_and_stays_unless_forced(command, tmp_path):
    path = tmp_path / "run.h5"
    path.write_text("mine")
    _, said = command("simulate", output=path, status=2, **CHAIN)
    assert said == f"error: output = {path}: is there already; --force overwrites it\n"
    assert path.read_text() == "mine"
    result, _ = command("simulate", "--json", "--force", output=path, sample_interval=0.5, **CHAIN)
    data = store.read(path)
    assert data.arrays["positions"].shape == (61, 3)
    assert (data.attributes["belt_velocity"], data.attributes["kind"]) == (20, "run")
    assert len(data.arrays["events"]) == result["events"]


def test_constants_of_each_block_are_numbers_with_commas(command, tmp_path):
    path, law = tmp_path / "run.h5", {"mass": "1,3,1", "stiffness": "1,1,1", "rest_length": 40}
    result, _ = command("simulate", "--json", output=path, **CHAIN, **law)
    chain = ChainParameters(3, 20.0, 1.0, mass=(1, 3, 1), rest_length=40)
    assert Run.load(path) == simulate(chain, duration=30.0, transient=10.0)
    assert result["mass"] == [1, 3, 1] and "stiffness" not in result
    motion, _ = command("classify", "--json", mass="1,3", **ORBIT)
    direct = classify(ChainParameters(2, 5.0, mass=(1, 3)), duration=2000, transient=1000)
    assert motion["disorder_parameter"] == direct.disorder_parameter
    assert "mass" in command("simulate", mass="1,3,1", **CHAIN)[0]


@pytest.mark.parametrize("asked", ["error", "ignore"])
def test_a_warning_is_one_line_without_a_place_in_the_code(command, asked):
    with warnings.catch_warnings():
        warnings.simplefilter(asked)  # as of PYTHONWARNINGS
        _, said = command("simulate", n_blocks=7, belt_velocity=12, noise=1, duration=300)
    assert said.startswith("warning: loading is measured too") and said.count("\n") == 1


def test_closed_streams_and_the_backend_of_a_notebook_change_nothing(tmp_path):
    words = "simulate --n-blocks 2 --belt-velocity 10 --duration 50 --output run.h5 >&- 2>&-"
    backend = "MPLBACKEND=module://matplotlib_inline.backend_inline"
    run = f"{sys.executable} -m beltrepro"
    script = f"{run} {words} && {backend} {run} plot run.h5 --output run.png"
    done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    expected = simulate(ChainParameters(2, 10.0), duration=50.0)
    assert Run.load(tmp_path / "run.h5") == expected
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("where", "said"), [(">&-", "standard output is closed"), (">/dev/full", "No space left")]
)
@pytest.mark.parametrize(
    "words", ["--version", "simulate --n-blocks 1 --belt-velocity 9 --duration 99"]
)
def test_what_cannot_be_printed_is_an_error(where, said, words):
    script = f"unset PYTHONUNBUFFERED; {sys.executable} -m beltrepro {words} {where}"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert done.returncode == 1 and said in done.stderr and done.stderr.count("\n") == 1


def test_classify_prints_the_motion(command):
    result, _ = command("classify", "--json", seed=4, **ORBIT)
    motion = classify(ChainParameters(2, 5.0), duration=2000, transient=1000, seed=4)
    expected = {name: value for name, value in vars(motion).items() if name != "parameters"}
    assert result["period_time"] == pytest.approx(29.2705, abs=1e-4)
    expected |= {"method": "event", "seed": 4, "replicate": 0, "n_blocks": 2}
    assert expected.items() <= result.items()
    chaotic = {"n_blocks": 7, "belt_velocity": 10, "noise": 1, "duration": 400, "transient": 100}
    assert command("classify", "--json", **chaotic)[0]["period_time"] is None


WORDS = {"n_blocks": "2,3", "belt_velocity": "5:20:15", "duration": 60, "transient": 20}


def test_scan_takes_lists_and_ranges(command, tmp_path):
    more = {"friction_ratio": "0.45,0.6", "noise": 1, "replicates": 2, "seed": 4}
    rows, _ = command("scan", "--json", initial_spread=0.5, **WORDS, **more)
    grid = Grid([2, 3], [5.0, 20.0], 1.0, friction_ratio=[0.45, 0.6], replicates=2)
    direct = scan(grid, seed=4, duration=60.0, transient=20.0, initial_spread=0.5)
    read = pd.read_json(io.StringIO(json.dumps(rows)), precise_float=True)
    pd.testing.assert_frame_equal(read, direct.table(), check_exact=True, check_dtype=False)
    assert [row["belt_velocity"] for row in rows[:8]] == [5.0] * 4 + [20.0] * 4
    path = tmp_path / "scan.csv"
    assert command("scan", workers=1, output=path, **WORDS)[0] == f"{path}: 4 points\n"
    assert len(pd.read_csv(path)) == 4
    heading = command("scan", **WORDS)[0].splitlines()[0].split()
    assert heading[:3] == ["n_blocks", "belt_velocity", "disorder_parameter"]
    rows, _ = command("scan", "--json", n_blocks=1, belt_velocity="1:2:0.2,5", duration=5)
    assert [row["belt_velocity"] for row in rows] == [1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 5.0]


def test_a_scan_of_the_shell_goes_on(command, tmp_path):
    path = tmp_path / "r.h5"
    failing = WORDS | {"n_blocks": 5, "belt_velocity": "10,150", "store": path}
    assert "meet" in command("scan", status=1, **failing)[1]
    for replicates in (1, 2):
        more = {"on_error": "nan", "noise": 1, "replicates": replicates}
        rows, said = command("scan", "--json", **failing | more)
        assert [bool(row["error"]) for row in rows] == [False] * replicates + [True] * replicates
        assert f"warning: {replicates} of {2 * replicates} chains have failed; the first is" in said
    assert len(beltrepro.Results.load(path)["replicate"]) == 4
    other = tmp_path / "." / "r.h5"
    _, said = command("scan", "--force", status=2, **failing | {"output": f"{other}"})
    assert "is the store" in said and len(beltrepro.Results.load(path)["replicate"]) == 4


@pytest.mark.parametrize(("method", "tolerance"), [("event", 1e-10), ("verlet", None)])
def test_all_commands_agree_on_the_tolerance(command, method, tolerance):
    told, _ = command("simulate", "--json", method=method, **CHAIN)
    (row,), _ = command("scan", "--json", method=method, **CHAIN)
    assert told.get("tolerance") == row.get("tolerance") == tolerance
    assert ("tolerance" in told) == ("tolerance" in row) == (tolerance is not None)


# --- film, track, analyse ---


def test_a_chain_is_filmed_tracked_and_analysed(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    movie, table, picture = (Path(name) for name in ("a:b.mp4", "a.csv", "a.png"))
    chain = {"n_blocks": 2, "belt_velocity": 15, "duration": 160, "transient": 60}
    filmed, _ = command("film", "--json", output=movie, dropped=0.02, **chain)
    assert filmed["seconds"] == pytest.approx(100 * 0.0765, abs=0.1)
    known = {"scale": filmed["scale"], "zero": filmed["zero"]}
    tracked, _ = command("track", movie, "--json", output=table, **known)
    assert (tracked["frames"], tracked["lost_s"]) == (filmed["frames"], [])
    track = Track.load(table)
    assert len(track.time_s) == tracked["frames"]
    assert tracked["seconds"] == pytest.approx(np.ptp(track.time_s))
    assert abs(tracked["angle"]) < 0.1
    analysed, _ = command("analyse", table, "--json", output=picture)
    assert analysed["disorder_parameter"] == pytest.approx(filmed["disorder_parameter"], rel=0.01)
    assert analysed["mean_length_model"] == pytest.approx(analysed["mean_length"] / 1.4e-3)
    assert picture.read_bytes().startswith(b"\x89PNG")


RECORDING = "time_s,x_m\n" + "".join(f"{row / 24},{0.8 + 0.01 * (row % 9)}\n" for row in range(60))


def test_a_film_of_verlet_has_a_time_step_that_divides_the_time_between_frames(command, tmp_path):
    options = CHAIN | {"method": "verlet", "time_step": 0.004, "output": tmp_path / "a.mp4"}
    assert command("film", "--json", **options)[0]["frames"] == 37
    _, said = command("film", "--force", status=2, **options | {"time_step": 5})
    assert "time_step = 5: must be" in said


def test_a_table_without_an_end_is_told(command, tmp_path):
    (tmp_path / "a.csv").write_text(RECORDING[:-1])
    assert "its last line has no end" in command("analyse", tmp_path / "a.csv", "--json")[1]


def test_analyse_says_whether_blocks_are_in_x(command, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(RECORDING)
    plain, _ = command("analyse", path, "--json")
    of_springs, _ = command("analyse", path, "--json", block_length=0.1)
    assert (plain["blocks_m"], of_springs["blocks_m"]) == (0, 0.45)
    assert of_springs["mean_length"] == pytest.approx(plain["mean_length"] - 0.45)
    assert "--block-length takes them off" in command("analyse", path)[0]


# --- what is refused ---


def test_a_working_folder_that_is_gone_is_told(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tmp_path.rmdir()
    _, said = command("simulate", output="run.h5", status=2, **CHAIN)
    assert said == "error: output = run.h5: the working folder is not there any more\n"


def test_an_option_given_twice_and_too_little_memory_are_told(command, monkeypatch):
    _, said = command("simulate", "--noise", 1, "--noise=2", status=2, **CHAIN)
    assert said.startswith("error: --noise: given 3 times")

    def simulate_nothing(*_, **__):
        raise MemoryError("Unable to allocate 122. GiB")

    monkeypatch.setattr(beltrepro, "simulate", simulate_nothing)
    _, said = command("simulate", status=1, **CHAIN)
    assert said == "error: too little memory: Unable to allocate 122. GiB\n"


FILM = CHAIN | {"output": "a.mp4"}
WATCH = {"n_blocks": 2, "belt_velocity": 15}


@pytest.mark.parametrize(
    ("action", "options", "message"),
    [
        ("simulat", CHAIN, "; did you mean 'simulate'?"),
        ("simulate", CHAIN | {"transient": 31}, "transient = 31"),
        ("simulate", CHAIN | {"method": "verlet", "tolerance": 1e-8}, "'verlet' has none"),
        ("simulate", CHAIN | {"output": "run.csv"}, "must end in .h5"),
        ("simulate", CHAIN | {"belt_velocity": "1:5:1"}, "`beltrepro scan` takes lists and ranges"),
        ("simulate", CHAIN | {"mass": "1,3"}, "[1.0, 3.0] has 2 numbers: one number or 3 are"),
        ("simulate", CHAIN | {"mass": "1,,1"}, "--mass: '': a number is needed; see"),
        ("simulate", CHAIN | {"mass": "1:5:1"}, "`beltrepro scan` takes lists and ranges"),
        ("scan", CHAIN | {"noise": "1,1"}, "occurs twice; --replicates 2 makes two runs"),
        ("scan", CHAIN | {"mass": "1,3,1"}, "'1,3,1': a list is an axis; blocks that differ:"),
        ("scan", CHAIN | {"n_blocks": 3, "mass": "1,2,3"}, "mass = 1,2,3: as many as bl"),
        ("verify", {"list": "run.h5"}, "list = run.h5: must end in .json"),
        ("classify", CHAIN | {"method": "verlet"}, "only 'event' has a tangent dynamics"),
        ("film", CHAIN | {"output": "no/such/folder/a.mp4"}, "its folder does not exist"),
        ("film", FILM | {"width": 33}, "width = 33: must be an even number"),
        ("film", FILM | {"metres_per_pixel": 1e-5}, "take a larger"),
        ("film", FILM | {"transient": 50}, "transient = 50"),
        ("analyse", {"transient": 500}, "0 samples"),
        ("analyse", {"window": 0.1}, "window_s = 0.1: it must hold 3 samples or more"),
        ("analyse", {"quiet": "nan"}, "quiet"),
        ("analyse", {"block_length": -1}, "block_length = -1"),
        ("analyse", {"block_length": 0.2}, "measured from the support, and hold the 0.9 m of"),
        ("analyse", {"n_blocks": 0}, "n_blocks = 0"),
        (
            "watch",
            WATCH | {"output": "a.mp4", "duration": 0.01},
            "at least 0.0416667 and at most 3600",
        ),
        ("watch", WATCH | {"speed": -1}, "speed = -1: must be at least 0.05 and at most 50"),
        ("watch", WATCH | {"duration": 5}, "only a file has one, give --output too"),
        ("simulate", CHAIN | {"sample_interval": 3}, "sample_interval = 3: only a file has one"),
        ("watch", WATCH, "no display to open a window on: write a film with --output"),
    ],
)
def test_bad_input_is_one_line(command, tmp_path, monkeypatch, action, options, message):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(picture, "display", lambda: "")
    files = {"analyse": ["a.csv"], "verify": ["results"]}.get(action, [])
    for name in files:
        (tmp_path / name).write_text(RECORDING)
    out, said = command(action, *files, status=2, **options)
    assert out == "" and message in said
    assert said.startswith("error: ") and said.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == files
