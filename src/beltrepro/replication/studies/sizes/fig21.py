"""Fig. 21: the rise of r with noise for several system sizes."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(
    title="Disorder parameter r against noise for several numbers of blocks.",
    uses=("size_columns",),
    words=(
        "The rise of r with noise for several numbers of blocks, each at the upper edge of its "
        "transition: it is less marked for longer chains. Dots are runs with random numbers of "
        "their own, with their mean and the middle 80 % of them."
    ),
    alt=(
        "Panels of r against noise, one for each number of blocks: dots of single runs, their "
        "mean and a band."
    ),
    number="21",
)


@style.styled
def draw(data):
    """r(sigma), a panel for each number of blocks (and belt velocity, if there are several)."""
    panels.require(data, FIGURE)
    arrays = data["size_columns"].arrays
    points = sorted(set(zip(arrays["n_blocks"], arrays["belt_velocity"], strict=True)))
    figure = style.page(4.6)
    places = {(n, u): f"$N = {n}$, $u = {u:g}$" for n, u in points}
    replicate_panels.against_noise(figure, data, "size_columns", places, across=2)
    return figure
