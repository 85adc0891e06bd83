"""Fig. 21: the rise of r with noise for several system sizes."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(uses=("size_columns",), number="21")


@style.styled
def draw(data):
    """r(sigma): a run at each point, and all runs, a panel for each number of blocks and u."""
    panels.require(data, FIGURE)
    arrays = data["size_columns"].arrays
    points = sorted(set(zip(arrays["n_blocks"], arrays["belt_velocity"], strict=True)))
    figure = style.page(4.6)
    places = {(n, u): f"$N = {n}$, $u = {u:g}$" for n, u in points}
    replicate_panels.against_noise(figure, data, "size_columns", places, across=2)
    return figure
