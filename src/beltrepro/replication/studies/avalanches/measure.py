"""Sizes and energies of slips and avalanches, their power laws and where they end (Fig. 9)."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from beltrepro.base.errors import require
from beltrepro.stats import estimates, scale_free, spectra
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.fits import PowerLawFit, fit_log_log

MINIMUM_COUNT = 10
BINS_PER_DECADE = 10
CUTOFF_QUANTILE = 0.99
# Of the logarithm of a cutoff. Slips of one periodic orbit do not scatter at all.
CUTOFF_RESOLUTION = 0.02
STARTS_TRIED = 12
LEAST_CYCLES = 10  # of the lowest frequency of a fit, in a stretch of a series
LEAST_STRETCHES, STRETCHES = 4, 20


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


def avalanche_energies(catalogue, name: str = "dissipated") -> Sample:
    """Energies that the chain dissipates in avalanches with the last block (Fig. 9b)."""
    slips, avalanches, n_blocks = parts(catalogue)
    avalanches = avalanches[with_last_block(avalanches, slips, n_blocks)]
    return Sample(avalanches[name], avalanches["point"])


def all_energies(catalogue) -> Sample:
    """Energies that the chain dissipates in avalanches, with the last block or without it."""
    _, avalanches, _ = parts(catalogue)
    return Sample(avalanches["dissipated"], avalanches["point"])


def last_block_energies(catalogue) -> Sample:
    """Energies that the last block alone dissipates in its slips."""
    slips, _, n_blocks = parts(catalogue)
    of_last = last_block_slips(slips, n_blocks)
    return Sample(of_last["dissipated"], of_last["point"])


def energies_until_stop(catalogue) -> Sample:
    """Energies that the chain dissipates while the last block slips."""
    slips, _, n_blocks = parts(catalogue)
    chain = last_block_slips(slips, n_blocks)["point"]
    return Sample(dissipation_while_last_block_slips(slips, n_blocks), chain)


def spring_energy_drops(catalogue) -> Sample:
    """Energies that the springs lose in avalanches with the last block."""
    return avalanche_energies(catalogue, "spring_energy_drop")


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


def dissipation_while_last_block_slips(slips: np.ndarray, n_blocks: int) -> np.ndarray:
    """Friction loss of the whole chain during each slip of the last block.

    In this reading of the paper an avalanche ends when the last block stops. A slip of another
    block that overlaps counts with the share of its duration that overlaps.
    """
    energies = []
    for chain in np.unique(slips["point"]):
        of_chain = slips[slips["point"] == chain]
        of_chain = of_chain[np.argsort(of_chain["start_time"])]
        starts, stops = of_chain["start_time"], of_chain["stop_time"]
        longest = np.max(stops - starts)
        for start, stop in last_block_slips(of_chain, n_blocks)[["start_time", "stop_time"]]:
            near = slice(np.searchsorted(starts, start - longest), np.searchsorted(starts, stop))
            overlap = np.minimum(stops[near], stop) - np.maximum(starts[near], start)
            duration = np.maximum(stops[near] - starts[near], np.finfo(float).tiny)
            share = np.clip(overlap / duration, 0.0, 1.0)
            energies.append(np.sum(share * of_chain["dissipated"][near]))
    return np.array(energies)


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
    series, *, window: str = "hann", band: tuple[float, float] = spectra.FIT_BAND
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
    frequency, power = by_stretch[0][0], np.array([spectrum for _, spectrum in by_stretch])

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
    centre: np.ndarray,
    density: np.ndarray,
    count: np.ndarray,
    *,
    minimum_count: int = MINIMUM_COUNT,
) -> tuple[float, float]:
    """Range of the falling part of a density: the fit range used for Fig. 9, stated as a rule.

    From the bin of the largest density to the last bin of the unbroken run of bins that follow it
    with at least `minimum_count` values.
    """
    top = int(np.argmax(density))
    sparse = np.flatnonzero(count[top:] < minimum_count)
    end = top + sparse[0] - 1 if sparse.size else len(count) - 1
    require(end > top, f"no bin after the most probable one holds {minimum_count} values")
    return float(centre[top]), float(centre[end])


def fit_density(
    centre: np.ndarray, density: np.ndarray, count: np.ndarray, *, low: float, high: float
) -> PowerLawFit:
    """Power law through a histogram density, bins between low and high weighted by their counts."""
    return fit_log_log(centre, density, low=low * (1 - 1e-9), high=high * (1 + 1e-9), weight=count)


class FallingDensity(NamedTuple):
    """The power law in the falling part of a density, and its exponent with an interval."""

    law: PowerLawFit
    exponent: Estimate


def falling_density(
    sample: Sample, *, bins_per_decade: int = BINS_PER_DECADE, whole_range: bool = False
) -> FallingDensity:
    """By least squares through a histogram; chains are drawn anew for the interval."""
    centre, *_ = log_histogram(sample.values, bins_per_decade=bins_per_decade)
    half_bin = 10 ** (0.5 / bins_per_decade)
    edges = np.r_[centre / half_bin, centre[-1] * half_bin]
    counts = np.array([np.histogram(values, edges)[0] for values in sample.by_chain()])

    def fit(counts):
        count = counts.sum(axis=0)
        histogram = centre, count / (count.sum() * np.diff(edges)), count
        low, high = (centre[0], centre[-1]) if whole_range else falling_range(*histogram)
        return fit_density(*histogram, low=low, high=high)

    exponent = estimates.bootstrap(lambda drawn: fit(drawn).exponent, [counts])
    return FallingDensity(fit(counts), exponent)


def likely_exponent(sample: Sample) -> tuple[Estimate, float, float]:
    """Exponent by maximum likelihood over the falling part of the density, and its ends."""
    low, high = falling_range(*log_histogram(sample.values, bins_per_decade=BINS_PER_DECADE))
    sums = _sums(sample, low, high)
    exponent = estimates.bootstrap(lambda drawn: _fit(drawn, low, high).exponent, [sums])
    return exponent, low, high


# --- self-organised criticality -------------------------------------------------------------------


class ScaleFree(NamedTuple):
    """How a power law describes a sample from `low` to `high`, beside two rivals."""

    p: float  # of the test that refuses the power law
    distance: float  # of Kolmogorov and Smirnov
    exponent: float  # by maximum likelihood
    advantage: Estimate  # log-likelihood over that of an exponential, of the values of a chain
    cutoff: Estimate  # largest value over the place of an exponential cutoff
    low: float
    high: float
    count: int  # values in between
    chains: int


def scale_free_fit(sample: Sample, *, search: bool = False) -> ScaleFree:
    """A power law from the most probable value on, or from where it fits best, and two rivals."""
    centre, density, _ = log_histogram(sample.values, bins_per_decade=BINS_PER_DECADE)
    low = float(centre[np.argmax(density)])
    sample = Sample(*(column[sample.values >= low] for column in sample))
    shares = np.linspace(0, 0.9, STARTS_TRIED) if search else [0.0]
    worth = scale_free.independent_values(np.log(sample.values), sample.chain)
    fit = scale_free.goodness_of_fit(
        sample.values, np.quantile(sample.values, shares), independent=worth
    )
    low, high = fit.law.low, fit.law.high
    sums = _sums(sample, low, high)
    power, exponential = _fit(sums, low, high), _fit(sums, low, high, power=False, decay=True)
    gain = [
        np.sum(power.log_density(tail) - exponential.log_density(tail))
        for tail in (values[values >= low] for values in sample.by_chain())
    ]
    return ScaleFree(
        p=fit.p,
        distance=fit.distance,
        exponent=power.exponent,
        advantage=estimates.mean(np.array(gain) / sums[:, 0].mean()),
        cutoff=estimates.bootstrap(
            lambda drawn: high * _fit(drawn, low, high, decay=True).decay, [sums]
        ),
        low=low,
        high=high,
        count=int(sums[:, 0].sum()),
        chains=len(sums),
    )


def _sums(sample: Sample, low: float, high: float) -> np.ndarray:
    """Number of values in a range, and sums of ln x and x over them, for each chain (C, 3)."""
    scale_free.inside(sample.values, low, high)
    used = (sample.values >= low) & (sample.values <= high)
    values = np.where(used, sample.values, 1.0)
    terms = used * np.stack([np.ones(values.size), np.log(values), values])
    return np.array([part.sum(axis=0) for part in Sample(terms.T, sample.chain).by_chain()])


def _fit(sums: np.ndarray, low: float, high: float, **kind: bool) -> scale_free.Law:
    count, *totals = sums.sum(axis=0)
    return scale_free.fit_law(*(np.array(totals) / count), low, high, **kind)


class Growth(NamedTuple):
    """Cutoffs of chains of several lengths, and the power of the length that they grow with."""

    n_blocks: np.ndarray
    cutoffs: list[Estimate]
    power: Estimate

    def line(self, n_blocks: np.ndarray) -> np.ndarray:
        """The power law through the cutoffs, with the weights that its power has."""
        logs = np.log([(cutoff.value, cutoff.low, cutoff.high) for cutoff in self.cutoffs])
        weights = (logs[:, 2] - logs[:, 1]) ** -2
        place, height = (
            np.average(values, weights=weights) for values in (np.log(self.n_blocks), logs[:, 0])
        )
        return np.exp(height + self.power.value * (np.log(n_blocks) - place))


def growth(
    samples: dict[int, Sample], log_cutoff: Callable[[np.ndarray], float] | None = None
) -> Growth:
    """Growth of the cutoff of samples by number of blocks; the 99 % quantile if none is named."""
    sizes = np.array(list(samples))
    logs = [_resampled(log_cutoff or log_quantile, sample) for sample in samples.values()]
    require(all(np.isfinite(log.high) for log in logs), "one chain tells no interval of a cutoff")
    cutoffs = [estimates.exponential(log) for log in logs]
    return Growth(sizes, cutoffs, estimates.slope(np.log(sizes), logs))


def _resampled(log_cutoff: Callable[[np.ndarray], float], sample: Sample) -> Estimate:
    """Logarithm of a cutoff, with an interval from chains drawn anew."""
    chains = np.fromiter(sample.by_chain(), dtype=object)
    return estimates.bootstrap(
        lambda drawn: log_cutoff(np.concatenate(list(drawn))),
        [chains],
        grid_spacing=CUTOFF_RESOLUTION,
    )


def log_quantile(values: np.ndarray) -> float:
    """Logarithm of the value that 1 % exceed."""
    return np.log(np.quantile(values, CUTOFF_QUANTILE))


def log_moments(values: np.ndarray) -> float:
    """Logarithm of the ratio of the second moment to the first.

    Under a power law that falls less steeply than with exponent -2 and is cut off, the ratio is
    proportional to the cutoff, as the small values hardly count.
    """
    return np.log(np.mean(values**2) / np.mean(values))


# --- blocks that slip together --------------------------------------------------------------------


def share_of_weight(chosen: np.ndarray, weight: np.ndarray, chain: np.ndarray) -> Estimate:
    """Share of a weight that the chosen have: mean over the chains."""
    count, total = (
        np.array([values.sum() for values in Sample(column, chain).by_chain()])
        for column in (chosen * weight, weight)
    )
    return estimates.mean(count / total)


def spread_of_energies(energies: Sample) -> Estimate:
    """90 % over 10 % quantile: mean over the chains."""
    ratios = [np.quantile(one, 0.9) / np.quantile(one, 0.1) for one in energies.by_chain()]
    return estimates.mean(ratios)
