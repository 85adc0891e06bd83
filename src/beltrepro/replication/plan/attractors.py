"""Recorded for datasets: which attractor starts of several kinds reach, slow sweeps of u, and where
orbits begin.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from beltrepro.base.errors import InputError, ModelStateError
from beltrepro.chaos.basins import basins
from beltrepro.chaos.continuation import OrbitBranch, orbit_branch
from beltrepro.chaos.periodic_orbits import PeriodicOrbit, close_orbit
from beltrepro.engine.state import ChainState
from beltrepro.model.spring import (
    balance_tension,
    chain_deformations,
    spring_extension,
    spring_force,
)
from beltrepro.simulation.groups import Report
from beltrepro.simulation.setup import Setup
from beltrepro.simulation.starts import slipping_state
from beltrepro.simulation.sweeps import sweep

Arrays = dict[str, np.ndarray]
_LABEL, _R = [("point", "i4"), ("attractor", "i4")], ("disorder_parameter", "f8")
_PERIOD = [("period_time", "f8"), ("period_events", "i4")]
_END = [("end", "U18"), ("end_block", "i4")]
ATTRACTOR = np.dtype([*_LABEL, ("state", "U16"), *_PERIOD, ("largest_multiplier", "f8"), _R])
BRANCH = np.dtype([*_LABEL, ("belt_velocity", "f8"), _R, *_PERIOD, *_END])
BIRTH = np.dtype(
    [
        *(("point", "i4"), ("period_events", "i4"), ("friction_ratio", "f8")),
        *(("belt_velocity", "f8"), _R, ("largest_multiplier", "f8"), *_END),
    ]
)
_APART = 0.01  # between friction ratios at which an orbit is closed on the way
_ABOVE = 1.05  # times its birth: where an orbit is handed on to the next friction ratio
_STEP = 0.5  # of u, the largest


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
    settings: Any = {"duration": duration, "transient": transient, "section_values": 0}
    settings |= {"belt_velocity": [*values, *values[::-1]], "progress": progress}
    swept = sweep(begun, **settings)
    arrays = {}
    for name in ("disorder_parameter", "mean_length"):
        there, back = swept[name].reshape(2, *up.shape)
        arrays[name] = np.empty((len(velocities), 2))
        arrays[name][up, 0], arrays[name][up, 1] = there, back[::-1]
    return arrays


def births(
    setup: Setup,
    *,
    duration: float,
    slips: Sequence[int],
    friction_ratios: Sequence[float],
    progress: Report | None = None,
) -> Arrays:
    """Where orbits begin along u, at several friction ratios, as far as they can be followed there.

    Of each law one orbit of each of these numbers of slips is followed, the first of those that P
    starts reach, and that the chain reaches below the birth of another one. A record names the
    first point of the belt velocity at which the orbit, or that other one, was found.
    """
    chains = [case.parameters for case in setup.cases]
    records, done = [], set()
    for number, chain in enumerate(dict.fromkeys(chains), start=1):
        points = [point for point, one in enumerate(chains) if one == chain]
        ways = [[setup.cases[point].state for point in points]]
        while ways:
            states = ways.pop()
            several = Setup([states[0].parameters] * len(states), initial_state=states)
            for one in basins(several, duration=duration).attractors:
                kind = (chain.law, one.period_events)
                if one.orbit is None or kind in done or one.period_events not in slips:
                    continue
                done.add(kind)
                branch = _born(one.orbit)
                ways.append([_below(branch)])
                for born in _along_friction(branch, friction_ratios):
                    first, end = born.orbits[0], born.lower_end
                    numbers = first.disorder_parameter, abs(first.largest_multiplier)
                    place = one.period_events, first.parameters.friction_ratio, born.lower
                    records.append((points[0], *place, *numbers, end.kind, end.block))
        if progress:
            progress(number / len(set(chains)))
    return {"births": np.array(records, BIRTH)}


def _born(orbit: PeriodicOrbit) -> OrbitBranch:
    """The branch of an orbit down to where it begins, and a little up."""
    u = orbit.parameters.belt_velocity
    return orbit_branch(orbit, lower=u / 2, upper=_ABOVE * u, step=_STEP)


def _below(branch: OrbitBranch) -> ChainState:
    """A state of the first orbit of a branch, at a belt velocity at which there is none."""
    state = branch.orbits[0].state
    return state.under(replace(state.parameters, belt_velocity=branch.lower - _STEP / 10))


def _along_friction(begin: OrbitBranch, ratios: Sequence[float]) -> Iterator[OrbitBranch]:
    """The same branch at all friction ratios to which it can be followed."""
    middle = begin.orbits[0].parameters.friction_ratio
    if middle in ratios:
        yield begin
    lower = sorted((one for one in ratios if one < middle), reverse=True)
    for places in (lower, sorted(one for one in ratios if one > middle)):
        now, branch = middle, begin
        try:
            for place in places:
                beside = np.abs(branch.parameter - _ABOVE * branch.lower)
                orbit = branch.orbits[int(np.argmin(beside))]
                steps = int(np.ceil(abs(place - now) / _APART))
                for ratio in np.linspace(now, place, steps + 1)[1:].tolist():
                    orbit = _scaled(orbit, ratio)
                if orbit.period_events != begin.orbits[0].period_events:
                    break
                now, branch = place, _born(orbit)
                yield branch
        except (InputError, ModelStateError):  # it does not close, or blocks would meet
            continue


def _scaled(orbit: PeriodicOrbit, friction_ratio: float) -> PeriodicOrbit:
    """The orbit at another friction ratio and the same u / u* (docs/physics.md)."""
    old, state = orbit.parameters, orbit.state
    scale = (1 - friction_ratio) / (1 - old.friction_ratio)
    chain = replace(old, friction_ratio=friction_ratio, belt_velocity=scale * old.belt_velocity)
    tension = -spring_force(chain_deformations(state.positions, old), old) - balance_tension(old)
    stretched = spring_extension(balance_tension(chain) + scale * tension, chain)
    speeds = np.where(state.directions == 0, chain.belt_velocity, scale * state.velocities)
    places = np.cumsum(chain.rest_length + stretched)
    return close_orbit(ChainState.in_motion(chain, places, speeds), orbit.period_time)
