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
    """a: v_N at the section against u, a colour for each noise; b: r(sigma) at u = 7."""
    panels.require(data, FIGURE)
    figure = style.page(4.2)
    above, below = figure.subplots(2, 1, height_ratios=(1.5, 1))
    panels.letter(above, "a")
    panels.letter(below, "b")
    levels = panels.levels(data["n5_rows"], "noise")
    # the weakest noise last: its few dots lie on the clouds of the others
    for noise, colour in reversed(list(zip(levels, style.shades(levels.size), strict=True))):
        row = sections.rows(data["n5_rows"], n_blocks=5, noise=noise)
        panels.band_diagram(above, row, colour=colour, size=1.3, label=rf"$\sigma = {noise:g}$")
    panels.finish_diagram(above)
    panels.legend_above(above, ncols=max(levels.size, 1), markerscale=7)
    if legend := above.get_legend():
        for handle in legend.legend_handles:
            handle.set_alpha(1)  # dots over each other in the panel are as dark
    above.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.VELOCITY)
    above.set_xlim(left=0)
    _column(below, data["n5_u7"])
    return figure


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
