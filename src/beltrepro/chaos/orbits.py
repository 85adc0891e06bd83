"""Periodic orbits as such: found by recurrence, closed by Newton's method, with their multipliers.

A deviation from a state of the orbit is carried once around by the monodromy matrix M, the tangent
map over one period. Its 2N eigenvalues are the multipliers of the orbit (docs/chaos.md).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from beltrepro import checks
from beltrepro.analysis.errors import NotEnoughDataError
from beltrepro.analysis.recurrence import CLOSED, find_recurrence
from beltrepro.chaos.vectors import METHOD, NO_SAMPLES
from beltrepro.engine.integrator import Integrator, Sampling, Section
from beltrepro.engine.state import ChainState
from beltrepro.engine.tangent_integrator import TangentIntegrator
from beltrepro.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.returns import ReturnLog
from beltrepro.simulation import Run, arguments, simulate
from beltrepro.simulation.points import Point, Progress, integrator_of, observe

_STEPS = 8  # of Newton's method, which needs two or three from a state that has come back to 1e-8
_AT_ONCE = 1e-9  # share of the period
_TIME_STEP = 0.001  # of no effect without noise
_SAMPLE_INTERVAL = 0.1  # model time, about: of the samples of x_N for r


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbit:
    """A closed orbit of a chain without noise.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    state : ChainState
        A state of the orbit, at an instant at which as many blocks are stuck as ever are. The
        section is the plane through it across the motion, in the space of the states with these
        blocks stuck.
    period_time : float
        Length of the period T, model time.
    period_events : int
        Slips of all blocks in it.
    period_returns : int
        Returns of the last block, coming down, to the mean length of the chain.
    monodromy : array (D, D)
        Tangent map over one period, in the coordinates of the state: displacements of all blocks,
        then velocities of those that slip there.
    multipliers : array (2N,) of complex
        Eigenvalues of the tangent map over one period, largest modulus first. One belongs to a
        shift of time and is exactly 1. Those of directions that a stick erases are exactly 0.
    residual : float
        Distance of the state after one period from the state, as a share of its largest coordinate.
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
        """
        return _run(self.state, self.period_time, sample_interval=sample_interval)

    def __repr__(self) -> str:
        return (
            f"PeriodicOrbit({self.parameters.describe()}: period {self.period_time:.10g}, "
            f"{self.period_events} slips, |mu| = {abs(self.largest_multiplier):.3g})"
        )


def periodic_orbit(
    parameters: ChainParameters,
    *,
    duration: float,
    transient: float,
    tolerance: float | None = None,
    seed: int = 1,
    replicate: int = 1,
    initial_positions: ArrayLike | None = None,
    initial_spread: float = 1.0,
    initial_state: ChainState | None = None,
    progress: Progress | None = None,
) -> PeriodicOrbit:
    """The periodic orbit in which a chain ends.

    The chain is followed until its state comes back (`beltrepro.analysis.recurrence`), and the
    orbit is closed from there by `close_orbit`. Start and random numbers are as in `classify`.

    Parameters
    ----------
    parameters : ChainParameters
        The chain, without noise.
    duration : float
        Model time of the run, the transient included.
    transient : float
        The first part of it, in which the chain may settle. A period can be found that fits twice
        in the rest.
    tolerance : float or None
        Truncation of the series, as in `simulate`.
    seed, replicate : int
        Of 0 or greater; they fix the random displacements at the start.
    initial_positions : array (N,)
        Positions of the blocks at t = 0, model length; undeformed springs if not given.
    initial_spread : float
        Standard deviation of the random displacements of replicates other than 0, model length.
    initial_state : ChainState
        Where to go on, instead of these.
    progress : callable
        Called with the fraction done.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    InputError
        A value is not allowed, the chain has noise, or its state does not come back.
    ModelStateError
        A state left the range of the model.
    """
    if not isinstance(parameters, ChainParameters):
        raise InputError(f"parameters = {parameters!r}: a ChainParameters is needed")
    _check_noise(parameters)
    duration, transient = arguments.lengths(duration, transient)
    report = progress or (lambda done: None)
    if transient == 0:
        raise InputError("transient = 0: must be greater than 0, a chain needs time to settle")
    given = initial_state is not None
    settled = simulate(
        parameters,
        duration=transient,
        transient=transient / 2,
        method=METHOD,
        sample_interval=None,
        tolerance=tolerance,
        seed=None if given else seed,
        replicate=None if given else replicate,
        initial_positions=initial_positions,
        initial_spread=0.0 if given else initial_spread,
        initial_state=initial_state,
        progress=lambda done: report(done * transient / duration),
    )
    observed = duration - transient
    state, period_time = _recurrence(
        settled, observed, lambda done: report((transient + done * observed) / duration)
    )
    return close_orbit(state, period_time, tolerance=tolerance)


def close_orbit(
    state: ChainState, period_time: float, *, tolerance: float | None = None
) -> PeriodicOrbit:
    """The periodic orbit near a state that about comes back after some time.

    Newton's method, with the tangent map as derivative, moves the state and the time until the
    orbit closes. Orbits that do not attract are found too. A multiple of a period is taken as it
    is given.

    Parameters
    ----------
    state : ChainState
        Near the orbit, of a chain without noise.
    period_time : float
        About the length of the period, model time.
    tolerance : float or None
        Truncation of the series, as in `simulate`.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    InputError
        The chain has noise, no block slips and sticks, or no orbit closes nearby.
    ModelStateError
        A state left the range of the model.
    """
    if not isinstance(state, ChainState):
        raise InputError(f"state = {state!r}: a ChainState is needed")
    _check_noise(state.parameters)
    period_time = checks.positive("period_time", period_time)
    tolerance = arguments.tolerance("tolerance", tolerance)
    start = _most_stuck(state, period_time, tolerance)
    start, period_time, matrix, residual = _closed(start, period_time, tolerance)
    lengths, returns = _measured(start, period_time, tolerance)
    slips = _run(start, period_time, tolerance=tolerance).events["kind"] == "slip"
    return PeriodicOrbit(
        parameters=state.parameters,
        state=start,
        period_time=period_time,
        period_events=int(slips.sum()),
        period_returns=returns,
        monodromy=matrix,
        multipliers=_multipliers(matrix, _flow(start), 2 * state.parameters.n_blocks),
        residual=residual,
        disorder_parameter=float(lengths["disorder_parameter"][0]),
        mean_length=float(lengths["mean_length"][0]),
    )


def _check_noise(parameters: ChainParameters) -> None:
    if parameters.noise > 0:
        raise InputError(f"noise = {parameters.noise:g}: must be 0, with noise no state comes back")


def _recurrence(settled: Run, observed: float, report: Progress) -> tuple[ChainState, float]:
    """Follow a chain from the end of a run; its state at last, and its period."""
    # every motion comes down through its mean length again and again
    section = Section(settled.parameters.n_blocks, np.array([settled.mean_length]))
    chain = _integrator(settled.final_state, settled.tolerance, NO_SAMPLES, section)
    log = ReturnLog(1)
    observe(chain, observed, [log], report)
    times, states, _ = log.returns(0)
    try:
        closed = find_recurrence(states, times)
    except NotEnoughDataError:
        closed = None
    if closed is None:
        raise InputError(
            f"{settled.parameters.describe()}: no state comes back in the last {observed:g} time "
            "units; the motion has not settled, or not on a periodic orbit"
        )
    return chain.state()[0], closed.time


def _integrator(
    state: ChainState, tolerance: float | None, sampling: Sampling, section: Section | None = None
) -> Integrator:
    """One chain by itself."""
    point = Point(state, METHOD, _TIME_STEP, tolerance)
    return integrator_of([point], sampling=sampling, sampled_blocks=1, section=section)


def _run(
    state: ChainState,
    duration: float,
    *,
    tolerance: float | None = None,
    sample_interval: float | None = None,
) -> Run:
    """The chain from a state on."""
    return simulate(
        state.parameters,
        duration=duration,
        method=METHOD,
        time_step=_TIME_STEP,
        tolerance=tolerance,
        initial_state=state,
        sample_interval=sample_interval,
    )


# --- closing the orbit ---
#
# A state with given blocks stuck has as coordinates the displacements of all blocks and the
# velocities of the slipping ones. Its other velocities are those of the belt, and stay so.


def _most_stuck(state: ChainState, period_time: float, tolerance: float | None) -> ChainState:
    """A state of the next period in which as many blocks are stuck as ever are, at time 0.

    In the middle of the longest time between two events in which they are, away from the events. A
    state that is there already stays where it is.
    """
    state = dataclasses.replace(state, time=0.0)
    events = _run(state, period_time, tolerance=tolerance).events
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
        state = _run(state, middle % period_time, tolerance=tolerance).final_state
    return dataclasses.replace(state, time=0.0, scheme=None)


def _closed(
    start: ChainState, period_time: float, tolerance: float | None
) -> tuple[ChainState, float, np.ndarray, float]:
    """Newton's method; the best state, its period, monodromy matrix and residual.

    The state z and the period T change by dz and dT, so that the end comes to
    end + M dz + f dT = z + dz, with f the flow. The change dz is across the flow: f dz = 0.
    """
    size = float(np.abs(_coordinates(start)).max())
    best, least = None, np.inf
    for _ in range(_STEPS):
        end, matrix = _once_around(start, period_time, tolerance)
        if not np.array_equal(end.directions, start.directions):
            break
        apart, flow = _coordinates(end) - _coordinates(start), _flow(start)
        residual = float(np.abs(apart).max()) / size
        if residual >= least:
            break
        best, least = (start, period_time, matrix, residual), residual
        rows = np.block([[matrix - np.eye(len(flow)), flow[:, None]], [flow[None], np.zeros(1)]])
        change = np.linalg.lstsq(rows, -np.append(apart, 0.0))[0]
        start, period_time = _shifted(start, change[:-1]), period_time + float(change[-1])
    if best is None or least > CLOSED:
        raise InputError(
            f"{start.parameters.describe()}: no orbit closes near the state after about the time "
            f"{period_time:g}"
        )
    return best


def _once_around(
    start: ChainState, period_time: float, tolerance: float | None
) -> tuple[ChainState, np.ndarray]:
    """The state after a period, and the tangent map (D, D) in the coordinates of the start."""
    free = _free(start)
    chain = TangentIntegrator(
        [start],
        n_vectors=len(free),
        time_step=_TIME_STEP,
        sampling=NO_SAMPLES,
        sampled_blocks=1,
        **Point(start, METHOD, _TIME_STEP, tolerance).accuracy,
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


# --- what is known of a closed orbit ---


def _multipliers(matrix: np.ndarray, flow: np.ndarray, count: int) -> np.ndarray:
    """Eigenvalues of the monodromy matrix, those of the erased directions and the trivial one.

    M maps the flow to itself. What it does to the deviations across the flow, seen along the flow,
    has the other eigenvalues: it is the return map of the section.
    """
    across = np.linalg.svd(flow[None])[2][1:]
    found = np.linalg.eigvals(across @ matrix @ across.T).astype(complex)
    erased = np.zeros(count - len(flow))
    found = np.concatenate([[1.0], found, erased])
    return found[np.argsort(-np.abs(found), kind="stable")]


def _measured(
    start: ChainState, period_time: float, tolerance: float | None
) -> tuple[dict[str, np.ndarray], int]:
    """Moments of x_N over the period, and the returns to its mean."""
    count = int(np.ceil(period_time / _SAMPLE_INTERVAL))
    moments, log = LengthMoments(1), ReturnLog(1)
    sampled = _integrator(start, tolerance, Sampling(1, period_time / count))
    observe(sampled, period_time, [moments], lambda done: None)
    chain = start.parameters
    lengths = moments.result(chain.rest_positions[-1])
    section = Section(chain.n_blocks, lengths["mean_length"])
    crossing = _integrator(start, tolerance, NO_SAMPLES, section)
    observe(crossing, period_time, [log], lambda done: None)
    return lengths, len(log.returns(0)[0])
