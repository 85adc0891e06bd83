"""Fig. 15: r rises with noise."""

from beltrepro.analysis import sections
from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Disorder parameter r against noise for u from 20 on.",
    uses=("n5_columns",),
    words=(
        "At belt velocities of 20 and more, r rises with noise: steeply at 20, later and more "
        "gradually at higher velocities."
    ),
    alt="Curves of r against noise, one for each belt velocity.",
    number="15",
)

GUIDE = 5.0  # a line at this sigma, only to guide the eye


@style.styled
def draw(data, caption):
    """r(sigma) of five blocks, a curve for each belt velocity."""
    panels.require(data, ENTRY)
    figure = style.page(caption, 4.0)
    axes = figure.subplots()
    for scan, overlay in panels.layers(data, "n5_columns"):
        for index, velocity in enumerate(panels.levels(data["n5_columns"], "belt_velocity")):
            column = sections.columns(scan, n_blocks=5, belt_velocity=velocity)
            panels.curve(
                axes,
                column["noise"],
                column["disorder_parameter"],
                index,
                label=f"$u = {velocity:g}$",
                overlay=overlay,
                markersize=3.5,
            )
    panels.finish_curves(axes, xlabel=panels.NOISE)
    axes.axvline(GUIDE, color="0.6", linewidth=0.8, linestyle="--", zorder=0)
    return figure
