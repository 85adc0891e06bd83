"""When samples are taken, the samples of runs, and whether they fit in the memory."""

import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Chunk, Sampling
from beltrepro.model.friction import kinetic_friction
from beltrepro.model.parameters import LONGEST
from beltrepro.model.spring import external_force
from beltrepro.observe.length import LengthMoments
from beltrepro.simulation.setup import Case, caller

MOMENTS_INTERVAL = 0.1  # model time between samples of x_N for r, about; oscillations take 3
FEWEST = 10  # samples for r and <x_N>
_ROUNDING = 1e-9  # share of an interval
_AT_ONCE = 2**15  # numbers that are worked on together


def checked(
    sample_interval: Any, sample_start: Any, duration: float, cases: Sequence[Case]
) -> dict[str, Any]:
    """`sample_interval` and `sample_start` of a call, checked."""
    start = checks.not_negative("sample_start", sample_start)
    if sample_interval is None:
        return {"sample_interval": None, "sample_start": start}
    interval = checks.positive("sample_interval", sample_interval, LONGEST)
    for method, time_step in {(case.method, case.time_step) for case in cases}:
        sampling_of(interval, method, time_step)
    if start > duration:
        raise InputError(f"sample_start = {start:g}: must be at most duration = {duration:g}")
    return {"sample_interval": interval, "sample_start": start}


def for_moments(members: Sequence[Case]) -> Sampling:
    """When a group takes samples of x_N for r alone."""
    time_step = members[0].time_step
    return Sampling(max(1, round(MOMENTS_INTERVAL / time_step)), time_step)


def sampling_of(sample_interval: float, method: str, time_step: float) -> Sampling:
    """When a method takes samples that are kept."""
    steps = round(sample_interval / time_step)
    if steps >= 1 and abs(steps * time_step - sample_interval) <= _ROUNDING * sample_interval:
        return Sampling(steps, time_step)
    if method == "event":
        return Sampling(1, sample_interval)
    raise InputError(
        f"sample_interval = {sample_interval:g}: "
        f"method {method!r} needs a multiple of time_step = {time_step:g}"
    )


def with_moments(sampling: Sampling, method: str) -> tuple[Sampling, int]:
    """The same samples, and so many between them that r hardly depends on the interval.

    Returns the finer sampling, and how many of its intervals are one of those asked for: a power of
    2 for "event", which leaves the bits of the instants; a divisor of the steps for "verlet".
    """
    ratio = sampling.interval / MOMENTS_INTERVAL * (1 - _ROUNDING)
    if ratio <= 1:
        return sampling, 1
    if method == "event":
        every = 2 ** math.ceil(math.log2(ratio))
        return Sampling(sampling.steps, sampling.step / every), every
    every = next(k for k in range(math.ceil(ratio), sampling.steps + 1) if sampling.steps % k == 0)
    return Sampling(sampling.steps // every, sampling.step), every


def moments_of(
    moments: LengthMoments, members: Sequence[Case], sampling: Sampling, start: float, end: float
) -> dict[str, np.ndarray]:
    """Moments of the chain length (W,) from `start` to `end`; NaN, warned, of too few samples."""
    lengths = moments.result(members[0].parameters.rest_positions[-1])
    last = math.floor(end / sampling.interval + _ROUNDING)
    before = max(math.ceil(start / sampling.interval - _ROUNDING) - 1, 0)
    if last - before < FEWEST:
        warnings.warn(
            f"r and <x_N> are NaN: the {end - start:g} of model time over which they are to be "
            f"found hold fewer than {FEWEST} samples, one every {sampling.interval:g}",
            stacklevel=caller(),
        )
        for name in ("mean_length", "disorder_parameter"):
            lengths[name] = np.full_like(lengths[name], np.nan)
    return lengths


class SampleLog:
    """Keeps every so many samples of a group of runs, from `start` on; one at t = 0 the start."""

    def __init__(
        self, members: Sequence[Case], sampling: Sampling, every: int, start: float, end: float
    ) -> None:
        self._start = start
        self._interval, self._every = sampling.interval, every
        self._chain = chain = members[0].parameters
        self._belt_velocity = np.array([[[case.parameters.belt_velocity]] for case in members])
        most = max(0, int((end - start) / (every * sampling.interval))) + 2
        self._filled = 0
        self._time = np.empty(most)
        shape = (len(members), most, chain.n_blocks)
        self._positions, self._velocities, self._friction = (np.empty(shape) for _ in range(3))
        if start == 0:
            names = ("displacements", "relative_velocities", "directions")
            places, relative, directions = (
                np.array([getattr(case.state, name) for case in members]).T[None] for name in names
            )
            kinetic = kinetic_friction(chain, relative[0].T).T
            self._add(np.zeros(1), places, relative, -directions * kinetic)

    def observe(self, chunk: Chunk) -> None:
        """Add the samples of a chunk."""
        kept: Any = slice(np.searchsorted(chunk.time, self._start), None)
        if self._every > 1:
            numbers = np.rint(chunk.time / self._interval).astype(np.int64)
            kept = np.flatnonzero((chunk.time >= self._start) & (numbers % self._every == 0))
        self._add(
            chunk.time[kept],
            chunk.displacement[kept],
            chunk.relative_velocity[kept],
            chunk.kinetic_friction[kept],
        )

    def of(self, lane: int) -> dict[str, np.ndarray]:
        """time (T,), positions, velocities and friction (T, N) of one chain."""
        filled = slice(self._filled)
        return {
            "time": self._time[filled].copy(),
            "positions": self._positions[lane, filled],
            "velocities": self._velocities[lane, filled],
            "friction": self._friction[lane, filled],
        }

    def _add(self, time, displacement, relative_velocity, kinetic_friction):
        """Add S samples: time (S,), the others (S, N, W)."""
        rows = slice(self._filled, self._filled + len(time))
        self._time[rows] = time
        width, chain = len(self._positions), self._chain
        many = max(1, _AT_ONCE // (len(time) * chain.n_blocks + 1))  # chains, short of the caches
        for first in range(0, width, many):
            lanes = slice(first, first + many)
            places, relative, kinetic = (
                np.moveaxis(values[..., lanes], -1, 0)
                for values in (displacement, relative_velocity, kinetic_friction)
            )
            positions = places + chain.rest_positions
            held = -external_force(positions, chain)
            self._positions[lanes, rows] = positions
            self._velocities[lanes, rows] = relative + self._belt_velocity[lanes]
            self._friction[lanes, rows] = np.where((relative == 0) & (kinetic == 0), held, kinetic)
        self._filled = rows.stop


def check_memory(
    cases: Sequence[Case], duration: float, *, sample_interval: float, sample_start: float
) -> None:
    """Refuse in one line samples that do not fit in the memory together."""
    span = duration - sample_start
    # a row of time; positions, velocities and friction
    row = sum(8 * (1 + 3 * case.parameters.n_blocks) for case in cases)
    needed, free = row * span / sample_interval, available()
    if needed > free:
        raise InputError(
            f"sample_interval = {sample_interval:g}: the samples need {needed / 1e9:.3g} GB of "
            f"memory, {free / 1e9:.3g} GB are available; from {1.1 * row * span / free:.2g} on "
            "they fit; or give a later sample_start, or None for no samples"
        )


def available() -> float:
    """Bytes of memory that this process can have; infinite where the system does not tell."""
    # Linux gives out more than it has, and ends a process that uses it; others raise MemoryError
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
    except OSError:
        return math.inf
    return next(
        (1024.0 * int(x.split()[1]) for x in lines if x.startswith("MemAvailable:")), math.inf
    )
