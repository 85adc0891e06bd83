"""Fig. 19: the fall of r for several system sizes."""

import numpy as np

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats import sections

FIGURE = Figure(
    uses=(
        "critical_velocities",
        "n5_replicates",
        "size_replicates",
        "n5_rows",
        "n5_rows_check",
        "size_rows",
        "size_rows_check",
    ),
    number="19",
)

NOISE = 1.0
SHOWN = (5, 7, 10)
ORDER = (5, 7, 10, 2, 3, 4, 6)  # numbers of blocks in the order of the styles


@style.styled
def draw(data):
    """a: r(u) at sigma = 1 over replicates for N = 5, 7, 10; b: single runs for every N."""
    panels.require(data, FIGURE)
    figure = style.page(4.4)
    above, below = figure.subplots(2, 1, sharex=True)
    panels.letter(above, "a")
    panels.letter(below, "b")
    for n_blocks in SHOWN:
        _runs(above, data, n_blocks)
    for name in ("n5_rows", "size_rows"):
        for scan, overlay in panels.layers(data, name):
            for n_blocks in panels.levels(scan, "n_blocks"):
                row = sections.rows(scan, n_blocks=n_blocks, noise=NOISE)
                points = row["belt_velocity"], row["disorder_parameter"], _index(n_blocks)
                look = {"label": f"$N = {n_blocks}$"}
                if overlay:
                    look = {
                        "overlay": f"$N = {n_blocks}$, {overlay}",
                        "color": style.line_style(_index(n_blocks))["color"],
                    }
                panels.single_runs(below, *points, **look)
    for axes in (above, below):
        panels.finish_curves(axes, xlabel=panels.BELT_VELOCITY)
        axes.label_outer()
    _strips(above, data["critical_velocities"])
    above.set_xlim(left=0)
    return figure


def _index(n_blocks):
    """Number of the style of a number of blocks."""
    return ORDER.index(n_blocks) if n_blocks in ORDER else int(n_blocks)


def _runs(axes, data, n_blocks):
    """Runs of a number of blocks and the line of their means."""
    for name in ("n5_replicates", "size_replicates"):
        row = sections.rows(data[name], n_blocks=n_blocks, noise=NOISE)
        points = row["belt_velocity"], row["disorder_parameter"], _index(n_blocks)
        replicate_panels.draw_runs(axes, *points, label=f"$N = {n_blocks}$")


def _strips(axes, table):
    """The printed regions as strips at the top; below each the middle of the fall that we find."""
    axes.set_ylim(top=axes.get_ylim()[1] * 1.5)
    in_scans = table["dataset"].isin(["n5_replicates", "size_replicates"])
    table = table[in_scans & (table["noise"] == NOISE) & table["critical"].notna()]
    for place, n_blocks in enumerate(SHOWN):
        low, high = printed("transition-width")[str(n_blocks)]
        words = f"{'' if place else 'paper: '}$N = {n_blocks}$"
        top = 0.98 - 0.11 * place
        panels.printed_range(axes, low, high, words, top=top)
        for row in table[table["n_blocks"] == n_blocks].itertuples():
            reach = [[row.critical - row.low], [row.high - row.critical]]
            look = style.line_style(_index(n_blocks)) | {"markersize": 3, "linestyle": "none"}
            look |= {"capsize": 1.5, "elinewidth": 0.8, "transform": axes.get_xaxis_transform()}
            axes.errorbar([row.critical], [top - 0.06], xerr=np.nan_to_num(reach), **look)
