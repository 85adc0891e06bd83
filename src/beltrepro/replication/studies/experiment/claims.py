"""Claims on the experiment (Secs. II and IV.B), measured in trials and in films of the model."""

from functools import partial

import numpy as np

from beltrepro.base.errors import require
from beltrepro.model.units import LENGTH_M, TIME_S, from_si
from beltrepro.replication.studies.experiment import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates, sections
from beltrepro.stats.estimates import mean, share_of
from beltrepro.stats.intermittency import LAMINAR_SHARE

N_BLOCKS, RUNS = 5, "n5_replicates"
FILMS = measure.BELTS
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
        largest.append(measure.tracking_error(track.time_s, track.x_m, true, interval).largest)
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
        error = measure.tracking_error(time, place, true, interval)
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


def _at_noises(reading):
    return {f"sigma = {noise:g}": partial(reading, noise) for noise in measure.ASSIGNED}


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


# --- the noise that corresponds to the experiment -------------------------------------------------

NEAR = 0.5  # of u; runs this close to a speed of the experiment stand for it
SPEEDS = {"022": measure.EXPERIMENT[0], "028": measure.EXPERIMENT[1]}
INTERMITTENT = 2.2  # noise of Fig. 16
NEAR_IT = (2.0, 2.8)  # noises of trials


def _speed(observation):
    return f"{observation.speed_m_s:g} m/s"


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
    for name, observation in SPEEDS.items():
        points = sections.select(row.points, _near(row, observation))
        of_model[f"r_{name}"] = mean(points["disorder_parameter"])
        ratio = mean(measure.disorder_along_tape(points))
        ratios[f"r_{name} over the experiment's"] = ratio.scaled(1 / observation.disorder_parameter)
    return Measurement(of_model | ratios)


def _near(row, observation):
    near = np.abs(row.belt_velocity - observation.belt_velocity) <= NEAR
    require(bool(near.any()), f"no runs within {NEAR:g} of u = {observation.belt_velocity:.1f}")
    return row.evenly(near)


@claim("intermittency-experiment")
def intermittency_experiment(evidence):
    """The critical speed over those of the experiment, and how the model alternates there."""
    row = evidence.replicates(N_BLOCKS, INTERMITTENT, scan=RUNS)
    trials = evidence.dataset("trials").arrays
    alternating, (low, high) = measure.alternates(trials), NEAR_IT
    level = (trials["noise"] >= low - 1e-9) & (trials["noise"] <= high + 1e-9)
    ratios, also = {}, {"critical velocity": row.fall["critical"]}
    for observation in measure.EXPERIMENT:
        speed, velocity = _speed(observation), observation.belt_velocity
        ratios[f"critical speed over {speed}"] = row.fall["critical"].scaled(1 / velocity)
        at_speed = level & measure.at_speed(observation, trials)
        also[f"laminar share, {speed}"] = mean(
            row.points["laminar_fraction"][_near(row, observation)]
        )
        also[f"trials that alternate, {speed}"] = _share_of(alternating, at_speed)
    return Measurement(ratios, also)


def _share_of(having, among):
    require(bool(among.any()), "no trials at this noise")
    return share_of(having[among])


@claim("sigma-experiment")
def sigma_experiment(evidence):
    """How trials at the noise that the paper assigns agree with its recordings."""
    return {"printed constants": partial(_trials_that_agree, evidence)}


def _trials_that_agree(evidence):
    trials = evidence.dataset("trials").arrays
    assigned = measure.assigned(trials["noise"])
    return Measurement(
        also={
            f"trials that agree, {_speed(observation)}": _share_of(
                measure.agrees(observation, trials),
                assigned & measure.at_speed(observation, trials),
            )
            for observation in measure.EXPERIMENT
        }
    )
