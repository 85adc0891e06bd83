"""Not in the paper: avalanches of chains of several lengths."""

import numpy as np

from beltrepro.replication.drawing import marks, panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.studies.avalanches.fig09 import density_with_errors

FIGURE = Figure(
    uses=("slips_n3", "slips_u1", "slips_n7", "slips_n10"),
    category="Further studies",
    shows={"soc-cutoff": ("energy: growth with N",)},
)

BINS_PER_DECADE = 8
LEAST_FITTED = 5  # blocks


@style.styled
def draw(data):
    """a: density of the dissipated energy for each N; b: its cutoff against N."""
    panels.require(data, FIGURE)
    catalogues = sorted(
        (data[name] for name in FIGURE.uses), key=lambda catalogue: catalogue.attributes["n_blocks"]
    )
    figure = style.page(4.2)
    left, right = figure.subplots(2, 1, height_ratios=(1.3, 1))
    panels.letter(left, "a")
    panels.letter(right, "b")
    left.set(xlabel=r"$\Delta E$", ylabel=r"$P(\Delta E)$", xscale="log", yscale="log")
    right.set(xlabel="$N$", ylabel=r"$\Delta E$", xscale="log", yscale="log")
    samples = {
        int(catalogue.attributes["n_blocks"]): measure.all_energies(catalogue)
        for catalogue in catalogues
    }
    for index, (n_blocks, sample) in enumerate(samples.items()):
        if (sample.values > 0).any():
            label = f"$N = {n_blocks}$, {sample.values.size} avalanches"
            look = style.line_style(index) | {"linewidth": 0.9, "markersize": 3, "elinewidth": 0.8}
            density_with_errors(left, sample, BINS_PER_DECADE, label=label, **look)
    if left.lines:
        left.legend(loc="lower left")
    else:
        panels.note(left, "no avalanche in these catalogues")
    with panels.shortage_on(right):
        _cutoffs(right, {n: sample for n, sample in samples.items() if (sample.values > 0).any()})
    return figure


def _cutoffs(axes, samples):
    """With N = 3, whose motion is another, the law is not fitted."""
    n_blocks, cutoffs, _ = measure.growth(samples)
    growth = measure.growth({n: sample for n, sample in samples.items() if n >= LEAST_FITTED})
    cutoff = np.array([estimate.value for estimate in cutoffs])
    bars = [[estimate.value - estimate.low, estimate.high - estimate.value] for estimate in cutoffs]
    label = f"{measure.CUTOFF_QUANTILE:.0%} quantile"
    axes.errorbar(n_blocks, cutoff, np.transpose(bars), fmt="o", color=style.BLUE, label=label)
    largest = [sample.values.max() for sample in samples.values()]
    axes.plot(n_blocks, largest, "^", color=style.GREY, label="largest")
    look = {"color": style.VERMILION, "label": rf"$\propto N^{{{growth.power.value:.2f}}}$"}
    axes.plot(growth.n_blocks, growth.line(growth.n_blocks), **look)
    axes.set_xticks(n_blocks, [f"{n:g}" for n in n_blocks])
    axes.minorticks_off()
    panels.plain_log(axes.yaxis)
    for text in axes.legend(loc="upper left").get_texts():
        if "propto" in text.get_text():
            marks.shown(text, "soc-cutoff", "energy: growth with N")
