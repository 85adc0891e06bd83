"""Not in the paper: which motions are irregular, and for how long."""

import numpy as np
import pandas as pd
from matplotlib.patches import Patch

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.chaos.measure import POINT
from beltrepro.stats import motion, sections
from beltrepro.stats.survival import LASTING, SEEN, TRANSIENT, kaplan_meier, observed

FIGURES = {
    "motion_map": Figure(uses=("motion_map", "mean_lifetimes"), category="Further studies"),
    "survival": Figure(
        uses=("survival", "survival_many", "survival_long", "mean_lifetimes"),
        category="Further studies",
    ),
}


# --- Not in the paper: where the motion is periodic, irregular for long, and irregular to the end -

# Colour, hatching and words of each way to move, from the bottom of a cell to its top. The colours
# differ in grey too.
_LOOKS = {
    motion.CHAOTIC: ("#7a2e00", "", "irregular, exponent above zero"),
    motion.STABLE_CHAOS: (style.VERMILION, "xxx", "irregular, exponent below zero"),
    motion.TRANSIENT: (style.ORANGE, "/////", "irregular, exponent not above zero or not known"),
    motion.QUASI_PERIODIC: (style.GREEN, "....", "quasi-periodic"),
    motion.PERIODIC: ("#a5d5f0", "", "periodic"),
    motion.EQUILIBRIUM: ("#ffffff", "", "equilibrium slip"),
}
_MARKS = {
    LASTING: ("o", "irregular motion lasts in longer runs"),
    TRANSIENT: ("X", "irregular motion ends in longer runs"),
}
_TICKS = 8  # most words at an axis of belt velocities
_FILL = 0.9  # of a cell
_OUTLINED = 40  # more cells in a row have no outline


@panels.draws(FIGURES)
def motion_map(data):
    """Top: shares over (u, N); bottom: exponents."""
    figure, (sizes, exponents) = panels.page(4.4, "a;b")
    points = data["motion_map"].arrays
    sizes.set(xlabel=panels.BELT_VELOCITY, ylabel="$N$")
    exponents.set(xlabel=panels.BELT_VELOCITY, ylabel=r"largest exponent $\lambda_1$")
    _draw_cells(sizes, points)
    _draw_verdicts(sizes, points, data["mean_lifetimes"])
    _draw_exponents(exponents, points)
    _draw_legend(figure, sizes)
    return figure


def _draw_cells(axes, arrays):
    """A cell for each u and N, filled by the shares of each way to move."""
    ways = pd.crosstab(
        [arrays["n_blocks"], arrays["belt_velocity"]],
        arrays["state"].astype(str),
        normalize="index",
    ).reindex(columns=list(_LOOKS), fill_value=0)
    sizes, velocities = (np.unique(arrays[name]) for name in ("n_blocks", "belt_velocity"))
    line, column = (
        np.searchsorted(levels, ways.index.get_level_values(number))
        for number, levels in enumerate((sizes, velocities))
    )
    bottom = line - _FILL / 2
    outline = 0.3 if velocities.size <= _OUTLINED else 0.0
    look = {"width": _FILL, "edgecolor": "0.25", "linewidth": outline}
    for way, (colour, hatch, _) in _LOOKS.items():
        height = _FILL * ways[way].to_numpy()
        axes.bar(column, height, bottom=bottom, color=colour, hatch=hatch, **look)
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
    figure.legend(handles=handles, loc="outside upper left", ncols=1)


def _draw_exponents(axes, points):
    """A dot for each run; a line for each N, through the medians over its runs."""
    axes.axhline(0, color="0.6", linewidth=0.8, zorder=0)
    sizes = np.unique(points["n_blocks"])
    for size, colour in zip(sizes, style.shades(sizes.size), strict=True):
        chosen = points["n_blocks"] == size
        velocity, value = (points[name][chosen] for name in ("belt_velocity", "largest_exponent"))
        axes.plot(velocity, value, ".", color=colour, markersize=4, alpha=0.6, markeredgewidth=0)
        spread = sections.spread(velocity, value)
        axes.plot(spread.place, spread.median, color=colour, linewidth=1.4, label=f"{size}")
    place = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.03), "handlelength": 1.0}
    axes.legend(title="$N$", reverse=True, **place)


# --- Not in the paper: how long irregular motion lasts without noise ------------------------------


@panels.draws(FIGURES)
def survival(data):
    """Top: survival of each N at one u, and of many runs; bottom: mean lifetimes."""
    figure, (single, many, by_velocity) = panels.page(4.8, "ab;cc", width_ratios=(1.35, 1))
    table, sizes = data["mean_lifetimes"], panels.levels(data["survival"], "n_blocks")
    colours = dict(zip(sizes, style.shades(sizes.size), strict=True))
    _draw_each(single, data["survival"], _of(table, "survival"), colours)
    _draw_many(many, data["survival_many"], _of(table, "survival_many"))
    _draw_by_velocity(by_velocity, table, colours)
    by_velocity.axhline(_horizon(data["survival"]), color="0.6", linewidth=0.8, zorder=0)
    by_velocity.set(xlabel=panels.BELT_VELOCITY, yscale="log", ylabel=r"mean lifetime $\tau$")
    for axes in (single, many):
        axes.set(xlabel=panels.TIME, ylabel="share still irregular")
    single.set_ylim(-0.03, 1.03)
    handles, labels = by_velocity.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _of(table, name):
    return table[table["dataset"] == name]


def _horizon(runs):
    return SEEN * float(runs.attributes["duration"])


def _at(columns, *point):
    return np.all([columns[name] == value for name, value in zip(POINT, point, strict=True)], 0)


# --- survival -------------------------------------------------------------------------------------


def _draw_each(axes, runs, table, colours):
    """A curve for each N, at the u where about half of the runs end."""
    first, *others = np.unique(runs.arrays["initial_spread"])
    for size, colour in colours.items():
        velocity = _half_ends(runs, size, first)
        point = size, velocity, first
        _draw_curve(axes, runs, table, point, colour, f"$N = {size}$, $u = {velocity:g}$")
        for spread in others:
            if _at(runs.arrays, size, velocity, spread).any():
                curve = _curve(runs, size, velocity, spread)
                axes.step(curve.time, curve.share, ":", where="post", color=colour, linewidth=0.9)
    axes.set_xscale("log")
    ends = np.concatenate([line.get_xdata() for line in axes.lines])
    axes.set_xlim(ends[ends > 0].min() / 3, _horizon(runs))
    axes.legend(loc="lower left")


def _draw_many(axes, runs, table):
    """A curve for each point of the dataset with many runs."""
    points = np.unique(np.column_stack([runs.arrays[name] for name in POINT]), axis=0)
    for point, colour in zip(points, style.COLOURS, strict=False):
        label = f"$N = {point[0]:g}$, $u = {point[1]:g}$, {_at(runs.arrays, *point).sum()} runs"
        _draw_curve(axes, runs, table, point, colour, label)
    counted = np.minimum(runs.arrays["lifetime"], _horizon(runs))
    axes.set_xlim(0, counted.max())
    axes.set_yscale("log")
    least = 0.5 / max(_at(runs.arrays, *point).sum() for point in points)
    axes.set_ylim(least, 1 / least**0.35)  # room for the legend
    panels.plain_log(axes.yaxis)
    axes.set_yticks([tick for tick in (0.001, 0.01, 0.1, 1) if tick > least])
    axes.locator_params(axis="x", nbins=4)
    axes.legend(loc="upper right", handlelength=1.0)


def _draw_curve(axes, runs, table, point, colour, label):
    """Survival with its band, and the exponential with the mean lifetime."""
    curve = _curve(runs, *point)
    axes.step(curve.time, curve.share, where="post", color=colour, label=label, linewidth=1.3)
    ends = curve.share < 1  # bands of whole shares would lie on each other
    if ends.any():
        band = {"step": "post", "color": colour, "alpha": 0.15, "linewidth": 0}
        axes.fill_between(curve.time[ends], curve.lower[ends], curve.upper[ends], **band)
    row = table[_at(table, *point)].iloc[0]
    if np.isfinite(row["lifetime"]):
        left = curve.share[np.searchsorted(curve.time, row["start"], side="right") - 1]
        begin, end = max(row["start"], row["lifetime"] / 100), curve.time[-1]
        time = np.geomspace(begin, max(begin, end), 100)
        line = left * np.exp(-(time - row["start"]) / row["lifetime"])
        axes.plot(time, line, "--", color=colour, linewidth=0.8)


def _curve(runs, *point):
    chosen = _at(runs.arrays, *point)
    lifetime, settled = runs.arrays["lifetime"][chosen], runs.arrays["settled"][chosen]
    return kaplan_meier(*observed(lifetime, settled, horizon=_horizon(runs)))


def _half_ends(runs, size, spread):
    """The u at which about half of the runs of this N end; of equals, that with the longest."""
    arrays, horizon = runs.arrays, _horizon(runs)
    chosen = (arrays["n_blocks"] == size) & (arrays["initial_spread"] == spread)

    def unlike(velocity):
        lifetime = arrays["lifetime"][chosen & (arrays["belt_velocity"] == velocity)]
        return abs(np.mean(lifetime > horizon) - 0.5), -lifetime.mean()

    return min(np.unique(arrays["belt_velocity"][chosen]), key=unlike)


# --- mean lifetimes -------------------------------------------------------------------------------


def _draw_by_velocity(axes, table, colours):
    """A mark for each N, of the smallest initial spread, side by side; longer runs beside it."""
    measured = table[table["lifetime_lower"].notna()]
    usual = _of(measured, "survival")
    usual = usual[usual["initial_spread"] == usual["initial_spread"].min()]
    if usual.empty:
        panels.note(axes, "no mean lifetimes")
        return
    step = 0.08 * np.diff(np.unique(usual["belt_velocity"])).min(initial=10.0)
    for index, (size, colour) in enumerate(colours.items()):
        shift = step * (index - (len(colours) - 1) / 2)
        look = {"color": colour, "marker": style.MARKERS[index % len(style.MARKERS)]}
        rows = usual[usual["n_blocks"] == size]
        _draw_means(axes, rows, shift, markersize=3.5, label=f"$N = {size}$", **look)
        longer = _of(measured, "survival_long")
        longer = longer[longer["n_blocks"] == size]
        _draw_means(axes, longer, shift + step / 2, markersize=6, markerfacecolor="white", **look)


def _draw_means(axes, rows, shift, *, color, **look):
    """Means with intervals; arrows up from lower limits."""
    place = rows["belt_velocity"] + shift
    ended = np.isfinite(rows["lifetime"])
    mean = (rows[f"lifetime{end}"][ended] for end in ("", "_lower", "_upper"))
    bars = {"color": color, "elinewidth": 0.9}
    panels.intervals(axes, place[ended], *mean, linestyle="none", **bars | look)
    panels.limits(axes, place[~ended], rows["lifetime_lower"][~ended], capsize=2.0, **bars)
