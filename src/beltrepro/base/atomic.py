"""Files that appear whole or not at all, whatever happens to the process or the machine."""

import errno
import fcntl
import glob
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from beltrepro.base.errors import InputError

UNFINISHED = ".unfinished-"
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # disk, quota, limit of the process


@contextmanager
def replacing(path: str | os.PathLike) -> Iterator[Path]:
    """A file to write that takes its name when it is complete and on the disk."""
    path, unfinished = Path(path), begun(path)
    try:
        yield unfinished
        _flush(unfinished)
        unfinished.replace(path)
        _flush(path.parent)  # the new name too survives a power cut
    except OSError as error:
        if error.errno not in _NO_ROOM:
            raise
        remedy = "earlier results are as they were: make room and run the same command again"
        raise InputError(f"{path}: cannot be written ({error.strerror}); {remedy}") from None
    finally:
        unfinished.unlink(missing_ok=True)


def begun(path: str | os.PathLike) -> Path:
    """The file, empty, that will be this one; one line says if it cannot be written."""
    path = Path(path)
    # Of this process alone: a job outlives its killed Snakemake, and the next one writes beside it.
    unfinished = path.with_name(f"{UNFINISHED}{os.getpid()}-{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        unfinished.touch()
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    return unfinished


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Wait for other processes that change a file in here; what killed ones left of it goes."""
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        with suppress(OSError):  # NFS locks no folder
            fcntl.flock(folder, fcntl.LOCK_EX)  # ends with the process
            for unfinished in path.parent.glob(f"{UNFINISHED}*-{glob.escape(path.name)}"):
                writer, _, name = unfinished.name.removeprefix(UNFINISHED).partition("-")
                if name == path.name and writer.isdigit() and not _runs(int(writer)):
                    unfinished.unlink(missing_ok=True)
        yield
    finally:
        os.close(folder)


def _runs(process: int) -> bool:
    """Whether a process is alive."""
    try:
        os.kill(process, 0)
    except (OSError, OverflowError) as error:
        return isinstance(error, PermissionError)  # of somebody else
    return True


def look_for_room(path: Path, size: int) -> None:
    """Try whether a file has room, for libraries that end badly on a full disk as HDF5 does."""
    with path.open("wb") as file:
        if size and hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)
        file.truncate(0)


def clear(folder: Path) -> None:
    """Remove what killed processes have left half written."""
    for path in folder.rglob(f"{UNFINISHED}*"):
        path.unlink(missing_ok=True)


def _flush(path: Path) -> None:
    """Wait until a file or folder is on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
