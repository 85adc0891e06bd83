"""Figs. 19 to 22: other numbers of blocks."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats import sections

FIGURES = {
    "fig19": Figure(
        uses=(
            "critical_velocities",
            "n5_replicates",
            "size_replicates",
            "n5_rows",
            "n5_rows_check",
            "size_rows",
            "size_rows_check",
        ),
        number="19",
    ),
    "fig20": Figure(
        uses=("n10_u28", "n10_u31", "n10_u34", "n10_u38", "size_replicates"), number="20"
    ),
    "fig21": Figure(uses=("size_columns",), number="21"),
    "fig22": Figure(uses=("size_density",), number="22"),
}


# --- Fig. 19: the fall of r for several system sizes ----------------------------------------------

NOISE = 1.0
SHOWN = (5, 7, 10)
ORDER = (5, 7, 10, 2, 3, 4, 6)  # numbers of blocks in the order of the styles


@panels.draws(FIGURES)
def fig19(data):
    """a: r(u) at sigma = 1 over replicates for N = 5, 7, 10; b: single runs for every N."""
    figure, (above, below) = panels.page(4.4, "a;b", sharex=True)
    for n_blocks in SHOWN:
        for name in ("n5_replicates", "size_replicates"):
            points = _row(data[name], n_blocks)
            panels.draw_runs(above, *points, label=f"$N = {n_blocks}$")
    for name in ("n5_rows", "size_rows"):
        for scan, overlay in panels.layers(data, name):
            for n_blocks in panels.levels(scan, "n_blocks"):
                *points, index = _row(scan, n_blocks)
                look = {"label": f"$N = {n_blocks}$"}
                if overlay:
                    look = {"overlay": f"$N = {n_blocks}$, {overlay}"}
                    look["color"] = style.line_style(index)["color"]
                panels.single_runs(below, *points, index, **look)
    for axes in (above, below):
        panels.finish_curves(axes, xlabel=panels.BELT_VELOCITY)
        axes.label_outer()
    _strips(above, data["critical_velocities"])
    above.set_xlim(left=0)
    return figure


def _row(scan, n_blocks):
    """u and r of the runs of a number of blocks, and the number of its style."""
    row = sections.cut(scan, n_blocks=n_blocks, noise=NOISE)
    return row["belt_velocity"], row["disorder_parameter"], _index(n_blocks)


def _index(n_blocks):
    return ORDER.index(n_blocks) if n_blocks in ORDER else int(n_blocks)


def _strips(axes, table):
    """The printed regions as strips at the top; below each the middle of the fall that we find."""
    axes.set_ylim(top=axes.get_ylim()[1] * 1.5)
    in_scans = table["dataset"].isin(["n5_replicates", "size_replicates"])
    table = table[in_scans & (table["noise"] == NOISE) & table["critical"].notna()]
    for place, n_blocks in enumerate(SHOWN):
        low, high = printed("transition-width")[str(n_blocks)]
        words = f"{'' if place else 'paper: '}$N = {n_blocks}$"
        top = 0.98 - 0.11 * place
        panels.printed_range(axes, low, high, words, top=top)
        for row in table[table["n_blocks"] == n_blocks].itertuples():
            reach = [[row.critical - row.low], [row.high - row.critical]]
            look = style.line_style(_index(n_blocks)) | {"markersize": 3, "linestyle": "none"}
            look |= {"capsize": 1.5, "elinewidth": 0.8, "transform": axes.get_xaxis_transform()}
            axes.errorbar([row.critical], [top - 0.06], xerr=np.nan_to_num(reach), **look)


# --- Fig. 20: ten blocks in their transition region -----------------------------------------------

SHOWN_LENGTH = 10000.0  # length of the part of a series that is drawn
N_BLOCKS = 10


@panels.draws(FIGURES)
def fig20(data):
    """a to d: x_N(t) after the transient; e: last stick of each run against belt velocity."""
    scan = data["size_replicates"]
    laminar_time = float(scan.attributes["laminar_time"])
    series = (data[name] for name in FIGURES["fig20"].uses if name != "size_replicates")
    every = sorted(series, key=lambda one: one.attributes["belt_velocity"])
    figure, (*stack, below) = panels.page(5.6, "a;b;c;d;e", height_ratios=(1, 1, 1, 1, 1.5))
    for axes, series in zip(stack, every, strict=True):
        axes.sharex(stack[0])
        axes.sharey(stack[0])
        axes.tick_params(labelbottom=axes is stack[-1])
        begin, _ = panels.half_laminar(series, laminar_time, SHOWN_LENGTH)
        panels.laminar_trace(axes, series, laminar_time, (begin, begin + SHOWN_LENGTH), zero=begin)
    stack[-1].set_xlabel("$t$ since the left edge of the panel")
    _last_sticks(below, scan, laminar_time)
    return figure


def _last_sticks(axes, scan, laminar_time):
    """Last stick of the last block of each run, and the share of runs that stick to the end."""
    row = sections.cut(scan, n_blocks=N_BLOCKS, noise=0.0)
    velocity, transient = row["belt_velocity"], float(scan.attributes["transient"])
    duration = float(scan.attributes["duration"])
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="last stick / length of run", ylim=(-0.05, 1.12))
    # a run that never sticks after the transient has none
    last = np.where(np.isfinite(row["last_stick_time"]), row["last_stick_time"], transient)
    lasting = last > duration - laminar_time
    look = {"color": style.BLUE, "markersize": 3, "alpha": 0.5}
    axes.plot(velocity, last / duration, ".", label="a run", **look)
    places = np.unique(velocity)
    share = [lasting[velocity == place].mean() for place in places]
    look = {"color": style.VERMILION, "markerfacecolor": "none", "markersize": 5}
    axes.plot(places, share, "o", **look, label="share that sticks to the end")
    axes.axhline(transient / duration, color="0.5", linewidth=0.8, linestyle=":")
    panels.legend_above(axes)


# --- Fig. 21: the rise of r with noise for several system sizes -----------------------------------


@panels.draws(FIGURES)
def fig21(data):
    """r(sigma): a run at each point, and all runs, a panel for each number of blocks and u."""
    arrays = data["size_columns"].arrays
    points = sorted(set(zip(arrays["n_blocks"], arrays["belt_velocity"], strict=True)))
    figure = style.page(4.6)
    places = {(n, u): f"$N = {n}$, $u = {u:g}$" for n, u in points}
    panels.against_noise(figure, data, "size_columns", places, across=2)
    return figure


# --- Fig. 22: bifurcation diagrams of other system sizes ------------------------------------------

SIZES = (2, 3, 4, 6, 7, 10)
MOST_NOISES = 3


@panels.draws(FIGURES)
def fig22(data):
    """v_N at the section against u, a row for each N, a column for each noise."""
    scan = data["size_density"]
    noises = panels.levels(scan, "noise")[:MOST_NOISES]
    figure = style.page(7.0, wide=True)
    grid = figure.subplots(len(SIZES), max(noises.size, 1), sharex=True, sharey=True, squeeze=False)
    cells = [
        (axes, {"n_blocks": n_blocks, "noise": noise})
        for n_blocks, row in zip(SIZES, grid, strict=True)
        for noise, axes in zip(noises, row, strict=True)
    ]
    panels.diagrams(figure, scan, cells)
    for axes, where in cells:
        axes.text(0.99, 0.08, f"$N = {where['n_blocks']}$", ha="right", transform=axes.transAxes)
        axes.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.VELOCITY)
        axes.label_outer()
    for axes, noise in zip(grid[0], noises, strict=True):
        axes.set_title(rf"$\sigma = {noise:g}$")
    grid[0, 0].set_xlim(left=0)
    return figure
