"""Periodic orbits as such: found by recurrence, closed by Newton's method, with their multipliers.

A deviation from a state of the orbit is carried once around by the monodromy matrix, the tangent
map over one period. Its 2N eigenvalues are the multipliers of the orbit (docs/chaos.md).
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.chaos.vectors import METHOD, NO_SAMPLES, check_method, part, with_vectors
from beltrepro.engine.integrator import Sampling, Section
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model.energy import slow_unit, times_as_fast
from beltrepro.model.spring import acceleration, balance_length, section_position
from beltrepro.observe.crossings import ReturnLog
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.slips import EventLog
from beltrepro.simulation.groups import (
    Report,
    check_progress,
    for_moments,
    integrator_of,
    observe,
)
from beltrepro.simulation.run import Run
from beltrepro.simulation.setup import Case, Chains, Setup, check_lengths, setup_of, with_setup
from beltrepro.simulation.tables import Tabled, one_panel
from beltrepro.simulation.trajectories import event_records, simulate
from beltrepro.stats.motion import CLOSED, NEAR, find_recurrence

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOMENTS = ("disorder_parameter", "mean_length")
_TIME_STEP = 0.001  # of no effect without noise
_AHEAD = 10  # times the loading from undeformed springs
_STEPS = 8  # of Newton's method, which needs two or three from a state that has come back to 1e-8
_OFF_MIDDLE = 0.125  # share of the time between two events by which a state may be off its middle
_NEAR = 0.5  # share of the period by which it may change: every state comes back after no time
_DRAWN = 4000  # samples of the period in a picture
_SAMPLE_INTERVAL = 0.1  # model time, about: of the samples of x_N for r, of the paper's chain


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbit(Tabled):
    """A closed orbit of a chain without noise.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    state : ChainState
        A state of the orbit, at an instant at which as many blocks are stuck as ever are.
    period_time : float
        Length of the period T, model time.
    period_events, period_returns : int
        In a period, slips of all blocks, and returns of the last one, coming down, to <x_N>.
    monodromy : array (D, D)
        Tangent map over one period, in the coordinates of the state: displacements of all blocks,
        then velocities of those that slip there.
    multipliers : array (2N,) of complex
        Eigenvalues of the tangent map, largest modulus first: that of a shift of time is exactly 1,
        those of directions that a stick erases exactly 0.
    residual : float
        Distance of the state after one period from the state, as a share of its largest coordinate,
        or of the stretch of a spring under static friction where that is larger.
    disorder_parameter, mean_length : float
        r (Eq. 4) and <x_N> over the period.
    """

    parameters: ChainParameters
    state: ChainState
    period_time: float
    period_events: int
    period_returns: int
    monodromy: np.ndarray
    multipliers: np.ndarray
    residual: float
    disorder_parameter: float
    mean_length: float

    @property
    def trivial(self) -> int:
        """Index of the multiplier that belongs to a shift of time."""
        return int(np.flatnonzero(self.multipliers == 1.0)[0])

    @property
    def erased(self) -> int:
        """Number of multipliers that are exactly 0, of directions that a stick erases."""
        return int(np.sum(self.state.directions == 0))

    @property
    def largest_multiplier(self) -> complex:
        """The one of largest modulus besides the trivial one: inside the unit circle, attracts."""
        return complex(np.delete(self.multipliers, self.trivial)[0])

    @property
    def exponent(self) -> float:
        """Largest Lyapunov exponent besides the trivial one, log|mu| / T, per model time."""
        size = abs(self.largest_multiplier)
        return float(np.log(size) / self.period_time) if size > 0 else -np.inf

    @names.checked
    def run(self, sample_interval: float | None = 0.1) -> Run:
        """Follow the orbit for one period, from its state at time 0.

        Parameters
        ----------
        sample_interval : float or None
            As in `simulate`.

        Returns
        -------
        Run
            With the events of the period.

        Raises
        ------
        InputError
            The interval is not allowed.
        """
        setup = Setup(self.parameters, initial_state=self.state)
        with warnings.catch_warnings(action="ignore"):  # of a run so short, which is all there is
            run = simulate(setup, duration=self.period_time, sample_interval=sample_interval)
        return cast(Run, run)

    @one_panel
    def plot(
        self, path: str | Path | None = None, *, ax: Any = None, block: int = -1, **look: Any
    ) -> Axes:
        """Draw the orbit of a block: its velocity by its position.

        Parameters
        ----------
        block : int
            From 1; -1 for the last one.
        """
        return self.run(self.period_time / _DRAWN).plot_phase(ax=ax, block=block, **look)

    def __repr__(self) -> str:
        return (
            f"PeriodicOrbit({self.parameters.describe()}: period {self.period_time:.10g}, "
            f"{self.period_events} slips, |mu| = {abs(self.largest_multiplier):.3g})"
        )


@with_setup
def periodic_orbit(
    chains: Chains,
    *,
    duration: float,
    transient: float,
    progress: Report | None = None,
    **setup: Any,
) -> PeriodicOrbit:
    """The periodic orbit in which a chain ends.

    The chain is followed until its state comes back. Newton's method, with the tangent map as
    derivative, then moves the state and the time until the orbit closes.

    Parameters
    ----------
    chains : ChainParameters or Setup
        One run of one chain, without noise, of the method "event".
    duration, transient : float
        Model time of the run, and of its first part, in which the chain may settle. A period must
        fit twice in the rest.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

    Returns
    -------
    PeriodicOrbit
        With its multipliers.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, the chain has noise, its state does not come back, or left the range
        of the model.
    """
    made = setup_of(chains, setup)
    if len(made.cases) > 1:
        raise InputError(f"chains = {checks.shown(chains)}: one run of one chain is needed")
    (case,) = made.cases
    check_exact(made.cases)
    duration, transient = check_lengths(duration, transient)
    if transient == 0:
        raise InputError("transient = 0: must be greater than 0, a chain needs time to settle")
    check_progress(progress)
    observed, share = duration - transient, transient / duration
    log, report = ReturnLog(1), part(progress, 0, share)
    how = transient, observed, for_moments([case]), report
    (begun,), (length,) = with_lengths([case], *how)
    report, start = part(progress, share, 1), [replace(case, state=begun)]
    (end,) = advanced(start, observed, log, length=length, report=report)
    times, states, _ = log.returns(0)
    recurrence = find_recurrence(states, times)
    if recurrence is None:
        raise InputError(
            f"{case.parameters.describe()}: no state comes back in the last {observed:g} time "
            "units; the motion has not settled, or not on a periodic orbit"
        )
    return _undivided(close_orbit(end, recurrence.time, case.tolerance), case.tolerance)


def _undivided(orbit: PeriodicOrbit, tolerance: float | None) -> PeriodicOrbit:
    """The orbit of which another is several periods, as where it attracts weakly by turns."""
    start, events = orbit.state, orbit.period_events
    for parts in (parts for parts in range(events, 1, -1) if events % parts == 0):
        end, _ = follow(start, orbit.period_time / parts, tolerance)
        apart, size = np.abs(_numbers(end) - _numbers(start)).max(), np.abs(_numbers(start)).max()
        if apart <= NEAR * size:
            return close_orbit(start, orbit.period_time / parts, tolerance)
    return orbit


def with_lengths(
    cases: Sequence[Case], transient: float, observed: float, sampling: Sampling, report: Report
) -> tuple[list[ChainState], np.ndarray]:
    """Chains after a transient, and lengths (W,) through which they come down from then on."""
    # every motion comes down through its mean length again and again, once it has loaded
    chains, rest = integrator_of(cases, sampling=sampling), cases[0].parameters.rest_positions[-1]
    moments = LengthMoments(len(cases), chains.time + 0.5 * transient)
    if transient > 0:
        observe(chains, transient, [moments], report)
    states, lengths = chains.state(), moments.result(rest)["mean_length"]
    loading = np.array([loading_time(case.parameters, case.state.positions) for case in cases])
    if np.any(loads := 0.5 * transient < loading):  # it is looked for in what comes then
        whole = [loading_time(one.parameters, one.parameters.rest_positions) for one in cases]
        ahead = loading.max() + _AHEAD * max(*whole, slow_unit(cases[0].parameters))
        later = LengthMoments(len(cases), chains.time + loading.max())
        observe(chains, min(observed, ahead), [later], lambda done: None)
        lengths = np.where(loads, later.result(rest)["mean_length"], lengths)
    rule = [section_position(case.parameters) for case in cases]
    return states, np.where(np.isfinite(lengths), lengths, rule)


def loading_time(chain: ChainParameters, positions: np.ndarray) -> float:
    """Model time in which the belt brings a chain to where springs balance friction."""
    return float(balance_length(chain) - positions[-1]) / chain.belt_velocity


def check_exact(cases: Sequence[Case]) -> None:
    """That cases have a tangent dynamics, and no noise, so that their states can come back."""
    check_method(cases)
    for noise in (case.parameters.noise for case in cases):
        if noise > 0:
            raise InputError(f"noise = {noise:g}: must be 0, with noise no state comes back")


def close_orbit(
    state: ChainState, period_time: float, tolerance: float | None = None
) -> PeriodicOrbit:
    """The periodic orbit near a state that about comes back after some time, by Newton's method.

    Orbits that do not attract are found too. A multiple of a period is taken as it is given.
    """
    start = _most_stuck(state, period_time, tolerance)
    start, period_time, monodromy, residual = _closed(start, period_time, tolerance)
    lengths = moments_of_orbit(start, period_time, tolerance)
    log = ReturnLog(1)
    advanced([exact_case(start, tolerance)], period_time, log, length=lengths["mean_length"])
    return PeriodicOrbit(
        parameters=state.parameters,
        state=start,
        period_time=period_time,
        period_events=len(log.slips(0)[0]),
        period_returns=len(log.returns(0)[0]),
        monodromy=monodromy,
        multipliers=_multipliers(start, monodromy),
        residual=residual,
        **lengths,
    )


def turned(orbit: PeriodicOrbit, tolerance: float | None = None) -> PeriodicOrbit:
    """The orbit from a time of its period in which fewer blocks are stuck."""
    stuck = int(np.sum(orbit.state.directions == 0))
    state = _most_stuck(orbit.state, orbit.period_time, tolerance, below=stuck)
    _, monodromy = _once_around(state, orbit.period_time, tolerance)
    return replace(orbit, state=state, monodromy=monodromy)


def exact_case(state: ChainState, tolerance: float | None = None) -> Case:
    """A chain from a state on, with a tangent dynamics."""
    return Case(state, METHOD, _TIME_STEP, tolerance)


def advanced(
    cases: Sequence[Case],
    duration: float,
    *observers: Any,
    sampling: Sampling = NO_SAMPLES,
    length: float | None = None,
    report: Report = lambda done: None,
) -> list[ChainState]:
    """States of chains after some time; their returns are those to a length of them."""
    section = None
    if length is not None:
        section = Section(cases[0].parameters.n_blocks, np.full(len(cases), length))
    chains = integrator_of(cases, sampling=sampling, section=section)
    observe(chains, duration, observers, report)
    return chains.state()


def moments_of_orbit(
    start: ChainState, period_time: float, tolerance: float | None
) -> dict[str, float]:
    """r and <x_N> over the period."""
    interval = _SAMPLE_INTERVAL / times_as_fast(start.parameters)
    sampling = Sampling(1, period_time / int(np.ceil(period_time / interval)))
    moments = LengthMoments(1)
    advanced([exact_case(start, tolerance)], period_time, moments, sampling=sampling)
    lengths = moments.result(start.parameters.rest_positions[-1])
    return {name: float(lengths[name][0]) for name in MOMENTS}


def follow(
    state: ChainState, duration: float, tolerance: float | None = None
) -> tuple[ChainState, np.ndarray]:
    """The state after some time, and the events on the way, as `Run.events` has them."""
    log = EventLog(1, state.parameters.rest_positions)
    (end,) = advanced([exact_case(state, tolerance)], duration, log)
    return end, event_records(log.events(0))


# A state with given blocks stuck has D coordinates: the displacements of all blocks, and the
# velocities of those that slip. Its other velocities are those of the belt, and stay so.


def _most_stuck(
    state: ChainState, period_time: float, tolerance: float | None, below: float = np.inf
) -> ChainState:
    """A state of the next period in which as many blocks are stuck as ever are, at time 0.

    below : more than are.
    """
    # in the middle of the longest time between two events in which they are, away from the events;
    # a state that is about there already stays where it is
    state = replace(state, time=0.0)
    _, events = follow(state, period_time, tolerance)
    if not len(events):
        raise InputError(
            f"{state.parameters.describe()}: no block sticks or slips in {period_time:g} time "
            "units; equilibrium slip has no orbit of its own"
        )
    changes = np.where(events["kind"] == "stick", 1, -1)
    stuck = np.sum(state.directions == 0) + np.cumsum(changes) - changes  # before each event
    lasting = np.diff(events["time"], prepend=events["time"][-1] - period_time)
    allowed = (lasting > 0) & (stuck < below)
    if not allowed.any():
        raise InputError(f"below = {below:g}: so few blocks are never stuck")
    most = stuck == stuck[allowed].max()
    longest = int(np.argmax(np.where(most, lasting, -1.0)))
    middle = float(events["time"][longest] - lasting[longest] / 2)
    if abs(middle) > _OFF_MIDDLE * lasting[longest]:
        state, _ = follow(state, middle % period_time, tolerance)
    return replace(state, time=0.0, scheme=None)


def _closed(
    start: ChainState, period_time: float, tolerance: float | None
) -> tuple[ChainState, float, np.ndarray, float]:
    """A state of the orbit that closes after about a period, the period, tangent map, residual."""
    best, least, about = None, np.inf, period_time
    chain = start.parameters  # a single block may be anywhere, where its spring is slack too
    stretch = chain.by_block("static_friction") / chain.by_block("stiffness")
    size = float(max(np.abs(coordinates(start)).max(), stretch.max()))
    for _ in range(_STEPS):
        end, matrix = _once_around(start, period_time, tolerance)
        if not (np.array_equal(end.directions, start.directions) and np.isfinite(matrix).all()):
            break
        apart = coordinates(end) - coordinates(start)
        residual = float(np.abs(apart).max()) / size
        if residual >= least:
            break
        best, least = (start, period_time, matrix, residual), residual
        change, longer = closing(matrix, flow(start), apart)
        start, period_time = shifted(start, change), period_time + longer
        if abs(period_time - about) > _NEAR * about:
            break
    if best is None or least > CLOSED:
        raise InputError(
            f"{start.parameters.describe()}: no orbit closes near the state after about the time "
            f"{about:g}"
        )
    return best


def closing(matrix: np.ndarray, rates: np.ndarray, apart: np.ndarray) -> tuple[np.ndarray, float]:
    """By how much a state (D,) and its period must change to close what is `apart` after it."""
    # The state z and the period T change by dz and dT, so that the end P of the period comes to
    # P + M dz + f dT = z + dz, with the tangent map M and the flow f. The change dz is across f.
    rows = np.block([[matrix - np.eye(len(rates)), rates[:, None]], [rates[None], np.zeros(1)]])
    change = np.linalg.lstsq(rows, -np.append(apart, 0.0))[0]
    return change[:-1], float(change[-1])


def _multipliers(state: ChainState, monodromy: np.ndarray) -> np.ndarray:
    """The 2N multipliers of an orbit through a state, largest modulus first."""
    # The monodromy matrix maps the flow to itself: that is the trivial multiplier. What it does to
    # deviations across the flow, seen along the flow, is the return map of the section.
    across = np.linalg.svd(flow(state)[None])[2][1:]
    values = np.linalg.eigvals(across @ monodromy @ across.T).astype(complex)
    erased = np.zeros(np.sum(state.directions == 0))
    values = np.concatenate([[1.0], values, erased])
    return values[np.argsort(-np.abs(values), kind="stable")]


def _once_around(
    start: ChainState, period_time: float, tolerance: float | None
) -> tuple[ChainState, np.ndarray]:
    """The state after a period, and the tangent map (D, D) in the coordinates."""
    free = _free(start)
    chain = with_vectors([start], exact_case(start, tolerance), len(free))
    chain.set_deviations(np.eye(2 * chain.n_blocks)[None, :, free])
    observe(chain, period_time, [], lambda done: None)
    return chain.state()[0], chain.deviations()[0][free]


def _numbers(state: ChainState) -> np.ndarray:
    return np.concatenate([state.displacements, state.relative_velocities])


def _free(state: ChainState) -> np.ndarray:
    """Which of these 2N are coordinates: all but the velocities of stuck blocks."""
    slipping = state.directions != 0
    return np.flatnonzero(np.concatenate([np.ones_like(slipping), slipping]))


def coordinates(state: ChainState) -> np.ndarray:
    """The D numbers of a state that can be chosen freely."""
    return _numbers(state)[_free(state)]


def flow(state: ChainState) -> np.ndarray:
    """Rates at which the coordinates change: velocities, and accelerations of slipping blocks."""
    moving = state.relative_velocities, state.directions
    rates = acceleration(state.positions, *moving, state.parameters)
    return np.concatenate([state.velocities, rates])[_free(state)]


def shifted(state: ChainState, change: np.ndarray) -> ChainState:
    """The state with other coordinates."""
    numbers = _numbers(state)
    numbers[_free(state)] += change
    displacements, velocities = np.split(numbers, 2)
    return replace(state, displacements=displacements, relative_velocities=velocities)
