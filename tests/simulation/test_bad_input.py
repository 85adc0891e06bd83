"""Every wrong input gets one clear line that names it: in Python, and on the command line."""

import argparse
import inspect
import math
from collections import deque

import numpy as np
import pytest

import beltrepro
from beltrepro import Catalogue, ChainParameters, ChainState, Grid, Results, Run, Setup
from beltrepro.base import names
from beltrepro.base.errors import InputError
from beltrepro.cli import app as cli
from beltrepro.cli.options import by_block, grid

CHAIN = ChainParameters(2, 5.0)
STATE = ChainState.at_rest(CHAIN)
CATALOGUE = Catalogue({"slips": np.zeros(1, [("point", "i4")])})
RECORDS = {"source": beltrepro.catalogue(CHAIN, duration=200.0, transient=50.0)}
SHORT = {"chains": CHAIN, "duration": 20.0}
LONG = SHORT | {"transient": 10.0}
MOVING = {"parameters": CHAIN, "positions": [60.0, 120.0], "velocities": [1.0, -1.0]}
# What is called, and arguments that it takes.
CALLS = [
    *((getattr(beltrepro, name), SHORT) for name in ("simulate", "scan", "catalogue", "basins")),
    *((getattr(beltrepro, f"time_to_{end}"), SHORT) for end in ("continuous_slip", "orbit")),
    *((getattr(beltrepro, name), LONG) for name in ("classify", "lyapunov_spectrum")),
    (beltrepro.periodic_orbit, LONG),
    (Setup, {"chains": CHAIN}),
    (Grid, {"n_blocks": 2, "belt_velocity": 5.0}),
    (ChainParameters, {"n_blocks": 2, "belt_velocity": 5.0}),
    (beltrepro.sweep, SHORT | {"belt_velocity": [5.0, 6.0]}),
    (ChainState.at_balance, {"parameters": CHAIN}),
    (ChainState.in_motion, {"parameters": CHAIN}),
    (STATE.keyed, {"seed": 1, "replicate": 0}),
    (STATE.moved, {}),
    (beltrepro.slipping_state, {"parameters": CHAIN, "energy": 9.0}),
    (beltrepro.sliding_energy, MOVING),
    (beltrepro.mode_energies, MOVING),
    *((call, {"value": 1.0, "quantity": "time"}) for call in (beltrepro.to_si, beltrepro.from_si)),
    *((call, RECORDS) for call in (beltrepro.slip_sizes, beltrepro.avalanche_energies)),
    (beltrepro.section, RECORDS),
    (beltrepro.spectrum, {"runs": np.arange(32.0), "sample_interval": 0.1}),
    *((call, {"values": [1.0, 2.0, 5.0]}) for call in (beltrepro.density, beltrepro.power_law)),
    (CATALOGUE.table, {}),
    (Run.load, {"path": "run.h5"}),
    (Results({}, {}).save, {"path": "scan.csv"}),
]
HUGE = 10**5000  # beyond a double, and beyond what Python writes as text
NOT_ONE = (object(), int, {1.0}, {"a": 1}, [], 1j, "1", b"1", math.nan, -1.0, HUGE, True, [[1.0]])
NUMBER = (*NOT_ONE, math.inf, np.ones((1, 2)), np.timedelta64(1, "s"))
NUMBERS = (1.0, [50.0, math.nan], ["50", "100"], [[[50.0, 100.0]]], [[1.0, 2.0], [3.0]], "much",
           [np.ma.array([50.0, 100.0], mask=[False, True])])  # fmt: skip
ORDERED = (
    *NUMBERS,
    deque([True, 100.0]),
    [100.0, 50.0],
    [50.0, 50.0],
    [-50.0, 100.0],
    [1.0, 2.0, 3.0],
)
# By the name of an argument, wherever a function takes it.
WRONG = {
    **dict.fromkeys(("duration", "transient", "time_step", "seed", "replicate", "energy"), NUMBER),
    **dict.fromkeys(("n_blocks", "noise", "friction_ratio", "section_values"), NUMBER),
    **dict.fromkeys(("replicates", "workers", "laminar_time", "initial_spread"), NUMBER),
    **dict.fromkeys(("positions", "initial_positions"), ORDERED),
    "belt_velocity": (*NUMBER, 0.0),
    "velocities": NUMBERS,
    "tolerance": (*NUMBER, 1e-17, 2.0),
    "on_error": (5, None, "", "ignore"),
    "store": (5, "a\0.h5", ["a.h5"], "a.csv"),
    "method": (1, "", "euler", True, math.nan, np.ones(2)),
    "chains": (5, [None], ChainParameters, "much", []),
    "parameters": (5, [None], ChainParameters, "much", []),
    "initial_state": (5, [5], "much"),
    "progress": (5, True, "much"),
    "spread": (*NUMBER, 1.5),
    "belt": (5, [5.0, 6.0], [(0.0, 5.0), (0.0, 6.0)], [(20.5, 5.0)], "much"),
    "kind": (5, "", "slip", np.ones(2)),
    "section_bins": (5, "much", [1.0], [0.0, -1.0], [0.0, math.nan], [[0.0, 1.0]]),
    "value": ("1", None, {"a": 1}, True, ["1"], [[1.0], [2.0, 3.0]]),
    "quantity": (5, [], "", "speed", np.ones(2)),
    "source": (5, None, [], [None], "much", CATALOGUE),
    "runs": (5, None, [], [None], "much", [1.0, math.nan], [[[1.0]]]),
    "values": (5, None, "much", [1.0, math.nan], [[1.0, 2.0]], [1.0, "2"], [1.0, math.inf]),
    "frame": (1, "", "lab", None, np.ones(2)),
    **dict.fromkeys(("sample_interval", "bins_per_decade", "low"), (*NUMBER, 0.0)),
    "least_blocks": NUMBER,
    "path": (5, None, "a\0.h5", ["a.h5"]),
}


def line(error: BaseException | str, *words: str) -> None:
    """Check that a message is one line that has these words."""
    message = str(error)
    assert "\n" not in message and len(message) <= 400, message
    assert all(word in message for word in words), (words, message)


def arguments_of(called) -> list[inspect.Parameter]:
    """The arguments of a function, with those of a setup if it takes them."""
    arguments = list(inspect.signature(called).parameters.values())
    if arguments and arguments[-1].kind is arguments[-1].VAR_KEYWORD:
        return arguments[:-1] + list(inspect.signature(Setup).parameters.values())[1:]
    return arguments


@pytest.mark.parametrize(
    ("called", "valid"), CALLS, ids=lambda one: getattr(one, "__qualname__", "")
)
def test_each_wrong_argument_is_one_line_that_names_it(called, valid):
    for argument in arguments_of(called):
        name, optional = argument.name, argument.default is None
        for value in WRONG.get(name, ()):
            if isinstance(value, list) and not value and optional:
                continue
            with pytest.raises(InputError) as caught:
                called(**valid | {name: value})
            line(caught.value, name)
        with pytest.raises(InputError) as caught:
            called(**valid | {name[:-1]: 1})
        line(caught.value, f"{name[:-1]!r}", f"did you mean {name!r}")
        if argument.default is argument.empty:
            with pytest.raises(InputError) as caught:
                called(**{key: value for key, value in valid.items() if key != name})
            line(caught.value, repr(name), "missing")


@pytest.mark.parametrize("called", [beltrepro.simulate, beltrepro.scan])
def test_a_run_in_which_no_time_passes_is_refused(called):
    """Half a step of "verlet", and an instant that 1e12 does not tell apart."""
    late = {"initial_state": ChainState.at_rest(CHAIN, time=1e12)}
    for how in ({"method": "verlet", "duration": 4e-4}, late | {"duration": 1e-5}):
        with pytest.raises(InputError) as caught:
            called(CHAIN, **how)
        line(caught.value, f"duration = {how['duration']:g}: too short for a step from t = ")


def test_numbers_without_a_name_and_symbols_of_the_paper_are_understood():
    for name in ("simulate", "scan", "catalogue", "classify", "periodic_orbit"):
        with pytest.raises(InputError) as caught:
            getattr(beltrepro, name)(CHAIN, 1000, 300)
        line(caught.value, f"{name}: write duration=1000, transient=300")
    with pytest.raises(InputError, match=r"^sweep: write belt_velocity=\[12, 20\]$"):
        beltrepro.sweep(CHAIN, "belt_velocity", [12, 20], duration=100)
    for symbol, name in names.SYMBOLS.items():
        assert names.hint(symbol, [name, "other"]) == f"; did you mean {name!r}?"
    with pytest.raises(InputError, match="no argument 'N'; did you mean 'n_blocks'"):
        ChainParameters(N=5, u=20)
    with pytest.raises(InputError, match=r"no argument 'zzzz': allowed are .*duration, .*method"):
        beltrepro.basins(CHAIN, duration=20.0, zzzz=1)


# --- the command ----------------------------------------------------------------------------------

COMMANDS = next(
    action.choices
    for action in cli.parser()._actions
    if isinstance(action, argparse._SubParsersAction)
)
RUNS = {"n-blocks": 2, "belt-velocity": 5, "duration": 20}
GIVEN = dict.fromkeys(("simulate", "scan", "classify"), RUNS) | {"track": {"output": "track.csv"}}
GIVEN |= dict.fromkeys(("watch", "film"), RUNS | {"output": "film.mp4"})
FILES = {"track": ["film.mp4"], "analyse": ["track.csv"], "plot": ["run.h5"], "verify": ["results"]}


def refuse(capsys, command: str, options: dict, *words: str) -> None:
    """Check that a command refuses its options in one line, and writes nothing else."""
    given = [f"--{name}={value}" for name, value in options.items()]
    try:
        status = cli.main([command, *FILES.get(command, []), *given])
    except SystemExit as ended:
        status = ended.code
    out, err = capsys.readouterr()
    assert status == 2 and not out, (command, options, err)
    line(err.removesuffix("\n"), "error: ", *words)


@pytest.mark.parametrize("command", COMMANDS)
def test_misspelt_missing_and_wrong_options_are_named(capsys, monkeypatch, tmp_path, command):
    monkeypatch.chdir(tmp_path)
    given = GIVEN.get(command, {})
    for action in COMMANDS[command]._actions:
        if not action.option_strings or action.nargs == 0:
            continue
        option = action.option_strings[0]
        refuse(capsys, command, given | {f"{option[2:]}x": 1}, f"did you mean {option!r}")
        if action.required:
            rest = {name: value for name, value in given.items() if name != option[2:]}
            refuse(capsys, command, rest, option)
        if action.type in (int, float, grid, by_block):
            for wrong in ("much", "", *(["1.5"] if action.type is int else [])):
                refuse(capsys, command, given | {option[2:]: wrong}, option)
    assert list(tmp_path.iterdir()) == []


def test_output_is_refused_before_anything_is_computed(capsys, tmp_path):
    refuse(capsys, "simulate", RUNS | {"output": tmp_path}, "is a folder")
    for command in ("simulate", "scan", "watch", "film", "track"):
        path = tmp_path / "a.xyz"
        refuse(capsys, command, GIVEN[command] | {"output": path}, "output = ", "a.xyz")
