"""Fig. 15: r rises with noise."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(
    title="Disorder parameter r against noise for u from 20 on.",
    uses=("n5_columns",),
    words=(
        "At belt velocities of 20 and more, r rises with noise: steeply at 20, later and more "
        "gradually at higher velocities. Dots are runs with random numbers of their own, with "
        "their mean and the middle 80 % of them: where runs are short they lie on two branches."
    ),
    alt=(
        "Panels of r against noise, one for each belt velocity: dots of single runs, their mean "
        "and a band."
    ),
    number="15",
)

GUIDE = 5.0  # a line at this sigma, only to guide the eye


@style.styled
def draw(data):
    """r(sigma) of five blocks, a panel for each belt velocity."""
    panels.require(data, FIGURE)
    velocities = panels.levels(data["n5_columns"], "belt_velocity")
    figure = style.page(4.6)
    places = {(5, u): f"$u = {u:g}$" for u in velocities}
    for axes in replicate_panels.against_noise(figure, data, "n5_columns", places, across=3):
        axes.axvline(GUIDE, color="0.6", linewidth=0.8, linestyle="--", zorder=0)
    return figure
