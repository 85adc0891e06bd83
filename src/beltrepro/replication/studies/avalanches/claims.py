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


SPECTRA = {
    "amplitude": {"amplitude": True},
    "amplitude, fit for 0.01 to 1": {"amplitude": True, "band": (0.01, 1.0)},
    "amplitude, fit for 0.001 to 0.1": {"amplitude": True, "band": (0.001, 0.1)},
    "power": {},
}


@claim("spectrum-exponent", SPECTRA)
def spectrum_exponent(evidence, how):
    """Exponent and prefactor of the spectrum of x_N, as an amplitude and as a power."""
    return _law(evidence, "u1", **how)


def _law(evidence, name, **how):
    return measure.spectral_law(evidence.dataset(name), **how)


def _exponent(evidence, name, **how):
    return _law(evidence, name, **how).judged["exponent"]


@claim("spectrum-exponent", "amplitude, exact dynamics")
def spectrum_in_halves(evidence):
    """A power law has one exponent in both halves of the range."""
    law = _law(evidence, "u1_event", amplitude=True)
    low, high = measure.FIT_BAND
    middle = (low * high) ** 0.5
    lower, upper = (
        _exponent(evidence, "u1_event", band=band, amplitude=True)
        for band in ((low, middle), (middle, high))
    )
    change = {"upper minus lower half": estimates.difference(upper, lower)}
    also = {"of the power": _exponent(evidence, "u1_event")}
    return Measurement(law.judged | change, also, law.note)


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


def _line(sample, **how):
    binned = density(sample, **how)
    law, filled = binned.law(), np.count_nonzero(binned.count)
    return Measurement(
        {"exponent": law.exponent},
        note=f"{filled} bins from {law.low:.3g} to {law.high:.3g}",
    )


def _line_of_scheme(evidence, sample_of, **how):
    return _line(sample_of(_catalogue(evidence, "slips_u1")), **how)


def _tested_line(evidence, sample_of):
    """The same line of exact dynamics, and the test of a power law by maximum likelihood."""
    sample = sample_of(_catalogue(evidence, "slips_u1_event"))
    law = measure.scale_free_fit(sample)
    also = {"decades": law.also["decades"], "by maximum likelihood": law.also["exponent"]}
    return Measurement(_line(sample).judged | law.judged, also, law.note)


def _lines(sample_of, others):
    """By reading, what finds the exponent of a density in `evidence`."""
    return {
        "line through all bins": partial(_line_of_scheme, sample_of=sample_of),
        "10 bins a decade": partial(_line_of_scheme, sample_of=sample_of, bins_per_decade=10),
        EXACT: partial(_tested_line, sample_of=sample_of),
    } | {name: partial(_line_of_scheme, sample_of=other) for name, other in others.items()}


SIZES = _lines(slip_sizes, {"belt frame": partial(slip_sizes, frame="belt")})
OTHERS = {"last block only": measure.last_block_energies, "all avalanches": measure.all_energies}


@claim("slip-size-exponent", SIZES)
@claim("slip-energy-exponent", _lines(avalanche_energies, OTHERS))
def exponent_of_density(evidence, line_of):
    """Exponent of the density of slip sizes, or of the energies dissipated in avalanches."""
    return line_of(evidence)


# --- self-organised criticality -------------------------------------------------------------------


@claim("soc-power-law", "lines through all bins")
def slopes_of_lines(evidence):
    """Slopes of the straight lines that the authors draw."""
    catalogue = _catalogue(evidence, "slips_u1")
    samples = {"slip size": slip_sizes(catalogue), "energy": avalanche_energies(catalogue)}
    return Measurement({name: _line(one).judged["exponent"] for name, one in samples.items()})


FITS = {
    SCHEME: ("slips_u1", slip_sizes, False),
    f"{EXACT}, in the range that fits best": ("slips_u1_event", slip_sizes, True),
    "energies": ("slips_u1", avalanche_energies, False),
}


@claim("soc-power-law", FITS)
def soc_power_law(evidence, fit):
    """Whether a power law describes slip sizes and energies of avalanches."""
    name, sample_of, search = fit
    return measure.scale_free_fit(sample_of(_catalogue(evidence, name)), search=search)


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
