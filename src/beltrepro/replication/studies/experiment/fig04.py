"""Fig. 4: x_5(t) at 0.28 m/s, with spectra of small and of large amplitudes."""

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import filmed

FIGURE = Figure(uses=("belt_028", "belt_028_track", "belt_035", "belt_035_track"), number="4")


@style.styled
def draw(data):
    """a to c: x_5(t) at 0.28 m/s and its spectra; d to f: the same at 0.35 m/s."""
    panels.require(data, FIGURE)
    figure = style.page(5.8)
    filmed.mark(figure)
    places = figure.subplot_mosaic([["a", "a"], ["b", "c"], ["d", "d"], ["e", "f"]])
    for name, axes in places.items():
        panels.letter(axes, name)
    filmed.draw_recording(places["a"], (places["b"], places["c"]), data, "belt_028")
    filmed.draw_recording(places["d"], (places["e"], places["f"]), data, "belt_035")
    return figure
