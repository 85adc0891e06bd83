"""Sampled runs of chains."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import names
from beltrepro.engine.records import (
    EVENT_BLOCK,
    EVENT_DISSIPATED,
    EVENT_FORCE,
    EVENT_POSITION,
    EVENT_SLIP,
    EVENT_TIME,
)
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.slips import EventLog
from beltrepro.simulation import arguments, memory
from beltrepro.simulation.arguments import PerChain
from beltrepro.simulation.methods import TOLERANCES
from beltrepro.simulation.points import Point, Progress, groups, integrator_of, observe, points
from beltrepro.simulation.run import EVENT, Run
from beltrepro.simulation.sampling import (
    SampleLog,
    checked,
    moments_of,
    no_samples,
    sampling_of,
    with_moments,
)


@names.checked
def simulate(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    transient: float = 0.0,
    method: PerChain[str] = "verlet",
    time_step: PerChain[float] = 0.001,
    tolerance: PerChain[float | None] = None,
    seed: PerChain[int] | None = None,
    replicate: PerChain[int] | None = None,
    initial_positions: ArrayLike | Sequence[ArrayLike] | None = None,
    initial_spread: PerChain[float] = 0.0,
    initial_state: PerChain[ChainState] | None = None,
    sample_interval: float | None = 0.1,
    sample_start: float = 0.0,
    progress: Progress | None = None,
) -> Run | list[Run]:
    """Simulate one chain, or several together, from all blocks stuck (Sec. III) or from a state.

    Parameters
    ----------
    parameters : ChainParameters or sequence of them
        One chain, or several that are advanced together. Of the quantities below, `method`,
        `time_step`, `tolerance`, `seed`, `replicate`, `initial_spread` and `initial_state` are one
        value for all chains, or a sequence with one value for each.
    duration : float
        Model time simulated, the transient included.
    transient : float
        The first part of it, left out of r and <x_N>. They are found of samples at most about 0.1
        apart, however few are kept; NaN, with a warning, where fewer than 10 are left.
    method : str
        "verlet", the scheme of the Appendix, or "event", the exact dynamics (docs/event.md).
    time_step : float
        dt, model time, at most 0.1; for "event" it only sets the strength of the noise.
    tolerance : float or None
        Only for "event": last terms of the series of a force allowed at the end of a step, unit of
        force, 1e-16 to 1. None for the method's own, which is larger with noise (docs/event.md).
    seed, replicate : int
        Of 0 or greater; with the parameters they fix all random numbers. If not given, 1 and 0, or
        those of `initial_state`, whose random stream then goes on.
    initial_positions : array (N,), or a sequence of such arrays for a sequence of chains
        Positions of the blocks at t = 0, model length; undeformed springs if not given.
    initial_spread : float
        Standard deviation of normal deviates that are added to the initial positions of replicates
        other than 0, model length.
    initial_state : ChainState
        Where to go on, for instance `final_state` of another run, see docs/states.md. Time goes on
        from that of the state. The chain may have another belt velocity, noise or law than that of
        the state (`ChainState.under`), and another method may go on.
    sample_interval : float or None
        Model time between samples, which are taken at its multiples; None keeps no samples. For
        "verlet" a multiple of time_step. A run from t = 0 has a sample there, one from a later
        state none at its beginning.
    sample_start : float
        The first part of the run that has no samples, model time.
    progress : callable
        Called with the fraction done.

    Returns
    -------
    Run or list of Run
        A list for a sequence of chains, in its order.

    Raises
    ------
    InputError
        A value is not allowed, or the samples do not fit in the memory.
    ModelStateError
        A state left the range of the model.
    """
    duration, transient = arguments.lengths(duration, transient)
    chains = points(
        parameters,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=seed,
        replicate=replicate,
        initial_positions=initial_positions,
        initial_spread=initial_spread,
        initial_state=initial_state,
    )
    lengths = {"duration": duration, "transient": transient}
    samples = checked(sample_interval, sample_start, duration, chains)
    if samples["sample_interval"] is not None:
        memory.check_samples(chains, duration, **samples)
    runs: dict[int, Run] = {}
    for group, report in groups(chains, progress):
        members = [chains[index] for index in group]
        runs |= zip(group, _follow(members, lengths, samples, report), strict=True)
    if isinstance(parameters, ChainParameters):
        return runs[0]
    return [runs[index] for index in range(len(chains))]


def _follow(members: list[Point], lengths: dict, samples: dict, report: Progress) -> list[Run]:
    """The runs of a group of points."""
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
    observers = [moments, events, memory.EventWatch(members, events)]
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
            point,
            **lengths,
            **samples,
            final_state=states[lane],
            **{name: float(length[name][lane]) for name in ("disorder_parameter", "mean_length")},
            energy_residual=float(residual[lane]),
            **(log.of(lane) if keeps_samples else no_samples(len(rest))),
            events=_event_records(events, lane),
        )
        for lane, point in enumerate(members)
    ]


def _run(point: Point, **recorded: Any) -> Run:
    """The run of a point."""
    own = TOLERANCES.get(point.method)
    return Run(
        parameters=point.parameters,
        method=point.method,
        time_step=point.time_step,
        tolerance=own if point.tolerance is None else point.tolerance,
        seed=point.state.seed,
        replicate=point.state.replicate,
        initial_state=point.state,
        version=version("beltrepro"),
        **recorded,
    )


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
