"""Trials: runs of the length of the experiment, analysed as its recordings are (Sec. II).

A trial keeps the way of the last block at the instants of the frames of a camera. From there on it
is treated as `beltrepro.replication.camera.recording` treats a film, so that both are judged alike.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError, NotEnoughDataError
from beltrepro.model import units
from beltrepro.replication.camera import recording
from beltrepro.simulation.run import Run
from beltrepro.simulation.setup import Chains, setup_of
from beltrepro.simulation.trajectories import simulate

_AT_ONCE = 32  # runs whose samples are kept at one time


def trials(
    chains: Chains,
    *,
    duration: float,
    transient: float,
    sample_interval: float,
    laminar_time: float = 200.0,
    progress: Callable[[float], None] | None = None,
    **setup: Any,
) -> dict[str, np.ndarray]:
    """What the recording of each of P runs would tell.

    Small amplitudes, and those that last, are as `camera.recording` defines them.
    """
    made = setup_of(chains, setup)
    lasting_s = units.to_si(checks.positive("laminar_time", laminar_time), "time")
    how: dict[str, Any] = {"duration": duration, "transient": transient}
    how |= {"sample_start": transient, "sample_interval": sample_interval}
    rows: list[dict[str, float]] = []
    while len(rows) < len(made.cases):
        part = made.cases[len(rows) : len(rows) + _AT_ONCE]
        means = ("method", "time_step", "tolerance")
        begun: dict[str, Any] = {name: [getattr(case, name) for case in part] for name in means}
        begun["initial_state"] = [case.state for case in part]
        runs = simulate([case.parameters for case in part], **begun, **how)
        rows += [_trial(run, lasting_s) for run in cast(list[Run], runs)]
        if progress is not None:
            progress(len(rows) / len(made.cases))
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _trial(run: Run, lasting_s: float) -> dict[str, float]:
    """One run as a recording of its last block."""
    time_s = units.to_si(run.time, "time")
    x_m = units.to_si(run.positions[:, -1], "length")
    try:
        seen = recording.regimes(time_s, x_m, lasting_s=lasting_s)
    except NotEnoughDataError as reason:
        raise InputError(f"sample_interval = {run.sample_interval:g}: {reason}") from None
    lasting, lively = (
        units.from_si(np.diff(stretches, axis=1).max(initial=0.0), "time")
        for stretches in (seen.lasting_s, seen.lively_s)
    )
    return {
        "mean_length": units.from_si(seen.mean_length, "length"),
        "disorder_parameter": seen.disorder_parameter,
        "small_share": seen.small_share,
        "lasting_share": seen.lasting_share,
        "lasting_count": len(seen.lasting_s),
        "lasting_longest": lasting,
        "lively_longest": lively,
        "slip_longest": _slip(run, [run.parameters.n_blocks]),
        "all_slip_longest": _slip(run, range(1, run.parameters.n_blocks + 1)),
    }


def _slip(run: Run, blocks: Sequence[int]) -> float:
    """Longest time after the transient in which none of these blocks is stuck, model time."""
    start, end = run.initial_state.time, run.initial_state.time + run.duration
    first = start + run.transient
    events = run.events[np.isin(run.events["block"], blocks)]
    stuck_first = sum(run.initial_state.directions[block - 1] == 0 for block in blocks)
    change = np.where(events["kind"] == "stick", 1, -1)
    stuck = np.cumsum(np.concatenate([[stuck_first], change]))
    edges = np.maximum(np.concatenate([[start], events["time"], [end]]), first)
    # a block that reverses is stuck for no time, so that it goes on slipping
    lasting = (np.diff(edges) > 0) & (stuck > 0)
    begins = np.concatenate([[first], edges[1:][lasting]])
    ends = np.concatenate([edges[:-1][lasting], [end]])
    return float(np.max(ends - begins))
