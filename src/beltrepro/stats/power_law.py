"""Power laws: with ends by maximum likelihood and their tests (Fig. 9), and as straight lines.

Fits by maximum likelihood need the mean of ln x only.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy
from scipy.special import boxcox, inv_boxcox

from beltrepro.base.errors import require
from beltrepro.stats.estimates import Estimate

REFUSED = 0.1  # p below which values do not follow a law (Clauset et al., their Sec. 4.1)
LEAST_DRAWN = 6  # runs that are drawn anew; of fewer their stretches are
LEAST_VALUES = 50  # a rule of thumb of Clauset et al. (see `goodness_of_fit`), their Sec. 3.2
_ONE_END = 1e-6  # share of ln(high / low) by which the mean of ln x must be off both ends


@dataclass(frozen=True, repr=False)
class PowerLaw:
    """A power law y = prefactor * x**exponent that was fitted; called with x it gives y.

    Attributes
    ----------
    exponent, prefactor : Estimate
        They follow each other: both intervals are of the same fits.
    low, high : float
        The range of x in which it was fitted.
    p : float
        Share of samples of the law that lie as far from their own fits as the values from this one:
        below 0.1 the law is refused. NaN of a straight line, which tests nothing.
    """

    exponent: Estimate
    prefactor: Estimate
    low: float
    high: float
    p: float = np.nan

    def __call__(self, x: npt.ArrayLike) -> np.ndarray:
        """Values (any shape) of the law."""
        return self.prefactor.value * np.asarray(x, dtype=float) ** self.exponent.value

    def __repr__(self) -> str:
        test = "" if np.isnan(self.p) else f", p={self.p:.6g}"
        test += " (refused)" if self.p < REFUSED else ""
        low, high = f"{self.exponent.low:.6g}", f"{self.exponent.high:.6g}"
        exponent = f"exponent={self.exponent.value:.6g} ({low} to {high})"
        return f"PowerLaw({exponent}, from {self.low:.6g} to {self.high:.6g}{test})"


def fit_exponent(mean_log: float, low: float, high: float) -> float:
    """Exponent of the power law of maximum likelihood for values with this mean of ln x.

    Where ln x is 0 at one end and 1 at the other, its density grows exponentially at a rate of
    (exponent + 1) * ln(high / low). The likelihood is largest where the mean is that of the values.
    """
    require(0 < low < high, f"values from {low:.3g} to {high:.3g} span no range")
    length = np.log(high / low)
    place = (mean_log - np.log(low)) / length
    nearer = max(place, 1 - place)  # seen from the end at which the density is larger
    require(nearer < 1 - _ONE_END, "all values lie at one end of the range")
    # 1 / (1 - nearer) is too fast: the mean is 1 - 1 / rate, and more
    rate = scipy.optimize.brentq(
        lambda rate: _mean_place(rate) - nearer, 0.0, 1 / (1 - nearer), xtol=1e-15
    )
    return float(np.copysign(rate, place - 0.5) / length) - 1


def _mean_place(rate: float) -> float:
    """Mean of a density on 0..1 that grows exponentially at a rate of 0 or more."""
    if rate < 0.03:  # where the two terms cancel, their series
        return 0.5 + rate / 12 - rate**3 / 720 + rate**5 / 30240
    return float(-1 / np.expm1(-rate) - 1 / rate)


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


class NearestLaw(NamedTuple):
    """Density c * x**exponent for low <= x <= high, and how well it fits."""

    exponent: float
    low: float
    high: float
    p: float  # share of samples of the law that are as far from their own fits


def goodness_of_fit(
    values: np.ndarray, lows: np.ndarray, independent: float, *, samples: int = 200
) -> NearestLaw:
    """Power law that comes nearest to values, from one of some lower ends up to the largest value.

    independent : how many independent values tell as much as these.

    The p-value is that of A. Clauset, C. R. Shalizi and M. E. J. Newman, SIAM Review 51, 661
    (2009), Sec. 4: samples have the law above its lower end and the values below it, and each is
    fitted anew, its lower end too. The law here ends at the largest value.
    """
    values, lows = np.sort(values), np.unique(lows)
    values = values[values >= lows[0]]
    count = np.count_nonzero(values >= lows[-1])
    require(
        count >= LEAST_VALUES, f"{count} values above {lows[-1]:.3g}, {LEAST_VALUES} are needed"
    )
    high = float(values[-1])
    step = step_of(values)
    rounded = f"values in steps of {step:.3g}"
    if step < 1e-9 * high:  # as of periodic motion, which repeats itself up to rounding
        rounded = f"only {1 + np.count_nonzero(np.diff(values) > 1e-9 * high)} distinct values"
    require(not step, f"{rounded}: the test is one of values of any size")
    exponent, low, distance = _nearest(values, lows, high)
    size = round(min(independent, values.size))
    require(size >= LEAST_VALUES, f"as good as {size} values, {LEAST_VALUES} are needed")
    below = values[values < low]
    rate = exponent + 1
    rng = np.random.default_rng(0)
    further = 0
    for _ in range(samples):
        count = rng.binomial(size, below.size / values.size)
        # Box and Cox's transform to this power makes values of a power law uniform
        shares = rng.random(size - count) * boxcox(high / low, rate)
        made = np.sort(low * inv_boxcox(shares, rate))
        made = np.r_[np.sort(rng.choice(below, count)), made] if count else made
        further += _nearest(made, lows, high)[2] >= distance
    return NearestLaw(exponent, low, high, further / samples)


def step_of(values: np.ndarray) -> float:
    """The step of values in rising order that are rounded so far that most are there twice, or 0.

    Their steps, and not the law, would decide how far they lie from it.
    """
    places = np.unique(values)
    gaps = np.diff(places)
    if 2 * places.size > values.size or not gaps.size:
        return 0.0
    steps = gaps / gaps.min()
    return float(gaps.min()) if np.abs(steps - np.rint(steps)).max() < 1e-6 else 0.0


def _nearest(values: np.ndarray, lows: np.ndarray, high: float) -> tuple[float, float, float]:
    """Exponent, lower end and distance, by Kolmogorov and Smirnov, of the nearest law.

    Values and lower ends are in rising order.
    """
    laws: list[tuple[float, float, float]] = []
    for low in lows:
        tail = values[np.searchsorted(values, low) :]
        if tail.size < LEAST_VALUES and laws:  # of a small sample
            continue
        exponent = fit_exponent(np.log(tail).mean(), low, high)
        share = boxcox(tail / low, exponent + 1) / boxcox(high / low, exponent + 1)
        rank = np.arange(tail.size + 1) / tail.size
        distance = float(max((rank[1:] - share).max(), (share - rank[:-1]).max()))
        laws.append((exponent, float(low), distance))
    return min(laws, key=lambda law: law[2])


# --- straight lines on doubly logarithmic axes ---------------------------------------------------


class PowerLawFit(NamedTuple):
    """y = prefactor * x**exponent, fitted for low <= x <= high."""

    exponent: float
    prefactor: float
    low: float
    high: float
    sample_size: int = 0  # points that were fitted

    def __call__(self, abscissa: npt.ArrayLike) -> np.ndarray:
        """Value of the fitted law at `abscissa` (any shape)."""
        return self.prefactor * np.asarray(abscissa, dtype=float) ** self.exponent


def fit_log_log(
    abscissa: npt.ArrayLike,
    ordinate: npt.ArrayLike,
    *,
    low: float,
    high: float,
    weight: npt.ArrayLike | None = None,
) -> PowerLawFit:
    """Least-squares line through (log x, log y) of the points with low <= x <= high and y > 0."""
    abscissa, ordinate = (np.asarray(values, dtype=float) for values in (abscissa, ordinate))
    weight = np.ones_like(abscissa) if weight is None else np.asarray(weight, dtype=float)
    used = (abscissa >= low) & (abscissa <= high) & (abscissa > 0) & (ordinate > 0) & (weight > 0)
    require(used.sum() >= 4, f"{used.sum()} points between {low:.3g} and {high:.3g}, 4 are needed")
    x, y = np.log(abscissa[used]), np.log(ordinate[used])
    exponent, offset = np.polyfit(x, y, 1, w=np.sqrt(weight[used]))
    return PowerLawFit(float(exponent), float(np.exp(offset)), low, high, int(used.sum()))
