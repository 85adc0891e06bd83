"""Fig. 21: the rise of r with noise for several system sizes."""

from beltrepro.analysis import sections
from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Disorder parameter r against noise for several numbers of blocks.",
    uses=("size_columns",),
    words=(
        "The rise of r with noise for several numbers of blocks, each at the upper edge of its "
        "transition: it is less marked for longer chains."
    ),
    alt="Curves of r against noise, one for each number of blocks.",
    number="21",
)


@style.styled
def draw(data, caption):
    """r(sigma), a curve for each number of blocks (and belt velocity, if there are several)."""
    panels.require(data, ENTRY)
    sizes = panels.levels(data["size_columns"], "n_blocks")
    figure = style.page(caption, 4.0)
    axes = figure.subplots()
    for scan, overlay in panels.layers(data, "size_columns"):
        for index, n_blocks in enumerate(sizes):
            of_size = sections.select(scan.arrays, scan.arrays["n_blocks"] == n_blocks)
            for velocity in sorted(set(of_size["belt_velocity"])):
                column = sections.columns(scan, n_blocks=n_blocks, belt_velocity=velocity)
                panels.curve(
                    axes,
                    column["noise"],
                    column["disorder_parameter"],
                    index,
                    label=f"$N = {n_blocks}$, $u = {velocity:g}$",
                    overlay=overlay,
                    markersize=3.5,
                )
    panels.finish_curves(axes, xlabel=panels.NOISE)
    return figure
