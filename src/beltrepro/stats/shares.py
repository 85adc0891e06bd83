"""Shares of runs, with exact confidence intervals."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.stats.errors import require

CONFIDENCE = 0.95  # of intervals, where nothing else is said


class Share(NamedTuple):
    """Part of the runs, and the interval of Clopper and Pearson for its expectation."""

    value: float
    lower: float
    upper: float


def share(count: int, runs: int, *, confidence: float = CONFIDENCE) -> Share:
    """Share of independent runs, with an exact confidence interval.

    The interval is that of Clopper and Pearson (Biometrika 26, 404, 1934). It holds for few runs
    and for shares of 0 and 1 too. Each end is wrong in at most half of 1 - confidence of all cases.
    """
    require(runs > 0, "no runs, 1 is needed")
    interval = scipy.stats.binomtest(int(count), int(runs)).proportion_ci(
        confidence, method="exact"
    )
    return Share(count / runs, float(interval.low), float(interval.high))


class Shares(NamedTuple):
    """Shares by value of a quantity; arrays (V,)."""

    quantity: np.ndarray  # distinct values of the quantity, increasing
    value: np.ndarray  # share of the runs with that value, and its interval
    lower: np.ndarray
    upper: np.ndarray


def shares(quantity: npt.ArrayLike, having: npt.ArrayLike) -> Shares:
    """Share of runs that have a property, with its interval, for each value of a quantity."""
    quantity, having = np.asarray(quantity), np.asarray(having, dtype=bool)
    distinct = np.unique(quantity)
    found = [share(own.sum(), own.size) for own in (having[quantity == each] for each in distinct)]
    return Shares(distinct, *np.array(found).reshape(-1, 3).T)
