"""Fig. 5: x_5(t) at 0.22 m/s, with its spectrum."""

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import filmed

FIGURE = Figure(uses=("belt_022", "belt_022_track"), number="5")


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
