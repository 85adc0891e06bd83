"""Claims on the experiment (Sec. II), measured in trials and in films of the model."""

from functools import partial

import numpy as np
import scipy

from beltrepro.base.errors import require
from beltrepro.model.units import LENGTH_M, TIME_S, from_si
from beltrepro.replication.camera.recording import LASTING_S, analyse
from beltrepro.replication.studies.experiment import films
from beltrepro.replication.studies.experiment.lines import (
    LEAST_PEAKS,
    SEGMENT_S,
    lines,
    pieces,
    spacing,
    spectral_ratio,
    stand_out,
)
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates

FILMS = films.BELTS
AT_022, AT_028, INTERMITTENT = FILMS
SHORTEST_S = 900.0  # of a recording: the paper's are some hundred seconds long
LAMINAR_SHARE = (0.05, 0.95)
STRETCHES = 20
BAND_HZ = 0.4  # over which spectra are averaged before they are compared
RANDOM = 0.01  # chance that random peaks are as near to multiples of one frequency


# --- the measurement: Figs. 2 and 3 ---------------------------------------------------------------


@claim("snapshot")
def snapshot(evidence):
    """Share of the frames in which the last block is found, and whether it is that block."""
    shares, largest = [], []
    for name in FILMS:
        track, true, interval = _filmed(evidence, name)
        n_seen = len(track.time_s)
        shares.append(estimates.share(n_seen, n_seen + _lost_frames(track)))
        largest.append(films.tracking_error(track.time_s, track.x_m, true, interval).largest)
    return Measurement(
        {
            "share of the frames with the block": min(shares, key=lambda share: share.value),
            "largest error (m)": estimates.sure(max(largest)),
        },
        note=f"of {len(FILMS)} films, the one with the least; the runs are its frames",
    )


@claim("threshold")
def threshold(evidence):
    """Errors of x_5, of the scale and of r, of the film in which each is largest."""
    by_film = [_errors(evidence, name) for name in FILMS]
    worst = {
        name: max((errors[name] for errors in by_film), key=lambda error: abs(error.value))
        for name in by_film[0]
    }
    return Measurement(worst, note=f"{STRETCHES} stretches of each film")


def _errors(evidence, name):
    """Errors in stretches of a film."""
    track, true, interval = _filmed(evidence, name)
    rows = []
    for time, place in zip(
        np.array_split(track.time_s, STRETCHES), np.array_split(track.x_m, STRETCHES), strict=True
    ):
        error = films.tracking_error(time, place, true, interval)
        seen = true[np.rint(time / interval).astype(int)]
        in_pixels = np.array([error.scatter, error.offset]) / track.metres_per_pixel
        rows.append([*in_pixels, error.scale, _disorder(place) / _disorder(seen) - 1])
    names = [
        "scatter of x_5 (pixels)",
        "offset of x_5 (pixels)",
        "error of the scale",
        "error of r",
    ]
    columns = np.array(rows).T
    return {name: estimates.mean(column) for name, column in zip(names, columns, strict=True)}


def _filmed(evidence, name):
    """Track of a film, the positions that were filmed, and the time between them, in SI."""
    run, track = evidence.dataset(name), evidence.track(name)
    true = run.arrays["positions"][:, -1] * LENGTH_M
    return track, true, float(run.attributes["sample_interval"]) * TIME_S


def _disorder(position):
    return position.std() / position.mean()


def _lost_frames(track):
    """Number of frames in which the block was not found."""
    interval = np.median(np.diff(track.time_s))
    return sum(round((end - begin) / interval) + 1 for begin, end in track.lost_s)


# --- small and large amplitudes: Fig. 4 -----------------------------------------------------------


@claim("experiment-028")
def experiment_028(evidence):
    """How often the model alternates, and spectra of the stretches of small and large amplitude."""
    return {
        "sigma = 1": partial(_alternation, evidence, 1.0, AT_028),
        "sigma = 2": partial(_alternation, evidence, 2.0, AT_028),
        "one film, 0.35 m/s, sigma = 2.2": partial(_alternation, evidence, None, INTERMITTENT),
    }


def _alternation(evidence, noise, film):
    recording = _recording(evidence, film)
    share = recording.lasting_share if noise is None else _trials(evidence, noise)["lasting_share"]
    low, high = LAMINAR_SHARE
    alternates = np.atleast_1d((share >= low) & (share <= high))
    small, large = _stretches(recording)
    step = [_equally_spaced(recording, stretch) for stretch in small]
    flat = [_flatness(recording, stretches) for stretches in (small, large)]
    return Measurement(
        {
            "trials that alternate": estimates.share(int(alternates.sum()), alternates.size),
            "small stretches with peaks at equal distances": (
                estimates.share(sum(spaced > 0 for spaced in step), len(step))
                if step
                else estimates.absent()
            ),
            "flatness, large": flat[1],
            "flatness, large minus small": estimates.difference(flat[1], flat[0]),
        },
        {"share of small amplitude in the film": estimates.single(recording.lasting_share)},
        note=f"{len(small)} stretches of small amplitude in the film; peaks at multiples of "
        + (
            ", ".join(f"{spaced:.3g}" for spaced in sorted(set(step) - {0.0})) + " Hz"
            if any(step)
            else "none"
        ),
    )


def _stretches(recording):
    """Begin and end of stretches of small amplitude, and between, long enough for a spectrum."""
    begin, end = recording.time_s[[0, -1]]
    between = np.r_[begin, recording.small_s.ravel(), end].reshape(-1, 2)
    shortest = max(LASTING_S, SEGMENT_S) + 2 * recording.interval_s
    return tuple(
        spans[np.diff(spans, axis=1)[:, 0] > shortest] for spans in (recording.small_s, between)
    )


def _equally_spaced(recording, stretch):
    """Frequency in Hz whose multiples the peaks of a stretch are; 0 without such peaks."""
    peaks_hz = lines(recording.evenly(*stretch), recording.interval_s).peaks_hz
    if peaks_hz.size < LEAST_PEAKS:
        return 0.0
    best = spacing(peaks_hz)
    return best.step_hz if best.p < RANDOM else 0.0


def _flatness(recording, stretches):
    """Of the mean spectrum of all pieces of some stretches, which are drawn anew."""
    if not len(stretches):
        return estimates.absent()
    frequency, power = _pieces(recording, stretches)
    return estimates.bootstrap(
        lambda drawn: stand_out(frequency, drawn.mean(axis=0)).flatness, [power]
    )


def _pieces(recording, stretches):
    spectra = [pieces(recording.evenly(*span), recording.interval_s) for span in stretches]
    return spectra[0][0], np.concatenate([power for _, power in spectra])


# --- continuous slip: Fig. 5 ----------------------------------------------------------------------


@claim("experiment-022")
def experiment_022(evidence):
    """How often all blocks slip for a minute, and the spectrum of the whole."""
    return {
        "sigma = 1": partial(_long_slip, evidence, "all_slip_longest"),
        "sigma = 1, the last block slips": partial(_long_slip, evidence, "slip_longest"),
        "sigma = 1, small amplitude": partial(_long_slip, evidence, "lasting_longest"),
        "sigma = 2": partial(_long_slip, evidence, "all_slip_longest", noise=2.0),
        "one film, 0.35 m/s, sigma = 2.2": partial(_long_slip_in_film, evidence),
    }


def _long_slip(evidence, length, *, noise=1.0):
    return _judged_slip(evidence, _trials(evidence, noise)[length] * TIME_S, AT_022)


def _long_slip_in_film(evidence):
    longest = films.longest_slip_of_all_s(evidence.dataset(INTERMITTENT))
    return _judged_slip(evidence, np.array([longest]), INTERMITTENT)


def _judged_slip(evidence, longest_s, film):
    shortest = evidence.claim.parameters["longer_than_s"]
    count = int((longest_s > shortest).sum())
    return Measurement(
        {
            "trials with a minute of slip of all blocks": estimates.share(count, longest_s.size),
            "factor between the spectra": _factor(evidence, film),
        },
        note=f"longest in a trial: median {np.median(longest_s):.3g} s, at most "
        f"{longest_s.max():.3g} s",
    )


def _factor(evidence, film):
    """Between the spectrum of a film and that of the large amplitudes at 0.28 m/s."""
    one, other = _recording(evidence, film), _recording(evidence, AT_028)
    frequency, whole = _pieces(one, [one.time_s[[0, -1]]])
    _, large = _pieces(other, _stretches(other)[1])

    size = round(BAND_HZ / (frequency[1] - frequency[0]))

    def factor(*powers):
        # Two noisy spectra of one law would differ at single frequencies.
        smooth = [scipy.ndimage.uniform_filter1d(power.mean(axis=0), size) for power in powers]
        return spectral_ratio(*(stand_out(frequency, power) for power in smooth))

    return estimates.bootstrap(factor, [whole, large])


# --- shared ---------------------------------------------------------------------------------------


def _trials(evidence, noise):
    """Trials at the speed of the claim and a noise."""
    trials = evidence.dataset("trials")
    seconds = TIME_S * float(trials.attributes["duration"] - trials.attributes["transient"])
    require(seconds >= SHORTEST_S, f"trials of {seconds:.0f} s, {SHORTEST_S:g} s are needed")
    speed = from_si(evidence.claim.parameters["belt_velocity_m_s"], "velocity")
    arrays = trials.arrays
    chosen = np.isclose(arrays["belt_velocity"], speed, rtol=1e-3)
    chosen &= np.isclose(arrays["noise"], noise)
    require(chosen.any(), f"no trials at u = {speed:.4g}, sigma = {noise:g}")
    names = ("lasting_share", "lasting_longest", "slip_longest", "all_slip_longest")
    return {name: arrays[name][chosen] for name in names}


def _recording(evidence, name):
    track = evidence.track(name)
    recording = analyse(track.time_s, track.x_m)
    seconds = recording.observed_s
    require(
        seconds >= SHORTEST_S, f"the film {name} has {seconds:.0f} s, {SHORTEST_S:g} are needed"
    )
    return recording
