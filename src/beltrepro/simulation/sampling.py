"""When samples are taken, and the samples of runs."""

from collections.abc import Sequence

import numpy as np

from beltrepro.errors import InputError
from beltrepro.model.spring import external_force
from beltrepro.simulation import checks
from beltrepro.simulation.points import Point

MOMENTS_INTERVAL = 0.1  # model time between samples of x_N for r, about; oscillations take 3


def checked(sample_interval, sample_start, duration: float, chains: Sequence[Point]) -> dict:
    """`sample_interval` and `sample_start` of a call, checked."""
    start = checks.not_negative("sample_start", sample_start)
    if sample_interval is None:
        return {"sample_interval": None, "sample_start": start}
    interval = checks.positive("sample_interval", sample_interval)
    for time_step in {point.time_step for point in chains}:
        stride(interval, time_step)
    if start > duration:
        raise InputError(
            f"sample_start = {start:g}: must be at most the end of the run, {duration:g}"
        )
    return {"sample_interval": interval, "sample_start": start}


def stride(sample_interval: float | None, time_step: float) -> int:
    """Steps between samples; about MOMENTS_INTERVAL for those behind r if none are kept."""
    if sample_interval is None:
        return max(1, round(MOMENTS_INTERVAL / time_step))
    steps = round(sample_interval / time_step)
    if steps < 1 or abs(steps * time_step - sample_interval) > 1e-9 * sample_interval:
        raise InputError(
            f"sample_interval = {sample_interval:g}: "
            f"must be a multiple of time_step = {time_step:g}"
        )
    return steps


class SampleLog:
    """Keeps the samples of a run from `start` on; the state at t = 0 included."""

    def __init__(self, integrator, start: float):
        self._start = start
        self._chains = integrator.parameters
        self._time = []
        self._parts = []
        if start <= 0:
            self._time.append(np.zeros(1))
            displacement = integrator.positions() - self._chains[0].rest_positions
            still = np.zeros_like(displacement)
            self._parts.append(np.stack([displacement, still, still])[:, None].swapaxes(2, 3))

    def observe(self, chunk) -> None:
        """Add the samples of a chunk."""
        kept = chunk.time >= self._start
        if kept.any():
            parts = (chunk.displacement, chunk.relative_velocity, chunk.kinetic_friction)
            self._time.append(chunk.time[kept])
            self._parts.append(np.stack([part[kept] for part in parts]))

    def of(self, lane: int) -> dict[str, np.ndarray]:
        """time (T,), positions, velocities and friction (T, N) of one chain."""
        chain = self._chains[lane]
        if not self._time:
            return no_samples(chain.n_blocks)
        displacement, slip_velocity, kinetic = np.concatenate(
            [part[..., lane] for part in self._parts], axis=1
        )
        positions = displacement + chain.rest_positions
        stuck = (slip_velocity == 0) & (kinetic == 0)
        return {
            "time": np.concatenate(self._time),
            "positions": positions,
            "velocities": slip_velocity + chain.belt_velocity,
            "friction": np.where(stuck, -external_force(positions, chain), kinetic),
        }


def no_samples(n_blocks: int) -> dict[str, np.ndarray]:
    """As `SampleLog.of` of a run without samples."""
    empty = np.empty((0, n_blocks))
    return {"time": np.empty(0), "positions": empty, "velocities": empty, "friction": empty}
