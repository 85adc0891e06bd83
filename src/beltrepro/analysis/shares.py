"""Shares of runs with a property, by the value of some quantity."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import stats


class Shares(NamedTuple):
    """Shares by value; arrays (V,).

    Attributes
    ----------
    value : array
        Distinct values of the quantity, increasing.
    share : array
        Share of the runs with that value that have the property.
    low, high : array
        Ends of the interval of 68 % confidence (Wilson).
    """

    value: np.ndarray
    share: np.ndarray
    low: np.ndarray
    high: np.ndarray


def shares(values: npt.ArrayLike, having: npt.ArrayLike, *, confidence: float = 0.6827) -> Shares:
    """Share of runs that have a property, with its interval, for each value of a quantity.

    Parameters
    ----------
    values : array (P,)
        Of the quantity, for each run.
    having : array (P,) of bool
        Whether each run has the property.
    confidence : float
        Of the intervals.

    Returns
    -------
    Shares
        By value.
    """
    values, having = np.asarray(values), np.asarray(having, dtype=bool)
    distinct = np.unique(values)
    rows = []
    for value in distinct:
        own = having[values == value]
        found = stats.binomtest(int(own.sum()), len(own))
        interval = found.proportion_ci(confidence, method="wilson")
        rows.append((found.statistic, interval.low, interval.high))
    share, low, high = np.array(rows).reshape(-1, 3).T
    return Shares(distinct, share, low, high)
