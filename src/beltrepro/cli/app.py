"""The command `beltrepro`: single runs without the workflow, and what goes with it."""

import argparse
import os
import sys
import warnings
from importlib import import_module

from beltrepro import __version__
from beltrepro.base.errors import InputError, ModelStateError, needing
from beltrepro.cli.options import Parser

# modules, in the order of the help
COMMANDS = (
    *("simulate", "scan", "plot", "classify", "film", "track", "analyse", "watch"),
    *("verify", "claims"),
)


def main(arguments: list[str] | None = None) -> int:
    """Run the command."""
    options = parser().parse_args(arguments)
    try:
        with needing(f"beltrepro {options.command}"), warnings.catch_warnings(record=True) as heard:
            status = options.action(options)
        for warning in heard:  # not before, as what is refused gets one line
            print(f"warning: {warning.message}", file=sys.stderr)
        sys.stdout.flush()
        return status or 0
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # What is still to be written at the exit must find a reader.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except (ModelStateError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


def parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    whole = Parser(
        prog="beltrepro", description="Chaos on the conveyor belt: simulate chains of blocks."
    )
    whole.add_argument("--version", action="version", version=f"beltrepro {__version__}")
    commands = whole.add_subparsers(required=True, dest="command", metavar="COMMAND")
    for name in COMMANDS:
        import_module(f"beltrepro.cli.{name}").add(commands)
    return whole


if __name__ == "__main__":
    sys.exit(main())
