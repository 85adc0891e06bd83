"""Fig. 14: periodic windows and noise."""

import numpy as np

from beltrepro.replication.drawing import marks, panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.noise import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats import sections

FIGURE = Figure(uses=("n5_rows", "n5_u7"), number="14", shows={"sigma-c-u7": ("sigma_c",)})

BELT_VELOCITY = 7.0


@style.styled
def draw(data):
    """a: v_N at the section against u, a strip for each noise; b: r(sigma) at u = 7."""
    panels.require(data, FIGURE)
    figure = style.page(6.4)
    upper, lower = figure.add_gridspec(2, 1, height_ratios=(2.2, 1))
    _strips(upper, data["n5_rows"])
    below = figure.add_subplot(lower)
    panels.letter(below, "b")
    _column(below, data["n5_u7"])
    return figure


def _strips(place, scan):
    """Bifurcation diagrams below each other, the weakest noise at the top."""
    levels = panels.levels(scan, "noise")
    rows = place.subgridspec(max(levels.size, 1), 1)
    strips = rows.subplots(sharex=True, sharey=True, squeeze=False)[:, 0]
    panels.letter(strips[0], "a")
    for axes, noise in zip(strips, levels, strict=False):
        row = sections.rows(scan, n_blocks=5, noise=noise)
        panels.band_diagram(axes, row, size=1.3)
        panels.finish_diagram(axes)
        panels.remark(axes, rf"$\sigma = {noise:g}$")
        axes.set_ylabel(panels.VELOCITY)
    strips[-1].set(xlabel=panels.BELT_VELOCITY, xlim=(0, None))


def _column(axes, scan):
    """r(sigma) at one belt velocity, with the noise at which it rises, here and in the paper."""
    column = sections.columns(scan, n_blocks=5, belt_velocity=BELT_VELOCITY)
    noise, disorder = column["noise"], column["disorder_parameter"]
    replicate_panels.draw_runs(axes, noise, disorder, 0)
    panels.finish_curves(axes, xlabel=panels.NOISE)
    words, critical = f"$u = {BELT_VELOCITY:g}$", np.nan
    with panels.shortage_on(axes, place=(0.5, 0.25)):
        critical = measure.rise(noise, disorder)["critical"].value
        if np.isfinite(critical):
            line = axes.axvline(critical, color=style.VERMILION, linestyle="--", zorder=0)
            words += rf": $\sigma_c = {critical:.2f}$"
            marks.shown(line, "sigma-c-u7", "sigma_c")
    value = printed("sigma-c-u7")
    axes.axvline(value, color=style.BLACK, linestyle=":", zorder=0)
    text = panels.remark(axes, f"{words} (dashed), paper: {value} (dotted)")
    if np.isfinite(critical):
        marks.shown(text, "sigma-c-u7", "sigma_c")
