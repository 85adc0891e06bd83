"""Lines in a power spectrum: whether there are peaks, and whether they are equally spaced (Fig. 4).

The paper calls a spectrum with peaks at equal distances nearly periodic, and one without
quasi-continuous. Both are judged by eye there; here by the height of the peaks above their
surroundings, by a test of their places, and by the flatness of the spectrum.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require
from beltrepro.stats.spectra import power_spectrum

BAND_HZ = (0.2, 3.9)
SEGMENT_S = 20.0
HEIGHT = 10.0
LEAST_PEAKS = 4
_SURROUNDINGS_HZ = 0.8
_APART = 3  # frequencies between peaks, at least: a line is so wide
_RANDOM_SETS = 1000
_SEED = 1


class Lines(NamedTuple):
    """What stands out of a power spectrum."""

    # geometric over arithmetic mean of the power over its running median, in the band: 1 for a
    # smooth spectrum, near 0 where lines hold nearly all
    flatness: float
    peaks_hz: np.ndarray  # where power exceeds HEIGHT times that median


class Spacing(NamedTuple):
    """The one frequency whose multiples are nearest to the peaks."""

    step_hz: float  # that frequency
    # mean of cos(2 pi peak / step): 1 if all peaks are multiples, 0 on average for a fixed step
    # and random peaks
    concentration: float
    # share of sets of as many random peaks that reach this concentration with their best step
    p: float


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
    peaks, _ = scipy.signal.find_peaks(excess, height=HEIGHT, distance=_APART)
    peaks = peaks[inside[peaks]]
    # between the frequencies, by parabolas through the logarithm of the power
    before, at, after = (np.log(power[peaks + shift]) for shift in (-1, 0, 1))
    shift = (before - after) / (2 * (before - 2 * at + after))
    return Lines(float(flatness), frequency[peaks] + shift * (frequency[1] - frequency[0]))


def spacing(peaks_hz: npt.ArrayLike) -> Spacing:
    """Test whether peaks are multiples of one frequency.

    The step is the one with the highest concentration, from about half the smallest distance of the
    peaks up to the lowest of them. Random peaks are uniform in the band and as far apart as `lines`
    finds them; each set has its own best step.
    """
    peaks = np.sort(np.asarray(peaks_hz, dtype=float))
    require(peaks.size >= LEAST_PEAKS, f"{peaks.size} peaks, {LEAST_PEAKS} are needed")
    step, concentration = _best_step(peaks)
    stream = np.random.default_rng(_SEED)
    apart = _APART / SEGMENT_S
    room = BAND_HZ[1] - BAND_HZ[0] - (peaks.size - 1) * apart
    reached = 0
    for _ in range(_RANDOM_SETS):
        places = BAND_HZ[0] + np.sort(stream.uniform(0, room, peaks.size))
        reached += _best_step(places + apart * np.arange(peaks.size))[1] >= concentration
    return Spacing(step, concentration, (1 + reached) / (1 + _RANDOM_SETS))


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
