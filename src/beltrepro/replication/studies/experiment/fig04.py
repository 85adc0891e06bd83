"""Fig. 4: x_5(t) at 0.28 m/s, with spectra of small and of large amplitudes."""

from beltrepro.replication.drawing import panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.experiment import filmed

FIGURE = Figure(
    title="Position of the last block at 0.28 m/s, with spectra of small and large amplitudes.",
    uses=("belt_028", "belt_028_track", "belt_035", "belt_035_track"),
    words=(
        "Tracked in films of the virtual experiment. a to c: the belt speed of the paper at the "
        "noise that it assigns to the experiment. x_5 is that of the model, in which blocks have "
        "no length; r stands with the 95 % interval of so long a recording. Beside it stands r of "
        "the recording in the paper, whose x_5 may hold lengths of blocks. The real chain changes "
        "between small and large amplitudes there. d to f: the critical speed at more noise, "
        "where the model changes between them. Shaded: small amplitude, that is, a standard "
        "deviation below 5 % of the mean within 5 s. The spectra are those of the longest stretch "
        "of each kind. Peaks of the small amplitude exceed ten times their surroundings. Only "
        "those up to 3.9 Hz are judged; dotted, where there are four or more: the multiples of "
        "one frequency that lie nearest to them."
    ),
    alt=(
        "Six panels, three for each of two recordings: the position against time above the spectra "
        "of its small and of its large amplitudes. Where no small amplitude lasts, words say so."
    ),
    number="4",
)


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
