"""Simulation of the points of a batch: one function for each kind, arrays as `kinds` lists them."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from beltrepro.chaos import classify, separation, time_to_orbit
from beltrepro.replication.plan.points import Point, chain, columns
from beltrepro.simulation import Setup, catalogue, scan, simulate, time_to_continuous_slip

_HOW = ("method", "time_step", "tolerance", "seed", "replicate", "initial_spread", "kick")

Progress = Callable[[float], None]
Arrays = dict[str, np.ndarray]


def run(
    kind: str, points: Sequence[Point], settings: dict, progress: Progress | None = None
) -> Arrays:
    """Simulate points and record what their kind says."""
    records: dict[str, Callable[..., Any]] = {
        "scan": scan,
        "series": _series,
        "catalogue": catalogue,
        "escapes": time_to_continuous_slip,
        "motion": classify,
        "settling": time_to_orbit,
        "separation": separation,
        "trial": _trial,
    }
    setup = Setup(
        [chain(point) for point in points],
        **{name: [getattr(point, name) for point in points] for name in _HOW},
    )
    return columns(points) | records[kind](setup, **settings, progress=progress)


def _trial(setup, **settings):
    """Runs judged as recordings; imported here, because films take long to import."""
    from beltrepro.replication.camera.trials import trials

    return trials(setup, **settings)


def _series(setup, *, samples, transient, **settings):
    """Samples from the transient on, those of smaller chains filled up with NaN, and events."""
    runs = simulate(setup, transient=transient, sample_start=transient, **settings)
    shape = len(runs), runs[0].time.size, max(one.parameters.n_blocks for one in runs)
    sampled = {name: np.full(shape, np.nan) for name in samples}
    for row, one in enumerate(runs):
        for name, values in sampled.items():
            values[row, :, : one.parameters.n_blocks] = getattr(one, name)
    late = [one.events[one.events["time"] >= transient] for one in runs]
    return {
        "mean_length": np.array([one.mean_length for one in runs]),
        "disorder_parameter": np.array([one.disorder_parameter for one in runs]),
        "energy_residual": np.array([one.energy_residual for one in runs]),
        "allowed_error": np.array([one.tolerance for one in runs], dtype=float),
        "time": runs[0].time,
        **sampled,
        "events": _with_point(late),
    }


def _with_point(tables: list[np.ndarray]) -> np.ndarray:
    """Tables of records, one for each run, as one with the row of the run in the field `point`."""
    fields = tables[0].dtype.descr
    joined = np.empty(sum(map(len, tables)), dtype=[("point", "i4"), *fields])
    joined["point"] = np.repeat(np.arange(len(tables)), list(map(len, tables)))
    for name, *_ in fields:
        joined[name] = np.concatenate([table[name] for table in tables])
    return joined
