"""Fig. 18: map of the disorder parameter."""

import numpy as np
from matplotlib.colors import BoundaryNorm

from beltrepro.replication.drawing import panels, replicate_panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.noise import measure
from beltrepro.stats import intermittency, sections

FIGURE = Figure(uses=("n5_map", "n5_replicates"), number="18")

STEP = 0.02  # of r, from one colour to the next
_ONE_MOTION = 0.5  # largest range of the laminar shares at one u, for a line to join their means
LEFT_OUT = (0.5,)  # noise at which b shows what it shows at 0 and 1


@style.styled
def draw(data):
    """a: r over the plane (u, sigma), dots where `intermittent_mask` holds; b: laminar shares."""
    panels.require(data, FIGURE)
    points = data["n5_map"].arrays
    points = sections.select(points, points["n_blocks"] == 5)
    figure = style.page(4.6)
    above, below = figure.subplots(2, 1, height_ratios=(1.7, 1))
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
    """White dots at the ends of the intermittent range at each noise, small ones between them."""
    mask = intermittency.intermittent_mask(points)
    if not mask.any():
        panels.remark(axes, "no point is intermittent")
        return
    panels.remark(axes, "white: motion alternates")
    velocity, noise = points["belt_velocity"][mask], points["noise"][mask]
    ends = np.zeros(velocity.size, dtype=bool)
    for level in np.unique(noise):
        here = velocity[noise == level]
        ends |= (noise == level) & ((velocity == here.min()) | (velocity == here.max()))
    look = {"color": "white", "markeredgecolor": "black", "clip_on": False}
    axes.plot(velocity[~ends], noise[~ends], ".", markersize=1.2, color="white")
    axes.plot(velocity[ends], noise[ends], "o", markersize=3.2, markeredgewidth=0.5, **look)


def _shares(axes, scan):
    noises = [noise for noise in panels.levels(scan, "noise") if noise not in LEFT_OUT]
    for index, noise in enumerate(noises):
        row = sections.rows(scan, n_blocks=5, noise=noise)
        share = row["belt_velocity"], row["laminar_fraction"]
        label = rf"$\sigma = {noise:g}$"
        spread = sections.spread(*share)
        # runs that keep to one of both motions have a mean, but no motion has it
        agree = np.all(spread.high - spread.low <= _ONE_MOTION)
        look = {"apart": np.inf} if agree else {"apart": 0.0, "linestyle": "none"}
        replicate_panels.draw_runs(axes, *share, index, label=label, **look)
    for limit in intermittency.LAMINAR_SHARE:
        axes.axhline(limit, color="0.5", linewidth=0.8, linestyle=":")
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="laminar share", ylim=(-0.04, 1.04))
    panels.legend_above(axes)
    if not noises:
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
