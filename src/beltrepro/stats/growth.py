"""How fast small distances grow, size by size: the finite-size Lyapunov exponent.

E. Aurell, G. Boffetta, A. Crisanti, G. Paladin, A. Vulpiani, Phys. Rev. Lett. 77, 1262 (1996).
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from beltrepro.base.errors import require


@dataclass(frozen=True)
class Growth:
    """Rate at which distances of each size grow."""

    size: np.ndarray  # geometric mean of the two levels between which the rate was measured
    # finite-size exponent, the inverse of the unit of time; NaN where no run came so far
    exponent: np.ndarray
    standard_error: np.ndarray  # by the jackknife over runs; NaN with fewer than two of them
    passed: np.ndarray  # runs that passed from the lower level to the upper one
    # exponent that one passage in the time of all runs between the two levels would give; NaN
    # where no run was watched there. Where none has passed, the exponent is hardly larger
    limit: np.ndarray


def finite_size_exponents(
    levels: npt.ArrayLike, passage_time: npt.ArrayLike, observed: float, *, skipped: int = 0
) -> Growth:
    """Finite-size exponents from the times at which distances first passed each level.

    The exponent at a size is the logarithm of the ratio of two levels over the mean time from one
    to the other. Runs that did not come to the upper level count with the time that they were
    watched: the mean time is the sum of all times over the number of passages. Without them fast
    runs alone would count. A run begins to count at the first level that it has a time of.
    """
    levels = np.asarray(levels, dtype=float)
    passage = np.asarray(passage_time, dtype=float)
    require(levels.size >= 2 and len(passage) >= 1, "two levels and a run are needed")
    has_time = np.isfinite(passage)
    passage = np.where(np.cumsum(has_time, axis=1) > skipped, passage, np.nan)
    reached = np.isfinite(passage[:, :-1])
    passed = reached & np.isfinite(passage[:, 1:])
    until = np.where(passed, passage[:, 1:], float(observed))
    spent = np.where(reached, until - passage[:, :-1], 0.0)
    folds = np.diff(np.log(levels))
    count, total = passed.sum(axis=0), spent.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        exponent = folds * count / total
        without = folds * (count - passed) / (total - spent)
    return Growth(
        size=np.sqrt(levels[1:] * levels[:-1]),
        exponent=exponent,
        standard_error=_jackknife(without),
        passed=count,
        limit=np.where(total > 0, folds / np.where(total > 0, total, 1.0), np.nan),
    )


def _jackknife(without: np.ndarray) -> np.ndarray:
    """Standard errors from estimates (P, L) that each leave out one of P runs."""
    runs = len(without)
    if runs < 2:
        return np.full(without.shape[1], np.nan)
    finite = np.isfinite(without).all(axis=0)
    return np.where(
        finite, np.sqrt((runs - 1) * np.where(finite, without, 0.0).var(axis=0)), np.nan
    )
