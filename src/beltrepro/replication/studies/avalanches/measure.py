"""Spectrum, slips and avalanches: their power laws and where they end (Figs. 8 and 9)."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from beltrepro.base.errors import require
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.stats import estimates, power_law, spectra
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.power_law import PowerLawFit
from beltrepro.stats.spectra import FIT_BAND

BINS_PER_DECADE, FINE_BINS = 5, 10
SCALED_COUNT = 100  # values in a bin of densities that are compared: they scatter by a tenth
SCALED_RESAMPLES = 200  # each bins all values anew
CUTOFF_QUANTILE = 0.99
# Of the logarithm of a cutoff. Slips of one periodic orbit do not scatter at all.
CUTOFF_RESOLUTION = 0.02
STARTS_TRIED = 12
LEAST_CYCLES = 10  # of the lowest frequency of a fit, in a stretch of a series
LEAST_STRETCHES, STRETCHES = 4, 20
PRINTED_LENGTH = 1e6  # of the series behind Fig. 8, if it is as long as those behind Fig. 12


# --- slips and avalanches of a catalogue ----------------------------------------------------------


class Sample(NamedTuple):
    """Values, and the chain that each is of: those of one chain hang together."""

    values: np.ndarray
    chain: np.ndarray

    def by_chain(self) -> np.ndarray:
        """Values of each chain as one object, so that chains can be drawn anew."""
        order = np.argsort(self.chain, kind="stable")
        _, first = np.unique(self.chain[order], return_index=True)
        return np.fromiter(np.split(self.values[order], first[1:]), dtype=object)


def last_block_slips(catalogue) -> np.ndarray:
    slips = catalogue.arrays["slips"]
    return slips[slips["block"] == catalogue.attributes["n_blocks"]]


def slip_sizes(catalogue, frame: str = "laboratory") -> Sample:
    """Positive slip sizes of the last block: coordinate where it starts minus where it stops."""
    slips = last_block_slips(catalogue)
    sizes = slips["start_position"] - slips["stop_position"]
    if frame == "belt":
        lasting = slips["stop_time"] - slips["start_time"]
        sizes = sizes + catalogue.attributes["belt_velocity"] * lasting
    return Sample(sizes[sizes > 0], slips["point"][sizes > 0])


def avalanche_energies(catalogue) -> Sample:
    """Energies that the chain dissipates in avalanches with the last block (Fig. 9b)."""
    avalanches, slips = catalogue.arrays["avalanches"], last_block_slips(catalogue)
    reached = np.zeros(avalanches.size, dtype=bool)
    for chain in np.unique(avalanches["point"]):
        starts = np.sort(slips["start_time"][slips["point"] == chain])
        of_chain = avalanches["point"] == chain
        before = np.searchsorted(starts, avalanches["start_time"][of_chain])
        after = np.searchsorted(starts, avalanches["stop_time"][of_chain], side="right")
        reached[of_chain] = after > before
    return Sample(avalanches["dissipated"][reached], avalanches["point"][reached])


def all_energies(catalogue, *, least_blocks: int = 1) -> Sample:
    """Energies that the chain dissipates in avalanches of so many blocks or more."""
    avalanches = catalogue.arrays["avalanches"]
    avalanches = avalanches[avalanches["blocks"] >= least_blocks]
    return Sample(avalanches["dissipated"], avalanches["point"])


def last_block_energies(catalogue) -> Sample:
    slips = last_block_slips(catalogue)
    return Sample(slips["dissipated"], slips["point"])


# --- the spectrum of Fig. 8 -----------------------------------------------------------------------


def spectral_law(
    series, *, band: tuple[float, float] = FIT_BAND, amplitude: bool = False
) -> Measurement:
    """Power law of the mean spectrum of x_N in the stretches of a series, which are drawn anew.

    amplitude : whether of the amplitude 2|X|/n of n samples over a time T: the root of 2 S / T.
    """
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
    by_stretch = [spectra.power_spectrum(stretch, interval) for stretch in stretches]
    frequency = by_stretch[0][0]
    inside = (frequency >= low) & (frequency <= high)
    # Most of a spectrum lies above the range, and each resample would average it in vain.
    frequency, power = frequency[inside], np.array([spectrum[inside] for _, spectrum in by_stretch])

    def fit(drawn):
        # The logarithm of a single noisy spectrum would lie too low where bins are narrow.
        return spectra.fit_power_law(frequency, drawn.mean(axis=0), low=low, high=high)

    exponent = estimates.bootstrap(lambda drawn: fit(drawn).exponent, [power])
    level = estimates.bootstrap(lambda drawn: np.log(fit(drawn).prefactor), [power])
    prefactor = estimates.mapped(np.exp, level)
    if amplitude:
        exponent, prefactor = exponent.scaled(0.5), estimates.mapped(as_amplitude, prefactor)
    return Measurement(
        {"exponent": exponent, "prefactor": prefactor},
        note=f"{count} stretches of {length * interval:.0f}",
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


class Histogram(NamedTuple):
    """Positive values of chains in bins of equal width in log10."""

    centre: np.ndarray
    width: np.ndarray
    counts: np.ndarray  # (C, B), of each chain

    @classmethod
    def of(cls, sample: Sample, bins_per_decade: int = BINS_PER_DECADE) -> "Histogram":
        """Its edges are at whole parts of a decade, whatever the values."""
        positive = sample.values[sample.values > 0]
        require(positive.size, "no positive value")
        first = np.floor(np.log10(positive.min()) * bins_per_decade + 1e-9)
        last = np.ceil(np.log10(positive.max()) * bins_per_decade - 1e-9)
        edges = 10 ** (np.arange(first, max(last, first + 1) + 1) / bins_per_decade)
        edges[[0, -1]] *= 1 - 1e-12, 1 + 1e-12  # rounding must not drop the extreme values
        centre, half = np.sqrt(edges[1:] * edges[:-1]), 10 ** (0.5 / bins_per_decade)
        counts = [np.histogram(values, edges)[0] for values in sample.by_chain()]
        return cls(centre, centre * (half - 1 / half), np.array(counts))

    @property
    def count(self) -> np.ndarray:
        return self.counts.sum(axis=0)

    @property
    def density(self) -> np.ndarray:
        return self.count / (self.count.sum() * self.width)

    @property
    def error(self) -> np.ndarray:
        """Standard error of the density, by leaving out one chain after the other."""
        chains = len(self.counts)
        if chains < 2:
            return np.full(self.centre.size, np.nan)
        total = self.count - self.counts
        without = total / (total.sum(axis=1, keepdims=True) * self.width)
        return np.sqrt((chains - 1) * without.var(axis=0))

    def law(self) -> PowerLawFit:
        """Power law through all bins, weighted by their counts."""
        low, high = self.centre[0] * (1 - 1e-9), self.centre[-1] * (1 + 1e-9)
        return power_law.fit_log_log(
            self.centre, self.density, low=low, high=high, weight=self.count
        )


def density_law(
    sample: Sample, bins_per_decade: int = BINS_PER_DECADE
) -> tuple[PowerLawFit, Estimate]:
    """A power law through the bins of a density, and its exponent; chains are drawn anew."""
    histogram = Histogram.of(sample, bins_per_decade)
    exponent = estimates.bootstrap(
        lambda counts: histogram._replace(counts=counts).law().exponent, [histogram.counts]
    )
    return histogram.law(), exponent


def local_exponents(
    histogram: Histogram, neighbours: int, least: int
) -> tuple[np.ndarray, np.ndarray]:
    """Slope of log density over log size in each run of neighbouring bins, and its middle.

    NaN where one of the bins has fewer than `least` values.
    """
    filled = np.where(histogram.count >= least, histogram.density, np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(np.log(filled), neighbours)
    step = np.log(histogram.centre[1] / histogram.centre[0])
    weight = np.arange(neighbours) - (neighbours - 1) / 2
    middle = histogram.centre[neighbours // 2 :][: len(windows)]
    return middle, windows @ weight / (weight @ weight) / step


def most_probable(values: np.ndarray) -> float:
    """Middle of the bin of the largest density."""
    histogram = Histogram.of(Sample(values, np.zeros(values.size)), FINE_BINS)
    return float(histogram.centre[np.argmax(histogram.density)])


# --- self-organised criticality -------------------------------------------------------------------


def scale_free_fit(sample: Sample, *, search: bool = False) -> Measurement:
    """A power law from the most probable value on, or from where it fits best."""
    above = sample.values >= most_probable(sample.values)
    values, chain = (column[above] for column in sample)
    shares = np.linspace(0, 0.9, STARTS_TRIED) if search else [0.0]
    worth = power_law.independent_values(np.log(values), chain)
    fit = power_law.goodness_of_fit(values, np.quantile(values, shares), worth)
    low, high = fit.low, fit.high
    logs = np.where(values >= low, np.log(values), np.nan)
    sums = [(np.isfinite(part).sum(), np.nansum(part)) for part in Sample(logs, chain).by_chain()]

    def exponent(drawn):
        count, total = drawn.sum(axis=0)
        return power_law.fit_exponent(total / count, low, high)

    return Measurement(
        {"p of the power law": Estimate(fit.p, fit.p, fit.p, len(sums))},
        {
            "exponent": estimates.bootstrap(exponent, [np.array(sums)]),
            "decades": estimates.sure(np.log10(high / low)),
        },
        note=f"values from {low:.3g} to {high:.3g}",
    )


class Growth(NamedTuple):
    """Cutoffs of chains of several lengths, and the power of the length that they grow with."""

    n_blocks: np.ndarray
    cutoffs: list[Estimate]
    power: Estimate

    def line(self) -> np.ndarray:
        """The power law through the cutoffs, with the weights that its power has."""
        logs = np.log([cutoff.numbers for cutoff in self.cutoffs])
        weights = (logs[:, 2] - logs[:, 1]) ** -2
        places = np.log(self.n_blocks)
        place, height = (np.average(of, weights=weights) for of in (places, logs[:, 0]))
        return np.exp(height + self.power.value * (places - place))


def growth(samples: dict[int, Sample]) -> Growth:
    """Growth with N of the value that 1 % of a sample exceed; chains are drawn anew."""

    def log_cutoff(drawn):
        return np.log(np.quantile(np.concatenate(list(drawn)), CUTOFF_QUANTILE))

    require(all(one.values.size for one in samples.values()), "a chain without an avalanche")
    logs = [
        estimates.bootstrap(log_cutoff, [sample.by_chain()], grid_spacing=CUTOFF_RESOLUTION)
        for sample in samples.values()
    ]
    require(all(np.isfinite(log.high) for log in logs), "one chain tells no interval of a cutoff")
    sizes = np.array(list(samples))
    power = estimates.slope(np.log(sizes), logs)
    return Growth(sizes, [estimates.mapped(np.exp, log) for log in logs], power)


def collapse(samples: dict[int, Sample]) -> Measurement:
    """Factor by which scaled densities of several N differ from one curve, and the power of N.

    If nothing but the size of the system ends a power law, N**a P(x) are one curve of x / N**D. D
    is that of the cutoffs (second over first moment), a that of least squares.
    """

    def apart(*drawn, power=None):
        values = [np.concatenate(list(chains)) for chains in drawn]
        return _apart(dict(zip(samples, values, strict=True)), power)

    chains = [sample.by_chain() for sample in samples.values()]
    factor = estimates.bootstrap(
        lambda *drawn: apart(*drawn)[0], chains, resamples=SCALED_RESAMPLES
    )
    also = {"power of N": apart(*chains)[1]}
    also["distance without scaling"] = apart(*chains, power=0.0)[0]
    return Measurement({"distance from one curve": factor}, estimates.all_sure(also))


def _apart(values_by_n: dict[int, np.ndarray], power: float | None) -> tuple[float, float]:
    logs = np.log(list(values_by_n))
    if power is None:
        cutoffs = [np.mean(values**2) / np.mean(values) for values in values_by_n.values()]
        power = float(np.polyfit(logs, np.log(cutoffs), 1)[0])
    density = pd.DataFrame(
        {n: _scaled_density(values, n**power) for n, values in values_by_n.items()}
    ).dropna(thresh=2)
    require(len(density) >= 2, "the densities of several N do not overlap")
    length = (0 * density).add(logs)
    density, length = (table.sub(table.mean(axis=1), axis=0) for table in (density, length))
    slope = (density * length).sum().sum() / (length**2).sum().sum()
    spread = (density - slope * length) ** 2
    return float(np.exp(np.sqrt(spread.stack().mean()))), power


def _scaled_density(values: np.ndarray, scale: float) -> pd.Series:
    """Logarithm of the share of values in bins of ln(x / scale), from the most probable on."""
    place = np.floor(np.log10(values / scale) * BINS_PER_DECADE)
    first = np.ceil(np.log10(most_probable(values) / scale) * BINS_PER_DECADE)
    bins, count = np.unique(place[place >= first], return_counts=True)
    filled = count >= SCALED_COUNT
    return pd.Series(np.log(count[filled] / values.size), index=bins[filled])


# --- blocks that slip together --------------------------------------------------------------------


def together(catalogue) -> Measurement:
    """In how many avalanches blocks slip at one instant, and how far energies spread."""
    avalanches = catalogue.arrays["avalanches"]
    at_once = most_at_once(avalanches, catalogue.arrays["slips"])

    def share(chosen):
        return estimates.mean([of.mean() for of in Sample(chosen, avalanches["point"]).by_chain()])

    energies = all_energies(catalogue).by_chain()
    spreads = [np.quantile(of, 0.9) / np.quantile(of, 0.1) for of in energies]
    return Measurement(
        {
            "avalanches of two blocks or more": share(at_once >= 2),
            "energies: 90 % over 10 % quantile": estimates.mean(spreads),
        },
        {"avalanches of all blocks": share(at_once == catalogue.attributes["n_blocks"])},
        note=f"{avalanches.size} avalanches; blocks count that slip at one instant",
    )


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
