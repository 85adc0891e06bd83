"""Figs. 13 to 18: noise and the transition, and intermittency."""

import numpy as np
import pandas as pd
import scipy
from matplotlib.patheffects import withStroke

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.noise import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.replication.verdicts.motions import N_BLOCKS
from beltrepro.simulation import artists
from beltrepro.stats import sections, states

FIGURES = {
    "fig13": Figure(uses=("n5_density", "critical_velocities"), number="13"),
    "fig14": Figure(uses=("n5_density", "n5_u7"), number="14", shows={"sigma-c-u7": ("sigma_c",)}),
    "fig15": Figure(uses=("n5_columns",), number="15"),
    "fig16": Figure(uses=("u17", "u19", "n5_replicates"), number="16"),
    "fig17": Figure(uses=("n5_density",), number="17"),
    "fig18": Figure(
        uses=("n5_map", "n5_replicates", "critical_velocities"),
        number="18",
        shows={"uc-of-sigma: exact dynamics": ("u_c(?)", "u_c(?.?)")},
    ),
}


# --- Fig. 13: the fall of r at several noise levels -----------------------------------------------

NO_BANDS = 40.0  # beyond this u bands of all noises would cover each other
FALLS = 14, 34  # u between which r falls


@panels.draws(FIGURES)
def fig13(data):
    """a: r(u) of five blocks for each noise, means over bands of runs; b: where it falls."""
    scan = data["n5_density"]
    figure, (axes, below) = panels.page(4.05, "a;b", height_ratios=(2.1, 1))
    for noise in panels.levels(scan, "noise"):
        row = sections.cut(scan, n_blocks=N_BLOCKS, noise=noise)
        place = panels.together(row["belt_velocity"])
        look = style.look_of_noise(noise) | {"label": rf"$\sigma = {noise:g}$"}
        panels.band(axes, place, row["disorder_parameter"], shaded=place < NO_BANDS, **look)
    panels.finish_curves(
        axes, xlabel=panels.BELT_VELOCITY, ncols=5, handlelength=1.4, columnspacing=0.5
    )
    axes.set_xlim(left=0)
    look = {"transform": axes.transAxes, "ha": "right", "va": "top"}
    axes.text(0.99, 0.98, f"no bands from {NO_BANDS:g} on:\nthey would overlap", **look)
    paper = {0.0: printed("u-critical"), 2.2: printed("uc-sigma22")["u_c"]}
    rows = panels.independent_falls(data["critical_velocities"], "n_blocks", N_BLOCKS)
    panels.falls(below, rows, "noise", lambda s: style.look_of_noise(s)["color"], paper)
    below.set(ylabel=panels.NOISE, xlim=FALLS, xticks=range(15, 31, 5))
    return figure


# --- Fig. 14: periodic windows and noise ----------------------------------------------------------

BELT_VELOCITY = 7.0


@panels.draws(FIGURES)
def fig14(data):
    """a: v_N at the section against u, a strip for each noise; b: r(sigma) at u = 7."""
    scan, figure = data["n5_density"], style.page(4.05)
    upper, lower = figure.add_gridspec(2, 1, height_ratios=(3, 1))
    levels = panels.levels(scan, "noise")
    strips = upper.subgridspec(max(levels.size, 1), 1).subplots(sharex=True, squeeze=False)[:, 0]
    places = [(axes, _row(noise)) for axes, noise in zip(strips, levels, strict=False)]
    panels.diagrams(scan, places, bar="right")
    for axes, noise in zip(strips, levels, strict=False):
        look = {"transform": axes.transAxes, "rotation": 90, "va": "center"}
        axes.text(1.01, 0.5, rf"$\sigma = {noise:g}$", **look)
        axes.set_ylabel(panels.VELOCITY)
    strips[-1].set(xlabel=panels.BELT_VELOCITY, xlim=(0, None))
    below = figure.add_subplot(lower)
    panels.letters(strips[0], below)
    _column(below, data["n5_u7"])
    return figure


def _row(noise):
    return {"n_blocks": N_BLOCKS, "noise": noise}


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
            line = axes.axvline(critical, **style.HERE, zorder=0)
            words += rf": $\sigma_c = {critical:.2f}$"
            panels.shows(line, "sigma-c-u7", "sigma_c")
    value = printed("sigma-c-u7")
    axes.axvline(value, **style.PAPER, zorder=0)
    text = panels.remark(axes, f"{words} (red), paper: {value} (dashed)")
    if np.isfinite(critical):
        panels.shows(text, "sigma-c-u7", "sigma_c")


# --- Fig. 15: r rises with noise ------------------------------------------------------------------

GUIDE = 5.0  # a line at this sigma, only to guide the eye
LINE = 0.006  # height of a line of words, in r


@panels.draws(FIGURES)
def fig15(data):
    """r(sigma) of five blocks at several u: means of runs over a band of 10 to 90 % of them."""
    velocities = panels.levels(data["n5_columns"], "belt_velocity")
    figure = style.page(2.9)
    axes = figure.subplots()
    places, shades = {}, style.shades(velocities.size)
    for index, u in enumerate(velocities):
        look = {"color": shades[index], "marker": style.MARKERS[index % 7]}
        places[N_BLOCKS, u] = look | {"shaded": index % 2 == 0}  # all bands are a fog
    panels.against_noise(axes, data["n5_columns"], places)
    height, ends = np.inf, zip(axes.lines, velocities, shades, strict=False)
    for line, u, shade in sorted(ends, key=lambda one: -one[0].get_ydata()[-1]):
        place, end = line.get_xydata()[-1]
        height = min(end, height - LINE)
        axes.text(place + 0.15, height, f"$u = {u:g}$", color=shade, va="center")
        axes.set_xlim(right=1.17 * place)
    axes.axvline(GUIDE, color=style.GREY, linewidth=1.0, linestyle="--", zorder=0)
    panels.beside(axes, GUIDE, 0.04, "guide to the eye")
    look = {"transform": axes.transAxes, "va": "top"}
    axes.text(0.03, 0.97, "without noise:\nsingle runs on\nseveral attractors", **look)
    return figure


# --- Fig. 16: noise-induced intermittency ---------------------------------------------------------

SHOWN = 60000.0  # length of the part of a series that is drawn
VELOCITIES = (13.7, 24.3)  # shown in e


@panels.draws(FIGURES)
def fig16(data):
    """a: share of laminar phases against u; b, c: x_N(t); d, e: spectra after the transient."""
    scan = data["n5_replicates"]
    laminar_time = scan.attributes["laminar_time"]
    figure, (shares, *traces, left, right) = panels.page(4.05, "aa;bb;cc;de")
    for axes, spectrum, name in zip(traces, (left, right), ("u17", "u19"), strict=True):
        series = data[name]
        panels.laminar_trace(axes, series, laminar_time, SHOWN)
        axes.locator_params(axis="x", nbins=5)
        if name == "u17":
            panels.remark(axes, f"paper's {axes.get_title('right')}")
        panels.spectrum(spectrum, series)
        velocity = series.attributes["belt_velocity"]
        panels.remark(spectrum, f"$u = {velocity:g}$")
        shares.axvline(velocity, color="0.6", linewidth=0.8, zorder=0)
        panels.beside(shares, velocity, 0.7, axes.get_title("left"), left=True, weight="bold")
    traces[-1].set_xlabel(panels.TIME)
    noise = data["u17"].attributes["noise"]
    row = sections.cut(scan, n_blocks=N_BLOCKS, noise=noise)
    share = row["belt_velocity"], row["laminar_fraction"]
    panels.draw_runs(shares, *share, 0, apart=np.inf)
    shares.set(xlabel=panels.BELT_VELOCITY, ylabel="laminar share", ylim=(-0.05, 1.05))
    shares.set_xlim(*VELOCITIES)
    if not row["noise"].size:
        panels.note(shares, "no run at this noise")
    panels.remark(shares, rf"$\sigma = {noise:g}$")
    return figure


# --- Fig. 17: natural distribution over belt velocity ---------------------------------------------

NOISES = (0.0, 1.0, 5.0, 10.0)
FOOT = 0.04  # height of the marks, as a share of the panel


@panels.draws(FIGURES)
def fig17(data):
    """Density of v_N at the section for each u, on the plane (u, v_N), a panel per noise level."""
    scan = data["n5_density"]
    figure, grid = panels.page(4.05, "ab;cd", sharex=True, sharey=True)
    panels.diagrams(scan, [(axes, _row(s)) for axes, s in zip(grid, NOISES, strict=True)])
    for axes, noise in zip(grid, NOISES, strict=True):
        axes.set_title(rf"$\sigma = {noise:g}$")
        _marks(axes, sections.cut(scan, **_row(noise)))
        axes.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.VELOCITY, xticks=range(10, 51, 10))
        axes.label_outer()
    panels.squares(figure, "never sticks", "sticks now and then", "no strip: stick-slip")
    return figure


def _marks(axes, row):
    """A mark at the foot of each u at which the last block does not always stick."""
    low, high = states.LAMINAR_SHARE
    share = sections.spread(row["belt_velocity"], row["laminar_fraction"])
    often = share.mean > high, (share.mean >= low) & (share.mean <= high)
    for chosen, colour in zip(often, panels.SQUARES, strict=True):
        if chosen.any():
            places = share.place[chosen]
            look = {"color": colour, "markersize": 5, "transform": axes.get_xaxis_transform()}
            axes.plot(places, np.full(places.size, FOOT), "|", **look)


# --- Fig. 18: map of the disorder parameter -------------------------------------------------------

_ONE_MOTION = 0.5  # largest range of the laminar shares at one u, for a line to join their means
_ALL_STICK = 13.5  # below this u no run has a laminar phase
UNSHOWN = (0.5,)  # noise at which b shows what it shows at 0 and 1
_AROUND, _MANY = 3, 1 / 3  # points of sigma and u, of which so many are intermittent at its border
_CRUMB = 3  # points of a region that is not shown, at most


@panels.draws(FIGURES)
def fig18(data):
    """a: r over the plane (u, sigma), with the range of intermittency; b: laminar shares."""
    points = data["n5_map"].arrays
    measured = (points["n_blocks"] == N_BLOCKS) & np.isfinite(points["disorder_parameter"])
    points = sections.select(points, measured)
    figure, (above, below) = panels.page(4.05, "a;b", height_ratios=(1.6, 1))
    above.set(xlabel=panels.BELT_VELOCITY, ylabel=panels.NOISE)
    if points["noise"].size:
        table = {name: points[name] for name in ("noise", "belt_velocity", "disorder_parameter")}
        table["intermittent"] = states.intermittent_mask(points).astype(float)
        plane = pd.DataFrame(table).pivot_table(index="noise", columns="belt_velocity")
        disorder, mixed = plane["disorder_parameter"], plane["intermittent"]
        place = artists.edges(disorder.columns.to_numpy()), artists.edges(disorder.index.to_numpy())
        image = above.pcolormesh(*place, disorder, cmap="viridis", vmin=0, rasterized=True)
        figure.colorbar(image, ax=above, pad=0.01, label=panels.DISORDER)
        if min(mixed.shape) > 1:
            around = _without_crumbs(mixed.to_numpy())
            region = mixed.columns, mixed.index, around
            above.contourf(*region, levels=[_MANY, 2], colors="none", hatches=["///"])
            border = above.contour(*region, levels=[_MANY], colors="white", linewidths=1.0)
            border.set_path_effects([withStroke(linewidth=2.4, foreground="black")])
            panels.note(above, "intermittent", place=(0.75, 0.75))
            lowest = mixed.columns[around[0] > _MANY]
            if lowest.size:
                look = {"color": style.VERMILION, "markersize": 3.5, "clip_on": False}
                above.plot(lowest, np.full(lowest.size, place[1][0]), "^", **look)
                look = {"color": "white", "arrowprops": {"arrowstyle": "->", "color": "white"}}
                place, words = (lowest[0] - 5, 1), "in these runs, too\n(paper: not)"
                above.annotate(words, (lowest[0], 0), place, ha="right", **look)
        _falls(above, data["critical_velocities"])
    else:
        panels.note(above, "no points in this scan")
    _shares(below, data["n5_replicates"])
    return figure


def _without_crumbs(mixed):
    """Share of intermittent points around each, without regions and gaps of a few points."""
    around = scipy.ndimage.uniform_filter(mixed, _AROUND, mode="nearest")
    for inside, other in ((around > _MANY, 0.0), (around <= _MANY, 1.0)):
        region, _ = scipy.ndimage.label(inside)
        around[inside & (np.bincount(region.ravel())[region] <= _CRUMB)] = other
    return around


def _falls(axes, table):
    """Where r falls at each noise, from independent runs, and where the paper sees it fall."""
    rows = panels.independent_falls(table, "n_blocks", N_BLOCKS)
    reach = np.nan_to_num([rows["critical"] - rows["low"], rows["high"] - rows["critical"]])
    halo = {"path_effects": [withStroke(linewidth=2.2, foreground="white")]}
    look = {"fmt": "o", "color": style.BLACK, "markersize": 2.5, "elinewidth": 0.9} | halo
    bars = axes.errorbar(rows["critical"], rows["noise"], None, reach, label="$u_c$ here", **look)
    names = map("u_c({:g})".format, rows["noise"])
    panels.shows(bars, "uc-of-sigma", *names, variant="exact dynamics")
    places = printed("u-critical"), printed("uc-sigma22")["u_c"]
    look = {"color": style.BLACK, "transform": axes.get_xaxis_transform(), "clip_on": False}
    axes.plot(places, (1.0, 1.0), "v", markersize=4, label="paper", **look)
    look = {"transform": look["transform"], "va": "bottom"}
    axes.text(places[0] + 1, 1.025, r"$\sigma = 0$", ha="right", **look)
    axes.text(places[1] - 1, 1.025, "2.2", **look)
    panels.legend_above(axes, reverse=True)


def _shares(axes, scan):
    noises = [noise for noise in panels.levels(scan, "noise") if noise not in UNSHOWN]
    for index, noise in enumerate(noises):
        row = sections.cut(scan, n_blocks=N_BLOCKS, noise=noise)
        share = row["belt_velocity"], row["laminar_fraction"]
        look = style.look_of_noise(noise) | {"label": rf"$\sigma = {noise:g}$"}
        spread = sections.spread(*share)
        # runs that keep to one of both motions have a mean, but no motion has it
        if np.all(spread.high - spread.low <= _ONE_MOTION):
            panels.draw_runs(axes, *share, index, apart=np.inf, **look)
        else:  # in front, and open, since many lie on each other
            look |= {"markersize": max(4.5 - 1.5 * index, 2.5), "linestyle": "none", "zorder": 4}
            look |= {"marker": style.MARKERS[index % 7], "markerfacecolor": "none"}
            axes.plot(*share, markeredgewidth=0.7, **look)
    for limit in states.LAMINAR_SHARE:
        axes.axhline(limit, color="0.5", linewidth=0.8, linestyle=":")
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="laminar share", ylim=(-0.06, 1.06))
    axes.set_xlim(left=_ALL_STICK)
    panels.legend_above(axes)
