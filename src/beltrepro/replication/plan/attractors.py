"""Recorded for datasets: which attractor starts of several kinds reach, and slow sweeps of u."""

from collections.abc import Sequence

import numpy as np

from beltrepro.chaos.basins import Basins, basins
from beltrepro.engine.state import ChainState
from beltrepro.simulation.groups import Report
from beltrepro.simulation.setup import Case, Setup
from beltrepro.simulation.starts import slipping_state
from beltrepro.simulation.trajectories import simulate

Arrays = dict[str, np.ndarray]
_OF_STARTS = ("attractor", "state", "lifetime", "period_events", "disorder_parameter")
ATTRACTOR = np.dtype(
    [
        *(("point", "i4"), ("attractor", "i4"), ("state", "U16"), ("period_time", "f8")),
        *(("period_events", "i4"), ("largest_multiplier", "f8"), ("disorder_parameter", "f8")),
    ]
)
BRANCH = np.dtype(
    [
        *(("point", "i4"), ("attractor", "i4"), ("belt_velocity", "f8")),
        *(("disorder_parameter", "f8"), ("period_time", "f8"), ("period_events", "i4")),
        *(("end", "U18"), ("end_block", "i4")),
    ]
)


def basin_starts(
    setup: Setup, *, duration: float, energies: Sequence[float], progress: Report | None = None
) -> Arrays:
    """Where P points end from rest, and from slipping states of several energies for a block."""
    sizes = np.array([case.parameters.n_blocks for case in setup.cases])
    rows = [np.flatnonzero(sizes == n_blocks) for n_blocks in np.unique(sizes)]
    parts = [_of_one_size(setup.cases, points, duration, energies, progress) for points in rows]
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    order = np.argsort(np.concatenate(rows))
    of_points = {name: joined[name][order] for name in _OF_STARTS}
    return joined | of_points | {"start_energy": np.array([0.0, *energies])}


def _of_one_size(
    every_case: Sequence[Case],
    points: np.ndarray,
    duration: float,
    energies: Sequence[float],
    progress: Report | None,
) -> Arrays:
    """That of points of one number of blocks; labels hold for these."""
    cases = [every_case[point] for point in points]
    states = [case.state for case in cases]
    for energy in energies:
        states += [_slipping(case, energy) for case in cases]
    parameters = [case.parameters for case in cases] * (1 + len(energies))
    several = Setup(
        parameters,
        seed=[state.seed for state in states],
        replicate=[state.replicate for state in states],
        initial_state=states,
    )
    reached = basins(several, duration=duration, progress=progress)
    velocities = [case.parameters.belt_velocity for case in cases]
    first = {velocity: int(points[velocities.index(velocity)]) for velocity in velocities}
    columns = {name: reached.runs[name].reshape(-1, len(cases)).T for name in _OF_STARTS}
    return columns | {
        "attractors": _attractors(reached, first),
        "branches": _branches(reached, first),
    }


def _slipping(case: Case, energy: float) -> ChainState:
    """A slipping state of so much energy for each block."""
    chain, state = case.parameters, case.state
    keys = {"seed": state.seed, "replicate": state.replicate}
    return slipping_state(chain, energy * chain.n_blocks, **keys)


def _attractors(reached: Basins, first: dict[float, int]) -> np.ndarray:
    """Records of the attractors; `first` : the first point of each belt velocity."""
    rows = []
    for one in reached.attractors:
        size = np.nan if one.orbit is None else abs(one.orbit.largest_multiplier)
        period = one.period_time, one.period_events
        rows.append((first[one.value], one.label, one.state, *period, size, one.disorder_parameter))
    return np.array(rows, ATTRACTOR)


def _branches(reached: Basins, first: dict[float, int]) -> np.ndarray:
    """Records of the orbits of each branch along u, with how it ends at the first and the last."""
    place = {one.label: first[one.value] for one in reversed(reached.attractors)}
    rows = []
    for label, branch in reached.branches.items():
        ends = {branch.lower: branch.lower_end, branch.upper: branch.upper_end}
        for orbit in branch.orbits:
            velocity = orbit.parameters.belt_velocity
            end = ends.get(velocity)
            about = (end.kind, end.block) if end else ("", 0)
            period = orbit.period_time, orbit.period_events
            row = (velocity, orbit.disorder_parameter, *period, *about)
            rows.append((place[label], label, *row))
    return np.array(rows, BRANCH)


def sweeps(
    setup: Setup, *, duration: float, transient: float, progress: Report | None = None
) -> Arrays:
    """r of P points on the way up and down in u: each begins where the one before has ended."""
    disorder, length = np.full((2, len(setup.cases), 2), np.nan)
    up = list(zip(*_rows(setup.cases), strict=True))
    states = [setup.cases[point].state for point in up[0]]
    steps = [(way, points) for way, columns in enumerate((up, up[::-1])) for points in columns]
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
        disorder[list(points), way] = [run.disorder_parameter for run in runs]
        length[list(points), way] = [run.mean_length for run in runs]
        if progress:
            progress(done / len(steps))
    return {"disorder_parameter": disorder, "mean_length": length}


def _rows(cases: Sequence[Case]) -> list[list[int]]:
    """Points of one chain, method and replicate, in the order of the belt velocity."""
    rows: dict[tuple, list[int]] = {}
    for point, case in enumerate(cases):
        chain = case.parameters
        key = chain.n_blocks, chain.law, chain.noise, case.method, case.time_step
        rows.setdefault((*key, case.state.seed, case.state.replicate), []).append(point)
    velocities = [case.parameters.belt_velocity for case in cases]
    return [sorted(row, key=lambda point: velocities[point]) for row in rows.values()]
