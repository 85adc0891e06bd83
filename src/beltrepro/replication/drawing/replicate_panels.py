"""Independent runs, as several figures show them: a dot each, means where there is one branch."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.stats import sections

# Runs at a point lie on one branch if the largest value is at most this multiple of the least: the
# branches of r differ by factors of three and more.
ONE_BRANCH = 1.5


def draw_runs(axes, abscissa, values, index, *, label=None, apart=ONE_BRANCH, **changes):
    """A small mark for each run; a line of their means where they lie on one branch.

    apart : largest ratio of the values of one branch; infinite for what always has a mean, 0 for
    what never has.
    """
    spread = sections.spread(abscissa, values)
    if not spread.place.size:
        return
    look = style.line_style(index) | {"markersize": 2.6, "markeredgewidth": 0.3} | changes
    measured = np.isfinite(values)
    dots = {"markersize": 1.5, "markeredgewidth": 0, "zorder": 1.5, "alpha": 0.7}
    dots |= {name: look[name] for name in ("color", "marker")}
    place, value = np.asarray(abscissa)[measured], np.asarray(values)[measured]
    axes.plot(place, value, linestyle="none", **dots)
    joined = spread.mean
    if np.isfinite(apart):
        joined = np.where(spread.high <= apart * spread.low, joined, np.nan)
    axes.plot(spread.place, joined, label=label, **look)


def crosses(axes, abscissa, values, colour, overlay):
    """A cross for each run by the other integrator, over those of `draw_runs`."""
    label = overlay if overlay not in axes.get_legend_handles_labels()[1] else None
    look = {"markersize": 2.6, "markeredgewidth": 0.5, "label": label}
    axes.plot(abscissa, values, "x", color=colour, **look)


def against_noise(figure, data, name, places, *, across):
    """r against noise from columns of the scan `name`: above as in the paper, below all runs.

    Above there is one run at each point, all columns in one panel; below a panel for each column,
    with points of the other integrator, if given, as crosses over it.
    places : dict, words by (n_blocks, belt_velocity).  across : panels in a row.
    """
    if not places:
        panels.note(figure.subplots(), "no points in this scan")
        return []
    down = -(-len(places) // across)
    grid = figure.add_gridspec(down + 1, across, height_ratios=[1.7] + [1] * down)
    above = figure.add_subplot(grid[0, :])
    below = []
    for number, (place, words) in enumerate(places.items()):
        shared = {"sharex": below[0], "sharey": below[0]} if below else {}
        axes = figure.add_subplot(grid[1 + number // across, number % across], **shared)
        below.append(axes)
        panels.letter(axes, "bcdefghij"[number])
        axes.set_title(words)
        _column(above, axes, data, name, place, number, words)
    panels.letter(above, "a")
    panels.finish_curves(above, xlabel=panels.NOISE, ncols=across)
    below[0].set_ylim(bottom=0)
    for axes in below:
        axes.set(xlabel=panels.NOISE, ylabel=panels.DISORDER)
        axes.label_outer()
    return [above, *below]


def _column(above, axes, data, name, place, number, words):
    """The first run of a column in the panel of all, and all its runs in its own."""
    for scan, overlay in panels.layers(data, name):
        column = sections.columns(scan, n_blocks=place[0], belt_velocity=place[1])
        points = column["noise"], column["disorder_parameter"]
        if overlay:
            if points[0].size:
                crosses(axes, *points, style.VERMILION, overlay)
            continue
        first = column["replicate"] == column["replicate"].min(initial=0)
        panels.single_runs(above, points[0][first], points[1][first], number, label=words)
        draw_runs(axes, *points, number)
    if not axes.lines:
        panels.note(axes, "no r in this column", width=12)
