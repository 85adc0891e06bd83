"""The command `beltrepro`: single runs without the workflow, and what goes with it."""

import argparse
import os
import sys
import warnings

from beltrepro import __version__
from beltrepro.base.errors import InputError, ModelStateError, needing
from beltrepro.cli import chains, films, results  # noqa: F401 (they define the commands)
from beltrepro.cli.options import COMMANDS, Command, Parser, check_output


def main(arguments: list[str] | None = None) -> int:
    """Run the command."""
    options = parser().parse_args(arguments)
    command: Command = options.command
    name = f"beltrepro {command.run.__name__}"
    try:
        with needing(name), warnings.catch_warnings(record=True) as heard:
            if command.suffixes:
                check_output(options.output, options.force, command.suffixes)
            status = command.run(options)
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
    for command in COMMANDS:
        command.add_to(commands)
    return whole


if __name__ == "__main__":
    sys.exit(main())
