"""Fig. 22: bifurcation diagrams of other system sizes."""

from beltrepro.replication.drawing import motion_panels as motions
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats import sections

FIGURE = Figure(
    title="Bifurcation diagrams and largest exponents for 2, 3, 4, 6, 7 and 10 blocks.",
    uses=("size_rows", "motion_map"),
    words=(
        "Bifurcation diagrams for two to ten blocks, a row of panels for each noise: regular lines "
        "up to four blocks, broad bands from five on, with fewer windows and less effect of noise "
        "as blocks are added. The paper draws the noises over each other. Last row, not in the "
        "paper: the largest Lyapunov exponent of the exact motion without noise, coloured by the "
        "motion in which a run ends."
    ),
    alt=(
        "Panels in six columns for 2, 3, 4, 6, 7 and 10 blocks: bifurcation diagrams, a row for "
        "each noise, and below them the largest exponents against belt velocity."
    ),
    number="22",
)

SIZES = (2, 3, 4, 6, 7, 10)
COLOURS = (style.BLACK, style.VERMILION, style.BLUE)  # of the noises, rising


@style.styled
def draw(data):
    """v_N at the section, a column for each N and a row for each noise; below, the exponents."""
    panels.require(data, FIGURE)
    scan = data["size_rows"]
    noises = panels.levels(scan, "noise")[: len(COLOURS)]
    figure = style.page(7.0)
    heights = [1] * len(noises) + [0.8]
    grid = figure.subplots(
        len(heights), len(SIZES), sharex=True, sharey="row", height_ratios=heights
    )
    for line, (noise, colour) in enumerate(zip(noises, COLOURS, strict=False)):
        for axes, n_blocks in zip(grid[line], SIZES, strict=True):
            row = sections.rows(scan, n_blocks=n_blocks, noise=noise)
            panels.band_diagram(axes, row, colour=colour, size=1.6)
            panels.finish_diagram(axes, width=10)
        grid[line, 0].set_ylabel(rf"{panels.VELOCITY},  $\sigma = {noise:g}$")
    for axes, mark, n_blocks in zip(grid[0], "abcdef", SIZES, strict=True):
        panels.letter(axes, mark)
        row = sections.rows(scan, n_blocks=n_blocks, noise=noises[0])
        axes.set_title(f"$N = {n_blocks}$\n{_section(row)}", size=8)
    for axes, n_blocks in zip(grid[-1], SIZES, strict=True):
        motions.exponents(axes, data["motion_map"], n_blocks, size=2.4)
        axes.set_xlabel(panels.BELT_VELOCITY)
    grid[-1, 0].set_ylim(*motions.limits(data["motion_map"], SIZES))
    grid[-1, 0].set_ylabel(rf"{motions.EXPONENT},  $\sigma = 0$")
    grid[0, 0].set_xlim(left=0)
    motions.legend(figure, grid[-1], loc="outside upper left")
    figure.align_ylabels(grid[:, 0])
    return figure


def _section(row):
    return panels.section_name(row).removeprefix("section ")
