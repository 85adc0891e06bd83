"""Says in one line that chains still load while they are measured."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from beltrepro.base.errors import warn
from beltrepro.engine.integrator import Integrator
from beltrepro.model.energy import normal_modes, slow_unit
from beltrepro.model.friction import friction_fall, kinetic_friction
from beltrepro.model.parameters import LONGEST, ChainParameters
from beltrepro.model.spring import balance_length, spring_extension
from beltrepro.observe.length import LengthHistory
from beltrepro.simulation.groups import Group, observe
from beltrepro.simulation.setup import Case

_MATERIAL = 0.01  # of the standard deviation: smaller changes of mean and deviation do not matter
_PERIODS = 10  # of the slowest mode; in fewer a slow motion looks like loading
_STILL = 1e-6  # r of a viscous chain that only comes nearer to its balance
_SURELY = 5  # loading times after which nobody looks any more
_BINS = 10  # at least, however short a run is
_FOLDINGS = 5  # by which an overshoot shrinks until it is no part of loading
_FAR, _FAR_PERIODS = 0.3, 3  # of loading and of periods, which motion that has loaded rises in less
_STICKS = 2  # in less time r is that of a part of the motion
_LONGER = 10  # times the transient, a run that shows enough
AMPLE = 1.25  # what should be left out, over what is seen to be loading


class LoadingWatch:
    """Whether the measured parts of P runs begin while the chains still load."""

    def __init__(
        self,
        cases: Sequence[Case],
        duration: float,
        transient: float,
        belt: Sequence[tuple[float, float]] = (),
    ) -> None:
        """Of cases whose belt may change: when, from their beginning, and to which velocity."""
        self._cases, self._duration, self._transient = cases, duration, transient
        self._belt = belt
        # of the runs in which it matters: a transient that leaves it out, and r; NaN of the others
        self.noted = np.full((len(cases), 2), np.nan)

    def note(self, disorder: np.ndarray) -> None:
        """Note those of P runs of which the belt has not carried the last block to its balance."""
        for row, case in enumerate(self._cases):
            if not _age(case) and self._transient < self._loading_time(case):
                self.noted[row] = self._needed(case, 0.0), disorder[row]

    def observe(self, group: Group, chains: Integrator, *observers: Any) -> None:
        """Advance a group of runs, show it to the observers, and note which begin with loading."""
        cases, end = group.cases, group.start + self._duration
        begun = group.start + self._transient
        unit = slow_unit(group.chain)
        history = LengthHistory(len(cases), begun, end, min(unit, (end - begun) / _BINS) or unit)
        loaded = all(
            _age(case) + self._transient >= _SURELY * self._loading_time(case)
            and not (self._brief(case) or self._short(case))
            for case in cases
        )
        watching = observers if loaded else (*observers, history)
        observe(chains, self._duration, watching, group.report)
        if history.count.any():
            length, matters, whole, _ = beginning(history)
            disorder = whole.deviation / (whole.mean + group.chain.rest_positions[-1])
            settles = np.array([case.parameters.viscosity > 0 for case in cases])
            for lane in np.flatnonzero(matters | settles & _shrinks(history)):
                if self._may_load(cases[lane], disorder[lane]):
                    needed = self._needed(cases[lane], length[lane])
                    self.noted[group.indices[lane]] = needed, disorder[lane]
            for row, case, one in zip(group.indices, cases, disorder, strict=True):
                if np.isnan(self.noted[row, 0]) and one > _STILL and self._short(case):
                    self.noted[row] = 0.0, one

    def warn(self, late: str = "") -> None:
        """Warn if runs are measured while their chains load, and say how long that takes.

        late : name of a time before the end that is measured, where no transient is given.
        """
        loading = np.flatnonzero(~np.isnan(self.noted).any(axis=1))
        if not len(loading):
            return
        number = loading[np.argmax(self.noted[loading, 0])]
        needed, disorder = self.noted[number].tolist()
        total = len(self._cases)
        many = "" if total == 1 else f"{len(loading)} of {total} chains: "
        longer, rest = f"duration={min(_LONGER * needed, LONGEST):g}", self._duration - needed
        if late:
            advice = f"{f'{late}={rest:g}' if rest > 0 else longer} leaves it out"
        elif rest > needed:
            advice = f"transient={needed:g} leaves it out"
        else:
            advice = f"transient={needed:g} and {longer} leave it out"
        what = "loading is measured too"
        if needed > LONGEST / 2:
            advice = f"it lasts longer than a run may ({LONGEST:g})"
        elif needed <= self._transient:  # it has loaded, and moves one way all the time
            what, advice = "less than a slow motion is measured", "a longer duration has more of it"
        warn(
            f"{many}{what} ({self._cases[number].parameters.describe()}"
            f"{f': r = {disorder:.3g}' if math.isfinite(disorder) else ''}); {advice}"
        )

    def _needed(self, case: Case, length: float) -> float:
        """A transient that leaves the loading of a run out, of two digits; 0 if it has loaded."""
        if self._brief(case) and self._transient >= self._loading_time(case):
            return 0.0
        loading = self._loading_time(case) - _age(case)
        # viscous chains creep on where the belt has brought them
        creeps = math.isinf(length) and self._transient < loading < self._duration
        seen = self._duration if creeps else self._transient + length
        time = AMPLE * (max(loading, seen if math.isfinite(seen) else 0.0) or self._duration)
        if time > LONGEST:
            return math.inf
        step = 10.0 ** (math.floor(math.log10(time)) - 1)
        return math.ceil(time / step) * step

    def _may_load(self, case: Case, disorder: float) -> bool:
        """Whether a run that begins elsewhere loads, and is not in the middle of a slow motion."""
        slowest = _slowest_period(case.parameters)
        measured = self._duration - self._transient
        left_out, loading = _age(case) + self._transient, self._loading_time(case)
        if _age(case) > 0:  # its motion may be as slow as that
            slowest = max(slowest, loading)
        long_enough = measured >= _PERIODS * slowest and disorder > _STILL
        return long_enough or left_out < loading or self._brief(case)

    def _brief(self, case: Case) -> bool:
        """Whether a run, no piece of a longer one, measures less than the belt takes to load it."""
        if _age(case):
            return False
        whole = self._when(case, _rise(case.parameters, case.parameters.rest_positions))
        return self._duration - self._transient < whole

    def _short(self, case: Case) -> bool:
        """Whether a run, no piece of a longer one, measures less than two sticks of a block."""
        if case.state.time:
            return False
        velocity = self._belt[-1][1] if self._belt else case.parameters.belt_velocity
        return self._duration - self._transient < _STICKS * carried(case.parameters) / velocity

    def _loading_time(self, case: Case) -> float:
        """Time that loading takes from where a chain has begun to move."""
        chain = case.parameters
        begun = chain.rest_positions if _age(case) else case.state.positions
        settling = _settling(chain) if chain.viscosity > 0 else 0.0
        return self._when(case, _rise(chain, begun)) + settling

    def _when(self, case: Case, time: float) -> float:
        """When the belt has come as far as it would have in a time at its first velocity."""
        begin, velocity = 0.0, case.parameters.belt_velocity
        way = velocity * time
        for change, next_velocity in self._belt:
            if way <= velocity * (change - begin):
                break
            way -= velocity * (change - begin)
            begin, velocity = change, next_velocity
        return begin + way / velocity


def warn_of_loading(
    cases: Sequence[Case],
    disorder: np.ndarray,
    duration: float,
    transient: float,
    late: str = "",
) -> None:
    """Warn if P runs are measured before the belt can have brought them to their balance.

    disorder : r of each, infinite where it is not known, and NaN where loading is no matter.
    late : as of `LoadingWatch.warn`.
    """
    watch = LoadingWatch(cases, duration, transient)
    watch.note(disorder)
    watch.warn(late)


def carried(chain: ChainParameters) -> float:
    """How far the belt carries a single block until it slips, from where it stuck, at most.

    From 2 f_s F_st - F_st to F_st; blocks with neighbours less far.
    """
    threshold, ratio = chain.by_block("static_friction"), chain.by_block("friction_ratio")
    return float((2 * (1 - ratio) * threshold / chain.by_block("stiffness")).max())


def _settling(chain: ChainParameters) -> float:
    """Time in which viscosity brings a chain back from an overshoot, or up to its balance."""
    slowest = normal_modes(chain)[0][0]
    rates = -friction_fall(chain, chain.belt_velocity) / (2 * chain.by_block("mass"))
    damping = max(rates.min(), slowest / 4)  # what swings on for longer is its motion
    rate = min(damping, slowest) ** 2 / (damping + math.sqrt(max(damping**2 - slowest**2, 0.0)))
    return _FOLDINGS / float(rate)


def _rise(chain: ChainParameters, begun: np.ndarray) -> float:
    """Time in which the belt brings the last block to where springs and friction balance."""
    length = balance_length(chain)
    if chain.viscosity > 0:  # blocks that do not swing over stick until static friction is reached
        friction = kinetic_friction(chain, chain.belt_velocity)
        friction = np.maximum(chain.by_block("static_friction"), friction)
        tension = np.cumsum(friction[::-1])[::-1]
        length = float(chain.rest_positions[-1] + spring_extension(tension, chain).sum())
    return float(length - begun[-1]) / chain.belt_velocity


def _age(case: Case) -> float:
    """How long a chain has moved before its run, in which it has loaded.

    It has not where its belt or law were others then, and its springs are far from where the
    belt will bring them.
    """
    chain, state = case.parameters, case.state
    if not state.time or not state.displacements.any():
        return 0.0
    if state.wall_impulse:  # the audit of another chain begins anew
        return state.time
    rise, whole = (_rise(chain, places) for places in (state.positions, chain.rest_positions))
    far = rise > max(_FAR * whole, _FAR_PERIODS * _slowest_period(chain))
    return 0.0 if far else state.time


def _slowest_period(chain: ChainParameters) -> float:
    """Period of the slowest mode, less than 2 pi / (pi / (2N + 1)) in the paper's chain."""
    return (4 * chain.n_blocks + 2) * slow_unit(chain)


def _shrinks(history: LengthHistory) -> np.ndarray:
    """Whether W runs move less than half as far in the later half of the bins."""
    kept = history.count > 0
    low, high = history.low[kept], history.high[kept]
    middle = (len(low) + 1) // 2
    halves = slice(middle), slice(middle, None)  # of one bin the later one is empty
    tops = [high[half].max(axis=0, initial=-np.inf) for half in halves]
    early, late = tops - np.array([low[half].min(axis=0, initial=np.inf) for half in halves])
    return late < early / 2


class Moments(NamedTuple):
    """Mean and standard deviation of W runs, with standard errors; each (W,)."""

    mean: np.ndarray
    deviation: np.ndarray
    mean_error: np.ndarray
    deviation_error: np.ndarray


def beginning(history: LengthHistory) -> tuple[np.ndarray, np.ndarray, Moments, Moments]:
    """Of W runs how long the beginning is, whether it matters, and moments with and without it.

    A bin belongs to it if its mean is beyond all values that come later, and if all bins before it
    do. What comes back, as in periodic, chaotic and intermittent motion, is no beginning. Its
    length is 0 if there is none, and infinite if it is the whole run; it matters if mean or
    deviation change by more than their errors without it.
    """
    kept = history.count > 0
    starts, count = history.edges[:-1][kept], history.count[kept, None]
    mean, squares = history.mean[kept], history.squares[kept]
    lowest = np.minimum.accumulate(history.low[kept][::-1])[::-1][1:]
    highest = np.maximum.accumulate(history.high[kept][::-1])[::-1][1:]
    beyond = (mean[:-1] < lowest) | (mean[:-1] > highest)
    bins = np.logical_and.accumulate(beyond).sum(axis=0)
    later = np.arange(len(count))[:, None] >= bins
    whole, rest = (_moments(weight, mean, squares) for weight in (count + 0 * mean, count * later))
    material = _MATERIAL * rest.deviation
    matters = np.abs(rest.mean - whole.mean) > np.maximum(rest.mean_error, material)
    matters |= np.abs(rest.deviation - whole.deviation) > np.maximum(rest.deviation_error, material)
    length = np.where(bins < len(count) - 1, starts[bins] - history.edges[0], np.inf)
    return length, matters & (bins > 0), whole, rest


def _moments(weight: np.ndarray, mean: np.ndarray, squares: np.ndarray) -> Moments:
    """Moments over bins (K, W) of these weights; errors as if bins were independent."""
    share = weight / weight.sum(axis=0)
    centre = (share * mean).sum(axis=0)
    variances = squares - 2 * centre * mean + centre**2
    variance = np.maximum((share * variances).sum(axis=0), 0.0)
    deviation = np.sqrt(variance)
    mean_error = np.sqrt((share**2 * (mean - centre) ** 2).sum(axis=0))
    variance_error = np.sqrt((share**2 * (variances - variance) ** 2).sum(axis=0))
    deviation_error = variance_error / np.maximum(2 * deviation, 1e-300)
    return Moments(centre, deviation, mean_error, deviation_error)
