"""Claims on the chain at u = 1 without noise: its spectrum, slips and avalanches (Sec. IV.A)."""

from functools import partial

import numpy as np

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates

MINIMUM_SLIPS = 500
PAPERS_SCHEME, EXACT = "the paper's scheme", "exact dynamics"
CATALOGUES = {
    PAPERS_SCHEME: {5: "slips_u1", 7: "slips_n7", 10: "slips_n10"},
    EXACT: {5: "slips_u1_event", 7: "slips_n7_event", 10: "slips_n10_event"},
}


# --- the series of Fig. 8 -------------------------------------------------------------------------


@claim("spectrum-exponent")
def spectrum_exponent(evidence):
    """Exponent and prefactor of the spectrum of x_N, as an amplitude and as a power."""
    amplitude = partial(_spectral_law, evidence, "u1", measure.amplitude_law)
    return {
        "amplitude": amplitude,
        "amplitude, fit for 0.01 to 1": partial(amplitude, band=(0.01, 1.0)),
        "amplitude, fit for 0.001 to 0.1": partial(amplitude, band=(0.001, 0.1)),
        "power": partial(_spectral_law, evidence, "u1"),
        "power, exact dynamics": partial(_halves, evidence),
    }


def _spectral_law(evidence, name, law_of=measure.spectral_law, **how):
    law = law_of(evidence.dataset(name), **how)
    return Measurement(
        {"exponent": law.exponent, "prefactor": law.prefactor},
        note=f"{law.count} stretches of {law.length:.0f}",
    )


def _halves(evidence):
    """A power law has one exponent in both halves of the range."""
    law = _spectral_law(evidence, "u1_event")
    low, high = measure.FIT_BAND
    middle = (low * high) ** 0.5
    lower, upper = (
        measure.spectral_law(evidence.dataset("u1_event"), band=band).exponent
        for band in ((low, middle), (middle, high))
    )
    change = estimates.difference(upper, lower)
    also = {
        "amplitude": measure.amplitude_law(evidence.dataset("u1_event")).exponent,
        "by the scheme": _spectral_law(evidence, "u1").judged["exponent"],
    }
    return Measurement(law.judged | {"upper minus lower half": change}, also, law.note)


@claim("one-over-f")
def one_over_f(evidence):
    """Exponent of the spectrum above and below the frequency at which it turns."""

    def power(name):
        above = _spectral_law(evidence, name).judged["exponent"]
        try:
            below = _spectral_law(evidence, name, band=measure.SLOW_BAND).judged["exponent"]
        except NotEnoughDataError:
            below = estimates.absent()
        return Measurement({"exponent above 0.003": above, "exponent below 0.003": below})

    return {
        "amplitude": partial(_spectral_law, evidence, "u1", measure.amplitude_law),
        "power, the paper's scheme": partial(power, "u1"),
        "power, exact dynamics": partial(power, "u1_event"),
    }


@claim("slip-velocity")
def slip_velocity(evidence):
    """Peaks of the relative velocity of the last block in its slips."""

    def peaks(name):
        series = evidence.dataset(name)
        stretches = measure.peaks_of_slips(series) / series.attributes["belt_velocity"]
        return Measurement(
            {
                "median peak |v_r| / u": estimates.bootstrap(np.median, [stretches]),
                "peaks: 95 % over 5 % quantile": estimates.bootstrap(_spread, [stretches]),
            },
            note=f"{stretches.size} slips in {len(stretches)} stretches",
        )

    return {PAPERS_SCHEME: partial(peaks, "u1"), EXACT: partial(peaks, "u1_event")}


def _spread(peaks):
    return np.quantile(peaks, 0.95) / np.quantile(peaks, 0.05)


# --- exponents: Fig. 9 ----------------------------------------------------------------------------


@claim("slip-size-exponent")
def slip_size_exponent(evidence):
    """Exponent of the density of slip sizes of the last block."""
    return _exponents(
        evidence,
        measure.slip_sizes,
        {"belt frame": partial(measure.slip_sizes, frame="belt")},
    )


@claim("slip-energy-exponent")
def slip_energy_exponent(evidence):
    """Exponent of the density of the energy dissipated in avalanches."""
    return _exponents(
        evidence,
        measure.avalanche_energies,
        {"last block only": measure.last_block_energies, "all avalanches": measure.all_energies},
    )


def _exponents(evidence, sample, others):
    catalogue = _catalogue(evidence, "slips_u1")
    return {
        "line through all bins": partial(_exponent, sample(catalogue)),
        "10 bins a decade": partial(_exponent, sample(catalogue), bins_per_decade=10),
        "falling bins, 10 a decade": partial(
            _exponent, sample(catalogue), bins_per_decade=10, falling=True
        ),
        "maximum likelihood": partial(_likely_exponent, evidence, sample),
    } | {name: partial(_exponent, other(catalogue)) for name, other in others.items()}


def _exponent(sample, **how):
    law, exponent = measure.density_law(sample, **how)
    return Measurement(
        {"exponent": exponent},
        {"decades": estimates.sure(np.log10(law.high / law.low))},
        note=f"{law.sample_size} bins from {law.low:.3g} to {law.high:.3g}",
    )


def _likely_exponent(evidence, sample):
    """With the test of a power law, of exact dynamics; beside it the line of the scheme."""
    law = _scale_free(evidence, "slips_u1_event", sample)
    line = _exponent(sample(_catalogue(evidence, "slips_u1_event"))).judged["exponent"]
    also = law.also | {"line through all bins": line}
    return Measurement({"exponent": law.also["exponent"]} | law.judged, also, law.note)


# --- self-organised criticality -------------------------------------------------------------------


@claim("soc-power-law")
def soc_power_law(evidence):
    """Whether a power law describes slip sizes and energies of avalanches."""
    sizes, energies = measure.slip_sizes, measure.avalanche_energies
    return {
        PAPERS_SCHEME: partial(_scale_free, evidence, "slips_u1", sizes),
        f"{EXACT}, in the range that fits best": partial(
            _scale_free, evidence, "slips_u1_event", sizes, search=True
        ),
        "energies": partial(_scale_free, evidence, "slips_u1", energies),
    }


def _scale_free(evidence, name, sample, **how):
    fit = measure.scale_free_fit(sample(_catalogue(evidence, name)), **how)
    return Measurement(
        {"p of the power law": estimates.Estimate(fit.p, fit.p, fit.p, fit.chains)},
        {"exponent": fit.exponent, "decades": estimates.sure(np.log10(fit.high / fit.low))},
        note=f"values from {fit.low:.3g} to {fit.high:.3g}",
    )


@claim("soc-cutoff")
def soc_cutoff(evidence):
    """How the largest slips and avalanches grow with N, and whether their densities collapse."""
    return {method: partial(_growth_and_form, evidence, method) for method in CATALOGUES}


def _growth_and_form(evidence, method):
    """The form is that of avalanches of two blocks or more: what one does alone knows no N."""

    def by_n(sample):
        return {n: sample(_catalogue(evidence, name)) for n, name in CATALOGUES[method].items()}

    sizes, energies = (
        measure.growth(by_n(sample)).power for sample in (measure.slip_sizes, measure.all_energies)
    )
    samples = by_n(partial(measure.all_energies, least_blocks=2))
    factor, power = measure.collapse(samples)
    also = {"power of N": power, "distance without scaling": measure.unscaled(samples)}
    return Measurement(
        {
            "slip size: growth with N": sizes,
            "energy: growth with N": energies,
            "distance from one curve": factor,
        },
        {name: estimates.sure(value) for name, value in also.items()},
    )


# --- blocks that slip together --------------------------------------------------------------------


@claim("blocks-slip-together")
def blocks_slip_together(evidence):
    """Share of the avalanches in which blocks slip at one instant."""

    def together(name):
        slips, avalanches, n_blocks = measure.parts(_catalogue(evidence, name))
        at_once = measure.most_at_once(avalanches, slips)
        chain = avalanches["point"]
        energies = measure.Sample(avalanches["dissipated"], chain)
        return Measurement(
            {
                "avalanches of two blocks or more": measure.share_of_chains(at_once >= 2, chain),
                "energies: 90 % over 10 % quantile": measure.spread_of_energies(energies),
            },
            {"avalanches of all blocks": measure.share_of_chains(at_once == n_blocks, chain)},
            note=f"{avalanches.size} avalanches; blocks count that slip at one instant",
        )

    return {
        PAPERS_SCHEME: partial(together, "slips_u1"),
        EXACT: partial(together, "slips_u1_event"),
    }


def _catalogue(evidence, name):
    catalogue = evidence.dataset(name)
    slips, _, n_blocks = measure.parts(catalogue)
    of_last = measure.last_block_slips(slips, n_blocks)
    require(
        of_last.size >= MINIMUM_SLIPS,
        f"{name}: {of_last.size} slips of the last block, not {MINIMUM_SLIPS}",
    )
    require(np.unique(of_last["point"]).size >= 2, "one chain, 2 are needed for an interval")
    return catalogue
