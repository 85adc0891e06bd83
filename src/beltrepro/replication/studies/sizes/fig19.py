"""Fig. 19: the fall of r for several system sizes."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats import sections

FIGURE = Figure(
    title="Disorder parameter r(u) for several numbers of blocks.",
    uses=(
        "n5_replicates",
        "size_replicates",
        "n5_rows",
        "n5_rows_check",
        "size_rows",
        "size_rows_check",
    ),
    words=(
        "The fall of r with belt velocity for several numbers of blocks: it moves up and becomes "
        "more gradual as blocks are added. a: independent runs from starts of their own, mean "
        "and the middle 80 % of them; the strips at the top are the transition regions that the "
        "paper prints. b: single runs of all numbers of blocks."
    ),
    alt=(
        "Two panels of r against belt velocity, a colour for each number of blocks: above, lines "
        "with bands for 5, 7 and 10 blocks under three coloured strips; below, dots for all."
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
    figure = style.page(5.6)
    above, below = figure.subplots(2, 1, sharex=True)
    panels.letter(above, "a")
    panels.letter(below, "b")
    for n_blocks in SHOWN:
        _band(above, data, n_blocks)
    for name in ("n5_rows", "size_rows"):
        for scan, overlay in panels.layers(data, name):
            for n_blocks in panels.levels(scan, "n_blocks"):
                row = sections.rows(scan, n_blocks=n_blocks, noise=NOISE)
                points = row["belt_velocity"], row["disorder_parameter"], _index(n_blocks)
                label = f"$N = {n_blocks}$"
                panels.curve(below, *points, label=label, overlay=overlay, linestyle="none")
    for axes in (above, below):
        panels.finish_curves(axes, xlabel=panels.BELT_VELOCITY)
        axes.label_outer()
    _strips(above)
    words = rf"$\sigma = {NOISE:g}$"
    panels.remark(above, f"{words}; {replicate_panels.WORDS}; strips: regions in the paper")
    panels.remark(below, f"{words}; single runs")
    above.set_xlim(left=0)
    return figure


def _index(n_blocks):
    """Number of the style of a number of blocks."""
    return ORDER.index(n_blocks) if n_blocks in ORDER else int(n_blocks)


def _band(axes, data, n_blocks):
    for name in ("n5_replicates", "size_replicates"):
        row = sections.rows(data[name], n_blocks=n_blocks, noise=NOISE)
        points = row["belt_velocity"], row["disorder_parameter"], _index(n_blocks)
        replicate_panels.band(axes, *points, label=f"$N = {n_blocks}$", linestyle="-")


def _strips(axes):
    """The printed regions as strips at the top, in the colours of the curves."""
    axes.set_ylim(top=axes.get_ylim()[1] * 1.2)
    for place, n_blocks in enumerate(SHOWN):
        low, high = printed("transition-width")[str(n_blocks)]
        top = 0.97 - 0.045 * place
        colour = style.line_style(_index(n_blocks))["color"]
        axes.axvspan(low, high, top - 0.03, top, color=colour, linewidth=0)
