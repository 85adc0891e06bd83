"""Whether the samples of a call fit in memory, asked before it starts."""

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.engine.integrator import Chunk
from beltrepro.observe.slips import EventLog
from beltrepro.simulation.points import Point
from beltrepro.simulation.sampling import bytes_per_row

_UNWATCHED = 2**27  # bytes
_LIMITS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def check_samples(
    chains: Sequence[Point], duration: float, *, sample_interval: float, sample_start: float
) -> None:
    """Refuse in one line what does not fit in the memory.

    chains : the points whose samples are all kept at once.
    """
    span = duration - sample_start
    row = sum(bytes_per_row(point.parameters) for point in chains)
    needed, free = row * span / sample_interval, available()
    if free is not None and needed > free:
        raise InputError(
            f"sample_interval = {sample_interval:g}: the samples need {needed / 1e9:.3g} GB of "
            f"memory, {free / 1e9:.3g} GB are available; from {1.1 * row * span / free:.2g} on "
            "they fit; or give a later sample_start, or None for no samples"
        )


class EventWatch:
    """Stops a group of runs whose events would soon not fit in the memory."""

    def __init__(self, members: Sequence[Point], log: EventLog):
        self._members, self._log = members, log
        self._next = _UNWATCHED

    def observe(self, chunk: Chunk) -> None:
        """Look at the free memory each time that the events have doubled."""
        size = self._log.nbytes
        if size < self._next:
            return
        self._next = 2 * size
        free = available()
        if free is not None and size > free:
            most = int(np.argmax(self._log.counts))
            raise ModelStateError(
                f"{self._members[most].parameters.describe()}: the events of the runs need "
                f"{size / 1e9:.3g} GB at t = {chunk.end:g}, and as much again is not available"
            )


def available() -> int | None:
    """Bytes of memory that this process can have; None where the system does not tell."""
    known = [_of_machine(), *(_of_group(path) for path in _LIMITS)]
    return min((value for value in known if value is not None), default=None)


def _of_machine() -> int | None:
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        kilobytes = next(line.split()[1] for line in lines if line.startswith("MemAvailable:"))
        return 1024 * int(kilobytes)
    except (OSError, StopIteration):
        pass
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def _of_group(path: str) -> int | None:
    """Limit of the control group of the process, as in a container."""
    try:
        return int(Path(path).read_text())
    except (OSError, ValueError):
        return None
