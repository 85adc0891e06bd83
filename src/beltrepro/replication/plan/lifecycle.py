"""Runs of the workflow that begin, are stopped or are killed, and their jobs.

A run may end at any instant: files appear whole (`beltrepro.base.atomic`), and the lock on the
folder of its results ends with its process. So to stop means to end at once, and to go
on means to run the same command again.
"""

import atexit
import errno
import fcntl
import logging
import os
import select
import signal
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

from beltrepro.base import atomic
from beltrepro.base.errors import InputError

LOCK = ".lock"
FOLDERS = ("batches", "benchmarks", "datasets", "experiment", "figures", "logs", "tables")
PARENT = "BELTREPRO_PARENT"  # environment of jobs: process that they must not outlive
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# What Snakemake starts jobs with: Ctrl-C goes to Snakemake alone, which ends them.
JOB_PREFIX = "set -euo pipefail; trap '' INT; "
_PATIENCE = 0.5  # seconds, for another process that only looks whether a folder is locked
_SKEW = 60.0  # seconds by which clocks of machines may differ
_GRACE = 3.0  # seconds that jobs have to end

_held: dict[Path, int] = {}


def is_locked(results: Path) -> bool:
    """Whether a run of the workflow is at work on a folder of results."""
    try:
        descriptor = os.open(results / LOCK, os.O_RDONLY)  # results may be there to be read only
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return isinstance(error, BlockingIOError)
    finally:
        os.close(descriptor)
    return False


def begin(results: Path, was_locked: bool = False) -> None:
    """Take a folder of results for this process until it ends, and put it in order.

    Unfinished files are removed, now and at the end, and no file stays from the future.
    """
    try:
        results.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(results / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
        _look_at_folders(results)
    except OSError as error:
        raise InputError(f"{error.filename}: cannot be written ({error.strerror})") from None
    try:
        is_free = not was_locked and _lock(descriptor)
    except OSError as error:
        raise InputError(f"{results}: its file system has no locks ({error.strerror})") from None
    if not is_free:
        os.close(descriptor)
        raise InputError(
            f"{results}: another run is at work there; wait for its end or give this one a name: "
            "--config run=NAME"
        )
    _held[results] = descriptor  # open as long as the process lives
    atomic.clear(results)
    atexit.register(atomic.clear, results)  # what killed jobs leave
    _bring_back(results)


def _bring_back(results: Path) -> None:
    """Give files from the future, made by a wrong clock, the time of now.

    Snakemake fails when what it makes is older than what it is made from, and deletes it.
    """
    now = time.time()
    for path in results.rglob("*"):
        if path.is_file() and path.stat().st_mtime > now + _SKEW:
            with suppress(PermissionError):  # of another user, in a folder that several share
                os.utime(path, (now, now))


def _look_at_folders(results: Path) -> None:
    """Refuse what would end Snakemake with a traceback: files in their place, or no permission."""
    for path in (results / name for name in FOLDERS):
        if not path.exists():
            continue
        if not path.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), path)
        if not os.access(path, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)


def _lock(descriptor: int) -> bool:
    give_up = time.monotonic() + _PATIENCE
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > give_up:
                return False
            time.sleep(0.02)
        else:
            return True


def stop_at_once(results: Path) -> None:
    """From now on end with all jobs at Ctrl-C, SIGTERM or SIGHUP, and say how to go on."""

    def _stop(number: int, frame: Any) -> NoReturn:
        """End this process and its jobs; a handler of signals."""
        # other threads see their jobs fail: nothing of that is to be read
        logging.disable(logging.CRITICAL)
        _end_jobs()
        if results in _held:
            atomic.clear(results)
        said = f"stopped; what is finished is kept in {results}: the same command goes on from here"
        os.write(sys.stderr.fileno(), f"\n{said}\n".encode())
        os._exit(128 + number)

    for signum in STOPPING:
        if signal.getsignal(signum) is not signal.SIG_IGN:  # as under nohup
            signal.signal(signum, _stop)


def cancel_at_stop() -> None:
    """From now on let Snakemake cancel its jobs elsewhere at Ctrl-C, SIGTERM or SIGHUP.

    By itself it waits for them at SIGTERM, and leaves them behind at SIGHUP.
    """
    for signum in STOPPING:
        if signal.getsignal(signum) is not signal.SIG_IGN:
            signal.signal(signum, signal.default_int_handler)


def _end_jobs() -> None:
    import psutil  # only a stop needs it

    jobs = psutil.Process().children(recursive=True)
    for action in (psutil.Process.terminate, psutil.Process.kill):
        for job in jobs:
            try:
                action(job)
            except psutil.NoSuchProcess:
                continue
        _, jobs = psutil.wait_procs(jobs, timeout=_GRACE)


def end_with_parent(parent: int | None = None) -> None:
    """End this process when another ends, even if that is killed."""
    if parent is None and PARENT in os.environ:
        parent = int(os.environ[PARENT])
    if parent is not None:
        threading.Thread(target=_outlive, args=(parent,), daemon=True).start()


def _outlive(parent: int) -> None:
    """Wait for the end of a process and end this one at once: nothing is left half written."""
    try:
        if hasattr(os, "pidfd_open"):  # Linux
            select.select([os.pidfd_open(parent)], [], [])
        else:
            while True:
                os.kill(parent, 0)
                time.sleep(1)
    except ProcessLookupError:
        pass
    os._exit(1)
