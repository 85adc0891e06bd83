"""Fig. 15: r rises with noise."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(uses=("n5_columns",), number="15")

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
