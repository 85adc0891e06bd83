"""Claims on the experiment (Secs. II and IV.B), measured in trials and in films of the model."""

from functools import partial

import numpy as np

from beltrepro.base.errors import require
from beltrepro.model.units import TIME_S, from_si
from beltrepro.replication.studies.experiment import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, sections
from beltrepro.stats.estimates import mean, share_of
from beltrepro.stats.states import LAMINAR_SHARE

N_BLOCKS, RUNS = 5, "n5_replicates"
SHORTEST_S = 900.0  # of a trial: the paper's are some hundred seconds long
STRETCHES = 20


# --- the measurement: Figs. 2 and 3 ---------------------------------------------------------------


@claim("snapshot")
def snapshot(evidence):
    """Share of the frames in which the last block is found, and whether it is that block."""
    shares, largest = [], []
    for name in measure.BELTS:
        track, true, interval = _filmed(evidence, name)
        n_seen = len(track.time_s)
        shares.append(estimates.share(n_seen, n_seen + _lost_frames(track)))
        largest.append(measure.tracking_error(track.time_s, track.x_m, true, interval).largest)
    return Measurement(
        {
            "share of the frames with the block": min(shares, key=lambda share: share.value),
            "largest error (m)": estimates.sure(max(largest)),
        },
        note=f"of {len(measure.BELTS)} films, the one with the least; the runs are its frames",
    )


@claim("threshold")
def threshold(evidence):
    """Errors of x_5, of the scale and of r, of the film in which each is largest."""
    by_film = [_errors(evidence, name) for name in measure.BELTS]
    worst = {
        name: max((errors[name] for errors in by_film), key=lambda error: abs(error.value))
        for name in by_film[0]
    }
    return Measurement(worst, note=f"{STRETCHES} stretches of each film")


def _errors(evidence, name):
    """Errors in stretches of a film."""
    track, true, interval = _filmed(evidence, name)
    rows = []
    for part in np.array_split(np.arange(len(track.time_s)), STRETCHES):
        time, place = track.time_s[part], track.x_m[part]
        error = measure.tracking_error(time, place, true, interval)
        seen = true[np.rint(time / interval).astype(int)]
        rows.append(
            {
                "scatter of x_5 (pixels)": error.scatter / track.metres_per_pixel,
                "offset of x_5 (pixels)": error.offset / track.metres_per_pixel,
                "error of the scale": error.scale,
                "error of r": _disorder(place) / _disorder(seen) - 1,
            }
        )
    return {name: mean([row[name] for row in rows]) for name in rows[0]}


def _filmed(evidence, name):
    """Track of a film, the positions that were filmed, and the time between them, in SI."""
    true, interval = measure.filmed(evidence.dataset(name))
    return evidence.dataset(f"{name}_track"), true, interval


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
        lasting = _trials(evidence, noise, "lasting_share")
        alternating = share_of((lasting >= low) & (lasting <= high))
        return Measurement(also={"trials that alternate": alternating})

    return _at_noises(alternation)


@claim("experiment-022")
def experiment_022(evidence):
    """How often all blocks of the model slip for a minute."""

    def long_slip(noise):
        longest_s = _trials(evidence, noise, "all_slip_longest") * TIME_S
        minute = share_of(longest_s > evidence.claim.parameters["longer_than_s"])
        longest = estimates.sure(longest_s.max())
        return Measurement(
            also={"trials with a minute of slip of all blocks": minute, "longest slip (s)": longest}
        )

    return _at_noises(long_slip)


def _at_noises(reading):
    return {f"sigma = {noise:g}": partial(reading, noise) for noise in measure.ASSIGNED}


def _trials(evidence, noise, quantity):
    """A quantity of the trials at the speed of the claim and a noise."""
    trials = evidence.dataset("trials")
    seconds = TIME_S * float(trials.attributes["duration"] - trials.attributes["transient"])
    require(seconds >= SHORTEST_S, f"trials of {seconds:.0f} s, {SHORTEST_S:g} s are needed")
    speed = from_si(evidence.claim.parameters["belt_velocity_m_s"], "velocity")
    chosen = np.isclose(trials.arrays["belt_velocity"], speed, rtol=measure.ALIKE)
    chosen &= np.isclose(trials.arrays["noise"], noise)
    require(chosen.any(), f"no trials at u = {speed:.4g}, sigma = {noise:g}")
    return trials.arrays[quantity][chosen]


# --- the noise that corresponds to the experiment -------------------------------------------------

NEAR = 0.5  # of u; runs this close to a speed of the experiment stand for it
INTERMITTENT = 2.2  # noise of Fig. 16
NEAR_IT = (2.0, 2.8)  # noises of trials
BY_SPEED = {f"{recorded.speed_m_s:g} m/s": recorded for recorded in measure.EXPERIMENT}


@claim("r-experiment")
def r_experiment(evidence):
    """Model r at the belt speeds of the experiment, at several noises."""
    noises = (INTERMITTENT, 1.0, 0.0)
    return {
        f"sigma = {noise:g}": partial(_r_at_speeds, evidence, noise, RUNS) for noise in noises
    } | {
        "sigma = 0, the paper's scheme": partial(_r_at_speeds, evidence, 0.0, "n5_replicates_check")
    }


def _r_at_speeds(evidence, noise, scan):
    row = evidence.replicates(N_BLOCKS, noise, scan=scan)
    of_model, ratios = {}, {}
    for name, recorded in zip(("r_022", "r_028"), measure.EXPERIMENT, strict=True):
        points = sections.select(row.points, _near(row, recorded))
        of_model[name] = mean(points["disorder_parameter"])
        along_tape = mean(measure.disorder_along_tape(points))
        ratios[f"{name} over the experiment's"] = along_tape.scaled(1 / recorded.disorder_parameter)
    return Measurement(of_model | ratios)


def _near(row, recorded):
    near = np.abs(row.belt_velocity - recorded.belt_velocity) <= NEAR
    require(near.any(), f"no runs within {NEAR:g} of u = {recorded.belt_velocity:.1f}")
    return row.evenly(near)


@claim("intermittency-experiment")
def intermittency_experiment(evidence):
    """The critical speed over those of the experiment, and how the model alternates there."""
    row = evidence.replicates(N_BLOCKS, INTERMITTENT, scan=RUNS)
    trials = evidence.dataset("trials").arrays
    alternating, critical = measure.alternates(trials), row.fall["critical"]
    ratios, also = {}, {"critical velocity": critical}
    for speed, recorded in BY_SPEED.items():
        ratios[f"critical speed over {speed}"] = critical.scaled(1 / recorded.belt_velocity)
        laminar = row.points["laminar_fraction"][_near(row, recorded)]
        also[f"laminar share, {speed}"] = mean(laminar)
        also[f"trials that alternate, {speed}"] = share_of(
            alternating[_with_noise(trials, NEAR_IT, recorded)]
        )
    return Measurement(ratios, also)


@claim("sigma-experiment")
def sigma_experiment(evidence):
    """How trials at the noise that the paper assigns agree with its recordings."""
    return {"printed constants": partial(_trials_that_agree, evidence)}


def _trials_that_agree(evidence):
    trials = evidence.dataset("trials").arrays
    return Measurement(
        also={
            f"trials that agree, {speed}": share_of(
                measure.agrees(recorded, trials)[_with_noise(trials, measure.ASSIGNED, recorded)]
            )
            for speed, recorded in BY_SPEED.items()
        }
    )


def _with_noise(trials, ends, recorded):
    """Which trials have the speed of a recording and a noise between two ends."""
    low, high = ends
    chosen = (trials["noise"] >= low - 1e-9) & (trials["noise"] <= high + 1e-9)
    chosen &= measure.at_speed(recorded, trials)
    require(chosen.any(), "no trials at this noise")
    return chosen
