"""What has been shown of the last block: its recent positions, and r and <x_N> so far."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from beltrepro.model.units import TIME_S

KEPT = 30.0 / TIME_S  # model time: thirty seconds of the belt


def _empty() -> np.ndarray:
    return np.empty(0)


@dataclass(frozen=True, eq=False)
class Record:
    """Recent positions of the last block, and their moments since a beginning."""

    # instants, x_N and the disorder parameter up to that instant, of the last `KEPT` of model
    # time
    time: np.ndarray = field(default_factory=_empty)
    length: np.ndarray = field(default_factory=_empty)
    disorder: np.ndarray = field(default_factory=_empty)
    count: int = 0  # positions in the moments
    # the first of these positions, and the sum and the sum of squares of all from there
    origin: float = 0.0
    total: float = 0.0
    squares: float = 0.0

    def extended(self, time: np.ndarray, length: np.ndarray) -> Record:
        """This record with further positions."""
        if not len(time):
            return self
        origin = self.origin if self.count else float(length[0])
        count = self.count + np.arange(1, len(length) + 1)
        total = self.total + np.cumsum(length - origin)
        squares = self.squares + np.cumsum((length - origin) ** 2)
        spread = np.sqrt(np.maximum(squares / count - (total / count) ** 2, 0.0))
        disorder = spread / (origin + total / count)
        recent = self.time >= time[-1] - KEPT
        return Record(
            time=np.append(self.time[recent], time),
            length=np.append(self.length[recent], length),
            disorder=np.append(self.disorder[recent], disorder),
            count=int(count[-1]),
            origin=origin,
            total=float(total[-1]),
            squares=float(squares[-1]),
        )

    def anew(self) -> Record:
        """This record with moments that begin now."""
        return replace(self, count=0, total=0.0, squares=0.0)

    @property
    def mean_length(self) -> float:
        """<x_N> so far; NaN where nothing was shown."""
        return self.origin + self.total / self.count if self.count else np.nan

    @property
    def disorder_parameter(self) -> float:
        """The disorder parameter r so far (Eq. 4); NaN where nothing was shown."""
        return float(self.disorder[-1]) if self.count else np.nan
