"""Files that somebody gives: regular ones of bearable size; of any other, one line says why not."""

import errno
import json
import math
import os
import stat
from io import BufferedReader
from typing import Any

from beltrepro.base.errors import InputError

MOST_TEXT = 100_000_000  # bytes that are read at once


def opened(path: str | os.PathLike, most: float = math.inf) -> BufferedReader:
    """A file open for reading; a pipe or a device, which may never end, is refused."""
    try:
        file = open(path, "rb", opener=_without_waiting)  # noqa: SIM115 (the caller closes it)
    except ValueError as error:  # of the name
        raise InputError(f"{path!r}: cannot be read ({error})") from None
    except OSError as error:
        is_missing = error.errno == errno.ENOENT
        reason = "no such file" if is_missing else f"cannot be read ({error.strerror})"
        raise InputError(f"{path}: {reason}") from None
    status = os.fstat(file.fileno())
    if not stat.S_ISREG(status.st_mode):
        file.close()
        raise InputError(f"{path}: cannot be read (a pipe or device): a file is needed")
    if status.st_size > most:
        file.close()
        sizes = f"{status.st_size / 1e6:.4g} MB, at most {most / 1e6:g} MB"
        raise InputError(f"{path}: too large: {sizes} are allowed")
    return file


def check(path: str | os.PathLike) -> None:
    """Refuse what is no file to be read, before a library opens it."""
    opened(path).close()


def text(path: str | os.PathLike, most: float = MOST_TEXT) -> str:
    """The text of a file in UTF-8, without the mark that some editors set before it."""
    with opened(path, most) as file:
        content = file.read()
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None


def json_object(path: str | os.PathLike) -> dict[str, Any]:
    """The keys and values of a JSON file."""
    try:
        content = json.loads(text(path))
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        reason = "nested too deeply" if isinstance(error, RecursionError) else error
        raise InputError(f"{path}: not JSON ({reason})") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: not a JSON object")
    return content


def _without_waiting(path: str, flags: int) -> int:
    """Open a pipe, too, at once: the plain way waits for a writer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
