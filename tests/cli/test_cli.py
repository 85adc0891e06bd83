"""The command `beltrepro`: results as JSON or file, and errors in one line."""

import json
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from types import SimpleNamespace

import pandas as pd
import pytest

from beltrepro import ChainParameters, Grid, classify, scan, simulate
from beltrepro.base import store
from beltrepro.cli import app as cli

CHAIN = {"n-blocks": 3, "belt-velocity": 20, "noise": 1, "duration": 30, "transient": 10}


def words(*flags, action="simulate", **changes):
    settings = CHAIN | {name.replace("_", "-"): value for name, value in changes.items()}
    return [action, *(f"--{name}={value}" for name, value in settings.items()), *flags]


def command(*flags, **changes):
    """What the command says and returns, without a process of its own."""
    stdout, stderr = StringIO(), StringIO()
    with redirect_stdout(stdout), redirect_stderr(stderr):
        try:
            code = cli.main(words(*flags, **changes))
        except SystemExit as end:
            code = end.code
    return SimpleNamespace(returncode=code, stdout=stdout.getvalue(), stderr=stderr.getvalue())


def test_json_is_what_simulate_returns():
    law = {"static_friction": 80.0, "friction_ratio": 0.3, "rest_length": 40.0}
    law |= {"linear_limit": 15.0, "compression_rate": 0.1, "extension_rate": 0.02}
    done = command("--json", seed=4, tolerance=1e-4, **law)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    chain = ChainParameters(3, 20.0, 1.0, **law)
    how = {"seed": 4, "tolerance": 1e-4, "sample_interval": None}
    run = simulate(chain, duration=30.0, transient=10.0, **how)
    for name in ("disorder_parameter", "mean_length", "energy_residual"):
        assert result[name] == getattr(run, name)
    assert result["events"] == len(run.events) > 0
    expected = law | {"n_blocks": 3, "method": "event", "seed": 4, "tolerance": 1e-4}
    assert expected.items() <= result.items()


def test_the_output_file_holds_the_samples_and_stays_unless_forced(tmp_path):
    path = tmp_path / "run.h5"
    path.write_text("mine")
    done = command(output=path)
    assert done.returncode == 2 and path.read_text() == "mine"
    assert done.stderr == f"error: output = {path}: is there already; --force overwrites it\n"
    done = command("--json", "--force", output=path, sample_interval=0.5)
    assert done.returncode == 0, done.stderr
    data = store.read(path)
    assert data.arrays["positions"].shape == (61, 3)
    assert (data.attributes["belt_velocity"], data.attributes["kind"]) == (20, "run")
    assert len(data.arrays["events"]) == json.loads(done.stdout)["events"]
    assert command("--force", output=path).returncode == 0  # ten samples a unit of time
    assert store.read(path).arrays["positions"].shape == (301, 3)


def test_a_warning_is_one_line_without_a_place_in_the_code():
    said = command(n_blocks=7, belt_velocity=12, duration=300, transient=0).stderr
    assert said.startswith("warning: loading is measured too") and said.count("\n") == 1


def test_classify_prints_the_motion():
    settings = {"action": "classify", "n_blocks": 2, "belt_velocity": 5, "noise": 0}
    done = command("--json", duration=2000, transient=1000, seed=4, **settings)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert (result["state"], result["period_events"]) == ("periodic", 3)
    assert result["period_time"] == pytest.approx(29.2705, abs=1e-4)
    assert {"largest_exponent", "standard_error", "disorder_parameter", "mean_length"} <= set(
        result
    )
    assert (result["method"], result["seed"], result["replicate"]) == ("event", 4, 0)
    motion = classify(ChainParameters(2, 5.0), duration=2000, transient=1000, seed=4)
    assert result["largest_exponent"] == motion.largest_exponent
    chaotic = settings | {"n_blocks": 7, "belt_velocity": 10, "duration": 400, "transient": 100}
    assert json.loads(command("--json", **chaotic).stdout)["period_time"] is None
    assert "largest_exponent" in command(**chaotic).stdout


def test_classify_follows_the_orbit():
    settings = {"action": "classify", "n_blocks": 2, "belt_velocity": 5, "noise": 0}
    settings |= {"duration": 2000, "transient": 1000, "lower": 4.9, "upper": 5.2, "step": 0.1}
    result = json.loads(command("--json", **settings).stdout)
    assert (result["lower"], result["upper"], result["passed"]) == (4.9, 5.2, [])
    assert result["lower_end"] == result["upper_end"] == "the edge of the range"
    assert result["word"] == "1- 1| 1- 2- 1| 2|"
    assert result["orbits"]["belt_velocity"] == pytest.approx([4.9, 5.0, 5.1, 5.2])
    other = {"quantity": "friction_ratio", "lower": 0.44, "upper": 0.46}
    shown = command(**settings | other).stdout
    assert "friction_ratio  period_time  period_events" in shown
    assert "step: only a branch has one" in command(action="classify", step=1).stderr
    done = command(**settings, quantity="noise")
    assert (done.returncode, done.stdout) == (2, "") and "quantity = 'noise'" in done.stderr


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n_blocks": 0}, "n_blocks = 0"),
        ({"transient": 31}, "transient = 31"),
        ({"method": "euler"}, "method = 'euler'"),
        ({"method": "verlet", "tolerance": 1e-8}, "tolerance = 1e-08: method 'verlet' has none"),
        ({"tolerance": 2}, "tolerance = 2: must be at least 1e-16 and at most 1"),
        ({"output": "no/such/folder/run.h5"}, "output = no/such/folder/run.h5"),
        ({"output": "run.csv"}, "must end in .h5"),
        ({"belt_velocity": "1:5:1"}, "a number is needed; `beltrepro scan` takes lists and ranges"),
        ({"action": "classify", "method": "verlet"}, "only 'event' has a tangent dynamics"),
    ],
)
def test_bad_input_is_one_line(changes, message):
    done = command(**changes)
    assert done.returncode == 2
    assert done.stdout == ""
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_another_chain_than_that_of_the_run_gone_on_with_is_told(tmp_path):
    path = tmp_path / "half.h5"
    chain = ChainParameters(3, 20.0, 1.0, mass=(1, 2, 1))
    simulate(chain, duration=30, transient=10).save(path)
    changed = command(f"--from-state={path}", noise=0)
    assert changed.returncode == 0
    assert changed.stderr == (
        f"warning: not the chain of {path}: noise 1.0 -> 0.0, mass (1.0, 2.0, 1.0) -> 1.0\n"
    )
    simulate(ChainParameters(3, 20.0, 1.0), duration=30).save(path)
    assert command(f"--from-state={path}").stderr == ""


# --- scan ---

WORDS = ["--n-blocks=2,3", "--belt-velocity=5:20:15", "--duration=60", "--transient=20"]


def test_the_command_takes_lists_and_ranges(capsys, tmp_path):
    more = ["--friction-ratio=0.45,0.6", "--noise=1", "--replicates=2", "--seed=4"]
    more.append("--initial-spread=0.5")
    assert cli.main(["scan", *WORDS, *more, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    grid = Grid([2, 3], [5.0, 20.0], 1.0, friction_ratio=[0.45, 0.6], replicates=2)
    direct = scan(grid, seed=4, duration=60.0, transient=20.0, initial_spread=0.5)
    values = [row["disorder_parameter"] for row in rows]
    assert values == pytest.approx(direct["disorder_parameter"].tolist(), rel=1e-12)
    assert [row["belt_velocity"] for row in rows[:8]] == [5.0] * 4 + [20.0] * 4
    path = tmp_path / "scan.csv"
    assert cli.main(["scan", *WORDS, "--workers=1", f"--output={path}"]) == 0
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
