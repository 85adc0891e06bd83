"""What motion a chain ends in: equilibrium slip, periodic, quasi-periodic, chaotic, transient."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.chaos.clocks import REST, integrator_by
from beltrepro.chaos.vectors import (
    METHOD,
    check_method,
    grow,
    slopes,
    standard_errors,
    with_vectors,
)
from beltrepro.engine.integrator import Sampling, Section
from beltrepro.engine.state import ChainState
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.model import ChainParameters
from beltrepro.model.section import section_position
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.sections import ReturnLog
from beltrepro.simulation import arguments
from beltrepro.simulation.arguments import PerChain
from beltrepro.simulation.checkpoints import once
from beltrepro.simulation.points import Point, Progress, groups, integrator_of, observe, points
from beltrepro.stats.errors import NotEnoughDataError
from beltrepro.stats.motion import name_motion
from beltrepro.stats.recurrence import find_recurrence

_SAMPLES = Sampling(1, 0.1)  # for r
_VECTORS = 2  # the largest exponents: one may be that of the motion itself
_ALIGNED = 0.1  # first share of the observation, in which the vectors turn to their directions
_END = 0.5  # last share of it, in which blocks must turn for the motion not to be equilibrium slip


@dataclass(frozen=True)
class Motion:
    """The motion in which a chain ends.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    state : str
        "equilibrium slip", "periodic", "quasi-periodic", "chaotic", "transient" or, with noise,
        "noise-driven"; see `beltrepro.stats.motion.name_motion`.
    period_time : float
        Length of a period, model time; NaN if the orbit does not close.
    period_events : int
        Slips of all blocks in a period; 0 if it does not close.
    largest_exponent, standard_error : float
        Largest Lyapunov exponent per model time after the transient, and its error.
    disorder_parameter, mean_length : float
        r (Eq. 4) and <x_N> after the transient.
    """

    parameters: ChainParameters
    state: str
    period_time: float
    period_events: int
    largest_exponent: float
    standard_error: float
    disorder_parameter: float
    mean_length: float


@names.checked
def classify(
    parameters: ChainParameters,
    *,
    duration: float,
    transient: float,
    method: str = METHOD,
    time_step: float = 0.001,
    tolerance: float | None = None,
    seed: int = 1,
    replicate: int = 1,
    initial_spread: float = 1.0,
    noise_clock: str = REST,
    progress: Progress | None = None,
) -> Motion:
    """Tell what kind of motion one chain ends in.

    The chain starts from undeformed springs with a random displacement of each block, because
    several motions can coexist. Another seed gives another start. With replicate 0 the chain starts
    from undeformed springs as they are, and without noise the seed then decides nothing.

    Parameters
    ----------
    parameters : ChainParameters
        The chain.
    duration : float
        Model time of the run, the transient included.
    transient : float
        The first part of it; the motion after it is judged. A period can be found that fits in
        twice.
    method : str
        "event", the only one with a tangent dynamics.
    time_step : float
        dt, model time; it only sets the strength of the noise.
    tolerance : float or None
        Truncation of the series, as in `simulate`.
    seed, replicate : int
        Of 0 or greater; with the parameters they fix all random numbers, the start among them.
    initial_spread : float
        Standard deviation of the random displacements of replicates other than 0, model length.
    noise_clock : str
        As in `lyapunov_spectrum`.
    progress : callable
        Called with the fraction done.

    Returns
    -------
    Motion
        Its name, period, largest exponent, r and <x_N>.

    Raises
    ------
    InputError
        A value is not allowed.
    ModelStateError
        A state left the range of the model.
    """
    arguments.of_one_chain(
        parameters,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=checks.key("seed", seed),
        replicate=checks.key("replicate", replicate),
        initial_spread=initial_spread,
    )
    found = motions(
        parameters,
        duration=duration,
        transient=transient,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=seed,
        replicate=replicate,
        initial_spread=initial_spread,
        noise_clock=noise_clock,
        progress=progress,
    )
    return Motion(parameters, **{name: found[name][0].item() for name in _MEASURED})


_MEASURED = (
    "state",
    "period_time",
    "period_events",
    "largest_exponent",
    "standard_error",
    "disorder_parameter",
    "mean_length",
)


@names.checked
def motions(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    transient: float,
    method: PerChain[str] = METHOD,
    time_step: PerChain[float] = 0.001,
    tolerance: PerChain[float | None] = None,
    seed: PerChain[int] | None = None,
    replicate: PerChain[int] | None = None,
    initial_positions: ArrayLike | Sequence[ArrayLike] | None = None,
    initial_spread: PerChain[float] = 0.0,
    initial_state: PerChain[ChainState] | None = None,
    noise_clock: str = REST,
    progress: Progress | None = None,
) -> dict[str, np.ndarray]:
    """Tell what kind of motion each of P chains ends in.

    Parameters
    ----------
    parameters : ChainParameters or sequence of them
        P chains.
    duration : float
        Model time of each run, the transient included.
    transient : float
        The first part of it; the motion after it is judged.
    method : str
        "event", the only one with a tangent dynamics.
    time_step : float
        dt, model time; it only sets the strength of the noise.
    tolerance : float or None
        Truncation of the series, as in `simulate`.
    seed, replicate : int
        Of 0 or greater; with the parameters they fix all random numbers. 1 and 0 if not given.
    initial_positions : array (N,), or a sequence of such arrays for a sequence of chains
        Positions of the blocks at t = 0, model length; undeformed springs if not given.
    initial_spread : float
        Standard deviation of normal deviates that are added to the initial positions of replicates
        other than 0, model length.
    initial_state : ChainState
        Where to go on, instead of these.
    noise_clock : str
        As in `lyapunov_spectrum`.
    progress : callable
        Called with the fraction done.

    Returns
    -------
    dict of arrays (P,)
        The fields of `Motion`: state, period_time, period_events, largest_exponent,
        standard_error, disorder_parameter, mean_length; and period_returns, the number of returns
        to the section in a period.

    Raises
    ------
    InputError
        A value is not allowed.
    ModelStateError
        A state left the range of the model.
    """
    duration, transient = arguments.lengths(duration, transient)
    chains = points(
        parameters,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=seed,
        replicate=replicate,
        initial_positions=initial_positions,
        initial_spread=initial_spread,
        initial_state=initial_state,
    )
    check_method(chains)
    integrator_by(noise_clock)
    rows: list[dict] = [{}] * len(chains)
    for group, report in groups(chains, progress):
        members = [chains[index] for index in group]
        for index, row in zip(
            group, once(_judge, members, duration, transient, noise_clock, report), strict=True
        ):
            rows[index] = row
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _judge(
    members: list[Point], duration: float, transient: float, noise_clock: str, report: Progress
) -> list[dict]:
    """A row for each point of a group."""
    chains = _after(
        members, transient, noise_clock, lambda fraction: report(fraction * transient / duration)
    )
    observed = duration - transient
    half = chains.time + (1 - _END) * observed
    moments, log = LengthMoments(len(members), chains.time), ReturnLog(len(members))
    growth = grow(
        chains,
        observed,
        [moments, log],
        lambda done: report((transient + done * observed) / duration),
    )
    growth = growth[:, int(_ALIGNED * growth.shape[1]) :]
    exponents, errors = slopes(growth), standard_errors(growth)
    length = moments.result(members[0].parameters.rest_positions[-1])
    found = []
    for lane, point in enumerate(members):
        period, n_returns = _period(log, lane)
        state = name_motion(
            turns=bool(log.last_event[lane] > half),
            closed=bool(period["period_returns"]),
            exponents=exponents[lane],
            standard_error=errors[lane],
            time=(1 - _ALIGNED) * observed,
            returns=n_returns,
            noisy=point.parameters.noise > 0,
        )
        first = int(np.argmax(exponents[lane]))
        found.append(
            {
                "state": state,
                **period,
                "largest_exponent": exponents[lane, first],
                "standard_error": errors[lane, first],
                "disorder_parameter": length["disorder_parameter"][lane],
                "mean_length": length["mean_length"][lane],
            }
        )
    return found


def _after(
    members: list[Point], transient: float, noise_clock: str, report: Progress
) -> TangentIntegrator:
    """The chains after the transient, with vectors, and a section at their mean length."""
    # every motion comes down through its mean length again and again
    chain = members[0].parameters
    before = integrator_of(members, sampling=_SAMPLES, sampled_blocks=1)
    positions = np.full(len(members), section_position(chain))
    if transient > 0:
        lengths = LengthMoments(len(members), before.time + 0.5 * transient)
        observe(before, transient, [lengths], report)
        mean = lengths.result(chain.rest_positions[-1])["mean_length"]
        positions = np.where(np.isfinite(mean), mean, positions)
    size = min(_VECTORS, 2 * chain.n_blocks)
    section = Section(chain.n_blocks, positions)
    return with_vectors(before, members, size, _SAMPLES, section, noise_clock)


def _period(log: ReturnLog, lane: int) -> tuple[dict, int]:
    """The period of the returns of a chain, and how many returns there are."""
    times, states, slips = log.returns(lane)
    try:
        closed = find_recurrence(states, times)
    except NotEnoughDataError:
        closed = None
    if closed is None:
        return {"period_time": np.nan, "period_events": 0, "period_returns": 0}, len(times)
    period = {
        "period_time": closed.time,
        "period_events": int(slips[-1] - slips[-1 - closed.crossings]),
        "period_returns": closed.crossings,
    }
    return period, len(times)
