"""Fig. 8: the last block at low belt velocity, without noise."""

import numpy as np

from beltrepro.replication.drawing import marks, panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.avalanches import measure
from beltrepro.stats.fits import PowerLawFit
from beltrepro.stats.spectra import FIT_BAND

FIGURE = Figure(
    title="Position and relative velocity of the last block at u = 1, with the power spectrum.",
    uses=("u1",),
    words=(
        "At low belt speed and without noise the last block moves in a sawtooth of unequal teeth;"
        " its spectrum falls like a power of frequency. Its velocity relative to the belt is zero"
        " between bursts. Beside them the spectrum of the whole series and the fastest slip: in "
        "the paper, insets. The exponent that the paper prints is nearer to that of the amplitude."
    ),
    alt=(
        "Four panels: an irregular sawtooth of the position against time and its spectrum with a "
        "fitted line and a dashed one; bursts of relative velocity, and one of them enlarged."
    ),
    number="8",
    shows={"spectrum-exponent": ("exponent",)},
)

SHOWN = 3000.0  # last part of the series that is drawn
ZOOM = 30.0  # length of the enlarged part, around the fastest slip
EXPONENT = -1.21  # of the spectrum, in the caption of Fig. 8


@style.styled
def draw(data, caption):
    """a: x_N(t) and the spectrum of the whole series; b: v_rN(t), enlarged at its fastest slip."""
    panels.require(data, FIGURE)
    series = data["u1"]
    time, position, relative = panels.last_block(series)
    shown = time >= (time[-1] - SHOWN if time.size else 0.0)
    time, position, relative = time[shown], position[shown], relative[shown]

    figure = style.page(caption, 4.6)
    (upper, spectrum), (lower, enlarged) = figure.subplots(2, 2, width_ratios=(1.7, 1))
    panels.letter(upper, "a")
    panels.trace(upper, time, position, ylabel=panels.POSITION)
    panels.spectrum(spectrum, series)
    with panels.shortage_on(spectrum):
        _law(spectrum, series)
    panels.letter(lower, "b")
    panels.trace(lower, time, relative, ylabel=panels.RELATIVE_VELOCITY)
    lower.set_xlabel(panels.TIME)
    enlarged.set(xlabel=panels.TIME, ylabel=panels.RELATIVE_VELOCITY)
    if time.size:
        middle = time[np.argmin(relative)]
        window = middle - ZOOM / 2, middle + ZOOM / 2
        panels.zoom(lower, enlarged, time, relative, window)
    else:
        panels.note(enlarged, "no samples")
    return figure


def _law(axes, series):
    """The power law of the mean spectrum of its stretches, beside the printed exponent."""
    exponent, prefactor, *_ = measure.spectral_law(series)
    law = PowerLawFit(exponent.value, np.nan, prefactor.value, *FIT_BAND)
    words = rf"$S = {law.prefactor:.2g}\,\nu^{{{law.exponent:.2f}}}$"
    panels.power_law(axes, law, label=words)
    panels.printed_slope(axes, law, EXPONENT)
    first, *_ = axes.legend(loc="lower left", fontsize=7).get_texts()
    marks.shown(first, "spectrum-exponent", "exponent")
    half = rf"amplitude $\sqrt{{S}} \propto \nu^{{{law.exponent / 2:.2f}}}$"
    axes.set_title(half, size=8, color=style.VERMILION)
