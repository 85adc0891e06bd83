"""Claims on slips and avalanches: their densities, and self-organised criticality (Sec. IV.A)."""

from functools import partial

import numpy as np

from beltrepro.replication.studies.avalanches import slips as avalanches
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.registry import claim
from beltrepro.stats import estimates, scale_free
from beltrepro.stats.errors import require

MINIMUM_SLIPS = 500
BINS_PER_DECADE = 10
CUTOFF_QUANTILE = 0.99
# Of the logarithm of a cutoff. Slips of one periodic orbit do not scatter at all.
CUTOFF_RESOLUTION = 0.02
CATALOGUES = {3: "slips_n3", 5: "slips_u1", 7: "slips_n7", 10: "slips_n10"}
STARTS_TRIED = 12


# --- exponents: Fig. 9 ----------------------------------------------------------------------------


@claim("slip-size-exponent")
def slip_size_exponent(evidence):
    """Exponent of the density of slip sizes of the last block."""
    catalogue = _catalogue(evidence, "slips_u1")
    laboratory, chain = _sizes(catalogue, "laboratory")
    return {
        "laboratory frame": partial(_exponent, laboratory, chain),
        "belt frame": partial(_exponent, *_sizes(catalogue, "belt")),
        "5 bins per decade": partial(_exponent, laboratory, chain, bins_per_decade=5),
        "20 bins per decade": partial(_exponent, laboratory, chain, bins_per_decade=20),
        "all bins": partial(_exponent, laboratory, chain, whole_range=True),
        "maximum likelihood": partial(_likely_exponent, laboratory, chain),
    }


@claim("slip-energy-exponent")
def slip_energy_exponent(evidence):
    """Exponent of the density of the energy dissipated in avalanches."""
    catalogue = _catalogue(evidence, "slips_u1")
    slips, found, n_blocks = _parts(catalogue)
    own = avalanches.last_block_slips(slips, n_blocks)
    reaching = found[avalanches.with_last_block(found, slips, n_blocks)]
    energy, chain = reaching["dissipated"], reaching["point"]
    until_stop = avalanches.dissipation_while_last_block_slips(slips, n_blocks)
    return {
        "chain, until all are stuck": partial(_exponent, energy, chain),
        "chain, until the last block stops": partial(_exponent, until_stop, own["point"]),
        "last block only": partial(_exponent, own["dissipated"], own["point"]),
        "all avalanches of the chain": partial(_exponent, found["dissipated"], found["point"]),
        "drop in spring energy": partial(_exponent, reaching["spring_energy_drop"], chain),
        "20 bins per decade": partial(_exponent, energy, chain, bins_per_decade=20),
        "maximum likelihood": partial(_likely_exponent, energy, chain),
    }


def _exponent(values, chain, *, bins_per_decade=BINS_PER_DECADE, whole_range=False):
    """By least squares through a histogram; chains are drawn anew for the interval."""
    centre, *_ = avalanches.log_histogram(values, bins_per_decade=bins_per_decade)
    half_bin = 10 ** (0.5 / bins_per_decade)
    edges = np.r_[centre / half_bin, centre[-1] * half_bin]
    counts = np.array([np.histogram(each, edges)[0] for each in _by_chain(values, chain)])

    def fit(counts):
        count = counts.sum(axis=0)
        histogram = centre, count / (count.sum() * np.diff(edges)), count
        low, high = (centre[0], centre[-1]) if whole_range else avalanches.falling_range(*histogram)
        return avalanches.fit_density(*histogram, low=low, high=high)

    best = fit(counts)
    return Measurement(
        {"exponent": estimates.bootstrap(lambda drawn: fit(drawn).exponent, [counts])},
        {"decades of the fit": estimates.sure(np.log10(best.high / best.low))},
        note=f"fit for {best.low:.3g} to {best.high:.3g}, {best.sample_size} bins",
    )


def _likely_exponent(values, chain):
    """By maximum likelihood over the falling part of the density."""
    histogram = avalanches.log_histogram(values, bins_per_decade=BINS_PER_DECADE)
    low, high = avalanches.falling_range(*histogram)
    sums = _sums(values, chain, low, high)
    return Measurement(
        {"exponent": estimates.bootstrap(lambda drawn: _fit(drawn, low, high).exponent, [sums])},
        note=f"values from {low:.3g} to {high:.3g}",
    )


# --- self-organised criticality -------------------------------------------------------------------


@claim("soc-power-law")
def soc_power_law(evidence):
    """Whether a power law describes slip sizes, and whether it has a cutoff."""
    catalogue = _catalogue(evidence, "slips_u1")
    slips, found, n_blocks = _parts(catalogue)
    reaching = found[avalanches.with_last_block(found, slips, n_blocks)]
    laboratory = _sizes(catalogue, "laboratory")
    return {
        "sizes": partial(_scale_free, *laboratory),
        "sizes, in the range that fits best": partial(_scale_free, *laboratory, search=True),
        "sizes, belt frame": partial(_scale_free, *_sizes(catalogue, "belt")),
        "energies": partial(_scale_free, reaching["dissipated"], reaching["point"]),
    }


def _scale_free(values, chain, *, search=False):
    """A power law from the most probable value on, or from where it fits best, and two rivals."""
    centre, density, _ = avalanches.log_histogram(values, bins_per_decade=BINS_PER_DECADE)
    low = float(centre[np.argmax(density)])
    chain, values = chain[values >= low], values[values >= low]
    shares = np.linspace(0, 0.9, STARTS_TRIED) if search else [0.0]
    worth = scale_free.independent_values(np.log(values), chain)
    fit = scale_free.goodness_of_fit(values, np.quantile(values, shares), independent=worth)
    low, high = fit.law.low, fit.law.high
    sums = _sums(values, chain, low, high)
    power, exponential = _fit(sums, low, high), _fit(sums, low, high, power=False, decay=True)
    gain = [
        np.sum(power.log_density(own) - exponential.log_density(own))
        for own in (each[each >= low] for each in _by_chain(values, chain))
    ]
    per_chain = sums[:, 0].mean()
    advantage = estimates.mean(np.array(gain) / per_chain)
    cutoff = estimates.bootstrap(
        lambda drawn: high * _fit(drawn, low, high, decay=True).decay, [sums]
    )
    return Measurement(
        {
            "p of the power law": estimates.Estimate(fit.p, fit.p, fit.p, len(sums)),
            "largest size over the cutoff": cutoff,
            "log-likelihood, power law minus exponential": advantage,
        },
        {
            "exponent": estimates.sure(power.exponent),
            "Kolmogorov-Smirnov distance": estimates.sure(fit.distance),
            "decades": estimates.sure(np.log10(high / low)),
        },
        note=f"{sums[:, 0].sum():.0f} values from {low:.3g} to {high:.3g}",
    )


@claim("soc-cutoff")
def soc_cutoff(evidence):
    """How the largest slips and avalanches grow with the number of blocks."""
    return {
        "99 % quantile": partial(_growth, evidence, _log_quantile, "laboratory"),
        "ratio of moments": partial(_growth, evidence, _log_moments, "laboratory"),
        "99 % quantile, belt frame": partial(_growth, evidence, _log_quantile, "belt"),
    }


def _growth(evidence, cutoff, frame):
    places, sizes, energies = [], [], []
    for n_blocks in evidence.claim.parameters["n_blocks"]:
        catalogue = _catalogue(evidence, CATALOGUES[n_blocks])
        _, found, _ = _parts(catalogue)
        places.append(np.log(n_blocks))
        sizes.append(_cutoff(cutoff, *_sizes(catalogue, frame)))
        energies.append(_cutoff(cutoff, found["dissipated"], found["point"]))
    largest = [f"{np.exp(each.value):.3g}" for each in sizes]
    return Measurement(
        {
            "slip size: growth with N": estimates.slope(places, sizes),
            "energy: growth with N": estimates.slope(places, energies),
        },
        note=f"cutoff of slip sizes {', '.join(largest)} for N = "
        f"{', '.join(str(each) for each in evidence.claim.parameters['n_blocks'])}",
    )


def _cutoff(cutoff, values, chain):
    """Logarithm of a cutoff, with an interval from chains drawn anew."""
    groups = _by_chain(values, chain)
    chains = np.empty(len(groups), dtype=object)
    chains[:] = groups
    return estimates.bootstrap(
        lambda drawn: cutoff(np.concatenate(list(drawn))), [chains], grid_spacing=CUTOFF_RESOLUTION
    )


def _log_quantile(values):
    return np.log(np.quantile(values, CUTOFF_QUANTILE))


def _log_moments(values):
    return np.log(np.mean(values**2) / np.mean(values))


# --- blocks that slip together --------------------------------------------------------------------


@claim("blocks-slip-together")
def blocks_slip_together(evidence):
    """Share of the avalanches in which all blocks slip at one instant."""
    slips, found, n_blocks = _parts(_catalogue(evidence, "slips_u1"))
    at_once = avalanches.most_at_once(found, slips)
    energy, all_at_once = found["dissipated"], at_once == n_blocks
    alone = np.mean(found["blocks"] == 1)
    spread = _by_chain(energy, found["point"])
    ratios = [np.quantile(each, 0.9) / np.quantile(each, 0.1) for each in spread]

    def reading(together, weight):
        count, total = (
            np.array([each.sum() for each in _by_chain(values, found["point"])])
            for values in (together * weight, weight)
        )
        return Measurement(
            {
                "avalanches in which all blocks slip at once": estimates.mean(count / total),
                "energies: 90 % over 10 % quantile": estimates.mean(ratios),
            },
            note=f"{found.size} avalanches; one block alone slips in {alone:.2g} of them",
        )

    equal = np.ones(found.size)
    return {
        "at one instant": partial(reading, all_at_once, equal),
        "during the avalanche": partial(reading, found["blocks"] == n_blocks, equal),
        "two or more at one instant": partial(reading, at_once >= 2, equal),
        "at one instant, weighted by energy": partial(reading, all_at_once, energy),
    }


# --- shared ---------------------------------------------------------------------------------------


def _catalogue(evidence, name):
    catalogue = evidence.dataset(name)
    slips, _, n_blocks = _parts(catalogue)
    count = avalanches.last_block_slips(slips, n_blocks).size
    require(count >= MINIMUM_SLIPS, f"{name}: {count} slips of the last block, not {MINIMUM_SLIPS}")
    return catalogue


def _parts(catalogue):
    """Slips, avalanches and N."""
    arrays = catalogue.arrays
    return arrays["slips"], arrays["avalanches"], int(catalogue.attributes["n_blocks"])


def _sizes(catalogue, frame):
    """Positive slip sizes of the last block, and the chain of each."""
    slips, _, n_blocks = _parts(catalogue)
    sizes = avalanches.last_block_slip_sizes(
        slips, n_blocks, catalogue.attributes["belt_velocity"], frame
    )
    chain = avalanches.last_block_slips(slips, n_blocks)["point"]
    return sizes[sizes > 0], chain[sizes > 0]


def _by_chain(values, chain):
    """Values of each chain."""
    order = np.argsort(chain, kind="stable")
    _, first = np.unique(chain[order], return_index=True)
    require(len(first) >= 2, "one chain, 2 are needed for an interval")
    return np.split(values[order], first[1:])


def _sums(values, chain, low, high):
    """Number of values in a range, and sums of ln x and x over them, for each chain (C, 3)."""
    scale_free.inside(values, low, high)
    used = (values >= low) & (values <= high)
    own = np.where(used, values, 1.0)
    terms = used * np.stack([np.ones(values.size), np.log(own), own])
    return np.array([part.sum(axis=0) for part in _by_chain(terms.T, chain)])


def _fit(sums, low, high, **kind):
    count, *totals = sums.sum(axis=0)
    return scale_free.fit_law(*(np.array(totals) / count), low, high, **kind)
