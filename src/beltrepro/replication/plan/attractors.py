"""Recorded for datasets: which attractor starts of several kinds reach, and slow sweeps of u."""

from collections.abc import Sequence

import numpy as np

from beltrepro.chaos.basins import Basins, basins
from beltrepro.chaos.continuation import OrbitBranch
from beltrepro.engine.state import ChainState
from beltrepro.simulation.groups import Report
from beltrepro.simulation.setup import Case, Setup
from beltrepro.simulation.starts import slipping_state
from beltrepro.simulation.trajectories import simulate

Arrays = dict[str, np.ndarray]
_OF_STARTS = ("attractor", "state", "lifetime", "period_events", "disorder_parameter")
ATTRACTOR = np.dtype(
    {
        "names": [
            *("point", "attractor", "state", "period_time", "period_events"),
            *("largest_multiplier", "disorder_parameter"),
        ],
        "formats": ["i4", "i4", "U16", "f8", "i4", "f8", "f8"],
    }
)
BRANCH = np.dtype(
    {
        "names": [
            *("point", "attractor", "belt_velocity", "disorder_parameter", "period_time"),
            *("period_events", "end", "end_block"),
        ],
        "formats": ["i4", "i4", "f8", "f8", "f8", "i4", "U18", "i4"],
    }
)


def basin_starts(
    setup: Setup, *, duration: float, energies: Sequence[float], progress: Report | None = None
) -> Arrays:
    """Where P points end from rest, and from slipping states of several energies for a block."""
    sizes = np.array([case.parameters.n_blocks for case in setup.cases])
    parts = []
    for n_blocks in np.unique(sizes):
        points = np.flatnonzero(sizes == n_blocks)
        cases = [setup.cases[point] for point in points]
        parts.append(_of_one_size(cases, points, duration, energies, progress))
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    order = np.argsort(joined.pop("points"))
    of_points = {name: joined[name][order] for name in _OF_STARTS}
    return joined | of_points | {"start_energy": np.array([0.0, *energies])}


def _of_one_size(
    cases: list[Case],
    points: np.ndarray,
    duration: float,
    energies: Sequence[float],
    progress: Report | None,
) -> Arrays:
    """That of points of one number of blocks; labels hold for these."""
    states: list[ChainState | None] = [None] * len(cases)
    for energy in energies:
        states += [_slipping(case, energy) for case in cases]
    repeated = (1 + len(energies)) * cases
    several = Setup(
        [case.parameters for case in repeated],
        tolerance=[case.tolerance for case in repeated],
        seed=[case.state.seed for case in repeated],
        replicate=[case.state.replicate for case in repeated],
        initial_state=[
            case.state if state is None else state
            for case, state in zip(repeated, states, strict=True)
        ],
    )
    reached = basins(several, duration=duration, progress=progress)
    velocities = [case.parameters.belt_velocity for case in cases]
    first = {velocity: int(points[velocities.index(velocity)]) for velocity in velocities}
    columns = {name: reached.runs[name].reshape(-1, len(cases)).T for name in _OF_STARTS}
    return columns | {
        "points": points,
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
    """Records of the orbits of each branch, from its lower to its upper end."""
    place = {one.label: first[one.value] for one in reversed(reached.attractors)}
    rows = [
        (place[label], label, *row)
        for label, branch in reached.branches.items()
        for row in _orbits(branch)
    ]
    return np.array(rows, BRANCH)


def _orbits(branch: OrbitBranch) -> list[tuple]:
    """u, r, period and slips of each orbit of a branch, and how it ends for the first and last."""
    ends = {branch.lower: branch.lower_end, branch.upper: branch.upper_end}
    rows = []
    for orbit in branch.orbits:
        velocity = orbit.parameters.belt_velocity
        end = ends.get(velocity)
        about = (end.kind, end.block) if end else ("", 0)
        period = orbit.period_time, orbit.period_events
        rows.append((velocity, orbit.disorder_parameter, *period, *about))
    return rows


def sweeps(
    setup: Setup, *, duration: float, transient: float, progress: Report | None = None
) -> Arrays:
    """r of P points on the way up and down in u: each begins where the one before has ended."""
    disorder, length = np.full((2, len(setup.cases), 2), np.nan)
    rows = _rows(setup.cases)
    steps = 2 * len(rows[0])
    states = [setup.cases[row[0]].state for row in rows]
    ways = [(0, list(zip(*rows, strict=True))), (1, list(zip(*rows, strict=True))[::-1])]
    done = 0
    for way, columns in ways:
        for points in columns:
            continued = _going_on([setup.cases[point] for point in points], states)
            runs = simulate(continued, duration=duration, transient=transient, sample_interval=None)
            assert isinstance(runs, list)  # as the chains are one
            states = [run.final_state for run in runs]
            disorder[list(points), way] = [run.disorder_parameter for run in runs]
            length[list(points), way] = [run.mean_length for run in runs]
            done += 1
            if progress:
                progress(done / steps)
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


def _going_on(cases: Sequence[Case], states: Sequence[ChainState]) -> Setup:
    """The chains of some points, from the states of others."""
    return Setup(
        [case.parameters for case in cases],
        method=[case.method for case in cases],
        time_step=[case.time_step for case in cases],
        tolerance=[case.tolerance for case in cases],
        initial_state=list(states),
    )
