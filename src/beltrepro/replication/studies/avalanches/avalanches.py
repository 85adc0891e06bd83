"""Not in the paper: avalanches of chains of several lengths."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.avalanches import slips as avalanches
from beltrepro.stats import fits

FIGURE = Figure(
    title="Energies of avalanches at u = 1 for several numbers of blocks, and where they end.",
    uses=("slips_n3", "slips_u1", "slips_n7", "slips_n10"),
    words=(
        "Not in the paper, which shows five blocks. a: density of the energy dissipated in an "
        "avalanche, of all avalanches. In a self-organised critical state the densities of all "
        "lengths fall on one power law, which goes the further the longer the chain. b: where they "
        "end, as the ratio of the second moment to the first, with its standard error, and the "
        "largest energy seen; the line is a power law through the ratios."
    ),
    alt=(
        "Two panels on doubly logarithmic axes: densities of dissipated energy, a line for each "
        "number of blocks, and the energy at which they end against the number of blocks."
    ),
    category="Further studies",
)

BINS_PER_DECADE = 8
LEAST = 4  # numbers of blocks for a power law


@style.styled
def draw(data, caption):
    """a: density of the dissipated energy for each N; b: its cutoff against N."""
    panels.require(data, FIGURE)
    every = sorted((data[name] for name in FIGURE.uses), key=lambda one: one.attributes["n_blocks"])
    figure = style.page(caption, 3.7)
    left, right = figure.subplots(1, 2, width_ratios=(1.3, 1))
    panels.letter(left, "a")
    panels.letter(right, "b")
    left.set(xlabel=r"$\Delta E$", ylabel=r"$P(\Delta E)$", xscale="log", yscale="log")
    right.set(xlabel="$N$", ylabel=r"$\Delta E$", xscale="log", yscale="log")
    ends = []
    for index, catalogue in enumerate(every):
        events, n_blocks = catalogue.arrays["avalanches"], catalogue.attributes["n_blocks"]
        energy, run = events["dissipated"], events["point"]
        if (energy > 0).any():
            _density(left, energy, run, index, f"$N = {n_blocks}$, {energy.size} avalanches")
            ends.append((n_blocks, *avalanches.cutoff(energy, run), energy.max()))
    if ends:
        left.legend(loc="lower left", fontsize=7)
        _cutoffs(right, np.array(ends, dtype=float))
    else:
        panels.note(left, "no avalanche in these catalogues")
        panels.note(right, "no avalanche in these catalogues")
    return figure


def _density(axes, energy, run, index, label):
    centre, density, count = avalanches.log_histogram(energy, bins_per_decade=BINS_PER_DECADE)
    error = avalanches.density_error(energy, run, centre, bins_per_decade=BINS_PER_DECADE)
    known = count > 0
    look = style.line_style(index) | {"linewidth": 0.9, "markersize": 3, "elinewidth": 0.8}
    axes.errorbar(centre[known], density[known], np.nan_to_num(error[known]), label=label, **look)


def _cutoffs(axes, ends):
    """ends (E, 4): number of blocks, ratio of moments, its error, largest energy."""
    n_blocks, size, error, largest = ends.T
    axes.errorbar(
        n_blocks,
        size,
        np.nan_to_num(error),
        fmt="o",
        color=style.BLUE,
        label=r"$\langle \Delta E^2 \rangle / \langle \Delta E \rangle$",
    )
    axes.plot(n_blocks, largest, "^", color=style.GREY, label="largest")
    if n_blocks.size >= LEAST:
        law = fits.fit_log_log(n_blocks, size, low=n_blocks.min(), high=n_blocks.max())
        words = rf"$\propto N^{{{law.exponent:.2f} \pm {law.exponent_error:.2f}}}$"
        panels.power_law(axes, law, label=words)
    axes.set_xticks(n_blocks, [f"{n:g}" for n in n_blocks])
    axes.minorticks_off()
    axes.legend(loc="upper left")
