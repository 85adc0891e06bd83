"""Fig. 13: the fall of r at several noise levels."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats import sections

FIGURE = Figure(
    title="Disorder parameter r(u) for several noise strengths.",
    uses=("n5_replicates", "n5_replicates_check", "n5_rows", "n5_rows_check"),
    words=(
        "The fall of r with belt velocity for several noise levels: little changes at weak noise;"
        " stronger noise moves the fall to higher velocities and makes it gradual. a: independent "
        "runs from starts of their own, means and the middle 80 % of them; without noise a dot for "
        "each, and crosses for the means by the scheme of the paper. b: single runs over "
        "the whole range, as the paper shows them: without noise a run ends on one of several "
        "attractors, and beyond u = 37 on those of large amplitude again."
    ),
    alt=(
        "Two panels of r against belt velocity, a colour for each noise level: above, lines with "
        "bands about the fall; below, dots of single runs over all velocities."
    ),
    number="13",
)

LEFT_OUT = (0.25, 0.5)  # levels at which nothing differs from those beside them


@style.styled
def draw(data):
    """a: r(u) of five blocks over replicates, for each noise; b: r of single runs."""
    panels.require(data, FIGURE)
    figure = style.page(5.6)
    axes = figure.subplots(2, 1, sharey=True)
    noises = sorted({s for name in ("n5_replicates", "n5_rows") for s in _levels(data[name])})
    for panel, mark, name in zip(axes, "ab", ("n5_replicates", "n5_rows"), strict=True):
        panels.letter(panel, mark)
        for scan, overlay in panels.layers(data, name):
            for noise in _levels(scan):
                row = sections.rows(scan, n_blocks=5, noise=noise)
                points = row["belt_velocity"], row["disorder_parameter"]
                draw_row = _replicates if mark == "a" else _single_runs
                draw_row(panel, points, noise, noises.index(noise), overlay)
        panels.finish_curves(panel, xlabel=panels.BELT_VELOCITY)
    panels.remark(axes[0], rf"{replicate_panels.WORDS}; dots: runs at $\sigma = 0$")
    panels.remark(axes[1], "single runs")
    axes[1].set_xlim(left=0)
    return figure


def _replicates(axes, points, noise, index, overlay):
    """Without noise runs end on attractors that are far apart: each is drawn, and no band."""
    colour = style.line_style(index)["color"]
    if overlay:
        replicate_panels.crosses(axes, *points, colour, overlay)
    else:
        apart = {"runs": colour, "band": False} if noise == 0 else {}
        label = rf"$\sigma = {noise:g}$"
        replicate_panels.band(axes, *points, index, label=label, **apart)


def _single_runs(axes, points, noise, index, overlay):
    label = rf"$\sigma = {noise:g}$"
    panels.curve(axes, *points, index, label=label, overlay=overlay, linestyle="none")


def _levels(scan):
    return [noise for noise in panels.levels(scan, "noise") if noise not in LEFT_OUT]
