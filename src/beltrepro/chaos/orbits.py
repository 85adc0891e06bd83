"""Periodic orbits as such: found by recurrence, closed by Newton's method, with their multipliers.

A deviation from a state of the orbit is carried once around by the monodromy matrix, the tangent
map over one period. Its 2N eigenvalues are the multipliers of the orbit (docs/chaos.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Unpack

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.chaos.closing import TIME_STEP, closed, follow, most_stuck, multipliers
from beltrepro.chaos.vectors import METHOD, NO_SAMPLES, check_method
from beltrepro.engine.integrator import Integrator, Sampling, Section
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.sections import ReturnLog
from beltrepro.simulation import Run, simulate
from beltrepro.simulation.groups import Report, check_progress, integrator_of, observe
from beltrepro.simulation.setup import (
    Case,
    Chains,
    Keywords,
    check_lengths,
    check_tolerance,
    setup_of,
    with_setup,
)
from beltrepro.stats.errors import NotEnoughDataError
from beltrepro.stats.recurrence import find_recurrence

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
            The interval is not allowed, or its samples need more memory than there is.
        """
        return follow(self.state, self.period_time, sample_interval=sample_interval)

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
    **setup: Unpack[Keywords],
) -> PeriodicOrbit:
    """The periodic orbit in which a chain ends.

    The chain is followed until its state comes back (`beltrepro.stats.recurrence`), and the
    orbit is closed from there by `close_orbit`.

    Parameters
    ----------
    chains : ChainParameters or Setup
        One run of one chain, without noise.
    duration : float
        Model time of the run, the transient included.
    transient : float
        The first part of it, in which the chain may settle. A period can be found that fits twice
        in the rest.
    progress : callable, optional
        Called with the fraction done.
    **setup
        The keywords of `Setup`; the method must be "event".

    Returns
    -------
    PeriodicOrbit
        With its multipliers.

    Raises
    ------
    InputError
        A value is not allowed, the chain has noise, or its state does not come back.
    ModelStateError
        A state left the range of the model.
    """
    made = setup_of(chains, setup)
    if len(made.cases) > 1:
        raise InputError(f"chains = {checks.shown(chains)}: one run of one chain is needed")
    (case,) = made.cases
    check_method(made.cases)
    _check_noise(case.parameters)
    duration, transient = check_lengths(duration, transient)
    if transient == 0:
        raise InputError("transient = 0: must be greater than 0, a chain needs time to settle")
    check_progress(progress)
    report = progress or (lambda done: None)
    settled = simulate(
        made,
        duration=transient,
        transient=transient / 2,
        sample_interval=None,
        progress=lambda done: report(done * transient / duration),
    )
    settled = settled[0] if isinstance(settled, list) else settled
    observed = duration - transient
    state, period_time = _recurrence(
        settled, observed, lambda done: report((transient + done * observed) / duration)
    )
    return close_orbit(state, period_time, tolerance=case.tolerance)


@names.checked
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
        With its multipliers.

    Raises
    ------
    InputError
        The chain has noise, no block slips and sticks, or no orbit closes nearby.
    ModelStateError
        A state left the range of the model.
    """
    if not isinstance(state, ChainState):
        raise InputError(f"state = {checks.shown(state)}: a ChainState is needed")
    _check_noise(state.parameters)
    period_time = checks.positive("period_time", period_time)
    tolerance = check_tolerance("tolerance", tolerance)
    start = most_stuck(state, period_time, tolerance)
    orbit = closed(start, period_time, tolerance)
    start, period_time = orbit.state, orbit.period_time
    lengths, returns = _measured(start, period_time, tolerance)
    slips = follow(start, period_time, tolerance=tolerance).events["kind"] == "slip"
    return PeriodicOrbit(
        parameters=state.parameters,
        state=start,
        period_time=period_time,
        period_events=int(slips.sum()),
        period_returns=returns,
        monodromy=orbit.monodromy,
        multipliers=multipliers(start, orbit.monodromy),
        residual=orbit.residual,
        disorder_parameter=float(lengths["disorder_parameter"][0]),
        mean_length=float(lengths["mean_length"][0]),
    )


def _check_noise(parameters: ChainParameters) -> None:
    if parameters.noise > 0:
        raise InputError(f"noise = {parameters.noise:g}: must be 0, with noise no state comes back")


def _recurrence(settled: Run, observed: float, report: Report) -> tuple[ChainState, float]:
    """Follow a chain from the end of a run; its state at last, and its period."""
    # every motion comes down through its mean length again and again
    section = Section(settled.parameters.n_blocks, np.array([settled.mean_length]))
    chain = _integrator(settled.final_state, settled.tolerance, NO_SAMPLES, section)
    log = ReturnLog(1)
    observe(chain, observed, [log], report)
    times, states, _ = log.returns(0)
    try:
        recurrence = find_recurrence(states, times)
    except NotEnoughDataError:
        recurrence = None
    if recurrence is None:
        raise InputError(
            f"{settled.parameters.describe()}: no state comes back in the last {observed:g} time "
            "units; the motion has not settled, or not on a periodic orbit"
        )
    return chain.state()[0], recurrence.time


def _integrator(
    state: ChainState, tolerance: float | None, sampling: Sampling, section: Section | None = None
) -> Integrator:
    """One chain by itself."""
    case = Case(state, METHOD, TIME_STEP, tolerance)
    return integrator_of([case], sampling=sampling, section=section)


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
