"""Whether values are scale-free: power laws with ends, and tests of them (Fig. 9).

Fits are by maximum likelihood, which needs the mean of ln x only.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require

LEAST_VALUES = 50
_NODES = 200  # of the integral over a law


@dataclass(frozen=True)
class Law:
    """Density c * x**exponent for low <= x <= high."""

    exponent: float
    low: float
    high: float


@dataclass(frozen=True)
class Fit:
    """How well a power law fits."""

    law: Law  # the power law that comes nearest
    distance: float  # of Kolmogorov and Smirnov, between the values from `law.low` on and the law
    p: float  # share of samples of the law that are as far from their own fits


def fit_law(mean_log: float, low: float, high: float) -> Law:
    """Power law of maximum likelihood for values with this mean of ln x."""
    require(0 < low < high, f"values from {low:.3g} to {high:.3g} span no range")
    nodes, weights = _integral(low, high)
    logs = np.log(nodes)
    centre, scale = logs.mean(), logs.std()
    terms, wanted = (logs - centre) / scale, (mean_log - centre) / scale

    def slope(factors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Minus the slope of the log-likelihood of a value, and the slope of that."""
        log = factors[0] * terms
        share = weights * np.exp(log - log.max())
        share /= share.sum()
        mean = terms @ share
        return np.array([mean - wanted]), np.array([[(terms * share) @ terms - mean**2]])

    at_one_end = "all values lie at one end of the range"
    require(bool(np.log(low) < mean_log < np.log(high)), at_one_end)
    best = scipy.optimize.root(slope, np.zeros(1), jac=True)
    require(best.success, at_one_end)
    return Law(float(best.x[0] / scale), float(low), float(high))


def independent_values(values: np.ndarray, chain: np.ndarray) -> float:
    """How many independent values tell as much as these, which repeat themselves within a chain.

    By the scatter of the means of chains, against that of means of independent values.
    """
    _, place = np.unique(chain, return_inverse=True)
    count = np.bincount(place)
    if len(count) < 2 or values.std() == 0:
        return float(len(count))
    means = np.bincount(place, values) / count
    excess = np.average((means - values.mean()) ** 2, weights=count) * count.mean() / values.var()
    return float(values.size / max(1.0, excess * len(count) / (len(count) - 1)))


def goodness_of_fit(
    values: npt.ArrayLike,
    lows: npt.ArrayLike,
    *,
    independent: float | None = None,
    samples: int = 200,
) -> Fit:
    """Power law that comes nearest to values, from one of some lower ends up to the largest value.

    The p-value is that of A. Clauset, C. R. Shalizi and M. E. J. Newman, SIAM Review 51, 661
    (2009), Sec. 4: samples have the law above its lower end and the values below it, and each is
    fitted anew, its lower end too. The law here ends at the largest value.
    """
    values, lows = np.sort(np.asarray(values, dtype=float)), np.unique(lows)
    values = values[values >= lows.min()]
    count = np.count_nonzero(values >= lows.max())
    require(
        count >= LEAST_VALUES, f"{count} values above {lows.max():.3g}, {LEAST_VALUES} are needed"
    )
    high = float(values[-1])
    law, distance = _nearest(values, lows, high)
    size = values.size if independent is None else round(min(independent, values.size))
    require(size >= LEAST_VALUES, f"as good as {size} values, {LEAST_VALUES} are needed")
    below = values[values < law.low]
    rng = np.random.default_rng(0)
    further = 0
    for _ in range(samples):
        count = rng.binomial(size, below.size / values.size)
        drawn = _draw(law, rng.random(size - count))
        made = np.r_[np.sort(rng.choice(below, count)), np.sort(drawn)] if count else np.sort(drawn)
        further += _nearest(made, lows, high)[1] >= distance
    return Fit(law, distance, further / samples)


def _nearest(values: np.ndarray, lows: np.ndarray, high: float) -> tuple[Law, float]:
    """The law of least distance; values and lower ends in rising order."""
    laws: list[tuple[Law, float]] = []
    for low in lows:
        tail = values[np.searchsorted(values, low) :]
        if tail.size < LEAST_VALUES and laws:  # of a small sample
            continue
        law = fit_law(np.log(tail).mean(), low, high)
        share = _cumulative(law, tail)
        rank = np.arange(tail.size + 1) / tail.size
        distance = float(max((rank[1:] - share).max(), (share - rank[:-1]).max()))
        laws.append((law, distance))
    return min(laws, key=lambda pair: pair[1])


def _cumulative(law: Law, values: np.ndarray) -> np.ndarray:
    """Share of a power law below values."""
    rate, length = law.exponent + 1, np.log(law.high / law.low)
    place = np.log(values / law.low)
    return place / length if abs(rate) < 1e-9 else np.expm1(rate * place) / np.expm1(rate * length)


def _draw(law: Law, shares: np.ndarray) -> np.ndarray:
    """Values of a power law below which these shares lie."""
    rate, length = law.exponent + 1, np.log(law.high / law.low)
    if abs(rate) < 1e-9:
        return law.low * np.exp(shares * length)
    return law.low * np.exp(np.log1p(shares * np.expm1(rate * length)) / rate)


def _integral(low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of an integral over x from low to high, evenly in ln x."""
    nodes, weights = _legendre()
    half = np.log(high / low) / 2
    values = np.sqrt(low * high) * np.exp(half * nodes)
    return values, weights * half * values


@cache
def _legendre() -> tuple[np.ndarray, np.ndarray]:
    return np.polynomial.legendre.leggauss(_NODES)
