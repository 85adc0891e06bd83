"""What motion a chain ends in: equilibrium slip, periodic, quasi-periodic, chaotic, transient."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import partial
from typing import Any

import numpy as np

from beltrepro.chaos import vectors
from beltrepro.chaos.periodic_orbits import MOMENTS, moments_of_orbit
from beltrepro.chaos.vectors import REST
from beltrepro.engine.integrator import Sampling, Section
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.model import ChainParameters
from beltrepro.model.spring import section_position
from beltrepro.observe.crossings import ReturnLog
from beltrepro.observe.length import LengthMoments
from beltrepro.simulation.groups import Report, integrator_of, observe
from beltrepro.simulation.results import Results, gathered
from beltrepro.simulation.setup import Case, Chains, check_lengths, setup_of, with_setup
from beltrepro.simulation.tables import Tabled
from beltrepro.stats.motion import PERIODIC, Recurrence, find_recurrence, name_motion

_SAMPLES = Sampling(1, 0.1)  # for r
_VECTORS = 2  # the largest exponents: one may be that of the motion itself
_ALIGNED = 0.1  # first share of the observation, in which the vectors turn to their directions
_END = 0.5  # last share of it, in which blocks must turn for the motion not to be equilibrium slip


@dataclass(frozen=True)
class Motion(Tabled):
    """The motion in which a chain ends.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    state : str
        "equilibrium slip", "periodic", "quasi-periodic", "chaotic", "transient" or, with noise,
        "noise-driven"; see `beltrepro.stats.motion.name_motion`.
    period_time, period_events : float, int
        Model time of a period, NaN if the orbit does not close; slips of all blocks in it, 0 so.
    largest_exponent, standard_error : float
        Largest Lyapunov exponent per model time after the transient, and its error.
    disorder_parameter, mean_length : float
        r (Eq. 4) and <x_N>: of the orbit if the motion is periodic, else after the transient.
    """

    parameters: ChainParameters
    state: str
    period_time: float
    period_events: int
    largest_exponent: float
    standard_error: float
    disorder_parameter: float
    mean_length: float


@with_setup
def classify(
    chains: Chains,
    *,
    duration: float,
    transient: float,
    noise_clock: str = REST,
    progress: Report | None = None,
    **setup: Any,
) -> Motion | Results:
    """Tell what kind of motion one chain ends in, or each of several.

    Several motions can coexist, so where a chain begins may decide. With an `initial_spread` and
    `replicate=range(32)` it begins from undeformed springs, and 31 times elsewhere.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        One chain or P chains.
    duration, transient : float
        Model time of each run, and of its first part; the rest is judged. A period must fit in it
        twice.
    noise_clock : str
        As in `lyapunov_spectrum`.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`; the method must be "event", the only one with a tangent dynamics.

    Returns
    -------
    Motion or Results
        Of one run of one chain its motion; of several arrays (P,) by the names of the fields of
        `Motion`, and period_returns, to the section in a period.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    duration, transient = check_lengths(duration, transient)
    made = setup_of(chains, setup)
    vectors.check_method(made.cases, noise_clock)
    settings: dict = {"duration": duration, "transient": transient, "noise_clock": noise_clock}
    motions = gathered("motion", made, partial(_judged, **settings), progress, **settings)
    if not made.alone:
        return motions
    measured = [field.name for field in fields(Motion)[1:]]
    return Motion(made.cases[0].parameters, **{name: motions[name].item() for name in measured})


def _judged(
    group: np.ndarray,
    members: list[Case],
    report: Report,
    *,
    duration: float,
    transient: float,
    noise_clock: str,
) -> dict[str, np.ndarray]:
    observed, share = duration - transient, transient / duration
    chains = _after(members, transient, noise_clock, vectors.part(report, 0, share))
    half = chains.time + (1 - _END) * observed
    moments, log = LengthMoments(len(members), chains.time), ReturnLog(len(members))
    growth = vectors.grow(chains, observed, [moments, log], vectors.part(report, share, 1))
    growth = growth[:, int(_ALIGNED * growth.shape[1]) :]
    exponents, errors = vectors.slopes(growth), vectors.standard_errors(growth)
    lengths = moments.result(members[0].parameters.rest_positions[-1])
    rows = []
    for lane, case in enumerate(members):
        times, states, slips = log.returns(lane)
        closed = find_recurrence(states, times)
        state = name_motion(
            turns=bool(log.last_event[lane] > half),
            closed=closed is not None,
            exponents=exponents[lane],
            standard_error=errors[lane],
            time=(1 - _ALIGNED) * observed,
            returns=len(times),
            noisy=case.parameters.noise > 0,
        )
        first = int(np.argmax(exponents[lane]))
        row = {
            "state": state,
            **period_of(closed, slips),
            "largest_exponent": exponents[lane, first],
            "standard_error": errors[lane, first],
            **{name: lengths[name][lane] for name in MOMENTS},
        }
        if closed is not None and state == PERIODIC:
            # the motion after the transient may hold irregular motion that came before the orbit
            row |= moments_of_orbit(chains.state()[lane], closed.time, case.tolerance)
        rows.append(row)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _after(
    members: list[Case], transient: float, noise_clock: str, report: Report
) -> TangentIntegrator:
    """The chains after the transient, with vectors, and a section at their mean length."""
    # every motion comes down through its mean length again and again
    chain = members[0].parameters
    before = integrator_of(members, sampling=_SAMPLES)
    positions = np.full(len(members), section_position(chain))
    if transient > 0:
        lengths = LengthMoments(len(members), before.time + 0.5 * transient)
        observe(before, transient, [lengths], report)
        mean = lengths.result(chain.rest_positions[-1])["mean_length"]
        positions = np.where(np.isfinite(mean), mean, positions)
    section = Section(chain.n_blocks, positions)
    settings = _VECTORS, _SAMPLES, section, noise_clock
    return vectors.with_vectors(before.state(), members[0], *settings)


def period_of(closed: Recurrence | None, slips: np.ndarray) -> dict[str, float]:
    """What is told of the period of returns, from the number of slips before each of them."""
    time, events, returns = np.nan, 0, 0
    if closed is not None:
        time, returns = closed.time, closed.crossings
        events = int(slips[-1] - slips[-1 - returns])
    return {"period_time": time, "period_events": events, "period_returns": returns}
