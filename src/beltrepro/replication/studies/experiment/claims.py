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


# --- what the model shows beside the recordings: Figs. 4 and 5 ------------------------------------


@claim("experiment-028")
def experiment_028(evidence):
    """How often the model alternates, and spectra of the stretches of small and large amplitude."""
    low, high = LAMINAR_SHARE

    def alternation(noise):
        share = _trials(evidence, noise)["lasting_share"]
        return Measurement(
            also={"trials that alternate": estimates.share_of((share >= low) & (share <= high))}
        )

    return {f"sigma = {noise:g}": partial(alternation, noise) for noise in (1.0, 2.0)} | {
        "film, 0.35 m/s, sigma = 2.2": partial(_spectra_of_stretches, evidence, INTERMITTENT)
    }


def _spectra_of_stretches(evidence, film):
    recording = _recording(evidence, film)
    small, large = _stretches(recording)
    equal = np.array([_equally_spaced(recording, stretch) for stretch in small], dtype=bool)
    return Measurement(
        also={
            "share of small amplitude": estimates.single(recording.lasting_share),
            "stretches with peaks at equal distances": (
                estimates.share_of(equal) if equal.size else estimates.absent()
            ),
            "flatness, small": _flatness(recording, small),
            "flatness, large": _flatness(recording, large),
        },
        note=f"{len(small)} stretches of small amplitude",
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
    """Whether a stretch has peaks that are multiples of one frequency."""
    peaks_hz = lines(recording.evenly(*stretch), recording.interval_s).peaks_hz
    return peaks_hz.size >= LEAST_PEAKS and spacing(peaks_hz).p < RANDOM


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


@claim("experiment-022")
def experiment_022(evidence):
    """How often all blocks slip for a minute, and the spectrum of the whole."""
    shortest = evidence.claim.parameters["longer_than_s"]

    def long_slip(noise):
        longest_s = _trials(evidence, noise)["all_slip_longest"] * TIME_S
        minute = estimates.share_of(longest_s > shortest)
        longest = estimates.sure(longest_s.max())
        return Measurement(
            also={"trials with a minute of slip of all blocks": minute, "longest slip (s)": longest}
        )

    return {f"sigma = {noise:g}": partial(long_slip, noise) for noise in (1.0, 2.0)} | {
        "films, sigma = 1": partial(_factor_between_spectra, evidence)
    }


def _factor_between_spectra(evidence):
    """Between the spectrum of a film at 0.22 m/s and that of the large amplitudes at 0.28 m/s."""
    one, other = (_recording(evidence, film) for film in (AT_022, AT_028))
    frequency, whole = _pieces(one, [one.time_s[[0, -1]]])
    _, large = _pieces(other, _stretches(other)[1])
    size = round(BAND_HZ / (frequency[1] - frequency[0]))

    def factor(*powers):
        # Two noisy spectra of one law would differ at single frequencies.
        smooth = [scipy.ndimage.uniform_filter1d(power.mean(axis=0), size) for power in powers]
        return spectral_ratio(*(stand_out(frequency, power) for power in smooth))

    return Measurement(
        also={"factor between the spectra": estimates.bootstrap(factor, [whole, large])}
    )


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
    names = ("lasting_share", "all_slip_longest")
    return {name: arrays[name][chosen] for name in names}


def _recording(evidence, name):
    track = evidence.track(name)
    recording = analyse(track.time_s, track.x_m)
    seconds = recording.observed_s
    require(
        seconds >= SHORTEST_S, f"the film {name} has {seconds:.0f} s, {SHORTEST_S:g} are needed"
    )
    return recording
