"""Not in the paper: how long irregular motion lasts without noise."""

import numpy as np

from beltrepro.analysis import survival
from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Survival of irregular motion without noise, and its mean lifetime for each N.",
    uses=("survival", "mean_lifetimes"),
    words=(
        "Not in the paper. a: share of the runs that are still irregular, by Kaplan and Meier, "
        "with 95 % bands from the first end on. Each N is shown at the belt velocity at which the "
        "share left at the end is nearest to one half. Dashed lines are exponentials with the mean "
        "lifetime. Dotted curves start from larger displacements. b: mean lifetimes at all belt "
        "velocities, against N. c: mean lifetimes against belt velocity, with 95 % intervals. "
        "Where no run ended, an arrow begins at the lower limit. The grey line is the time up to "
        "which ends are counted."
    ),
    alt=(
        "Three panels: the share of runs that are still irregular against time, and the mean "
        "lifetime of irregular motion against the number of blocks and against belt velocity."
    ),
    category="Further studies",
)

_FONT = 9.5  # points: legible where the page is as narrow as a phone
_POINT = ("n_blocks", "belt_velocity", "initial_spread")


@style.styled
def draw(data, caption):
    """Top: survival of each N at one u, mean lifetimes against N; bottom: against u."""
    panels.require(data, ENTRY)
    with style.font(_FONT):
        return _draw(data["survival"], data["mean_lifetimes"], caption)


def _draw(runs, table, caption):
    figure = style.page(caption, 6.6)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.5, 1))
    curves, by_size = (figure.add_subplot(grid[0, column]) for column in (0, 1))
    by_velocity = figure.add_subplot(grid[1, :])
    sizes = panels.levels(runs, "n_blocks")
    colours = dict(zip(sizes, style.shades(sizes.size), strict=True))
    horizon = survival.SEEN * float(runs.attributes["duration"])
    _draw_curves(curves, runs.arrays, table, colours, horizon)
    _draw_by_size(by_size, table, colours)
    _draw_by_velocity(by_velocity, table, colours)
    for axes in (by_size, by_velocity):
        axes.axhline(horizon, color="0.6", linewidth=0.8, zorder=0)
        axes.set(yscale="log", ylabel=r"mean lifetime $\tau$")
    curves.set(xlabel=panels.TIME, ylabel="share still irregular", ylim=(-0.03, 1.03))
    by_size.set(xlabel="$N$")
    by_velocity.set(xlabel=panels.BELT_VELOCITY)
    for axes, name in zip((curves, by_size, by_velocity), "abc", strict=True):
        panels.letter(axes, name)
    return figure


# --- survival -------------------------------------------------------------------------------------


def _draw_curves(axes, arrays, table, colours, horizon):
    """Kaplan-Meier curves, one for each N, at the u where about half of the runs end."""
    if not arrays["lifetime"].size:
        panels.note(axes, "no runs in this dataset")
        return
    first, *others = np.unique(arrays["initial_spread"])
    for size, colour in colours.items():
        velocity = _half_ends(arrays, horizon, size, first)
        curve = _curve(arrays, horizon, size, velocity, first)
        label = f"$N = {size}$, $u = {velocity:g}$"
        axes.step(curve.time, curve.share, where="post", color=colour, label=label, linewidth=1.3)
        if curve.share[-1] < 1:
            ends = curve.share < 1  # bands of whole shares would lie on each other
            band = {"step": "post", "color": colour, "alpha": 0.15, "linewidth": 0}
            axes.fill_between(curve.time[ends], curve.lower[ends], curve.upper[ends], **band)
        for spread in others:
            if _chosen(arrays, size, velocity, spread).any():
                found = _curve(arrays, horizon, size, velocity, spread)
                axes.step(found.time, found.share, ":", where="post", color=colour, linewidth=0.9)
        _draw_exponential(axes, table[_chosen(table, size, velocity, first)], curve, colour)
    axes.set_xscale("log")
    ends = np.concatenate([line.get_xdata() for line in axes.lines])
    axes.set_xlim(ends[ends > 0].min() / 3, horizon)
    axes.legend(loc="lower left", fontsize=_FONT - 1.5)


def _curve(arrays, horizon, *point):
    """Survival of the runs at one point."""
    runs = _chosen(arrays, *point)
    lifetime, settled = arrays["lifetime"][runs], arrays["settled"][runs]
    return survival.kaplan_meier(lifetime, settled, horizon=horizon)


def _half_ends(arrays, horizon, size, spread):
    """The u at which about half of the runs of this N end; of equals, that with the longest."""
    chosen = (arrays["n_blocks"] == size) & (arrays["initial_spread"] == spread)

    def unlike(velocity):
        lifetime = arrays["lifetime"][chosen & (arrays["belt_velocity"] == velocity)]
        return abs(np.mean(lifetime > horizon) - 0.5), -lifetime.mean()

    return min(np.unique(arrays["belt_velocity"][chosen]), key=unlike)


def _chosen(columns, *point):
    """Which runs, or rows, are at this N, u and initial spread."""
    return np.all([columns[name] == value for name, value in zip(_POINT, point, strict=True)], 0)


def _draw_exponential(axes, rows, curve, colour):
    """The exponential with the mean lifetime, from the start of the count on."""
    if rows.empty or not np.isfinite(rows["lifetime"].iloc[0]):
        return
    start, mean = rows["start"].iloc[0], rows["lifetime"].iloc[0]
    left = curve.share[np.searchsorted(curve.time, start, side="right") - 1]
    time = np.geomspace(max(start, mean / 100), curve.time[-1], 100)
    axes.plot(time, left * np.exp(-(time - start) / mean), "--", color=colour, linewidth=0.8)


# --- mean lifetimes -------------------------------------------------------------------------------


def _draw_by_size(axes, table, colours):
    """A dot for each u at each N: full for the smallest initial spread, open for the others."""
    axes.set_xticks(list(colours))
    known = table[table["lifetime_lower"].notna()]
    if known.empty:
        panels.note(axes, "no mean lifetimes")
        return
    spreads = np.unique(known["initial_spread"])
    for index, spread in enumerate(spreads):
        rows = known[known["initial_spread"] == spread]
        place = rows["n_blocks"] + 0.25 * (index - (spreads.size - 1) / 2)
        ended = np.isfinite(rows["lifetime"])
        look = {"linestyle": "none", "color": style.BLUE, "markersize": 3.5}
        look |= {"markerfacecolor": "none"} if index else {}
        axes.plot(
            place[ended], rows["lifetime"][ended], "o", label=f"initial spread {spread:g}", **look
        )
        _draw_limits(axes, place[~ended], rows["lifetime_lower"][~ended], style.BLUE)
    axes.set_xlim(min(colours) - 0.6, max(colours) + 0.6)
    axes.legend(loc="lower right", fontsize=_FONT - 1.5)


def _draw_by_velocity(axes, table, colours):
    """A curve for each N with bars, of the smallest initial spread, side by side."""
    known = table[table["lifetime_lower"].notna()]
    known = known[known["initial_spread"] == known["initial_spread"].min()]
    if known.empty:
        panels.note(axes, "no mean lifetimes")
        return
    velocities = np.unique(known["belt_velocity"])
    step = 0.08 * np.diff(velocities).min(initial=10.0)
    for index, (size, colour) in enumerate(colours.items()):
        rows = known[known["n_blocks"] == size]
        place = rows["belt_velocity"] + step * (index - (len(colours) - 1) / 2)
        ended = np.isfinite(rows["lifetime"])
        axes.plot(place, rows["lifetime"].where(ended), color=colour, linewidth=0.6)
        mean, lower, upper = (
            rows[name][ended] for name in ("lifetime", "lifetime_lower", "lifetime_upper")
        )
        look = {"color": colour, "marker": style.MARKERS[index % len(style.MARKERS)]}
        look |= {"linestyle": "none", "markersize": 3.5, "elinewidth": 0.9}
        both = [mean - lower, upper - mean]
        axes.errorbar(place[ended], mean, both, label=f"$N = {size}$", **look)
        _draw_limits(axes, place[~ended], rows["lifetime_lower"][~ended], colour)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.03))


def _draw_limits(axes, place, lower, colour):
    """Arrows up from lower limits."""
    if len(place):
        look = {"color": colour, "linestyle": "none", "elinewidth": 0.9, "capsize": 2.0}
        axes.errorbar(place, lower, lower, lolims=True, **look)
