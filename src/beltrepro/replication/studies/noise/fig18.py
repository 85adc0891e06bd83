"""Fig. 18: map of the disorder parameter."""

import numpy as np
from matplotlib.colors import BoundaryNorm

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.noise import measure
from beltrepro.stats import intermittency, sections

FIGURE = Figure(
    title="Map of r over belt velocity and noise, with the points of intermittency.",
    uses=("n5_map", "n5_replicates"),
    words=(
        "The disorder parameter over belt velocity and noise. In the paper white dots enclose the "
        "range of intermittency, which ends above zero noise and widens at strong noise. Here each "
        "point has one that is intermittent by the rule above the map, in one run of limited "
        "length. b: the share of time in laminar phases, that is, slips of the last block longer "
        "than 200, in runs from starts of their own; the dotted lines are the limits of the rule."
    ),
    alt=(
        "Two panels: a colour map of r over belt velocity and noise, with a white dot at each "
        "intermittent point; below, the share of laminar phases against belt velocity, a line "
        "with a band for each noise."
    ),
    number="18",
)

STEP = 0.02  # of r, from one colour to the next
LEFT_OUT = (0.5,)  # noise at which b shows what it shows at 0 and 1


@style.styled
def draw(data):
    """a: r over the plane (u, sigma), a dot where `intermittent_mask` holds; b: laminar shares."""
    panels.require(data, FIGURE)
    points = data["n5_map"].arrays
    points = sections.select(points, points["n_blocks"] == 5)
    figure = style.page(6.4)
    above, below = figure.subplots(2, 1, height_ratios=(1.5, 1))
    panels.letter(above, "a")
    above.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.NOISE)
    if points["noise"].size:
        _map(figure, above, points)
        _dots(above, points)
    else:
        panels.note(above, "no points in this scan")
    panels.letter(below, "b")
    _shares(below, data["n5_replicates"])
    return figure


def _map(figure, axes, points):
    velocities, noises, disorder = _table(points)
    highest = np.nanmax(disorder) if np.isfinite(disorder).any() else STEP
    levels = STEP * np.arange(np.ceil(highest / STEP - 1e-9) + 1)
    image = axes.pcolormesh(
        measure.cell_edges(velocities),
        measure.cell_edges(noises),
        disorder,
        cmap="viridis",
        norm=BoundaryNorm(levels, 256),
        rasterized=True,
    )
    figure.colorbar(image, ax=axes, pad=0.01, label=panels.DISORDER)


def _dots(axes, points):
    mask = intermittency.intermittent_mask(points)
    low, high = intermittency.LAMINAR_SHARE
    rule = f"laminar phases, at least {intermittency.MINIMUM_PHASES}, take {low:.0%} to {high:.0%}"
    words = "dots: intermittent" if mask.any() else "no point is intermittent"
    panels.remark(axes, f"{words} ({rule} of the time)")
    places = points["belt_velocity"][mask], points["noise"][mask]
    look = {"color": "white", "markeredgecolor": "black", "markeredgewidth": 0.4}
    if mask.any():  # dots that may leave the panel count in the layout, none of them too
        axes.plot(*places, "o", markersize=3.2, clip_on=False, **look)


def _shares(axes, scan):
    noises = [noise for noise in panels.levels(scan, "noise") if noise not in LEFT_OUT]
    for index, noise in enumerate(noises):
        row = sections.rows(scan, n_blocks=5, noise=noise)
        label = rf"$\sigma = {noise:g}$"
        share = row["belt_velocity"], row["laminar_fraction"]
        # without noise a run has one of both motions for good
        replicate_panels.band(axes, *share, index, label=label, band=noise > 0)
    for limit in intermittency.LAMINAR_SHARE:
        axes.axhline(limit, color="0.5", linewidth=0.8, linestyle=":")
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="laminar share", ylim=(-0.04, 1.04))
    panels.remark(axes, replicate_panels.WORDS)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="center left")
    else:
        panels.note(axes, "no run with five blocks")


def _table(points):
    """(u (U,), sigma (S,), r (S, U)): median over replicates, NaN where the map has no point."""
    velocities, column = np.unique(points["belt_velocity"], return_inverse=True)
    noises, line = np.unique(points["noise"], return_inverse=True)
    disorder = np.full((noises.size, velocities.size), np.nan)
    cell = line * velocities.size + column
    for place in np.unique(cell):
        disorder.flat[place] = np.median(points["disorder_parameter"][cell == place])
    return velocities, noises, disorder
