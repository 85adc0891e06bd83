"""A run of the workflow has its folder of results to itself, and its jobs end when it is killed.

Snakemake's own lock outlives a kill; this one ends with the process. So the same command goes on.
"""

import fcntl
import os
import select
import threading
from contextlib import suppress
from pathlib import Path

from beltrepro.base import atomic
from beltrepro.base.errors import InputError

NAME = ".lock"
RUN = "BELTREPRO_RUN"  # environment of jobs: the process that they must not outlive


def take(results: Path) -> None:
    """Take a folder of results until this process ends, and remove what kills left half written."""
    try:
        results.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(results / NAME, os.O_RDWR | os.O_CREAT, 0o644)  # never closed
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InputError(
            f"{results}: another run is at work there; wait for its end or give this one a name: "
            "--config run=NAME"
        ) from None
    except OSError as error:
        raise InputError(f"{results}: cannot be locked ({error.strerror})") from None
    atomic.clear(results)


def end_with_run() -> None:
    """End this job at once when the process in RUN ends, even if that is killed."""
    if RUN in os.environ and hasattr(os, "pidfd_open"):  # elsewhere than on Linux a job just ends
        threading.Thread(target=_wait, args=(int(os.environ[RUN]),), daemon=True).start()


def _wait(process: int) -> None:
    with suppress(ProcessLookupError):  # it has ended already
        select.select([os.pidfd_open(process)], [], [])
    os._exit(1)
