"""What trials show where viscous friction acts beside the dry one; half an hour.

    python -m beltrepro.replication.studies.experiment.runs

A combination that the file has already is not made again, so a run that was stopped goes on.
"""

from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np

from beltrepro import ChainParameters
from beltrepro.replication.camera.trials import trials
from beltrepro.replication.studies import published
from beltrepro.replication.studies.experiment import observations

FILE = Path(__file__).with_name("viscous_trials.csv")
LEVELS = {
    "noise": (2.0, 3.0, 4.0, 5.0, 6.0, 8.0),
    "friction_ratio": (0.25, 0.3, 0.35, 0.4, 0.45),
    "viscosity": (0.0, 0.1, 0.14, 0.16, 0.18, 0.2, 0.22, 0.26),
}
RUNS = 30  # of each recording in a combination
LENGTH = {"duration": 15691.0, "transient": 2615.0, "sample_interval": 0.54484}  # as `trials`


def viscous_trials(**constants: float) -> Iterator[dict]:
    """A row for each recording: r along a tape, and how many trials show what it shows."""
    for observation in observations.EXPERIMENT:
        chain = ChainParameters(5, observation.belt_velocity, **constants)
        arrays = trials([chain] * RUNS, replicate=range(1, RUNS + 1), method="event", **LENGTH)
        low, median, high = np.quantile(observations.disorder_along_tape(arrays), [0.05, 0.5, 0.95])
        yield {
            "speed_m_s": observation.speed_m_s,
            "runs": RUNS,
            "r": median,
            "r_lower": low,
            "r_upper": high,
            "shows": int(observations.shows(observation, arrays).sum()),
            "agrees": int(observations.agrees(observation, arrays).sum()),
        }


if __name__ == "__main__":
    points = [dict(zip(LEVELS, values, strict=True)) for values in product(*LEVELS.values())]
    published.extend(FILE, points, viscous_trials)
