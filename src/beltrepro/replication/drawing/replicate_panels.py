"""Replicates, as several figures show them: the mean as a line, most runs as a band, or all."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.stats import replicates, sections

WORDS = f"lines: means over runs; bands: {replicates.SHARE:.0%} of the runs"


def band(axes, abscissa, values, index, *, label=None, runs="", band=True, **changes):
    """What was measured of runs: their mean, with a band; in the colour `runs` a dot for each."""
    spread = replicates.spread(abscissa, values)
    if not spread.place.size:
        return
    look = style.line_style(index) | {"markersize": 2.6, "label": label} | changes
    if runs:
        measured = np.isfinite(values)
        place, value = np.asarray(abscissa)[measured], np.asarray(values)[measured]
        dots = {"marker": ".", "markersize": 3.5, "markeredgewidth": 0, "zorder": 1.5}
        axes.plot(place, value, linestyle="none", color=runs, **dots)
    if band:
        axes.fill_between(
            spread.place, spread.low, spread.high, color=look["color"], alpha=0.2, linewidth=0
        )
    axes.plot(spread.place, spread.mean, **look)


def crosses(axes, abscissa, values, colour, overlay):
    """Means of runs by the other integrator, over those of `band`, with its name in the legend."""
    spread = replicates.spread(abscissa, values)
    label = overlay if overlay not in axes.get_legend_handles_labels()[1] else None
    axes.plot(spread.place, spread.mean, "x", color=colour, markersize=4, label=label)


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
            if not overlay:
                band(axes, *points, 0, runs=style.BLACK, linestyle="-")
            elif points[0].size:
                crosses(axes, *points, style.VERMILION, overlay)
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
