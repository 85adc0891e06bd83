"""Claims on the noise that corresponds to the experiment (Sec. IV.B)."""

from functools import partial

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.studies.experiment import observations
from beltrepro.replication.studies.noise.claims import N_BLOCKS, RUNS
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import sections
from beltrepro.stats.estimates import mean, share_of

NEAR = 0.5  # of u; runs this close to a speed of the experiment stand for it
SPEEDS = {"022": observations.EXPERIMENT[0], "028": observations.EXPERIMENT[1]}
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
        ratio = mean(observations.disorder_along_tape(points))
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
    alternating, (low, high) = observations.alternates(trials), NEAR_IT
    level = (trials["noise"] >= low - 1e-9) & (trials["noise"] <= high + 1e-9)
    ratios, also = {}, {"critical velocity": row.fall["critical"]}
    for observation in observations.EXPERIMENT:
        speed, velocity = _speed(observation), observation.belt_velocity
        ratios[f"critical speed over {speed}"] = row.fall["critical"].scaled(1 / velocity)
        at_speed = level & observations.at_speed(observation, trials)
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
    assigned = observations.assigned(trials["noise"])
    return Measurement(
        also={
            f"trials that agree, {_speed(observation)}": _share_of(
                observations.agrees(observation, trials),
                assigned & observations.at_speed(observation, trials),
            )
            for observation in observations.EXPERIMENT
        }
    )
