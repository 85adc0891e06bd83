"""Fig. 22: bifurcation diagrams of other system sizes."""

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats import sections

FIGURE = Figure(uses=("size_rows",), number="22")

SIZES = (2, 3, 4, 6, 7, 10)
MOST_NOISES = 3
_ASIDE = 0.32  # of u, by which the columns of the noises lie beside each other


@style.styled
def draw(data):
    """v_N at the section against u, a panel for each N, a colour for each noise."""
    panels.require(data, FIGURE)
    scan = data["size_rows"]
    noises = panels.levels(scan, "noise")[:MOST_NOISES]
    figure = style.page(5.2)
    grid = figure.subplots(3, 2, sharex=True, sharey=True)
    for axes, mark, n_blocks in zip(grid.flat, "abcdef", SIZES, strict=True):
        panels.letter(axes, mark)
        for number, (noise, colour) in enumerate(
            zip(noises, style.shades(noises.size), strict=True)
        ):
            row = sections.rows(scan, n_blocks=n_blocks, noise=noise)
            look = {"colour": colour, "size": 1.6, "label": rf"$\sigma = {noise:g}$"}
            panels.band_diagram(axes, row, aside=_ASIDE * (number - (noises.size - 1) / 2), **look)
        panels.finish_diagram(axes)
        place = panels.section_name(row).removeprefix("section ") if noises.size else ""
        axes.set_title(f"$N = {n_blocks}$, {place}", loc="right")
        axes.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.VELOCITY)
        axes.label_outer()
    grid[0, 0].set_xlim(left=0)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), markerscale=4)
    return figure
