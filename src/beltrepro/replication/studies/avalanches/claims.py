"""Claims on slips and avalanches: their densities, and self-organised criticality (Sec. IV.A)."""

from functools import partial

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates

MINIMUM_SLIPS = 500
CATALOGUES = {3: "slips_n3", 5: "slips_u1", 7: "slips_n7", 10: "slips_n10"}


# --- exponents: Fig. 9 ----------------------------------------------------------------------------


@claim("slip-size-exponent")
def slip_size_exponent(evidence):
    """Exponent of the density of slip sizes of the last block."""
    catalogue = _catalogue(evidence, "slips_u1")
    laboratory = measure.slip_sizes(catalogue, "laboratory")
    return {
        "laboratory frame": partial(_exponent, laboratory),
        "belt frame": partial(_exponent, measure.slip_sizes(catalogue, "belt")),
        "5 bins per decade": partial(_exponent, laboratory, bins_per_decade=5),
        "20 bins per decade": partial(_exponent, laboratory, bins_per_decade=20),
        "all bins": partial(_exponent, laboratory, whole_range=True),
        "maximum likelihood": partial(_likely_exponent, laboratory),
    }


@claim("slip-energy-exponent")
def slip_energy_exponent(evidence):
    """Exponent of the density of the energy dissipated in avalanches."""
    catalogue = _catalogue(evidence, "slips_u1")
    energies = measure.avalanche_energies(catalogue)
    others = {
        "chain, until the last block stops": measure.energies_until_stop,
        "last block only": measure.last_block_energies,
        "all avalanches of the chain": measure.all_energies,
        "drop in spring energy": measure.spring_energy_drops,
    }
    return (
        {"chain, until all are stuck": partial(_exponent, energies)}
        | {name: partial(_exponent, sample(catalogue)) for name, sample in others.items()}
        | {
            "20 bins per decade": partial(_exponent, energies, bins_per_decade=20),
            "maximum likelihood": partial(_likely_exponent, energies),
        }
    )


def _exponent(sample, **how):
    law, exponent = measure.falling_density(sample, **how)
    return Measurement(
        {"exponent": exponent},
        {"decades of the fit": estimates.sure(np.log10(law.high / law.low))},
        note=f"fit for {law.low:.3g} to {law.high:.3g}, {law.sample_size} bins",
    )


def _likely_exponent(sample):
    exponent, low, high = measure.likely_exponent(sample)
    return Measurement({"exponent": exponent}, note=f"values from {low:.3g} to {high:.3g}")


# --- self-organised criticality -------------------------------------------------------------------


@claim("soc-power-law")
def soc_power_law(evidence):
    """Whether a power law describes slip sizes, and whether it has a cutoff."""
    catalogue = _catalogue(evidence, "slips_u1")
    sizes = measure.slip_sizes(catalogue, "laboratory")
    return {
        "sizes": partial(_scale_free, sizes),
        "sizes, in the range that fits best": partial(_scale_free, sizes, search=True),
        "sizes, belt frame": partial(_scale_free, measure.slip_sizes(catalogue, "belt")),
        "energies": partial(_scale_free, measure.avalanche_energies(catalogue)),
    }


def _scale_free(sample, **how):
    fit = measure.scale_free_fit(sample, **how)
    return Measurement(
        {
            "p of the power law": estimates.Estimate(fit.p, fit.p, fit.p, fit.chains),
            "largest size over the cutoff": fit.cutoff,
            "log-likelihood, power law minus exponential": fit.advantage,
        },
        {
            "exponent": estimates.sure(fit.exponent),
            "Kolmogorov-Smirnov distance": estimates.sure(fit.distance),
            "decades": estimates.sure(np.log10(fit.high / fit.low)),
        },
        note=f"{fit.count} values from {fit.low:.3g} to {fit.high:.3g}",
    )


@claim("soc-cutoff")
def soc_cutoff(evidence):
    """How the largest slips and avalanches grow with the number of blocks."""
    return {
        "99 % quantile": partial(_growth, evidence, measure.log_quantile, "laboratory"),
        "ratio of moments": partial(_growth, evidence, measure.log_moments, "laboratory"),
        "99 % quantile, belt frame": partial(_growth, evidence, measure.log_quantile, "belt"),
    }


def _growth(evidence, log_cutoff, frame):
    n_blocks = evidence.claim.parameters["n_blocks"]
    catalogues = {size: _catalogue(evidence, CATALOGUES[size]) for size in n_blocks}
    sizes, energies = (
        measure.growth({n: sample(of) for n, of in catalogues.items()}, log_cutoff)
        for sample in (partial(measure.slip_sizes, frame=frame), measure.all_energies)
    )
    largest = ", ".join(f"{cutoff.value:.3g}" for cutoff in sizes.cutoffs)
    return Measurement(
        {"slip size: growth with N": sizes.power, "energy: growth with N": energies.power},
        note=f"cutoff of slip sizes {largest} for N = {', '.join(map(str, n_blocks))}",
    )


# --- blocks that slip together --------------------------------------------------------------------


@claim("blocks-slip-together")
def blocks_slip_together(evidence):
    """Share of the avalanches in which all blocks slip at one instant."""
    slips, avalanches, n_blocks = measure.parts(_catalogue(evidence, "slips_u1"))
    energies = measure.Sample(avalanches["dissipated"], avalanches["point"])
    at_once = measure.most_at_once(avalanches, slips)
    alone = np.mean(avalanches["blocks"] == 1)

    def reading(together, weight):
        return Measurement(
            {
                "avalanches in which all blocks slip at once": measure.share_of_weight(
                    together, weight, energies.chain
                ),
                "energies: 90 % over 10 % quantile": measure.spread_of_energies(energies),
            },
            note=f"{avalanches.size} avalanches; one block alone slips in {alone:.2g} of them",
        )

    equal = np.ones(avalanches.size)
    return {
        "at one instant": partial(reading, at_once == n_blocks, equal),
        "during the avalanche": partial(reading, avalanches["blocks"] == n_blocks, equal),
        "two or more at one instant": partial(reading, at_once >= 2, equal),
        "at one instant, weighted by energy": partial(
            reading, at_once == n_blocks, energies.values
        ),
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
