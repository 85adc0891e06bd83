"""Fig. 11: a chaotic transient and what follows it."""

import numpy as np

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.transition.transients import settled_orbit
from beltrepro.replication.verdicts.ledger import printed

FIGURE = Figure(uses=("u20",), number="11")

PERIODS = 3  # that are enlarged, at the end
ZOOM = 60.0  # least length of the enlarged part
AFTER = 0.6  # share of the transient's length that is drawn after it


@style.styled
def draw(data):
    """a: x_N(t) from the start; b: v_rN(t); c and d: the end of what is drawn, enlarged."""
    panels.require(data, FIGURE)
    series = data["u20"]
    time, position, relative = panels.last_block(series)
    orbit = settled_orbit(time, series.arrays["positions"], series.arrays["velocities"])
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
