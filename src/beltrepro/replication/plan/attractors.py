"""Recorded for datasets: which attractor starts of several kinds reach, and slow sweeps of u."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from beltrepro.chaos.basins import basins
from beltrepro.simulation.groups import Report
from beltrepro.simulation.setup import Setup
from beltrepro.simulation.starts import slipping_state
from beltrepro.simulation.sweeps import sweep

Arrays = dict[str, np.ndarray]
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
    values = np.unique(velocities)
    up = np.array([np.flatnonzero(velocities == value) for value in values])
    cases = [setup.cases[point] for point in up[0]]
    begun = Setup(
        [case.parameters for case in cases],
        method=[case.method for case in cases],
        time_step=[case.time_step for case in cases],
        initial_state=[case.state for case in cases],
    )
    told: Any = {"duration": duration, "transient": transient, "section_values": 0}
    told |= {"belt_velocity": [*values, *values[::-1]], "progress": progress}
    swept = sweep(begun, **told)
    arrays = {}
    for name in ("disorder_parameter", "mean_length"):
        there, back = swept[name].reshape(2, *up.shape)
        arrays[name] = np.empty((len(velocities), 2))
        arrays[name][up, 0], arrays[name][up, 1] = there, back[::-1]
    return arrays
