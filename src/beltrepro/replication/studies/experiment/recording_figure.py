"""A recording of the last block, drawn like Figs. 4 and 5; `beltrepro analyse` calls it."""

from pathlib import Path

import numpy as np

from beltrepro.base.errors import InputError
from beltrepro.replication.camera.recording import LARGE, SMALL, WHOLE
from beltrepro.replication.drawing import panels, style

SUFFIXES = (".png", ".pdf", ".svg")
_COLOURS = {WHOLE: style.SKY, SMALL: style.GREEN, LARGE: style.BLUE}
_WORDS = {WHOLE: "whole", SMALL: "small amplitude", LARGE: "large amplitude"}
HIGHEST_HZ = 8.0  # beyond it lies only the noise of the picture


@style.styled
def save(recording, path):
    """Draw a recording into a file; InputError for another ending than those of SUFFIXES."""
    if Path(path).suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: the name of a figure must end in {', '.join(SUFFIXES)}")
    style.write(draw_recording(recording), path, Path(path).stem, "recording")


@style.styled
def draw_recording(recording):
    """x_N(t), stretches of small amplitude shaded; below, spectra of the parts of Figs. 4 and 5."""
    figure = style.page(3.4)
    names = [name for name in (SMALL, LARGE, WHOLE) if name in recording.spectra]
    if len(names) == 2:  # one part is the whole
        names = [name for name in names if name != WHOLE]
    above, *below = figure.subplot_mosaic([["x"] * len(names), names]).values()
    above.set_title("\n".join(draw_trace(above, recording)))
    for axes, name in zip(below, names, strict=True):
        draw_spectrum(axes, recording.spectra[name], name)
    return figure


def draw_trace(axes, recording):
    """x_N(t) in seconds and centimetres, with its mean; small amplitudes are shaded.

    Returns two lines of words, on r and on the small amplitude.
    """
    time, position = recording.time_s.copy(), 100 * recording.x_m
    # A line across a gap would show what was not seen.
    gaps = np.flatnonzero(np.diff(time) > 3 * recording.interval_s) + 1
    panels.trace(axes, np.insert(time, gaps, np.nan), np.insert(position, gaps, np.nan), ylabel="")
    axes.set(xlabel="$t$ (s)", ylabel="$x_N$ (cm)", xlim=(time[0], time[-1]))
    for begin, end in recording.small_s:
        axes.axvspan(begin, end, color=style.GREEN, alpha=0.15, linewidth=0)
    axes.axhline(100 * recording.mean_length, color=style.GREY, linewidth=0.8, linestyle="--")
    longest = np.diff(recording.small_s, axis=1).max(initial=0.0)
    share = f"small amplitude {100 * recording.small_share:.0f} % of the time"
    return f"$r$ = {recording.disorder.words}", f"{share}, {longest:.0f} s at most"


def draw_spectrum(axes, spectrum, name):
    """Power spectrum of a stretch of a recording, with its power law if it has one."""
    shown = spectrum.frequency_hz <= HIGHEST_HZ
    frequency, power = spectrum.frequency_hz[shown], spectrum.power[shown]
    axes.loglog(frequency, power, color=_COLOURS[name], linewidth=0.6, rasterized=True)
    axes.set(xlabel=r"$\nu$ (Hz)", ylabel=r"$S(\nu)$ (m$^2$/Hz)", xlim=(frequency[0], HIGHEST_HZ))
    axes.set_ylim(np.quantile(power, 0.02), 5 * power.max())
    if 100 * frequency[0] > HIGHEST_HZ:
        panels.plain_log(axes.xaxis)
    title = [_WORDS[name], f"{spectrum.begin_s:.0f} to {spectrum.end_s:.0f} s"]
    if spectrum.law:
        band = np.array([spectrum.law.low, spectrum.law.high])
        axes.plot(band, spectrum.law(band), color=style.VERMILION, linewidth=1.4)
        title.insert(1, panels.true_minus(f"$p$ = {spectrum.exponent.words}"))
    panels.remark(axes, "\n".join(title))  # the letter is beside the last line
