"""Power spectra of sampled series: power laws in them (Figs. 8 and 16), and lines (Fig. 4).

The paper calls a spectrum with peaks at equal distances nearly periodic, and one without
quasi-continuous. Both are judged by eye there; here by the height of the peaks above their
surroundings, by a test of their places, and by the flatness of the spectrum.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError, NotEnoughDataError, require
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate, from_error
from beltrepro.stats.power_law import LEAST_DRAWN, PowerLaw, PowerLawFit, fit_log_log

# The paper prints no fit range for Fig. 8. Below the lower bound lie times longer than the
# stick-slip cycle of the whole chain (a plateau), above the upper one single slips (a steep fall).
FIT_BAND = (0.003, 0.3)
_RESAMPLES = 200
_ROUNDING = 1e-12  # of the values of a series
# Of a series whose stretches are drawn anew: cycles of the lowest frequency in each, and how many.
# With 4 the interval of noise of a known exponent holds it in 0.79 of the cases, from 6 on in 0.9.
_MEAN_CYCLES, _MOST_DRAWN = 10, 20
# Of a series, at most; the slowest motion in the fit must pass so often in each, at least. Two or
# three stretches tell their scatter so badly that the interval says nothing.
_STRETCHES, _LEAST_STRETCHES, _LEAST_CYCLES = 8, 4, 4

BAND_HZ = (0.2, 3.9)  # up to the end of FIT_BAND in Hz
SEGMENT_S = 20.0
LEAST_PEAKS = 4
# Over the median: noise, whose power by one segment is distributed exponentially, exceeds that at
# one frequency in 2^10, and at far fewer by several.
_HEIGHT = 10.0
_SURROUNDINGS_HZ = 0.8  # 16 frequencies: a line is 3 wide, and two do not raise their median
_APART = 3  # frequencies between peaks, at least: a line is so wide
_RANDOM_SETS = 1000


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
        single one they can differ by some 10 %.
        """
        return self._whole[1]

    @names.checked
    def law(self, low: float, high: float) -> PowerLaw:
        """Power law between two frequencies, as the one in Fig. 8.

        The series are cut into stretches of ten cycles of the lowest frequency or more, at most 20
        each. Their mean spectrum, in ten bins a decade, has a straight line on doubly logarithmic
        axes. The intervals are those of 6 or more series drawn anew, or else of their stretches.
        Hann's window lets no exponent below about -4 be told: there half of the intervals hold it.

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
        high = min(high, 0.5 / self.sample_interval)  # samples tell of none beyond
        frequency, power = self._drawn(low, high)

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
            f"the series lasts {size * interval:.0f}: {least} stretches of "
            f"{shortest:.0f} are needed for nu >= {low:g}",
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


# --- lines --------------------------------------------------------------------------------------


class Lines(NamedTuple):
    """What stands out of a power spectrum."""

    # geometric over arithmetic mean of the power over its running median, in the band: 1 for a
    # smooth spectrum, near 0 where lines hold nearly all
    flatness: float
    peaks_hz: np.ndarray  # where power exceeds _HEIGHT times that median


class Spacing(NamedTuple):
    """The one frequency whose multiples are nearest to the peaks."""

    step_hz: float
    p: float  # share of sets of as many random peaks that are as near to those of their best step


def lines(
    values: npt.ArrayLike, interval_s: float, *, band_hz: tuple[float, float] = BAND_HZ
) -> Lines:
    """Find the lines in a band of the spectrum of a series."""
    values = np.asarray(values, dtype=float)
    segment = round(SEGMENT_S / interval_s)
    require(
        values.size >= segment,
        f"{values.size * interval_s:.0f} s, a spectrum of lines needs {SEGMENT_S:g} s",
    )
    frequency, power = power_spectrum(values, interval_s, segment=segment)
    size = round(_SURROUNDINGS_HZ / (frequency[1] - frequency[0]))
    level = np.exp(scipy.ndimage.median_filter(np.log(power), size, mode="nearest"))
    inside = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    excess = power / level
    flatness = np.exp(np.log(excess[inside]).mean()) / excess[inside].mean()
    peaks, _ = scipy.signal.find_peaks(excess, height=_HEIGHT, distance=_APART)
    peaks = peaks[inside[peaks]]
    # between the frequencies, by parabolas through the logarithm of the power
    before, at, after = (np.log(power[peaks + shift]) for shift in (-1, 0, 1))
    shift = (before - after) / (2 * (before - 2 * at + after))
    return Lines(float(flatness), frequency[peaks] + shift * (frequency[1] - frequency[0]))


def spacing(peaks_hz: npt.ArrayLike) -> Spacing:
    """Test whether peaks are multiples of one frequency.

    The step is the one with the highest concentration, mean of cos(2 pi peak / step), from about
    half the smallest distance of the peaks up to the lowest of them. Random peaks are uniform in
    the band and as far apart as `lines` finds them; each set has its own best step.
    """
    peaks = np.sort(np.asarray(peaks_hz, dtype=float))
    require(peaks.size >= LEAST_PEAKS, f"{peaks.size} peaks, {LEAST_PEAKS} are needed")
    step, concentration = _best_step(peaks)
    stream = np.random.default_rng(1)
    apart = _APART / SEGMENT_S
    room = BAND_HZ[1] - BAND_HZ[0] - (peaks.size - 1) * apart
    reached = 0
    for _ in range(_RANDOM_SETS):
        places = BAND_HZ[0] + np.sort(stream.uniform(0, room, peaks.size))
        reached += _best_step(places + apart * np.arange(peaks.size))[1] >= concentration
    return Spacing(step, (1 + reached) / (1 + _RANDOM_SETS))


def _best_step(peaks: np.ndarray) -> tuple[float, float]:
    """The step with the highest concentration, and that concentration."""
    shortest = np.diff(peaks).min() / 2
    # The lowest peak is some multiple of the step. Which ones the others are follows, and then the
    # step by least squares.
    multiple = np.arange(1, max(1, round(peaks[0] / shortest)) + 1)[:, np.newaxis]
    numbers = np.rint(multiple * peaks / peaks[0])
    steps = (numbers @ peaks) / (numbers**2).sum(axis=1)
    concentration = np.cos(2 * np.pi * peaks / steps[:, np.newaxis]).mean(axis=1)
    best = concentration.argmax()
    return float(steps[best]), float(concentration[best])
