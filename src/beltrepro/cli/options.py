"""What the commands share: the parser, their options as tables, how a result is printed."""

import argparse
import inspect
import json
import math
import os
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import MISSING, Field, fields
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn

from beltrepro import ChainParameters, __version__
from beltrepro.base import checks
from beltrepro.base.checks import shown, spaced
from beltrepro.base.errors import InputError
from beltrepro.base.names import hint, left, one_of
from beltrepro.base.progress import Progress
from beltrepro.model.parameters import PER_BLOCK

CHAIN = tuple(constant.name for constant in fields(ChainParameters))
UNITS = """\
All numbers are in model units: mass 0.1158 kg, spring constant 19.8 N/m, length 1.4 mm; so one unit
of time is 0.0765 s, of velocity 0.0183 m/s, of force 0.0277 N. A paper-length run has duration 2e6
and transient 1e6."""
REQUIRED, PLACED = object(), object()  # defaults: an option that must be there, one without a name

# Options: name, type, default, words.
JSON = ("json", bool, False, 'print JSON: all digits, infinity as "Infinity", NaN as null')
NUMERICS = (
    ("duration", float, REQUIRED, "time simulated, transient included"),
    ("transient", float, 0.0, "time left out of what is measured (0)"),
    ("method", str, "event", "event, exact, or verlet, the scheme of the paper (event)"),
    ("time_step", float, 0.001, "dt (paper: 0.001)"),
    ("tolerance", float, None, "error allowed in a step of event (1e-10, larger with noise)"),
)
SEED = ("seed", int, 1, "fixes the random numbers (1)")
REPLICATE = ("replicate", int, 0, "number of the repetition, with other random numbers (0)")
ONE_CHAIN = (*NUMERICS, SEED, REPLICATE)  # how one chain is followed
_WORDS = "standard deviation of random displacements at the start, but of replicate 0 (0)"
SPREAD = ("initial_spread", float, 0.0, _WORDS)


class Parser(argparse.ArgumentParser):
    """A parser that says in one line what is wrong, and takes no shortened options."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, **settings)
        for kind, words in ((float, "a number"), (int, "a whole number")):
            self.register("type", kind, partial(_number, kind, words))

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As of `ArgumentParser`, but a misspelt word is an error here, before a missing one."""
        args = sys.argv[1:] if args is None else list(args)
        words = [word.partition("=")[0] for word in takewhile(lambda word: word != "--", args)]
        if self is PARSER:
            words = words[:1]  # the rest is for a command
            for name in words:
                if left(name):
                    raise InputError(left(name))
                if not name.startswith("-"):
                    one_of("command", name, COMMANDS.choices)
        flags = [word for word in words if word.startswith("--")]
        for name in flags:
            if name not in self._option_string_actions:
                self.error(f"{name}: no such option{hint(name, self._option_string_actions)}")
            if flags.count(name) > 1:  # the last one alone would count
                self.error(f"{name}: given {flags.count(name)} times")
        return super().parse_known_args(args, namespace)

    def _print_message(self, message: str, file: Any = None) -> None:
        print(message, end="", file=file, flush=True)  # the usual one hides that it cannot

    def error(self, message: str) -> NoReturn:
        """Say it in one line."""
        raise InputError(f"{message.removeprefix('argument ')}; see {self.prog} --help")


def _number(kind: Callable[[str], Any], words: str, text: str) -> Any:
    """The number that a text is; one line says if it is none."""
    try:
        return kind(text)
    except ValueError:
        many = "; `beltrepro scan` takes lists and ranges" if set(text) & set(",:") else ""
        raise argparse.ArgumentTypeError(f"{shown(text)}: {words} is needed{many}") from None


PARSER = Parser(
    prog="beltrepro", description="Chaos on the conveyor belt: simulate chains of blocks."
)
PARSER.add_argument("--version", action="version", version=f"beltrepro {__version__}")
COMMANDS = PARSER.add_subparsers(required=True, metavar="COMMAND")


def command(*options: Any, epilog: str = "", suffixes: tuple[str, ...] = ()) -> Callable:
    """Decorate a function of the options that becomes a command; its docstring is the help.

    options : each a row of a table; a text alone is the title of those that follow.
    suffixes : of the file of --output.
    """

    def add(run: Callable[[argparse.Namespace], int | None]) -> Callable:
        text = inspect.getdoc(run) or ""
        first = text.partition(".")[0]
        words: Any = {"help": first[:1].lower() + first[1:], "description": text, "epilog": epilog}
        group: Any = COMMANDS.add_parser(run.__name__, **words)
        group.set_defaults(command=run, suffixes=suffixes)
        parser = group
        for option in options:
            if isinstance(option, str):
                group = parser.add_argument_group(option)
            else:
                _add_option(group, *option)
        if suffixes:
            _add_option(parser, "force", bool, False, "overwrite the file of --output")
        return run

    return add


def _add_option(group: Any, name: str, kind: Any, default: Any, words: str) -> None:
    flag = f"--{name.replace('_', '-')}"
    if kind is bool:
        group.add_argument(flag, action="store_true", help=words)
    elif default is PLACED:
        group.add_argument(name, type=kind, help=words)
    else:
        how = {"required": True} if default is REQUIRED else {"default": default}
        metavar = "FILE" if kind is Path else None
        group.add_argument(flag, type=kind, metavar=metavar, help=words, **how)


def chain_options(kind: Callable[..., Any] | None = None) -> list:
    """Which chain, with the words of `ChainParameters`; the law last.

    kind : of all values; if not given each is a number, and some may be one for each block.
    """
    text = inspect.getdoc(ChainParameters) or ""
    blocks = "" if kind else ", one or N with commas"
    for python, here in ((", per block", blocks), (", per spring", blocks)):
        text = text.replace(python, here)
    for python in ("math.", "`"):  # what only Python takes
        text = text.replace(python, "")
    words = dict(re.findall(r"^(\w+) : .*\n    (.+)\.$", text, re.M))
    kinds = dict.fromkeys(PER_BLOCK, partial(kind, of_blocks=True) if kind else by_block)
    rows = [
        field_option(one, words.get(one.name, ""), kinds.get(one.name, kind))
        for one in fields(ChainParameters)
    ]
    return [*rows[:3], "law of springs and friction, as in the paper if not given", *rows[3:]]


def field_option(setting: Field, words: str, kind: Any = None) -> tuple:
    """The option of a field of a dataclass."""
    default = REQUIRED if setting.default is MISSING else setting.default
    if isinstance(default, int | float) and f"{default:g}" not in words:
        words = f"{words} ({default:g})"
    is_whole = setting.type is int or isinstance(default, int)
    return setting.name, kind or (int if is_whole else float), default, words


def by_block(text: str) -> float | tuple[float, ...]:
    """A number of an option, or as 1,3,1 one for each block."""
    first, *others = (_number(float, "a number", part) for part in text.split(","))
    return (first, *others) if others else first


_DIFFER = "a list is an axis; blocks that differ: `beltrepro simulate` or Python"


def grid(text: str, of_blocks: bool = False) -> Sequence[float]:
    """Numbers of an option: one, a list 1,2,5, or a range 1:50:1, the end too if a step meets it.

    of_blocks : whether each block can have one of its own; a list is a tuple then.
    """
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
    if len(set(numbers)) < len(numbers):
        words = "the same value occurs twice"
        words = f"{_DIFFER}; {words}" if of_blocks else f"{words}; --replicates 2 makes two runs"
        raise argparse.ArgumentTypeError(f"{shown(text)}: {words}")
    return tuple(numbers) if of_blocks and ":" not in text else numbers


def check_axes(options: argparse.Namespace) -> None:
    """Refuse lists that can be meant as the numbers of the blocks of one chain."""
    for name in PER_BLOCK:
        if isinstance(numbers := getattr(options, name), tuple):
            if options.n_blocks == [len(numbers)] != [1]:
                text = ",".join(f"{number:g}" for number in numbers)
                raise InputError(f"{name} = {text}: as many as blocks; {_DIFFER}")
            setattr(options, name, list(numbers))


def values(options: Any, *names: str) -> dict[str, Any]:
    """Some of the options, or other attributes, by name."""
    return {name: getattr(options, name) for name in names}


def chain_of(options: argparse.Namespace) -> ChainParameters:
    """The chain that the options describe."""
    return ChainParameters(**values(options, *CHAIN))


def settings_of(options: argparse.Namespace) -> dict[str, Any]:
    """How one chain is followed."""
    return values(options, *(name for name, *_ in ONE_CHAIN))


def progress_of(label: str) -> Progress | None:
    """A bar, where somebody can see it."""
    return Progress(label) if sys.stderr.isatty() else None


def print_result(result: dict, as_json: bool, chain: ChainParameters | None = None) -> None:
    """Print a result, a line for each value; of a law what is not as in the paper."""
    if chain is not None:
        about = values(chain, *CHAIN)
        usual = {one.name: one.default for one in fields(ChainParameters)[3:]}
        result = {n: now for n, now in about.items() if now != usual.get(n)} | result
    if as_json:
        print_json(result)
        return
    width = max(map(len, result))
    for name, value in result.items():
        print(f"{name:<{width}}  {f'{value:.6g}' if isinstance(value, float) else value}")


def print_json(value: Any) -> None:
    """Print numbers with all digits; JSON has no infinity and no NaN, see `JSON`."""
    print(json.dumps(_plain(value), indent=2))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(part) for name, part in value.items()}
    if isinstance(value, list):
        return [_plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        # pandas, JavaScript and Python make the number of this text
        return None if math.isnan(value) else str(value).replace("inf", "Infinity")
    return value


def only_with_output(options: argparse.Namespace, name: str) -> None:
    """Refuse an option that a file alone has, as it would do nothing."""
    value = getattr(options, name)
    if value is not None and options.output is None:
        raise InputError(f"{name} = {value:g}: only a file has one, give --output too")


def check_output(path: Path | None, force: bool, suffixes: tuple[str, ...]) -> None:
    """Refuse a file that cannot be written, or is there already, before anything is computed."""
    if path is None:
        return
    if not path.is_dir():
        checks.path("output", path, suffixes)
    try:
        folder = path.absolute().parent
    except FileNotFoundError:
        raise InputError(f"output = {path}: the working folder is not there any more") from None
    problems = {
        "is a folder": path.is_dir(),
        "its folder does not exist": not folder.is_dir(),
        "is there already; --force overwrites it": path.exists() and not force,
        "cannot be written": not os.access(path if path.exists() else folder, os.W_OK),
    }
    for problem, holds in problems.items():
        if holds:
            raise InputError(f"output = {path}: {problem}")
