"""What motion a chain ends in: equilibrium slip, periodic, chaotic and so on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base.errors import warn
from beltrepro.chaos import vectors
from beltrepro.chaos.periodic_orbits import MOMENTS, loading_time, moments_of_orbit, with_lengths
from beltrepro.chaos.vectors import REST
from beltrepro.engine.integrator import Sampling, Section
from beltrepro.engine.state import ChainState
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.model import ChainParameters
from beltrepro.model.energy import normal_modes, slips_for_good
from beltrepro.model.parameters import LONGEST
from beltrepro.observe.crossings import ReturnLog
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.slips import MostStuck
from beltrepro.simulation.gathering import gathered
from beltrepro.simulation.groups import Group, Report, moments_interval, moments_of
from beltrepro.simulation.loading import AMPLE, carried, warn_of_loading
from beltrepro.simulation.results import Results
from beltrepro.simulation.setup import Case, Chains, check_lengths, setup_of, with_setup
from beltrepro.simulation.tables import OF_RUNS, Tabled, brief
from beltrepro.stats.motion import (
    EQUILIBRIUM,
    PERIODIC,
    TRANSIENT,
    Recurrence,
    find_recurrence,
    name_motion,
)

_VECTORS = 2  # the largest exponents: one may be that of the motion itself
_ALIGNED = 0.1  # first share of the observation, in which the vectors turn to their directions
_END = 0.5  # last share of it, in which blocks must turn for the motion not to be equilibrium slip
RESTS = OF_RUNS + "rests"  # whether blocks slip too rarely in a run to judge it
# Periods of the slowest mode, for which all blocks must slip: in a slip from which some stick again
# they do for less than one up to u = 30, and for ten at u = 45 (N = 5 and 10).
_PERIODS = 10
_CYCLES = 2 * _PERIODS  # of the slowest motion, that are advised


@dataclass(frozen=True, repr=False)
class Motion(Tabled):
    """The motion in which a chain ends.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    state : str
        "equilibrium slip", "periodic", "quasi-periodic", "chaotic", "stable chaos", "transient" or,
        with noise, "noise-driven"; see `beltrepro.stats.motion.name_motion`.
    period_time, period_events : float, int
        Model time of a period, NaN if the orbit does not close or has no slip; slips of all blocks
        in it, 0 so.
    largest_exponent, standard_error : float
        Largest Lyapunov exponent per model time after the transient, and its error; NaN where no
        block slips or sticks in the second half of that time, though not all slip.
    disorder_parameter, mean_length : float
        r (Eq. 4) and <x_N>: of the orbit if the motion is periodic, else after the transient.
    nontrivial_exponent, nontrivial_error : float
        The largest besides that of a shift of time, as in `lyapunov_spectrum`, and its error.
    erased : int
        Directions that sticks erase: the most blocks that are stuck at once after the transient.
    """

    parameters: ChainParameters
    state: str
    period_time: float
    period_events: int
    largest_exponent: float
    standard_error: float
    disorder_parameter: float
    mean_length: float
    nontrivial_exponent: float
    nontrivial_error: float
    erased: int

    def __repr__(self) -> str:
        return f"Motion({self.parameters.describe()}: {brief(self)})"


@with_setup
def classify(
    chains: Chains,
    *,
    duration: float,
    transient: float,
    noise_clock: str = REST,
    on_error: str = "raise",
    store: str | Path | None = None,
    progress: Report | None = None,
    **setup: Any,
) -> Motion | Results:
    """Tell what kind of motion one chain ends in, or each of several.

    Several motions can coexist, so where a chain begins may decide. With an `initial_spread` and
    `replicate=range(32)` it begins from undeformed springs, and 31 times elsewhere.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        One chain or P chains; only the method "event" has a tangent dynamics.
    duration, transient : float
        Model time of each run, and of its first part; the rest is judged. A period must fit in it
        three times.
    noise_clock : str
        As in `lyapunov_spectrum`.
    on_error, store : str, str or Path
        As in `scan`.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

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
    measure = partial(_judged, **settings)
    motions = gathered("motion", made, measure, progress, on_error, store, **settings)
    rests = motions.of_runs[RESTS]
    warn_of_rests(made.cases, rests, transient)
    # the numbers of an orbit are those of its period
    of_all = ~(rests | (motions["state"] == PERIODIC))
    disorder = np.where(of_all, motions["disorder_parameter"], np.nan)
    warn_of_loading(made.cases, disorder, duration, transient)
    if not made.alone:
        return motions
    measured = [field.name for field in fields(Motion)[1:]]
    return Motion(made.cases[0].parameters, **{name: motions[name].item() for name in measured})


def _judged(
    group: Group, *, duration: float, transient: float, noise_clock: str
) -> dict[str, np.ndarray]:
    members, report = group.cases, group.report
    observed, share = duration - transient, transient / duration
    chains = _after(members, transient, observed, noise_clock, vectors.part(report, 0, share))
    begin, half = chains.time, chains.time + (1 - _END) * observed
    moments, log = LengthMoments(len(members), begin), ReturnLog(len(members))
    stuck = MostStuck(np.array([np.sum(state.directions == 0) for state in chains.state()]))
    observers, report = [moments, log, stuck], vectors.part(report, share, 1)
    growth = vectors.grow(chains, observed, observers, report, across=True)
    growth = growth[:, int(_ALIGNED * growth.shape[1]) :]
    growth[vectors.none_across(chains, stuck.most), :, -1] = -np.inf
    exponents, errors = vectors.slopes(growth), vectors.standard_errors(growth)
    lengths = moments_of(moments, chains)
    rows = []
    for lane, (case, end) in enumerate(zip(members, chains.state(), strict=True)):
        times, states, slips = log.returns(lane)
        closed = find_recurrence(states, times)
        last_event = max(log.last_event[lane], begin)
        period = period_of(closed, slips)
        returned = closed is not None and not period["period_events"]
        sliding = slides(end, last_event, half) or returned
        if rests := last_event <= half and not sliding and closed is None:
            exponents[lane] = errors[lane] = np.nan
        state = name_motion(
            slides=sliding,
            closed=closed is not None,
            exponents=exponents[lane, :-1],
            standard_error=errors[lane, :-1],
            nontrivial=(exponents[lane, -1], errors[lane, -1]),
            time=(1 - _ALIGNED) * observed,
            returns=len(times),
            noisy=case.parameters.noise > 0,
        )
        if state == EQUILIBRIUM and not ends_in_slip(
            end, case.time_step, last_event, half, returned
        ):
            state = TRANSIENT  # until blocks stick
        first = int(np.argmax(exponents[lane, :-1]))
        row = {
            "state": state,
            **period,
            "largest_exponent": exponents[lane, first],
            "standard_error": errors[lane, first],
            **{name: lengths[name][lane] for name in MOMENTS},
            "nontrivial_exponent": exponents[lane, -1],
            "nontrivial_error": errors[lane, -1],
            "erased": stuck.most[lane],
            RESTS: rests,
        }
        if closed is not None and state == PERIODIC:
            # the motion after the transient may hold irregular motion that came before the orbit
            row |= moments_of_orbit(end, closed.back, case.tolerance)
        rows.append(row)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _after(
    members: list[Case], transient: float, observed: float, noise_clock: str, report: Report
) -> TangentIntegrator:
    """The chains after the transient, with vectors, and a section at their mean length."""
    sampling = Sampling(1, moments_interval(members[0]))
    states, lengths = with_lengths(members, transient, observed, sampling, report)
    section = Section(members[0].parameters.n_blocks, lengths)
    settings = _VECTORS, sampling, section, noise_clock
    return vectors.with_vectors(states, members[0], *settings, across=True)


def period_of(closed: Recurrence | None, slips: np.ndarray) -> dict[str, float]:
    """What is told of the period of returns, from the number of slips before each of them.

    Without a slip there is none: rounding alone makes a chain in steady slip return.
    """
    time, events, returns = np.nan, 0, 0
    if closed is not None and (events := int(slips[-1] - slips[-1 - closed.crossings])):
        time, returns = closed.time, closed.crossings
    return {"period_time": time, "period_events": events, "period_returns": returns}


def slides(state: ChainState, last_event: float, since: float) -> bool:
    """Whether all blocks have slipped since an instant, and for long enough to call it a motion."""
    long_enough = last_event <= min(since, state.time - _PERIODS * _slowest(state.parameters))
    return bool(np.all(state.directions) and long_enough)


def ends_in_slip(
    state: ChainState, time_step: float, last_event: float, since: float, returned: bool
) -> bool:
    """Whether all blocks have slipped since an instant and will: returned is, without any slip."""
    chain = state.parameters
    if returned and not chain.friction_varies and not chain.noise:
        return True
    for_good = slips_for_good(chain, state.positions, state.velocities, time_step)
    return for_good and slides(state, last_event, since)


def warn_of_rests(cases: Sequence[Case], rests: np.ndarray, transient: float | None = None) -> None:
    """Warn of runs with few events or none at the end, too short for the slow motion of a chain."""
    times = [(*_loading_and_cycles(cases[row]), row) for row in np.flatnonzero(rests).tolist()]
    if not times:
        return
    loading, cycles, row = max(times, key=lambda one: one[0] + one[1])
    begin = max(loading, transient or 0.0)
    if begin + cycles >= LONGEST:
        advice = f"it slips more rarely than the longest run shows ({LONGEST:g})"
    else:
        longer = "" if transient is None else f"transient={math.ceil(begin)}, "
        duration = math.ceil(begin) + math.ceil(cycles)
        advice = f"{longer}duration={duration} shows some slips, and a longer duration more"
    many = "" if len(cases) == 1 else f"{len(times)} of {len(cases)} chains: "
    warn(
        f"{many}blocks slip too rarely to judge the motion "
        f"({cases[row].parameters.describe()}): the chain loads, or waits for a slip; {advice}"
    )


def _loading_and_cycles(case: Case) -> tuple[float, float]:
    """Model time in which a chain loads from its start, and in which it slips some times."""
    chain = case.parameters
    loading = loading_time(chain, case.state.positions)
    return AMPLE * loading, _CYCLES * max(carried(chain) / chain.belt_velocity, _slowest(chain))


def _slowest(chain: ChainParameters) -> float:
    """Period of the slowest mode."""
    return 2 * np.pi / normal_modes(chain)[0][0]
