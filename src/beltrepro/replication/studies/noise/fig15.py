"""Fig. 15: r rises with noise."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(
    title="Disorder parameter r against noise for u from 20 on.",
    uses=("n5_columns",),
    words=(
        "At belt velocities of 20 and more, r rises with noise: steeply at 20, and at higher "
        "velocities more gradually, its middle at stronger noise. a: one run at each point, as in "
        "the paper; the dashed line guides the eye there too. Below: all runs with random numbers "
        "of their own, a small mark each, and their mean where they lie on one branch. At weak "
        "noise they end on several."
    ),
    alt=(
        "A panel of r against noise with marks for each belt velocity, and below it a panel for "
        "each belt velocity: dots of single runs and a line where they agree."
    ),
    number="15",
)

GUIDE = 5.0  # a line at this sigma, only to guide the eye


@style.styled
def draw(data):
    """r(sigma) of five blocks: a run at each point, and all runs, a panel for each u."""
    panels.require(data, FIGURE)
    velocities = panels.levels(data["n5_columns"], "belt_velocity")
    figure = style.page(4.6)
    places = {(5, u): f"$u = {u:g}$" for u in velocities}
    for axes in replicate_panels.against_noise(figure, data, "n5_columns", places, across=3):
        axes.axvline(GUIDE, color=style.BLACK, linewidth=0.6, linestyle="--", zorder=0)
    return figure
