"""The margin of a periodic orbit: the smallest displacement of a block that throws the chain off.

A run that begins beside the orbit is compared with it return by return. It has left the orbit at
the first return at which some coordinate is further away than `irregular.WIDEST` of F_st / k.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.chaos.irregular import WIDEST
from beltrepro.chaos.periodic_orbits import PeriodicOrbit, advanced, exact_case, follow
from beltrepro.engine.integrator import GROUP_SIZE
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model.energy import as_lengths
from beltrepro.observe.crossings import ReturnLog
from beltrepro.simulation.setup import Case

SMALLEST = 1e-8  # displacement, model length: an orbit is known not much better
LARGEST = 2.0  # of the paper's blocks: an orbit that bears it has no margin
_LATE = 3.0  # periods without a return after which a run has left
_AFTER = 1e-6  # model time after the start of a slip at which its block is displaced


Slip = tuple[ChainState, float, int]
"""The start of a slip: a state just after it, its instant on the orbit, and its block from 0."""


@names.checked
def margin(
    orbit: PeriodicOrbit, *, begin: float = 0.01, periods: int = 20, slips: int = 32
) -> float:
    """How far a disturbance may move a block before other sticks and slips follow than the orbit's.

    One block is moved, forward or back, at the start of one of its slips. Moved by less than the
    margin the chain comes back to the orbit. From the margin on it can get onto another sequence of
    sticks and slips: at some return of the last block a coordinate is off the orbit by more than
    0.15 F_st / k then, or the block does not return for three periods.

    Parameters
    ----------
    orbit : PeriodicOrbit
        An orbit that attracts.
    begin : float
        Displacement that is tried first, model length. Where it loses the orbit, tenths of it are
        tried, down to 1e-8; then each is a third of an octave (26 %) larger than the last.
    periods : int
        Periods for which each run is followed.
    slips : int
        From at most so many slips of a period, spread evenly.

    Returns
    -------
    float
        The smallest displacement that loses the orbit, model length; inf if 0.028 F_st / k, 2 in
        the paper's chain, does not.

    Raises
    ------
    InputError
        A value is not allowed.
    """
    if not isinstance(orbit, PeriodicOrbit):
        raise InputError(f"orbit = {checks.shown(orbit)}: a PeriodicOrbit is needed")
    begin = checks.within("begin", begin, ge=SMALLEST, lt=LARGEST)
    for name, value in (("periods", periods), ("slips", slips)):
        checks.within(name, checks.whole_number(name, value), ge=1)
    track, starts = Track.of(orbit), _slips(orbit, int(slips))
    largest = LARGEST * _stretch(orbit.parameters) / ChainParameters.static_friction
    while begin > SMALLEST and _lost(track, starts, begin, periods):
        begin = max(begin / 10, SMALLEST)
    while begin < largest and not _lost(track, starts, begin, periods):
        begin *= 2 ** (1 / 3)
    return begin if begin < largest else np.inf


def _stretch(chain: ChainParameters) -> float:
    """F_st / k, the largest of a chain."""
    return float((chain.by_block("static_friction") / chain.by_block("stiffness")).max())


def _slips(orbit: PeriodicOrbit, number: int) -> list[Slip]:
    """At most so many of the slips of a period, spread evenly."""
    _, events = follow(orbit.state, orbit.period_time)
    events = events[events["kind"] == "slip"]
    chosen = events[np.unique(np.linspace(0, len(events) - 1, number).astype(int))]
    slips = []
    for time, block in zip(chosen["time"].tolist(), chosen["block"].tolist(), strict=True):
        state, _ = follow(orbit.state, time + _AFTER)
        slips.append((replace(state, time=0.0, scheme=None), time, block - 1))
    return slips


def _lost(track: Track, starts: Sequence[Slip], size: float, periods: int) -> bool:
    """Whether a displacement of this size, forward or back, at one of the slips, loses it."""
    cases, begun = [], []
    for state, time, block in starts:
        for change in (-size, size):
            displacements = state.displacements.copy()
            displacements[block] += change
            cases.append(exact_case(replace(state, displacements=displacements)))
            begun.append(time)
    duration = periods * track.orbit.period_time
    for first in range(0, len(cases), GROUP_SIZE):
        log = _returns(cases[first : first + GROUP_SIZE], track.length, duration)
        for lane, begin in enumerate(begun[first : first + GROUP_SIZE]):
            if np.isfinite(track.left(log.returns(lane), begin, duration)):
                return True
    return False


@dataclass(frozen=True, eq=False)
class Track:
    """An orbit as the returns of its last block to a length, which runs beside it must follow."""

    orbit: PeriodicOrbit
    length: float  # x_N of the section
    times: np.ndarray  # (p,) of the returns in a period
    states: np.ndarray  # (p, 2N)

    @classmethod
    def of(cls, orbit: PeriodicOrbit) -> Track:
        """The returns to the length that the last block crosses fastest."""
        run = orbit.run(orbit.period_time / max(400, 40 * orbit.period_events))
        length = _fastest_crossed(run.positions[:, -1])
        log = _returns([exact_case(orbit.state)], length, orbit.period_time)
        times, states, _ = log.returns(0)
        return cls(orbit, length, times, states)

    def left(self, returns: tuple, begin: float, duration: float) -> float:
        """When a run that begins at an instant of the first period leaves it; inf: never."""
        times, states, _ = returns
        order = np.searchsorted(self.times, begin) + np.arange(len(times))
        chain = self.orbit.parameters
        apart = (states - self.states[order % len(self.times)]) * as_lengths(chain)
        away = np.abs(apart).max(axis=1)
        far = np.append(times[away > WIDEST * _stretch(chain)], np.inf)[0]
        gaps = np.diff(np.concatenate([[0.0], times, [duration]]))
        late = gaps > _LATE * self.orbit.period_time
        missing = np.append(np.append(0.0, times)[late], np.inf)[0]
        return float(min(far, missing))


def _returns(cases: Sequence[Case], length: float, duration: float) -> ReturnLog:
    log = ReturnLog(len(cases))
    advanced(cases, duration, log, length=length)
    return log


def _fastest_crossed(lengths: np.ndarray) -> float:
    """The length (T,) whose crossings downwards are fastest, the slowest of them counting."""
    levels = np.quantile(lengths, np.linspace(0.1, 0.9, 33))
    after = np.roll(lengths, -1)
    slowest = [
        np.min((lengths - after)[(lengths > level) & (after <= level)], initial=np.inf)
        for level in levels
    ]
    return float(levels[np.argmax(np.where(np.isfinite(slowest), slowest, 0.0))])
