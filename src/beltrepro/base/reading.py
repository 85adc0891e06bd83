"""Files that somebody gives: regular ones of bearable size; of any other, one line says why not."""

import math
import os
import stat
from io import BufferedReader
from pathlib import Path

from beltrepro.base.errors import InputError

MOST_TEXT = 100_000_000  # bytes that are read at once


def opened(path: str | os.PathLike, most: float = math.inf) -> BufferedReader:
    """A file open for reading."""
    path = Path(path)
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):  # a pipe or device may never end
            raise InputError(f"{path}: cannot be read: a folder, pipe or device, not a file")
        if status.st_size > most:
            sizes = f"{status.st_size / 1e6:.4g} MB, at most {most / 1e6:g} MB"
            raise InputError(f"{path}: too large: {sizes} are allowed")
        return path.open("rb")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None


def text(path: str | os.PathLike, most: float = MOST_TEXT) -> str:
    """The text of a file in UTF-8, without the mark that some editors set before it."""
    with opened(path, most) as file:
        content = file.read()
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None
