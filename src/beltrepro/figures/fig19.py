"""Fig. 19: the fall of r for several system sizes."""

from beltrepro.analysis import sections
from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Disorder parameter r(u) for several numbers of blocks.",
    uses=("n5_rows", "n5_rows_check", "size_rows", "size_rows_check"),
    words=(
        "The fall of r with belt velocity for several numbers of blocks: it moves up and becomes "
        "more gradual as blocks are added."
    ),
    alt="Curves of r against belt velocity, one for each number of blocks.",
    number="19",
)

NOISE = 1.0


@style.styled
def draw(data, caption):
    """r(u) at sigma = 1, a curve for each number of blocks."""
    panels.require(data, ENTRY)
    layers = [layer for name in ("size_rows", "n5_rows") for layer in panels.layers(data, name)]
    sizes = sorted({n for scan, _ in layers for n in panels.levels(scan, "n_blocks")})
    figure = style.page(caption, 4.2)
    axes = figure.subplots()
    for index, n_blocks in enumerate(sizes):
        for scan, overlay in layers:
            row = sections.rows(scan, n_blocks=n_blocks, noise=NOISE)
            panels.curve(
                axes,
                row["belt_velocity"],
                row["disorder_parameter"],
                index,
                label=f"$N = {n_blocks}$",
                overlay=overlay,
                linewidth=0.9,
            )
    panels.finish_curves(axes, xlabel=panels.BELT_VELOCITY)
    axes.set_title(rf"$\sigma = {NOISE:g}$", loc="right", size=8, color="0.35")
    axes.set_xlim(left=0)
    return figure
