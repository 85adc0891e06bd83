"""Fig. 22: bifurcation diagrams of other system sizes."""

from beltrepro.analysis import sections
from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Bifurcation diagrams for 2, 3, 4, 6, 7 and 10 blocks.",
    uses=("size_rows",),
    words=(
        "Bifurcation diagrams for two to ten blocks: regular lines up to four blocks, broad "
        "chaotic bands from five on, with fewer windows and less effect of noise as blocks are "
        "added."
    ),
    alt=(
        "Six bifurcation diagrams, for 2, 3, 4, 6, 7 and 10 blocks, with points of several noise "
        "levels."
    ),
    number="22",
)

SIZES = (2, 3, 4, 6, 7, 10)
# Strong noise first: what covers most lies below.
COLOURS = (style.BLACK, style.VERMILION, style.SKY)


@style.styled
def draw(data, caption):
    """v_N at the section against u, a panel for each N, a colour for each noise level."""
    panels.require(data, ENTRY)
    scan = data["size_rows"]
    noises = panels.levels(scan, "noise")[: len(COLOURS)]
    figure = style.page(caption, 5.2)
    grid = figure.subplots(2, 3, sharex=True)
    for axes, mark, n_blocks in zip(grid.flat, "abcdef", SIZES, strict=True):
        panels.letter(axes, mark)
        for noise, colour in reversed(list(zip(noises, COLOURS, strict=False))):
            row = sections.rows(scan, n_blocks=n_blocks, noise=noise)
            panels.band_diagram(axes, row, colour=colour, size=1.3, label=rf"$\sigma = {noise:g}$")
        axes.set_title(f"$N = {n_blocks}$  {panels.section_name(row)}", size=8)
        panels.finish_diagram(axes)
    grid[0, 0].set_xlim(left=0)
    panels.dot_legend(figure, grid[0, 0])
    for axes in grid[-1]:
        axes.set_xlabel(panels.BELT_VELOCITY)
    for axes in grid[:, 0]:
        axes.set_ylabel(panels.VELOCITY)
    return figure
