"""Not in the paper: kicks, the steps of the scheme and noise that lose periodic orbits."""

import numpy as np
from matplotlib.ticker import NullFormatter

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(uses=("orbits_lost", "loss_lines"), category="Further studies")

_LOOKS = {  # marker, colour, and words of each disturbance
    "kick": ("o", style.BLUE, "kicks"),
    "step": ("s", style.VERMILION, "time step"),
    "noise": ("^", style.GREEN, "noise"),
}


@style.styled
def draw(data):
    """Sizes against the margin and against the slips of each orbit."""
    panels.require(data, FIGURE)
    figure = style.page(1.95)
    by_margin, by_slips = figure.subplots(1, 2, sharey=True)
    orbits, lines = data["orbits_lost"], data["loss_lines"].set_index("disturbance")
    for axes, name in ((by_margin, "margin"), (by_slips, "slips")):
        for kind in _LOOKS:
            _draw_sizes(axes, orbits, name, kind)
    margins = orbits["margin"][np.isfinite(orbits["margin"])]
    if margins.empty or "kick" not in lines.index:
        for axes in (by_margin, by_slips):
            panels.note(axes, "no orbits in this table")
    else:
        ends = np.array([margins.min() / 2, margins.max() * 2])
        by_margin.plot(ends, lines["share"]["kick"] * ends, color="0.5", linewidth=1, zorder=0)
        _scale(by_margin, by_slips)
    by_margin.set(xlabel="margin", ylabel="disturbance")
    by_slips.set(xlabel="slips in a period")
    by_margin.legend(loc="lower right", handletextpad=0.1, borderaxespad=0.1)
    panels.letters(by_margin, by_slips)
    return figure


def _draw_sizes(axes, orbits, name, kind):
    marker, colour, words = _LOOKS[kind]
    orbits = orbits[np.isfinite(orbits[kind]) & (orbits[kind] > 0)]
    worth = orbits["noise_as_kick"] if kind == "noise" else 1.0
    size, low, high = (worth * orbits[f"{kind}{end}"] for end in ("", "_low", "_high"))
    high = high.where(np.isfinite(high), size)
    look = {"fmt": marker, "color": colour, "markerfacecolor": "none", "label": words}
    look |= {"elinewidth": 0.4, "markersize": 2.4, "markeredgewidth": 0.6}
    panels.intervals(axes, orbits[name], size, low, high, **look)


def _scale(by_margin, by_slips):
    """Logarithmic axes with plain numbers, since powers are written smaller than the rest."""
    for axes in (by_margin, by_slips):
        axes.set(xscale="log", yscale="log")
    for axis in (by_margin.xaxis, by_margin.yaxis, by_slips.xaxis):
        axis.set_minor_formatter(NullFormatter())
    by_margin.set_xticks([1e-4, 1e-2, 1], ["0.0001", "0.01", "1"])
    by_margin.set_yticks([1e-5, 1e-3, 0.1], ["0.00001", "0.001", "0.1"])
    by_slips.set_xticks([10, 100, 1000], ["10", "100", "1000"])
