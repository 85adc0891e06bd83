"""What motion a chain ends in: equilibrium slip, periodic, quasi-periodic, chaotic, transient."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from beltrepro.analysis.errors import NotEnoughDataError
from beltrepro.analysis.motion import name_motion
from beltrepro.analysis.recurrence import Recurrence, find_recurrence
from beltrepro.engine.integrator import Section
from beltrepro.engine.records import EVENT_SLIP, EVENT_TIME
from beltrepro.engine.tangent_integrator import TangentIntegrator
from beltrepro.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.model.section import section_position
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.sections import CrossingLog
from beltrepro.observe.slips import EventLog
from beltrepro.simulation import arguments, tangents
from beltrepro.simulation.arguments import PerChain
from beltrepro.simulation.lyapunov import METHOD
from beltrepro.simulation.points import Point, Progress, groups, integrator_of, observe, points

_VECTORS = 2  # the largest exponents: one may be that of the motion itself
_ALIGNED = 0.1  # first share of the observation, in which the vectors turn to their directions
_END = 0.5  # last share of it, in which blocks must turn for the motion not to be equilibrium slip


@dataclass(frozen=True)
class Motion:
    """The motion in which a chain ends.

    Parameters
    ----------
    parameters : ChainParameters
        The chain.
    state : str
        "equilibrium slip", "periodic", "quasi-periodic", "chaotic" or "transient", see
        `beltrepro.analysis.motion.name_motion`.
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


def classify(
    parameters: ChainParameters,
    *,
    duration: float,
    transient: float,
    method: str = METHOD,
    time_step: float = 0.001,
    tolerance: float | None = None,
    seed: int = 1,
    replicate: int = 0,
    initial_positions=None,
    initial_spread: float = 0.0,
    initial_state=None,
    progress: Progress | None = None,
) -> Motion:
    """Tell what kind of motion one chain ends in.

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
    time_step, tolerance, seed, replicate, initial_positions, initial_spread, initial_state
        As in `simulate`.
    progress : callable
        Called with the fraction done.

    Returns
    -------
    Motion

    Raises
    ------
    InputError
        A value is not allowed.
    ModelStateError
        A state left the range of the model.
    """
    if not isinstance(parameters, ChainParameters):
        raise InputError(f"parameters = {parameters!r}: a ChainParameters is needed")
    found = motions(
        parameters,
        duration=duration,
        transient=transient,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=seed,
        replicate=replicate,
        initial_positions=initial_positions,
        initial_spread=initial_spread,
        initial_state=initial_state,
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


def motions(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    transient: float,
    method: PerChain[str] = METHOD,
    time_step: PerChain[float] = 0.001,
    tolerance: PerChain[float | None] = None,
    seed: PerChain[int | None] = None,
    replicate: PerChain[int | None] = None,
    initial_positions=None,
    initial_spread: PerChain[float] = 0.0,
    initial_state=None,
    progress: Progress | None = None,
) -> dict[str, np.ndarray]:
    """Tell what kind of motion each of P chains ends in.

    Parameters
    ----------
    parameters : ChainParameters or sequence of them
        P chains.
    duration, transient, method, time_step, tolerance, seed, replicate
        As in `classify`.
    initial_positions, initial_spread, initial_state, progress
        As in `simulate`.

    Returns
    -------
    dict of arrays (P,)
        The fields of `Motion`: state, period_time, period_events, largest_exponent,
        standard_error, disorder_parameter, mean_length; and period_crossings, the crossings of the
        section in a period.

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
    for point in chains:
        if point.method != METHOD:
            raise InputError(f"method = {point.method!r}: only {METHOD!r} has a tangent dynamics")
    rows: list[dict] = [{}] * len(chains)
    for group, report in groups(chains, progress):
        members = [chains[index] for index in group]
        for index, row in zip(group, _judge(members, duration, transient, report), strict=True):
            rows[index] = row
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _judge(members: list[Point], duration: float, transient: float, report: Progress) -> list[dict]:
    """A row for each point of a group."""
    chain, width = members[0].parameters, len(members)
    chains = _after(members, transient, lambda fraction: report(fraction * transient / duration))
    begin, observed = chains.time, duration - transient
    moments, events = LengthMoments(width, begin), EventLog(width, chain.rest_positions)
    crossings = CrossingLog(begin)
    growth = tangents.grow(
        chains,
        observed,
        None,
        [moments, events, crossings],
        lambda time: report((transient + time - begin) / duration),
    )
    growth = growth[:, int(_ALIGNED * growth.shape[1]) :]
    exponents, errors = growth.mean(axis=1), tangents.standard_errors(growth)
    length, rows = moments.result(chain.rest_positions[-1]), crossings.rows(chain.n_blocks)
    found = []
    for lane, point in enumerate(members):
        slips = events.events(lane)
        closed = _recurrence(rows[rows[:, 0] == lane, 1:])
        first = int(np.argmax(exponents[lane]))
        found.append(
            {
                "state": name_motion(
                    turns=bool(np.any(slips[:, EVENT_TIME] > begin + (1 - _END) * observed)),
                    closed=closed is not None,
                    exponents=exponents[lane],
                    standard_error=errors[lane],
                    time=observed,
                    n_trivial=0 if point.parameters.noise > 0 else 1,
                ),
                **_period(closed, slips, chains.time),
                "largest_exponent": exponents[lane, first],
                "standard_error": errors[lane, first],
                "disorder_parameter": length["disorder_parameter"][lane],
                "mean_length": length["mean_length"][lane],
            }
        )
    return found


def _after(members: list[Point], transient: float, report: Progress) -> TangentIntegrator:
    """The chains of a group after the transient, with vectors, and a section at their mean length.

    Every motion comes down through its mean length again and again.
    """
    chain = members[0].parameters
    before = integrator_of(members, sampling=tangents.SAMPLES, sampled_blocks=1)
    positions = np.full(len(members), section_position(chain))
    if transient > 0:
        lengths = LengthMoments(len(members), before.time + 0.5 * transient)
        observe(before, transient, [lengths], report)
        mean = lengths.result(chain.rest_positions[-1])["mean_length"]
        positions = np.where(np.isfinite(mean), mean, positions)
    chains = TangentIntegrator(
        before.state(),
        n_vectors=min(_VECTORS, 2 * chain.n_blocks),
        time_step=members[0].time_step,
        sampling=tangents.SAMPLES,
        sampled_blocks=1,
        section=Section(chain.n_blocks, positions),
        **members[0].accuracy,
    )
    tangents.randomise(chains)
    return chains


def _recurrence(rows: np.ndarray) -> Recurrence | None:
    """The period of the states (K, 2N) in rows of time and state."""
    try:
        return find_recurrence(rows[:, 1:], rows[:, 0])
    except NotEnoughDataError:
        return None


def _period(closed: Recurrence | None, events: np.ndarray, end: float) -> dict:
    if closed is None:
        return {"period_time": np.nan, "period_events": 0, "period_crossings": 0}
    # a whole period of a settled motion, wherever it begins
    within = events[:, EVENT_TIME] > end - closed.time
    return {
        "period_time": closed.time,
        "period_events": int(np.sum(within & (events[:, EVENT_SLIP] > 0))),
        "period_crossings": closed.crossings,
    }
