"""Recorded for datasets: which attractor starts of several kinds reach, and slow sweeps of u."""

from collections.abc import Sequence

import numpy as np

from beltrepro.chaos.basins import basins
from beltrepro.simulation.groups import Report
from beltrepro.simulation.setup import Setup
from beltrepro.simulation.starts import slipping_state
from beltrepro.simulation.trajectories import simulate

Arrays = dict[str, np.ndarray]
_LABEL, _R = [("point", "i4"), ("attractor", "i4")], ("disorder_parameter", "f8")
_PERIOD = [("period_time", "f8"), ("period_events", "i4")]
_END = [("end", "U18"), ("end_block", "i4")]
ATTRACTOR = np.dtype([*_LABEL, ("state", "U16"), *_PERIOD, ("largest_multiplier", "f8"), _R])
BRANCH = np.dtype([*_LABEL, ("belt_velocity", "f8"), _R, *_PERIOD, *_END])


def basin_starts(
    setup: Setup, *, duration: float, energies: Sequence[float], progress: Report | None = None
) -> Arrays:
    """Where P points of one N end, from rest, and from slipping states of several energies a block.

    Records of an attractor name the first point of its belt velocity, those of a branch the first
    of the lowest one at which its attractor was seen.
    """
    chains = [case.parameters for case in setup.cases]
    states = [case.state for case in setup.cases]
    keys = [{"seed": state.seed, "replicate": state.replicate} for state in states]
    for energy in energies:
        states += [
            slipping_state(chain, energy * chain.n_blocks, **key)
            for chain, key in zip(chains, keys, strict=True)
        ]
    several = Setup(
        chains * (1 + len(energies)),
        seed=[state.seed for state in states],
        replicate=[state.replicate for state in states],
        initial_state=states,
    )
    reached = basins(several, duration=duration, progress=progress)
    velocities = [chain.belt_velocity for chain in chains]
    attractors = [
        (
            *(velocities.index(one.value), one.label, one.state, one.period_time),
            *(one.period_events, abs(one.orbit.largest_multiplier) if one.orbit else np.nan),
            one.disorder_parameter,
        )
        for one in reached.attractors
    ]
    place = {label: point for point, label, *_ in reversed(attractors)}
    orbits = []
    for label, branch in reached.branches.items():
        ends = {
            end.parameter: (end.kind, end.block) for end in (branch.lower_end, branch.upper_end)
        }
        for u, orbit in zip(branch.parameter, branch.orbits, strict=True):
            numbers = orbit.disorder_parameter, orbit.period_time, orbit.period_events
            orbits.append((place[label], label, u, *numbers, *ends.get(u, ("", 0))))
    names = ("attractor", "state", "lifetime", "period_events", "disorder_parameter")
    return {
        **{name: reached.runs[name].reshape(-1, len(chains)).T for name in names},
        "attractors": np.array(attractors, ATTRACTOR),
        "branches": np.array(orbits, BRANCH),
        "start_energy": np.array([0.0, *energies]),
    }


def sweeps(
    setup: Setup, *, duration: float, transient: float, progress: Report | None = None
) -> Arrays:
    """r of P points on the way up and down in u: each begins where the one before has ended.

    At each belt velocity there are the same points, in the same order.
    """
    velocities = np.array([case.parameters.belt_velocity for case in setup.cases])
    up = [np.flatnonzero(velocities == velocity) for velocity in np.unique(velocities)]
    steps = [(way, points) for way, columns in enumerate((up, up[::-1])) for points in columns]
    disorder, length = np.full((2, len(velocities), 2), np.nan)
    states = [setup.cases[point].state for point in up[0]]
    for done, (way, points) in enumerate(steps, start=1):
        cases = [setup.cases[point] for point in points]
        continued = Setup(
            [case.parameters for case in cases],
            method=[case.method for case in cases],
            time_step=[case.time_step for case in cases],
            initial_state=states,
        )
        runs = simulate(continued, duration=duration, transient=transient, sample_interval=None)
        assert isinstance(runs, list)  # as the chains are one
        states = [run.final_state for run in runs]
        disorder[points, way] = [run.disorder_parameter for run in runs]
        length[points, way] = [run.mean_length for run in runs]
        if progress:
            progress(done / len(steps))
    return {"disorder_parameter": disorder, "mean_length": length}
