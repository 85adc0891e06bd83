"""Claims on the experiment (Sec. II), measured in films of the model by a virtual camera."""

from functools import partial

import numpy as np

from beltrepro.analysis.errors import require
from beltrepro.analysis.intermittency import slips_of_all
from beltrepro.analysis.lines import LEAST_PEAKS, lines, spacing, spectral_ratio
from beltrepro.analysis.recording import LARGE, SMALL, analyse
from beltrepro.analysis.tracking_error import tracking_error
from beltrepro.claims.criteria import Measurement
from beltrepro.claims.registry import claim
from beltrepro.model.units import LENGTH_M, TIME_S, to_si

FILMS = ("belt_022", "belt_028", "belt_035")
AT_022, AT_028, INTERMITTENT = FILMS
SHORTEST_S = 900.0  # of a recording: the paper's are some hundred seconds long
HALF_BLOCK_M = 0.02
LAMINAR_SHARE = (0.05, 0.95)
ALL_SLIP_S = 60.0


# --- the measurement: Figs. 2 and 3 ---------------------------------------------------------------


@claim("snapshot")
def snapshot(evidence):
    """Share of the frames in which the last block is found, and whether it is that block."""
    found, checks, places = {}, {}, 0
    for name in FILMS:
        track, error, _ = _compared(evidence, name)
        share = len(track.time_s) / (len(track.time_s) + _lost_frames(track))
        speed = _speed(evidence, name)
        found[speed] = share
        checks[f"{speed}: found"] = share >= 0.99
        checks[f"{speed}: no other thing"] = error.largest < HALF_BLOCK_M
        places += error.places
    return Measurement(found, sample_size=places, checks=checks, note="share of the frames")


@claim("threshold")
def threshold(evidence):
    """Errors of x_5, of the scale and of r in each film."""
    values, checks, places = {}, {}, 0
    for name in FILMS:
        track, error, ratio = _compared(evidence, name)
        speed, pixel = _speed(evidence, name), track.metres_per_pixel
        values[f"{speed}: pixels"] = error.scatter / pixel
        values[f"{speed}: r by"] = ratio - 1
        checks[f"{speed}: x_5"] = max(error.scatter, abs(error.offset)) < 0.2 * pixel
        checks[f"{speed}: scale"] = abs(error.scale) < 1e-3
        checks[f"{speed}: r"] = abs(ratio - 1) < 0.01
        places += error.places
    return Measurement(values, sample_size=places, checks=checks)


def _compared(evidence, name):
    """Track of a film, its error, and its r over that of the positions at the same instants."""
    run, track = evidence.dataset(name), evidence.track(name)
    true = run.arrays["positions"][:, -1] * LENGTH_M
    interval = float(run.attributes["sample_interval"]) * TIME_S
    error = tracking_error(track.time_s, track.x_m, true, interval)
    seen = true[np.rint(track.time_s / interval).astype(int)]
    return track, error, _disorder(track.x_m) / _disorder(seen)


def _disorder(position):
    return position.std() / position.mean()


def _lost_frames(track):
    """Number of frames in which the block was not found."""
    interval = np.median(np.diff(track.time_s))
    return sum(round((end - begin) / interval) + 1 for begin, end in track.lost_s)


# --- small and large amplitudes: Fig. 4 -----------------------------------------------------------


@claim("experiment-028")
def experiment_028(evidence):
    """Spectra of the stretches of small and of large amplitude."""
    return {
        "0.28 m/s, sigma = 1": partial(_alternation, evidence, AT_028),
        "0.35 m/s, sigma = 2.2": partial(_alternation, evidence, INTERMITTENT),
    }


def _alternation(evidence, name):
    recording = _recording(evidence, name)
    low, high = LAMINAR_SHARE
    share = recording.lasting_share
    values = {"share of small amplitude": share, "r": recording.disorder_parameter}
    if not low <= share <= high:
        note = f"the model does not alternate in {recording.observed_s:.0f} s"
        return Measurement(values, sample_size=1, checks={"alternates": False}, note=note)
    small, large = (_lines(recording, recording.spectra[part]) for part in (SMALL, LARGE))
    checks = {"alternates": True, "small amplitude: peaks": small.peaks_hz.size >= LEAST_PEAKS}
    words = "too few peaks"
    if checks["small amplitude: peaks"]:
        step = spacing(small.peaks_hz)
        checks["small amplitude: peaks at equal distances"] = step.p < 0.01
        words = f"multiples of {step.step_hz:.3g} Hz with p = {step.p:.2g}"
    flat = large.flatness > max(0.5, small.flatness)
    checks["large amplitude: quasi-continuous"] = bool(flat)
    values |= {"flatness, small": small.flatness, "flatness, large": large.flatness}
    places = ", ".join(f"{peak:.2f}" for peak in small.peaks_hz) or "none"
    note = f"peaks of the longest stretch of small amplitude in Hz: {places}; {words}"
    return Measurement(values, sample_size=len(recording.small_s), checks=checks, note=note)


def _recording(evidence, name):
    track = evidence.track(name)
    recording = analyse(track.time_s, track.x_m)
    seconds = recording.observed_s
    require(
        seconds >= SHORTEST_S, f"the film {name} has {seconds:.0f} s, {SHORTEST_S:g} are needed"
    )
    return recording


def _lines(recording, spectrum=None):
    """Lines of a stretch, or of the whole."""
    begin, end = recording.time_s[[0, -1]]
    if spectrum is not None:
        begin, end = spectrum.begin_s, spectrum.end_s
    return lines(recording.evenly(begin, end), recording.interval_s)


# --- continuous slip: Fig. 5 ----------------------------------------------------------------------


@claim("experiment-022")
def experiment_022(evidence):
    """The longest slip of all blocks at once, and the spectrum of the whole."""
    return {
        "0.22 m/s, sigma = 1": partial(_long_slip, evidence, AT_022),
        "0.22 m/s, sigma = 1, as the film shows it": partial(_long_calm, evidence, AT_022),
        "0.35 m/s, sigma = 2.2": partial(_long_slip, evidence, INTERMITTENT),
        "0.35 m/s, sigma = 2.2, as the film shows it": partial(_long_calm, evidence, INTERMITTENT),
    }


def _long_slip(evidence, name):
    """By the slips and sticks of all blocks."""
    run = evidence.dataset(name)
    time, velocities, events = (run.arrays[each] for each in ("time", "velocities", "events"))
    spans = slips_of_all(time, velocities - run.attributes["belt_velocity"], events)
    return _judged_spans(evidence, name, TIME_S * spans, TIME_S * time[[0, -1]], "all blocks slip")


def _long_calm(evidence, name):
    """By the stretches of small amplitude, which are all that a film of the last block shows."""
    recording = _recording(evidence, name)
    span = recording.time_s[[0, -1]]
    return _judged_spans(evidence, name, recording.small_s, span, "small amplitude")


def _judged_spans(evidence, name, spans, span, words):
    """Whether the longest of some stretches lasts a minute, with others around it."""
    recording, other = _recording(evidence, name), _recording(evidence, AT_028)
    inside = spans[(spans[:, 0] > span[0]) & (spans[:, 1] < span[1])]
    longest = float(np.diff(inside, axis=1).max(initial=0.0))
    ratio = spectral_ratio(_lines(recording), _lines(other, other.spectra.get(LARGE)))
    return Measurement(
        {f"longest, {words} (s)": longest, "factor between the spectra": ratio},
        sample_size=len(spans),
        checks={
            f"{words} for more than a minute": longest > ALL_SLIP_S,
            "spectrum as of large amplitudes at 0.28 m/s": ratio < 1.5,
        },
        note="" if longest > ALL_SLIP_S else f"the model does not in {recording.observed_s:.0f} s",
    )


def _speed(evidence, name):
    """The belt speed of a film in words."""
    return f"{to_si(evidence.dataset(name).attributes['belt_velocity'], 'velocity'):.2f} m/s"
