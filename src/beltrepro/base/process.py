"""What a process inherits from whoever starts it, set right before anything else runs."""

import os
import re
import sys

# Backends of matplotlib that open windows, as a user of `beltrepro watch` may choose them. Any
# other value is of a notebook, whose backend is a module that only the notebook has, or a slip.
_WINDOWS = re.compile("(gtk|macosx|qt|tk|webagg|wx)", re.IGNORECASE)


def set_right() -> None:
    """Give this process and those it starts streams and variables that the program can use.

    Called first by the command `beltrepro` and by the workflow, before matplotlib and Numba are
    imported. A stream that is closed goes nowhere: its number would be that of the next file.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, os.fdopen(_nowhere(number), mode, encoding="utf-8"))
        elif name == "stdout" and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a letter that the terminal lacks
    if not _WINDOWS.match(os.environ.get("MPLBACKEND", "")):
        os.environ.pop("MPLBACKEND", None)


def _nowhere(number: int) -> int:
    """A stream of this number that takes all and gives nothing; another one if it is in use."""
    opened = os.open(os.devnull, os.O_RDWR)  # the lowest number that is free
    os.set_inheritable(opened, opened == number)
    return opened
