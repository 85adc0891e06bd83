"""Fig. 12: the transition without noise."""

import numpy as np

from beltrepro.replication.drawing import motion_panels as motions
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.transition import lifetimes
from beltrepro.stats import sections, transitions

FIGURE = Figure(
    title="Bifurcation diagram, largest exponent and r(u) without noise, with lifetimes.",
    uses=("n5_rows", "n5_rows_check", "n5_replicates_check", "motion_map", "lifetimes"),
    words=(
        "The bifurcation diagram of section velocities and the disorder parameter r against belt "
        "velocity without noise: bands with windows, then a sharp fall of r. The lifetime of "
        "irregular transients, an inset in the paper, rises towards that fall; where an arrow "
        "stands, too few runs ended, and it is longer. Between them, not in the paper: the largest "
        "Lyapunov exponent of the exact motion, coloured by the motion in which a run ends. Grey "
        "dots at r are runs from other starts: they end on several attractors."
    ),
    alt=(
        "Four panels against belt velocity: section velocities as points, largest Lyapunov "
        "exponents, r as points with a line, and mean lifetimes of transients with error bars."
    ),
    number="12",
)

PLAIN = 50  # a shorter range of lifetimes has plain numbers


@style.styled
def draw(data, caption):
    """v_N at the section; largest exponent; r; mean lifetimes. All against u, without noise."""
    panels.require(data, FIGURE)
    figure = style.page(caption, 6.9)
    heights = (1.3, 0.6, 1, 0.7)
    top, middle, lower, bottom = figure.subplots(4, 1, sharex=True, height_ratios=heights)
    row = sections.rows(data["n5_rows"], n_blocks=5, noise=0.0)
    panels.band_diagram(top, row, size=3.2)
    panels.finish_diagram(top)
    top.set_ylabel(panels.VELOCITY)
    panels.remark(top, panels.section_name(row))
    motions.exponents(middle, data["motion_map"], 5, size=3)
    middle.set_ylabel(motions.EXPONENT)
    motions.legend(figure, [middle], loc="outside upper left")
    _disorder(lower, data)
    _mark_transition(lower, row)
    _lifetimes(bottom, data["lifetimes"])
    bottom.set(xlabel=panels.BELT_VELOCITY, ylabel=r"$\tau$", xlim=(0, None))
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
            markersize=3,
            label="other starts",
        )
    for scan, overlay in panels.layers(data, "n5_rows"):
        row = sections.rows(scan, n_blocks=5, noise=0.0)
        points = row["belt_velocity"], row["disorder_parameter"]
        colour = style.ORANGE if overlay else style.BLUE
        panels.curve(axes, *points, 0, overlay=overlay, color=colour, linewidth=0.8)
    panels.finish_curves(axes, xlabel="")
    if axes.get_legend():
        panels.make_room(axes, above=0.22)
        axes.legend(loc="upper right", ncols=2)


def _mark_transition(axes, row):
    try:
        fall = transitions.transition_region(row["belt_velocity"], row["disorder_parameter"])
    except ValueError:
        return
    if fall.found:
        axes.axvspan(fall.lower, fall.upper, color="0.9", linewidth=0, zorder=0)
        axes.axvline(fall.critical, color="0.4", linewidth=0.8, linestyle="--", zorder=0)
        words = f"grey: transition region {fall.lower:.1f} to {fall.upper:.1f}, dashed: $u_c$"
        panels.remark(axes, f"{words} = {fall.critical:.1f}")


def _lifetimes(axes, runs):
    table = lifetimes.by_belt_velocity(runs, float(runs.attributes["duration"]))
    known = np.isfinite(table["tau"])
    few = ~known & np.isfinite(table["tau_lower"])
    velocity = table["belt_velocity"]
    if known.any():
        look = {"color": style.VERMILION, "markersize": 3.5, "linewidth": 0.8, "elinewidth": 0.8}
        axes.errorbar(
            velocity[known], table["tau"][known], table["tau_error"][known], fmt="o", **look
        )
    if few.any():
        limit = table["tau_lower"][few]
        axes.plot(velocity[few], limit, "^", color=style.BLUE, label="too few runs end: longer")
        axes.legend(loc="center left")
    if known.any() or few.any():
        axes.set_yscale("log")
        low, high = axes.get_ylim()
        if high < PLAIN * low:
            panels.plain_log(axes.yaxis)
        panels.remark(axes, f"measured from $u$ = {velocity.min():g} on")
    else:
        panels.note(axes, "no run of the lifetimes lasts")
