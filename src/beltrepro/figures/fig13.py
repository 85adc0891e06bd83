"""Fig. 13: the fall of r at several noise levels."""

from beltrepro.analysis import sections
from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Disorder parameter r(u) for several noise strengths.",
    uses=("n5_rows", "n5_rows_check"),
    words=(
        "The fall of r with belt velocity for several noise levels: little changes at weak noise;"
        " stronger noise moves the fall to higher velocities and makes it gradual."
    ),
    alt="Curves of r against belt velocity, one for each noise level.",
    number="13",
)


@style.styled
def draw(data, caption):
    """r(u) of five blocks, a curve for each noise level."""
    panels.require(data, ENTRY)
    figure = style.page(caption, 4.2)
    axes = figure.subplots()
    for scan, overlay in panels.layers(data, "n5_rows"):
        for index, noise in enumerate(panels.levels(data["n5_rows"], "noise")):
            row = sections.rows(scan, n_blocks=5, noise=noise)
            panels.curve(
                axes,
                row["belt_velocity"],
                row["disorder_parameter"],
                index,
                label=rf"$\sigma = {noise:g}$",
                overlay=overlay,
                linewidth=0.9,
            )
    panels.finish_curves(axes, xlabel=panels.BELT_VELOCITY)
    axes.set_xlim(left=0)
    return figure
