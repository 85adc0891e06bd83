"""Fig. 10: natural distribution on a Poincaré section."""

import numpy as np
from matplotlib.colors import LogNorm

from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Poincaré section of the chaotic attractor at u = 1.",
    uses=("slips_u1",),
    words=(
        "Points where the second block passes a fixed place backwards, drawn as position and "
        "relative velocity of the last block, lie on a folded, layered set as for a simple "
        "chaotic oscillator."
    ),
    alt=(
        "Scatter of section points in the plane of position and relative velocity of the last "
        "block: a folded set of thin layers."
    ),
    number="10",
)

STUCK = 1e-6  # a block slower than this relative to the belt is stuck
DENSITY_FROM = 20_000  # points: fewer are drawn one by one
BINS = (360, 240)


@style.styled
def draw(data, caption):
    """Section points with v_rN < 0 in the plane (x_N, v_rN): a density where there are many."""
    panels.require(data, ENTRY)
    catalogue = data["slips_u1"]
    attributes, points = catalogue.attributes, catalogue.arrays["section"]
    position = points["positions"][:, -1]
    relative = points["velocities"][:, -1] - attributes["belt_velocity"]
    slipping = relative < -STUCK

    figure = style.page(caption, 4.4)
    axes = figure.subplots()
    axes.set(xlabel=panels.POSITION, ylabel=panels.RELATIVE_VELOCITY)
    axes.set_title(
        f"$x_{{{attributes['section_block']}}} = {attributes['section_position']:g}$, "
        f"{slipping.sum()} points with $v_{{rN}} < 0$ of {points.size}",
        loc="right",
        size=8,
        color="0.35",
    )
    _draw_points(figure, axes, position[slipping], relative[slipping])
    return figure


def _draw_points(figure, axes, position, relative):
    if position.size == 0:
        panels.note(axes, "no section point at which the last block slips")
    elif position.size < DENSITY_FROM:
        size = float(np.clip(150 / np.sqrt(position.size), 1.2, 6))
        axes.plot(
            position,
            relative,
            ".",
            color=style.BLUE,
            markersize=size,
            markeredgewidth=0,
            rasterized=True,
        )
        axes.margins(0.02)
    else:
        count, *edges = np.histogram2d(position, relative, BINS)
        count = np.where(count > 0, count, np.nan)
        image = axes.pcolormesh(*edges, count.T, norm=LogNorm(), rasterized=True)
        figure.colorbar(image, ax=axes, pad=0.01, label="points per cell")
