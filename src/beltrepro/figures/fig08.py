"""Fig. 8: the last block at low belt velocity, without noise."""

import numpy as np

from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Position and relative velocity of the last block at u = 1, with the power spectrum.",
    uses=("u1",),
    words=(
        "At low belt speed and without noise the last block moves in a sawtooth of unequal teeth;"
        " its spectrum falls like a power of frequency. Its velocity relative to the belt is zero"
        " between bursts."
    ),
    alt=(
        "Two panels against time: an irregular sawtooth of the position with its spectrum in an "
        "inset, and bursts of relative velocity with an enlarged stretch."
    ),
    number="8",
)

SHOWN = 3000.0  # last part of the series that is drawn
ZOOM = 30.0  # length of the enlarged part, around the fastest slip


@style.styled
def draw(data, caption):
    """a: x_N(t) with the spectrum of the whole series; b: v_rN(t), enlarged at its fastest slip."""
    panels.require(data, ENTRY)
    series = data["u1"]
    time, position, relative = panels.last_block(series)
    shown = time >= (time[-1] - SHOWN if time.size else 0.0)
    time, position, relative = time[shown], position[shown], relative[shown]

    figure = style.page(caption, 6.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    panels.letter(upper, "a")
    panels.trace(upper, time, position, ylabel=panels.POSITION)
    panels.make_room(upper, above=0.56)
    panels.spectrum_inset(upper, (0.36, 0.575, 0.60, 0.34), series, fit=True)

    panels.letter(lower, "b")
    panels.trace(lower, time, relative, ylabel=panels.RELATIVE_VELOCITY)
    lower.set_xlabel(panels.TIME)
    panels.make_room(lower, below=0.50)
    if time.size:
        middle = time[np.argmin(relative)]
        panels.zoom(
            lower, (0.36, 0.12, 0.60, 0.34), time, relative, (middle - ZOOM / 2, middle + ZOOM / 2)
        )
    return figure
