"""Files that appear whole or not at all, whatever happens to the process or the machine."""

import errno
import glob
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from beltrepro.base.errors import InputError

UNFINISHED = ".unfinished-"


@contextmanager
def replacing(path: str | os.PathLike) -> Iterator[Path]:
    """A file to write that takes its name when it is complete and on the disk."""
    path = Path(path)
    unfinished = path.with_name(f"{UNFINISHED}{os.getpid()}-{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for left in _left_by_the_dead(path):
            left.unlink(missing_ok=True)
        unfinished.touch()
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    except OSError as error:
        with suppress(OSError):
            unfinished.unlink()
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    try:
        yield unfinished
        _flush(unfinished)
        unfinished.replace(path)
        _flush(path.parent)  # the new name too survives a power cut
    except OSError as error:
        if not (reason := lack_of_room(error)):
            raise
        remedy = "earlier results are as they were: make room and run the same command again"
        raise InputError(f"{path}: cannot be written ({reason}); {remedy}") from None
    finally:
        unfinished.unlink(missing_ok=True)


def look_for_room(path: Path, size: int) -> None:
    """Try whether a file has room, for libraries that end badly on a full disk."""
    with path.open("wb") as file:
        if size and hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)
        file.truncate(0)


def clear(folder: Path) -> int:
    """Remove what killed processes have left half written."""
    left = list(folder.rglob(f"{UNFINISHED}*"))
    for path in left:
        path.unlink(missing_ok=True)
    return len(left)


def _left_by_the_dead(path: Path) -> Iterator[Path]:
    """What processes that were killed have left of a file."""
    for left in path.parent.glob(f"{UNFINISHED}*-{glob.escape(path.name)}"):
        process = left.name.removeprefix(UNFINISHED).removesuffix(f"-{path.name}")
        with suppress(PermissionError):  # it lives, and is another user's
            try:
                os.kill(int(process), 0)
            except ValueError:  # of another file whose name ends so
                continue
            except ProcessLookupError:
                yield left


def lack_of_room(error: OSError) -> str:
    """Why there was no room, if that is the error; HDF5 gives its number in the text only."""
    for code in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):  # disk, quota, limit of the process
        if error.errno == code or f"errno = {code}," in str(error):
            return os.strerror(code)
    return ""


def _flush(path: Path) -> None:
    """Wait until a file or folder is on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
