"""Not in the paper: where the motion is periodic, irregular for long, and irregular to the end."""

import numpy as np
from matplotlib.patches import Patch

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.stats import motion, sections, survival

FIGURE = Figure(uses=("motion_map", "mean_lifetimes"), category="Further studies")

# Colour, hatching and words of each way to move, from the bottom of a cell to its top. The hues are
# those of `motions.COLOURS`, darker or paler so that they differ in grey too.
_LOOKS = {
    motion.CHAOTIC: ("#7a2e00", "", "irregular, exponent above zero"),
    motion.TRANSIENT: (style.ORANGE, "/////", "irregular, exponent not above zero or not known"),
    motion.QUASI_PERIODIC: (style.GREEN, "....", "quasi-periodic"),
    motion.PERIODIC: ("#a5d5f0", "", "periodic"),
    motion.EQUILIBRIUM: ("#ffffff", "", "equilibrium slip"),
}
_MARKS = {
    survival.LASTING: ("o", "irregular motion lasts in longer runs"),
    survival.TRANSIENT: ("X", "irregular motion ends in longer runs"),
}
_TICKS = 8  # most words at an axis of belt velocities
_FILL = 0.9  # of a cell
_OUTLINED = 40  # more cells in a row have no outline


@style.styled
def draw(data):
    """Top: shares over (u, N); bottom: exponents."""
    panels.require(data, FIGURE)
    figure = style.page(4.4)
    sizes, exponents = figure.subplots(2, 1)
    points = data["motion_map"].arrays
    _draw_cells(sizes, points)
    _draw_verdicts(sizes, points, data["mean_lifetimes"])
    _draw_exponents(exponents, points)
    panels.letters(sizes, exponents)
    for axes in (sizes, exponents):
        axes.set_xlabel(panels.BELT_VELOCITY)
    _draw_legend(figure, sizes)
    return figure


# --- cells ----------------------------------------------------------------------------------------


def _draw_cells(axes, arrays):
    """A cell for each u and N, filled by the shares of each way to move."""
    axes.set_ylabel("$N$")
    if not arrays["belt_velocity"].size:
        panels.note(axes, "no points in this dataset")
        return
    velocities, column = np.unique(arrays["belt_velocity"], return_inverse=True)
    sizes, line = np.unique(arrays["n_blocks"], return_inverse=True)
    place = line * velocities.size + column
    ways = arrays["state"].astype(str)
    runs = np.bincount(place, minlength=sizes.size * velocities.size)
    there = np.flatnonzero(runs)
    bottom = there // velocities.size - _FILL / 2
    outline = 0.3 if velocities.size <= _OUTLINED else 0.0
    look = {"width": _FILL, "edgecolor": "0.25", "linewidth": outline}
    for way, (colour, hatch, _) in _LOOKS.items():
        count = np.bincount(place[ways == way], minlength=runs.size)[there]
        height = _FILL * count / runs[there]
        axes.bar(there % velocities.size, height, bottom=bottom, color=colour, hatch=hatch, **look)
        bottom = bottom + height
    every = -(-velocities.size // _TICKS)
    axes.set_xticks(range(0, velocities.size, every), [f"{u:g}" for u in velocities[::every]])
    axes.set_yticks(range(sizes.size), [f"${size}$" for size in sizes])
    axes.set(xlim=(-0.6, velocities.size - 0.4), ylim=(-0.6, sizes.size - 0.4))
    axes.tick_params(length=0)


def _draw_verdicts(axes, points, table):
    """Marks on cells: whether irregular motion ends, by those runs that were observed most."""
    velocities, sizes = (np.unique(points[name]) for name in ("belt_velocity", "n_blocks"))
    rows = table[np.isin(table["belt_velocity"], velocities) & np.isin(table["n_blocks"], sizes)]
    observed = (rows["counted"] * rows["horizon"]).sort_values(kind="stable")
    rows = rows.loc[observed.index].drop_duplicates(["n_blocks", "belt_velocity"], keep="last")
    for verdict, (marker, words) in _MARKS.items():
        those = rows[rows["verdict"] == verdict]
        place = np.searchsorted(velocities, those["belt_velocity"])
        look = {"markeredgecolor": "black", "markeredgewidth": 0.7, "markersize": 5}
        line = np.searchsorted(sizes, those["n_blocks"])
        axes.plot(place, line, marker, label=words, color="white", **look)


def _draw_legend(figure, axes):
    """Words for the fillings and marks that occur, above the page."""
    bars = [patch for panel in figure.axes for patch in panel.patches if patch.get_height() > 0]
    used = {bar.get_facecolor() for bar in bars}
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor="0.25", linewidth=0.5, label=words)
        for colour, hatch, words in _LOOKS.values()
    ]
    handles = [patch for patch in handles if patch.get_facecolor() in used]
    handles += [line for line in axes.lines if len(line.get_xdata())]
    if handles:
        figure.legend(handles=handles, loc="outside upper left", ncols=1)


# --- exponents ------------------------------------------------------------------------------------


def _draw_exponents(axes, points):
    """A dot for each run; a line for each N, through the medians over its runs."""
    axes.set_ylabel(r"largest exponent $\lambda_1$")
    if not points["belt_velocity"].size:
        panels.note(axes, "no points in this dataset")
        return
    axes.axhline(0, color="0.6", linewidth=0.8, zorder=0)
    sizes = np.unique(points["n_blocks"])
    for size, colour in zip(sizes, style.shades(sizes.size), strict=True):
        chosen = points["n_blocks"] == size
        velocity, value = (points[name][chosen] for name in ("belt_velocity", "largest_exponent"))
        axes.plot(velocity, value, ".", color=colour, markersize=4, alpha=0.6, markeredgewidth=0)
        spread = sections.spread(velocity, value)
        axes.plot(spread.place, spread.median, color=colour, linewidth=1.4, label=f"{size}")
    axes.legend(
        title="$N$", reverse=True, loc="upper left", bbox_to_anchor=(1.0, 1.03), handlelength=1.0
    )
