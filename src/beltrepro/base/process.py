"""What a process inherits from whoever starts it, set right before anything else runs."""

import atexit
import io
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

# Variables that end jobs or imports, with the values at which they do not.
_ALLOWED = {
    # Of windows, as a user of `beltrepro watch` may choose one. A notebook sets a module that only
    # the notebook has, and what it starts inherits that.
    "MPLBACKEND": "(?i)(gtk|macosx|qt|tk|webagg|wx).*",
    "NUMBA_DISABLE_JIT": "0",
    "NUMBA_NUM_THREADS": r"[1-9]\d*",
    "PYTHONWARNINGS": "(default|ignore)",  # "error" ends whatever has something to say
    "SOURCE_DATE_EPOCH": r"\d{1,11}",  # a year that `datetime` knows
}
_CACHES = ("XDG_CACHE_HOME", "MPLCONFIGDIR")


def set_right() -> None:
    """Give this process and those it starts streams, variables and folders that can be used.

    Called first by the command `beltrepro` and by the workflow, before matplotlib and Numba are
    imported.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        stream = getattr(sys, name)
        if stream is None:  # it is closed, and the next file would have its number
            setattr(sys, name, os.fdopen(_nowhere(number), mode, encoding="utf-8"))
        elif name == "stdout" and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")  # a letter that the terminal lacks
    for name, allowed in _ALLOWED.items():
        if not re.fullmatch(allowed, os.environ.get(name, "")):
            os.environ.pop(name, None)
    if not _has_cache():
        folder = tempfile.mkdtemp(prefix="beltrepro-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        os.environ.update(dict.fromkeys(_CACHES, folder))


class Closed(io.TextIOBase):
    """A standard output that is closed: to print there fails, as it does on a full disk."""

    def write(self, text: str) -> int:
        raise OSError("standard output is closed: nothing can be printed")


def _nowhere(number: int) -> int:
    """A stream of this number that takes all and gives nothing; another one if it is in use."""
    opened = os.open(os.devnull, os.O_RDWR)  # the lowest number that is free
    os.set_inheritable(opened, opened == number)
    return opened


def _has_cache() -> bool:
    """Whether Snakemake, matplotlib and Numba can write where they keep what helps them."""
    try:
        cache = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
        cache.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # somebody without a home
        return False
    return os.access(cache, os.W_OK)
