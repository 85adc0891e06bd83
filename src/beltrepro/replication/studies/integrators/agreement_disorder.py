"""Comparison of integrators: the disorder parameter with noise."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.integrators import measure, samples

FIGURE = Figure(
    uses=("pairs_r_verlet", "pairs_r_event", "agreement"), category="Integrators compared"
)


@style.styled
def draw(data):
    """a: mean r of both against u; b: difference in standard errors; c: p-values in order."""
    panels.require(data, FIGURE)
    table = data["agreement"]
    rows = table[table["quantity"] == measure.DISORDER]
    figure = style.page(3.8)
    left, middle, right = figure.subplot_mosaic([["a", "a"], ["b", "c"]]).values()
    panels.letters(left, middle, right)
    curves = rows.groupby(["n_blocks", "noise"])
    for index, ((_, noise), curve) in enumerate(curves):
        _curve(left, middle, curve, index, rf"$\sigma = {noise:g}$")
    left.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.DISORDER)
    left.set_ylim(bottom=0)
    middle.set(xlabel=panels.BELT_VELOCITY, ylabel="difference / standard error")
    _limits(middle, len(rows))
    _p_values(right, rows)
    if len(rows):
        panels.legend_above(left, ncols=len(curves))
    return figure


def _curve(left, middle, rows, index, label):
    velocity, look = rows["belt_velocity"], style.line_style(index)
    left.plot(velocity, rows["mean_reference"], color=look["color"], linewidth=0.9)
    bars = {"fmt": "x", "color": look["color"], "markersize": 4, "elinewidth": 0.8}
    left.errorbar(velocity, rows["mean_tested"], rows["error_tested"], label=label, **bars)
    marks = {"marker": look["marker"], "markersize": 3.5, "linestyle": "none"}
    middle.plot(velocity, rows["z"], color=look["color"], **marks)


def _limits(axes, count):
    axes.axhspan(-2, 2, color="0.92", linewidth=0, zorder=0)
    if not count:
        panels.note(axes, "no point by both integrators")
        return
    limit = samples.largest_of(count)
    for side in (-limit, limit):
        axes.axhline(side, color=style.GREY, linewidth=0.8, linestyle="--")
    axes.set_ylim(-1.35 * limit, 1.35 * limit)


def _p_values(axes, rows):
    axes.plot([0, 1], [0, 1], color=style.GREY, linewidth=0.8)
    for name, label, marker in (("p", "distributions", "o"), ("mean_p", "means", "x")):
        values = np.sort(rows[name].dropna())
        if values.size:
            share = (np.arange(values.size) + 0.5) / values.size
            axes.plot(share, values, marker, markersize=3.5, label=label)
    axes.set(xlabel="expected in order", ylabel="p-value")
    panels.legend_above(axes, ncols=1)
