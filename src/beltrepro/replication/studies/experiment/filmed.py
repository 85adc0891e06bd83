"""Parts that the figures of the virtual experiment share (Figs. 2 to 5)."""

import textwrap

import numpy as np

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.model.units import to_si
from beltrepro.replication.camera.recording import LARGE, LASTING_S, SMALL, WHOLE, analyse
from beltrepro.replication.drawing import panels, style
from beltrepro.replication.studies.experiment import films, observations
from beltrepro.replication.studies.experiment import recording_figure as drawing
from beltrepro.replication.studies.experiment.lines import BAND_HZ, LEAST_PEAKS, lines, spacing

SECONDS = r"$t$ (s)"
LENGTH = "$x_5$ (cm)"

_LETTERS = 24  # in a line of words on a narrow panel
_WORDS = "virtual experiment: simulated chain, simulated camera"


def mark(figure):
    """Say at the top of a page that the experiment is not a real one."""
    figure.suptitle(_WORDS, size=6.5, style="italic", color=style.VERMILION)


def speed(run):
    """Belt speed and noise of a run in words."""
    velocity = run.attributes["belt_velocity"]
    return (
        rf"$u$ = {to_si(velocity, 'velocity'):.2f} m/s = {velocity:.2f}, "
        rf"$\sigma$ = {run.attributes['noise']:g}"
    )


def pixel(track, x_m, y_m=0.0):
    """Pixel of a point, metres along the belt from the fixed point and across it from the chain."""
    angle, (column, row) = np.radians(track.angle), track.zero
    along, across = x_m / track.metres_per_pixel, y_m / track.metres_per_pixel
    return (
        column + along * np.cos(angle) - across * np.sin(angle),
        row + along * np.sin(angle) + across * np.cos(angle),
    )


def draw_recording(trace, spectra, data, film):
    """x_5(t) of a film, and spectra of its longest small and large amplitude, or of the whole."""
    track = data[f"{film}_track"]
    try:
        recording = analyse(track.time_s, track.x_m)
    except NotEnoughDataError as reason:
        for axes in (trace, *spectra):
            panels.note(axes, str(reason))
        return
    disorder, small = drawing.draw_trace(trace, recording)
    trace.set(xlabel=SECONDS, ylabel=LENGTH)
    printed = _printed_disorder(data[film])
    panels.remark(trace, "\n".join([speed(data[film]), disorder + printed, small]))
    names = (SMALL, LARGE) if len(spectra) == 2 else (WHOLE,)
    for axes, name in zip(spectra, names, strict=True):
        spectrum = recording.spectra.get(name)
        length = 0.0 if spectrum is None else spectrum.end_s - spectrum.begin_s
        if name == SMALL and length <= LASTING_S:
            words = (
                f"The model does not alternate here: no stretch of small amplitude of "
                f"{LASTING_S:.0f} s or more in {recording.observed_s:.0f} s. The longest has "
                f"{length:.0f} s."
            )
            panels.note(axes, words, width=22)
            axes.set(xticks=[], yticks=[])
        elif spectrum is None:
            panels.note(axes, f"no stretch of {name} amplitude")
        else:
            drawing.draw_spectrum(axes, spectrum, name)
            if name == SMALL:
                _draw_multiples(axes, recording, spectrum)


def _printed_disorder(run):
    """Words for r of the recording at the belt speed of a run, if the paper prints one."""
    for recorded in observations.EXPERIMENT:
        if observations.at_speed(recorded, run.attributes):
            return f" (paper, recorded: {recorded.disorder_parameter:g})"
    return ""


def say_longest_slip(axes, run):
    """How long all blocks of a run slip at once, at most."""
    longest = films.longest_slip_of_all_s(run)
    words = f"all blocks slip at once for {longest:.2g} s at most (paper: over 60 s)"
    panels.remark(axes, f"{axes.get_title(loc='right')}\n{words}")


def _draw_multiples(axes, recording, spectrum):
    """The frequency whose multiples lie nearest to the peaks of a spectrum, if it has peaks."""
    values = recording.evenly(spectrum.begin_s, spectrum.end_s)
    with panels.shortage_on(axes, place=(0.3, 0.85)):
        seen = BAND_HZ[0], drawing.HIGHEST_HZ
        peaks = lines(values, recording.interval_s, band_hz=seen).peaks_hz
        found = "peaks (Hz): " + (", ".join(f"{peak:.2f}" for peak in peaks) or "none")
        words = textwrap.wrap(found, _LETTERS)
        peaks = peaks[peaks <= BAND_HZ[1]]  # those that are judged
        if peaks.size >= LEAST_PEAKS:
            best = spacing(peaks)
            for number in range(1, int(BAND_HZ[1] / best.step_hz) + 1):
                axes.axvline(number * best.step_hz, color=style.GREY, linewidth=0.7, linestyle=":")
            words += [f"multiples of {best.step_hz:.3g} Hz:", f"p = {best.p:.2g}"]
        low, high = axes.get_ylim()
        axes.set_ylim(low, high * (high / low) ** (0.15 * len(words)))
        axes.text(0.03, 0.96, "\n".join(words), transform=axes.transAxes, va="top")
