"""What the commands share: options of a chain, grids, files to write, how a result is printed."""

import argparse
import json
import math
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import fields
from itertools import takewhile
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, NoReturn

from beltrepro import ChainParameters
from beltrepro.base.checks import shown, spaced
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint
from beltrepro.base.progress import Progress

LAW: dict[str, Any] = {field.name: field.default for field in fields(ChainParameters)[3:]}
"""Constants of springs and friction, as in the paper."""


class Parser(argparse.ArgumentParser):
    """A parser that says in one line what is wrong, and takes no shortened options."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, **settings)
        self.register("type", float, _number)
        self.register("type", int, _whole_number)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As of `ArgumentParser`, but a misspelt option is an error here, before a missing one."""
        args = sys.argv[1:] if args is None else list(args)
        own: Iterable[str] = args
        if self._subparsers is not None:  # the rest is for the parser of a command
            own = takewhile(lambda word: word.startswith("-"), args)
        for word in takewhile(lambda word: word != "--", own):
            name = word.partition("=")[0]
            if name.startswith("--") and name not in self._option_string_actions:
                self.error(f"{name}: no such option{hint(name, self._option_string_actions)}")
        options, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"{unknown[0]}: not understood, options are given as --NAME VALUE")
        return options, unknown

    def error(self, message: str) -> NoReturn:
        """End with one line on stderr, and status 2."""
        said = message.removeprefix("argument ")
        self.exit(2, f"error: {said}; see {self.prog} --help\n")


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
    except ValueError:
        numbers = ()
    if len(numbers) not in (1, 3) or not all(map(math.isfinite, numbers)):
        raise argparse.ArgumentTypeError(
            f"{shown(text)}: a number, a list 1,2,5 or a range START:STOP:STEP is needed"
        )
    if len(numbers) == 1:
        return numbers
    try:
        return spaced(part, *numbers)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def add_run(command: argparse.ArgumentParser) -> None:
    """Options of a command that follows one chain."""
    add_chain(command)
    add_numerics(command)
    add = command.add_argument
    add("--seed", type=int, help="fixes the random numbers; 1 if not given")
    add("--replicate", type=int, help="another one has other random numbers; 0 if not given")
    add("--json", action="store_true", help="print the result as JSON")


def add_numerics(command: argparse.ArgumentParser) -> None:
    """Options that say how long a chain is followed, and by what means."""
    add = command.add_argument
    add("--duration", type=float, required=True, help="time simulated, transient included")
    add("--transient", type=float, default=0.0, help="time left out of what is measured")
    add("--method", default="event", help="event, exact, or verlet, the paper's scheme (event)")
    add("--time-step", type=float, default=0.001, help="dt (paper: 0.001)")
    add(
        "--tolerance",
        type=float,
        help="truncation allowed in a step of event (its own: 1e-10, more with noise)",
    )


def add_chain(
    command: argparse.ArgumentParser,
    whole: Callable[[str], Any] = int,
    number: Callable[[str], Any] = float,
) -> None:
    """Options that say which chain."""
    add = command.add_argument
    add("--n-blocks", type=whole, required=True, help="number of blocks N")
    add("--belt-velocity", type=number, required=True, help="belt velocity u, units of 0.0183 m/s")
    add("--noise", type=number, default="0", help="noise strength sigma, units of 0.0277 N")
    law = command.add_argument_group("law of springs and friction, as in the paper if not given")
    words = dict(re.findall(r"^    (\w+) : float\n +(.+)\.$", str(ChainParameters.__doc__), re.M))
    for name, value in LAW.items():
        law.add_argument(_option(name), type=number, default=f"{value:g}", help=words[name])


def add_output(command: argparse.ArgumentParser, words: str, **settings: Any) -> None:
    """Options that name a file to write."""
    command.add_argument("--output", type=Path, metavar="FILE", help=words, **settings)
    command.add_argument("--force", action="store_true", help="overwrite the file of --output")


def chain_of(options: argparse.Namespace) -> ChainParameters:
    """The chain that the options describe."""
    names = [each.name for each in fields(ChainParameters)]
    return ChainParameters(**{name: getattr(options, name) for name in names})


def own_constants(chain: ChainParameters) -> dict[str, float]:
    """Constants of the law that differ from those of the paper."""
    return {name: getattr(chain, name) for name in LAW if getattr(chain, name) != LAW[name]}


def numerics(options: argparse.Namespace) -> dict[str, Any]:
    """How a chain is followed."""
    names = ("duration", "transient", "method", "time_step", "tolerance", "seed", "replicate")
    progress = progress_of(chain_of(options).describe())
    return {name: getattr(options, name) for name in names} | {"progress": progress}


def progress_of(label: str) -> Progress | None:
    """A bar, where somebody can see it."""
    return Progress(label) if sys.stderr.isatty() else None


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def print_result(result: dict, as_json: bool) -> None:
    """Print a result, a line for each value."""
    if as_json:
        known = {name: None if value != value else value for name, value in result.items()}
        print(json.dumps(known, indent=2))
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
    if path.is_dir() or not folder.is_dir():
        problem = "is a folder" if path.is_dir() else "its folder does not exist"
        raise InputError(f"output = {path}: {problem}")
    if suffixes and path.suffix.lower() not in suffixes:
        raise InputError(f"output = {path}: must end in {', '.join(suffixes)}")
    if path.exists() and not options.force:
        raise InputError(f"output = {path}: is there already; --force overwrites it")
    try:
        if path.exists():
            path.open("ab").close()
        else:
            TemporaryFile(dir=folder).close()
    except OSError as error:
        raise InputError(f"output = {path}: cannot be written: {error.strerror}") from None
