"""Not in the paper: the orbits behind the fall of r, and which starts and sweeps reach them."""

import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm
from matplotlib.patheffects import withStroke

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.fall import measure
from beltrepro.simulation import artists

FIGURES = {
    "branches": Figure(uses=("basins", "basin_shares", "sweep_falls"), category="Further studies"),
    "births": Figure(
        uses=("friction_map", "birth_lines", "fall_onsets"), category="Further studies"
    ),
    "orbits_met": Figure(
        uses=("fall_orbits", "fall_shares", "birth_lines"), category="Further studies"
    ),
    "chaos_ends": Figure(
        uses=("chaos_ends", "chaos_ends_near", "chaos_lifetimes", "contraction"),
        category="Further studies",
    ),
    "disturbances": Figure(
        uses=("disturbances", "disturbances_scheme", "disturbance_shares"),
        category="Further studies",
    ),
}


_PAPER = 15.0, 18.0  # where the paper sees r fall
_BIFURCATIONS = ("fold", "period doubling", "torus", "stick of no length")
_SHIFT = 0.16  # of u between the marks of kinds of starts


@panels.draws(FIGURES)
def branches(data):
    """Above branches and their ends; then shares of starts, and of sweeps."""
    figure, (orbits, starts, sweeps) = panels.page(
        4.05, "a;b;c", sharex=True, height_ratios=(1.5, 1, 1)
    )
    _draw_branches(orbits, data["basins"].arrays)
    shares = data["basin_shares"]
    _draw_starts(starts, shares[shares["n_blocks"] == 5])
    falls = data["sweep_falls"]
    _draw_sweeps(sweeps, falls[falls["noise"] == 0])
    for axes in (orbits, starts, sweeps):
        axes.axvspan(*_PAPER, color="0.9", linewidth=0, zorder=0)
    for axes in (starts, sweeps):
        axes.set(ylabel="share at small $r$", ylim=(-0.05, 1.05))
    sweeps.set_xlabel(panels.BELT_VELOCITY)
    return figure


def _draw_branches(axes, arrays):
    """r of each orbit, its ends, and irregular runs."""
    orbits = arrays["branches"]
    if not orbits.size:
        panels.note(axes, "no orbit was followed")
    ends = {"markersize": 2.6, "markerfacecolor": "none", "markeredgewidth": 0.6}
    bifurcation = np.isin(orbits["end"], _BIFURCATIONS)
    for label, points, marker, look in (
        (None, orbits, ".", {"color": style.BLUE, "markersize": 1.9, "markeredgewidth": 0}),
        ("grazing", orbits[orbits["end"] == "grazing"], "o", ends | {"color": style.VERMILION}),
        ("bifurcation", orbits[bifurcation], "D", ends | {"color": style.GREEN}),
    ):
        places = points["belt_velocity"], points["disorder_parameter"]
        axes.plot(*places, marker, label=label, **look)
    attractors = arrays["attractors"]
    followed = np.isin(attractors["attractor"], orbits["attractor"])
    long = attractors[~followed & (attractors["state"] == "periodic")]
    place = arrays["belt_velocity"][long["point"]]
    look = {"markersize": 2.2, "markeredgewidth": 0.4, "color": style.SKY, "zorder": 0.5}
    axes.plot(place, long["disorder_parameter"], "+", label="long orbit", **look)
    irregular = arrays["state"] == "irregular"
    place = np.broadcast_to(arrays["belt_velocity"][:, np.newaxis], irregular.shape)[irregular]
    values = arrays["disorder_parameter"][irregular]
    look = {"markersize": 2.4, "markeredgewidth": 0.4, "color": "0.55", "zorder": 0}
    axes.plot(place, values, "x", label="irregular", **look)
    axes.set(ylabel="$r$", yscale="log", ylim=(0.0025, 0.4))
    panels.plain_log(axes.yaxis)
    panels.legend_above(axes, handlelength=0.6, columnspacing=0.5)


def _draw_starts(axes, shares):
    """Shares of the starts at rest, and of slipping ones of each energy."""
    energies = sorted(shares["start_energy"].unique())
    for number, energy in enumerate(energies):
        chosen = shares["start_energy"] == energy
        label = f"$H/N = {energy:g}$" if energy else "rest"
        shift = _SHIFT * (number - (len(energies) - 1) / 2)
        _draw_shares(axes, shares[chosen], number, label, shift)
    panels.legend_above(axes, handlelength=0.6, columnspacing=0.5)


def _draw_sweeps(axes, falls):
    """Shares of the sweeps, up and down, for each hold."""
    for number, hold in enumerate(sorted(falls["hold"].unique())):
        for way, face in (("up", None), ("down", "white")):
            rows = falls[(falls["hold"] == hold) & (falls["way"] == way)]
            _draw_shares(axes, rows, number, "" if face else f"hold {hold:g}", 0.0, face)
    axes.text(0.02, 0.4, "full: up\nopen: down", transform=axes.transAxes)
    panels.legend_above(axes, handlelength=0.6, columnspacing=0.5)


def _draw_shares(axes, rows, number, label, shift, face=None):
    colour = style.COLOURS[number]
    look = {"color": colour, "ecolor": (colour, 0.5), "markersize": 2.2, "elinewidth": 0.4}
    look |= {"markeredgewidth": 0.6, "markerfacecolor": face, "label": label}
    shares = (rows[name] for name in ("share", "low", "high"))
    panels.intervals(
        axes, rows["belt_velocity"] + shift, *shares, fmt=style.MARKERS[number], **look
    )


# --- births in the plane of friction ratio and belt velocity --------------------------------------

_R_SHOWN = 0.01, 0.2  # from r of the smallest orbits to that of slow belts


@panels.draws(FIGURES)
def births(data):
    """Lines of births over r, and where runs begin to end at small r."""
    figure = style.page(3.2)
    axes = figure.subplots()
    arrays = data["friction_map"].arrays
    table = pd.DataFrame(
        {name: arrays[name] for name in ("friction_ratio", "belt_velocity", "disorder_parameter")}
    )
    plane = table.pivot_table(
        index="belt_velocity", columns="friction_ratio", values="disorder_parameter"
    )
    if plane.empty:
        axes.set(xlabel="$f_s$", ylabel=panels.BELT_VELOCITY)
        panels.note(axes, "no r in this scan")
        return figure
    look = {"norm": LogNorm(*_R_SHOWN), "rasterized": True}
    colours = axes.pcolormesh(plane.columns, plane.index, plane, **look)
    bar = figure.colorbar(colours, ax=axes, label=panels.DISORDER, pad=0.02, extend="min")
    panels.plain_log(bar.ax.yaxis)
    limits = axes.get_xlim(), axes.get_ylim()
    halo = [withStroke(linewidth=2.2, foreground="white")]
    beside = {"textcoords": "offset points", "va": "center", "path_effects": halo}
    for (linear, slips), line in data["birth_lines"].groupby(["linear", "slips"]):
        dashes = "--" if linear else "-"
        marker = "" if len(line) > 1 else "_"
        look = {"marker": marker, "color": style.BLACK, "linewidth": 1.0, "path_effects": halo}
        axes.plot(line["friction_ratio"], line["birth"], dashes, **look)
        end = line.iloc[-1]
        axes.annotate(f"{slips}", (end["friction_ratio"], end["birth"]), xytext=(3, 0), **beside)
    onsets = data["fall_onsets"]
    numbers = (onsets[name] for name in ("onset", "low", "high"))
    look = {"fmt": "o", "color": style.VERMILION, "markersize": 2}
    panels.intervals(axes, onsets["friction_ratio"], *numbers, **look)
    axes.set(xlabel="$f_s$", ylabel=panels.BELT_VELOCITY, xlim=limits[0], ylim=limits[1])
    return figure


# --- on which orbits runs end ---------------------------------------------------------------------

_END_COLOURS = (style.BLUE, "#2f97d3", style.GREEN, "#9fd8c5", style.VERMILION, style.ORANGE)
_END_COLOURS += ("#f3d6ae", "0.85")


@panels.draws(FIGURES)
def orbits_met(data):
    """Stacked shares of ends at each u, and shares at small r over ranges of u."""
    figure = style.page(2.6)
    axes = figure.subplots()
    arrays = data["fall_orbits"].arrays
    velocity = arrays["belt_velocity"]
    places = np.unique(velocity)
    width = np.diff(places).min(initial=measure.RANGE)
    below = np.zeros(places.size)
    for (end, runs), colour in zip(measure.ends(arrays).items(), _END_COLOURS, strict=True):
        share = np.array([runs[velocity == u].mean() for u in places])
        look = {"color": colour, "linewidth": 0, "label": end}
        axes.bar(places, share, width, below, **look)
        below = below + share
    small = data["fall_shares"][data["fall_shares"]["end"] == "small r"]
    numbers = (small[name] for name in ("share", "low", "high"))
    halo = [withStroke(linewidth=1.6, foreground="white")]
    look = {"fmt": "o", "color": style.BLACK, "markersize": 2, "elinewidth": 0.8}
    panels.intervals(axes, small["begin"] + measure.RANGE / 2, *numbers, **look, path_effects=halo)
    for slips, side in ((5, "right"), (11, "left")):
        for birth in measure.births_at_paper(data["birth_lines"], slips):
            axes.axvline(birth, color=style.BLACK, linewidth=0.8, linestyle=":")
            axes.text(birth, 0.93, f" {slips} ", ha=side, path_effects=halo)
    axes.set(xlabel=panels.BELT_VELOCITY, ylabel="share of runs", ylim=(-0.015, 1.015))
    axes.set_xlim(places[0] - width / 2, places[-1] + width / 2)
    title = "slips in the period (left: small $r$, right: large $r$)"
    look = {"columnspacing": 0.8, "handlelength": 1.0, "title": title}
    figure.legend(loc="outside upper center", ncols=2, **look)
    return figure


# --- what a disturbance clears --------------------------------------------------------------------

_ROW, _GAP = 0.34, 0.12  # decades: height of a row without a place on a logarithmic axis, and room
_PRINTED_NOISE = 0, 1  # of the paper's values those within the map


@panels.draws(FIGURES)
def disturbances(data):
    """Share at small r over u and noise, and just above the fall; rows for none and the scheme."""
    figure, (plane, profile) = panels.page(3.0, "ab", sharey=True, width_ratios=(1.9, 1))
    runs, scheme = (data[name].arrays for name in FIGURES["disturbances"].uses[:2])
    levels = np.unique(runs["noise"][runs["noise"] > 0])
    for axes in (plane, profile):
        axes.set_xlabel(panels.BELT_VELOCITY if axes is plane else "share at small $r$")
        if not levels.size:
            panels.note(axes, "no noise in this scan")
    if not levels.size:
        return figure
    borders = artists.edges(np.log10(levels))
    none, paper = borders[0] - _GAP - _ROW / 2, borders[-1] + _GAP + _ROW / 2
    mesh = _draw_shares_of(plane, runs, levels, borders)
    _draw_shares_of(plane, runs, [0], none + _ROW * np.array([-0.5, 0.5]))
    limits = plane.get_xlim()
    _draw_shares_of(plane, scheme, [0], paper + _ROW * np.array([-0.5, 0.5]))
    artists.colour_bar([mesh], plane, "share at small $r$", location="top")
    rows = data["disturbance_shares"]
    by_scheme = rows["dataset"] == FIGURES["disturbances"].uses[1]
    with np.errstate(divide="ignore"):
        place = np.where(by_scheme, paper, np.maximum(np.log10(rows["noise"]), none))
    for chosen, colour in ((~by_scheme, style.BLUE), (by_scheme, style.VERMILION)):
        share, low, high = (rows[name][chosen] for name in ("share", "low", "high"))
        look = {"fmt": "o", "color": colour, "markersize": 2.2, "elinewidth": 0.7}
        profile.errorbar(share, place[chosen], xerr=[share - low, high - share], **look)
    for line in rows["share"][by_scheme]:
        profile.axvline(line, color=style.VERMILION, linewidth=0.8, linestyle=":", zorder=0)
    step = data["disturbances_scheme"].attributes.get("time_step", np.nan)
    ends = np.log10(measure.noise_of_step(np.mean(measure.ABOVE), step))
    profile.axhspan(*ends, color=style.ORANGE, alpha=0.4, linewidth=0, zorder=0)
    printed = [none if noise == 0 else np.log10(noise) for noise in _PRINTED_NOISE]
    look = {"color": style.BLACK, "markersize": 3.5, "clip_on": False, "zorder": 5}
    plane.plot(np.full(len(printed), limits[1]), printed, "<", **look)
    decades = np.unique(np.round(np.log10(levels)).astype(int))
    words = [f"$10^{{{decade}}}$" for decade in decades]
    plane.set_yticks([none, *decades, paper], ["0", *words, "paper's\ntime step"])
    plane.tick_params(left=False, right=False)
    plane.set(ylabel=panels.NOISE, xlim=limits, ylim=(none - _ROW / 2, paper + _ROW / 2))
    profile.tick_params(labelleft=False)
    profile.set_xlim(-0.03, 1.03)
    return figure


def _draw_shares_of(axes, runs, levels, borders):
    """A row of cells for each noise: share of the runs of each u that are at small r."""
    chosen = np.isin(runs["noise"], levels)
    if not chosen.any():
        return None
    table = pd.DataFrame({name: runs[name][chosen] for name in ("noise", "belt_velocity")})
    table["small"] = runs["disorder_parameter"][chosen] < measure.SMALL
    cells = table.pivot_table(index="noise", columns="belt_velocity", values="small", dropna=False)
    places = artists.edges(cells.columns.to_numpy())
    look = {"cmap": "Blues", "vmin": 0, "vmax": 1, "rasterized": True}
    return axes.pcolormesh(places, borders, cells.to_numpy(float), **look)


# --- how long motion is irregular -----------------------------------------------------------------

_LINEAR_TO = 1e-3  # exponents below are on a linear scale


@panels.draws(FIGURES)
def chaos_ends(data):
    """Lifetimes, and slips in the period, over all u, and near one where chaos lasts; then N."""
    figure, places = panels.page(4.05, "ab;cd;ef", width_ratios=(1.7, 1))
    for one, other in ((1, 0), (3, 2)):
        places[one].sharey(places[other])
    table = data["chaos_lifetimes"]
    for column, (name, width) in enumerate(measure.WIDTHS.items()):
        arrays, medians = data[name].arrays, table[table["width"] == width]
        times, periods = places[column], places[2 + column]
        velocity, settled = arrays["belt_velocity"], arrays["settled"].astype(bool)
        look = {"markersize": 2.4, "markeredgewidth": 0, "color": style.BLUE, "alpha": 0.7}
        times.plot(velocity[settled], arrays["lifetime"][settled], ".", **look)
        periods.plot(velocity[settled], arrays["period_events"][settled], ".", **look)
        look |= {"color": style.VERMILION, "markersize": 3}
        times.plot(velocity[~settled], arrays["lifetime"][~settled], "^", **look)
        ends = np.append(medians["begin"], medians["begin"].iloc[-1:] + width)
        look = {"color": style.BLACK, "linewidth": 0.7, "baseline": None}
        times.stairs(medians["lifetime"], ends, **look)
        periods.stairs(medians["slips"], ends, **look)
        times.set_yscale("log")
        periods.set(yscale="log", xlabel=panels.BELT_VELOCITY)
    for axes in (places[1], places[3]):
        axes.ticklabel_format(axis="x", useOffset=False)
        axes.locator_params(axis="x", nbins=3)
        axes.tick_params(labelleft=False)
    places[0].set_ylabel("time irregular")
    places[2].set_ylabel("slips in the period")
    _draw_contraction(*places[4:], data["contraction"])
    return figure


def _draw_contraction(exponents, lifetimes, table):
    """Against N: largest nontrivial exponents, and how long motion is irregular."""
    size = table["n_blocks"]
    numbers = (table[f"exponent{end}"] for end in ("", "_low", "_high"))
    look = {"color": style.BLUE, "marker": "o", "markersize": 3}
    bars = look | {"linestyle": "none", "elinewidth": 3, "ecolor": "0.75"}
    panels.intervals(exponents, size, *numbers, **bars)
    exponents.axhline(0, color="0.4", linewidth=0.7, zorder=0)
    exponents.axhspan(-_LINEAR_TO, _LINEAR_TO, color="0.92", linewidth=0, zorder=-1)
    above = {"markerfacecolor": "white", "color": style.VERMILION, "markersize": 3.5}
    exponents.plot(size, table["exponent_irregular"], "D", label="irregular to the end", **above)
    exponents.set_yscale("symlog", linthresh=_LINEAR_TO, linscale=0.6)
    exponents.set_ylabel("nontrivial exponent")
    panels.legend_above(exponents, handlelength=0.6)
    numbers = (table[f"lifetime{end}"] for end in ("", "_low", "_high"))
    if table["lifetime_low"].notna().any():
        panels.intervals_or_limits(lifetimes, size, *numbers, elinewidth=0.8, **look)
        lifetimes.set_yscale("log")
    else:
        panels.note(lifetimes, "too few runs")
    lifetimes.set_ylabel("mean time irregular")
    for axes in (exponents, lifetimes):
        axes.set(xlabel="$N$", xticks=size, xlim=(1.4, 10.6))
