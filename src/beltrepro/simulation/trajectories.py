"""Sampled runs of chains, and whether their samples fit in the memory."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.base.provenance import code_version
from beltrepro.engine import records
from beltrepro.engine.integrator import Chunk, Integrator, Sampling, share_of_work
from beltrepro.engine.state import ChainState
from beltrepro.model.friction import kinetic_friction
from beltrepro.model.parameters import LIMITS, LONGEST
from beltrepro.model.spring import external_force
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.slips import EventLog
from beltrepro.simulation.groups import (
    Group,
    Report,
    for_moments,
    in_groups,
    integrator_of,
    moments_interval,
    moments_of,
    of_each,
)
from beltrepro.simulation.loading import LoadingWatch
from beltrepro.simulation.run import EVENT, Run
from beltrepro.simulation.setup import (
    TOLERANCES,
    Case,
    Chains,
    check_lengths,
    check_steps,
    setup_of,
    with_setup,
    with_value,
)

Belt = list[tuple[float, float]]
_ROUNDING = 1e-9  # share of an interval


@with_setup
def simulate(
    chains: Chains,
    *,
    duration: float,
    transient: float = 0.0,
    sample_interval: float | None = 0.1,
    sample_start: float = 0.0,
    belt: Sequence[tuple[float, float]] | None = None,
    progress: Report | None = None,
    **setup: Any,
) -> Run | list[Run]:
    """Simulate one chain, or several together, from all blocks stuck (Sec. III) or from a state.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        One chain, or several that are advanced together.
    duration : float
        Model time simulated, the transient included.
    transient : float
        The first part of it, left out of r and <x_N>. They are found of samples at most about 0.1
        apart, however few are kept; NaN, with a warning, where fewer than 10 are left.
    sample_interval : float or None
        Model time between samples, which are taken at its multiples; None keeps no samples. For
        "verlet" a multiple of time_step. A run from t = 0 has a sample there, one from a later
        state none at its beginning. r and <x_N> are taken over samples (see `transient`), so that
        r differs with the interval, over 2500 time units by about 1e-5 of itself.
    sample_start : float
        The first part of the run that has no samples, model time.
    belt : sequence of (t, u), optional
        From the time t after the beginning on, the belt of all chains has the velocity u; before
        the first t it has that of the chain. The numbers are those of runs from one t to the next,
        each from the final state of the one before. A belt that rests has a tiny u, as 1e-6. r,
        <x_N>, spectra and the like mix all velocities after the transient.
    progress, **setup : callable, keywords of `Setup`
        Called with the fraction done.

    Returns
    -------
    Run or list of Run
        A list for several chains or several runs of one, in their order.

    Raises
    ------
    InputError
        A value is not allowed, or the samples do not fit in the memory.
    ModelStateError
        A state left the range of the model.
    """
    duration, transient = check_lengths(duration, transient)
    made = setup_of(chains, setup)
    steps = _check_belt(belt, duration, made.cases)
    if steps and steps[0][0] == 0:
        made = with_value(made, "belt_velocity", steps.pop(0)[1])
    lengths = {"duration": duration, "transient": transient}
    samples = check_samples(sample_interval, sample_start, duration, made.cases)
    loading = LoadingWatch(made.cases, **lengths, belt=steps)
    work = partial(_followed, loading, lengths | samples, steps)
    runs = of_each(in_groups(made.cases, work, progress, workers=made.workers))
    loading.warn()
    return runs[0] if made.alone else runs


def _followed(
    loading: LoadingWatch, settings: dict[str, Any], belt: Belt, group: Group
) -> list[Run]:
    """The runs of a group of cases."""
    members, rest, start = group.cases, group.chain.rest_positions, group.start
    end, interval = start + settings["duration"], settings["sample_interval"]
    if interval is None:
        sampling, every, sampled_blocks, kept_from = for_moments(members), 1, 1, math.inf
    else:
        sampling, every = with_moments(interval, members[0])
        sampled_blocks, kept_from = len(rest), start + settings["sample_start"]
    chains: Any = _OnBelt(members, belt, sampling=sampling, sampled_blocks=sampled_blocks)
    moments = LengthMoments(len(members), start + settings["transient"])
    events = EventLog(len(members), rest)
    samples = SampleLog(members, chains, sampling, every, kept_from, end)
    loading.observe(group, chains, moments, events, samples)
    length, residual, states = moments_of(moments, chains), chains.energy_residual(), chains.state()
    return [
        Run(
            parameters=case.parameters,
            method=case.method,
            time_step=case.time_step,
            tolerance=case.tolerance or TOLERANCES.get(case.method),
            seed=case.state.seed,
            replicate=case.state.replicate,
            initial_state=case.state,
            final_state=states[lane],
            version=code_version(),
            disorder_parameter=float(length["disorder_parameter"][lane]),
            mean_length=float(length["mean_length"][lane]),
            energy_residual=float(residual[lane]),
            events=event_records(events.events(lane)),
            changes=tuple(states[lane] for states in chains.changes),
            **samples.of(lane),
            **settings,
        )
        for lane, case in enumerate(members)
    ]


class _OnBelt:
    """The integrator of a group, made anew where the velocity of the belt changes."""

    def __init__(self, members: Sequence[Case], belt: Belt, **how: Any) -> None:
        self._members, self._how = list(members), how
        self._belt = [(members[0].state.time + time, velocity) for time, velocity in belt]
        self._integrator = integrator_of(members, **how)
        self._balance = np.zeros((2, len(members)))  # of the pieces that are finished
        self.changes: list[list[ChainState]] = []  # states at the changes, before each

    def __getattr__(self, name: str) -> Any:
        return getattr(self._integrator, name)

    def advance(self, until: float) -> Iterator[Chunk]:
        """As of the integrator."""
        for instant, velocity in self._belt:
            yield from self._integrator.advance(instant)
            self._balance += self._integrator.energy_balance()
            self.changes.append(self._integrator.state())
            for lane, (case, state) in enumerate(zip(self._members, self.changes[-1], strict=True)):
                chain = replace(case.parameters, belt_velocity=velocity)
                self._members[lane] = replace(case, state=state.under(chain))
            self._integrator = integrator_of(self._members, **self._how)
        yield from self._integrator.advance(until)

    def energy_residual(self) -> np.ndarray:
        """As of the integrator, of all pieces together."""
        return share_of_work(*(self._balance + self._integrator.energy_balance()))


def event_records(rows: np.ndarray) -> np.ndarray:
    """Events of one chain as records."""
    events = np.empty(len(rows), dtype=EVENT)
    events["time"] = rows[:, records.EVENT_TIME]
    events["block"] = rows[:, records.EVENT_BLOCK].astype(np.int64) + 1
    events["kind"] = np.where(rows[:, records.EVENT_SLIP] > 0, "slip", "stick")
    events["force"] = rows[:, records.EVENT_FORCE]
    events["position"] = rows[:, records.EVENT_POSITION]
    events["dissipated"] = rows[:, records.EVENT_DISSIPATED]
    return events


def _check_belt(belt: Any, duration: float, cases: Sequence[Case]) -> Belt:
    """When the belt changes its velocity, and to which."""
    if belt is None:
        return []
    pairs = checks.as_numbers(checks.listed("belt", belt) if checks.is_sequence(belt) else belt)
    if pairs.ndim != 2 or pairs.shape[1] != 2:
        needed = "pairs (t, u) are needed, as [(0, 5), (500, 10)]"
        raise InputError(f"belt = {checks.shown(belt)}: {needed}")
    last = -math.inf
    for number, (time, velocity) in enumerate(pairs.tolist()):
        checks.within(f"t of belt[{number}]", time, gt=last, ge=0, le=duration)
        checks.within(f"u of belt[{number}]", velocity, **LIMITS["belt_velocity"])
        for case in cases:
            check_steps(f"belt[{number}]", case.state.time + time, case.method, case.time_step)
        last = time
    return [(time, velocity) for time, velocity in pairs.tolist() if time < duration]


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
            f"{free / 1e9:.3g} GB are available; from {1.1 * interval * needed / free:.2g} on, "
            "or of a shorter time, they fit"
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


def with_moments(sample_interval: float, case: Case) -> tuple[Sampling, int]:
    """The samples of a case, and so many between them that r hardly depends on the interval.

    Returns the finer sampling, and how many of its intervals are one of those asked for: a power of
    2 for "event", which leaves the bits of the instants; a divisor of the steps for "verlet".
    """
    sampling = sampling_of(sample_interval, case.method, case.time_step)
    ratio = sampling.interval / moments_interval(case) * (1 - _ROUNDING)
    if ratio <= 1:
        return sampling, 1
    if case.method == "event":
        every = 2 ** math.ceil(math.log2(ratio))
        return Sampling(sampling.steps, sampling.step / every), every
    least, most = math.ceil(ratio), sampling.steps
    every = next(k for k in range(min(least, most), most + 1) if most % k == 0)
    return Sampling(sampling.steps // every, sampling.step), every


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


class SampleLog:
    """Keeps every so many samples of a group of runs, from `start` on; one at t = 0 the start."""

    def __init__(
        self, members: Sequence[Case], chains: Integrator, sampling: Sampling, every: int,
        start: float, end: float,
    ) -> None:  # fmt: skip
        self._start, self._interval, self._every = start, sampling.interval, every
        self._chain, self._chains = members[0].parameters, chains
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
        for lane, chain in enumerate(self._chains.parameters):
            place, relative, kinetic = (value[..., lane] for value in values)
            positions = place + self._chain.rest_positions
            held = -external_force(positions, self._chain)
            friction = np.where((relative == 0) & (kinetic == 0), held, kinetic)
            self._samples[lane, :, rows] = positions, relative + chain.belt_velocity, friction
        self._count = rows.stop
