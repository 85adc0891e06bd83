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
    motion.CHAOTIC: ("#7a2e00", "", "irregular, exponent > 0"),
    motion.STABLE_CHAOS: (style.VERMILION, "xxx", "irregular, exponent < 0"),
    motion.TRANSIENT: (style.ORANGE, "/////", "irregular, sign not known"),
    motion.QUASI_PERIODIC: (style.GREEN, "....", "quasi-periodic"),
    motion.PERIODIC: ("#a5d5f0", "", "periodic"),
    motion.EQUILIBRIUM: ("#ffffff", "", "equilibrium slip"),
    # whole cells, by longer runs
    f"{LASTING}, longer": ("#000000", "", "irregular in longer runs"),
    f"{TRANSIENT}, longer": ("#dddddd", "xxxx", "ends in longer runs"),
}
_TICKS = 8  # most words at an axis of belt velocities
_FILL = 0.9  # of a cell
_OUTLINED = 40  # more cells in a row have no outline


@panels.draws(FIGURES)
def motion_map(data):
    """Top: shares over (u, N); bottom: exponents."""
    figure, (sizes, exponents) = panels.page(4.05, "a;b")
    points = data["motion_map"].arrays
    sizes.set(xlabel=panels.BELT_VELOCITY, ylabel="$N$")
    exponents.set(xlabel=panels.BELT_VELOCITY, ylabel=r"largest exponent $\lambda_1$")
    _draw_cells(sizes, points, data["mean_lifetimes"])
    _draw_exponents(exponents, points)
    _draw_legend(figure)
    return figure


def _draw_cells(axes, arrays, table):
    """A cell for each u and N, filled by the shares of each way to move, or by longer runs."""
    ways = pd.crosstab(
        [arrays["n_blocks"], arrays["belt_velocity"]],
        arrays["state"].astype(str),
        normalize="index",
    ).reindex(columns=list(_LOOKS), fill_value=0.0)
    for point, verdict in _verdicts(table).items():
        if point in ways.index and f"{verdict}, longer" in _LOOKS:
            ways.loc[point] = 0.0
            ways.loc[point, f"{verdict}, longer"] = 1.0
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


def _verdicts(table):
    """Whether irregular motion ends, by N and u: by those runs that were observed most."""
    observed = (table["counted"] * table["horizon"]).sort_values(kind="stable")
    points = ["n_blocks", "belt_velocity"]
    return (
        table.loc[observed.index].drop_duplicates(points, keep="last").set_index(points)["verdict"]
    )


def _draw_legend(figure):
    """Words for the fillings that occur, above the page."""
    bars = [patch for panel in figure.axes for patch in panel.patches if patch.get_height() > 0]
    used = {bar.get_facecolor() for bar in bars}
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor="0.25", linewidth=0.5, label=words)
        for colour, hatch, words in _LOOKS.values()
    ]
    handles = [patch for patch in handles if patch.get_facecolor() in used]
    figure.legend(handles=handles, loc="outside upper left", ncols=2)


def _draw_exponents(axes, points):
    """A dot for each run; a line for each N, through the medians over its runs."""
    axes.axhline(0, color="0.6", linewidth=0.8, zorder=0)
    sizes = np.unique(points["n_blocks"])
    for size in sizes:
        colour = style.colour_of_size(size)
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
    """a: survival of many runs; b: mean lifetimes."""
    figure, (many, by_velocity) = panels.page(4.05, "a;b")
    table, sizes = data["mean_lifetimes"], panels.levels(data["survival"], "n_blocks")
    _draw_many(many, data["survival_many"], _of(table, "survival_many"))
    many.set(xlabel=panels.TIME, ylabel="share still irregular")
    _draw_by_velocity(by_velocity, table, sizes)
    by_velocity.axhline(_horizon(data["survival"]), color="0.6", linewidth=0.8, zorder=0)
    by_velocity.set(xlabel=panels.BELT_VELOCITY, yscale="log", ylabel=r"mean lifetime $\tau$")
    panels.legend_above(by_velocity, ncols=6)
    return figure


def _of(table, name):
    return table[table["dataset"] == name]


def _horizon(runs):
    return SEEN * float(runs.attributes["duration"])


def _at(columns, *point):
    return np.all([columns[name] == value for name, value in zip(POINT, point, strict=True)], 0)


# --- survival -------------------------------------------------------------------------------------


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
    axes.legend(loc="upper right")


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


# --- mean lifetimes -------------------------------------------------------------------------------


def _draw_by_velocity(axes, table, sizes):
    """A mark for each N, of the smallest initial spread, side by side; longer runs beside it."""
    measured = table[table["lifetime_lower"].notna()]
    usual = _of(measured, "survival")
    usual = usual[usual["initial_spread"] == usual["initial_spread"].min()]
    if usual.empty:
        panels.note(axes, "no mean lifetimes")
        return
    step = 0.08 * np.diff(np.unique(usual["belt_velocity"])).min(initial=10.0)
    for index, size in enumerate(sizes):
        shift = step * (index - (sizes.size - 1) / 2)
        look = {"color": style.colour_of_size(size), "marker": style.MARKERS[index % 7]}
        rows = usual[usual["n_blocks"] == size]
        _draw_means(axes, rows, shift, markersize=3.5, label=f"$N = {size}$", **look)
        longer = _of(measured, "survival_long")
        longer = longer[longer["n_blocks"] == size]
        _draw_means(axes, longer, shift + step / 2, markersize=4, markerfacecolor="white", **look)


def _draw_means(axes, rows, shift, *, color, **look):
    """Means with intervals; arrows up from lower limits."""
    place = rows["belt_velocity"] + shift
    ended = np.isfinite(rows["lifetime"])
    mean = (rows[f"lifetime{end}"][ended] for end in ("", "_lower", "_upper"))
    bars = {"color": color, "elinewidth": 0.9}
    panels.intervals(axes, place[ended], *mean, linestyle="none", **bars | look)
    panels.limits(axes, place[~ended], rows["lifetime_lower"][~ended], capsize=2.0, **bars)
