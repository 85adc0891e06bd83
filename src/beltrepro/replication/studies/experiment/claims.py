"""Claims on the experiment (Secs. II and IV.B), measured in trials and in films of the model."""

import numpy as np

from beltrepro.base.errors import require
from beltrepro.model.units import TIME_S
from beltrepro.replication.studies.experiment import measure
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.replication.verdicts.motions import N_BLOCKS, between
from beltrepro.stats import estimates, sections
from beltrepro.stats.estimates import mean, share_of
from beltrepro.stats.states import LAMINAR_SHARE

RUNS = "n5_replicates"
SHORTEST_S = 900.0  # of a trial: the paper's are some hundred seconds long
STRETCHES = 20
AT_NOISES = {f"sigma = {noise:g}": noise for noise in measure.ASSIGNED}


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
    interval = np.median(np.diff(track.time_s))
    return sum(round((end - begin) / interval) + 1 for begin, end in track.lost_s)


# --- what the model shows beside the recordings: Figs. 4 and 5 ------------------------------------


@claim("experiment-028", AT_NOISES)
def experiment_028(evidence, noise):
    """How often trials of the model alternate between small and large amplitude."""
    low, high = LAMINAR_SHARE
    lasting = _trials_of_claim(evidence, noise)["lasting_share"]
    alternating = share_of((lasting >= low) & (lasting <= high))
    return Measurement(also={"trials that alternate": alternating})


@claim("experiment-022", AT_NOISES)
def experiment_022(evidence, noise):
    """How often all blocks of the model slip for a minute."""
    longest_s = _trials_of_claim(evidence, noise)["all_slip_longest"] * TIME_S
    minute = share_of(longest_s > evidence.claim.parameters["longer_than_s"])
    longest = estimates.sure(longest_s.max())
    return Measurement(
        also={"trials with a minute of slip of all blocks": minute, "longest slip (s)": longest}
    )


def _trials_of_claim(evidence, noise):
    """The trials at the speed of the claim and a noise, if they are long enough."""
    about = evidence.dataset("trials").attributes
    seconds = TIME_S * float(about["duration"] - about["transient"])
    require(seconds >= SHORTEST_S, f"trials of {seconds:.0f} s, {SHORTEST_S:g} s are needed")
    return _trials(evidence, evidence.claim.parameters["belt_velocity_m_s"], (noise, noise))


def _trials(evidence, speed_m_s, noises):
    """The trials at a speed, and at a noise between two ends."""
    trials = evidence.dataset("trials").arrays
    chosen = measure.at_speed(speed_m_s, trials) & between(trials["noise"], *noises)
    words = " to ".join(f"{noise:g}" for noise in sorted(set(noises)))
    require(chosen.any(), f"no trials at {speed_m_s:g} m/s, sigma = {words}")
    return sections.select(trials, chosen)


# --- the noise that corresponds to the experiment -------------------------------------------------

NEAR = 0.5  # of u; runs this close to a speed of the experiment stand for it
INTERMITTENT = 2.2  # noise of Fig. 16
NEAR_IT = (2.0, 2.8)  # noises of trials
READINGS = {f"sigma = {noise:g}": (noise, RUNS) for noise in (INTERMITTENT, 1.0, 0.0)}
READINGS |= {"sigma = 0, the paper's scheme": (0.0, "n5_replicates_check")}


@claim("r-experiment", READINGS)
def r_experiment(evidence, noise_and_scan):
    """Model r at the belt speeds of the experiment, at several noises."""
    noise, scan = noise_and_scan
    row = evidence.row(scan, N_BLOCKS, noise)
    of_model, ratios = {}, {}
    for name, recorded in zip(("r at 0.22 m/s", "r at 0.28 m/s"), measure.EXPERIMENT, strict=True):
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
    row = evidence.row(RUNS, N_BLOCKS, INTERMITTENT)
    critical = row.fall["critical"]
    ratios, also = {}, {"critical velocity": critical}
    for recorded in measure.EXPERIMENT:
        speed = f"{recorded.speed_m_s:g} m/s"
        ratios[f"critical speed over {speed}"] = critical.scaled(1 / recorded.belt_velocity)
        laminar = row.points["laminar_fraction"][_near(row, recorded)]
        also[f"laminar share, {speed}"] = mean(laminar)
        trials = _trials(evidence, recorded.speed_m_s, NEAR_IT)
        also[f"trials that alternate, {speed}"] = share_of(measure.alternates(trials))
    return Measurement(ratios, also)


@claim("sigma-experiment", "printed constants")
def sigma_experiment(evidence):
    """How trials at the noise that the paper assigns agree with its recordings."""
    also = {}
    for recorded in measure.EXPERIMENT:
        trials = _trials(evidence, recorded.speed_m_s, measure.ASSIGNED)
        agreeing = share_of(measure.agrees(recorded, trials))
        also[f"trials that agree, {recorded.speed_m_s:g} m/s"] = agreeing
    return Measurement(also=also)
