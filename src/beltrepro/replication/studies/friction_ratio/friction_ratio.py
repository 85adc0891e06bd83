"""Not in the paper: the fall of r for several friction ratios."""

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.points import by_point

FIGURE = Figure(uses=("friction_ratio", "friction_falls"), category="Further studies")


@style.styled
def draw(data):
    """a: r(u), marks for each f_s; b: u_c against f_s."""
    panels.require(data, FIGURE)
    scan, falls = data["friction_ratio"].arrays, data["friction_falls"]
    figure = style.page(4.0)
    left, right = figure.subplots(2, 1, height_ratios=(1.4, 1))
    panels.letters(left, right)
    for index, (place, runs) in enumerate(by_point(scan, "friction_ratio")):
        curve = (scan[name][runs] for name in ("belt_velocity", "disorder_parameter"))
        panels.single_runs(left, *curve, index, label=f"$f_s = {place['friction_ratio']:g}$")
    panels.finish_curves(left, xlabel=panels.BELT_VELOCITY)
    _draw_falls(right, falls[falls["critical"].notna()])
    right.set(xlabel="$f_s$", ylabel="$u_c$")
    return figure


def _draw_falls(axes, falls):
    if falls.empty:
        panels.note(axes, "r(u) falls nowhere, or has too few points")
        return
    ratio = falls["friction_ratio"]
    axes.vlines(ratio, falls["lower"], falls["upper"], color="0.85", linewidth=4)
    look = {"fmt": "o", "color": style.BLUE, "markersize": 3, "elinewidth": 0.8}
    panels.intervals(axes, ratio, falls["critical"], falls["low"], falls["high"], **look)
    axes.axvline(0.45, color="0.7", linewidth=0.8, zorder=0)
    axes.set_xlim(0.25, 0.95)
