"""What the commands share: options of a chain, grids, files to write, how a result is printed."""

import argparse
import inspect
import json
import math
import os
import re
import sys
from collections.abc import Callable
from dataclasses import MISSING, Field, fields
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn

from beltrepro import ChainParameters
from beltrepro.base.checks import shown, spaced
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint, left
from beltrepro.base.progress import Progress

CHAIN = tuple(parameter.name for parameter in fields(ChainParameters))
LAW = CHAIN[3:]  # what is left after number of blocks, belt velocity and noise
NUMERICS = ("duration", "transient", "method", "time_step", "tolerance")
JSON = "print the result as JSON"
UNITS = """\
All numbers are in model units: mass 0.1158 kg, spring constant 19.8 N/m, length 1.4 mm; so one unit
of time is 0.0765 s, of velocity 0.0183 m/s, of force 0.0277 N. A paper-length run has duration 2e6
and transient 1e6."""


class Parser(argparse.ArgumentParser):
    """A parser that says in one line what is wrong, and takes no shortened options."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, **settings)
        self.register("type", float, _number)
        self.register("type", int, _whole_number)

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


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        many = "; `beltrepro scan` takes lists and ranges" if set(text) & set(",:") else ""
        raise argparse.ArgumentTypeError(f"{shown(text)}: a number is needed{many}") from None


def _whole_number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{shown(text)}: a whole number is needed") from None


def grid(text: str) -> tuple[float, ...]:
    """Numbers of an option: one, a list 1,2,5, or a range 1:50:1 with both ends."""
    return tuple(number for part in text.split(",") for number in _part(text, part))


def whole_grid(text: str) -> tuple[int, ...]:
    """As `grid`, for whole numbers."""
    numbers = grid(text)
    if not all(number % 1 == 0 for number in numbers):
        raise argparse.ArgumentTypeError(f"{shown(text)}: whole numbers are needed")
    return tuple(int(number) for number in numbers)


def _part(text: str, part: str) -> tuple[float, ...]:
    """Numbers between two commas."""
    try:
        numbers = tuple(float(word) for word in part.split(":"))
        if len(numbers) == 1 or (len(numbers) == 3 and all(map(math.isfinite, numbers))):
            return numbers if len(numbers) == 1 else spaced(part, *numbers)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(
        f"{shown(text)}: a number, a list 1,2,5 or a range START:STOP:STEP is needed"
    )


def command(
    commands: Any,
    run: Callable[[argparse.Namespace], int | None],
    words: str,
    description: str,
    epilog: str | None = None,
) -> argparse.ArgumentParser:
    """Add the command of the module in which `run` stands, by its name."""
    name = run.__module__.rpartition(".")[2]
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=words, description=description, epilog=epilog
    )
    parser.set_defaults(action=run)
    return parser


def add_run(
    parser: argparse.ArgumentParser, *, seed: int | None = None, replicate: int | None = None
) -> None:
    """Options of a command that follows one chain."""
    add_chain(parser)
    add_numerics(parser)
    option = parser.add_argument
    option("--seed", type=int, default=seed, help="fixes the random numbers; 1 if not given")
    words = "number of the repetition; another one has other random numbers; 0 if not given"
    option("--replicate", type=int, default=replicate, help=words)
    option("--json", action="store_true", help=JSON)


def add_numerics(parser: argparse.ArgumentParser) -> None:
    """Options that say how long a chain is followed, and by what means."""
    option = parser.add_argument
    option("--duration", type=float, required=True, help="time simulated, transient included")
    option("--transient", type=float, default=0.0, help="time left out of what is measured (0)")
    words = "event (exact) or verlet (the scheme of the paper); default: event"
    option("--method", default="event", help=words)
    option("--time-step", type=float, default=0.001, help="dt (paper: 0.001)")
    words = "error allowed in a step of event (1e-10, larger with noise)"
    option("--tolerance", type=float, help=words)


def add_spread(parser: argparse.ArgumentParser) -> None:
    """Option of the random part of the start."""
    words = "standard deviation of random displacements of the blocks at the start (0); "
    words += "replicate 0 has none"
    parser.add_argument("--initial-spread", type=float, default=0.0, help=words)


def add_chain(
    parser: argparse.ArgumentParser,
    whole: Callable[[str], Any] = int,
    number: Callable[[str], Any] = float,
) -> None:
    """Options that say which chain, with the words of `ChainParameters`."""
    law = parser.add_argument_group("law of springs and friction, as in the paper if not given")
    text = inspect.getdoc(ChainParameters) or ""
    words = dict(re.findall(r"^(\w+) : .*\n    (.+)\.$", text, re.M))
    # what only Python takes
    words = {name: one.replace(", per block", "").replace("`math.inf`", "inf")
             for name, one in words.items()}  # fmt: skip
    for parameter in fields(ChainParameters):
        group = law if parameter.name in LAW else parser
        kind = whole if parameter.name == "n_blocks" else number
        add_field(group, parameter, words.get(parameter.name, ""), kind)


def add_field(group: Any, setting: Field, words: str, kind: Any = None) -> None:
    """The option of a field of a dataclass, in a parser or a group of it."""
    option = group.add_argument
    name = f"--{setting.name.replace('_', '-')}"
    kind = kind or (int if isinstance(setting.default, int) else float)
    if setting.default is MISSING:
        option(name, type=kind, required=True, help=words)
    elif setting.default is None:
        option(name, type=kind, help=words)
    else:  # as text, so that a list of one is made of it where lists are taken
        default = f"{setting.default:g}"
        end = "" if default in words else f" ({default})"
        option(name, type=kind, default=default, help=words.rstrip(".") + end)


def add_output(parser: argparse.ArgumentParser, words: str, **settings: Any) -> None:
    """Options that name a file to write."""
    option = parser.add_argument
    option("--output", type=Path, metavar="FILE", help=words, **settings)
    option("--force", action="store_true", help="overwrite the file of --output")


def chain_of(options: argparse.Namespace) -> ChainParameters:
    """The chain that the options describe."""
    return ChainParameters(**{name: getattr(options, name) for name in CHAIN})


def of_chain(chain: ChainParameters) -> dict[str, Any]:
    """Quantities of a chain as they are printed: constants of the law where they are not usual."""
    return {
        field.name: value
        for field in fields(chain)
        if (value := getattr(chain, field.name)) != field.default or field.name not in LAW
    }


def settings_of(options: argparse.Namespace) -> dict[str, Any]:
    """How a chain is followed."""
    settings = {name: getattr(options, name) for name in (*NUMERICS, "seed", "replicate")}
    return settings | {"progress": progress_of(chain_of(options).describe())}


def progress_of(label: str) -> Progress | None:
    """A bar, where somebody can see it."""
    return Progress(label) if sys.stderr.isatty() else None


def print_result(result: dict, as_json: bool) -> None:
    """Print a result, a line for each value."""
    if as_json:
        plain = {name: None if value != value else value for name, value in result.items()}
        print(json.dumps(plain, indent=2))
        return
    width = max(map(len, result))
    for name, value in result.items():
        shown = f"{value:.6g}" if isinstance(value, float) else value
        print(f"{name:<{width}}  {shown}")


def check_output(options: argparse.Namespace, *suffixes: str) -> None:
    """Refuse a file that cannot be written, or is there already, before anything is computed."""
    path: Path | None = options.output
    if path is None:
        return
    folder = path.absolute().parent
    problems = {
        "is a folder": path.is_dir(),
        "its folder does not exist": not folder.is_dir(),
        f"must end in {', '.join(suffixes)}": suffixes and path.suffix.lower() not in suffixes,
        "is there already; --force overwrites it": path.exists() and not options.force,
        "cannot be written": not os.access(path if path.exists() else folder, os.W_OK),
    }
    for problem, holds in problems.items():
        if holds:
            raise InputError(f"output = {path}: {problem}")
