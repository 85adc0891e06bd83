"""Fig. 13: the fall of r at several noise levels."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats import sections

FIGURE = Figure(
    uses=("n5_replicates", "n5_replicates_check", "n5_rows", "n5_rows_check"), number="13"
)

LEFT_OUT = (0.25, 0.5)  # levels at which nothing differs from those beside them


@style.styled
def draw(data):
    """a: r(u) of single runs of five blocks, for each noise; b: r of independent runs."""
    panels.require(data, FIGURE)
    figure = style.page(4.2)
    axes = figure.subplots(2, 1, sharey=True)
    noises = sorted({s for name in ("n5_replicates", "n5_rows") for s in _levels(data[name])})
    for panel, mark, name in zip(axes, "ab", ("n5_rows", "n5_replicates"), strict=True):
        panels.letter(panel, mark)
        for scan, _ in panels.layers(data, name):
            for noise in _levels(scan):
                row = sections.rows(scan, n_blocks=5, noise=noise)
                scheme = panels.METHODS["verlet"]
                overlay = scheme if (row["method"].astype(str) == "verlet").all() else ""
                points = row["belt_velocity"], row["disorder_parameter"]
                draw_row = _single_runs if mark == "a" else _replicates
                draw_row(panel, points, noise, noises.index(noise), overlay)
        panels.finish_curves(panel, xlabel=panels.BELT_VELOCITY)
    _printed(axes[0])
    axes[0].set_xlim(left=0)
    return figure


def _replicates(axes, points, noise, index, overlay):
    """Runs, and their means with noise; crosses for the paper's scheme."""
    colour = style.line_style(index)["color"]
    if overlay:
        replicate_panels.crosses(axes, *points, colour, overlay)
    else:
        # Without noise several branches coexist at most u.
        alone = {} if noise else {"linestyle": "none", "apart": 0.0}
        label = rf"$\sigma = {noise:g}$"
        replicate_panels.draw_runs(axes, *points, index, label=label, **alone)


def _single_runs(axes, points, noise, index, overlay):
    label = rf"$\sigma = {noise:g}$"
    panels.single_runs(axes, *points, index, label=label, overlay=overlay)


def _printed(axes):
    """Critical velocities of the paper."""
    axes.set_ylim(top=1.15 * axes.get_ylim()[1])
    place = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "va": "center"}
    for velocity, words, side in (
        (printed("u-critical"), r"paper: $u_c$ at $\sigma = 0$", "right"),
        (printed("uc-sigma22")["u_c"], r"at $\sigma = 2.2$", "left"),
    ):
        look = {"color": style.BLACK, "markersize": 7, "markeredgewidth": 1.4}
        axes.plot(velocity, 0.94, "|", transform=axes.get_xaxis_transform(), **look)
        shift = (-4 if side == "right" else 4), 0
        axes.annotate(words, (velocity, 0.94), xytext=shift, ha=side, **place)


def _levels(scan):
    return [noise for noise in panels.levels(scan, "noise") if noise not in LEFT_OUT]
