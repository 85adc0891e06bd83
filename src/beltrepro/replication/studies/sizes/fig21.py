"""Fig. 21: the rise of r with noise for several system sizes."""

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure

FIGURE = Figure(
    title="Disorder parameter r against noise for several numbers of blocks.",
    uses=("size_columns",),
    words=(
        "Noise raises r tenfold at five blocks (b). At seven (d) the rise is smaller and drawn "
        "out, and at ten (e) most runs have the larger r already without noise. Six blocks (c) do "
        "not rise, because their r has not yet fallen at this belt velocity. a: one run at each "
        "point, as in the paper, where chance hides much of this. b to e: all runs with random "
        "numbers of their own, a small mark each, and their mean where they lie on one branch."
    ),
    alt=(
        "A panel of r against noise with marks for each number of blocks, and below it a panel for "
        "each: dots of single runs and a line where they agree."
    ),
    number="21",
)


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
