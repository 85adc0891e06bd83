"""Fig. 9: sizes and energies of avalanches."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.avalanches import slips as avalanches

FIGURE = Figure(
    title="Distributions of slip sizes and of dissipated energies at u = 1.",
    uses=("slips_u1",),
    words=(
        "Slip sizes of the last block, and energies dissipated in avalanches, have densities that"
        " fall like powers; the authors read a sign of self-organised criticality from them. "
        "Dashed: the exponents that the paper prints. Error bars: one standard error, from what "
        "each run changes in the density."
    ),
    alt=(
        "Two densities on doubly logarithmic axes, of slip size and of dissipated energy, each "
        "with error bars, a fitted straight line and a dashed one."
    ),
    number="9",
)

BINS_PER_DECADE = 10
EXPONENTS = {"size": -1.47, "energy": -0.87}  # in the caption of Fig. 9


@style.styled
def draw(data, caption):
    """a: density of the slip sizes of the last block; b: of the energy dissipated in avalanches.

    Filled: the reading drawn with its fit; open: another reading of the same words. Bins of equal
    width in the logarithm; the fit spans `avalanches.falling_range`.
    """
    panels.require(data, FIGURE)
    catalogue = data["slips_u1"]
    slips, events = catalogue.arrays["slips"], catalogue.arrays["avalanches"]
    n_blocks = int(catalogue.attributes["n_blocks"])
    belt_velocity = catalogue.attributes["belt_velocity"]
    own = avalanches.last_block_slips(slips, n_blocks)
    reaching = events[avalanches.with_last_block(events, slips, n_blocks)]
    sizes = {
        frame: avalanches.last_block_slip_sizes(slips, n_blocks, belt_velocity, frame)
        for frame in avalanches.FRAMES
    }

    figure = style.page(caption, 3.7)
    left, right = figure.subplots(1, 2)
    panels.letter(left, "a")
    words = f"laboratory frame, {own.size} slips"
    _density(left, sizes["laboratory"], words, own["point"], EXPONENTS["size"])
    _other_reading(left, sizes["belt"], "frame of the belt")
    _finish(left, r"$\Delta x_s$", r"$P(\Delta x_s)$")
    panels.letter(right, "b")
    words = f"whole chain, {reaching.size} avalanches"
    _density(right, reaching["dissipated"], words, reaching["point"], EXPONENTS["energy"])
    _other_reading(right, own["dissipated"], "last block only")
    _finish(right, r"$\Delta E$", r"$P(\Delta E)$")
    return figure


def _density(axes, values, label, run, printed):
    """Density of a sample of several runs, its power law, and the exponent of the paper."""
    with panels.shortage_on(axes, place=(0.68, 0.66)):
        histogram = avalanches.log_histogram(values, bins_per_decade=BINS_PER_DECADE)
        centre, density, count = histogram
        known = count > 0
        error = avalanches.density_error(values, run, centre, bins_per_decade=BINS_PER_DECADE)
        axes.errorbar(
            centre[known],
            density[known],
            np.nan_to_num(error[known]),
            fmt="o",
            color=style.BLUE,
            elinewidth=0.9,
            label=label,
            zorder=3,
        )
        low, high = avalanches.falling_range(*histogram)
        law = avalanches.fit_density(*histogram, low=low, high=high)
        words = rf"$\alpha = {law.exponent:.2f}$  ({low:.0f} to {high:.0f})"
        panels.power_law(axes, law, linewidth=1.8, zorder=2, label=words)
        panels.printed_slope(axes, law, printed)


def _other_reading(axes, values, label):
    with panels.shortage_on(axes, place=(0.68, 0.66)):
        centre, density, count = avalanches.log_histogram(values, bins_per_decade=BINS_PER_DECADE)
        known = count > 0
        look = {"color": style.SKY, "markerfacecolor": "none", "markersize": 3.5, "zorder": 1}
        axes.loglog(centre[known], density[known], "s", label=label, **look)


def _finish(axes, xlabel, ylabel):
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.set(xscale="log", yscale="log")
    if axes.lines:
        panels.plain_log(axes.xaxis)
        low, high = axes.get_ylim()
        axes.set_ylim(low, high * (high / low) ** 0.35)
        axes.legend(loc="upper right")
