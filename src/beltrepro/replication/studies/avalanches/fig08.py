"""Fig. 8: the last block at low belt velocity, without noise."""

import numpy as np

from beltrepro.replication.drawing import marks, panels, style
from beltrepro.replication.plan.registry import Figure
from beltrepro.replication.studies.avalanches import measure
from beltrepro.replication.verdicts.ledger import printed
from beltrepro.stats.power_law import PowerLawFit
from beltrepro.stats.spectra import FIT_BAND

FIGURE = Figure(uses=("u1",), number="8", shows={"spectrum-exponent": ("exponent",)})

SHOWN = 3000.0  # last part of the series that is drawn
ZOOM = 30.0  # length of the enlarged part, around the fastest slip
_ROOM = 5000  # factor by which the axis of the spectrum is longer, for the legend
_DASHED = {"linestyle": "--", "color": style.BLACK, "linewidth": 1.0}


@style.styled
def draw(data):
    """a: x_N(t); b: v_rN(t); c: the spectrum of the whole series; d: the fastest slip of b."""
    panels.require(data, FIGURE)
    series = data["u1"]
    time, position, relative = panels.last_block(series)
    shown = time >= (time[-1] - SHOWN if time.size else 0.0)
    time, position, relative = time[shown], position[shown], relative[shown]

    figure = style.page(4.2)
    places = figure.subplot_mosaic([["a", "a"], ["b", "b"], ["c", "d"]], height_ratios=(1, 1, 1.4))
    upper, lower, spectrum, enlarged = places.values()
    for mark, axes in places.items():
        panels.letter(axes, mark)
    panels.trace(upper, time, position, ylabel=panels.POSITION)
    panels.spectrum(spectrum, series, measure.as_amplitude, ylabel=r"amplitude $A(\nu)$")
    with panels.shortage_on(spectrum):
        _law(spectrum, series)
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
    """The power law of the mean spectrum of its stretches, beside the printed one."""
    fit, paper = measure.amplitude_law(series), printed("spectrum-exponent")
    for exponent, prefactor, words, look in (
        (fit.exponent.value, fit.prefactor.value, "fit: ", {}),
        (paper["exponent"], paper["prefactor"], "paper: ", _DASHED),
    ):
        law = PowerLawFit(exponent, np.nan, prefactor, *FIT_BAND)
        label = rf"{words}${prefactor:.2g}\,\nu^{{{exponent:.2f}}}$"
        panels.power_law(axes, law, label=label, **look)
    axes.set_ylim(bottom=axes.get_ylim()[0] / _ROOM)
    first, *_ = axes.legend(loc="lower left").get_texts()
    marks.shown(first, "spectrum-exponent", "exponent")
