"""Newton's method for closed orbits, and the eigenvalues of the tangent map over a period.

A state with given blocks stuck has D coordinates: the displacements of all blocks, and the
velocities of those that slip. Its other velocities are those of the belt, and stay so.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from beltrepro.base.errors import InputError
from beltrepro.chaos.vectors import METHOD, NO_SAMPLES
from beltrepro.engine.state import ChainState
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.simulation import Run, simulate
from beltrepro.simulation.groups import observe
from beltrepro.simulation.setup import Case
from beltrepro.stats.recurrence import CLOSED

TIME_STEP = 0.001  # of no effect without noise
_STEPS = 8  # of Newton's method, which needs two or three from a state that has come back to 1e-8
_AT_ONCE = 1e-9  # share of the period
_NEAR = 0.5  # share of the period by which it may change: every state comes back after no time


class Closed(NamedTuple):
    """A closed orbit: one of its states, and what a period does to deviations from it."""

    state: ChainState
    period_time: float
    monodromy: np.ndarray  # (D, D)
    residual: float  # as a share of the largest coordinate


def follow(
    state: ChainState,
    duration: float,
    *,
    tolerance: float | None = None,
    sample_interval: float | None = None,
) -> Run:
    """The run from a state on."""
    run = simulate(
        state.parameters,
        duration=duration,
        method=METHOD,
        time_step=TIME_STEP,
        tolerance=tolerance,
        initial_state=state,
        sample_interval=sample_interval,
    )
    assert isinstance(run, Run)  # as it was one chain
    return run


def most_stuck(state: ChainState, period_time: float, tolerance: float | None) -> ChainState:
    """A state of the next period in which as many blocks are stuck as ever are, at time 0."""
    # in the middle of the longest time between two events in which they are, away from the events;
    # a state that is there already stays where it is
    state = dataclasses.replace(state, time=0.0)
    events = follow(state, period_time, tolerance=tolerance).events
    if not len(events):
        raise InputError(
            f"{state.parameters.describe()}: no block sticks or slips in {period_time:g} time "
            "units; equilibrium slip has no orbit of its own"
        )
    changes = np.where(events["kind"] == "stick", 1, -1)
    stuck = np.sum(state.directions == 0) + np.cumsum(changes) - changes  # before each event
    lasting = np.diff(events["time"], prepend=events["time"][-1] - period_time)
    most = stuck == stuck[lasting > 0].max()
    longest = int(np.argmax(np.where(most, lasting, -1.0)))
    middle = float(events["time"][longest] - lasting[longest] / 2)
    if abs(middle) > _AT_ONCE * period_time:
        state = follow(state, middle % period_time, tolerance=tolerance).final_state
    return dataclasses.replace(state, time=0.0, scheme=None)


def closed(start: ChainState, period_time: float, tolerance: float | None) -> Closed:
    """The orbit that closes near a state after about a period."""
    # The state z and the period T change by dz and dT, so that the end P of the period comes to
    # P + M dz + f dT = z + dz, with the tangent map M and the flow f. The change dz is across f.
    best, size, about = None, float(np.abs(_coordinates(start)).max()), period_time
    for _ in range(_STEPS):
        end, matrix = _once_around(start, period_time, tolerance)
        if not np.array_equal(end.directions, start.directions):
            break
        apart, flow = _coordinates(end) - _coordinates(start), _flow(start)
        residual = float(np.abs(apart).max()) / size
        if best is not None and residual >= best.residual:
            break
        best = Closed(start, period_time, matrix, residual)
        rows = np.block([[matrix - np.eye(len(flow)), flow[:, None]], [flow[None], np.zeros(1)]])
        change = np.linalg.lstsq(rows, -np.append(apart, 0.0))[0]
        start, period_time = _shifted(start, change[:-1]), period_time + float(change[-1])
        if abs(period_time - about) > _NEAR * about:
            break
    if best is None or best.residual > CLOSED:
        raise InputError(
            f"{start.parameters.describe()}: no orbit closes near the state after about the time "
            f"{about:g}"
        )
    return best


def multipliers(state: ChainState, monodromy: np.ndarray) -> np.ndarray:
    """The 2N multipliers of an orbit through a state, largest modulus first."""
    # The monodromy matrix maps the flow to itself: that is the trivial multiplier. What it does to
    # deviations across the flow, seen along the flow, is the return map of the section.
    flow = _flow(state)
    across = np.linalg.svd(flow[None])[2][1:]
    values = np.linalg.eigvals(across @ monodromy @ across.T).astype(complex)
    erased = np.zeros(np.sum(state.directions == 0))
    values = np.concatenate([[1.0], values, erased])
    return values[np.argsort(-np.abs(values), kind="stable")]


def _once_around(
    start: ChainState, period_time: float, tolerance: float | None
) -> tuple[ChainState, np.ndarray]:
    """The state after a period, and the tangent map (D, D) in the coordinates."""
    free = _free(start)
    chain = TangentIntegrator(
        [start],
        n_vectors=len(free),
        time_step=TIME_STEP,
        sampling=NO_SAMPLES,
        sampled_blocks=1,
        **Case(start, METHOD, TIME_STEP, tolerance).accuracy,
    )
    chain.set_deviations(np.eye(2 * chain.n_blocks)[None, :, free])
    observe(chain, period_time, [], lambda done: None)
    return chain.state()[0], chain.deviations()[0][free]


def _free(state: ChainState) -> np.ndarray:
    """Which of the 2N numbers of a state are coordinates: all but velocities of stuck blocks."""
    slipping = state.directions != 0
    return np.flatnonzero(np.concatenate([np.ones_like(slipping), slipping]))


def _coordinates(state: ChainState) -> np.ndarray:
    return np.concatenate([state.displacements, state.relative_velocities])[_free(state)]


def _flow(state: ChainState) -> np.ndarray:
    """Rates at which the coordinates change: velocities, and accelerations of slipping blocks."""
    law = state.parameters
    kinetic = law.friction_ratio * law.static_friction * state.directions
    return np.concatenate([state.velocities, state.forces - kinetic])[_free(state)]


def _shifted(state: ChainState, change: np.ndarray) -> ChainState:
    """The state with other coordinates."""
    moved = np.zeros(2 * len(state.displacements))
    moved[_free(state)] = change
    displacements, velocities = np.split(moved, 2)
    return dataclasses.replace(
        state,
        displacements=state.displacements + displacements,
        relative_velocities=state.relative_velocities + velocities,
    )
