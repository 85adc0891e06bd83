"""Values of chains, their densities on logarithmic axes, and power laws in them (Fig. 9)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from numbers import Real
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import boxcox

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError, NotEnoughDataError, require, warn
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.power_law import (
    LEAST_DRAWN,
    LEAST_VALUES,
    PowerLaw,
    PowerLawFit,
    fit_exponent,
    fit_log_log,
    goodness_of_fit,
    independent_values,
    step_of,
)

FINE_BINS = 10  # a decade, in which the most probable value is looked for
STARTS_TRIED = 12
_PULLED = 0.7  # standard errors, from which on an interval holds less than 85 in 100
_MOST = 1e150  # of a value, and of its inverse: products of two are floats
_MOST_LOG = 300.0  # of a prefactor, which with its interval is to be a float


@names.checked
@dataclass(frozen=True, eq=False, repr=False)
class ChainValues:
    """Values, and the chain that each is of: those of one chain hang together.

    NumPy and Matplotlib take it for the array of its values.

    Attributes
    ----------
    values : array (S,)
        The values, those of each chain in the order of time.
    chain : array (S,)
        Number of its chain, or another label.

    Raises
    ------
    InputError
        The arrays are none of numbers, or differ in length.
    """

    values: np.ndarray
    chain: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", checks.series("values", self.values))
        masked = np.ma.is_masked(self.chain)
        object.__setattr__(self, "chain", np.asarray(self.chain))
        if masked or (self.chain.dtype.kind == "f" and np.isnan(self.chain).any()):
            raise InputError("chain: some values have no chain: their labels are masked, or NaN")
        if self.chain.dtype.kind == "O" and not any(
            all(isinstance(label, kind) for label in self.chain.flat) for kind in (Real, str)
        ):
            raise InputError(
                f"chain = {checks.shown(self.chain.tolist())}: numbers or texts are needed"
            )
        if self.chain.shape != self.values.shape:
            needed = f"the shape {self.values.shape} of the values is needed"
            raise InputError(f"chain of shape {self.chain.shape}: {needed}")

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.values, dtype=dtype, copy=copy)

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        text = f"{len(self)} of {np.unique(self.chain).size} chains"
        ends = f", {self.values.min():.6g} to {self.values.max():.6g}" if len(self) else ""
        return f"ChainValues({text}{ends})"


def by_chain(sample: ChainValues) -> np.ndarray:
    """Values of each chain as one object, so that chains can be drawn anew."""
    order = np.argsort(sample.chain, kind="stable")
    _, first = np.unique(sample.chain[order], return_index=True)
    return np.fromiter(np.split(sample.values[order], first[1:]), dtype=object)


def _independent(values: Any) -> ChainValues:
    """Values with what can be drawn anew: their chains, or of few chains stretches of each."""
    if not isinstance(values, ChainValues):
        values = ChainValues(values, np.zeros(np.shape(checks.series("values", values))))
    if not np.isfinite(values.values).all():
        raise InputError("values: all must be finite numbers")
    chains = by_chain(values)
    if len(chains) >= LEAST_DRAWN:
        return values
    pieces = -(-estimates.STRETCHES // len(chains))
    stretches = [
        pieces * number + np.arange(one.size) * pieces // max(one.size, 1)
        for number, one in enumerate(chains)
    ]
    return ChainValues(np.concatenate(chains), np.concatenate(stretches))


# --- densities ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, repr=False)
class Density:
    """Density of positive values in bins of equal width in their logarithm.

    Attributes
    ----------
    centre, width : array (B,)
        Of the bins; the centre is the geometric one.
    counts : array (C, B)
        Values of each chain in each bin, or of each stretch of one.
    """

    centre: np.ndarray
    width: np.ndarray
    counts: np.ndarray

    def __repr__(self) -> str:
        ends = f"{self.centre[0]:.6g} to {self.centre[-1]:.6g}"
        return f"Density({self.count.sum()} values of {len(self.counts)} chains, {ends})"

    @classmethod
    def _of(cls, sample: ChainValues, bins_per_decade: int) -> Density:
        """Its edges are at whole parts of a decade, whatever the values."""
        positive = sample.values[sample.values > 0]
        require(positive.size, "no positive value")
        ends = positive.min(), positive.max()
        if not 1 / _MOST < ends[0] <= ends[1] < _MOST:
            around = "{:.3g} to {:.3g}".format(*ends)
            raise InputError(f"values from {around}: no bins hold them; take another unit")
        first = np.floor(np.log10(positive.min()) * bins_per_decade + 1e-9)
        last = np.ceil(np.log10(positive.max()) * bins_per_decade - 1e-9)
        edges = 10 ** (np.arange(first, max(last, first + 1) + 1) / bins_per_decade)
        edges[[0, -1]] *= 1 - 1e-12, 1 + 1e-12
        # the ends, where near an edge, are in the bin beside it
        edges[0], edges[-1] = min(edges[0], ends[0]), max(edges[-1], ends[1])
        centre, half = np.sqrt(edges[1:] * edges[:-1]), 10 ** (0.5 / bins_per_decade)
        counts = [np.histogram(values, edges)[0] for values in by_chain(sample)]
        return cls(centre, centre * (half - 1 / half), np.array(counts))

    @property
    def count(self) -> np.ndarray:
        """Values (B,) in each bin."""
        return self.counts.sum(axis=0)

    @property
    def density(self) -> np.ndarray:
        """Share of the values over the width of the bin (B,)."""
        return self.count / (self.count.sum() * self.width)

    @property
    def error(self) -> np.ndarray:
        """Standard error of the density (B,), by leaving out one chain after the other.

        NaN where it is not known: in bins without a value, and of one chain.
        """
        chains = len(self.counts)
        if chains < 2:
            return np.full(self.centre.size, np.nan)
        total = self.count - self.counts
        without = total / (total.sum(axis=1, keepdims=True) * self.width)
        return np.where(self.count, np.sqrt((chains - 1) * without.var(axis=0)), np.nan)

    def law(self) -> PowerLaw:
        """Power law through all bins, weighted by their counts: the exponents that Fig. 9 prints.

        The intervals are those of chains drawn anew. Of one chain stretches are drawn, and about 90
        in 100 hold the exponent that this line has of many more values; 80 where its motion changes
        and lasts. Values that end within a bin tilt the line, some by 0.07 in the exponent, where
        `power_law` does not err. That tests too, and refuses the few sizes of periodic motion. A
        warning tells where many bins of few values tilt the line.

        Returns
        -------
        PowerLaw
            From the centre of the first bin to that of the last.

        Raises
        ------
        NotEnoughDataError
            Fewer than 4 bins have a value.
        """
        fit = self._fit(self.counts)
        exponent, prefactor = _law_of(self.counts, lambda drawn: self._fit(drawn)[:2])
        # A bin of few values weighs more where it has more: of k, with the mean c, the mean of
        # k ln k is about c ln c + 1/2. By so much each bin pulls at the line.
        place, error = np.log(self.centre), estimates.error_of(exponent.low, exponent.high)
        apart = place[self.count > 0] - np.average(place, weights=self.count)
        if abs(pull := 0.5 * apart.sum() * error) > _PULLED:
            tilt = f"tilt the line by about {pull * error:+.2g}"
            warn(f"bins of few values {tilt}: take fewer bins a decade, or `power_law`")
        return PowerLaw(exponent, prefactor, fit.low, fit.high)

    def _fit(self, counts: np.ndarray) -> PowerLawFit:
        drawn = replace(self, counts=counts)
        ends = {"low": self.centre[0] * (1 - 1e-9), "high": self.centre[-1] * (1 + 1e-9)}
        return fit_log_log(self.centre, drawn.density, weight=drawn.count, **ends)


def _law_of(
    chains: np.ndarray, fit: Callable[[np.ndarray], tuple[float, float]]
) -> tuple[Estimate, Estimate]:
    """Exponent and prefactor that are fitted to chains, which are drawn anew."""

    def number(place: int, drawn: np.ndarray) -> float:
        try:
            value = fit(drawn)[place]
        except NotEnoughDataError:  # of few chains some draws have too few values
            return np.nan
        return float(np.log(value)) if place else value

    exponent, level = (estimates.bootstrap(partial(number, place), [chains]) for place in (0, 1))
    return exponent, estimates.mapped(np.exp, level)


@names.checked
def density(values: ChainValues | npt.ArrayLike, bins_per_decade: int = 5) -> Density:
    """Density of values in bins of equal width in their logarithm (Fig. 9).

    Parameters
    ----------
    values : ChainValues or array (S,)
        Values of chains, as `slip_sizes` gives them, whose scatter is the error; or those of one
        series in the order of time. Of fewer than 6 chains or one series stretches stand for
        chains, 16 together or a few more. Those of 0 and below are left out.
    bins_per_decade : int
        The edges of the bins are 10**(i / bins_per_decade).

    Returns
    -------
    Density
        From the bin of the least value to that of the greatest.

    Raises
    ------
    InputError, NotEnoughDataError
        The values are no finite numbers, or there are no bins; no value is above 0.
    """
    bins = checks.within("bins_per_decade", checks.key("bins_per_decade", bins_per_decade), ge=1)
    sample = _independent(values)
    made = Density._of(sample, int(bins))
    if made.width[0] < (step := step_of(np.sort(sample.values[sample.values > 0]))):
        narrow = f"bins below {step * made.centre[0] / made.width[0]:.2g} hold one of them or none"
        warn(f"values in steps of {step:.3g}: {narrow}, and a law through them is not theirs")
    return made


def most_probable(values: np.ndarray) -> float:
    """Middle of the bin of the largest density."""
    fine = Density._of(ChainValues(values, np.zeros(values.size)), FINE_BINS)
    return float(fine.centre[np.argmax(fine.density)])


# --- power laws -----------------------------------------------------------------------------------


@names.checked
def power_law(values: ChainValues | npt.ArrayLike, *, low: float | str | None = None) -> PowerLaw:
    """Power law of the density of values, by maximum likelihood, and its test.

    The law ends at the largest value. The test is that of Clauset, Shalizi and Newman (SIAM Review
    51, 661, 2009), where values that hang together count as fewer.

    Parameters
    ----------
    values : ChainValues or array (S,)
        As of `density`.
    low : float or "best", optional
        Lower end; if not given, the most probable value. "best": of twelve from there on, up to
        the 90 % quantile or the fiftieth largest value, the one from which the law comes nearest.

    Returns
    -------
    PowerLaw
        With p, the share of samples of this law that lie as far from their own fits as the values
        do. Below 0.1 the law is refused; above, the values may follow it, or be too few to tell.
        The intervals are those of chains drawn anew, between the same ends; those of values that do
        not follow the law hold for these ends alone.

    Raises
    ------
    InputError, NotEnoughDataError
        A value is not allowed; or they are as good as fewer than 50, span no range, or are rounded.
    """
    sample = _independent(values)
    given = isinstance(low, str) or low is None
    least = most_probable(sample.values) if given else checks.positive("low", low)
    if given:  # the middle of the bin may lie above all
        least = min(least, float(sample.values.max()))
    if isinstance(low, str):
        names.one_of("low", low, ["best"])
    positive, above = np.count_nonzero(sample.values > 0), sample.values >= least
    sample = ChainValues(sample.values[above], sample.chain[above])
    require(len(sample), f"no value of {least:.3g} or more")
    most = np.clip(1 - LEAST_VALUES / len(sample), 0.0, 0.9)  # so many have to lie above
    shares = np.linspace(0, most, STARTS_TRIED) if low == "best" else [0.0]
    starts = np.quantile(sample.values, shares) if given else np.array([least])
    worth = independent_values(np.log(sample.values), sample.chain)
    fit = goodness_of_fit(sample.values, starts, worth)
    logs = np.where(sample.values >= fit.low, np.log(sample.values), np.nan)
    chains = by_chain(ChainValues(logs, sample.chain))
    sums = np.array([(np.isfinite(logs).sum(), np.nansum(logs)) for logs in chains])
    share = sums[:, 0].sum() / positive

    def law(drawn: np.ndarray) -> tuple[float, float]:
        count, total = drawn.sum(axis=0)
        exponent = fit_exponent(total / count, fit.low, fit.high)
        area = fit.low ** (exponent + 1) * boxcox(fit.high / fit.low, exponent + 1)
        return exponent, share / area

    if abs((fit.exponent + 1) * np.log(fit.low)) > _MOST_LOG:
        few = "no number is as large or small as the prefactor: take another unit"
        raise InputError(f"values from {fit.low:.3g} on: {few}")
    return PowerLaw(*_law_of(sums, law), fit.low, fit.high, fit.p)
