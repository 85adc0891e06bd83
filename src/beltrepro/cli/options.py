"""What the commands share: their options as tables, the parser, how a result is printed."""

import argparse
import inspect
import json
import os
import re
import sys
from collections.abc import Callable
from dataclasses import MISSING, Field, fields
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from beltrepro import ChainParameters
from beltrepro.base.checks import shown, spaced
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint, left
from beltrepro.base.progress import Progress

CHAIN = tuple(parameter.name for parameter in fields(ChainParameters))
_LAW = CHAIN[3:]  # what is left after number of blocks, belt velocity and noise
UNITS = """\
All numbers are in model units: mass 0.1158 kg, spring constant 19.8 N/m, length 1.4 mm; so one unit
of time is 0.0765 s, of velocity 0.0183 m/s, of force 0.0277 N. A paper-length run has duration 2e6
and transient 1e6."""
REQUIRED, PLACED = object(), object()  # defaults: an option that must be there, one without a name

# Options: name, type, default, words. A text alone is the title of those that follow.
JSON = ("json", bool, False, "print the result as JSON")
NUMERICS = (
    ("duration", float, REQUIRED, "time simulated, transient included"),
    ("transient", float, 0.0, "time left out of what is measured (0)"),
    ("method", str, "event", "event, exact, or verlet, the scheme of the paper (event)"),
    ("time_step", float, 0.001, "dt (paper: 0.001)"),
    ("tolerance", float, None, "error allowed in a step of event (1e-10, larger with noise)"),
)
_WORDS = "standard deviation of random displacements at the start, but of replicate 0 (0)"
SPREAD = ("initial_spread", float, 0.0, _WORDS)


class Command(NamedTuple):
    """A function of the options: its name is that of the command, its docstring the help."""

    run: Callable[[argparse.Namespace], int | None]
    options: tuple
    epilog: str
    suffixes: tuple[str, ...]  # of the file of --output

    def add_to(self, commands: Any) -> None:
        """Add its parser."""
        text = inspect.getdoc(self.run) or ""
        first = text.partition(".")[0]
        words = {"help": first[:1].lower() + first[1:], "description": text, "epilog": self.epilog}
        group = parser = commands.add_parser(self.run.__name__, **words)
        for option in self.options:
            if isinstance(option, str):
                group = parser.add_argument_group(option)
            else:
                _add_option(group, *option)
        parser.set_defaults(command=self)


COMMANDS: list[Command] = []


def command(*options: Any, epilog: str = "", suffixes: tuple[str, ...] = ()) -> Callable:
    """Decorate a function that becomes a command with these options."""

    def add(run: Callable) -> Callable:
        COMMANDS.append(Command(run, options, epilog, suffixes))
        return run

    return add


def _add_option(group: Any, name: str, kind: Any, default: Any, words: str) -> None:
    flag = f"--{name.replace('_', '-')}"
    if kind is bool:
        group.add_argument(flag, action="store_true", help=words)
        return
    how: dict[str, Any] = {"type": kind, "metavar": "FILE" if kind is Path else None}
    if default is PLACED:
        group.add_argument(name, type=kind, help=words)
    elif default is REQUIRED:
        group.add_argument(flag, required=True, help=words, **how)
    else:
        group.add_argument(flag, default=default, help=words, **how)


def chain_options(whole: Callable[[str], Any] = int, number: Callable[[str], Any] = float) -> list:
    """Which chain, with the words of `ChainParameters`; the law last."""
    text = inspect.getdoc(ChainParameters) or ""
    for python in (", per block", ", per spring", "math.", "`"):  # what only Python takes
        text = text.replace(python, "")
    words = dict(re.findall(r"^(\w+) : .*\n    (.+)\.$", text, re.M))
    rows = [field_option(one, words.get(one.name, ""), number) for one in fields(ChainParameters)]
    rows[0] = (rows[0][0], whole, *rows[0][2:])  # the number of blocks
    return [*rows[:3], "law of springs and friction, as in the paper if not given", *rows[3:]]


def field_option(setting: Field, words: str, kind: Any = None) -> tuple:
    """The option of a field of a dataclass."""
    kind = kind or (int if isinstance(setting.default, int) else float)
    if setting.default is MISSING:
        return setting.name, kind, REQUIRED, words
    told = setting.default is None or f"{setting.default:g}" in words
    return setting.name, kind, setting.default, words if told else f"{words} ({setting.default:g})"


def keys(seed: int | None = 1, replicate: int | None = 0) -> tuple:
    """Options of the random numbers of one chain."""
    words = "number of the repetition, with other random numbers; 0 if not given"
    return (
        ("seed", int, seed, "fixes the random numbers; 1 if not given"),
        ("replicate", int, replicate, words),
    )


def output(words: str, default: Any = None) -> tuple:
    """Options that name a file to write."""
    force = ("force", bool, False, "overwrite the file of --output")
    return ("output", Path, default, words), force


class Parser(argparse.ArgumentParser):
    """A parser that says in one line what is wrong, and takes no shortened options."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, **settings)
        self.register("type", float, _number(float, "a number is needed"))
        self.register("type", int, _number(int, "a whole number is needed"))

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As of `ArgumentParser`, but a misspelt option is an error here, before a missing one."""
        args = sys.argv[1:] if args is None else list(args)
        words = args if self._subparsers is None else args[:1]  # the rest is for a command
        for word in takewhile(lambda word: word != "--", words):
            name = word.partition("=")[0]
            if name.startswith("--") and name not in self._option_string_actions:
                self.error(f"{name}: no such option{hint(name, self._option_string_actions)}")
            if self._subparsers is not None and left(name):
                self.error(left(name))
        options, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"{unknown[0]}: not understood, options are given as --NAME VALUE")
        return options, unknown

    def error(self, message: str) -> NoReturn:
        """End with one line on stderr, and status 2."""
        self.exit(2, f"error: {message.removeprefix('argument ')}; see {self.prog} --help\n")


def _number(kind: Callable[[str], Any], words: str) -> Callable[[str], Any]:
    """What makes a number of a text, or says in one line that it is none."""

    def number(text: str) -> Any:
        try:
            return kind(text)
        except ValueError:
            many = "; `beltrepro scan` takes lists and ranges" if set(text) & set(",:") else ""
            raise argparse.ArgumentTypeError(f"{shown(text)}: {words}{many}") from None

    return number


def grid(text: str) -> tuple[float, ...]:
    """Numbers of an option: one, a list 1,2,5, or a range 1:50:1 with both ends."""
    numbers: list[float] = []
    try:
        for part in text.split(","):
            number, *rest = map(float, part.split(":"))
            numbers += spaced(part, number, *rest) if rest else [number]
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    except (ValueError, TypeError):
        words = "a number, a list 1,2,5 or a range START:STOP:STEP is needed"
        raise argparse.ArgumentTypeError(f"{shown(text)}: {words}") from None
    return tuple(numbers)


def whole_grid(text: str) -> tuple[int, ...]:
    """As `grid`, for whole numbers."""
    numbers = grid(text)
    if any(number % 1 != 0 for number in numbers):
        raise argparse.ArgumentTypeError(f"{shown(text)}: whole numbers are needed")
    return tuple(map(int, numbers))


def values(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Some of the options by name."""
    return {name: getattr(options, name) for name in names}


def chain_of(options: argparse.Namespace) -> ChainParameters:
    """The chain that the options describe."""
    return ChainParameters(**values(options, *CHAIN))


def settings_of(options: argparse.Namespace) -> dict[str, Any]:
    """How a chain is followed."""
    return values(options, *(name for name, *_ in NUMERICS), "seed", "replicate")


def progress_of(label: str) -> Progress | None:
    """A bar, where somebody can see it."""
    return Progress(label) if sys.stderr.isatty() else None


def print_result(result: dict, as_json: bool, chain: ChainParameters | None = None) -> None:
    """Print a result, a line for each value; of a law what is not as in the paper."""
    if chain is not None:
        constants = {one.name: (getattr(chain, one.name), one.default) for one in fields(chain)}
        told = {n: now for n, (now, usual) in constants.items() if n not in _LAW or now != usual}
        result = told | result
    if as_json:
        plain = {name: None if value != value else value for name, value in result.items()}
        print(json.dumps(plain, indent=2))
        return
    width = max(map(len, result))
    for name, value in result.items():
        print(f"{name:<{width}}  {f'{value:.6g}' if isinstance(value, float) else value}")


def check_output(path: Path | None, force: bool, suffixes: tuple[str, ...] = ()) -> None:
    """Refuse a file that cannot be written, or is there already, before anything is computed."""
    if path is None:
        return
    folder = path.absolute().parent
    problems = {
        "is a folder": path.is_dir(),
        "its folder does not exist": not folder.is_dir(),
        f"must end in {', '.join(suffixes)}": suffixes and path.suffix.lower() not in suffixes,
        "is there already; --force overwrites it": path.exists() and not force,
        "cannot be written": not os.access(path if path.exists() else folder, os.W_OK),
    }
    for problem, holds in problems.items():
        if holds:
            raise InputError(f"output = {path}: {problem}")
