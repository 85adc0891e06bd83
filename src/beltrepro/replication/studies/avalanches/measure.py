"""Spectrum, slips and avalanches: their power laws and where they end (Figs. 8 and 9)."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from beltrepro.base.errors import require
from beltrepro.model import ChainParameters
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.simulation.catalogues import Catalogue
from beltrepro.simulation.observables import avalanche_energies, last_block_slips, spectrum
from beltrepro.stats import estimates
from beltrepro.stats.densities import ChainValues, Density, by_chain, most_probable, power_law
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.spectra import FIT_BAND

RECORDED = ("slips", "avalanches", "section")
BINS_PER_DECADE = 5
SCALED_COUNT = 100  # values in a bin of densities that are compared: they scatter by a tenth
SCALED_RESAMPLES = 200  # each bins all values anew
CUTOFF_QUANTILE = 0.99
# Of the logarithm of a cutoff. Slips of one periodic orbit do not scatter at all.
CUTOFF_RESOLUTION = 0.02
STRETCHES = 20  # of a series
PRINTED_LENGTH = 1e6  # of the series behind Fig. 8, if it is as long as those behind Fig. 12


# --- slips and avalanches of a catalogue ----------------------------------------------------------


def catalogue_of(dataset) -> Catalogue:
    """The catalogue that a dataset holds, of one chain that was followed several times."""
    about = dataset.attributes
    chain = ChainParameters(int(about["n_blocks"]), float(about["belt_velocity"]))
    arrays = {name: dataset.arrays[name] for name in RECORDED if name in dataset.arrays}
    last = max(rows["point"].max(initial=0) for rows in arrays.values())
    return Catalogue(arrays, [chain] * (int(last) + 1))


def all_energies(catalogue: Catalogue, *, least_blocks: int = 1) -> ChainValues:
    """Energies that the chain dissipates in avalanches of so many blocks or more."""
    return avalanche_energies(catalogue, last_block=False, least_blocks=least_blocks)


def last_block_energies(catalogue: Catalogue) -> ChainValues:
    slips = last_block_slips(catalogue)
    return ChainValues(slips["dissipated"], slips["point"])


# --- the spectrum of Fig. 8 -----------------------------------------------------------------------


def spectral_law(
    series, *, band: tuple[float, float] = FIT_BAND, amplitude: bool = False
) -> Measurement:
    """Power law of the mean spectrum of x_N in the stretches of a series, which are drawn anew.

    amplitude : whether of the amplitude 2|X|/n of n samples over a time T: the root of 2 S / T.
    """
    time = series.arrays["time"]
    values = series.arrays["positions"][time >= series.attributes["transient"], -1]
    require(values.size > 1, f"{values.size} samples, a spectrum needs 16")
    interval = float(np.median(np.diff(time)))
    law = spectrum(values, sample_interval=interval).law(*band)
    exponent, prefactor = law.exponent, law.prefactor
    if amplitude:
        exponent, prefactor = exponent.scaled(0.5), estimates.mapped(as_amplitude, prefactor)
    count = exponent.runs
    return Measurement(
        {"exponent": exponent, "prefactor": prefactor},
        note=f"{count} stretches of {values.size // count * interval:.0f}",
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
    # a block that slips as the series begins sticks first
    sticks = sticks[sticks > slips.min(initial=np.inf)]
    inside = np.searchsorted(time, [*zip(slips, sticks, strict=False)]).reshape(-1, 2)
    peaks = [relative[first:last].max() for first, last in inside if last > first]
    count = len(peaks) // STRETCHES
    require(count >= 2, f"{len(peaks)} slips of the last block, not {2 * STRETCHES}")
    return np.array(peaks[: count * STRETCHES]).reshape(STRETCHES, count)


# --- local exponents ------------------------------------------------------------------------------


def local_exponents(density: Density, neighbours: int, least: int) -> tuple[np.ndarray, np.ndarray]:
    """Slope of log density over log size in each run of neighbouring bins, and its middle.

    NaN where one of the bins has fewer than `least` values.
    """
    filled = np.where(density.count >= least, density.density, np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(np.log(filled), neighbours)
    step = np.log(density.centre[1] / density.centre[0])
    weight = np.arange(neighbours) - (neighbours - 1) / 2
    middle = density.centre[neighbours // 2 :][: len(windows)]
    return middle, windows @ weight / (weight @ weight) / step


# --- self-organised criticality -------------------------------------------------------------------


def scale_free_fit(sample: ChainValues, *, search: bool = False) -> Measurement:
    """A power law from the most probable value on, or from where it fits best."""
    law = power_law(sample, low="best" if search else None)
    return Measurement(
        {"p of the power law": Estimate(law.p, law.p, law.p, law.exponent.runs)},
        {
            "exponent": law.exponent,
            "decades": estimates.sure(np.log10(law.high / law.low)),
        },
        note=f"values from {law.low:.3g} to {law.high:.3g}",
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


def log_cutoff(sample: ChainValues) -> Estimate:
    """Logarithm of the value that 1 % of a sample exceed; chains are drawn anew."""
    require(sample.values.size, "a chain without an avalanche")

    def of(drawn):
        return np.log(np.quantile(np.concatenate(list(drawn)), CUTOFF_QUANTILE))

    log = estimates.bootstrap(of, [by_chain(sample)], grid_spacing=CUTOFF_RESOLUTION)
    require(np.isfinite(log.high), "one chain tells no interval of a cutoff")
    return log


def growth(logs: dict[int, Estimate]) -> Growth:
    """Growth of a cutoff with N, from its logarithms."""
    sizes = np.array(list(logs))
    power = estimates.slope(np.log(sizes), [*logs.values()])
    return Growth(sizes, [estimates.mapped(np.exp, log) for log in logs.values()], power)


def collapse(samples: dict[int, ChainValues]) -> Measurement:
    """Factor by which scaled densities of several N differ from one curve, and the power of N.

    If nothing but the size of the system ends a power law, N**a P(x) are one curve of x / N**D. D
    is that of the cutoffs (second over first moment), a that of least squares.
    """

    def apart(*drawn, power=None):
        values = [np.concatenate(list(chains)) for chains in drawn]
        return _apart(dict(zip(samples, values, strict=True)), power)

    chains = [by_chain(sample) for sample in samples.values()]
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


def together(catalogue: Catalogue) -> Measurement:
    """In how many avalanches blocks slip at one instant, and how far energies spread."""
    avalanches = catalogue["avalanches"]
    at_once = most_at_once(avalanches, catalogue["slips"])

    def share(chosen):
        values = ChainValues(chosen.astype(float), avalanches["point"])
        return estimates.mean([of.mean() for of in by_chain(values)])

    energies = by_chain(all_energies(catalogue))
    spreads = [np.quantile(of, 0.9) / np.quantile(of, 0.1) for of in energies]
    return Measurement(
        {
            "avalanches of two blocks or more": share(at_once >= 2),
            "energies: 90 % over 10 % quantile": estimates.mean(spreads),
        },
        {"avalanches of all blocks": share(at_once == catalogue.parameters[0].n_blocks)},
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
