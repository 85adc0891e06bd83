"""Sampled runs of chains."""

from __future__ import annotations

import math
from functools import partial
from importlib.metadata import version
from typing import Any

import numpy as np

from beltrepro.engine import records
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.slips import EventLog
from beltrepro.simulation.groups import Report, in_groups, integrator_of
from beltrepro.simulation.loading import LoadingWatch
from beltrepro.simulation.run import EVENT, Run
from beltrepro.simulation.sampling import (
    SampleLog,
    check_samples,
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
    samples = check_samples(sample_interval, sample_start, duration, made.cases)
    loading = LoadingWatch(made.cases, **lengths)
    work = partial(_follow, loading, lengths | samples)
    followed = in_groups(made.cases, work, progress, workers=made.workers)
    loading.warn()
    runs = {
        index: run for group, several in followed for index, run in zip(group, several, strict=True)
    }
    return runs[0] if made.alone else [runs[index] for index in range(len(made.cases))]


def _follow(
    loading: LoadingWatch,
    settings: dict[str, Any],
    group: np.ndarray,
    members: list[Case],
    report: Report,
) -> list[Run]:
    """The runs of a group of cases."""
    first, rest = members[0], members[0].parameters.rest_positions
    start = first.state.time
    measured, end = start + settings["transient"], start + settings["duration"]
    if settings["sample_interval"] is None:
        sampling, every, sampled_blocks, kept_from = for_moments(members), 1, 1, math.inf
    else:
        kept = sampling_of(settings["sample_interval"], first.method, first.time_step)
        sampling, every = with_moments(kept, first.method)
        sampled_blocks, kept_from = len(rest), start + settings["sample_start"]
    integrator = integrator_of(members, sampling=sampling, sampled_blocks=sampled_blocks)
    moments, events = LengthMoments(len(members), measured), EventLog(len(members), rest)
    samples = SampleLog(members, sampling, every, kept_from, end)
    loading.observe(group, integrator, [moments, events, samples], report)
    length = moments_of(moments, members, sampling, measured, integrator.time)
    residual, states, made_by = (
        integrator.energy_residual(),
        integrator.state(),
        version("beltrepro"),
    )
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
            version=made_by,
            disorder_parameter=float(length["disorder_parameter"][lane]),
            mean_length=float(length["mean_length"][lane]),
            energy_residual=float(residual[lane]),
            events=event_records(events.events(lane)),
            **samples.of(lane),
            **settings,
        )
        for lane, case in enumerate(members)
    ]


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
