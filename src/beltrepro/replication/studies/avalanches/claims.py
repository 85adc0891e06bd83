"""Claims on the chain at u = 1 without noise: its spectrum, slips and avalanches (Sec. IV.A)."""

from functools import partial

import numpy as np

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.evidence import EXACT, SCHEME
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.simulation.observables import avalanche_energies, last_block_slips, slip_sizes
from beltrepro.stats import estimates
from beltrepro.stats.densities import density

MINIMUM_SLIPS = 500
SLOW_BAND = (0.0005, 0.003)  # slower than the whole chain sticks and slips
CATALOGUES = {
    SCHEME: {5: "slips_u1", 7: "slips_n7", 10: "slips_n10"},
    EXACT: {5: "slips_u1_event", 7: "slips_n7_event", 10: "slips_n10_event"},
}


# --- the series of Fig. 8 -------------------------------------------------------------------------


@claim("spectrum-exponent")
def spectrum_exponent(evidence):
    """Exponent and prefactor of the spectrum of x_N, as an amplitude and as a power."""
    amplitude = partial(_law, evidence, "u1", amplitude=True)
    return {
        "amplitude": amplitude,
        "amplitude, fit for 0.01 to 1": partial(amplitude, band=(0.01, 1.0)),
        "amplitude, fit for 0.001 to 0.1": partial(amplitude, band=(0.001, 0.1)),
        "power": partial(_law, evidence, "u1"),
        "amplitude, exact dynamics": partial(_halves, evidence, "u1_event"),
    }


def _law(evidence, name, **how):
    return measure.spectral_law(evidence.dataset(name), **how)


def _exponent(evidence, name, **how):
    return _law(evidence, name, **how).judged["exponent"]


def _halves(evidence, name):
    """A power law has one exponent in both halves of the range."""
    law = _law(evidence, name, amplitude=True)
    low, high = measure.FIT_BAND
    middle = (low * high) ** 0.5
    lower, upper = (
        _exponent(evidence, name, band=band, amplitude=True)
        for band in ((low, middle), (middle, high))
    )
    change = {"upper minus lower half": estimates.difference(upper, lower)}
    return Measurement(law.judged | change, {"of the power": _exponent(evidence, name)}, law.note)


@claim("one-over-f", "amplitude")
def one_over_f(evidence):
    return _law(evidence, "u1", amplitude=True)


@claim("one-over-f", {"power, the paper's scheme": "u1", "power, exact dynamics": "u1_event"})
def one_over_f_of_power(evidence, name):
    """Exponent of the spectrum above and below the frequency at which it turns."""
    above = _exponent(evidence, name)
    try:
        below = _exponent(evidence, name, band=SLOW_BAND)
    except NotEnoughDataError:
        below = estimates.absent()
    return Measurement({"exponent above 0.003": above, "exponent below 0.003": below})


@claim("slip-velocity", {SCHEME: "u1", EXACT: "u1_event"})
def slip_velocity(evidence, name):
    """Peaks of the relative velocity of the last block in its slips."""
    series = evidence.dataset(name)
    stretches = measure.peaks_of_slips(series) / series.attributes["belt_velocity"]
    return Measurement(
        {
            "median peak |v_r| / u": estimates.bootstrap(np.median, [stretches]),
            "peaks: 95 % over 5 % quantile": estimates.bootstrap(_spread, [stretches]),
        },
        note=f"{stretches.size} slips in {len(stretches)} stretches",
    )


def _spread(peaks):
    return np.quantile(peaks, 0.95) / np.quantile(peaks, 0.05)


# --- exponents: Fig. 9 ----------------------------------------------------------------------------


@claim("slip-size-exponent")
def slip_size_exponent(evidence):
    """Exponent of the density of slip sizes of the last block."""
    others = {"belt frame": partial(slip_sizes, frame="belt")}
    return _exponents(evidence, slip_sizes, others)


@claim("slip-energy-exponent")
def slip_energy_exponent(evidence):
    """Exponent of the density of the energy dissipated in avalanches."""
    others = {
        "last block only": measure.last_block_energies,
        "all avalanches": measure.all_energies,
    }
    return _exponents(evidence, avalanche_energies, others)


def _exponents(evidence, sample_of, others):
    catalogue = _catalogue(evidence, "slips_u1")
    line = partial(_line, sample_of(catalogue))
    return {
        "line through all bins": line,
        "10 bins a decade": partial(line, bins_per_decade=10),
        EXACT: partial(_tested_line, evidence, sample_of),
    } | {name: partial(_line, other(catalogue)) for name, other in others.items()}


def _line(sample, **how):
    binned = density(sample, **how)
    law, filled = binned.law(), np.count_nonzero(binned.count)
    return Measurement(
        {"exponent": law.exponent},
        note=f"{filled} bins from {law.low:.3g} to {law.high:.3g}",
    )


def _tested_line(evidence, sample_of):
    """The same line of exact dynamics, and the test of a power law by maximum likelihood."""
    sample = sample_of(_catalogue(evidence, "slips_u1_event"))
    law = measure.scale_free_fit(sample)
    also = {"decades": law.also["decades"], "by maximum likelihood": law.also["exponent"]}
    return Measurement(_line(sample).judged | law.judged, also, law.note)


# --- self-organised criticality -------------------------------------------------------------------


@claim("soc-power-law")
def soc_power_law(evidence):
    """Whether a power law describes slip sizes and energies of avalanches."""

    def fit(name, sample_of, **how):
        return measure.scale_free_fit(sample_of(_catalogue(evidence, name)), **how)

    return {
        "lines through all bins": partial(_lines, evidence),
        SCHEME: partial(fit, "slips_u1", slip_sizes),
        f"{EXACT}, in the range that fits best": partial(
            fit, "slips_u1_event", slip_sizes, search=True
        ),
        "energies": partial(fit, "slips_u1", avalanche_energies),
    }


def _lines(evidence):
    """Slopes of the straight lines that the authors draw."""
    catalogue = _catalogue(evidence, "slips_u1")
    samples = {"slip size": slip_sizes(catalogue), "energy": avalanche_energies(catalogue)}
    return Measurement({name: _line(one).judged["exponent"] for name, one in samples.items()})


@claim("soc-cutoff", CATALOGUES)
def soc_cutoff(evidence, names):
    """How the largest slips and avalanches grow with N, and whether their densities collapse.

    The form is that of avalanches of two blocks or more: what one does alone knows no N.
    """
    catalogues = {n: _catalogue(evidence, name) for n, name in names.items()}

    def by_n(sample_of, **how):
        return {n: sample_of(catalogue, **how) for n, catalogue in catalogues.items()}

    samples = {"slip size": by_n(slip_sizes), "energy": by_n(measure.all_energies)}
    grown = {
        f"{name}: growth with N": measure.growth(
            {n: measure.log_cutoff(sample) for n, sample in of_n.items()}
        ).power
        for name, of_n in samples.items()
    }
    form = measure.collapse(by_n(measure.all_energies, least_blocks=2))
    return Measurement(grown | form.judged, form.also)


# --- blocks that slip together --------------------------------------------------------------------


@claim("blocks-slip-together", {SCHEME: "slips_u1", EXACT: "slips_u1_event"})
def blocks_slip_together(evidence, name):
    """Share of the avalanches in which blocks slip at one instant."""
    return measure.together(_catalogue(evidence, name))


def _catalogue(evidence, name):
    catalogue = measure.catalogue_of(evidence.dataset(name))
    slips = last_block_slips(catalogue)
    require(
        slips.size >= MINIMUM_SLIPS,
        f"{name}: {slips.size} slips of the last block, not {MINIMUM_SLIPS}",
    )
    require(np.unique(slips["point"]).size >= 2, "one chain, 2 are needed for an interval")
    return catalogue
