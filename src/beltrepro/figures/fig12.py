"""Fig. 12: the transition without noise."""

import numpy as np

from beltrepro.analysis import lifetimes, sections, transitions
from beltrepro.figures import motions, panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Bifurcation diagram, largest exponent and r(u) without noise, with lifetimes.",
    uses=("n5_rows", "n5_rows_check", "motion_map", "lifetimes"),
    words=(
        "The bifurcation diagram of section velocities and the disorder parameter r against belt "
        "velocity without noise: bands with windows, then a sharp fall of r. The lifetime of "
        "irregular transients rises towards that fall. Between the two, not in the paper: the "
        "largest Lyapunov exponent of the exact motion, coloured by the motion in which a run ends."
    ),
    alt=(
        "Three panels against belt velocity: section velocities as points, largest Lyapunov "
        "exponents, and r with an inset of mean lifetimes of transients."
    ),
    number="12",
)


@style.styled
def draw(data, caption):
    """Top: v_N at the section; middle: largest exponent; bottom: r and, inset, mean lifetimes."""
    panels.require(data, ENTRY)
    figure = style.page(caption, 6.8)
    top, middle, bottom = figure.subplots(3, 1, sharex=True, height_ratios=(1, 0.6, 1.2))
    motions.exponents(middle, data["motion_map"], 5)
    middle.set_ylabel(motions.EXPONENT)
    motions.legend(figure, [middle], loc="outside upper left")
    layers = panels.layers(data, "n5_rows")
    for scan, overlay in layers:
        row = sections.rows(scan, n_blocks=5, noise=0.0)
        colour = style.ORANGE if overlay else style.BLUE
        panels.band_diagram(top, row, colour=colour, label=overlay or None, size=2.6)
        panels.curve(
            bottom,
            row["belt_velocity"],
            row["disorder_parameter"],
            0,
            overlay=overlay,
            color=colour,
            linewidth=0.8,
        )
    row = sections.rows(data["n5_rows"], n_blocks=5, noise=0.0)
    _mark_transition(bottom, row)
    panels.finish_diagram(top)
    top.set_ylabel(panels.VELOCITY)
    top.set_title(panels.section_name(row), loc="right", size=8, color="0.35")
    panels.finish_curves(bottom, xlabel=panels.BELT_VELOCITY)
    if bottom.get_legend():
        bottom.legend(loc="upper left")  # the room over the points, beside the inset
    bottom.set_xlim(left=0)
    place = (0.56, 0.47, 0.41, 0.47)
    for scan, _ in layers:
        row = sections.rows(scan, n_blocks=5, noise=0.0)
        panels.keep_clear(bottom, place, row["belt_velocity"], row["disorder_parameter"])
    _lifetimes(panels.inset(bottom, place, xlabel="$u$", ylabel=r"$\tau$"), data["lifetimes"])
    return figure


def _mark_transition(axes, row):
    try:
        fall = transitions.transition_region(row["belt_velocity"], row["disorder_parameter"])
    except ValueError:
        return
    if fall.found:
        axes.axvspan(fall.lower, fall.upper, color="0.9", linewidth=0, zorder=0)
        axes.axvline(fall.critical, color="0.4", linewidth=0.8, linestyle="--", zorder=0)
        words = f"grey: transition region {fall.lower:.1f} to {fall.upper:.1f}, dashed: $u_c$"
        axes.set_title(f"{words} = {fall.critical:.1f}", loc="right", size=8, color="0.35")


def _lifetimes(inner, runs):
    table = lifetimes.by_belt_velocity(runs, float(runs.attributes["duration"]))
    known = np.isfinite(table["tau"])
    if not known.any():
        panels.note(inner, "too few runs escape", size=6.5)
        return
    inner.errorbar(
        table["belt_velocity"][known],
        table["tau"][known],
        table["tau_error"][known],
        fmt="o-",
        color=style.VERMILION,
        markersize=2.5,
        linewidth=0.8,
        elinewidth=0.6,
    )
    inner.set_yscale("log")
    panels.plain_log(inner.yaxis)
