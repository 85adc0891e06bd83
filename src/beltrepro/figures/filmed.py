"""Parts that the figures of the virtual experiment share (Figs. 2 to 5)."""

import itertools
from contextlib import suppress
from dataclasses import dataclass

import cv2
import numpy as np

from beltrepro.analysis.errors import NotEnoughDataError
from beltrepro.analysis.lines import BAND_HZ, lines, spacing
from beltrepro.analysis.recording import LARGE, SMALL, WHOLE, analyse
from beltrepro.experiment import white_block
from beltrepro.experiment.scene import Scene
from beltrepro.experiment.survey import Survey
from beltrepro.experiment.tracking import SPRING
from beltrepro.experiment.white_block import has_size
from beltrepro.figures import panels, style
from beltrepro.figures import recording as drawing
from beltrepro.model.units import TIME_S, to_si

SECONDS = r"$t$ (s)"
LENGTH = "$x_5$ (cm)"
LAMINAR_S = 200 * TIME_S  # a longer stretch of small amplitude is a laminar phase
_SURVEYED = 24  # frames from which it is told where things are
_WORDS = "virtual experiment: a simulated chain, filmed by a simulated camera"


def mark(figure):
    """Say at the top of a page that the experiment is not a real one."""
    figure.suptitle(_WORDS, size=8, style="italic", color=style.VERMILION)


def speed(run):
    """Belt speed and noise of a run in words."""
    velocity = run.attributes["belt_velocity"]
    return (
        rf"$u$ = {to_si(velocity, 'velocity'):.2f} m/s = {velocity:.2f},  "
        rf"$\sigma$ = {run.attributes['noise']:g}"
    )


@dataclass(frozen=True)
class Picture:
    """A frame with the places of the scene in it.

    Attributes
    ----------
    time_s : float
        When it was taken.
    brightness : array (H, W) of uint8
        What it shows.
    survey : Survey
        Where things are in it.
    lane : float
        Middle of the chain, pixels from that of the picture, across the belt.
    """

    time_s: float
    brightness: np.ndarray
    survey: Survey
    lane: float

    def place(self, x_m, y_m=0.0):
        """Pixel of a point, metres along the belt from the support and across it from the chain."""
        survey = self.survey
        turn = np.radians(survey.angle)
        along = survey.towards * (survey.zero + x_m / survey.metres_per_pixel)
        across = self.lane + y_m / survey.metres_per_pixel
        return (
            survey.middle[0] + np.cos(turn) * along - np.sin(turn) * across,
            survey.middle[1] + np.sin(turn) * along + np.cos(turn) * across,
        )

    @property
    def white(self):
        """The picture (H, W) of bool after the threshold: what is bright and not as thin as a
        spring."""
        opening = np.ones((round(SPRING * self.survey.across), 1), np.uint8)
        opened = cv2.morphologyEx(self.brightness, cv2.MORPH_OPEN, opening)
        threshold, _ = cv2.threshold(opened, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
        return opened > threshold


def first_pictures(film, count):
    """The first frames of a film, surveyed as the tracker does."""
    frames = list(itertools.islice(film(), max(count, _SURVEYED)))
    survey = Survey.of(
        [frame.picture for frame in frames[:_SURVEYED]],
        Scene(),
        metres_per_pixel=None,
        first_mark=None,
        support="auto",
        name="film",
    )
    lane = _lane(frames[0].picture, survey)
    return [Picture(frame.time_s, frame.picture, survey, lane) for frame in frames[:count]]


def _lane(picture, survey):
    """Where the white block is across the belt."""
    opening = int(SPRING * survey.across)
    shape = survey.along / survey.across
    regions = white_block.bright_rectangles(picture, survey.angle, shape, opening)
    sizes = survey.along, survey.across
    return survey.across_belt(next(each for each in regions if has_size(each, *sizes)))


def draw_recording(trace, spectra, data, film):
    """x_5(t) of a film with its stretches of small amplitude, and spectra.

    spectra : axes for the longest stretch of small amplitude and of large amplitude; of one only,
        for the whole.
    """
    track = data[f"{film}_track"]
    recording = analyse(track.time_s, track.x_m)
    drawing.draw_trace(trace, recording)
    trace.set(xlabel=SECONDS, ylabel=LENGTH)
    trace.set_title(f"{speed(data[film])};  {trace.get_title()}", size=8)
    names = (SMALL, LARGE) if len(spectra) == 2 else (WHOLE,)
    for axes, name in zip(spectra, names, strict=True):
        spectrum = recording.spectra.get(name)
        if name == SMALL and not _lasts(spectrum):
            longest = 0.0 if spectrum is None else spectrum.end_s - spectrum.begin_s
            _say_none(axes, longest, recording.observed_s)
        elif spectrum is None:
            panels.note(axes, f"no stretch of {name} amplitude")
        else:
            drawing.draw_spectrum(axes, spectrum, name)
            if name == SMALL:
                _draw_multiples(axes, recording, spectrum)


def _lasts(spectrum):
    """Whether a stretch of small amplitude is a laminar phase."""
    return spectrum is not None and spectrum.end_s - spectrum.begin_s > LAMINAR_S


def _say_none(axes, longest_s, observed_s):
    words = (
        f"The model does not alternate here: no stretch of small amplitude of {LAMINAR_S:.0f} s or "
        f"more in {observed_s:.0f} s. The longest has {longest_s:.0f} s."
    )
    panels.note(axes, words, width=34)
    axes.set(xticks=[], yticks=[])


def _draw_multiples(axes, recording, spectrum):
    """The frequency whose multiples lie nearest to the peaks of a spectrum, if it has peaks."""
    values = recording.evenly(spectrum.begin_s, spectrum.end_s)
    with suppress(NotEnoughDataError):
        found = spacing(lines(values, recording.interval_s).peaks_hz)
        for number in range(1, int(BAND_HZ[1] / found.step_hz) + 1):
            axes.axvline(number * found.step_hz, color=style.GREY, linewidth=0.7, linestyle=":")
        words = f"peaks: multiples of {found.step_hz:.3g} Hz, p = {found.p:.2g}"
        axes.text(0.03, 0.05, words, transform=axes.transAxes, size=7)
