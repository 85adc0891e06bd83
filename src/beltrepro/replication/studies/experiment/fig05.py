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
        "slip. Shaded: small amplitude; x_5 and r as in Fig. 4. The spectrum is that of the whole."
    ),
    alt="Position of the last block against time, a sawtooth without rest, above its spectrum.",
    number="5",
)


@style.styled
def draw(data):
    """a: x_5(t); b: the spectrum of all of it."""
    panels.require(data, FIGURE)
    figure = style.page(3.4)
    filmed.mark(figure)
    above, below = figure.subplots(2, 1)
    panels.letter(above, "a")
    panels.letter(below, "b")
    filmed.draw_recording(above, (below,), data, "belt_022")
    panels.make_room(above, above=0.25)
    filmed.say_longest_slip(above, data["belt_022"])
    return figure
