"""Fluctuation of x_N over friction ratio and belt velocity, for both kinds of springs.

    python -m beltrepro.replication.studies.friction_ratio.runs

Of linear springs kinetic friction shifts the balance alone, so (1 - f_s) F_st0 is the only force
that is left: velocities and starts are those of one chain in units of it.
"""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from beltrepro import ChainParameters, scan
from beltrepro.replication.studies import published

FRICTION_RATIOS = {"exponential": (0.45, 0.7), "linear": (0.3, 0.45, 0.7)}
VELOCITIES = np.arange(9.0, 100.0, 3.0)  # u / (1 - f_s): the same for linear springs
SPRINGS = {
    "exponential": {},
    # longer ones have blocks that never meet; the length of a linear spring changes nothing else
    "linear": {"linear_limit": math.inf, "rest_length": 1000.0},
}
REPLICATES = 4
SPREAD = 18.0  # of the starts, times 1 - f_s
DURATION, TRANSIENT = 6000.0, 3000.0


def fluctuations(springs: str, friction_ratio: float) -> Iterator[dict]:
    """A row for each belt velocity and start."""
    chains = [
        ChainParameters(
            5, scaled * (1 - friction_ratio), friction_ratio=friction_ratio, **SPRINGS[springs]
        )
        for scaled in VELOCITIES
        for _ in range(REPLICATES)
    ]
    starts = list(range(1, REPLICATES + 1)) * len(VELOCITIES)
    runs = scan(
        chains,
        replicate=starts,
        method="event",
        initial_spread=SPREAD * (1 - friction_ratio),
        duration=DURATION,
        transient=TRANSIENT,
    )
    deviation = runs["disorder_parameter"] * runs["mean_length"]
    for chain, start, value in zip(chains, starts, deviation, strict=True):
        yield {"belt_velocity": chain.belt_velocity, "replicate": start, "deviation": value}


if __name__ == "__main__":
    published.extend(
        Path(__file__).with_name("fluctuations.csv"),
        (
            {"springs": name, "friction_ratio": ratio}
            for name, ratios in FRICTION_RATIOS.items()
            for ratio in ratios
        ),
        fluctuations,
    )
