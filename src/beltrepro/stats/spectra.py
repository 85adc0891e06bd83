"""Power spectra of sampled series and the power laws in them (Figs. 8 and 16)."""

import numpy as np
import numpy.typing as npt
import scipy

from beltrepro.base.errors import require
from beltrepro.stats.estimates import Estimate, from_error
from beltrepro.stats.power_law import PowerLawFit, fit_log_log

# The paper prints no fit range for Fig. 8. Below the lower bound lie times longer than the
# stick-slip cycle of the whole chain (a plateau), above the upper one single slips (a steep fall).
FIT_BAND = (0.003, 0.3)


def power_spectrum(
    values: npt.ArrayLike,
    sample_interval: float,
    *,
    segment: int | None = None,
    window: str = "hann",
) -> tuple[np.ndarray, np.ndarray]:
    """One-sided power spectral density of a sampled series, mean removed."""
    values = np.asarray(values, dtype=float)
    require(values.size >= 16, f"{values.size} samples, a spectrum needs 16")
    length = values.size if segment is None else min(int(segment), values.size)
    frequency, power = scipy.signal.welch(
        values, fs=1 / sample_interval, window=window, nperseg=length, detrend="constant"
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
    frequency, power = np.asarray(frequency, dtype=float), np.asarray(power, dtype=float)
    used = (frequency >= low) & (frequency <= high)
    require(used.any(), f"no frequency between {low:.3g} and {high:.3g}")
    place = np.floor(np.log10(frequency[used]) * 10).astype(int)
    _, place, count = np.unique(place, return_inverse=True, return_counts=True)
    centre = np.exp(np.bincount(place, np.log(frequency[used])) / count)
    mean = np.bincount(place, power[used]) / count
    return fit_log_log(centre, mean, low=low, high=high)


def exponent_of(law: PowerLawFit, frequency: npt.ArrayLike, *, resamples: int = 200) -> Estimate:
    """Exponent of a law that was fitted to the spectrum of one series without segments.

    Its error is by how much the exponents scatter of spectra of Gaussian noise with this law, at
    these frequencies. The scatter of the bins about the line says too little: few frequencies lie
    in the lowest bins, which weigh most.
    """
    frequency = np.asarray(frequency, dtype=float)
    frequency = frequency[: np.searchsorted(frequency, law.high) + 2]
    amplitude = np.concatenate([[0.0], np.sqrt(law(frequency))])  # the mean was removed
    rng = np.random.default_rng(0)
    exponents = []
    for _ in range(resamples):
        waves = amplitude * (rng.standard_normal((amplitude.size, 2)) @ [1, 1j])
        windowed = waves[1:-1] - (waves[:-2] + waves[2:]) / 2  # Hann's window
        power = np.abs(windowed) ** 2
        exponents.append(fit_power_law(frequency[:-1], power, low=law.low, high=law.high).exponent)
    return from_error(law.exponent, float(np.std(exponents)), None)
