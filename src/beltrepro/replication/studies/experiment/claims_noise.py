"""Claims on the noise that corresponds to the experiment (Sec. IV.B)."""

from functools import partial

import numpy as np

from beltrepro.replication.camera import recording
from beltrepro.replication.studies.experiment import inference, trials
from beltrepro.replication.studies.experiment.inference import Simulated
from beltrepro.replication.studies.noise.claims import N_BLOCKS, RUNS
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.registry import claim
from beltrepro.stats import estimates
from beltrepro.stats.errors import NotEnoughDataError, require
from beltrepro.stats.estimates import Estimate, bootstrap, from_resamples, mean, share, sure

NEAR = 0.5  # of u; runs this close to a speed of the experiment stand for it
FILMED_S = 900.0  # of a film, at least
PARTS = 10  # stretches of a film that count as independent
MINIMUM_TRIALS = 80  # of none that agree, 5 % are excluded from 72 on
SPEEDS = {"022": trials.EXPERIMENT[0], "028": trials.EXPERIMENT[1]}
ASSIGNED = 1.0  # noise that counts


def _speed(observation):
    return f"{observation.speed_m_s:g} m/s"


# --- r --------------------------------------------------------------------------------------------


@claim("r-experiment")
def r_experiment(evidence):
    """Model r at the belt speeds of the experiment, for every noise level and in films."""
    levels = [float(level) for level in evidence.values(RUNS, "noise")]
    counted = [ASSIGNED, *(level for level in levels if level != ASSIGNED)]
    readings = {
        f"sigma = {level:g}": partial(_r_at_speeds, evidence, level, RUNS) for level in counted
    }
    scheme = {"sigma = 0, the paper's scheme": "n5_replicates_check"}
    return (
        readings
        | {name: partial(_r_at_speeds, evidence, 0.0, scan) for name, scan in scheme.items()}
        | {"films, sigma = 1": partial(_r_in_films, evidence)}
    )


def _r_at_speeds(evidence, noise, scan):
    row = evidence.replicates(N_BLOCKS, noise, scan=scan)
    return _beside_experiment(
        {name: mean(row.disorder[_near(row, each)]) for name, each in SPEEDS.items()}
    )


def _near(row, observation):
    near = np.abs(row.belt_velocity - observation.belt_velocity) <= NEAR
    require(bool(near.any()), f"no runs within {NEAR:g} of u = {observation.belt_velocity:.1f}")
    return near


def _r_in_films(evidence):
    """R of x_5 as tracked in films; intervals from the stretches of each film."""
    return _beside_experiment({name: _r_in_film(evidence, f"belt_{name}") for name in SPEEDS})


def _r_in_film(evidence, film):
    track = evidence.track(film)
    seconds = track.time_s[-1] - track.time_s[0]
    require(seconds >= FILMED_S, f"the film {film} has {seconds:.0f} s, {FILMED_S:g} are needed")
    whole = recording.analyse(track.time_s, track.x_m)
    parts = np.array_split(whole.evenly(track.time_s[0], track.time_s[-1]), PARTS)
    return bootstrap(_disorder, [np.array([(part.mean(), np.mean(part**2)) for part in parts])])


def _disorder(moments):
    first, second = moments.mean(axis=0)
    return float(np.sqrt(second - first**2) / first)


def _beside_experiment(found):
    return Measurement(
        {f"r_{name}": each for name, each in found.items()}
        | {
            f"r_{name} over the experiment's": each.scaled(1 / SPEEDS[name].disorder_parameter)
            for name, each in found.items()
        }
    )


# --- intermittency --------------------------------------------------------------------------------


@claim("intermittency-experiment")
def intermittency_experiment(evidence):
    """Laminar phases at the belt speeds of the experiment, in long runs and in trials."""
    return {
        "sigma = 1, trials 1 to 2": partial(_at_speeds, evidence, ASSIGNED, trials.ASSIGNED),
        "sigma = 2.2, trials 2 to 2.8": partial(_at_speeds, evidence, 2.2, (2.0, 2.8)),
    }


def _at_speeds(evidence, of_runs, of_trials):
    row = evidence.replicates(N_BLOCKS, of_runs, scan=RUNS)
    arrays = evidence.dataset("trials").arrays
    alternating, (low, high) = trials.alternates(arrays), of_trials
    level = (arrays["noise"] >= low - 1e-9) & (arrays["noise"] <= high + 1e-9)
    shares, also, trialled = {}, {}, {}
    for each in trials.EXPERIMENT:
        near, speed = _near(row, each), _speed(each)
        shares[f"laminar share, {speed}"] = mean(row.points["laminar_fraction"][near])
        top = float(row.points["laminar_longest"][near].max())
        also[f"runs with laminar phases, {speed}"] = _share_of(
            row.points["laminar_count"] > 0, near
        )
        also[f"longest laminar phase, {speed}"] = Estimate(top, top, top, int(near.sum()))
        trialled[f"trials that alternate, {speed}"] = _share_of(
            alternating, level & trials.at_speed(each, arrays)
        )
    return Measurement(shares | trialled, also)


def _share_of(having, among):
    runs = int(np.count_nonzero(among))
    require(runs > 0, "no trials or runs at this noise")
    return share(int(np.count_nonzero(having & among)), runs)


# --- sigma ----------------------------------------------------------------------------------------


@claim("sigma-experiment")
def sigma_experiment(evidence):
    """Noise at which trials of the experiment's length agree with both of its recordings."""
    tolerances = (trials.TOLERANCE, trials.TOLERANCE / 2, 2 * trials.TOLERANCE)
    return {
        f"r within {tolerance:.0%}": partial(_noise_of_experiment, evidence, tolerance)
        for tolerance in tolerances
    }


def _noise_of_experiment(evidence, tolerance):
    printed = evidence.dataset("trials").arrays
    assigned = trials.assigned(printed["noise"])
    agreeing = {}
    for each in trials.EXPERIMENT:
        own = assigned & trials.at_speed(each, printed)
        require(own.sum() >= MINIMUM_TRIALS, f"{own.sum()} trials, {MINIMUM_TRIALS} are needed")
        agreeing[f"trials that agree, {_speed(each)}"] = _share_of(
            trials.agrees(each, printed, tolerance), own
        )
    simulated = trials.on_grid(evidence.dataset("trials_free").arrays)
    found = inference.posterior(simulated, trials.RECORDED, tolerance)
    trials.require_agreed(found)
    levels, chosen = found.levels["noise"], found.credible("noise")
    before = _between(levels, np.full(levels.size, 1 / levels.size), trials.ASSIGNED)
    return Measurement(
        agreeing | {"posterior of 1 to 2": _posterior(simulated, found, tolerance)},
        {
            "least noise of the 90 % set": sure(levels[chosen].min()),
            "largest noise of the 90 % set": sure(levels[chosen].max()),
        },
        note=f"before the trials 1 to 2 had {before:.2g}",
    )


def _posterior(simulated, found, tolerance):
    """Posterior of the noise that is assigned; the trials of each combination are drawn anew."""

    def assigned(posterior):
        levels = posterior.levels["noise"]
        return _between(levels, posterior.marginal("noise"), trials.ASSIGNED)

    rng = np.random.default_rng(0)
    resampled = []
    for _ in range(estimates.RESAMPLES):
        try:
            own = inference.posterior(_drawn_anew(simulated, rng), trials.RECORDED, tolerance)
            resampled.append(assigned(own))
        except NotEnoughDataError:
            resampled.append(np.nan)
    return from_resamples(assigned(found), np.array(resampled), min(found.agreed))


def _drawn_anew(simulated: Simulated, rng: np.random.Generator) -> Simulated:
    chosen = rng.integers(0, simulated.runs, simulated.summary.shape)
    summary, shown = (
        np.take_along_axis(values, chosen, axis=-1)
        for values in (simulated.summary, simulated.shown)
    )
    return Simulated(simulated.levels, summary, shown, simulated.smoothing)


def _between(levels, probability, ends):
    """Probability of a range of noise; a level stands for the noises half way, in ratio, around."""
    place = np.log(levels)
    middle = (place[1:] + place[:-1]) / 2
    edges = np.concatenate([[2 * place[0] - middle[0]], middle, [2 * place[-1] - middle[-1]]])
    below = np.interp(np.log(ends), edges, np.concatenate([[0.0], np.cumsum(probability)]))
    return float(below[1] - below[0])
