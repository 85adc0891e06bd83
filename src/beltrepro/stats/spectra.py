"""Power spectra of sampled series: power laws (Figs. 8, 16), and peaks at equal distances (Fig. 4).

The paper calls motion with such peaks nearly periodic, and a spectrum without them
quasi-continuous, both by eye.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError, NotEnoughDataError, require, warn
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate, from_error
from beltrepro.stats.power_law import LEAST_DRAWN, PowerLaw, PowerLawFit, fit_log_log

# The paper prints no fit range for Fig. 8. Below the lower bound lie times longer than the
# stick-slip cycle of the whole chain (a plateau), above the upper one single slips (a steep fall).
FIT_BAND = (0.003, 0.3)
_RESAMPLES = 200
# Mean over median power of so many frequencies, the geometric mean of the range: 1.2 to 7 of
# irregular motion, 50 and more of orbits whose period passes ten times in a series.
_AROUND, _LINES = 101, 30.0
# Share of the power over its law, each decade alike, that is in the strongest tenth of the range:
# 0.3 of noise, up to 0.9 of irregular motion, 0.98 and more of few or narrow peaks.
_STRONGEST, _PEAKS = 0.1, 0.95
# Variance of a mean over frequencies, over that of independent ones: Hann's window makes neighbours
# alike. Up to 5 times that much is found in irregular motion of one kind, 3.7 to 2700 where it
# changes between two.
_OF_HANN, _UNLIKE = 1.94, 6.0
_TINY = np.finfo(float).tiny
_ROUNDING = 1e-12  # of the values of a series
# Of a series whose stretches are drawn anew: cycles of the lowest frequency in each, and how many.
# With 4 the interval of noise of a known exponent holds it in 0.79 of the cases, from 6 on in 0.9.
_MEAN_CYCLES, _MOST_DRAWN = 10, 20
# Of a series, at most; the slowest motion in the fit must pass so often in each, at least. Two or
# three stretches tell their scatter so badly that the interval says nothing.
_STRETCHES, _LEAST_STRETCHES, _LEAST_CYCLES = 8, 4, 4

HIGHEST_HZ = 8.0  # beyond it lies only the noise of the picture
SEGMENT_S = 20.0
# Of a comb. Half of the narrowest is three frequencies of the spectrum, which Hann's window keeps
# apart; of the widest there are four multiples. From one to the next all move by less than that.
_SPACINGS_HZ = np.geomspace(0.3, HIGHEST_HZ / 4, 700)
_MULTIPLES = np.floor(HIGHEST_HZ / _SPACINGS_HZ).astype(int)
_NOISES = 400  # series of noise


def power_spectrum(
    values: npt.ArrayLike, sample_interval: float, *, segment: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """One-sided power spectral density of a sampled series, mean removed."""
    values = np.asarray(values, dtype=float)
    require(values.size >= 16, f"{values.size} samples, a spectrum needs 16")
    if np.ptp(values) <= _ROUNDING * np.abs(values).max():  # at rest
        values = np.zeros_like(values)
    length = values.size if segment is None else min(int(segment), values.size)
    frequency, power = scipy.signal.welch(
        values, fs=1 / sample_interval, nperseg=length, detrend="constant"
    )
    return frequency[1:], power[1:]


def fit_power_law(
    frequency: npt.ArrayLike, power: npt.ArrayLike, *, low: float, high: float
) -> PowerLawFit:
    """S(nu) = prefactor * nu**exponent for low <= nu <= high.

    The spectrum is averaged in ten bins a decade first, so that each decade counts
    alike and the logarithm of a noisy periodogram does not bias the level; the line through the
    bins is unweighted.
    """
    return fit_log_log(*_bins(frequency, power, low, high), low=low, high=high)


def _bins(
    frequency: npt.ArrayLike, power: npt.ArrayLike, low: float, high: float
) -> tuple[np.ndarray, np.ndarray]:
    """Frequency and mean power of ten bins a decade."""
    frequency, power = np.asarray(frequency, dtype=float), np.asarray(power, dtype=float)
    used = (frequency >= low) & (frequency <= high)
    require(used.any(), f"no frequency between {low:.3g} and {high:.3g}")
    place = np.floor(np.log10(frequency[used]) * 10).astype(int)
    _, place, count = np.unique(place, return_inverse=True, return_counts=True)
    centre = np.exp(np.bincount(place, np.log(frequency[used])) / count)
    return centre, np.bincount(place, power[used]) / count


@dataclass(frozen=True, eq=False, repr=False)
class PowerSpectrum:
    """Power spectrum of sampled series, of each without its mean; the mean over the series.

    Attributes
    ----------
    series : array (R, T)
        Samples of R series that are independent.
    sample_interval : float
        Time between them.
    """

    series: np.ndarray
    sample_interval: float

    def __repr__(self) -> str:
        (count, size), frequency = self.series.shape, self.frequency
        ends = f"frequency {frequency[0]:.6g} to {frequency[-1]:.6g}"
        return f"PowerSpectrum({count} series of {size} samples, {ends})"

    @cached_property
    def _whole(self) -> tuple[np.ndarray, np.ndarray]:
        spectra = [power_spectrum(values, self.sample_interval) for values in self.series]
        return spectra[0][0], np.mean([power for _, power in spectra], axis=0)

    @property
    def frequency(self) -> np.ndarray:
        """Frequencies (F,), 1 / time: multiples of the one that passes once in a series."""
        return self._whole[0]

    @property
    def power(self) -> np.ndarray:
        """One-sided power spectral density (F,).

        Its integral is the variance up to Hann's window, which weighs the middle of a series: of a
        single one they can differ by 20 %, and by far more where its motion changes and lasts.
        """
        return self._whole[1]

    @names.checked
    def law(self, low: float, high: float) -> PowerLaw:
        """Power law between two frequencies, as the one in Fig. 8.

        The series are cut into stretches of ten cycles of the lowest frequency or more, at most 20
        each. Their mean spectrum, in ten bins a decade, has a straight line on doubly logarithmic
        axes. The intervals are those of 6 or more series drawn anew, or else of their stretches; of
        6 to 8 series about 90 in 100 hold the exponent. Those of fewer do not hold what lasts
        longer than a stretch; a warning tells where stretches differ by more than chance, another
        where lines or narrow peaks hold the power. Hann's window lets none below about -4 be told:
        there half of the intervals hold it.

        Parameters
        ----------
        low, high : float
            Frequencies, 1 / time; about 0.003 and 0.3 in the paper.

        Returns
        -------
        PowerLaw
            Of the power; that of the amplitude, which Fig. 8 shows, has half its exponent.

        Raises
        ------
        InputError, NotEnoughDataError
            The frequencies are no range; there are too few stretches, or all is at rest.
        """
        low, high = checks.positive("low", low), checks.finite_number("high", high)
        if not low < high:
            raise InputError(f"high = {high:g}: must be greater than low = {low:g}")
        last = 0.5 / self.sample_interval  # samples tell of none beyond
        if low >= last:
            raise InputError(f"low = {low:g}: must be below {last:g}, the last of the frequencies")
        high = min(high, last)
        frequency, power = self._drawn(low, high)
        if _of_lines(*self._whole, low, high):
            warn(
                "the spectrum is one of lines or narrow peaks, as of periodic motion: it follows "
                "no power law"
            )
        elif len(self.series) < LEAST_DRAWN and _excess(power) > _UNLIKE:
            warn(
                "stretches differ by more than chance, as of motion that changes: what lasts for "
                f"longer is not in the intervals; those of {LEAST_DRAWN} or more runs hold it"
            )

        def fit(drawn: np.ndarray) -> PowerLawFit:
            # The logarithm of a single noisy spectrum would lie too low where bins are narrow.
            return fit_power_law(frequency, drawn.mean(axis=0), low=low, high=high)

        exponent = estimates.bootstrap(lambda drawn: fit(drawn).exponent, [power])
        level = estimates.bootstrap(lambda drawn: np.log(fit(drawn).prefactor), [power])
        return PowerLaw(exponent, estimates.mapped(np.exp, level), low, high)

    @names.checked
    def exponent(self, low: float, high: float) -> Estimate:
        """Exponent of the `law` between two frequencies, negative where the power falls.

        Parameters
        ----------
        low, high : float
            As of `law`.

        Returns
        -------
        Estimate
            With its 95 % interval.

        Raises
        ------
        InputError, NotEnoughDataError
            As of `law`.
        """
        return self.law(low, high).exponent

    def _drawn(self, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
        """Frequencies of a range, and the power there of each series or stretch."""
        (series, size), interval = self.series.shape, self.sample_interval
        shortest = _MEAN_CYCLES / low
        count = min(_MOST_DRAWN, int(size * interval / shortest + 1e-9))
        least = -(-LEAST_DRAWN // series)
        require(
            count >= least,
            f"the series lasts {checks.rounded(size * interval, up=False)}: from a frequency of "
            f"{low:g} on {least} stretches of {shortest:.4g} are needed, "
            f"{checks.rounded(least * shortest, up=True)} in all",
        )
        length = size // count
        stretches = self.series[:, : count * length].reshape(-1, length)
        spectra = [power_spectrum(stretch, interval) for stretch in stretches]
        frequency = spectra[0][0]
        inside = (frequency >= low) & (frequency <= high)
        # Most of a spectrum lies above the range, and each resample would average it in vain.
        power = np.array([power[inside] for _, power in spectra])
        if series >= LEAST_DRAWN:  # what lasts longer than a stretch is in the interval then
            power = power.reshape(series, count, -1).mean(axis=1)
        return frequency[inside], power


def _of_lines(frequency: np.ndarray, power: np.ndarray, low: float, high: float) -> bool:
    """Whether lines or peaks hold nearly all the power around them, or of the range."""
    # of whole series: stretches may be too short to part the lines
    inside = (frequency >= low) & (frequency <= high)
    frequency, power = frequency[inside], np.maximum(power[inside], _TINY)
    size = min(_AROUND, power.size)
    around = (scipy.ndimage.uniform_filter1d, scipy.ndimage.median_filter)
    mean, median = (np.log(np.maximum(of(power, size), _TINY)) for of in around)
    over = power / fit_power_law(frequency, power, low=low, high=high)(frequency)
    order = np.argsort(-over)
    decades, share = 1 / frequency[order], over[order] / frequency[order]
    strongest = np.cumsum(decades) < _STRONGEST * decades.sum()
    return bool(
        np.mean(mean - median) > np.log(_LINES) or share[strongest].sum() > _PEAKS * share.sum()
    )


def _excess(power: np.ndarray) -> float:
    """Variance of the power of stretches (K, F), all frequencies alike, over that of noise."""
    levels = (power / np.maximum(power.mean(axis=0), _TINY)).mean(axis=1)
    return float(levels.var(ddof=1) * power.shape[1] / _OF_HANN)


def exponent_of(law: PowerLawFit, values: npt.ArrayLike, sample_interval: float) -> Estimate:
    """Exponent of a law that was fitted to the spectrum of one series without segments.

    Its interval is the widest of three, since a series may be anything but the noise that the law
    describes. (1) Gaussian noise with this law: few frequencies lie in the lowest bins, which weigh
    most, so that their scatter about the line would say too little. (2) That scatter: a spectrum of
    lines follows no power law, and its exponent hangs on what lies between them. (3) The exponents
    of stretches of the series: motion that switches between two kinds has two.
    """
    values = np.asarray(values, dtype=float)
    frequency, power = power_spectrum(values, sample_interval)
    centre, mean = _bins(frequency, power, law.low, law.high)
    scatter = scipy.stats.linregress(np.log(centre), np.log(mean)).stderr
    estimates = [
        from_error(law.exponent, _error_of_noise(law, frequency), None),
        from_error(law.exponent, scatter, None, centre.size - 2),
    ]
    count = min(_STRETCHES, int(values.size * sample_interval * law.low / _LEAST_CYCLES))
    if count >= _LEAST_STRETCHES:
        length = values.size // count
        parts = values[: count * length].reshape(count, length)
        spectra = [power_spectrum(part, sample_interval) for part in parts]
        try:
            laws = [fit_power_law(*one, low=law.low, high=law.high) for one in spectra]
        except NotEnoughDataError:  # the whole of a stretch is at rest
            return Estimate(law.exponent, np.nan, np.nan)
        error = float(scipy.stats.sem([part.exponent for part in laws]))
        estimates.append(from_error(law.exponent, error, None, count - 1))
    return max(estimates, key=lambda estimate: estimate.high)


def _error_of_noise(law: PowerLawFit, frequency: np.ndarray) -> float:
    """Standard deviation of the exponents of Gaussian noise with a law, at these frequencies."""
    frequency = frequency[: np.searchsorted(frequency, law.high) + 2]
    amplitude = np.concatenate([[0.0], np.sqrt(law(frequency))])  # the mean was removed
    rng = np.random.default_rng(0)
    exponents = []
    for _ in range(_RESAMPLES):
        waves = amplitude * (rng.standard_normal((amplitude.size, 2)) @ [1, 1j])
        windowed = waves[1:-1] - (waves[:-2] + waves[2:]) / 2  # Hann's window
        power = np.abs(windowed) ** 2
        exponents.append(fit_power_law(frequency[:-1], power, low=law.low, high=law.high).exponent)
    return float(np.std(exponents))


# --- peaks at equal distances ---------------------------------------------------------------------


class Comb(NamedTuple):
    """The spacing of which the multiples stand out most in a spectrum."""

    spacing_hz: float
    peaks: np.ndarray  # of each multiple up to HIGHEST_HZ: does it stand out as 5 % of noise do?
    p: float  # share of series of white noise in which those of some spacing stand out as much

    @property
    def found(self) -> bool:
        return self.p < 0.01


def comb(values: npt.ArrayLike, interval_s: float) -> Comb:
    """Test for peaks at all multiples of one frequency, up to HIGHEST_HZ.

    A multiple stands out by the logarithm of the power there, less that of the power law through
    the places half a spacing to both sides. Each counts at most as one in a hundred of noise, since
    a lone peak is no comb.
    """
    values = np.asarray(values, dtype=float)
    require(
        values.size >= round(SEGMENT_S / interval_s),
        f"{values.size * interval_s:.0f} s, a spectrum of peaks needs {SEGMENT_S:g} s",
    )
    tooth, most, by_chance = _of_noise(values.size, float(interval_s))
    heights = _heights(values, interval_s)
    together = _together(heights, most)
    best = np.lexsort((heights.sum(axis=1), together))[-1]  # of several, that of the highest peaks
    peaks = heights[best, : _MULTIPLES[best]] > tooth
    p = float(np.sum(by_chance >= together[best]) + 1) / (_NOISES + 1)
    return Comb(float(_SPACINGS_HZ[best]), peaks, p)


def _heights(values: np.ndarray, interval_s: float) -> np.ndarray:
    """By how much each multiple (S, M) of each spacing stands out; 0 beyond HIGHEST_HZ."""
    segment = round(SEGMENT_S / interval_s)
    frequency, power = power_spectrum(values, interval_s, segment=segment)
    numbers = np.arange(1, 2 * _MULTIPLES.max() + 2) / 2
    halves = np.outer(_SPACINGS_HZ, numbers)
    places = np.rint(halves / frequency[0]).astype(int) - 1
    log = np.log(np.maximum(power, _TINY)).take(places, mode="clip")
    before, at, after = numbers[:-2:2], numbers[1::2], numbers[2::2]
    weight = np.log(after / at) / np.log(after / before)
    heights = log[:, 1::2] - weight * log[:, :-2:2] - (1 - weight) * log[:, 2::2]
    return np.where(halves[:, 1::2] <= HIGHEST_HZ, heights, 0.0)


def _together(heights: np.ndarray, most: float) -> np.ndarray:
    """How much the multiples of each spacing stand out together, in one scale for all numbers."""
    return np.clip(heights, -most, most).sum(axis=1) / np.sqrt(_MULTIPLES)


@lru_cache
def _of_noise(size: int, interval_s: float) -> tuple[float, float, np.ndarray]:
    """Heights that one in twenty and in a hundred exceed; of each series, the best together."""
    stream = np.random.default_rng(1)
    sets = [_heights(stream.standard_normal(size), interval_s) for _ in range(_NOISES)]
    tooth, most = np.quantile([heights[0] for heights in sets], (0.95, 0.99))
    return tooth, most, np.array([_together(heights, most).max() for heights in sets])
