"""Fig. 10: natural distribution on a Poincaré section."""

import numpy as np
from matplotlib.colors import LogNorm

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats import sections

FIGURE = Figure(uses=("slips_u1", "slips_u1_event"), number="10")

STUCK = 1e-6  # a block slower than this relative to the belt is stuck
DENSITY_FROM = 20_000  # points: fewer are drawn one by one
BINS = (240, 240)


@style.styled
def draw(data):
    """Section points with v_rN < 0 in the plane (x_N, v_rN): a density where there are many."""
    panels.require(data, FIGURE)
    figure = style.page(2.6)
    grid = figure.subplots(1, 2, sharex=True, sharey=True)
    for axes, mark, name in zip(grid, "ab", FIGURE.uses, strict=True):
        panels.letter(axes, mark)
        _section(figure, axes, data[name])
    grid[0].set_ylabel(panels.RELATIVE_VELOCITY)
    return figure


def _section(figure, axes, catalogue):
    about, points = catalogue.attributes, catalogue.arrays["section"]
    position = points["positions"][:, -1]
    relative = points["velocities"][:, -1] - about["belt_velocity"]
    again = sections.repeated(np.hstack([points["positions"], points["velocities"]]))
    slipping = relative < -STUCK
    new, old = slipping & ~again, slipping & again
    size = float(np.clip(160 / np.sqrt(max(slipping.sum(), 1)), 1.5, 5))
    look = {"markersize": size, "markeredgewidth": 0, "rasterized": True}
    if old.any():
        axes.plot(position[old], relative[old], ".", color=style.ORANGE, **look)
    _draw_points(figure, axes, position[new], relative[new], look)
    runs = np.unique(points["point"]).size
    place = f"$x_{{{about['section_block']}}} = {about['section_position']:g}$"
    axes.set_xlabel(f"{panels.POSITION} at {place}")
    motion = panels.METHODS[about["method"]]
    words = f"{motion}, {runs} runs:\n{new.sum()} of {slipping.sum()} points are new"
    panels.remark(axes, words)


def _draw_points(figure, axes, position, relative, look):
    if position.size == 0:
        panels.note(axes, "no section point at which the last block slips")
    elif position.size < DENSITY_FROM:
        axes.plot(position, relative, ".", color=style.BLUE, **look)
        axes.margins(0.02)
    else:
        count, *edges = np.histogram2d(position, relative, BINS)
        count = np.where(count > 0, count, np.nan)
        image = axes.pcolormesh(*edges, count.T, norm=LogNorm(), rasterized=True)
        figure.colorbar(image, ax=axes, pad=0.01, location="bottom", label="points per cell")
