"""Made-up trials of the experiment: which of them agree with its recordings is known."""

import numpy as np

from beltrepro.base.store import Dataset
from beltrepro.model.units import from_si
from beltrepro.replication.studies.experiment import measure
from beltrepro.replication.studies.experiment.measure import EXPERIMENT
from irregular import HOW, grid

SPEEDS = np.array([recording.belt_velocity for recording in EXPERIMENT])
NOISES = (0.5, 1.0, 2.0, 4.0)
FITTING = 0.6  # friction ratio at which trials agree with both recordings, at their speeds
AGREEING = dict(zip(NOISES, (0, 0.5, 1, 0.25), strict=True))  # share of the trials in a cell
LENGTH = 600.0  # <x_5> of all trials, and r of the model over that along a tape, by blocks of 4 cm
OF_MODEL = 1 + from_si(4.5 * 0.04, "length") / LENGTH


def trials(share, *, noise=NOISES, ratio=(0.45,), velocity=SPEEDS, runs, duration=15691.0):
    """Trials at every noise, friction ratio and belt velocity, in shuffled order.

    A share of the trials at a noise and a ratio, at the printed speeds, has r of the recording, by
    a tape beside the chain, and both regimes.
    """
    axes = {"noise": noise, "friction_ratio": ratio, "belt_velocity": velocity}
    columns = grid(**axes, replicate=np.arange(runs))
    order = np.random.default_rng(5).permutation(columns["noise"].size)
    arrays = {name: values[order] for name, values in columns.items()}
    cells = zip(arrays["noise"], arrays["friction_ratio"], strict=True)
    agreeing = arrays["replicate"] < runs * np.array([share(*cell) for cell in cells])
    first, second = (np.isclose(arrays["belt_velocity"], u, rtol=1e-3) for u in SPEEDS)
    agreeing &= first | second
    printed = np.where(first, EXPERIMENT[0].disorder_parameter, EXPERIMENT[1].disorder_parameter)
    besides = 0.13 + 1e-3 * arrays["replicate"]
    lasting = np.where(agreeing, 900.0, 0.0)
    arrays |= {
        "n_blocks": np.full(order.size, 5),
        "mean_length": np.full(order.size, LENGTH),
        "disorder_parameter": OF_MODEL * np.where(agreeing, printed, besides),
        "lasting_share": np.where(agreeing, 0.25, 0.0),
        "lasting_longest": lasting,
        "slip_longest": np.maximum(lasting, 8.0),
        "lively_longest": np.full(order.size, 3000.0),
        "all_slip_longest": np.full(order.size, 8.0),
    }
    return Dataset(arrays, HOW | {"kind": "trial", "duration": duration, "transient": 2615.0})


def studies(*, runs):
    """The datasets and tables of the study, by name."""

    def share(noise, ratio):
        return AGREEING[noise] if ratio == FITTING else 0

    velocities = SPEEDS[0] * (14 / 11) ** np.arange(-1.0, 3.0)
    made = {
        "trials": trials(share, runs=runs),
        "trials_short": trials(share, runs=runs, duration=6538.0),
        "trials_free": trials(share, runs=runs, ratio=(0.45, FITTING), velocity=velocities),
    }
    made["experiment_odds"] = measure.experiment_odds(made)
    made["alternation"] = measure.alternation(made)
    return made


def experiments(best, *, runs):
    """`trials` with the printed constants: all agree at the noises `best`."""
    noises = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
    return {"trials": trials(lambda noise, ratio: noise in best, noise=noises, runs=runs)}
