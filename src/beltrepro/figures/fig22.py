"""Fig. 22: bifurcation diagrams of other system sizes."""

from beltrepro.analysis import sections
from beltrepro.figures import motions, panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Bifurcation diagrams and largest exponents for 2, 3, 4, 6, 7 and 10 blocks.",
    uses=("size_rows", "motion_map"),
    words=(
        "Bifurcation diagrams for two to ten blocks: regular lines up to four blocks, broad "
        "bands from five on, with fewer windows and less effect of noise as blocks are added. "
        "Below each, not in the paper: the largest Lyapunov exponent of the exact motion without "
        "noise, coloured by the motion in which a run ends."
    ),
    alt=(
        "Twelve panels: bifurcation diagrams for 2, 3, 4, 6, 7 and 10 blocks, with points of "
        "several noise levels, and below each the largest exponents against belt velocity."
    ),
    number="22",
)

SIZES = (2, 3, 4, 6, 7, 10)
# Strong noise first: what covers most lies below.
COLOURS = (style.BLACK, style.VERMILION, style.SKY)


@style.styled
def draw(data, caption):
    """For each N: v_N at the section, a colour for each noise, and the largest exponent."""
    panels.require(data, ENTRY)
    scan = data["size_rows"]
    noises = panels.levels(scan, "noise")[: len(COLOURS)]
    figure = style.page(caption, 7.0)
    grid = figure.subplots(4, 3, sharex=True, height_ratios=(1, 0.55, 1, 0.55))
    above, below = grid[::2].ravel(), grid[1::2].ravel()
    for axes, under, mark, n_blocks in zip(above, below, "abcdef", SIZES, strict=True):
        panels.letter(axes, mark)
        for noise, colour in reversed(list(zip(noises, COLOURS, strict=False))):
            row = sections.rows(scan, n_blocks=n_blocks, noise=noise)
            panels.band_diagram(axes, row, colour=colour, size=1.3, label=rf"$\sigma = {noise:g}$")
        axes.set_title(f"$N = {n_blocks}$  {panels.section_name(row)}", size=8)
        panels.finish_diagram(axes)
        motions.exponents(under, data["motion_map"], n_blocks, size=1.8)
    grid[0, 0].set_xlim(left=0)
    panels.dot_legend(figure, grid[0, 0])
    motions.legend(figure, below, loc="outside upper left")
    figure.align_ylabels(grid[:, 0])
    for axes in grid[-1]:
        axes.set_xlabel(panels.BELT_VELOCITY)
    for axes, label in zip(grid[:, 0], 2 * (panels.VELOCITY, motions.EXPONENT), strict=True):
        axes.set_ylabel(label)
    return figure
