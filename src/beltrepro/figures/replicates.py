"""Replicates, as several figures show them: the median as a line, most runs as a band, or all."""

import numpy as np

from beltrepro.analysis import replicates, sections
from beltrepro.figures import panels, style

WORDS = f"lines: median over runs; bands: {replicates.SHARE:.0%} of the runs"


def band(axes, abscissa, disorder, index, *, label=None, runs=False, **changes):
    """r against u or noise: the median with a band, and with `runs` a dot for each run."""
    found = replicates.spread(abscissa, disorder)
    if not found.place.size:
        return
    look = style.line_style(index) | {"markersize": 2.6, "label": label} | changes
    if runs:
        known = np.isfinite(disorder)
        axes.plot(
            np.asarray(abscissa)[known],
            np.asarray(disorder)[known],
            ".",
            color=style.GREY,
            markersize=3,
            markeredgewidth=0,
            zorder=1.5,
        )
    axes.fill_between(
        found.place, found.low, found.high, color=look["color"], alpha=0.22, linewidth=0
    )
    axes.plot(found.place, found.median, **look)


def against_noise(figure, data, name, places, *, across):
    """r against noise from columns of the scan `name`, a panel for each (N, u) and its title.

    places : dict, title by (n_blocks, belt_velocity).  across : panels in a row.
    Points of the other integrator, if given, lie over it as crosses.
    """
    if not places:
        panels.note(figure.subplots(), "no points in this scan")
        return []
    down = -(-len(places) // across)
    grid = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    for axes, ((n_blocks, velocity), title) in zip(grid.flat, places.items(), strict=False):
        axes.set_title(title)
        for scan, overlay in panels.layers(data, name):
            column = sections.columns(scan, n_blocks=n_blocks, belt_velocity=velocity)
            points = column["noise"], column["disorder_parameter"]
            if overlay:
                panels.curve(axes, *points, 0, overlay=overlay, color=style.VERMILION)
            else:
                band(axes, *points, 0, runs=True, linestyle="-")
        if not axes.lines:
            panels.note(axes, "no r in this column")
        panels.legend_within(axes)
    for axes in grid.flat[len(places) :]:
        axes.remove()
    grid.flat[0].set_ylim(bottom=0)
    for axes in grid.flat[: len(places)]:
        axes.set(xlabel=panels.NOISE, ylabel=panels.DISORDER)
        axes.label_outer()
    return list(grid.flat[: len(places)])
