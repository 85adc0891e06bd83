"""Fig. 11: a chaotic transient and what follows it."""

import numpy as np

from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Chaotic transient and periodic orbit at u = 20.",
    uses=("u20",),
    words=(
        "At u = 20 without noise, irregular stick-slip motion ends abruptly and gives way to a "
        "small periodic oscillation in which the last block never sticks again."
    ),
    alt=(
        "Position and relative velocity of the last block against time: large irregular swings "
        "that stop and turn into small regular ones, with an enlarged stretch of the latter."
    ),
    number="11",
)

ZOOM = 60.0  # length of the enlarged part, at the end
AFTER = 0.6  # share of the transient's length that is drawn after it


@style.styled
def draw(data, caption):
    """a: x_N(t) from the start; b: v_rN(t); the end of what is drawn is enlarged in both.

    Drawn until some time after the last stick of the last block.
    """
    panels.require(data, ENTRY)
    series = data["u20"]
    time, position, relative = panels.last_block(series)
    last_stick = _last_stick(series)
    shown = time <= (1 + AFTER) * last_stick + ZOOM
    time, position, relative = time[shown], position[shown], relative[shown]

    figure = style.page(caption, 5.2)
    upper, lower = figure.subplots(2, 1, sharex=True)
    panels.letter(upper, "a")
    panels.trace(upper, time, position, ylabel=panels.POSITION)
    panels.make_room(upper, above=0.42)
    panels.letter(lower, "b")
    panels.trace(lower, time, relative, ylabel=panels.RELATIVE_VELOCITY)
    panels.make_room(lower, below=0.42)
    lower.set_xlabel(panels.TIME)
    if time.size:
        window = (time[-1] - ZOOM, time[-1])
        panels.zoom(upper, (0.52, 0.64, 0.45, 0.32), time, position, window)
        panels.zoom(lower, (0.52, 0.10, 0.45, 0.32), time, relative, window)
        if last_stick < time[-1] - ZOOM:
            words = f"last stick at $t$ = {last_stick:.0f}"
        else:
            words = "the last block still sticks at the end of the series"
        upper.set_title(words, loc="right", size=8, color="0.35")
    return figure


def _last_stick(series):
    """Time at which the last block is last seen stuck."""
    time, _, relative = panels.last_block(series)
    stuck = np.flatnonzero(np.abs(relative) < 1e-9)
    return float(time[stuck[-1]]) if stuck.size else 0.0
