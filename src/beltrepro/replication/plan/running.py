"""Simulation of the points of a batch: one function for each kind, arrays as `kinds` lists them."""

from collections.abc import Callable, Sequence

import numpy as np

from beltrepro.chaos import motions, separation, settling
from beltrepro.replication.plan.points import Point, chain, columns
from beltrepro.simulation import catalogue, escapes, scan, simulate

_HOW = ("method", "time_step", "tolerance", "seed", "replicate", "initial_spread")

Progress = Callable[[float], None]
Arrays = dict[str, np.ndarray]


def run(
    kind: str, points: Sequence[Point], settings: dict, progress: Progress | None = None
) -> Arrays:
    """Simulate points and record what their kind says."""
    records: dict[str, Callable[..., Arrays]] = {
        "scan": scan,
        "series": _series,
        "catalogue": catalogue,
        "escapes": escapes,
        "motion": motions,
        "settling": settling,
        "separation": separation,
        "trial": _trial,
    }
    # a plan with kicked points of a kind that takes no kicks has been refused
    told = (*_HOW, "kick") if any(point.kick > 0 for point in points) else _HOW
    how = {name: [getattr(point, name) for point in points] for name in told}
    recorded = records[kind](
        [chain(point) for point in points], **how, **settings, progress=progress
    )
    return columns(points) | recorded


def _trial(chains, **told):
    """Runs judged as recordings; imported here, because films take long to import."""
    from beltrepro.replication.camera.trials import trials

    return trials(chains, **told)


def _series(chains, *, samples, transient, **told):
    """Samples from the transient on, those of smaller chains filled up with NaN, and events."""
    runs = simulate(chains, transient=transient, sample_start=transient, **told)
    shape = len(runs), runs[0].time.size, max(one.n_blocks for one in chains)
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
