"""Sampled runs of chains."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version
from typing import Any, Unpack

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
from beltrepro.simulation.groups import Report, groups, integrator_of, observe
from beltrepro.simulation.run import EVENT, Run
from beltrepro.simulation.sampling import (
    EventWatch,
    SampleLog,
    check_memory,
    checked,
    moments_of,
    no_samples,
    sampling_of,
    with_moments,
)
from beltrepro.simulation.setup import (
    TOLERANCES,
    Case,
    Chains,
    Keywords,
    check_lengths,
    setup_of,
    with_setup,
)


@with_setup
def simulate(
    chains: Chains,
    *,
    duration: float,
    transient: float = 0.0,
    sample_interval: float | None = 0.1,
    sample_start: float = 0.0,
    progress: Report | None = None,
    **setup: Unpack[Keywords],
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
    runs: dict[int, Run] = {}
    for group, report in groups(made.cases, progress):
        members = [made.cases[index] for index in group]
        runs |= zip(group, _follow(members, lengths, samples, report), strict=True)
    return runs[0] if made.alone else [runs[index] for index in range(len(made.cases))]


def _follow(members: list[Case], lengths: dict, samples: dict, report: Report) -> list[Run]:
    """The runs of a group of cases."""
    first = members[0]
    rest, start = first.parameters.rest_positions, first.state.time
    keeps_samples = samples["sample_interval"] is not None
    kept = sampling_of(samples["sample_interval"], first.method, first.time_step)
    sampling, every = with_moments(kept, first.method)
    integrator = integrator_of(
        members, sampling=sampling, sampled_blocks=len(rest) if keeps_samples else 1
    )
    moments = LengthMoments(len(members), start + lengths["transient"])
    events = EventLog(len(members), rest)
    observers = [moments, events, EventWatch(members, events)]
    if keeps_samples:
        begin, end = start + samples["sample_start"], start + lengths["duration"]
        log = SampleLog(members, sampling, every, begin, end)
        observers.append(log)
    # samples and events would fill a checkpoint
    observe(integrator, lengths["duration"], observers, report, kept=False)
    measured = sampling, start + lengths["transient"], integrator.time
    length, residual = moments_of(moments, rest[-1], *measured), integrator.energy_residual()
    states = integrator.state()
    return [
        _run(
            case,
            **lengths,
            **samples,
            final_state=states[lane],
            **{name: float(length[name][lane]) for name in ("disorder_parameter", "mean_length")},
            energy_residual=float(residual[lane]),
            **(log.of(lane) if keeps_samples else no_samples(len(rest))),
            events=_event_records(events, lane),
        )
        for lane, case in enumerate(members)
    ]


def _run(case: Case, **recorded: Any) -> Run:
    """The run of a case."""
    default = TOLERANCES.get(case.method)
    return Run(
        parameters=case.parameters,
        method=case.method,
        time_step=case.time_step,
        tolerance=default if case.tolerance is None else case.tolerance,
        seed=case.state.seed,
        replicate=case.state.replicate,
        initial_state=case.state,
        version=_version(),
        **recorded,
    )


@cache  # reading it takes half a millisecond
def _version() -> str:
    return version("beltrepro")


def _event_records(log: EventLog, lane: int) -> np.ndarray:
    """Events of one chain as records; a long run has millions, so the log gives them up."""
    records = np.empty(log.count(lane), dtype=EVENT)
    start = 0
    for rows in log.give_up(lane):
        part = records[start : start + len(rows)]
        part["time"] = rows[:, EVENT_TIME]
        part["block"] = rows[:, EVENT_BLOCK].astype(np.int64) + 1
        part["kind"] = np.where(rows[:, EVENT_SLIP] > 0, "slip", "stick")
        part["force"] = rows[:, EVENT_FORCE]
        part["position"] = rows[:, EVENT_POSITION]
        part["dissipated"] = rows[:, EVENT_DISSIPATED]
        start += len(rows)
    return records
