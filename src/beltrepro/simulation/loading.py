"""Says in one line that chains still load while they are measured."""

import math
import warnings
from collections.abc import Sequence

import numpy as np

from beltrepro.model.spring import balance_length
from beltrepro.observe.length import LengthHistory
from beltrepro.simulation.setup import Case, caller
from beltrepro.stats.stationarity import Moments, beginning

_PERIODS = 10  # of the slowest mode; in fewer a slow motion looks like loading
_SURELY = 5  # loading times after which nobody looks any more
_AMPLE = 1.25  # what should be left out, over what is seen to be loading


class LoadingWatch:
    """Whether the measured parts of P runs begin while the chains still load."""

    def __init__(self, cases: Sequence[Case]) -> None:
        self._cases = cases
        count = len(cases)
        self._length = np.zeros(count)  # of the loading that is measured; infinite: to the end
        self._loads = np.zeros(count, dtype=bool)  # whether it matters
        self._disorder, self._later_disorder = np.zeros(count), np.zeros(count)

    def history(
        self, members: Sequence[Case], duration: float, transient: float
    ) -> list[LengthHistory]:
        """An observer of a group of runs, for `judge`; none if the transient is surely enough."""
        if transient >= _SURELY * max(map(_loading_time, members)):
            return []
        start = members[0].state.time
        return [LengthHistory(len(members), start + transient, start + duration)]

    def judge(self, group: np.ndarray, histories: list[LengthHistory]) -> None:
        """Note how the runs of a group begin."""
        if not any(history.count.any() for history in histories):
            return
        (history,) = histories

        def disorder(moments: Moments) -> np.ndarray:
            return moments.deviation / (moments.mean + rest)

        rest = self._cases[group[0]].parameters.rest_positions[-1]
        first = beginning(**vars(history))
        self._length[group], self._loads[group] = first.length, first.matters
        self._disorder[group] = disorder(first.whole)
        self._later_disorder[group] = disorder(first.rest)

    def warn(self, duration: float, transient: float) -> None:
        """Warn if runs are measured while their chains load, and say how long that takes."""
        needed = {
            number: self._needed(number, transient)
            for number in np.flatnonzero(self._loads).tolist()
            if self._may_load(number, duration, transient)
        }
        if not needed:
            return
        number = max(needed, key=needed.__getitem__)
        many = "" if len(self._cases) == 1 else f"{len(needed)} of {len(self._cases)} chains: "
        text = f"r = {self._disorder[number]:.3g}"
        if math.isfinite(self._length[number]):
            text += f", {self._later_disorder[number]:.3g} without the first of it"
        longer = "" if needed[number] < duration / 2 else " and a duration well beyond it"
        warnings.warn(
            f"{many}loading is measured too ({self._cases[number].parameters.describe()}: {text}); "
            f"transient={needed[number]:g}{longer} leaves it out",
            stacklevel=caller(),
        )

    def _needed(self, number: int, transient: float) -> float:
        """A transient that leaves the loading of a run out, of two digits."""
        length = self._length[number]
        seen = transient + length if math.isfinite(length) else 0.0
        time = _AMPLE * max(_loading_time(self._cases[number]), seen)
        step = 10.0 ** (math.floor(math.log10(time)) - 1)
        return math.ceil(time / step) * step

    def _may_load(self, number: int, duration: float, transient: float) -> bool:
        """Whether a run that begins elsewhere loads, and is not in the middle of a slow motion."""
        case = self._cases[number]
        slowest = 4 * case.parameters.n_blocks + 2  # period, less than 2 pi / (pi / (2N + 1))
        return duration - transient >= _PERIODS * slowest or transient < _loading_time(case)


def _loading_time(case: Case) -> float:
    """Time in which the belt brings the last block to where springs and friction balance."""
    chain = case.parameters
    return (balance_length(chain) - case.state.positions[-1]) / chain.belt_velocity
