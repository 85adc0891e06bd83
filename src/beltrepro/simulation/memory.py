"""Whether the samples of a call fit in memory, asked before it starts."""

import os
from collections.abc import Sequence
from pathlib import Path

from beltrepro.errors import InputError
from beltrepro.simulation.points import Point

_NUMBER = 8  # bytes
_COPIES = 3  # of positions, velocities and friction while a run is put together, at most
_GROUP_LIMITS = (
    ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
    ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
)


def check_samples(
    chains: Sequence[Point], duration: float, *, sample_interval: float, sample_start: float
) -> None:
    """Refuse in one line what does not fit in the available memory.

    chains : the points whose samples are all kept at once.
    """
    free = available()
    span = max(duration - sample_start, 0.0)
    row = sum(_NUMBER * (1 + 3 * _COPIES * point.parameters.n_blocks) for point in chains)
    needed = row * span / sample_interval
    if free is not None and needed > free:
        raise InputError(
            f"sample_interval = {sample_interval:g}: samples would take {needed / 1e9:.3g} GB of "
            f"memory and {free / 1e9:.3g} GB are free; take one of at least "
            f"{row * span / free:.2g}, a later sample_start, or sample_interval=None for no samples"
        )


def available() -> int | None:
    """Bytes of memory that are free for this process, None where the system does not tell."""
    known = [_of_machine(), *(_of_group(*paths) for paths in _GROUP_LIMITS)]
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


def _of_group(limit: str, usage: str) -> int | None:
    """What the control group of the process leaves, as in a container."""
    try:
        return int(Path(limit).read_text()) - int(Path(usage).read_text())
    except (OSError, ValueError):
        return None
