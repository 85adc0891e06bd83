"""Fig. 18: map of the disorder parameter."""

import numpy as np

from beltrepro.analysis import intermittency, sections
from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Map of r over belt velocity and noise, with the boundary of intermittency.",
    uses=("n5_map",),
    words=(
        "The disorder parameter over belt velocity and noise, with the edge of the intermittent "
        "region, which ends above zero noise and widens at strong noise."
    ),
    alt=(
        "Colour map of r over belt velocity and noise, with a dotted outline of the intermittent "
        "region."
    ),
    number="18",
)


@style.styled
def draw(data, caption):
    """r over the plane (u, sigma) in colours; white dots: boundary of the intermittent region.

    The criterion of intermittency is that of `intermittency.intermittent_mask`.
    """
    panels.require(data, ENTRY)
    points = data["n5_map"].arrays
    points = sections.select(points, points["n_blocks"] == 5)
    figure = style.page(caption, 4.2)
    axes = figure.subplots()
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.NOISE)
    if not points["noise"].size:
        panels.note(axes, "no points in this scan")
        return figure
    velocities, noises, disorder = _table(points)
    image = axes.pcolormesh(
        _edges(velocities), _edges(noises), disorder, cmap="viridis", vmin=0, rasterized=True
    )
    figure.colorbar(image, ax=axes, pad=0.01, label=panels.DISORDER)
    _boundary(axes, points)
    return figure


def _boundary(axes, points):
    mask = intermittency.intermittent_mask(points)
    low, high = intermittency.LAMINAR_SHARE
    rule = f"laminar phases, at least {intermittency.MINIMUM_PHASES}, take {low:.0%} to {high:.0%}"
    if not mask.any():
        axes.set_title(f"no point is intermittent ({rule} of the time)", size=8, color="0.35")
        return
    levels, *edges = intermittency.boundary(points["belt_velocity"], points["noise"], mask)
    for edge in edges:
        axes.plot(
            edge,
            levels,
            "o",
            color="white",
            markersize=4,
            markeredgecolor="black",
            markeredgewidth=0.4,
            clip_on=False,
        )
    axes.set_title(f"dots: boundary of intermittency ({rule} of the time)", size=8, color="0.35")


def _table(points):
    """(u (U,), sigma (S,), r (S, U)): median over replicates, NaN where the map has no point."""
    velocities, column = np.unique(points["belt_velocity"], return_inverse=True)
    noises, line = np.unique(points["noise"], return_inverse=True)
    disorder = np.full((noises.size, velocities.size), np.nan)
    cell = line * velocities.size + column
    for place in np.unique(cell):
        disorder.flat[place] = np.median(points["disorder_parameter"][cell == place])
    return velocities, noises, disorder


def _edges(centres):
    """Borders of cells around grid values."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])
