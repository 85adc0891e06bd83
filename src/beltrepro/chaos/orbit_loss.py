"""How large a disturbance loses a periodic orbit: kicks, the steps of a scheme, noise.

A disturbed run is compared with its orbit return by return. It has left the orbit at the first
return at which some coordinate is further away than `irregular.WIDEST` of F_st.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from beltrepro.chaos.irregular import WIDEST
from beltrepro.chaos.periodic_orbits import TIME_STEP, PeriodicOrbit, follow
from beltrepro.engine.integrator import GROUP_SIZE, Section
from beltrepro.engine.state import ChainState
from beltrepro.model.spring import external_force
from beltrepro.observe.crossings import ReturnLog
from beltrepro.simulation.groups import integrator_of, observe
from beltrepro.simulation.setup import Case, Setup

KICK, STEP, NOISE = "kick", "time_step", "noise"
DISTURBANCES = (KICK, STEP, NOISE)
LARGEST = {KICK: 2.0, STEP: 0.1, NOISE: 5.0}  # 0.1 is the longest step of the scheme
SMALLEST = {KICK: 2e-8, STEP: 1e-4, NOISE: 5e-8}  # a shorter step takes too long
_COARSE = 1.0  # decades between the sizes that are tried first
_FINE = 0.125  # and then
_LATE = 3.0  # periods without a return after which a run has left
_TINY = 1e-9  # kicks to which the answer is linear
_SCATTERING = 8  # runs with them
_BEFORE = 1e-5  # and before it, where the rate of its pull is measured
_AFTER = 1e-6  # model time after the start of a slip at which a single kick is given


@dataclass(frozen=True, eq=False)
class Track:
    """An orbit as the returns of its last block to a length, which disturbed runs must follow."""

    orbit: PeriodicOrbit
    length: float  # x_N of the section
    times: np.ndarray  # (p,) of the returns in a period
    states: np.ndarray  # (p, 2N)

    @classmethod
    def of(cls, orbit: PeriodicOrbit) -> Track:
        """The returns to the length that the last block crosses fastest."""
        run = orbit.run(orbit.period_time / max(400, 40 * orbit.period_events))
        length = _fastest_crossed(run.positions[:, -1])
        chain = Case(orbit.state, "event", TIME_STEP, None)
        log = _returns([chain], length, orbit.period_time)
        times, states, _ = log.returns(0)
        return cls(orbit, length, times, states)

    def left(self, cases: Sequence[Case], begun: Sequence[float], duration: float) -> np.ndarray:
        """When runs (W,) that begin on the orbit leave it; inf for those that do not.

        begun : instants of the orbit (W,), in its first period, at which they begin.
        """
        times = [
            self._first_away(log.returns(lane), begin, duration)
            for first in range(0, len(cases), GROUP_SIZE)
            for log in [_returns(cases[first : first + GROUP_SIZE], self.length, duration)]
            for lane, begin in enumerate(begun[first : first + GROUP_SIZE])
        ]
        return np.array(times)

    def _first_away(self, returns: tuple, begin: float, duration: float) -> float:
        times, states, _ = returns
        away = self._apart(times, states, begin)
        limit = WIDEST * self.orbit.parameters.by_block("static_friction").max()
        far = np.append(times[away > limit], np.inf)[0]
        gaps = np.diff(np.concatenate([[0.0], times, [duration]]))
        late = gaps > _LATE * self.orbit.period_time
        missing = np.append(np.append(0.0, times)[late], np.inf)[0]
        return float(min(far, missing))

    @cached_property
    def starts(self) -> list[ChainState]:
        """States spread over a period, at time 0."""
        return [self.at(share * self.orbit.period_time) for share in self.phases]

    phases = (0.0, 0.29, 0.53, 0.81)  # shares of the period, in no simple ratio

    def at(self, time: float) -> ChainState:
        """The state of the orbit at an instant, as a start."""
        state = follow(self.orbit.state, time).final_state if time > 0 else self.orbit.state
        return replace(state, time=0.0, scheme=None)

    def scatter(self, *, duration: float) -> float:
        """Distance from the orbit, root mean square over returns, for kicks of the size 1."""
        cases = [_disturbed(self, KICK, _TINY, number, duration) for number in range(_SCATTERING)]
        log = _returns(cases, self.length, duration)
        squares = []
        for lane in range(len(cases)):
            times, states, _ = log.returns(lane)
            begin = self.phases[lane % len(self.phases)] * self.orbit.period_time
            squares.append(self._apart(times, states, begin)[len(times) // 2 :] ** 2)
        return float(np.sqrt(np.mean(np.concatenate(squares))) / _TINY)

    def _apart(self, times: np.ndarray, states: np.ndarray, begin: float) -> np.ndarray:
        """Largest difference of a coordinate (T,) from the orbit, return by return."""
        order = np.searchsorted(self.times, begin) + np.arange(len(times))
        away: np.ndarray = np.abs(states - self.states[order % len(self.times)]).max(axis=1)
        return away


def _returns(cases: Sequence[Case], length: float, duration: float) -> ReturnLog:
    section = Section(cases[0].parameters.n_blocks, np.full(len(cases), length))
    log = ReturnLog(len(cases))
    observe(integrator_of(cases, section=section), duration, [log], lambda done: None)
    return log


def _fastest_crossed(lengths: np.ndarray) -> float:
    """The length (T,) whose crossings downwards are fastest, the slowest of them counting."""
    levels = np.quantile(lengths, np.linspace(0.1, 0.9, 33))
    before, after = lengths, np.roll(lengths, -1)
    slowest = [
        np.min((before - after)[(before > level) & (after <= level)], initial=np.inf)
        for level in levels
    ]
    return float(levels[np.argmax(np.where(np.isfinite(slowest), slowest, 0.0))])


# --- lasting disturbances -------------------------------------------------------------------------


@dataclass(frozen=True)
class Loss:
    """The size of a disturbance beyond which an orbit is lost within a time."""

    size: float  # at which half of the runs leave
    low: float  # the largest below which none left; 0 if some left at all sizes
    high: float  # the smallest from which on all left; inf if some stayed at all sizes
    runs: int  # that the finer sizes were tried with, in all


def loss(track: Track, disturbance: str, *, duration: float, replicates: int) -> Loss:
    """By coarse sizes first, and then finer ones where some of the runs leave."""
    left = partial(_shares, track, disturbance, duration=duration, replicates=replicates)
    share: dict[float, float] = {}
    size = LARGEST[disturbance]
    for size in _sizes(LARGEST[disturbance], SMALLEST[disturbance], _COARSE):
        share |= left([size])
        if share[size] == 0:
            break
    some = [tried for tried in share if share[tried] > 0]
    if not some:
        return Loss(np.inf, size, np.inf, replicates)
    if share[size] > 0:
        return Loss(0.0, 0.0, size, replicates)
    above = min([tried for tried in share if share[tried] == 1], default=LARGEST[disturbance])
    fine = left([tried for tried in _sizes(above, size, _FINE) if tried not in share])
    return _threshold(fine | {size: share[size], above: share[above]}, replicates * len(fine))


def _sizes(largest: float, smallest: float, decades: float) -> list[float]:
    count = round(np.log10(largest / smallest) / decades)
    return list(np.geomspace(largest, smallest, max(1, count) + 1))


def _threshold(share: dict[float, float], runs: int) -> Loss:
    """Where half leave, by the mean of the logarithm over the runs (Spearman and Karber)."""
    sizes = np.array(sorted(share))
    shares = np.maximum.accumulate([share[size] for size in sizes])
    whole = shares[-1] == 1
    middles = np.log(sizes[1:] * sizes[:-1]) / 2
    mean = np.exp(np.sum(np.diff(shares) * middles)) if whole else np.inf
    exact = np.array([share[size] for size in sizes])
    low = sizes[np.flatnonzero(shares == 0)[-1]]
    short = np.flatnonzero(exact < 1)
    high = np.append(sizes, np.inf)[short[-1] + 1]
    return Loss(float(mean), float(low), float(high), runs)


def _shares(
    track: Track, disturbance: str, sizes: Iterable[float], *, duration: float, replicates: int
) -> dict[float, float]:
    """Share of the runs that leave, by size."""
    sizes = list(sizes)
    made = [
        (_disturbed(track, disturbance, size, number, duration), number)
        for size in sizes
        for number in range(replicates)
    ]
    together = (
        [made]
        if disturbance != STEP
        else [made[first : first + replicates] for first in range(0, len(made), replicates)]
    )
    begun = [share * track.orbit.period_time for share in track.phases]
    left = [
        track.left([case for case, _ in part], [begun[k % len(begun)] for _, k in part], duration)
        for part in together
    ]
    gone = np.isfinite(np.concatenate(left)).reshape(len(sizes), replicates)
    return dict(zip(sizes, gone.mean(axis=1).tolist(), strict=True))


def _disturbed(track: Track, disturbance: str, size: float, number: int, duration: float) -> Case:
    """A run from the orbit; each has another phase and other random numbers."""
    state = track.starts[number % len(track.starts)]
    how: dict = {"replicate": number + 1}
    if disturbance == NOISE:
        state = state.under(replace(state.parameters, noise=size))
    elif disturbance == KICK:
        how["kick"] = size
    else:
        how |= {"method": "verlet", "time_step": duration / np.ceil(duration / size)}
    (case,) = Setup(state.parameters, initial_state=state, **how).cases
    return case


# --- a single kick --------------------------------------------------------------------------------


def margin(track: Track, *, begin: float, periods: int, slips: int) -> float:
    """The smallest displacement of a block, at the start of its slip, that loses the orbit.

    begin : size that is tried first; each further one is a third of an octave larger.
    slips : at most so many of a period are kicked, spread evenly.
    """
    orbit = track.orbit
    events = follow(orbit.state, orbit.period_time).events
    events = events[events["kind"] == "slip"]
    chosen = events[np.unique(np.linspace(0, len(events) - 1, slips).astype(int))]
    kicked = [
        (track.at(float(event["time"]) + _AFTER), float(event["time"]), int(event["block"]) - 1)
        for event in chosen
    ]
    while begin < LARGEST[KICK] and not _lost(track, kicked, begin, periods):
        begin *= 2 ** (1 / 3)
    return begin if begin < LARGEST[KICK] else np.inf


def noise_as_kick(track: Track) -> float:
    """Kicks that move slips as much as thresholds of the standard deviation 1 do.

    A threshold higher by f is reached later by f over the rate of the pull. So the slip starts late
    by that, as in a scheme (`beltrepro.model.scheme_error`): a kick of 2u times as much does the
    same. A block that a slipping neighbour pulls is hardly late. Root mean square over the slips.
    """
    orbit = track.orbit
    events = follow(orbit.state, orbit.period_time).events
    rates = []
    for event in events[events["kind"] == "slip"]:
        if event["time"] > _BEFORE:
            state = track.at(float(event["time"]) - _BEFORE)
            pull = external_force(
                orbit.parameters.rest_positions + state.displacements, orbit.parameters
            )[event["block"] - 1]
            rates.append((event["force"] - pull) / _BEFORE)
    late = 2 * orbit.parameters.belt_velocity / np.array(rates)
    return float(np.sqrt(np.mean(late**2)))


def _lost(track: Track, kicked: Sequence, size: float, periods: int) -> bool:
    """Whether a kick of this size, forward or back, at one of the slips, loses the orbit."""
    cases, begun = [], []
    for state, time, block in kicked:
        for change in (-size, size):
            displacements = state.displacements.copy()
            displacements[block] += change
            start = replace(state, displacements=displacements)
            cases.append(Case(start, "event", TIME_STEP, None))
            begun.append(time)
    left = track.left(cases, begun, periods * track.orbit.period_time)
    return bool(np.isfinite(left).any())
