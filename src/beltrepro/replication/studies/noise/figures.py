"""Figs. 13 to 18: noise and the transition, and intermittency."""

import numpy as np
import pandas as pd
from matplotlib.colors import BoundaryNorm

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.noise import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.replication.verdicts.motions import N_BLOCKS
from beltrepro.stats import sections, states

FIGURES = {
    "fig13": Figure(
        uses=("n5_replicates", "n5_replicates_check", "n5_rows", "n5_rows_check"), number="13"
    ),
    "fig14": Figure(uses=("n5_rows", "n5_u7"), number="14", shows={"sigma-c-u7": ("sigma_c",)}),
    "fig15": Figure(uses=("n5_columns",), number="15"),
    "fig16": Figure(uses=("u17", "u19", "n5_replicates"), number="16"),
    "fig17": Figure(uses=("n5_rows",), number="17"),
    "fig18": Figure(uses=("n5_map", "n5_replicates"), number="18"),
}


# --- Fig. 13: the fall of r at several noise levels -----------------------------------------------

LEFT_OUT = (0.25, 0.5)  # levels at which nothing differs from those beside them


@panels.draws(FIGURES)
def fig13(data):
    """a: r(u) of single runs of five blocks, for each noise; b: r of independent runs."""
    names = ("n5_rows", "n5_replicates")
    figure, grid = panels.page(4.2, "a;b", sharey=True)
    noises = sorted({noise for name in names for noise in _levels(data[name])})
    for axes, name in zip(grid, names, strict=True):
        for scan, _ in panels.layers(data, name):
            for noise in _levels(scan):
                row = sections.cut(scan, n_blocks=N_BLOCKS, noise=noise)
                scheme = panels.METHODS["verlet"]
                overlay = scheme if (row["method"].astype(str) == "verlet").all() else ""
                points = row["belt_velocity"], row["disorder_parameter"]
                index, label = noises.index(noise), rf"$\sigma = {noise:g}$"
                if name == "n5_rows":
                    panels.single_runs(axes, *points, index, label=label, overlay=overlay)
                elif overlay:
                    colour = style.line_style(index)["color"]
                    panels.crosses(axes, *points, colour, overlay)
                else:
                    # Without noise several branches coexist at most u.
                    alone = {} if noise else {"linestyle": "none", "apart": 0.0}
                    panels.draw_runs(axes, *points, index, label=label, **alone)
        panels.finish_curves(axes, xlabel=panels.BELT_VELOCITY)
    _printed(grid[0])
    grid[0].set_xlim(left=0)
    return figure


def _printed(axes):
    axes.set_ylim(top=1.15 * axes.get_ylim()[1])
    place = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points", "va": "center"}
    for velocity, words, side in (
        (printed("u-critical"), r"paper: $u_c$ at $\sigma = 0$", "right"),
        (printed("uc-sigma22")["u_c"], r"at $\sigma = 2.2$", "left"),
    ):
        look = {"color": style.BLACK, "markersize": 7, "markeredgewidth": 1.4}
        axes.plot(velocity, 0.94, "|", transform=axes.get_xaxis_transform(), **look)
        shift = (-4 if side == "right" else 4), 0
        axes.annotate(words, (velocity, 0.94), xytext=shift, ha=side, **place)


def _levels(scan):
    return [noise for noise in panels.levels(scan, "noise") if noise not in LEFT_OUT]


# --- Fig. 14: periodic windows and noise ----------------------------------------------------------

BELT_VELOCITY = 7.0
STRIP_BINS = 60  # of v_N


@panels.draws(FIGURES)
def fig14(data):
    """a: v_N at the section against u, a strip for each noise; b: r(sigma) at u = 7."""
    figure = style.page(6.4)
    upper, lower = figure.add_gridspec(2, 1, height_ratios=(2.2, 1))
    levels = panels.levels(data["n5_rows"], "noise")
    places = upper.subgridspec(max(levels.size, 1), 1)
    strips = places.subplots(sharex=True, sharey=True, squeeze=False)[:, 0]
    rows = [sections.cut(data["n5_rows"], n_blocks=N_BLOCKS, noise=noise) for noise in levels]
    panels.band_densities(strips[: levels.size], rows, bins=STRIP_BINS)
    for axes, noise in zip(strips, levels, strict=False):
        panels.remark(axes, rf"$\sigma = {noise:g}$")
        axes.set_ylabel(panels.VELOCITY)
    strips[-1].set(xlabel=panels.BELT_VELOCITY, xlim=(0, None))
    below = figure.add_subplot(lower)
    panels.letters(strips[0], below)
    _column(below, data["n5_u7"])
    return figure


def _column(axes, scan):
    """r(sigma) at one belt velocity, with the noise at which it rises, here and in the paper."""
    column = sections.cut(scan, n_blocks=N_BLOCKS, belt_velocity=BELT_VELOCITY)
    noise, disorder = column["noise"], column["disorder_parameter"]
    panels.draw_runs(axes, noise, disorder, 0)
    panels.finish_curves(axes, xlabel=panels.NOISE)
    words, critical = f"$u = {BELT_VELOCITY:g}$", np.nan
    with panels.shortage_on(axes, place=(0.5, 0.25)):
        critical = measure.rise(noise, disorder)["critical"].value
        if np.isfinite(critical):
            line = axes.axvline(critical, color=style.VERMILION, linestyle="--", zorder=0)
            words += rf": $\sigma_c = {critical:.2f}$"
            panels.shows(line, "sigma-c-u7", "sigma_c")
    value = printed("sigma-c-u7")
    axes.axvline(value, color=style.BLACK, linestyle=":", zorder=0)
    text = panels.remark(axes, f"{words} (dashed), paper: {value} (dotted)")
    if np.isfinite(critical):
        panels.shows(text, "sigma-c-u7", "sigma_c")


# --- Fig. 15: r rises with noise ------------------------------------------------------------------

GUIDE = 5.0  # a line at this sigma, only to guide the eye


@panels.draws(FIGURES)
def fig15(data):
    """r(sigma) of five blocks: a run at each point, and all runs, a panel for each u."""
    velocities = panels.levels(data["n5_columns"], "belt_velocity")
    figure = style.page(4.6)
    places = {(N_BLOCKS, u): f"$u = {u:g}$" for u in velocities}
    for axes in panels.against_noise(figure, data, "n5_columns", places, across=3):
        axes.axvline(GUIDE, color=style.BLACK, linewidth=0.6, linestyle="--", zorder=0)
    return figure


# --- Fig. 16: noise-induced intermittency ---------------------------------------------------------

SHOWN = 60000.0  # length of the part of a series that is drawn
VELOCITIES = (13.7, 24.3)  # shown in e


@panels.draws(FIGURES)
def fig16(data):
    """a, b: x_N(t); c, d: spectra after the transient; e: share of laminar phases against u."""
    scan = data["n5_replicates"]
    laminar_time = scan.attributes["laminar_time"]
    figure, (*traces, left, right, below) = panels.page(5.2, "aa;bb;cd;ee")
    for axes, spectrum, name in zip(traces, (left, right), ("u17", "u19"), strict=True):
        series = data[name]
        window = panels.half_laminar(series, laminar_time, SHOWN)
        panels.laminar_trace(axes, series, laminar_time, window)
        axes.set_xlabel(panels.TIME)
        axes.locator_params(axis="x", nbins=5)
        panels.spectrum(spectrum, series)
        velocity = series.attributes["belt_velocity"]
        panels.remark(spectrum, f"$u = {velocity:g}$")
        below.axvline(velocity, color="0.4", linewidth=0.8, linestyle="--")
    noise = data["u17"].attributes["noise"]
    row = sections.cut(scan, n_blocks=N_BLOCKS, noise=noise)
    share = row["belt_velocity"], row["laminar_fraction"]
    panels.draw_runs(below, *share, 0, apart=np.inf)
    below.set(xlabel=panels.BELT_VELOCITY, ylabel="laminar share", ylim=(-0.05, 1.05))
    below.set_xlim(*VELOCITIES)
    if not row["noise"].size:
        panels.note(below, "no run at this noise")
    panels.remark(below, rf"$\sigma = {noise:g}$")
    return figure


# --- Fig. 17: natural distribution over belt velocity ---------------------------------------------

NOISES = (0.0, 1.0, 5.0, 10.0)
BINS = 120
FOOT = 0.04  # height of the marks, as a share of the panel


@panels.draws(FIGURES)
def fig17(data):
    """Density of v_N at the section for each u, on the plane (u, v_N), a panel per noise level."""
    rows = {s: sections.cut(data["n5_rows"], n_blocks=N_BLOCKS, noise=s) for s in NOISES}
    figure, grid = panels.page(4.0, "ab;cd", sharex=True, sharey=True)
    bar = {"location": "bottom", "aspect": 40, "format": "%g"}
    span = panels.band_densities(grid, list(rows.values()), bins=BINS, **bar)
    for axes, (noise, row) in zip(grid, rows.items(), strict=True):
        axes.set_title(rf"$\sigma = {noise:g}$")
        _marks(axes, row, span)
        axes.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.VELOCITY)
        axes.label_outer()
    return figure


def _marks(axes, row, span):
    """At the foot of each u: whether the last block slips on, or both motions take turns."""
    low, high = states.LAMINAR_SHARE
    share = sections.spread(row["belt_velocity"], row["laminar_fraction"])
    foot = span[0] - FOOT / 2 * (span[1] - span[0])
    for chosen, colour in (
        (share.mean > high, style.BLUE),
        ((share.mean >= low) & (share.mean <= high), style.ORANGE),
    ):
        if chosen.any():
            places = share.place[chosen]
            axes.plot(places, np.full(places.size, foot), "|", color=colour, markersize=5)
    axes.set_ylim(span[0] - FOOT * (span[1] - span[0]), span[1])


# --- Fig. 18: map of the disorder parameter -------------------------------------------------------

STEP = 0.02  # of r, from one colour to the next
_ONE_MOTION = 0.5  # largest range of the laminar shares at one u, for a line to join their means
UNSHOWN = (0.5,)  # noise at which b shows what it shows at 0 and 1


@panels.draws(FIGURES)
def fig18(data):
    """a: r over the plane (u, sigma), dots where `intermittent_mask` holds; b: laminar shares."""
    points = data["n5_map"].arrays
    measured = (points["n_blocks"] == N_BLOCKS) & np.isfinite(points["disorder_parameter"])
    points = sections.select(points, measured)
    figure, (above, below) = panels.page(4.6, "a;b", height_ratios=(1.7, 1))
    above.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.NOISE)
    if points["noise"].size:
        columns = {name: points[name] for name in ("noise", "belt_velocity", "disorder_parameter")}
        table = pd.DataFrame(columns).pivot_table(
            "disorder_parameter", "noise", "belt_velocity", aggfunc="median"
        )
        levels = STEP * np.arange(np.ceil(table.max().max() / STEP - 1e-9) + 1)
        look = {"cmap": "viridis", "norm": BoundaryNorm(levels, 256), "rasterized": True}
        image = above.pcolormesh(table.columns, table.index, table, **look)
        figure.colorbar(image, ax=above, pad=0.01, label=panels.DISORDER)
        _dots(above, points)
    else:
        panels.note(above, "no points in this scan")
    _shares(below, data["n5_replicates"])
    return figure


def _dots(axes, points):
    """A white dot at each intermittent point."""
    mask = states.intermittent_mask(points)
    panels.remark(axes, "white: motion alternates" if mask.any() else "no point is intermittent")
    look = {"color": "white", "markeredgecolor": "black", "markersize": 2.4}
    place = points["belt_velocity"][mask], points["noise"][mask]
    axes.plot(*place, "o", markeredgewidth=0.4, clip_on=False, **look)


def _shares(axes, scan):
    noises = [noise for noise in panels.levels(scan, "noise") if noise not in UNSHOWN]
    for index, noise in enumerate(noises):
        row = sections.cut(scan, n_blocks=N_BLOCKS, noise=noise)
        share = row["belt_velocity"], row["laminar_fraction"]
        label = rf"$\sigma = {noise:g}$"
        spread = sections.spread(*share)
        # runs that keep to one of both motions have a mean, but no motion has it
        agree = np.all(spread.high - spread.low <= _ONE_MOTION)
        look = {"apart": np.inf} if agree else {"apart": 0.0, "linestyle": "none"}
        panels.draw_runs(axes, *share, index, label=label, **look)
    for limit in states.LAMINAR_SHARE:
        axes.axhline(limit, color="0.5", linewidth=0.8, linestyle=":")
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="laminar share", ylim=(-0.04, 1.04))
    panels.legend_above(axes)
