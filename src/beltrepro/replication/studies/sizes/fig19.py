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
        "more gradual as blocks are added, here at the noise 1. a: the numbers of blocks whose "
        "transition regions the paper prints (black). Dots are independent runs from starts of "
        "their own, and lines their means where all lie on one branch. b: single runs of all "
        "numbers of blocks."
    ),
    alt=(
        "Two panels of r against belt velocity, a colour for each number of blocks: above, dots "
        "and lines for 5, 7 and 10 blocks under three black strips; below, marks for all."
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
                label = f"$N = {n_blocks}$"
                panels.single_runs(below, *points, label=label, overlay=overlay)
    for axes in (above, below):
        panels.finish_curves(axes, xlabel=panels.BELT_VELOCITY)
        axes.label_outer()
    _strips(above)
    above.set_xlim(left=0)
    return figure


def _index(n_blocks):
    """Number of the style of a number of blocks."""
    return ORDER.index(n_blocks) if n_blocks in ORDER else int(n_blocks)


def _runs(axes, data, n_blocks):
    for name in ("n5_replicates", "size_replicates"):
        row = sections.rows(data[name], n_blocks=n_blocks, noise=NOISE)
        points = row["belt_velocity"], row["disorder_parameter"], _index(n_blocks)
        replicate_panels.draw_runs(axes, *points, label=f"$N = {n_blocks}$")


def _strips(axes):
    """The printed regions as strips at the top."""
    axes.set_ylim(top=axes.get_ylim()[1] * 1.35)
    for place, n_blocks in enumerate(SHOWN):
        low, high = printed("transition-width")[str(n_blocks)]
        words = f"{'' if place else 'paper: '}$N = {n_blocks}$"
        panels.printed_range(axes, low, high, words, top=0.98 - 0.09 * place)
