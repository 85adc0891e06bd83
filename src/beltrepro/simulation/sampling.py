"""When samples are taken, the samples of runs, and whether they fit in the memory."""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Chunk, Integrator, Sampling
from beltrepro.model.friction import kinetic_friction
from beltrepro.model.parameters import LONGEST
from beltrepro.model.spring import external_force
from beltrepro.observe.length import LengthMoments
from beltrepro.simulation.setup import Case, warn

_MOMENTS_INTERVAL = 0.1  # model time between samples of x_N for r, about; oscillations take 3
_FEWEST = 10  # samples for r and <x_N>
_ROUNDING = 1e-9  # share of an interval


def check_samples(
    sample_interval: Any, sample_start: Any, duration: float, cases: Sequence[Case]
) -> dict[str, Any]:
    """`sample_interval` and `sample_start` of a call, if the samples fit in the memory together."""
    start = checks.not_negative("sample_start", sample_start)
    if sample_interval is None:
        return {"sample_interval": None, "sample_start": start}
    interval = checks.positive("sample_interval", sample_interval, LONGEST)
    for method, time_step in {(case.method, case.time_step) for case in cases}:
        sampling_of(interval, method, time_step)
    if start > duration:
        raise InputError(f"sample_start = {start:g}: must be at most duration = {duration:g}")
    # a row of time; positions, velocities and friction
    row = sum(8 * (1 + 3 * case.parameters.n_blocks) for case in cases)
    needed, free = row * (duration - start) / interval, available_memory()
    if needed > free:
        raise InputError(
            f"sample_interval = {interval:g}: the samples need {needed / 1e9:.3g} GB of memory, "
            f"{free / 1e9:.3g} GB are available; from {1.1 * interval * needed / free:.2g} on "
            "they fit; or give a later sample_start, or None for no samples"
        )
    return {"sample_interval": interval, "sample_start": start}


def available_memory() -> float:
    """Bytes that this process can have; infinite where the system does not tell."""
    # Linux gives out more than it has, and ends a process that uses it; others raise MemoryError
    path = Path("/proc/meminfo")
    available = re.search(
        r"^MemAvailable: *(\d+) kB", path.read_text() if path.exists() else "", re.M
    )
    return 1024.0 * int(available[1]) if available else math.inf


def for_moments(members: Sequence[Case]) -> Sampling:
    """When a group takes samples of x_N for r alone."""
    time_step = members[0].time_step
    return Sampling(max(1, round(_MOMENTS_INTERVAL / time_step)), time_step)


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


def with_moments(sample_interval: float, case: Case) -> tuple[Sampling, int]:
    """The samples of a case, and so many between them that r hardly depends on the interval.

    Returns the finer sampling, and how many of its intervals are one of those asked for: a power of
    2 for "event", which leaves the bits of the instants; a divisor of the steps for "verlet".
    """
    sampling = sampling_of(sample_interval, case.method, case.time_step)
    ratio = sampling.interval / _MOMENTS_INTERVAL * (1 - _ROUNDING)
    if ratio <= 1:
        return sampling, 1
    if case.method == "event":
        every = 2 ** math.ceil(math.log2(ratio))
        return Sampling(sampling.steps, sampling.step / every), every
    every = next(k for k in range(math.ceil(ratio), sampling.steps + 1) if sampling.steps % k == 0)
    return Sampling(sampling.steps // every, sampling.step), every


def moments_of(moments: LengthMoments, chains: Integrator) -> dict[str, np.ndarray]:
    """Moments of the length (W,) of chains; r and <x_N> are NaN, warned, of too few samples."""
    lengths = moments.result(chains.parameters[0].rest_positions[-1])
    if moments.count < _FEWEST:
        warn(
            f"r and <x_N> are NaN: the {chains.time - moments.start:g} of model time over which "
            f"they are to be found hold {moments.count} samples, at least {_FEWEST} are needed"
        )
        nothing = np.full_like(lengths["mean_length"], np.nan)
        lengths |= {"mean_length": nothing, "disorder_parameter": nothing}
    return lengths


class SampleLog:
    """Keeps every so many samples of a group of runs, from `start` on; one at t = 0 the start."""

    def __init__(
        self, members: Sequence[Case], sampling: Sampling, every: int, start: float, end: float
    ) -> None:
        self._start, self._interval, self._every = start, sampling.interval, every
        self._chain = members[0].parameters
        self._belt_velocities = [case.parameters.belt_velocity for case in members]
        most = int(max(0.0, end - start) / (every * sampling.interval)) + 2
        self._count, self._time = 0, np.empty(most)
        self._samples = np.empty((len(members), 3, most, self._chain.n_blocks))
        if start == 0:
            names = ("displacements", "relative_velocities", "directions")
            places, relative, directions = (
                np.array([getattr(case.state, name) for case in members]).T[None] for name in names
            )
            braked = -directions * kinetic_friction(self._chain, relative[0].T).T
            self._add(np.zeros(1), places, relative, braked)

    def observe(self, chunk: Chunk) -> None:
        """Add the samples of a chunk."""
        kept: Any = slice(np.searchsorted(chunk.time, self._start), None)
        if self._every > 1:
            numbers = np.rint(chunk.time / self._interval).astype(np.int64)
            kept = np.flatnonzero((chunk.time >= self._start) & (numbers % self._every == 0))
        values = chunk.displacement, chunk.relative_velocity, chunk.kinetic_friction
        self._add(chunk.time[kept], *(value[kept] for value in values))

    def of(self, lane: int) -> dict[str, Any]:
        """time (T,), positions, velocities and friction (T, N) of one chain."""
        moving = self._samples[lane, :, : self._count]
        names = ("positions", "velocities", "friction")
        return {"time": self._time[: self._count].copy()} | dict(zip(names, moving, strict=True))

    def _add(self, time, displacement, relative_velocity, kinetic_friction):
        """Add S samples: time (S,), the others (S, N, W)."""
        if not len(time):
            return
        rows = slice(self._count, self._count + len(time))
        self._time[rows] = time
        values = displacement, relative_velocity, kinetic_friction
        for lane, belt_velocity in enumerate(self._belt_velocities):
            place, relative, kinetic = (value[..., lane] for value in values)
            positions = place + self._chain.rest_positions
            held = -external_force(positions, self._chain)
            friction = np.where((relative == 0) & (kinetic == 0), held, kinetic)
            self._samples[lane, :, rows] = positions, relative + belt_velocity, friction
        self._count = rows.stop
