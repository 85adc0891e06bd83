"""Recorded for datasets: samples and events. Apart, as no other kind has this code behind it."""

import numpy as np

from beltrepro.simulation.trajectories import simulate


def series(setup, *, samples, transient, **settings):
    """Samples from the transient on, those of smaller chains filled up with NaN, and events."""
    runs = simulate(setup, transient=transient, sample_start=transient, **settings)
    shape = len(runs), runs[0].time.size, max(run.parameters.n_blocks for run in runs)
    sampled = {name: np.full(shape, np.nan) for name in samples}
    late = [run.events[run.events["time"] >= transient] for run in runs]
    counts = list(map(len, late))
    events = np.empty(sum(counts), [("point", "i4"), *late[0].dtype.descr])
    events["point"] = np.repeat(np.arange(len(runs)), counts)
    for name in late[0].dtype.names:
        events[name] = np.concatenate([table[name] for table in late])
    for row, run in enumerate(runs):
        for name, values in sampled.items():
            values[row, :, : run.parameters.n_blocks] = getattr(run, name)
    numbers = ("mean_length", "disorder_parameter", "energy_residual")
    of_runs = {name: np.array([getattr(run, name) for run in runs]) for name in numbers}
    return of_runs | {"time": runs[0].time} | sampled | {"events": events}
