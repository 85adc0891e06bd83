"""What a measured x_N(t) tells: r, quiet stretches, spectra (Sec. II, Figs. 4 and 5)."""

from __future__ import annotations

import math
import warnings
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from beltrepro.base import checks
from beltrepro.base.errors import InputError, NotEnoughDataError, require
from beltrepro.model.units import TIME_S
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.power_law import PowerLawFit
from beltrepro.stats.spectra import FIT_BAND, exponent_of, fit_power_law, power_spectrum

# The paper tells stretches of small amplitude from those of large amplitude by eye.
WINDOW_S = 5.0
QUIET = 0.05
LASTING_S = 200 * TIME_S  # as laminar phases in simulations
SMALL, LARGE, WHOLE = "small", "large", "whole"
# A power law is fitted above the peak of a spectrum, up to where that of Fig. 8 is fitted to.
FIT_TO_HZ = FIT_BAND[1] / TIME_S
# Median intervals without a frame from which on a recording has a gap; r leaves gaps out. Between
# two whole numbers of frames, so that no rounding of instants decides.
LONGEST_GAP = 5.5
_SHORTEST_FIT = 3.0  # highest over lowest frequency
_LEAST_SAMPLES = 32
_FEW_CHANGES = 10  # of the amplitude; with six intervals hold r in 86 of 100 recordings
_LONGEST_M = 40.0  # mean length of a chain: of 200 blocks, or of five in centimetres
_MOST_SAMPLES = 10**7  # at equal intervals, which fit into memory


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Power spectrum of a stretch of a recording."""

    begin_s: float  # the stretch
    end_s: float
    x_m: np.ndarray  # its positions at equal intervals
    frequency_hz: np.ndarray
    power: np.ndarray  # power spectral density, m^2/Hz
    law: PowerLawFit | None  # from the peak to FIT_TO_HZ; None if the peak lies too high for one

    @cached_property
    def exponent(self) -> Estimate | None:
        """Exponent of the law, with its error."""
        interval_s = 1 / (self.frequency_hz[0] * self.x_m.size)
        return None if self.law is None else exponent_of(self.law, self.x_m, interval_s)


@dataclass(frozen=True, eq=False)
class Regimes:
    """Where x_N(t) has a small amplitude, and its moments."""

    interval_s: float  # median time between samples
    weight_s: np.ndarray  # time that each sample stands for, without gaps
    disorder_parameter: float  # r = standard deviation of x_N over its mean (Eq. 4)
    mean_length: float  # of x_N, metres
    small_share: float  # share of the time with small amplitude, in that with small or large one
    lasting_share: float  # share of the time in those stretches of it that last
    small: np.ndarray  # which samples have a small amplitude
    large: np.ndarray  # and a large one; those in pieces shorter than a window have neither
    small_s: np.ndarray  # begin and end of the stretches of small amplitude
    lasting_s: np.ndarray  # those of them that last
    lively_s: np.ndarray  # begin and end of the stretches between those that last

    @property
    def observed_s(self) -> float:
        """Time that the samples stand for together."""
        return float(self.weight_s.sum())


@dataclass(frozen=True, eq=False)
class Recording(Regimes):
    """A measured x_N(t) and what it tells."""

    time_s: np.ndarray  # the samples after the transient
    x_m: np.ndarray  # without the lengths of blocks that were taken off
    # r and <x_N> (metres) with the errors of a recording of this length; their runs are the
    # stretches of the recording that are independent
    disorder: Estimate
    length: Estimate
    # of the "whole", and of the longest stretch of "small" and of "large" amplitude, where they
    # are long enough
    spectra: dict[str, Spectrum]


def analyse(
    time_s: npt.ArrayLike,
    x_m: npt.ArrayLike,
    *,
    transient_s: float = 0.0,
    window_s: float = WINDOW_S,
    quiet: float = QUIET,
    blocks_m: float = 0.0,
    n_blocks: int = 5,
) -> Recording:
    """Analyse a recording of the last block, with frames at any instants.

    Means are over time: a sample stands for the time half-way to its neighbours, and gaps count for
    nothing. Stretches end at a gap, spectra are those of stretches without one, and a warning tells
    how much of the whole that leaves out. For both the samples are interpolated at equal intervals.
    The amplitude is small where the standard deviation of x_N within a window is below a share of
    its mean. That criterion is ours: the paper gives none. A laminar phase of a simulation is
    something else, a long slip of the last block (docs/experiment.md).

    blocks_m : lengths of blocks that x_m holds, taken off: x_N of the model has none.
    n_blocks : of the chain; positions of fewer than five in centimetres are told by it.
    """
    time, position = checks.as_numbers(time_s), checks.as_numbers(x_m)
    require(
        time.ndim == 1 and time.shape == position.shape and np.isfinite([time, position]).all(),
        "time_s and x_m must be finite numbers, as many instants as positions",
    )
    checks.not_negative("transient_s", transient_s)
    kept = time >= transient_s + time.min(initial=math.inf)
    time, position = time[kept], position[kept] - checks.not_negative("blocks_m", blocks_m)
    lowest = position.min(initial=math.inf)
    require(
        lowest > 0,
        f"x_N reaches {lowest + blocks_m:.3g} m: it must be measured from the support, and hold "
        f"the {blocks_m:.3g} m of blocks",
    )
    mean = position.mean() if position.size else 1.0  # `regimes` says that there are no samples
    require(
        0 < mean < _LONGEST_M * min(1, n_blocks / 5) ** 2,  # the friction of all blocks adds up
        f"the mean of x_N is {mean:.3g} m: centimetres and millimetres must become metres",
    )
    parts = regimes(time, position, window_s=window_s, quiet=quiet)
    middle = float(np.median(position))  # of a block at rest it leaves 0, a mean what it rounds off
    moments = estimates.sums_in_stretches(position - middle, parts.weight_s)
    disorder, length = (
        estimates.mapped(np.exp, estimates.from_stretches(partial(log, middle), moments))
        for log in (_log_disorder, _log_mean)
    )
    stretches_s = np.concatenate([parts.lasting_s, parts.lively_s])
    lasts = np.argsort(stretches_s[:, 0]) < len(parts.lasting_s)  # in their order
    changes = np.count_nonzero(np.diff(lasts))
    if 0 < changes < _FEW_CHANGES and math.isfinite(disorder.low):
        rarely = "intervals hold r in fewer than 95 of 100 such recordings (docs/experiment.md)"
        warnings.warn(f"the amplitude changes for long {changes} times: {rarely}", stacklevel=2)
    spectra = _spectra(time, position, parts)
    if len(_pieces(time, parts.interval_s)) > 1:
        span, one = np.ptp(time), spectra[WHOLE]
        used = f"the spectrum of the whole is of {one.end_s - one.begin_s:.3g} s without one"
        missing = f"{span - parts.observed_s:.3g} s of {span:.3g} s of the recording"
        untold = parts.weight_s[~(parts.small | parts.large)].sum()
        pieces = f"; {untold:.3g} s are in pieces too short to tell their amplitude" * bool(untold)
        warnings.warn(f"gaps are {missing}: {used}{pieces}", stacklevel=2)
    return Recording(**vars(parts), time_s=time, x_m=position,
                     disorder=disorder, length=length, spectra=spectra)  # fmt: skip


def regimes(
    time: np.ndarray,
    position: np.ndarray,
    *,
    window_s: float = WINDOW_S,
    quiet: float = QUIET,
    lasting_s: float = LASTING_S,
) -> Regimes:
    """r of a recording, and its stretches of small and of large amplitude.

    What `analyse` tells but for errors and spectra, so that a film and a simulation that is sampled
    like one are judged alike.
    """
    checks.positive("window_s", window_s)
    checks.positive("quiet", quiet)
    require(time.size >= _LEAST_SAMPLES, f"{time.size} samples, {_LEAST_SAMPLES} are needed")
    gaps = np.diff(time)
    require(np.all(gaps > 0), "instants time_s must rise")
    interval = float(np.median(gaps))
    require(
        np.ptp(time) < _MOST_SAMPLES * interval,
        f"samples every {interval:.3g} s over {np.ptp(time):.3g} s: too far apart",
    )
    if window_s < 3 * interval:
        every = f"there is one every {interval:.3g} s"
        raise InputError(f"window_s = {window_s:g}: it must hold 3 samples or more, and {every}")
    longest = LONGEST_GAP * interval
    halves = np.where(gaps > longest, interval, gaps) / 2
    weight = np.pad(halves, (1, 0)) + np.pad(halves, (0, 1))
    mean = float(np.average(position, weights=weight))
    spread = float(np.sqrt(np.average((position - mean) ** 2, weights=weight)))
    parts, small, large = _pieces(time, interval), *np.zeros((2, time.size), dtype=bool)
    for one in parts:  # one that is shorter than the window does not tell its amplitude
        if len(parts) == 1 or np.ptp(time[one]) >= window_s:
            small[one] = _is_small(time[one], position[one], interval, window_s, quiet)
            large[one] = ~small[one]
    judged_s = weight[small | large].sum()
    small_s = stretches(time, small, longest)
    lasting = small_s[np.diff(small_s, axis=1)[:, 0] > lasting_s]
    in_lasting = np.any((time >= lasting[:, :1]) & (time <= lasting[:, 1:]), axis=0)
    return Regimes(
        interval_s=interval,
        weight_s=weight,
        disorder_parameter=spread / mean,
        mean_length=mean,
        small_share=float(weight[small].sum() / judged_s) if judged_s else math.nan,
        lasting_share=float(weight[in_lasting].sum() / weight.sum()),
        small=small,
        large=large,
        small_s=small_s,
        lasting_s=lasting,
        lively_s=stretches(time, ~in_lasting, longest),
    )


def stretches(time: np.ndarray, chosen: np.ndarray, longest: float = math.inf) -> np.ndarray:
    """Begin and end (L, 2) of the runs of samples that are chosen, which longer steps end."""
    joined = chosen[1:] & chosen[:-1] & (np.diff(time) <= longest)
    begins, ends = (chosen & ~np.pad(joined, side) for side in ((1, 0), (0, 1)))
    return np.column_stack([time[begins], time[ends]])


def _pieces(time: np.ndarray, interval: float) -> list[np.ndarray]:
    """Numbers of the samples of each piece without a gap."""
    cuts = np.flatnonzero(np.diff(time) > LONGEST_GAP * interval) + 1
    return np.split(np.arange(time.size), cuts)


def _log_mean(middle: float, moments: np.ndarray) -> float:
    weight, first, _ = moments
    return math.log(middle + first / weight)


def _log_disorder(middle: float, moments: np.ndarray) -> float:
    """ln r of sums of weights, x_N - middle and its squares: errors of a factor are alike for r."""
    weight, first, second = moments
    variance = second / weight - (first / weight) ** 2
    return math.log(variance) / 2 - _log_mean(middle, moments) if variance > 0 else -math.inf


def _even(time: np.ndarray, position: np.ndarray, interval: float) -> np.ndarray:
    """Positions at equal intervals."""
    return np.interp(np.arange(time[0], time[-1] + interval / 2, interval), time, position)


def _is_small(
    time: np.ndarray, position: np.ndarray, interval: float, window_s: float, quiet: float
) -> np.ndarray:
    """Which samples (T,) lie in a window with a small amplitude."""
    even = _even(time, position, interval)
    size = max(3, min(round(window_s / interval), even.size))
    centred = even - even.mean()
    mean, square = (ndimage.uniform_filter1d(power, size) for power in (centred, centred**2))
    amplitude = np.sqrt(np.maximum(square - mean**2, 0))
    calm = amplitude < quiet * (mean + even.mean())
    # A window with a burst is not quiet, but samples beside the burst are: give them back.
    calm = ndimage.maximum_filter1d(calm, 2 * (size // 2) + 1, mode="constant")
    return calm[np.clip(np.rint((time - time[0]) / interval).astype(int), 0, even.size - 1)]


def _spectra(time: np.ndarray, position: np.ndarray, parts: Regimes) -> dict[str, Spectrum]:
    """Spectra of the whole, and of the longest stretches of each kind."""
    small, large, longest = parts.small, parts.large, LONGEST_GAP * parts.interval_s
    spectra = {}
    for name, chosen in ((WHOLE, np.ones_like(small)), (SMALL, small), (LARGE, large)):
        spans = stretches(time, chosen, longest)
        begin, end = max(spans, key=np.ptp, default=(math.inf, math.inf))
        inside = (time >= begin) & (time <= end)
        if inside.sum() < _LEAST_SAMPLES:
            continue
        even = _even(time[inside], position[inside], parts.interval_s)
        frequency, power = power_spectrum(even, parts.interval_s)
        low, law = float(frequency[power.argmax()]), None
        with suppress(NotEnoughDataError):
            require(low * _SHORTEST_FIT <= FIT_TO_HZ, "no room above the peak")
            law = fit_power_law(frequency, power, low=low, high=FIT_TO_HZ)
        spectra[name] = Spectrum(float(begin), float(end), even, frequency, power, law)
    require(WHOLE in spectra, f"no {_LEAST_SAMPLES} samples that no gap parts")
    return spectra
