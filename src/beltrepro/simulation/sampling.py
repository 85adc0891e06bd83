"""When samples are taken, and the samples of runs."""

import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Chunk, Sampling
from beltrepro.model import ChainParameters
from beltrepro.model.parameters import LONGEST
from beltrepro.model.spring import external_force
from beltrepro.observe.length import LengthMoments
from beltrepro.simulation.points import Point

MOMENTS_INTERVAL = 0.1  # model time between samples of x_N for r, about; oscillations take 3
FEWEST = 10  # samples that r is found of
_ROUNDING = 1e-9  # share of an interval


def checked(
    sample_interval: Any, sample_start: Any, duration: float, chains: Sequence[Point]
) -> dict[str, Any]:
    """`sample_interval` and `sample_start` of a call, checked."""
    start = checks.not_negative("sample_start", sample_start)
    if sample_interval is None:
        return {"sample_interval": None, "sample_start": start}
    interval = checks.positive("sample_interval", sample_interval, LONGEST)
    for method, time_step in {(point.method, point.time_step) for point in chains}:
        sampling_of(interval, method, time_step)
    if start > duration:
        raise InputError(f"sample_start = {start:g}: must be at most duration = {duration:g}")
    return {"sample_interval": interval, "sample_start": start}


def sampling_of(sample_interval: float | None, method: str, time_step: float) -> Sampling:
    """When a method takes samples; about every MOMENTS_INTERVAL, for r, if none are kept."""
    if sample_interval is None:
        return Sampling(max(1, round(MOMENTS_INTERVAL / time_step)), time_step)
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
    moments: LengthMoments, rest_length: float, sampling: Sampling, start: float, end: float
) -> dict[str, np.ndarray]:
    """Moments of the chain length (W,); mean and r are NaN, with a warning, of too few samples.

    start, end : of the time over which they were taken.
    """
    found = moments.result(rest_length)
    last = math.floor(end / sampling.interval + _ROUNDING)
    before = max(math.ceil(start / sampling.interval - _ROUNDING) - 1, 0)
    if last - before < FEWEST:
        warnings.warn(
            f"r and <x_N> are NaN: the {end - start:g} of model time over which they are to be "
            f"found hold fewer than {FEWEST} samples, one every {sampling.interval:g}",
            stacklevel=4,
        )
        for name in ("mean_length", "disorder_parameter"):
            found[name] = np.full_like(found[name], np.nan)
    return found


def bytes_per_row(chain: ChainParameters) -> int:
    """Memory of one row of samples of a run: time; positions, velocities and friction."""
    return np.dtype(float).itemsize * (1 + 3 * chain.n_blocks)


class SampleLog:
    """Keeps the samples of a group of runs.

    members : the points. sampling, every : of the chunks, and which of their samples are kept.
    start : of the samples kept; one at t = 0 shows the initial states. end : of the runs.
    """

    def __init__(
        self,
        members: Sequence[Point],
        sampling: Sampling,
        every: int,
        start: float,
        end: float,
    ):
        self._start = start
        self._interval, self._every = sampling.interval, every
        self._chains = [point.parameters for point in members]
        most = max(0, int((end - start) / (every * sampling.interval))) + 2
        self._filled = 0
        self._time = np.empty(most)
        shape = (len(members), most, self._chains[0].n_blocks)
        self._positions, self._velocities, self._friction = (np.empty(shape) for _ in range(3))
        states = [point.state for point in members]
        if start == 0:
            self._add(
                np.zeros(1),
                np.stack([state.displacements for state in states], axis=1)[None],
                np.stack([state.relative_velocities for state in states], axis=1)[None],
                np.stack([_kinetic_friction(state) for state in states], axis=1)[None],
            )

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
        for lane, chain in enumerate(self._chains):
            positions = displacement[..., lane] + chain.rest_positions
            kinetic = kinetic_friction[..., lane]
            stuck = (relative_velocity[..., lane] == 0) & (kinetic == 0)
            self._positions[lane, rows] = positions
            self._velocities[lane, rows] = relative_velocity[..., lane] + chain.belt_velocity
            self._friction[lane, rows] = np.where(stuck, -external_force(positions, chain), kinetic)
        self._filled = rows.stop


def no_samples(n_blocks: int) -> dict[str, np.ndarray]:
    """As `SampleLog.of` of a run without samples."""
    empty = np.empty((0, n_blocks))
    return {"time": np.empty(0), "positions": empty, "velocities": empty, "friction": empty}


def _kinetic_friction(state):
    chain = state.parameters
    return -state.directions * (chain.static_friction * chain.friction_ratio)
