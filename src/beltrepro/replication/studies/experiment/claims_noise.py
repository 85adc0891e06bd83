"""Claims on the noise that corresponds to the experiment (Sec. IV.B)."""

from functools import partial

import numpy as np

from beltrepro.base.errors import require
from beltrepro.replication.studies.experiment import films, measure, observations
from beltrepro.replication.studies.noise.claims import N_BLOCKS, RUNS
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats.estimates import Estimate, mean, share, sure

NEAR = 0.5  # of u; runs this close to a speed of the experiment stand for it
FILMED_S = 900.0  # of a film, at least
MINIMUM_TRIALS = 80  # of none that agree, 5 % are excluded from 72 on
SPEEDS = {"022": observations.EXPERIMENT[0], "028": observations.EXPERIMENT[1]}
COUNTED = 1.0  # the noise of which r counts


def _speed(observation):
    return f"{observation.speed_m_s:g} m/s"


# --- r --------------------------------------------------------------------------------------------


@claim("r-experiment")
def r_experiment(evidence):
    """Model r at the belt speeds of the experiment, for every noise level and in films."""
    levels = [float(level) for level in evidence.values(RUNS, "noise")]
    counted = [COUNTED, *(level for level in levels if level != COUNTED)]
    return {
        f"sigma = {level:g}": partial(_r_at_speeds, evidence, level, RUNS) for level in counted
    } | {
        "sigma = 0, the paper's scheme": partial(
            _r_at_speeds, evidence, 0.0, "n5_replicates_check"
        ),
        "films, sigma = 1": partial(_r_in_films, evidence),
    }


def _r_at_speeds(evidence, noise, scan):
    row = evidence.replicates(N_BLOCKS, noise, scan=scan)
    return _beside_experiment(
        {name: mean(row.disorder[_near(row, speed)]) for name, speed in SPEEDS.items()}
    )


def _near(row, observation):
    near = np.abs(row.belt_velocity - observation.belt_velocity) <= NEAR
    require(bool(near.any()), f"no runs within {NEAR:g} of u = {observation.belt_velocity:.1f}")
    return row.evenly(near)


def _r_in_films(evidence):
    """R of x_5 as tracked in films; intervals from the stretches of each film."""
    return _beside_experiment({name: _r_in_film(evidence, f"belt_{name}") for name in SPEEDS})


def _r_in_film(evidence, film):
    track = evidence.track(film)
    seconds = track.time_s[-1] - track.time_s[0]
    require(seconds >= FILMED_S, f"the film {film} has {seconds:.0f} s, {FILMED_S:g} are needed")
    return films.disorder_of(track)


def _beside_experiment(by_speed):
    return Measurement(
        {f"r_{name}": estimate for name, estimate in by_speed.items()}
        | {
            f"r_{name} over the experiment's": estimate.scaled(1 / SPEEDS[name].disorder_parameter)
            for name, estimate in by_speed.items()
        }
    )


# --- intermittency --------------------------------------------------------------------------------


@claim("intermittency-experiment")
def intermittency_experiment(evidence):
    """Laminar phases at the belt speeds of the experiment, in long runs and in trials."""
    return {
        "sigma = 1, trials 1 to 2": partial(_at_speeds, evidence, COUNTED, observations.ASSIGNED),
        "sigma = 2.2, trials 2 to 2.8": partial(_at_speeds, evidence, 2.2, (2.0, 2.8)),
    }


def _at_speeds(evidence, of_runs, of_trials):
    row = evidence.replicates(N_BLOCKS, of_runs, scan=RUNS)
    trials = evidence.dataset("trials").arrays
    alternating, (low, high) = observations.alternates(trials), of_trials
    level = (trials["noise"] >= low - 1e-9) & (trials["noise"] <= high + 1e-9)
    laminar, also, trialled = {}, {}, {}
    for observation in observations.EXPERIMENT:
        near, speed = _near(row, observation), _speed(observation)
        laminar[f"laminar share, {speed}"] = mean(row.points["laminar_fraction"][near])
        top = float(row.points["laminar_longest"][near].max())
        with_phases = _share_of(row.points["laminar_count"] > 0, near)
        also[f"runs with laminar phases, {speed}"] = with_phases
        also[f"longest laminar phase, {speed}"] = Estimate(top, top, top, int(near.sum()))
        at_speed = level & observations.at_speed(observation, trials)
        trialled[f"trials that alternate, {speed}"] = _share_of(alternating, at_speed)
    return Measurement(laminar | trialled, also)


def _share_of(having, among):
    runs = int(np.count_nonzero(among))
    require(runs > 0, "no trials or runs at this noise")
    return share(int(np.count_nonzero(having & among)), runs)


# --- sigma ----------------------------------------------------------------------------------------


@claim("sigma-experiment")
def sigma_experiment(evidence):
    """Noise at which trials of the experiment's length agree with both of its recordings."""
    return {
        f"r within {tolerance:.0%}": partial(_noise_of_experiment, evidence, tolerance)
        for tolerance in measure.TOLERANCES
    }


def _noise_of_experiment(evidence, tolerance):
    trials = evidence.dataset("trials").arrays
    assigned = observations.assigned(trials["noise"])
    agreeing = {}
    for observation in observations.EXPERIMENT:
        chosen = assigned & observations.at_speed(observation, trials)
        require(
            chosen.sum() >= MINIMUM_TRIALS, f"{chosen.sum()} trials, {MINIMUM_TRIALS} are needed"
        )
        agreeing[f"trials that agree, {_speed(observation)}"] = _share_of(
            observations.agrees(observation, trials, tolerance), chosen
        )
    simulated = observations.on_grid(evidence.dataset("trials_free").arrays)
    answer = measure.posterior(simulated, tolerance)
    levels = answer.levels["noise"]
    credible = levels[answer.credible("noise")]
    posterior = measure.posterior_of_assigned(simulated, answer, tolerance)
    return Measurement(
        agreeing | {"posterior of 1 to 2": posterior},
        {
            "least noise of the 90 % set": sure(credible.min()),
            "largest noise of the 90 % set": sure(credible.max()),
        },
        note=f"before the trials 1 to 2 had {measure.assigned_share_before(levels):.2g}",
    )
