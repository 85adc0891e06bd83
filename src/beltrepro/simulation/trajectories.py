"""Sampled runs of chains."""

from __future__ import annotations

from functools import cache, partial
from importlib.metadata import version
from typing import Any

import numpy as np

from beltrepro.engine.records import (
    EVENT_BLOCK,
    EVENT_DISSIPATED,
    EVENT_FORCE,
    EVENT_POSITION,
    EVENT_SLIP,
    EVENT_TIME,
)
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.slips import EventLog
from beltrepro.simulation.groups import Report, in_groups, integrator_of
from beltrepro.simulation.loading import LoadingWatch
from beltrepro.simulation.run import EVENT, Run
from beltrepro.simulation.sampling import (
    SampleLog,
    check_memory,
    checked,
    for_moments,
    moments_of,
    sampling_of,
    with_moments,
)
from beltrepro.simulation.setup import (
    TOLERANCES,
    Case,
    Chains,
    check_lengths,
    setup_of,
    with_setup,
)

_EVENT_COLUMNS = {
    "time": EVENT_TIME,
    "force": EVENT_FORCE,
    "position": EVENT_POSITION,
    "dissipated": EVENT_DISSIPATED,
}


@with_setup
def simulate(
    chains: Chains,
    *,
    duration: float,
    transient: float = 0.0,
    sample_interval: float | None = 0.1,
    sample_start: float = 0.0,
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
        state none at its beginning.
    sample_start : float
        The first part of the run that has no samples, model time.
    progress : callable
        Called with the fraction done.
    **setup
        The keywords of `Setup`.

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
    lengths = {"duration": duration, "transient": transient}
    samples = checked(sample_interval, sample_start, duration, made.cases)
    if samples["sample_interval"] is not None:
        check_memory(made.cases, duration, **samples)
    loading = LoadingWatch(made.cases, **lengths)
    work = partial(_follow, lengths, samples, loading)
    followed = in_groups(made.cases, work, progress, workers=made.workers)
    loading.warn()
    runs = {
        index: run for group, several in followed for index, run in zip(group, several, strict=True)
    }
    return runs[0] if made.alone else [runs[index] for index in range(len(made.cases))]


def _follow(
    lengths: dict,
    samples: dict,
    loading: LoadingWatch,
    group: np.ndarray,
    members: list[Case],
    report: Report,
) -> list[Run]:
    """The runs of a group of cases."""
    first = members[0]
    rest, start = first.parameters.rest_positions, first.state.time
    keeps_samples = samples["sample_interval"] is not None
    sampling, every, sampled_blocks = for_moments(members), 1, 1
    if keeps_samples:
        kept = sampling_of(samples["sample_interval"], first.method, first.time_step)
        sampling, every = with_moments(kept, first.method)
        sampled_blocks = len(rest)
    integrator = integrator_of(members, sampling=sampling, sampled_blocks=sampled_blocks)
    moments = LengthMoments(len(members), start + lengths["transient"])
    events = EventLog(len(members), rest)
    observers: list[Any] = [moments, events]
    if keeps_samples:
        begin, end = start + samples["sample_start"], start + lengths["duration"]
        log = SampleLog(members, sampling, every, begin, end)
        observers.append(log)
    loading.observe(group, integrator, observers, report)
    measured = sampling, start + lengths["transient"], integrator.time
    length, residual = moments_of(moments, members, *measured), integrator.energy_residual()
    runs = []
    for lane, (case, state) in enumerate(zip(members, integrator.state(), strict=True)):
        recorded: dict[str, Any] = {"time": np.empty(0)}
        recorded |= dict.fromkeys(("positions", "velocities", "friction"), np.empty((0, len(rest))))
        if keeps_samples:
            recorded = log.of(lane)
        for name in ("disorder_parameter", "mean_length"):
            recorded[name] = float(length[name][lane])
        run = Run(
            parameters=case.parameters,
            time_step=case.time_step,
            tolerance=case.tolerance or TOLERANCES.get(case.method),
            initial_state=case.state,
            final_state=state,
            version=_version(),
            energy_residual=float(residual[lane]),
            events=_event_records(events.events(lane)),
            method=case.method,
            seed=case.state.seed,
            replicate=case.state.replicate,
            **recorded,
            **lengths,
            **samples,
        )
        runs.append(run)
    return runs


@cache  # reading it takes half a millisecond
def _version() -> str:
    return version("beltrepro")


def _event_records(rows: np.ndarray) -> np.ndarray:
    """Events of one chain as records."""
    records = np.empty(len(rows), dtype=EVENT)
    for name, column in _EVENT_COLUMNS.items():
        records[name] = rows[:, column]
    records["block"] = rows[:, EVENT_BLOCK].astype(np.int64) + 1
    records["kind"] = np.where(rows[:, EVENT_SLIP] > 0, "slip", "stick")
    return records
