"""Every wrong input gets one clear line: of each argument, option and key, whatever it is.

What is tried follows from signatures, from the parser of the command and from the schema, so a new
argument, option or key is tried without a change here.
"""

import argparse
import inspect
import math
import re

import numpy as np
import pytest

import beltrepro
from beltrepro import (
    Basins,
    ChainParameters,
    ChainState,
    Grid,
    PeriodicOrbit,
    Results,
    Run,
    Setup,
    chaos,
    simulation,
)
from beltrepro.base import names
from beltrepro.base.errors import InputError, NotEnoughDataError
from beltrepro.cli import app as cli
from beltrepro.cli.options import grid, whole_grid
from beltrepro.replication.camera import recording
from beltrepro.replication.plan.points import QUANTITIES

LONGEST = 400  # characters of a line


def line(error: BaseException | str, *words: str) -> str:
    """The message, which is one line that has these words."""
    message = str(error)
    assert "\n" not in message and len(message) <= LONGEST, message
    assert all(word in message for word in words), (words, message)
    return message


# --- wrong values, from the signature of a function alone -----------------------------------------

HUGE = 10**5000  # beyond a double, and beyond what Python writes as text
ANYWHERE = {
    "object": object(),
    "class": int,
    "set": {1.0},
    "mapping": {"a": 1},
    "nothing in it": [],
    "complex": 1j,
    "word": "much",
    "number as text": "1",
    "bytes": b"1",
}
NUMBER = {
    "nan": math.nan,
    "infinite": math.inf,
    "minus infinite": -math.inf,
    "negative": -1.0,
    "huge": HUGE,
    "true": True,
    "nested": [[1.0]],
    "table": np.ones((1, 2)),
    "array without axes": np.array(1.0),
    "duration of NumPy": np.timedelta64(1, "s"),
}
ARRAY = {
    "single number": 1.0,
    "array without axes": np.array(1.0),
    "nan in it": [50.0, math.nan],
    "infinite in it": [50.0, math.inf],
    "texts in it": ["50", "100"],
    "complex in it": np.array([50.0, 1j]),
    "wrong shape": [[[50.0, 100.0]]],
    "ragged": [[1.0, 2.0], [3.0]],
}
RISING = {"unsorted": [100.0, 50.0], "duplicate": [50.0, 50.0], "negative in it": [-50.0, 100.0]}

# The kind of an argument is the first of these words in its annotation. An int is a valid float,
# and every number of the package is 0 or greater, but for velocities.
KINDS = {
    "Chains": {"number": 5, "none in it": [None], "class": ChainParameters},
    "ChainParameters": {"number": 5, "none in it": [None], "class": ChainParameters},
    "ChainState": {"number": 5, "number in it": [5]},
    "PeriodicOrbit": {"number": 5, "class": ChainParameters},
    "bool": {"number": 1, "text": "yes", "list": [True]},
    "Run": {"number": 5, "class": ChainParameters},
    "Report": {"number": 5, "true": True},
    "ArrayLike": ARRAY,
    "Path": {"number": 5, "no name": "a\0.h5"},
    "str": {"empty": "", "number": 1, "nan": math.nan, "true": True},
    "int": NUMBER | {"fraction": 1.5},
    "float": NUMBER,
    "Any": NUMBER | {"list of one": [1.0], "list of three": [1.0] * 3, "text in it": [1.0, "2"]},
}
# By the kind, which of the values that are wrong anywhere are right.
ALLOWED = {"Path": ("word", "number as text", "bytes"), "Report": ("class",)}
# Linear springs, and friction that does not weaken.
MEANINGFUL = dict.fromkeys(("linear_limit", "weakening_velocity"), ("infinite",))


PER_BLOCK = ("static_friction", "friction_ratio", "rest_length", "mass", "stiffness")


def wrong_values(parameter):
    """Values that the argument of a function about one chain cannot have, by what they are."""
    words = parameter.annotation
    words = words if isinstance(words, str) else words.__name__
    kind = next(kind for kind in KINDS if re.search(rf"\b{kind}\b", words))
    values = ANYWHERE | KINDS[kind]
    if kind == "ArrayLike" and not parameter.name.endswith("velocities"):
        values |= RISING
    if kind in ("int", "float", "str") and not re.search("PerChain|Sequence|Axis", words):
        values |= {"list": ["event" if kind == "str" else 1.0]}
    if parameter.name.endswith(("position", "positions", "velocities")):
        values |= {"too many": [1.0, 2.0, 3.0]}
    if "Sequence[float]" in words:
        values |= ARRAY
    if "None" not in words:
        values |= {"none": None}
    if parameter.name in PER_BLOCK and "Axis" in words:
        values = {what: value for what, value in values.items() if what != "table"}
    allowed = ALLOWED.get(kind, ()) + MEANINGFUL.get(parameter.name, ())
    return {name: value for name, value in values.items() if name not in allowed}


# --- public functions -----------------------------------------------------------------------------

CHAIN = ChainParameters(2, 5.0)
STATE = ChainState.at_rest(CHAIN)
RESULTS = Results({}, {})
ORBIT = PeriodicOrbit(CHAIN, STATE, 20.0, *[None] * 7)
REACHED = Results({"belt_velocity": np.array([5.0]), "attractor": np.array([1])}, {})
BASINS = Basins("belt_velocity", (), {}, REACHED)
CATALOGUE = simulation.Catalogue({"slips": np.zeros(1, [("point", "i4")])})
RUN = Run(CHAIN, *[None] * 20)
SHORT = {"chains": CHAIN, "duration": 20.0}
LONG = SHORT | {"transient": 10.0}
MOVING = {"parameters": CHAIN, "positions": [60.0, 120.0], "velocities": [1.0, -1.0]}
TIME = np.arange(100.0)

# Public name: what is called, and arguments that it takes.
CALLS = {
    "Basins.plot": (BASINS.plot, {"path": "basins.png"}),
    "Catalogue.table": (CATALOGUE.table, {}),
    "ChainParameters": (ChainParameters, {"n_blocks": 2, "belt_velocity": 5.0}),
    "ChainParameters.by_block": (CHAIN.by_block, {"quantity": "mass"}),
    "ChainState.at_rest": (ChainState.at_rest, {"parameters": CHAIN}),
    "ChainState.in_motion": (ChainState.in_motion, {"parameters": CHAIN}),
    "ChainState.keyed": (STATE.keyed, {"seed": 1, "replicate": 0}),
    "ChainState.moved": (STATE.moved, {}),
    "ChainState.under": (STATE.under, {"parameters": CHAIN}),
    "Grid": (Grid, {"n_blocks": 2, "belt_velocity": 5.0}),
    "Results.save": (RESULTS.save, {"path": "scan.csv"}),
    "PeriodicOrbit.run": (ORBIT.run, {}),
    "Run.plot": (RUN.plot, {"path": "run.png"}),
    "Run.load": (Run.load, {"path": "run.h5"}),
    "Results.load": (Results.load, {"path": "results.h5"}),
    "Run.save": (RUN.save, {"path": "run.h5"}),
    "analyse": (recording.analyse, {"time_s": TIME, "x_m": 1 + 0.1 * np.sin(TIME)}),
    "basins": (beltrepro.basins, SHORT),
    "catalogue": (beltrepro.catalogue, SHORT),
    "classify": (beltrepro.classify, LONG),
    "orbit_branch": (beltrepro.orbit_branch, {"orbit": ORBIT, "lower": 4.0, "upper": 6.0}),
    "lyapunov_spectrum": (beltrepro.lyapunov_spectrum, LONG),
    "mode_energies": (beltrepro.mode_energies, MOVING),
    "periodic_orbit": (beltrepro.periodic_orbit, LONG),
    "scan": (beltrepro.scan, SHORT),
    "Setup": (Setup, {"chains": CHAIN}),
    "simulate": (beltrepro.simulate, SHORT),
    "sliding_energy": (beltrepro.sliding_energy, MOVING),
    "slipping_state": (beltrepro.slipping_state, {"parameters": CHAIN, "energy": 9.0}),
    "time_to_continuous_slip": (beltrepro.time_to_continuous_slip, SHORT),
    "time_to_orbit": (beltrepro.time_to_orbit, SHORT),
}
KEYWORDS = [
    parameter
    for parameter in inspect.signature(Setup).parameters.values()
    if parameter.name != "chains"
]


def parameters_of(called):
    """The arguments of a function, with those of a setup if it takes them."""
    chosen = list(inspect.signature(called).parameters.values())
    return chosen[:-1] + KEYWORDS if chosen[-1].kind is chosen[-1].VAR_KEYWORD else chosen


ARGUMENTS = {
    (name, parameter.name): parameter
    for name, (called, _) in CALLS.items()
    for parameter in parameters_of(called)
}


def refusal(name: str, **changes: object) -> str:
    """The line with which a call with some other arguments is refused."""
    called, valid = CALLS[name]
    with pytest.raises((InputError, NotEnoughDataError)) as caught:
        called(**valid | changes)
    return line(caught.value)


def test_every_public_function_is_called():
    rooms = (beltrepro, simulation, chaos)
    public = {name: getattr(room, name) for room in rooms for name in room.__all__}
    result = {"ChainParameters", "Grid", "Setup", "analyse"}
    for name, one in public.items():
        if inspect.isclass(one):  # made by functions, so that only methods are called
            result |= {
                f"{name}.{method}"
                for method, function in inspect.getmembers(one, callable)
                if method[0] != "_" and "\nParameters\n" in inspect.cleandoc(function.__doc__ or "")
            }
        elif callable(one):
            result.add(name)
    assert result == set(CALLS)


@pytest.mark.parametrize("name", CALLS)
def test_wrong_value_of_each_argument_is_refused(name):
    for (called, argument), parameter in ARGUMENTS.items():
        if called != name:
            continue
        for what, value in wrong_values(parameter).items():
            message = refusal(name, **{argument: value})
            assert argument in message, (what, message)


def test_many_wrong_values_are_tried():
    assert sum(len(wrong_values(one)) for one in ARGUMENTS.values()) > 3000


@pytest.mark.parametrize("name", CALLS)
def test_misspelt_and_missing_arguments_are_named(name):
    called, valid = CALLS[name]
    for parameter in parameters_of(called):
        argument = parameter.name
        message = refusal(name, **{argument[:-1]: 1})
        assert f"{argument[:-1]!r}" in message and repr(argument) in message
        if parameter.default is inspect.Parameter.empty:
            rest = {key: value for key, value in valid.items() if key != argument}
            with pytest.raises(InputError) as caught:
                called(**rest)
            line(caught.value, repr(argument), "missing")


@pytest.mark.parametrize(
    "name", ["simulate", "scan", "catalogue", "classify", "lyapunov_spectrum", "periodic_orbit"]
)
def test_numbers_without_a_name_are_told_how_to_write_them(name):
    with pytest.raises(InputError) as caught:
        CALLS[name][0](CHAIN, 1000, 300)
    line(caught.value, f"{name}: write duration=1000, transient=300")


def test_symbols_of_the_paper_are_understood():
    for symbol, name in names.SYMBOLS.items():
        assert names.hint(symbol, [name, "other"]) == f"; did you mean {name!r}?"
    for quantity in QUANTITIES.values():
        symbol = (quantity.symbol or "").replace(" ", "_")
        assert names.SYMBOLS.get(symbol, quantity.name) == quantity.name
    with pytest.raises(InputError, match="no argument 'N'; did you mean 'n_blocks'"):
        ChainParameters(N=5, u=20)


def test_a_call_keeps_its_signature_and_errors_of_its_own():
    @names.checked
    def add(one: int, two: int = 2) -> int:
        return one + two

    assert str(inspect.signature(add)) == "(one: int, two: int = 2) -> int"
    assert add(1) == 3
    with pytest.raises(TypeError, match="concatenate"):
        add("1", two=2)
    with pytest.raises(InputError, match="too many positional arguments"):
        add(1, 2, 3)


# --- the command ----------------------------------------------------------------------------------

COMMANDS = next(
    action.choices
    for action in cli.parser()._actions
    if isinstance(action, argparse._SubParsersAction)
)
RUNS = {"n_blocks": 2, "belt_velocity": 5, "duration": 20}
GIVEN = {command: {} for command in COMMANDS} | {"simulate": RUNS, "classify": RUNS, "scan": RUNS}
GIVEN |= {"branch": RUNS | {"transient": 10, "lower": 4, "upper": 6}}
GIVEN |= {"watch": RUNS | {"output": "film.mp4", "duration": 1}}
GIVEN |= {"film": RUNS | {"output": "film.mp4"}, "track": {"output": "track.csv"}}
FILES = {"track": ["film.mp4"], "analyse": ["track.csv"], "plot": ["run.h5"]}
FILES |= {"verify": ["results"], "publish": ["results"]}
# Commands whose numbers are checked before a file is read, and are all 0 or greater.
NUMERIC = ("simulate", "scan", "classify", "branch", "watch")


def options(command: str) -> dict[str, argparse.Action]:
    results = [one for one in COMMANDS[command]._actions if one.option_strings and one.nargs != 0]
    return {one.dest: one for one in results}


def said(capsys, command: str, arguments: dict, *more: str) -> str:
    """The one line of a command that refuses."""
    words = [f"--{name.replace('_', '-')}={value}" for name, value in arguments.items()]
    try:
        status = cli.main([command, *FILES.get(command, []), *words, *more])
    except SystemExit as ended:
        status = ended.code
    out, err = capsys.readouterr()
    assert status == 2 and not out, (command, arguments, err)
    return line(err.removesuffix("\n"), "error: ")


@pytest.mark.thorough
@pytest.mark.parametrize("command", COMMANDS)
def test_wrong_value_of_each_option_is_refused(capsys, monkeypatch, tmp_path, command):
    monkeypatch.chdir(tmp_path)
    for name, action in options(command).items():
        numbers = (int, float, whole_grid, grid)
        values = ["much", ""] if action.type in numbers else []
        values += ["1:2", "1:2:0", "2:1:1", "1,,2"] if action.type in (whole_grid, grid) else []
        values += ["1.5"] if action.type in (int, whole_grid) else []
        values += ["nan", "-1"] if values and command in NUMERIC else []
        values += (
            ["inf", "1e999"] if values and command in NUMERIC and name not in MEANINGFUL else []
        )
        values += ["no/such/folder/file"] if name == "output" else []
        values += ["much"] if name in ("method", "only") else []
        for value in values:
            message = said(capsys, command, GIVEN[command] | {name: value})
            assert name in message.replace("-", "_"), message
            assert value != "much" or "is needed" in message or "allowed are" in message
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", COMMANDS)
def test_misspelt_and_missing_options_are_named(capsys, command):
    for name, action in options(command).items():
        values = {key: value for key, value in GIVEN[command].items() if key != name}
        option = f"--{name.replace('_', '-')}"
        assert f"did you mean {option!r}" in said(capsys, command, values, f"{option}x=1")
        if action.required:
            assert option in said(capsys, command, values)
    said(capsys, command, GIVEN[command], "--", "one", "more")


def test_output_is_refused_before_anything_is_computed(capsys, tmp_path):
    assert "is a folder" in said(capsys, "simulate", RUNS | {"output": tmp_path})
    assert "no such file" in said(capsys, "simulate", RUNS | {"from_state": tmp_path / "no.h5"})


def test_unknown_command_is_refused(capsys):
    for words in (["simulat"], [], ["--verson"]):
        with pytest.raises(SystemExit):
            cli.main(words)
        line(capsys.readouterr().err.removesuffix("\n"), "error: ")
