"""Made-up trials of the experiment: which of them agree with its recordings is known."""

import numpy as np

from beltrepro.base.store import Dataset
from beltrepro.model.units import from_si
from beltrepro.replication.studies.experiment import measure
from beltrepro.replication.studies.experiment.measure import EXPERIMENT

HOW = {
    "preset": "smoke",
    "kind": "trial",
    "method": "event",
    "time_step": 0.001,
    "duration": 15691.0,
    "transient": 2615.0,
    "seed": 1,
    "code_version": "0.0+gabc",
}
SPEEDS = np.array([recording.belt_velocity for recording in EXPERIMENT])
NOISES = (0.5, 1.0, 2.0, 4.0)
RATIOS = (0.45, 0.6)
FITTING = 0.6  # friction ratio at which trials agree with both recordings, at their speeds
AGREEING = dict(zip(NOISES, (0, 0.5, 1, 0.25), strict=True))  # share of the trials in a cell
RUNS = 4
LENGTH = 600.0  # <x_5> of all trials, and r of the model over that along a tape, by blocks of 4 cm
OF_MODEL = 1 + from_si(4.5 * 0.04, "length") / LENGTH


def made_up(noises=NOISES, ratios=RATIOS, velocities=None, runs=RUNS, duration=15691.0):
    """Trials at every noise, friction ratio and belt velocity, in shuffled order.

    A share AGREEING[noise] of the trials at FITTING have r of the recording, by a tape beside the
    chain, and both regimes.
    """
    if velocities is None:
        velocities = SPEEDS[0] * (14 / 11) ** np.arange(-1.0, 3.0)
    rows = [(s, f, u, k) for s in noises for f in ratios for u in velocities for k in range(runs)]
    rows = np.random.default_rng(5).permutation(np.array(rows, dtype=float).reshape(-1, 4))
    noise, ratio, velocity, number = rows.T
    agreeing = (ratio == FITTING) & (number < runs * np.array([AGREEING.get(s, 0) for s in noise]))
    first, second = (np.isclose(velocity, speed, rtol=1e-3) for speed in SPEEDS)
    agreeing &= first | second
    printed = np.where(first, EXPERIMENT[0].disorder_parameter, EXPERIMENT[1].disorder_parameter)
    arrays = {
        "n_blocks": np.full(noise.size, 5),
        "noise": noise,
        "friction_ratio": ratio,
        "belt_velocity": velocity,
        "replicate": number.astype(int),
        "time_step": np.full(noise.size, 0.001),
        "seed": np.ones(noise.size, dtype=int),
        "mean_length": np.full(noise.size, LENGTH),
        "disorder_parameter": OF_MODEL * np.where(agreeing, printed, 0.13 + 1e-3 * number),
        "lasting_share": np.where(agreeing, 0.25, 0.0),
        "lasting_longest": np.where(agreeing, 900.0, 0.0),
        "lively_longest": np.full(noise.size, 3000.0),
        "all_slip_longest": np.full(noise.size, 8.0),
    }
    return Dataset(arrays, HOW | {"duration": duration})


def studies(**changes):
    """The datasets and tables of the study, by name."""
    printed = changes | {"ratios": changes.get("ratios", (0.45,)), "velocities": SPEEDS}
    made = {
        "trials": made_up(**printed),
        "trials_short": made_up(**printed, duration=6538.0),
        "trials_free": made_up(**changes),
    }
    made["experiment_odds"] = measure.experiment_odds(made)
    made["alternation"] = measure.alternation(made)
    return made


def experiments(best, *, runs):
    """`trials` with the printed constants: all agree at the noises `best`."""
    noises = np.array([0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0])
    points = np.array([(s, u) for s in noises for u in SPEEDS for _ in range(runs)])
    noise, velocity = points.T
    first, second = (one.disorder_parameter for one in EXPERIMENT)
    agreeing = np.isin(noise, best)
    printed = np.where(velocity == SPEEDS[0], first, second)
    arrays = {
        "noise": noise,
        "belt_velocity": velocity,
        "friction_ratio": np.full(noise.size, 0.45),
        "mean_length": np.full(noise.size, LENGTH),
        "disorder_parameter": OF_MODEL * np.where(agreeing, printed, 0.135),
        "lasting_longest": np.where(agreeing, 1000.0, 0.0),
        "lasting_share": np.where(agreeing, 0.2, 0.0),
        "slip_longest": np.where(agreeing, 1000.0, 8.0),
        "all_slip_longest": np.full(noise.size, 8.0),
        "lively_longest": np.full(noise.size, 3000.0),
    }
    return {"trials": Dataset(arrays, HOW)}
