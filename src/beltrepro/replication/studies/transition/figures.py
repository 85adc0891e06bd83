"""Figs. 11 and 12: a transient, and the transition without noise."""

from contextlib import suppress

import numpy as np

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.transition import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.replication.verdicts.motions import N_BLOCKS
from beltrepro.stats import sections

FIGURES = {
    "fig11": Figure(uses=("u20",), number="11"),
    "fig12": Figure(
        uses=(
            "n5_rows",
            "n5_rows_check",
            "n5_replicates_check",
            "lifetimes_wide",
            "survival",
        ),
        number="12",
        shows={"u-critical": ("critical", "lower", "upper")},
    ),
    "critical_velocity": Figure(
        uses=(
            "critical_velocities",
            "n5_replicates",
            "n5_replicates_check",
            "n5_replicates_wide",
            "size_replicates",
        ),
        category="Further studies",
        shows={
            "uc-of-sigma: exact dynamics": ("u_c(?)", "u_c(?.?)"),
            "u-critical": ("critical",),
            "u-critical: wider starts": ("critical",),
        },
    ),
}


# --- Fig. 11: a chaotic transient and what follows it ---------------------------------------------

PERIODS = 3  # that are enlarged, at the end
ZOOM = 60.0  # least length of the enlarged part
AFTER = 0.6  # share of the transient's length that is drawn after it


@panels.draws(FIGURES)
def fig11(data):
    """a: x_N(t) from the start; b: v_rN(t); c and d: the end of what is drawn, enlarged."""
    series = data["u20"]
    time, position, relative = panels.last_block(series)
    orbit = measure.settled_orbit(time, series.arrays["positions"], series.arrays["velocities"])
    stuck = np.flatnonzero(np.abs(relative) < 1e-9)
    last_stick = float(time[stuck[-1]]) if stuck.size else 0.0
    end, period = orbit or (last_stick, 0.0)
    length = max(ZOOM, PERIODS * period)
    shown = time <= (1 + AFTER) * end + length
    time, position, relative = time[shown], position[shown], relative[shown]

    figure, (above, below, *insets) = panels.page(4.2, "aa;bb;cd", height_ratios=(1, 1, 1.2))
    for axes, enlarged, values, label in (
        (above, insets[0], position, panels.POSITION),
        (below, insets[1], relative, panels.RELATIVE_VELOCITY),
    ):
        panels.trace(axes, time, values, ylabel=label)
        enlarged.set(xlabel=panels.TIME, ylabel=label)
        panels.zoom(axes, enlarged, time, values, (time[-1] - length, time[-1]))
        axes.axvline(printed("u20-transient"), color=style.BLACK, linestyle=":")
        if end < time[-1] - length:
            axes.axvline(end, color=style.VERMILION, linestyle="--")
    below.set_xlabel(panels.TIME)
    sticks = last_stick > time[-1] - length
    words = f"last stick at $t$ = {last_stick:.0f}, no period found"
    if orbit:
        words = f"periodic from $t$ = {end:.0f} on, period {period:.1f}"
    elif sticks:
        words = "no end of the transient in this series"
    panels.remark(above, words)
    ours = "goes on sticking (paper: only slips)" if sticks else "only slips, as in the paper"
    panels.remark(below, f"last block: {ours}")
    return figure


# --- Fig. 12: the transition without noise --------------------------------------------------------

SPREAD = 10.0  # of the starts whose irregular motion is timed, as in the claim on lifetimes
PRINTED = printed("transition-width")["5"]
BINS = 150  # of v_N
PLAIN = 50  # a shorter range of lifetimes has plain numbers


@panels.draws(FIGURES)
def fig12(data):
    """a: v_N at the section; b: r; c: mean lifetimes. Against u, without noise."""
    figure, (top, disorder, lifetimes) = panels.page(
        5.0, "a;b;c", sharex=True, height_ratios=(1.5, 1.3, 0.9)
    )
    row = sections.cut(data["n5_rows"], n_blocks=N_BLOCKS, noise=0.0)
    panels.band_densities([top], [row], bins=BINS, location="top", aspect=50)
    top.set_ylabel(panels.VELOCITY)
    panels.remark(top, panels.section_name(row))
    _disorder(disorder, data)
    _lifetimes(lifetimes, data)
    lifetimes.set(xlabel=panels.BELT_VELOCITY, ylabel=r"$\tau$", xlim=(0, None))
    figure.align_ylabels()
    return figure


def _disorder(axes, data):
    """r of the row, over runs from other starts and their fall, under r by the other integrator."""
    starts = data.get("n5_replicates_check")
    if starts is not None:
        look = {"color": style.GREY, "markersize": 2.2, "markeredgewidth": 0}
        points = (starts.arrays[name] for name in ("belt_velocity", "disorder_parameter"))
        axes.plot(*points, ".", label="other starts", **look)
    for scan, overlay in panels.layers(data, "n5_rows"):
        row = sections.cut(scan, n_blocks=N_BLOCKS, noise=0.0)
        points = row["belt_velocity"], row["disorder_parameter"]
        colour = style.ORANGE if overlay else style.BLUE
        label = "" if overlay else "as in the paper"
        panels.single_runs(axes, *points, 0, label=label, overlay=overlay, color=colour)
    panels.finish_curves(axes, xlabel="")
    panels.make_room(axes, above=0.22)
    if starts is not None:
        _mark_transition(axes, measure.fall(starts, N_BLOCKS, 0.0))
    panels.printed_range(axes, *PRINTED, f"paper: {PRINTED[0]} to {PRINTED[1]}")


def _mark_transition(axes, fall):
    lower, critical, upper = (fall[name].value for name in ("lower", "critical", "upper"))
    if np.isnan(critical):
        return
    region = axes.axvspan(lower, upper, color="0.9", linewidth=0, zorder=0)
    line = axes.axvline(critical, color="0.4", linewidth=0.8, linestyle="--", zorder=0)
    words = f"fall here: {lower:.1f} to {upper:.1f}, $u_c$ = {critical:.1f} (dashed)"
    panels.shows(region, "u-critical", "lower", "upper")
    panels.shows(line, "u-critical", "critical")
    place = {"transform": axes.transAxes, "ha": "right", "va": "top"}
    text = axes.text(0.98, 0.9, words, **place)
    panels.shows(text, "u-critical", "lower", "upper", "critical")


def _lifetimes(axes, data):
    settled, last_stick = data["survival"], data["lifetimes_wide"]
    for ends_of, label, colour, marker in (
        (lambda: measure.until_settled(settled, SPREAD), "irregular, exact", style.BLUE, "o"),
        (
            lambda: measure.until_last_stick(last_stick),
            "to the last stick, paper's scheme",
            style.VERMILION,
            "s",
        ),
    ):
        place, *numbers = _means(ends_of)
        look = {"color": colour, "marker": marker, "markersize": 2.2, "elinewidth": 0.8}
        panels.intervals_or_limits(axes, place, *numbers, label=label, **look)
    if not axes.containers:
        panels.note(axes, "no run of the lifetimes lasts")
        return
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    if high < PLAIN * low:
        panels.plain_log(axes.yaxis)
    panels.legend_above(axes)


def _means(ends_of):
    """Belt velocities with a mean lifetime, its value and the ends of its interval."""
    rows = []
    with suppress(NotEnoughDataError):
        ends = ends_of()
        for place in np.unique(ends.belt_velocity):
            with suppress(NotEnoughDataError):
                lifetime = ends.mean(place, place)
                if lifetime.low > 0:
                    rows.append((place, *lifetime.numbers))
    return np.array(rows).reshape(-1, 4).T


# --- Not in the paper as a figure: the critical velocity against noise and number of blocks -------

NOISES = (0.0, 1.0)  # shown in b
# Of each dataset: label, colour, marker and shift in a.
LOOKS = {
    "n5_replicates": ("exact motion", style.BLUE, "o", 0.0),
    "n5_replicates_check": ("scheme of the paper", style.VERMILION, "s", 0.08),
    "n5_replicates_wide": ("scheme, wide starts", style.ORANGE, "^", 0.16),
}


@panels.draws(FIGURES)
def critical_velocity(data):
    """a: u_c against sigma for five blocks; b: u_c and the region against N for each noise."""
    table = data["critical_velocities"]
    figure, (left, right) = panels.page(4.4, "a;b")
    left.set(xlabel=panels.NOISE, ylabel="$u_c$")
    right.set(xlabel="$N$", ylabel="$u_c$")
    _against_noise(left, table[table["n_blocks"] == N_BLOCKS])
    _against_size(right, table[table["dataset"].isin(["n5_replicates", "size_replicates"])])
    for axes in (left, right):
        panels.legend_above(axes, ncols=2)
        if table["critical"].isna().all():
            panels.note(axes, "r(u) falls nowhere, or has too few points")
    return figure


def _against_noise(axes, table):
    for name, (label, colour, marker, shift) in LOOKS.items():
        rows = table[table["dataset"] == name]
        points = _points(axes, rows["noise"] + shift, rows, label, color=colour, marker=marker)
        if points and name == "n5_replicates":
            noises = rows["noise"][rows["critical"].notna()]
            names = map("u_c({:g})".format, noises)
            panels.shows(points, "uc-of-sigma", *names, variant="exact dynamics")
        elif points:
            variant = "wider starts" if name.endswith("wide") else ""
            panels.shows(points, "u-critical", "critical", variant=variant)
    values = printed("u-critical"), printed("uc-sigma22")["u_c"]
    axes.plot((0.0, 2.2), values, "x", color=style.BLACK, markersize=7, label="paper")


def _against_size(axes, table):
    for index, noise in enumerate(NOISES):
        rows = table[table["noise"] == noise].sort_values("n_blocks")
        place = rows["n_blocks"] + 0.18 * (index - 0.5)
        look = {"color": style.COLOURS[index], "marker": style.MARKERS[index]}
        _points(axes, place, rows, rf"$\sigma = {noise:g}$", **look)
    for n_blocks, region in ((int(n), ends) for n, ends in printed("transition-width").items()):
        label = "paper, region" if n_blocks == N_BLOCKS else None
        axes.plot([n_blocks + 0.3] * 2, region, "_-", color=style.BLACK, linewidth=0.9, label=label)


def _points(axes, place, rows, label, **look):
    """Critical velocities with their intervals, over the transition regions."""
    has_fall = rows["critical"].notna()
    if not has_fall.any():
        return
    place, rows = place[has_fall], rows[has_fall]
    axes.vlines(place, rows["lower"], rows["upper"], color=look["color"], alpha=0.25, linewidth=4)
    how = {"linestyle": "none", "markersize": 4, "elinewidth": 1.0, "capsize": 2}
    reach = np.nan_to_num([rows["critical"] - rows["low"], rows["high"] - rows["critical"]])
    return axes.errorbar(place, rows["critical"], reach, label=label, **how, **look)
