"""The benchmark: what it compares with computes the same motion; the command; no speeds."""

import argparse
import itertools
import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import naive
from beltrepro import ChainParameters, simulate
from beltrepro.base.errors import InputError
from beltrepro.cli import bench as command
from beltrepro.engine.vector import zeros
from beltrepro.extras.bench import measuring, plain, smooth, table
from beltrepro.extras.bench.competitors import LABELS
from beltrepro.extras.bench.measuring import compare, measure
from beltrepro.extras.bench.peak import multiply_add

EXACT = (*plain.FLAGS, "-ffp-contract=off")  # no fused operations, as in Numba


def c_loop(flags):
    loop = plain.c_loop(flags)
    if loop is None:
        pytest.skip("no C compiler")
    return loop


def advanced(loop, span, n_blocks=5, belt_velocity=20.0, noise=0.0):
    chain = plain.PlainChain(ChainParameters(n_blocks, belt_velocity, noise), loop)
    chain.advance(span)
    return chain


@pytest.mark.parametrize(("n_blocks", "belt_velocity"), [(1, 10.0), (3, 20.0), (5, 20.0)])
def test_plain_loop_is_the_naive_twin(n_blocks, belt_velocity):
    n_steps = 12000
    positions, events = naive.verlet(n_blocks, belt_velocity, n_steps)
    assert {kind for *_, kind in events} == {"slip", "stick"}
    chain = advanced(plain.numba_loop, n_steps / 1000, n_blocks, belt_velocity)
    np.testing.assert_allclose(chain.state[plain.POSITION], positions[-1], rtol=0, atol=1e-9)
    last = np.array(positions)[:, -1]
    moments = chain.carry[[plain.SUM, plain.SUM_OF_SQUARES]] / n_steps
    assert moments == pytest.approx([last.mean(), np.mean(last**2)], rel=1e-9)


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_loop_in_c_does_what_the_loop_in_numba_does(noise):
    """Without fused operations; and, for a shorter time, as it is timed."""
    for flags, span, error in ((EXACT, 20.0, 1e-9), (plain.FLAGS, 8.0, 1e-6)):
        expected = advanced(plain.numba_loop, span, noise=noise)
        in_c = advanced(c_loop(flags), span, noise=noise)
        np.testing.assert_allclose(in_c.state, expected.state, rtol=error, atol=error)


def test_no_compiler_is_no_error(monkeypatch):
    monkeypatch.setattr(plain.shutil, "which", lambda program: None)
    assert plain.c_loop.__wrapped__() is None
    assert plain.compiler.__wrapped__() is None


def test_a_compiler_is_told_by_the_first_line_of_its_version(monkeypatch):
    monkeypatch.setattr(plain, "_compiler", lambda: sys.executable)
    assert plain.compiler.__wrapped__().startswith(f"Python 3.{sys.version_info.minor}")


def test_two_trees_have_no_page(monkeypatch, tmp_path):
    def measured(**settings):
        raise InputError("measured")

    monkeypatch.setattr("beltrepro.extras.bench.measuring.measure", measured)
    page = f"--output={tmp_path / 'page.md'}"
    for options, words in (([page], "measured"), ([page, "--against=."], "not with --against")):
        parser = argparse.ArgumentParser()
        command.add(parser.add_subparsers())
        with pytest.raises(InputError, match=words):
            command.run(parser.parse_args(["bench", *options]))


def test_solve_ivp_follows_the_exact_dynamics():
    parameters = ChainParameters(5, 20.0)
    chain = smooth.SolveIvpChain(plain.PlainChain(parameters, plain.numba_loop))
    chain.advance(12.0)
    run = simulate(parameters, duration=12.0, method="event")
    assert len(run.events) > 3
    np.testing.assert_allclose(chain.positions, run.positions[-1], rtol=0, atol=1e-5)


def test_solve_ivp_leaves_no_block_beyond_its_threshold():
    chain = smooth.SolveIvpChain(advanced(plain.numba_loop, 500.0, belt_velocity=1.0))
    for _ in range(40):  # at 164 a pair of events hides in the step that ends a slip
        chain.advance(5.0)
        functions = [chain._event(block) for block in range(5)]
        assert min(function(chain.time, chain._state) for function in functions) > -1e-6


def test_peak_kernel_multiplies_and_adds():
    values = zeros((6, 16))
    multiply_add(values, 2)
    np.testing.assert_allclose(values, 0.999 * 0.1 + 0.1)


@pytest.mark.slow
def test_quick_run_shows_every_table(tmp_path):
    page = tmp_path / "benchmark.md"
    options = ["--quick", "--rounds=1", f"--only={','.join(LABELS)}", f"--output={page}"]
    result = json.loads(bench(*options, "--json").stdout)
    assert result["names"] == list(LABELS)
    for row in result["cases"]:
        assert set(row["ns"]) >= {"numba", "verlet", "event"}
        assert ("scipy" in row["ns"]) == (row["noise"] == 0)
    text = table.as_text(result)
    for title in ("Cost", "Share of the peak", "Number of blocks", "Two processes"):
        assert f"\n{title}\n" in text
        assert f"\n## {title}\n" in page.read_text()
    assert "/tmp" not in page.read_text()


@pytest.mark.thorough
def test_two_trees_are_timed_in_turns():
    tree = Path(__file__).parents[2]
    (quiet, noisy) = json.loads(
        bench("--quick", "--rounds=3", "--only=event", f"--against={tree}", "--json").stdout
    )
    assert (quiet["noise"], noisy["noise"], quiet["method"]) == (0.0, 1.0, "event")
    for row in (quiet, noisy):  # of the same code
        assert len(row["here"]) == len(row["there"]) == 3
        assert 0.3 < np.median(row["here"]) / np.median(row["there"]) < 3


def bench(*options):
    command = [sys.executable, "-m", "beltrepro", "bench", *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    # a cold cache is told
    lines = [line for line in done.stderr.splitlines() if not line.startswith("compiling for")]
    assert lines == []
    return done


def test_costs_are_seconds_of_processor_time_by_chain_and_unit_of_time(monkeypatch):
    """By clocks that go on by 2 and 3 seconds at each look, over the shortest span."""
    clocks = {"process_time": 2.0, "perf_counter": 3.0}
    looks = {name: itertools.count(100.0, step).__next__ for name, step in clocks.items()}
    monkeypatch.setattr(measuring, "time", SimpleNamespace(**looks))
    costs, walls, peak, scope = {}, [], [], measuring.QUICK
    names = ("numba", "event")
    tasks = [measuring._cost(costs, walls, name, (5, 0.0, 20.0), 8, scope) for name in names]
    for task in (*tasks, measuring._peak(peak, scope)):
        for _ in range(3):
            next(task)
    assert costs == {"numba": [pytest.approx(2e10)] * 2, "event": [pytest.approx(2e10 / 8)] * 2}
    assert walls == [1.5] * 4
    assert peak == [2 * 16 * 6 * scope.timing * 2e8 / 2] * 2
    workers = [
        SimpleNamespace(
            ask=lambda case, span: None, reply=lambda s=s: {"processor": s, "bytes": 9 * s}
        )
        for s in (1.0, 4.0)
    ]
    together = {"wall": 3.0, "processor": 2.5, "bytes": 9.0}
    assert measuring._together(workers, {}, 1.0) == together


def test_each_case_is_asked_of_each_competitor():
    names = ["numba", "verlet", "event"]
    result = {part: [] for part in ("cases", "chains", "blocks", "peak", "wall")}
    result |= {part: {} for part in ("cores", "memory", "first_step")}
    tasks = measuring._tasks(measuring.QUICK, names, result)  # of which none has begun
    quiet = {"n_blocks": 5, "noise": 0.0, "belt_velocity": 20.0, "ns": {}}
    assert result["cases"] == [quiet, quiet | {"noise": 1.0}]
    assert result["chains"] == [{"chains": chains, "ns": {}} for chains in (1, 8, 64)]
    assert result["blocks"] == [{"n_blocks": n_blocks, "ns": {}} for n_blocks in (1, 10)]
    # the peak, and cores and first step of two integrators
    assert len(tasks) == 2 * 3 + 3 * 2 + 2 * 3 + 1 + 2 * 2


def test_each_table_of_the_page_has_its_title_words_and_numbers():
    numba, steps = [1000.0, 3000.0, 2000.0], [100.0, 200.0, 200.0]
    case = {"n_blocks": 5, "noise": 0.0, "belt_velocity": 20.0}
    result = {
        "conditions": measuring._conditions(3, measuring.Scope(), False, None),
        "names": ["numba", "c", "steps", "event"],
        "cases": [case | {"ns": {"numba": numba, "steps": steps}}],
        "chains": [{"chains": 8, "ns": {"event": [50.0]}}],
        "blocks": [{"n_blocks": 10, "ns": {"numba": [2000.0]}}],
        "cores": {"event": {"wall": [1.9, 2.1, 1.5], "processor": [1.8]}},
        "memory": {"event": {"start": 185e6, "end": 194e6}},
        "first_step": {"event": [1.2]},
        "peak": [1e11],
        "wall": [1.0, 1.25, 1.5],
    }
    last_rows = {
        "Conditions": ["largest over smallest cost in the rounds", "1.50"],
        "Cost": ["5", "0", "20", "times faster than the plain loop", "1.00", "n/a", "10.0", "n/a"],
        "Share of the peak": ["peak", "", *["100.0 (100 %)"] * 3],
        "Number of chains": ["8", "50.0"],
        "Number of blocks": ["10", "200"],
        "Two processes": ["event", "1.90", "2.10", "1.80"],
        "Memory and start": ["event", "185", "194", "1.20"],
    }
    _, *parts = table.as_markdown(result).split("\n## ")
    assert [part.partition("\n")[0] for part in parts] == list(last_rows)
    for part, cells in zip(parts, last_rows.values(), strict=True):
        _, text, *lines = (line for line in part.splitlines() if line)
        assert lines[-1] == f"| {' | '.join(cells)} |"
        assert text.endswith(".") or cells is last_rows["Conditions"]
    assert "| clock over processor time | 1.25, at most 1.50 |" in parts[0]
    assert "| 5 | 20 | 57.50 (57.5 %) | n/a | 575.00 (575.0 %) |" in parts[2]


def test_costs_become_cells():
    costs = {"numba": [100.0, 300.0], "verlet": [10.0, 20.0]}
    case = {"n_blocks": 5, "noise": 0.0, "belt_velocity": 20.0, "ns": costs}
    cost = table._cases({"names": ["numba", "c", "verlet"], "cases": [case]})
    assert [row[4:] for row in cost.rows] == [
        ("200", "n/a", "15.0"),
        ("0.400", "n/a", "0.0300"),
        ("1.00", "n/a", "12.5"),
    ]
    sides = {"here": [3.0, 40.0, 50.0], "there": [4.0, 50.0, 20.0]}
    calls = {"call_here": [0.01, 0.02, 0.04], "call_there": [0.03, 0.03, 0.5]}
    text = table.comparison([case | sides | calls | {"method": "event"}], "a tree")
    title, _, row, _ = text.split("\n")
    assert title.endswith("beside a tree")
    assert " ".join(row.split()) == "5 0 20 event 40.0 20.0 0.800 0.750 to 2.500 20.0 30.0"


@pytest.mark.parametrize(
    ("function", "settings", "message"),
    [
        (measure, {"rounds": 0}, "rounds = 0"),
        (measure, {"only": ["euler"]}, "only = 'euler'"),
        (compare, {"tree": Path("no/such/tree")}, "against = no/such/tree: no source tree"),
        (compare, {"tree": Path(), "only": ["numba"]}, "only = 'numba': allowed are verlet, event"),
    ],
)
def test_bad_input_names_what_is_allowed(function, settings, message):
    with pytest.raises(InputError, match=message):
        function(**settings)
