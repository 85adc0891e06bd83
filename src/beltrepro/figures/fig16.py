"""Fig. 16: noise-induced intermittency."""

from beltrepro.figures import panels, style
from beltrepro.figures.registry import Entry

ENTRY = Entry(
    title="Noise-induced intermittency at u = 17.5, with the power spectrum.",
    uses=("u17",),
    words=(
        "With noise, in the transition region, the last block alternates between long quiet "
        "stretches and bursts of large swings, as in the experiment."
    ),
    alt=(
        "Position of the last block against time, quiet stretches between bursts, with its "
        "spectrum in an inset."
    ),
    number="16",
)

SHOWN = 10000.0  # last part of the series that is drawn


@style.styled
def draw(data, caption):
    """x_N(t); inset: spectrum of the whole series after its transient."""
    panels.require(data, ENTRY)
    series = data["u17"]
    time, position, _ = panels.last_block(series)
    shown = time >= (time[-1] - SHOWN if time.size else 0.0)
    figure = style.page(caption, 4.0)
    axes = figure.subplots()
    panels.trace(axes, time[shown], position[shown], ylabel=panels.POSITION)
    axes.set_xlabel(panels.TIME)
    panels.make_room(axes, above=0.5)
    panels.spectrum_inset(axes, (0.42, 0.63, 0.55, 0.34), series, fit=False)
    return figure
