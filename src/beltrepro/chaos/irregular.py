"""How long irregular motion lasts, and what it settles on."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.chaos import vectors
from beltrepro.chaos.naming import ends_in_slip, period_of, warn_of_rests
from beltrepro.chaos.periodic_orbits import MOMENTS
from beltrepro.chaos.vectors import INTERVAL, METHOD, part
from beltrepro.engine.integrator import Integrator, Section
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.model import ChainParameters
from beltrepro.model.energy import as_lengths, slow_unit, times_as_fast
from beltrepro.observe.crossings import ReturnLog
from beltrepro.observe.length import LengthMoments
from beltrepro.simulation.groups import (
    Group,
    Report,
    check_progress,
    for_moments,
    in_groups,
    integrator_of,
    observe,
)
from beltrepro.simulation.loading import carried
from beltrepro.simulation.results import KEY, Results
from beltrepro.simulation.setup import Case, Chains, check_duration, columns, setup_of, with_setup
from beltrepro.stats.motion import CLOSED, EQUILIBRIUM, PERIODIC, find_recurrence

IRREGULAR = "irregular"

# Windows in which returns are collected, in units of `slow_unit`: a period must fit twice in the
# second half of one. On slow belts the longest has room for so many sticks.
_FIRST_WINDOW = 1000.0
_LONGEST_WINDOW, _STICKS = 250_000.0, 1600
_GROWTH = 0.5  # length of a window as a share of the time before it
_EARLY = 1 / (1 + _GROWTH)  # share of a run before its last window, unless that is cut short
# Of the irregular motion, in units of `slow_unit`: in the first part the vector turns to its
# direction, and after the last its growth is known well enough.
_ALIGNED, _FOLLOWED = 500.0, 100_000.0
_SHORTEST = 1000.0  # below this no exponent is given
_FEWEST = 3  # returns in a window; with fewer the section is moved
_AGREE = 10  # returns of a disturbed orbit, at least: in slow motion one in five does by chance
# Distances between a disturbed state and that a period earlier, in units of the disturbance. On
# orbits of 9, 631, 2052, 8089 and 8924 slips they reach 7, 300, 5000, 50000 and 8 millions.
SCATTERS = (1e2, 1e3, 1e4, 1e5, 1e6, 1e7)
# No more than this share of F_st, which stretches a spring by about the size of the motion. An
# orbit is lost before it scatters so much. Other irregular states differ by about F_st.
WIDEST = 0.15


@with_setup
def time_to_orbit(
    chains: Chains,
    *,
    duration: float,
    closed: float = CLOSED,
    progress: Report | None = None,
    **setup: Any,
) -> Results:
    """How long the motion of each of P chains is irregular before it settles, and on what orbit.

    Each chain is advanced until all blocks slip and none can stick any more, or its state comes
    back. None can where `sliding_energy` is below m u^2 / 2 and does not grow, or where the swings
    are small and each mode is damped. What noise brings is counted: in a chain that no viscosity
    calms it ends each slip.
    On the way to a periodic orbit irregular motion is over when the order in which the blocks slip
    repeats from then on: what follows is a smooth approach. An orbit is seen in a run of twelve
    periods or more.

    Where noise or the steps of "verlet" disturb each slip, states come back only about. There all
    states of a sixth of the time so far must. A disturbed motion may leave its orbit later.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        P chains. Exponents are measured with the method "event" only.
    duration : float
        Model time after which a run is given up.
    closed : float
        Distance of two states that count as one, as a share of the largest coordinate.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

    Returns
    -------
    Results
        settled; lifetime of the irregular motion (the duration if not settled); state (equilibrium
        slip, periodic or irregular); period_time, period_events and period_returns as of
        `classify`; disorder_parameter and mean_length of the settled motion, or of the end
        (over half a window of at least 1000 sqrt(m / k): no whole periods of slow motion);
        irregular_exponent and irregular_error, the largest Lyapunov exponent over the
        irregular_time, NaN where that is too short; return_state (P, 2N), displacements and
        relative velocities of the blocks at the last return, NaN padded. The period may be twice
        that of the orbit just before a period doubling, where `periodic_orbit` tells. The numbers
        of a viscous chain in equilibrium slip hold what is left of its way to the balance.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    duration = check_duration(duration)
    closed = checks.finite_number("closed", closed)
    if not 0 < closed < 1:
        raise InputError(f"closed = {closed:g}: must be greater than 0 and less than 1")
    check_progress(progress)
    made = setup_of(chains, setup)
    runs = [_Run(case, case.state.time, bool(case.state.directions.all())) for case in made.cases]
    alike: dict[tuple[float, float], list[_Run]] = {}
    for run in runs:
        alike.setdefault(_windows(run.case.parameters), []).append(run)
    ends = np.cumsum([len(some) for some in alike.values()]) / len(runs)
    shares = pairwise([0.0, *ends.tolist()])
    for (windows, some), share in zip(alike.items(), shares, strict=True):
        _follow(some, duration, closed, windows, part(progress, *share), made.workers)
    width = 2 * max(case.parameters.n_blocks for case in made.cases)
    rows = [run.row(duration, width) for run in runs]
    table = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    warn_of_rests(made.cases, np.array([run.rests(duration) for run in runs]))
    settings = {"kind": "time to orbit", "duration": duration, "closed": closed}
    table[KEY] = np.array([case.key for case in made.cases])
    return Results(columns(made) | table, settings)


def _windows(chain: ChainParameters) -> tuple[float, float]:
    """Lengths of the first window and the longest; powers of two of those of the paper's chain."""
    unit, stick = max(1.0, slow_unit(chain)), carried(chain) / chain.belt_velocity
    longest = max(unit, _STICKS * stick / _LONGEST_WINDOW)
    first, longest = (2.0 ** math.ceil(math.log2(times)) for times in (unit, longest))
    return first * _FIRST_WINDOW, longest * _LONGEST_WINDOW


def _follow(
    runs: list[_Run],
    duration: float,
    closed: float,
    windows: tuple[float, float],
    report: Report,
    workers: int | None,
) -> None:
    """Advance runs of the same windows until each has settled, or to the end."""
    first, longest = windows
    place = partial(_place_sections, runs, first)
    in_groups([run.case for run in runs], place, None, workers=workers)
    begin, left = 0.0, runs
    while begin < duration and left:
        length = max(1.0, min(longest, _GROWTH * begin) // first) * first
        end = begin + length
        if duration - end < first:  # too short to judge by itself
            end = duration
        work = partial(_pass_window, left, end - begin, closed)
        passed = part(report, begin / duration, end / duration)
        in_groups([run.case for run in left], work, passed, workers=workers)
        begin, left = end, [run for run in left if not run.settled]
    report(1.0)


_UNKNOWN = {"state": IRREGULAR, **period_of(None, np.empty(0)), **dict.fromkeys(MOMENTS, np.nan)}
_UNKNOWN |= {"return_state": np.empty(0), "lifetime": np.inf}


@dataclass
class _Run:
    """One chain on its way, and what is remembered of it."""

    case: Case  # it, in its state now
    start: float  # instant at which it began
    slipped: bool  # whether all its blocks did so then
    section: float = np.nan  # length of the chain at which its returns are noted
    slips: list[tuple] = field(default_factory=list)  # instants and blocks, of each window
    growth: list[np.ndarray] = field(default_factory=list)  # rates of growth of its deviation
    deviation: np.ndarray | None = None  # the deviation now
    last_event: float = -np.inf  # instant of the last slip or stick
    motion: dict = field(default_factory=_UNKNOWN.copy)  # what is known of it

    @property
    def settled(self) -> bool:
        """Whether its motion has settled."""
        return self.motion["state"] != IRREGULAR

    @property
    def followed(self) -> bool:
        """Whether a deviation goes along."""
        longest = _FOLLOWED * slow_unit(self.case.parameters)
        return self.case.method == METHOD and self.case.state.time - self.start < longest

    def rests(self, duration: float) -> bool:
        """Whether its blocks slip too rarely for returns in its last windows."""
        late = self.start + _EARLY * duration
        slips = sum(int(np.sum(times > late)) for times, _ in self.slips)
        swings = self.case.state.directions.all()
        return not self.settled and not swings and slips < _FEWEST * self.case.parameters.n_blocks

    def judge(self, log: ReturnLog, lane: int, middle: float, closed: float) -> None:
        """Look for the end of the irregular motion in a window that has just been passed.

        middle : of the window; what settles later shows its numbers in the next one.
        """
        times, states, slips = log.returns(lane)
        places = states * as_lengths(self.case.parameters)
        self.last_event = max(self.last_event, log.last_event[lane])
        if len(states):
            self.motion["return_state"] = states[-1]
        distances = scatters(self.case)
        late = max(int(np.sum(times > middle)), _AGREE) if distances else 1
        recurrences = (  # a narrow distance first: it tells like returns apart
            find_recurrence(places, times, closed=closed, distance=distance, crossings=late)
            for distance in distances or (0.0,)
        )
        closing = next(filter(None, recurrences), None)
        period = period_of(closing, slips)
        events = int(period["period_events"])
        since = self._repeats_since(events, period["period_time"]) if events else np.inf
        if closing and distances:
            # disturbances may exchange slips of almost one time
            since = min(since, float(times[closing.since]))
        last_event = max(self.last_event, self.start)
        returned = closing is not None and not events
        state, time_step = self.case.state, self.case.time_step
        if ends_in_slip(state, time_step, last_event, middle, returned):
            self.motion |= {"state": EQUILIBRIUM, "lifetime": last_event - self.start}
        elif closing and events and since <= middle:
            self.motion |= {"state": PERIODIC, "lifetime": since - self.start, **period}

    def _repeats_since(self, period: int, period_time: float) -> float:
        """Instant from which on the order of the slips repeats after so many of them."""
        times, blocks = map(np.concatenate, zip(*self.slips, strict=True))
        exchanged = blocks[period:] != blocks[:-period]
        # a slip of all blocks that has lasted for long is no part of the orbit
        broken = np.flatnonzero(exchanged | (times[period:] - times[:-period] > 2 * period_time))
        if broken.size:
            return float(times[broken[-1] + 1])
        late = self.slipped and times[0] > self.start + period_time
        return float(times[0]) if late else self.start

    def row(self, duration: float, width: int) -> dict:
        """What `time_to_orbit` returns of it; width : numbers of the state of the longest chain."""
        lifetime, state = self.motion["lifetime"], self.motion["return_state"]
        rates = np.concatenate([np.empty((0, 1)), *self.growth])
        interval = INTERVAL / times_as_fast(self.case.parameters)
        last = int(min(lifetime, len(rates) * interval) / interval)
        unit = slow_unit(self.case.parameters)
        rates = rates[int(_ALIGNED * unit / interval) : last][None]  # of the irregular motion
        time, exponent, error = rates.shape[1] * interval, np.nan, np.nan
        moves = self.last_event - self.start > _ALIGNED * unit
        if long_enough := moves and time >= _SHORTEST * unit:
            exponent, error = vectors.slopes(rates).item(), vectors.standard_errors(rates).item()
        return self.motion | {
            "return_state": np.pad(state, (0, width - state.size), constant_values=np.nan),
            "lifetime": min(lifetime, duration),
            "settled": self.settled,
            "irregular_exponent": exponent,
            "irregular_error": error,
            "irregular_time": time if long_enough else 0.0,
        }


def _place_sections(runs: list[_Run], window: float, group: Group) -> None:
    """Sections at the mean lengths of the chains of a group after their start."""
    # every motion comes down through its mean length again and again
    moments = LengthMoments(len(group.cases), group.start + 0.5 * window)
    observe(integrator_of(group.cases), window, [moments], group.report)
    lengths = moments.result(group.chain.rest_positions[-1])
    for index, length in zip(group.indices, lengths["mean_length"], strict=True):
        runs[index].section = length


def _pass_window(runs: list[_Run], length: float, closed: float, group: Group) -> None:
    """Advance a group by a window, and judge its motion there."""
    members, middle = [runs[index] for index in group.indices], group.start + 0.5 * length
    observers = moments, log = LengthMoments(len(members), middle), ReturnLog(len(members))
    chains = _integrator(members)
    if isinstance(chains, TangentIntegrator):
        growth = vectors.grow(chains, length, observers, group.report)
        for run, rates, deviation in zip(members, growth, chains.deviations(), strict=True):
            run.growth.append(rates)
            run.deviation = deviation
    else:
        observe(chains, length, observers, group.report)
    lengths = moments.result(group.chain.rest_positions[-1])
    for lane, (run, state) in enumerate(zip(members, chains.state(), strict=True)):
        run.case = replace(run.case, state=state)
        run.slips.append(log.slips(lane))
        run.judge(log, lane, middle, closed)
        run.motion |= {name: lengths[name][lane] for name in MOMENTS}
        few = len(log.returns(lane)[0]) < _FEWEST
        if few and not run.settled and np.isfinite(run.motion["mean_length"]):
            run.section = run.motion["mean_length"]


def _integrator(members: list[_Run]) -> Integrator:
    """The integrator of a group in its states now, with a deviation if one goes along."""
    cases = [run.case for run in members]
    section = Section(cases[0].parameters.n_blocks, np.array([run.section for run in members]))
    if not members[0].followed:
        return integrator_of(cases, section=section)
    states = [case.state for case in cases]
    chains = vectors.with_vectors(states, cases[0], 1, for_moments(cases), section)
    deviations = [run.deviation for run in members if run.deviation is not None]
    if deviations:
        chains.set_deviations(np.stack(deviations))
    return chains


def disturbance(case: Case) -> float:
    """Standard deviation of displacements that disturb each slip as much as it is disturbed."""
    # what noise does during a slip is left out: less than at its start by about sqrt(dt)
    chain, exact = case.parameters, case.method == METHOD
    softest = chain.by_block("stiffness").min()
    # in the scheme one begins late by t, uniform over a step, and moves its block by 2 u t
    steps = 0.0 if exact else chain.belt_velocity * case.time_step / math.sqrt(3.0)
    return math.hypot(steps, chain.noise / softest)


def scatters(case: Case) -> tuple[float, ...]:
    """Distances at which two states of a disturbed motion may count as one."""
    size, chain = disturbance(case), case.parameters
    widest = WIDEST * (chain.by_block("static_friction") / chain.by_block("stiffness")).max()
    return tuple(sorted({min(scatter * size, widest) for scatter in SCATTERS})) if size else ()
