"""Spectrum, slips and avalanches: their power laws and where they end (Figs. 8 and 9)."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from beltrepro.base.errors import require
from beltrepro.stats import estimates, power_law, spectra
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.power_law import PowerLawFit, fit_log_log
from beltrepro.stats.spectra import FIT_BAND

MINIMUM_COUNT = 10
BINS_PER_DECADE, FINE_BINS = 5, 10
SCALED_COUNT = 100  # values in a bin of densities that are compared: they scatter by a tenth
SCALED_RESAMPLES = 200  # each bins all values anew
CUTOFF_QUANTILE = 0.99
# Of the logarithm of a cutoff. Slips of one periodic orbit do not scatter at all.
CUTOFF_RESOLUTION = 0.02
STARTS_TRIED = 12
LEAST_CYCLES = 10  # of the lowest frequency of a fit, in a stretch of a series
LEAST_STRETCHES, STRETCHES = 4, 20
SLOW_BAND = (0.0005, 0.003)  # slower than the whole chain sticks and slips
PRINTED_LENGTH = 1e6  # of the series behind Fig. 8, if it is as long as those behind Fig. 12


# --- slips and avalanches of a catalogue ----------------------------------------------------------


class Sample(NamedTuple):
    """Values, and the chain that each is of: those of one chain hang together."""

    values: np.ndarray
    chain: np.ndarray

    def by_chain(self) -> list[np.ndarray]:
        """Values of each chain."""
        order = np.argsort(self.chain, kind="stable")
        _, first = np.unique(self.chain[order], return_index=True)
        return np.split(self.values[order], first[1:])


def parts(catalogue) -> tuple[np.ndarray, np.ndarray, int]:
    """Slips, avalanches and N."""
    arrays = catalogue.arrays
    return arrays["slips"], arrays["avalanches"], int(catalogue.attributes["n_blocks"])


def slip_sizes(catalogue, frame: str = "laboratory") -> Sample:
    """Positive slip sizes of the last block."""
    slips, _, n_blocks = parts(catalogue)
    belt_velocity = catalogue.attributes["belt_velocity"]
    sizes = last_block_slip_sizes(slips, n_blocks, belt_velocity, frame)
    chain = last_block_slips(slips, n_blocks)["point"]
    return Sample(sizes[sizes > 0], chain[sizes > 0])


def avalanche_energies(catalogue) -> Sample:
    """Energies that the chain dissipates in avalanches with the last block (Fig. 9b)."""
    slips, avalanches, n_blocks = parts(catalogue)
    avalanches = avalanches[with_last_block(avalanches, slips, n_blocks)]
    return Sample(avalanches["dissipated"], avalanches["point"])


def all_energies(catalogue, *, least_blocks: int = 1) -> Sample:
    """Energies that the chain dissipates in avalanches of so many blocks or more."""
    _, avalanches, _ = parts(catalogue)
    avalanches = avalanches[avalanches["blocks"] >= least_blocks]
    return Sample(avalanches["dissipated"], avalanches["point"])


def last_block_energies(catalogue) -> Sample:
    """Energies that the last block alone dissipates in its slips."""
    slips, _, n_blocks = parts(catalogue)
    of_last = last_block_slips(slips, n_blocks)
    return Sample(of_last["dissipated"], of_last["point"])


def last_block_slips(slips: np.ndarray, n_blocks: int) -> np.ndarray:
    """The slips of a catalogue that belong to the last block."""
    return slips[slips["block"] == n_blocks]


def last_block_slip_sizes(
    slips: np.ndarray, n_blocks: int, belt_velocity: float, frame: str = "laboratory"
) -> np.ndarray:
    """Slip sizes of the last block: coordinate where it starts to slip minus where it stops."""
    of_last = last_block_slips(slips, n_blocks)
    sizes = of_last["start_position"] - of_last["stop_position"]
    if frame == "belt":
        sizes = sizes + belt_velocity * (of_last["stop_time"] - of_last["start_time"])
    return sizes


def with_last_block(avalanches: np.ndarray, slips: np.ndarray, n_blocks: int) -> np.ndarray:
    """Which avalanches of a catalogue take in a slip of the last block."""
    of_last = last_block_slips(slips, n_blocks)
    reached = np.zeros(avalanches.size, dtype=bool)
    for chain in np.unique(avalanches["point"]):
        starts = np.sort(of_last["start_time"][of_last["point"] == chain])
        of_chain = avalanches["point"] == chain
        before = np.searchsorted(starts, avalanches["start_time"][of_chain])
        after = np.searchsorted(starts, avalanches["stop_time"][of_chain], side="right")
        reached[of_chain] = after > before
    return reached


def most_at_once(avalanches: np.ndarray, slips: np.ndarray) -> np.ndarray:
    """Largest number of blocks that slip at one instant of each avalanche."""
    most = np.zeros(avalanches.size, dtype=int)
    for chain in np.unique(avalanches["point"]):
        slips_of_chain = slips[slips["point"] == chain]
        of_chain = np.flatnonzero(avalanches["point"] == chain)
        time = np.concatenate([slips_of_chain["stop_time"], slips_of_chain["start_time"]])
        change = np.repeat([-1, 1], slips_of_chain.size)
        order = np.argsort(time, kind="stable")  # a block that reverses stops first
        slipping = np.cumsum(change[order])
        first = np.searchsorted(time[order], avalanches["start_time"][of_chain])
        last = np.searchsorted(time[order], avalanches["stop_time"][of_chain])
        most[of_chain] = [slipping[begin:end].max() for begin, end in zip(first, last, strict=True)]
    return most


# --- the spectrum of Fig. 8 -----------------------------------------------------------------------


class SpectralLaw(NamedTuple):
    """Power law S = prefactor * nu**exponent of a series, and the stretches that tell it."""

    exponent: Estimate
    prefactor: Estimate
    count: int
    length: float


def spectral_law(
    series, *, window: str = "hann", band: tuple[float, float] = FIT_BAND
) -> SpectralLaw:
    """Of the mean spectrum of x_N in the stretches of a series, which are drawn anew."""
    time = series.arrays["time"]
    values = series.arrays["positions"][time >= series.attributes["transient"], -1]
    require(time.size > 1, f"{time.size} samples, a spectrum needs 16")
    interval = float(np.median(np.diff(time)))
    low, high = band
    shortest = LEAST_CYCLES / low
    count = min(STRETCHES, int(values.size * interval / shortest + 1e-9))
    require(
        count >= LEAST_STRETCHES,
        f"the series lasts {values.size * interval:.0f}: {LEAST_STRETCHES} stretches of "
        f"{shortest:.0f} are needed for nu >= {low:g}",
    )
    length = values.size // count
    stretches = values[: count * length].reshape(count, length)
    by_stretch = [spectra.power_spectrum(stretch, interval, window=window) for stretch in stretches]
    frequency = by_stretch[0][0]
    inside = (frequency >= low) & (frequency <= high)
    # Most of a spectrum lies above the range, and each resample would average it in vain.
    frequency, power = frequency[inside], np.array([spectrum[inside] for _, spectrum in by_stretch])

    def fit(drawn):
        # The logarithm of a single noisy spectrum would lie too low where bins are narrow.
        return spectra.fit_power_law(frequency, drawn.mean(axis=0), low=low, high=high)

    return SpectralLaw(
        estimates.bootstrap(lambda drawn: fit(drawn).exponent, [power]),
        estimates.exponential(
            estimates.bootstrap(lambda drawn: np.log(fit(drawn).prefactor), [power])
        ),
        count,
        length * interval,
    )


def amplitude_law(series, **how) -> SpectralLaw:
    """Of the amplitude 2|X|/n of n samples over a time T: the root of 2 S / T."""
    law = spectral_law(series, **how)
    return law._replace(
        exponent=law.exponent.scaled(0.5), prefactor=estimates.mapped(as_amplitude, law.prefactor)
    )


def as_amplitude(power: npt.ArrayLike) -> npt.ArrayLike:
    """Amplitude over the time PRINTED_LENGTH, of a power spectral density."""
    return np.sqrt(2 * np.asarray(power) / PRINTED_LENGTH)


def peaks_of_slips(series) -> np.ndarray:
    """Greatest |v_r| in each slip of the last block (S, P), in stretches of the series."""
    time = series.arrays["time"]
    relative = np.abs(series.arrays["velocities"][:, -1] - series.attributes["belt_velocity"])
    events = series.arrays["events"]
    events = events[events["block"] == series.attributes["n_blocks"]]
    slips, sticks = (events["time"][events["kind"] == kind] for kind in ("slip", "stick"))
    inside = np.searchsorted(time, [*zip(slips, sticks, strict=False)])
    peaks = [relative[first:last].max() for first, last in inside if last > first]
    count = len(peaks) // STRETCHES
    require(count >= 2, f"{len(peaks)} slips of the last block, not {2 * STRETCHES}")
    return np.array(peaks[: count * STRETCHES]).reshape(STRETCHES, count)


# --- densities and their exponents ----------------------------------------------------------------


def log_histogram(
    values: npt.ArrayLike,
    *,
    bins_per_decade: int,
    low: float | None = None,
    high: float | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Probability density of positive values in bins of equal width in log10."""
    values = np.asarray(values, dtype=float).ravel()
    values = values[values > 0]
    require(values.size, "no positive value")
    first = np.floor(np.log10(values.min() if low is None else low) * bins_per_decade + 1e-9)
    last = np.ceil(np.log10(values.max() if high is None else high) * bins_per_decade - 1e-9)
    edges = 10 ** (np.arange(first, max(last, first + 1) + 1) / bins_per_decade)
    # Rounding must not drop the extreme values.
    edges[0] *= 1 - 1e-12
    edges[-1] *= 1 + 1e-12
    count, _ = np.histogram(values, edges)
    return np.sqrt(edges[1:] * edges[:-1]), count / (values.size * np.diff(edges)), count


def most_probable(values: np.ndarray) -> float:
    """Middle of the bin of the largest density."""
    centre, density, _ = log_histogram(values, bins_per_decade=FINE_BINS)
    return float(centre[np.argmax(density)])


def density_error(
    values: npt.ArrayLike, run: npt.ArrayLike, centre: np.ndarray, *, bins_per_decade: int
) -> np.ndarray:
    """Standard error of a density from `log_histogram`, by leaving out one run after the other."""
    values, run = np.asarray(values, dtype=float), np.asarray(run)
    names, member = np.unique(run[values > 0], return_inverse=True)
    if names.size < 2:
        return np.full(len(centre), np.nan)
    first = np.log10(centre[0]) * bins_per_decade - 0.5
    place = np.floor(np.log10(values[values > 0]) * bins_per_decade - first + 1e-9).astype(int)
    count = np.zeros((names.size, len(centre)))
    np.add.at(count, (member, np.clip(place, 0, len(centre) - 1)), 1)
    ratio = 10 ** (0.5 / bins_per_decade)
    width = centre * (ratio - 1 / ratio)
    total = count.sum(axis=0) - count
    without = total / (total.sum(axis=1, keepdims=True) * width)
    return np.sqrt((names.size - 1) * without.var(axis=0))


def falling_range(
    centre: np.ndarray, density: np.ndarray, count: np.ndarray
) -> tuple[float, float]:
    """Range of the falling part of a density: the fit range used for Fig. 9, stated as a rule.

    From the bin of the largest density to the last bin of the unbroken run of bins that follow it
    with at least MINIMUM_COUNT values.
    """
    top = int(np.argmax(density))
    sparse = np.flatnonzero(count[top:] < MINIMUM_COUNT)
    end = top + sparse[0] - 1 if sparse.size else len(count) - 1
    require(end > top, f"no bin after the most probable one holds {MINIMUM_COUNT} values")
    return float(centre[top]), float(centre[end])


def fit_density(
    centre: np.ndarray, density: np.ndarray, count: np.ndarray, *, low: float, high: float
) -> PowerLawFit:
    """Power law through a histogram density, bins between low and high weighted by their counts."""
    return fit_log_log(centre, density, low=low * (1 - 1e-9), high=high * (1 + 1e-9), weight=count)


class DensityLaw(NamedTuple):
    """A power law through the bins of a density, and its exponent with an interval."""

    law: PowerLawFit
    exponent: Estimate


def density_law(
    sample: Sample, *, bins_per_decade: int = BINS_PER_DECADE, falling: bool = False
) -> DensityLaw:
    """Least squares through all bins, or the falling ones; chains are drawn anew."""
    centre, *_ = log_histogram(sample.values, bins_per_decade=bins_per_decade)
    half_bin = 10 ** (0.5 / bins_per_decade)
    edges = np.r_[centre / half_bin, centre[-1] * half_bin]
    counts = np.array([np.histogram(values, edges)[0] for values in sample.by_chain()])

    def fit(counts):
        count = counts.sum(axis=0)
        histogram = centre, count / (count.sum() * np.diff(edges)), count
        low, high = falling_range(*histogram) if falling else (centre[0], centre[-1])
        return fit_density(*histogram, low=low, high=high)

    return DensityLaw(fit(counts), estimates.bootstrap(lambda drawn: fit(drawn).exponent, [counts]))


# --- self-organised criticality -------------------------------------------------------------------


class ScaleFree(NamedTuple):
    """How a power law describes a sample from `low` to `high`."""

    p: float  # of the test that refuses the power law
    exponent: Estimate  # by maximum likelihood
    low: float
    high: float
    chains: int


def scale_free_fit(sample: Sample, *, search: bool = False) -> ScaleFree:
    """A power law from the most probable value on, or from where it fits best."""
    above = sample.values >= most_probable(sample.values)
    values, chain = (column[above] for column in sample)
    shares = np.linspace(0, 0.9, STARTS_TRIED) if search else [0.0]
    worth = power_law.independent_values(np.log(values), chain)
    fit = power_law.goodness_of_fit(values, np.quantile(values, shares), independent=worth)
    low, high = fit.law.low, fit.law.high
    logs = np.where(values >= low, np.log(values), np.nan)
    sums = [(np.isfinite(part).sum(), np.nansum(part)) for part in Sample(logs, chain).by_chain()]

    def exponent(drawn):
        count, total = drawn.sum(axis=0)
        return power_law.fit_law(total / count, low, high).exponent

    return ScaleFree(fit.p, estimates.bootstrap(exponent, [np.array(sums)]), low, high, len(sums))


class Growth(NamedTuple):
    """Cutoffs of chains of several lengths, and the power of the length that they grow with."""

    n_blocks: np.ndarray
    cutoffs: list[Estimate]
    power: Estimate

    def line(self, n_blocks: np.ndarray) -> np.ndarray:
        """The power law through the cutoffs, with the weights that its power has."""
        logs = np.log([cutoff.numbers for cutoff in self.cutoffs])
        weights = (logs[:, 2] - logs[:, 1]) ** -2
        place, height = (
            np.average(values, weights=weights) for values in (np.log(self.n_blocks), logs[:, 0])
        )
        return np.exp(height + self.power.value * (np.log(n_blocks) - place))


def growth(samples: dict[int, Sample]) -> Growth:
    """Growth with N of the value that 1 % of a sample exceed; chains are drawn anew."""

    def log_cutoff(drawn):
        return np.log(np.quantile(np.concatenate(list(drawn)), CUTOFF_QUANTILE))

    logs = [
        estimates.bootstrap(log_cutoff, [_chains(sample)], grid_spacing=CUTOFF_RESOLUTION)
        for sample in samples.values()
    ]
    require(all(np.isfinite(log.high) for log in logs), "one chain tells no interval of a cutoff")
    sizes = np.array(list(samples))
    return Growth(
        sizes, list(map(estimates.exponential, logs)), estimates.slope(np.log(sizes), logs)
    )


def collapse(samples: dict[int, Sample]) -> tuple[Estimate, float]:
    """Factor by which scaled densities of several N differ from one curve, and the power of N.

    If nothing but the size of the system ends a power law, N**a P(x) are one curve of x / N**D. D
    is that of the cutoffs (second over first moment), a that of least squares.
    """

    def apart(*drawn):
        return _apart(
            dict(zip(samples, (np.concatenate(list(chains)) for chains in drawn), strict=True))
        )

    chains = [_chains(sample) for sample in samples.values()]
    factor = estimates.bootstrap(
        lambda *drawn: apart(*drawn)[0], chains, resamples=SCALED_RESAMPLES
    )
    return factor, apart(*chains)[1]


def unscaled(samples: dict[int, Sample]) -> float:
    """Factor by which the densities differ from one curve if their sizes are not scaled with N."""
    values = {n: np.concatenate(list(_chains(sample))) for n, sample in samples.items()}
    return _apart(values, power=0.0)[0]


def _apart(values_by_n: dict[int, np.ndarray], power: float | None = None) -> tuple[float, float]:
    logs = np.log(list(values_by_n))
    if power is None:
        cutoffs = [np.mean(values**2) / np.mean(values) for values in values_by_n.values()]
        power = float(np.polyfit(logs, np.log(cutoffs), 1)[0])
    density = pd.DataFrame(
        {n: _scaled_density(values, n**power) for n, values in values_by_n.items()}
    )
    density = density[density.notna().sum(axis=1) >= 2]
    require(len(density) >= 2, "the densities of several N do not overlap")
    length = density.notna() * logs
    length = length.where(density.notna())
    about = [table.sub(table.mean(axis=1), axis=0) for table in (density, length)]
    slope = (about[0] * about[1]).sum().sum() / (about[1] ** 2).sum().sum()
    flat = density - slope * length
    spread = flat.sub(flat.mean(axis=1), axis=0)
    return float(np.exp(np.sqrt((spread**2).stack().mean()))), power


def _scaled_density(values: np.ndarray, scale: float) -> pd.Series:
    """Logarithm of the share of values in bins of ln(x / scale), from the most probable on."""
    place = np.floor(np.log10(values / scale) * BINS_PER_DECADE)
    first = np.ceil(np.log10(most_probable(values) / scale) * BINS_PER_DECADE)
    bins, count = np.unique(place[place >= first], return_counts=True)
    filled = count >= SCALED_COUNT
    return pd.Series(np.log(count[filled] / values.size), index=bins[filled])


def _chains(sample: Sample) -> np.ndarray:
    """Values of each chain as one object, to be drawn anew."""
    return np.fromiter(sample.by_chain(), dtype=object)


# --- blocks that slip together --------------------------------------------------------------------


def share_of_chains(chosen: np.ndarray, chain: np.ndarray) -> Estimate:
    """Share that is chosen: mean over the chains."""
    return estimates.mean([part.mean() for part in Sample(chosen, chain).by_chain()])


def spread_of_energies(energies: Sample) -> Estimate:
    """90 % over 10 % quantile: mean over the chains."""
    ratios = [np.quantile(one, 0.9) / np.quantile(one, 0.1) for one in energies.by_chain()]
    return estimates.mean(ratios)
