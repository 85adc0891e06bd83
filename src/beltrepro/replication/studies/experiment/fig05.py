"""Fig. 5: x_5(t) at 0.22 m/s, with its spectrum."""

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import filmed

FIGURE = Figure(
    title="Position of the last block at 0.22 m/s, with its spectrum.",
    uses=("belt_022", "belt_022_track"),
    words=(
        "Tracked in a film of the virtual experiment, at the noise that the paper assigns to the "
        "experiment. There, avalanches were broken by more than a minute in which all blocks "
        "slip. Shaded green: small amplitude; x_5 and r as in Fig. 4. b: the spectrum of the "
        "whole. c: a minute of a, shaded orange there, in which single slips are seen."
    ),
    alt=(
        "Three panels: the position of the last block against time, its spectrum, and a minute of "
        "it, a sawtooth without rest."
    ),
    number="5",
)


_ENLARGED_S = 60.0  # in which single slips are seen


@style.styled
def draw(data):
    """a: x_5(t); b: the spectrum of all of it; c: a minute of it."""
    panels.require(data, FIGURE)
    figure = style.page(4.4)
    filmed.mark(figure)
    above, below, enlarged = figure.subplots(3, 1)
    for axes, mark in zip((above, below, enlarged), "abc", strict=True):
        panels.letter(axes, mark)
    filmed.draw_recording(above, (below,), data, "belt_022")
    filmed.say_longest_slip(above, data["belt_022"])
    track = data["belt_022_track"]
    middle = (track.time_s[0] + track.time_s[-1]) / 2
    window = middle - _ENLARGED_S / 2, middle + _ENLARGED_S / 2
    panels.zoom(above, enlarged, track.time_s, 100 * track.x_m, window)
    enlarged.set(xlabel=filmed.SECONDS, ylabel=filmed.LENGTH)
    return figure
