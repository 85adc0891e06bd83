"""Fig. 9: sizes and energies of avalanches."""

import numpy as np

from beltrepro.replication.drawing import marks, panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.verdicts.ledger import printed

FIGURE = Figure(
    uses=("slips_u1",),
    number="9",
    shows={"slip-size-exponent": ("exponent",), "slip-energy-exponent": ("exponent",)},
)


@style.styled
def draw(data):
    """a: density of the slip sizes of the last block; b: of the energy dissipated in avalanches."""
    panels.require(data, FIGURE)
    catalogue = data["slips_u1"]
    n_slips = measure.last_block_energies(catalogue).values.size
    energies = measure.avalanche_energies(catalogue)
    figure = style.page(4.4)
    left, right = figure.subplots(2, 1)
    panels.letter(left, "a")
    panels.letter(right, "b")
    sizes = measure.slip_sizes(catalogue, "laboratory")
    _density(left, sizes, f"laboratory frame, {n_slips} slips", "slip-size-exponent")
    _other_reading(left, measure.slip_sizes(catalogue, "belt"), "frame of the belt")
    words = f"whole chain, {energies.values.size} avalanches"
    _density(right, energies, words, "slip-energy-exponent")
    _other_reading(right, measure.last_block_energies(catalogue), "last block only")
    _finish(left, r"$\Delta x_s$", r"$P(\Delta x_s)$", "slip-size-exponent")
    _finish(right, r"$\Delta E$", r"$P(\Delta E)$", "slip-energy-exponent")
    return figure


def _density(axes, sample, label, claim):
    """Density of a sample of several runs, its power law, and the exponent of the paper."""
    with panels.shortage_on(axes, place=(0.68, 0.66)):
        look = {"fmt": "o", "color": style.BLUE, "elinewidth": 0.9, "zorder": 3}
        density_with_errors(axes, sample, measure.BINS_PER_DECADE, label=label, **look)
        law, exponent = measure.density_law(sample)
        words = rf"$\alpha = {exponent.value:.2f}$"
        panels.power_law(axes, law, linewidth=1.8, zorder=2, label=words)
        panels.printed_slope(axes, law, printed(claim))


def density_with_errors(axes, sample, bins_per_decade, **look):
    """Density of a sample with the standard errors that its runs tell."""
    bins = {"bins_per_decade": bins_per_decade}
    centre, density, count = measure.log_histogram(sample.values, **bins)
    error = measure.density_error(*sample, centre, **bins)
    filled = count > 0
    axes.errorbar(centre[filled], density[filled], np.nan_to_num(error[filled]), **look)


def _other_reading(axes, sample, label):
    with panels.shortage_on(axes, place=(0.68, 0.66)):
        centre, density, count = measure.log_histogram(
            sample.values, bins_per_decade=measure.BINS_PER_DECADE
        )
        look = {"color": style.SKY, "markerfacecolor": "none", "markersize": 3.5, "zorder": 1}
        axes.loglog(centre[count > 0], density[count > 0], "s", label=label, **look)


def _finish(axes, xlabel, ylabel, claim):
    axes.set(xlabel=xlabel, ylabel=ylabel, xscale="log", yscale="log")
    if axes.lines:
        panels.plain_log(axes.xaxis)
        low, high = axes.get_ylim()
        axes.set_ylim(low, high * (high / low) ** 0.25)
        for text in axes.legend(loc="upper right").get_texts():
            if "alpha" in text.get_text():
                marks.shown(text, claim, "exponent")
