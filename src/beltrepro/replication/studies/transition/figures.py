"""Figs. 11 and 12: a transient, and the transition without noise."""

import numpy as np

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.transition import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats import motion, sections

FIGURES = {
    "fig11": Figure(uses=("u20",), number="11"),
    "fig12": Figure(
        uses=(
            "n5_rows",
            "n5_rows_check",
            "n5_replicates_check",
            "motion_map",
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
    last_stick = _last_stick(time, relative)
    end = orbit.since if orbit else last_stick
    length = max(ZOOM, PERIODS * orbit.period) if orbit else ZOOM
    shown = time <= (1 + AFTER) * end + length
    time, position, relative = time[shown], position[shown], relative[shown]

    figure = style.page(4.2)
    places = figure.subplot_mosaic([["a", "a"], ["b", "b"], ["c", "d"]], height_ratios=(1, 1, 1.2))
    for mark, axes in places.items():
        panels.letter(axes, mark)
        axes.set_xlabel("" if mark == "a" else panels.TIME)
    for mark, inset, values, label in (
        ("a", "c", position, panels.POSITION),
        ("b", "d", relative, panels.RELATIVE_VELOCITY),
    ):
        axes, enlarged = places[mark], places[inset]
        panels.trace(axes, time, values, ylabel=label)
        enlarged.set_ylabel(label)
        if time.size:
            panels.zoom(axes, enlarged, time, values, (time[-1] - length, time[-1]))
            axes.axvline(printed("u20-transient"), color=style.BLACK, linestyle=":")
            if end < time[-1] - length:
                axes.axvline(end, color=style.VERMILION, linestyle="--")
        else:
            panels.note(enlarged, "no samples")
    if time.size:
        _say(places, orbit, last_stick, sticks=last_stick > time[-1] - length)
    return figure


def _say(places, orbit, last_stick, *, sticks):
    """What the motion does after its transient, and whether the paper's does the same."""
    if orbit:
        panels.remark(
            places["a"], f"periodic from $t$ = {orbit.since:.0f} on, period {orbit.period:.1f}"
        )
    elif sticks:
        panels.remark(places["a"], "no end of the transient in this series")
    else:
        panels.remark(places["a"], f"last stick at $t$ = {last_stick:.0f}, no period found")
    if sticks:
        panels.remark(places["b"], "the last block goes on sticking; in the paper it only slips")
    else:
        panels.remark(places["b"], "the last block only slips, as in the paper")


def _last_stick(time, relative):
    """Time at which the last block is last seen stuck."""
    stuck = np.flatnonzero(np.abs(relative) < 1e-9)
    return float(time[stuck[-1]]) if stuck.size else 0.0


# --- Fig. 12: the transition without noise --------------------------------------------------------

N_BLOCKS = 5
SPREAD = 10.0  # of the starts whose irregular motion is timed, as in the claim on lifetimes
PRINTED = printed("transition-width")["5"]
PLAIN = 50  # a shorter range of lifetimes has plain numbers
COLOURS = {
    motion.PERIODIC: style.SKY,
    motion.QUASI_PERIODIC: style.GREEN,
    motion.EQUILIBRIUM: style.GREY,
    motion.TRANSIENT: style.ORANGE,
    motion.CHAOTIC: style.VERMILION,
    motion.NOISE_DRIVEN: style.PURPLE,
}
LEAST_RANGE = (-0.0005, 0.002)  # of exponents on an axis
_MARKERS = {motion.CHAOTIC: "o", motion.TRANSIENT: "^"}  # the rest, regular, are squares


@panels.draws(FIGURES)
def fig12(data):
    """a: v_N at the section; b: r; c: mean lifetimes; d: largest exponent. Against u, no noise."""
    figure = style.page(5.4)
    heights = (1.5, 1.3, 0.9, 0.8)
    top, disorder, lifetimes, bottom = figure.subplots(4, 1, sharex=True, height_ratios=heights)
    for axes, mark in zip((top, disorder, lifetimes, bottom), "abcd", strict=True):
        panels.letter(axes, mark)
    row = sections.rows(data["n5_rows"], n_blocks=5, noise=0.0)
    panels.band_diagram(top, row, size=2.0)
    panels.finish_diagram(top)
    top.set_ylabel(panels.VELOCITY)
    panels.remark(top, panels.section_name(row))
    _disorder(disorder, data)
    if "n5_replicates_check" in data:
        _mark_transition(disorder, measure.fall(data["n5_replicates_check"], 5, 0.0))
    panels.printed_range(disorder, *PRINTED, f"paper: {PRINTED[0]} to {PRINTED[1]}")
    _lifetimes(lifetimes, data)
    lifetimes.set_ylabel(r"$\tau$")
    _exponents(bottom, data["motion_map"])
    panels.legend_above(bottom)
    bottom.set(xlabel=panels.BELT_VELOCITY, ylabel=r"$\lambda_1$", xlim=(0, None))
    figure.align_ylabels()
    return figure


def _disorder(axes, data):
    """r of the row, over runs from other starts, and under those by the other integrator."""
    starts = data.get("n5_replicates_check")
    if starts is not None:
        axes.plot(
            starts.arrays["belt_velocity"],
            starts.arrays["disorder_parameter"],
            ".",
            color=style.GREY,
            markersize=2.2,
            markeredgewidth=0,
            label="other starts",
        )
    for scan, overlay in panels.layers(data, "n5_rows"):
        row = sections.rows(scan, n_blocks=5, noise=0.0)
        points = row["belt_velocity"], row["disorder_parameter"]
        colour = style.ORANGE if overlay else style.BLUE
        label = "" if overlay else "as in the paper"
        panels.single_runs(axes, *points, 0, label=label, overlay=overlay, color=colour)
    panels.finish_curves(axes, xlabel="")
    panels.make_room(axes, above=0.22)


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
    looks = {
        "irregular, exact": (style.BLUE, "o"),
        "to the last stick, paper's scheme": (style.VERMILION, "s"),
    }
    makers = (
        lambda: measure.until_settled(data["survival"], SPREAD),
        lambda: measure.until_last_stick(data["lifetimes_wide"]),
    )
    for (label, (colour, marker)), maker in zip(looks.items(), makers, strict=True):
        place, mean, low, high = _means(maker)
        look = {"color": colour, "linestyle": "none", "elinewidth": 0.8}
        ended = np.isfinite(high) & (low > 0)
        if ended.any():
            middle = mean[ended]
            bars = middle - low[ended], high[ended] - middle
            look_of_means = look | {"marker": marker, "markersize": 2.2, "label": label}
            axes.errorbar(place[ended], middle, bars, **look_of_means)
        if (~ended).any():
            name = "" if ended.any() else label
            limits = place[~ended], low[~ended], low[~ended]
            axes.errorbar(*limits, lolims=True, label=name, **look)
    if not axes.containers:
        panels.note(axes, "no run of the lifetimes lasts")
        return
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    if high < PLAIN * low:
        panels.plain_log(axes.yaxis)
    panels.legend_above(axes)


def _means(maker):
    """Belt velocities with a mean lifetime, its value and the ends of its interval."""
    rows = []
    try:
        runs = maker()
    except NotEnoughDataError:
        return np.empty((4, 0))
    for place in np.unique(runs.belt_velocity):
        try:
            lifetime = runs.mean(place, place)
        except NotEnoughDataError:
            continue
        if lifetime.time > 0:
            rows.append((place, lifetime.mean, lifetime.lower, lifetime.upper))
    return np.array(rows).reshape(-1, 4).T


def _exponents(axes, scan):
    """Largest exponent of each run of five blocks against u, coloured by its motion."""
    arrays = scan.arrays
    of_size = arrays["n_blocks"] == N_BLOCKS
    states = np.asarray(arrays["state"], dtype=str)
    axes.axhline(0, color="0.5", linewidth=0.6, zorder=0)
    for state, colour in COLOURS.items():
        chosen = of_size & (states == state)
        if chosen.any():
            axes.errorbar(
                arrays["belt_velocity"][chosen],
                arrays["largest_exponent"][chosen],
                arrays["standard_error"][chosen],
                fmt=_MARKERS.get(state, "s"),
                color=colour,
                markersize=2.4,
                markeredgewidth=0,
                elinewidth=0.5,
                label=state,
            )
    if not of_size.any():
        panels.note(axes, f"no run with N = {N_BLOCKS}")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, LEAST_RANGE[0]), max(high, LEAST_RANGE[1]))


# --- Not in the paper as a figure: the critical velocity against noise and number of blocks -------

NOISES = (0.0, 1.0)  # shown in b
LOOKS = {
    "n5_replicates": ("exact motion", style.BLUE, "o", 0.0),
    "n5_replicates_check": ("scheme of the paper", style.VERMILION, "s", 0.08),
    "n5_replicates_wide": ("scheme, wide starts", style.ORANGE, "^", 0.16),
}
# The claim, its variant and the names of its estimates that have the same numbers.
CLAIMS = {
    "n5_replicates": ("uc-of-sigma", "exact dynamics", "u_c({:g})"),
    "n5_replicates_check": ("u-critical", "", "critical"),
    "n5_replicates_wide": ("u-critical", "wider starts", "critical"),
}


@panels.draws(FIGURES)
def critical_velocity(data):
    """a: u_c against sigma for five blocks; b: u_c and the region against N for each noise."""
    table = data["critical_velocities"]
    figure = style.page(4.4)
    left, right = figure.subplots(2, 1)
    panels.letter(left, "a")
    panels.letter(right, "b")
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
        if points:
            claim, variant, names = CLAIMS[name]
            noises = rows["noise"][rows["critical"].notna()]
            shown = [names.format(noise) for noise in noises]
            panels.shows(points, claim, *shown, variant=variant)
    values = printed("u-critical"), printed("uc-sigma22")["u_c"]
    axes.plot((0.0, 2.2), values, "x", color=style.BLACK, markersize=7, label="paper")
    _say_none(axes, table[table["dataset"] == "n5_replicates"], "noise", r"$\sigma$")


def _against_size(axes, table):
    for index, noise in enumerate(NOISES):
        rows = table[table["noise"] == noise].sort_values("n_blocks")
        place = rows["n_blocks"] + 0.18 * (index - 0.5)
        look = {"color": style.COLOURS[index], "marker": style.MARKERS[index]}
        _points(axes, place, rows, rf"$\sigma = {noise:g}$", **look)
    for n_blocks, region in ((int(n), ends) for n, ends in printed("transition-width").items()):
        label = "paper, region" if n_blocks == N_BLOCKS else None
        axes.plot([n_blocks + 0.3] * 2, region, "_-", color=style.BLACK, linewidth=0.9, label=label)
    _say_none(axes, table[table["noise"].isin(NOISES)], "n_blocks", "$N$")


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


def _say_none(axes, rows, quantity, symbol):
    """Words for the values of a quantity at which r falls nowhere."""
    values = [value for value, same in rows.groupby(quantity) if same["critical"].isna().all()]
    if values:
        words = ", ".join(f"{value:g}" for value in values)
        place = {"transform": axes.transAxes, "ha": "left", "va": "top"}
        axes.text(0.02, 0.97, f"no fall by half at {symbol} = {words}", **place)
