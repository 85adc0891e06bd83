"""Claims on the experiment (Sec. II), measured in trials and in films of the model."""

from functools import partial

import numpy as np

from beltrepro.base.errors import require
from beltrepro.model.units import LENGTH_M, TIME_S, from_si
from beltrepro.replication.studies.experiment import films
from beltrepro.replication.studies.experiment.observations import ASSIGNED
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates
from beltrepro.stats.intermittency import LAMINAR_SHARE

FILMS = films.BELTS
SHORTEST_S = 900.0  # of a trial: the paper's are some hundred seconds long
STRETCHES = 20


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
    """How often trials of the model alternate between small and large amplitude."""
    low, high = LAMINAR_SHARE

    def alternation(noise):
        share = _trials(evidence, noise)["lasting_share"]
        return Measurement(
            also={"trials that alternate": estimates.share_of((share >= low) & (share <= high))}
        )

    return _at_noises(alternation)


@claim("experiment-022")
def experiment_022(evidence):
    """How often all blocks of the model slip for a minute."""
    shortest = evidence.claim.parameters["longer_than_s"]

    def long_slip(noise):
        longest_s = _trials(evidence, noise)["all_slip_longest"] * TIME_S
        minute = estimates.share_of(longest_s > shortest)
        longest = estimates.sure(longest_s.max())
        return Measurement(
            also={"trials with a minute of slip of all blocks": minute, "longest slip (s)": longest}
        )

    return _at_noises(long_slip)


def _at_noises(measure):
    return {f"sigma = {noise:g}": partial(measure, noise) for noise in ASSIGNED}


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
    return {name: arrays[name][chosen] for name in ("lasting_share", "all_slip_longest")}
