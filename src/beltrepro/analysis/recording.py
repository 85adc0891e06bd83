"""What a measured x_N(t) tells: r, quiet stretches, spectra (Sec. II, Figs. 4 and 5)."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from beltrepro.analysis.errors import NotEnoughDataError, require
from beltrepro.analysis.spectra import FIT_BAND, PowerLawFit, fit_power_law, power_spectrum
from beltrepro.model.units import TIME_S

# The paper tells stretches of small amplitude from those of large amplitude by eye.
WINDOW_S = 5.0
QUIET = 0.05
SMALL, LARGE, WHOLE = "small", "large", "whole"
# A power law is fitted above the peak of a spectrum, up to where that of Fig. 8 is fitted to.
FIT_TO_HZ = FIT_BAND[1] / TIME_S
_SHORTEST_FIT = 3.0  # highest over lowest frequency
_LEAST_SAMPLES = 32
# Median intervals without a frame from which on a recording has a gap; r leaves gaps out.
_LONGEST_GAP = 3.0


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Power spectrum of a stretch of a recording.

    Attributes
    ----------
    begin_s, end_s : float
        The stretch.
    frequency_hz : array (F,)
        Frequencies.
    power : array (F,)
        Power spectral density, m^2/Hz.
    law : PowerLawFit or None
        Power law between the peak and FIT_TO_HZ; None if the peak lies too high for one.
    """

    begin_s: float
    end_s: float
    frequency_hz: np.ndarray
    power: np.ndarray
    law: PowerLawFit | None


@dataclass(frozen=True, eq=False)
class Recording:
    """A measured x_N(t) and what it tells.

    Attributes
    ----------
    time_s, x_m : array (T,)
        The samples after the transient.
    interval_s : float
        Median time between them.
    observed_s : float
        Time that they stand for, without gaps.
    disorder_parameter : float
        r = standard deviation of x_N over its mean (Eq. 4).
    mean_length, minimum_length, maximum_length : float
        Of x_N, metres.
    small_share : float
        Share of the time with small amplitude.
    small_s : array (L, 2)
        Begin and end of the stretches of small amplitude.
    laminar_share : float
        Share of the time in those of them that last longer than `laminar_s`.
    spectra : dict of Spectrum
        Of the "whole", and of the longest stretch of "small" and of "large" amplitude, where they
        are long enough.
    """

    time_s: np.ndarray
    x_m: np.ndarray
    interval_s: float
    observed_s: float
    disorder_parameter: float
    mean_length: float
    minimum_length: float
    maximum_length: float
    small_share: float
    small_s: np.ndarray
    laminar_share: float
    spectra: dict[str, Spectrum]

    def evenly(self, begin_s: float, end_s: float) -> np.ndarray:
        """Positions within a stretch at equal intervals, straight across gaps.

        Parameters
        ----------
        begin_s : float
            Begin of the stretch.
        end_s : float
            Its end.

        Returns
        -------
        array (S,)
            x_N every `interval_s`, metres.
        """
        inside = (self.time_s >= begin_s) & (self.time_s <= end_s)
        return _even(self.time_s[inside], self.x_m[inside], self.interval_s)[1]


def analyse(
    time_s: npt.ArrayLike,
    x_m: npt.ArrayLike,
    *,
    transient_s: float = 0.0,
    window_s: float = WINDOW_S,
    quiet: float = QUIET,
    laminar_s: float = 200 * TIME_S,
) -> Recording:
    """Analyse a recording of the last block, with frames at any instants.

    Means are over time: a sample stands for the time half-way to its neighbours, and gaps count for
    nothing. For spectra the samples are interpolated at equal intervals, straight across gaps.
    The amplitude is small where the standard deviation of x_N within a window is below a share of
    its mean. That criterion is ours: the paper gives none.

    Parameters
    ----------
    time_s : array (T,)
        Instants, seconds, rising.
    x_m : array (T,)
        Position of the last block from the support, metres.
    transient_s : float
        Seconds left out at the beginning (Sec. II: 200).
    window_s : float
        Length of the window for the amplitude, seconds.
    quiet : float
        Share of the mean length below which the amplitude is small.
    laminar_s : float
        Seconds that a stretch of small amplitude must exceed to be a laminar phase; 200 model units
        if not given, as in simulations.

    Returns
    -------
    Recording
        What they tell.

    Raises
    ------
    NotEnoughDataError
        Fewer than 32 samples after the transient, no time between them, or a mean length that is
        not positive.
    """
    time, position = np.asarray(time_s, dtype=float), np.asarray(x_m, dtype=float)
    require(time.shape == position.shape and time.ndim == 1, "as many instants as positions needed")
    require(np.all(np.isfinite(time)) and np.all(np.isfinite(position)), "numbers must be finite")
    kept = time >= transient_s + (time[0] if time.size else 0.0)
    time, position = time[kept], position[kept]
    require(
        time.size >= _LEAST_SAMPLES,
        f"{time.size} samples after the first {transient_s:g} s, {_LEAST_SAMPLES} are needed",
    )
    gaps = np.diff(time)
    require(np.all(gaps > 0), "instants must rise")
    interval = float(np.median(gaps))
    weight = _weights(gaps, interval)
    mean = float(np.average(position, weights=weight))
    require(mean > 0, f"the mean of x_N is {mean:.3g} m: it must be measured from the support")
    spread = float(np.sqrt(np.average((position - mean) ** 2, weights=weight)))
    small = _is_small(time, position, interval, window_s, quiet)
    quiet_s = _stretches(time, small)
    lasting = quiet_s[np.diff(quiet_s, axis=1)[:, 0] > laminar_s]
    laminar = np.any((time >= lasting[:, :1]) & (time <= lasting[:, 1:]), axis=0)
    return Recording(
        time_s=time,
        x_m=position,
        interval_s=interval,
        observed_s=float(weight.sum()),
        disorder_parameter=spread / mean,
        mean_length=mean,
        minimum_length=float(position.min()),
        maximum_length=float(position.max()),
        small_share=float(weight[small].sum() / weight.sum()),
        small_s=quiet_s,
        laminar_share=float(weight[laminar].sum() / weight.sum()),
        spectra=_spectra(time, position, interval, quiet_s, _stretches(time, ~small)),
    )


def _weights(gaps: np.ndarray, interval: float) -> np.ndarray:
    """Seconds (T,) that each sample stands for."""
    counted = np.where(gaps > _LONGEST_GAP * interval, interval, gaps) / 2
    return np.pad(counted, (1, 0)) + np.pad(counted, (0, 1))


def _even(time: np.ndarray, position: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """The samples at equal intervals."""
    instants = np.arange(time[0], time[-1] + interval / 2, interval)
    return instants, np.interp(instants, time, position)


def _is_small(
    time: np.ndarray, position: np.ndarray, interval: float, window_s: float, quiet: float
) -> np.ndarray:
    """Which samples (T,) lie in a window with a small amplitude."""
    instants, even = _even(time, position, interval)
    size = max(3, min(round(window_s / interval), even.size))
    centred = even - even.mean()
    mean, square = (ndimage.uniform_filter1d(each, size) for each in (centred, centred**2))
    amplitude = np.sqrt(np.maximum(square - mean**2, 0))
    calm = amplitude < quiet * (mean + even.mean())
    # A window with a burst is not quiet, but samples beside the burst are: give them back.
    calm = ndimage.binary_dilation(calm, np.ones(2 * (size // 2) + 1)) if calm.any() else calm
    return calm[np.clip(np.rint((time - time[0]) / interval).astype(int), 0, instants.size - 1)]


def _stretches(time: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Begin and end (L, 2) of the runs of samples that are chosen."""
    change = np.flatnonzero(np.diff(np.pad(chosen.astype(np.int8), 1)))
    return np.column_stack([time[change[::2]], time[change[1::2] - 1]])


def _spectra(
    time: np.ndarray,
    position: np.ndarray,
    interval: float,
    quiet_s: np.ndarray,
    lively_s: np.ndarray,
) -> dict[str, Spectrum]:
    """Spectra of the whole, and of the longest stretches of each kind."""
    spans = {WHOLE: (time[0], time[-1])}
    for name, stretches in ((SMALL, quiet_s), (LARGE, lively_s)):
        if len(stretches):
            spans[name] = tuple(stretches[np.argmax(np.diff(stretches, axis=1))])
    found = {}
    for name, (begin, end) in spans.items():
        inside = (time >= begin) & (time <= end)
        if inside.sum() >= _LEAST_SAMPLES:
            found[name] = _spectrum(time[inside], position[inside], interval)
    return found


def _spectrum(time: np.ndarray, position: np.ndarray, interval: float) -> Spectrum:
    """Spectrum of a stretch."""
    frequency, power = power_spectrum(_even(time, position, interval)[1], interval)
    low, law = float(frequency[power.argmax()]), None
    with suppress(NotEnoughDataError):
        require(low * _SHORTEST_FIT <= FIT_TO_HZ, "no room above the peak")
        law = fit_power_law(frequency, power, low=low, high=FIT_TO_HZ)
    return Spectrum(float(time[0]), float(time[-1]), frequency, power, law)
