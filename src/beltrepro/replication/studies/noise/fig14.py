"""Fig. 14: periodic windows and noise."""

import math

import numpy as np

from beltrepro.replication.drawing import marks, panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.noise import measure
from beltrepro.stats import sections

FIGURE = Figure(
    title="Bifurcation diagrams with noise, and r against noise at u = 7.",
    uses=("n5_rows", "n5_u7"),
    words=(
        "Bifurcation diagrams at several noise levels: the periodic windows wash out. At u = 7, "
        "inside a window, r jumps up at some noise level."
    ),
    alt=(
        "Several bifurcation diagrams for rising noise, and a last panel with r against noise at "
        "u = 7."
    ),
    number="14",
    shows={"sigma-c-u7": ("sigma_c",)},
)

BELT_VELOCITY = 7.0
ROWS, MOST_COLUMNS = 2, 4


@style.styled
def draw(data):
    """v_N at the section against u, a panel for each noise level; last panel: r(sigma) at u = 7.

    That panel is the paper's inset: beside the diagrams it covers no points.
    """
    panels.require(data, FIGURE)
    levels = panels.levels(data["n5_rows"], "noise")[: ROWS * MOST_COLUMNS - 1]
    columns = max(2, math.ceil((len(levels) + 1) / ROWS))
    figure = style.page(5.0)
    grid = [figure.add_subplot(ROWS, columns, 1)]
    for place in range(2, ROWS * columns):
        grid.append(figure.add_subplot(ROWS, columns, place, sharex=grid[0], sharey=grid[0]))
    for axes, noise in zip(grid, levels, strict=False):
        axes.set_title(rf"$\sigma = {noise:g}$")
        panels.band_diagram(axes, sections.rows(data["n5_rows"], n_blocks=5, noise=noise), size=1.3)
        panels.finish_diagram(axes, width=14)
    for axes in grid[len(levels) :]:
        panels.note(axes, "no further noise level in this scan", width=14)
    grid[0].set_xlim(left=0)
    for axes in grid:
        axes.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.VELOCITY)
        axes.label_outer()
    _column(figure.add_subplot(ROWS, columns, ROWS * columns), data["n5_u7"])
    return figure


def _column(axes, scan):
    """r(sigma) at one belt velocity, with the noise at which it rises."""
    column = sections.columns(scan, n_blocks=5, belt_velocity=BELT_VELOCITY)
    noise, disorder = column["noise"], column["disorder_parameter"]
    replicate_panels.band(axes, noise, disorder, 1, runs=style.BLACK, linewidth=0.8, linestyle="-")
    panels.finish_curves(axes, xlabel=panels.NOISE, width=14)
    axes.set_title(f"$u = {BELT_VELOCITY:g}$")
    axes.yaxis.set_label_position("right")
    axes.yaxis.tick_right()
    axes.yaxis.set_ticks_position("both")
    axes.tick_params(labelleft=False, labelright=True)
    for spine in axes.spines.values():
        spine.set_color(style.VERMILION)
    with panels.shortage_on(axes, place=(0.5, 0.25), width=14):
        critical = measure.rise(noise, disorder)["critical"].value
        if np.isfinite(critical):
            line = axes.axvline(critical, color="0.4", linewidth=0.8, linestyle="--", zorder=0)
            words = axes.set_title(rf"$u = {BELT_VELOCITY:g}$: $\sigma_c = {critical:.2f}$")
            marks.shown(line, "sigma-c-u7", "sigma_c")
            marks.shown(words, "sigma-c-u7", "sigma_c")
