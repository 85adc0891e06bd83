"""The command `beltrepro`: single runs without the workflow, and what goes with it."""

import os
import sys
import warnings

from beltrepro.base import process
from beltrepro.base.errors import InputError, ModelStateError, needing
from beltrepro.cli import chains, films, results  # noqa: F401 (they define the commands)
from beltrepro.cli.options import PARSER, Parser, check_output


def main(arguments: list[str] | None = None) -> int:
    """Run the command."""
    is_closed = sys.stdout is None
    process.set_right()
    silent = sys.stdout
    if is_closed:
        sys.stdout = process.Closed()
    try:
        options = PARSER.parse_args(arguments)
        if getattr(options, "output", None):  # that file is what is wanted
            sys.stdout = silent
        name = f"beltrepro {options.command.__name__}"
        with needing(name, "replication"), warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("ignore")  # not as PYTHONWARNINGS says: "error" would end it
            for category in (UserWarning, RuntimeWarning):
                warnings.simplefilter("default", category)
            if options.suffixes:
                check_output(options.output, options.force, options.suffixes)
            status = options.command(options)
        for warning in heard:  # not before, as what is refused gets one line
            print(f"warning: {warning.message}", file=sys.stderr)
        sys.stdout.flush()
        return status or 0
    except OSError as error:
        # What is still to be written at the exit must find a reader.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        if isinstance(error, BrokenPipeError):
            return 141
        print(f"error: {error}", file=sys.stderr)
        return 1
    except (InputError, ModelStateError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2 if isinstance(error, InputError) else 1
    except MemoryError as error:
        print(f"error: too little memory: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


def parser() -> Parser:
    """The parser of all commands, for the documentation."""
    return PARSER


if __name__ == "__main__":
    sys.exit(main())
