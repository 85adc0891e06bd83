"""Figs. 19 to 22: other numbers of blocks."""

import numpy as np
from matplotlib import rc_context

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats import motion, sections

FIGURES = {
    "fig19": Figure(uses=("critical_velocities", "n5_replicates", "size_replicates"), number="19"),
    "fig20": Figure(
        uses=("n10_u28", "n10_u31", "n10_u34", "n10_u38", "size_replicates"), number="20"
    ),
    "fig21": Figure(uses=("size_columns", "critical_velocities"), number="21"),
    "fig22": Figure(uses=("size_density", "motions"), number="22"),
}


# --- Fig. 19: the fall of r for several system sizes ----------------------------------------------

NOISE = 1.0
SIZES = (2, 3, 4, 6, 7, 10)


@panels.draws(FIGURES)
def fig19(data):
    """a: r(u) at sigma = 1 for each N, means of runs over bands; b: where it falls."""
    figure, (axes, below) = panels.page(4.05, "a;b", sharex=True, height_ratios=(2.6, 1))
    for name in panels.REPLICATES:
        for n_blocks in panels.levels(data[name], "n_blocks"):
            row = sections.cut(data[name], n_blocks=n_blocks, noise=NOISE)
            look = style.look_of_size(n_blocks) | {"label": f"$N = {n_blocks}$"}
            panels.band(axes, row["belt_velocity"], row["disorder_parameter"], **look)
    panels.finish_curves(axes, xlabel="", ncols=6, handlelength=2)
    rows = panels.independent_falls(data["critical_velocities"], "noise", NOISE)
    regions = {int(n): ends for n, ends in printed("transition-width").items()}
    names = zip(rows["n_blocks"], rows["dataset"], strict=True)
    reach = {n: _reach(data[name], n) for n, name in names}
    ends = {n: one["ends"] for n, one in reach.items()}
    panels.falls(below, rows, "n_blocks", style.colour_of_size, regions, ends)
    below.set(ylabel="$N$", xlim=(0, None))
    axes.text(0.97, 0.95, rf"$\sigma = {NOISE:g}$", ha="right", va="top", transform=axes.transAxes)
    widths = [reach[n]["width"] for n in sorted(regions) if n in reach]
    words = f"width\npaper: grows with $N$\nhere: {_trend(widths)}"
    below.text(0.02, 0.06, words, transform=below.transAxes)
    return figure


def _trend(widths):
    """Whether the last of these intervals lies above the first."""
    if len(widths) < 2 or (widths[0][0] <= widths[-1][1] and widths[-1][0] <= widths[0][1]):
        return "undecided"
    return "grows" if widths[-1][0] > widths[0][1] else "shrinks"


@panels.reduced
def _reach(scan, n_blocks):
    """Where the fall of r begins at the earliest and ends at the latest; interval of its width."""
    row = Cut.of(scan, n_blocks=n_blocks, noise=NOISE)
    ends = row.fall["lower"].low, row.fall["upper"].high
    width = row.fall["width"]
    return {
        "ends": np.minimum(ends, row.belt_velocity.max()),
        "width": np.array([width.low, width.high]),
    }


# --- Fig. 20: ten blocks in their transition region -----------------------------------------------

SHOWN_LENGTH = 10000.0  # length of the part of a series that is drawn
N_BLOCKS = 10


@panels.draws(FIGURES)
def fig20(data):
    """a to d: x_N(t) after the transient; e: last stick of each run; f: share that sticks on."""
    scan = data["size_replicates"]
    laminar_time = float(scan.attributes["laminar_time"])
    series = (data[name] for name in FIGURES["fig20"].uses if name != "size_replicates")
    every = sorted(series, key=lambda one: one.attributes["belt_velocity"])
    figure, (*stack, last_sticks, lasting) = panels.page(
        4.05, "aa;bb;cc;dd;ef", height_ratios=(1, 1, 1, 1, 2)
    )
    for axes, series in zip(stack, every, strict=True):
        axes.sharex(stack[0])
        axes.sharey(stack[0])
        axes.tick_params(labelbottom=axes is stack[-1])
        panels.laminar_trace(axes, series, laminar_time, SHOWN_LENGTH)
    stack[-1].set_xlabel("$t$ since the left edge of the panel")
    _last_sticks(last_sticks, lasting, scan, laminar_time)
    panels.heading(figure, every[0].attributes, ("n_blocks", "noise"))
    return figure


def _last_sticks(axes, beside, scan, laminar_time):
    """Last stick of the last block of each run; beside it the share that sticks to the end."""
    row = sections.cut(scan, n_blocks=N_BLOCKS, noise=0.0)
    velocity, transient = row["belt_velocity"], float(scan.attributes["transient"])
    duration = float(scan.attributes["duration"])
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="last stick\n(share of run)", ylim=(-0.05, 1.05))
    beside.set(xlabel=panels.BELT_VELOCITY, ylabel="share sticking\nto the end", ylim=(-0.05, 1.05))
    # a run that never sticks after the transient has none
    last = np.where(np.isfinite(row["last_stick_time"]), row["last_stick_time"], transient)
    lasting = last > duration - laminar_time
    look = {"color": style.BLUE, "markersize": 3, "alpha": 0.5}
    axes.plot(velocity, last / duration, ".", **look)
    places = np.unique(velocity)
    share = [lasting[velocity == place].mean() for place in places]
    beside.plot(places, share, "o-", color=style.VERMILION, markersize=3)
    axes.axhline(transient / duration, color="0.5", linewidth=0.8, linestyle=":")
    axes.text(8, transient / duration, "transient", va="top", clip_on=True)


# --- Fig. 21: the rise of r with noise for several system sizes -----------------------------------


@panels.draws(FIGURES)
def fig21(data):
    """r(sigma) of several N, each at its u: means of runs over a band of 10 to 90 % of them."""
    arrays, figure = data["size_columns"].arrays, style.page(2.9)
    axes = figure.subplots()
    falls = panels.independent_falls(data["critical_velocities"], "noise", 0).set_index("n_blocks")
    places = {}
    for n, u in sorted(set(zip(arrays["n_blocks"], arrays["belt_velocity"], strict=True))):
        face = "white" if any(size == n for size, _ in places) else None
        look = {"markerfacecolor": face, "label": f"$N = {n}$, $u = {u:g}$"}
        places[n, u] = style.look_of_size(n) | look
        if n in falls.index and falls["lower"][n] < u < falls["upper"][n]:
            places[n, u] |= {"linewidth": 0.5, "markersize": 1.5}
    panels.against_noise(axes, data["size_columns"], places, ncols=2)
    for line, (n, _), look in zip(list(axes.lines), places, places.values(), strict=False):
        if "linewidth" in look:
            look = {"color": line.get_color(), "textcoords": "offset points", "ha": "right"}
            words = f"$N = {n}$: $u$ within its fall"
            axes.annotate(words, line.get_xydata()[-1], (0, -6), va="top", **look)
    return figure


# --- Fig. 22: bifurcation diagrams of other system sizes ------------------------------------------

MOST_NOISES = 3
FOOT = 0.09  # height of the strip of motions, as a share of the panel
IRREGULAR = [motion.CHAOTIC, motion.STABLE_CHAOS, motion.TRANSIENT]


@panels.draws(FIGURES)
@rc_context({"font.size": 9.0})
def fig22(data):
    """v_N at the section against u, a row for each N, a column for each noise."""
    scan = data["size_density"]
    noises = panels.levels(scan, "noise")[:MOST_NOISES]
    figure = style.page(8.2, wide=True)
    figure.set_dpi(200)  # the noise of so many pixels makes a large file at 300
    grid = figure.subplots(len(SIZES), max(noises.size, 1), sharex=True, sharey=True, squeeze=False)
    cells = [
        (axes, {"n_blocks": n_blocks, "noise": noise})
        for n_blocks, row in zip(SIZES, grid, strict=True)
        for noise, axes in zip(noises, row, strict=True)
    ]
    panels.diagrams(scan, cells)
    for axes, where in cells:
        words = f"$N = {where['n_blocks']}$\n{panels.VELOCITY}"
        axes.set(xlabel=panels.BELT_VELOCITY, ylabel=words)
        axes.label_outer()
    for axes, noise in zip(grid[0], noises, strict=True):
        axes.set_title(rf"$\sigma = {noise:g}$")
    for axes, n_blocks in zip(grid[:, 0], SIZES, strict=True):
        _motions(axes, data["motions"].query(f"n_blocks == {n_blocks}"))
    panels.letters(*grid[:, 0])
    panels.squares(figure, "foot: runs that end periodic", "irregular to the end")
    grid[0, 0].set_xlim(left=0)
    return figure


def _motions(axes, table):
    """At the foot the shares of runs at each u that end in either kind of motion."""
    share = FOOT * table[IRREGULAR].sum(axis=1) / table["runs"]
    place, width = table["belt_velocity"], table["belt_velocity"].diff().min()
    look = {"width": width, "linewidth": 0, "transform": axes.get_xaxis_transform()}
    for height, colour in zip((FOOT, share), panels.SQUARES, strict=True):
        axes.bar(place, height, color=colour, **look)
