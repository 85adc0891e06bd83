"""Fig. 12: the transition without noise."""

import numpy as np

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.drawing import marks, panels, style
from beltrepro.replication.drawing import motion_panels as motions
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.transition import measure, transients
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats import sections

FIGURE = Figure(
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
)

SPREAD = 10.0  # of the starts whose irregular motion is timed, as in the claim on lifetimes
PRINTED = printed("transition-width")["5"]
PLAIN = 50  # a shorter range of lifetimes has plain numbers


@style.styled
def draw(data):
    """a: v_N at the section; b: r; c: mean lifetimes; d: largest exponent. Against u, no noise."""
    panels.require(data, FIGURE)
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
    motions.exponents(bottom, data["motion_map"], 5)
    panels.legend_above(bottom)
    bottom.set(xlabel=panels.BELT_VELOCITY, ylabel=motions.EXPONENT, xlim=(0, None))
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
    marks.shown(region, "u-critical", "lower", "upper")
    marks.shown(line, "u-critical", "critical")
    place = {"transform": axes.transAxes, "ha": "right", "va": "top"}
    text = axes.text(0.98, 0.9, words, **place)
    marks.shown(text, "u-critical", "lower", "upper", "critical")


def _lifetimes(axes, data):
    looks = {
        "irregular, exact": (style.BLUE, "o"),
        "to the last stick, paper's scheme": (style.VERMILION, "s"),
    }
    makers = (
        lambda: transients.until_settled(data["survival"], SPREAD),
        lambda: transients.until_last_stick(data["lifetimes_wide"]),
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
