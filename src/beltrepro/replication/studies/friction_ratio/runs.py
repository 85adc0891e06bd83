"""Where r falls for friction ratios in steps of 0.05, with the paper's springs and linear ones.

    python -m beltrepro.replication.studies.friction_ratio.runs

Of linear springs kinetic friction shifts the balance alone, so (1 - f_s) F_st0 is the only force
that is left while no block slips forward: velocities and starts are those of one chain in units of
it. The fluctuation of x_N stands for r, since its mean hardly changes with u.
"""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from beltrepro import ChainParameters, scan
from beltrepro.model.energy import balance_tension, spring_extension
from beltrepro.replication.studies import published
from beltrepro.stats import branches, estimates

FRICTION_RATIOS = np.arange(1, 20) / 20
# Longer springs have blocks that never meet; nothing else depends on the length.
SPRINGS = {
    "linear": {"linear_limit": math.inf, "rest_length": 1000.0},
    "exponential": {"rest_length": 1000.0},
}
VELOCITIES = np.arange(6.0, 66.1, 1.5)  # u / (1 - f_s): up to u = 36 for the paper's ratio
PLATEAU = 24.0  # the last of these at which all chains move irregularly
REPLICATES = 12
SPREAD = 4.0  # of the starts at rest, times 1 - f_s, about the balance with kinetic friction
DURATION, TRANSIENT = 10_000.0, 5_000.0


def falls(springs: str, friction_ratio: float) -> Iterator[dict]:
    """Where r falls, and where half of the runs first have less than half of it."""
    deviation = _deviations(springs, friction_ratio)
    u = VELOCITIES * (1 - friction_ratio)
    critical = branches.fall(np.repeat(u, REPLICATES), deviation.ravel())["critical"]
    plateau = np.median(deviation[VELOCITIES <= PLATEAU])
    fallen = deviation < plateau / 2
    begin = _begin(u, fallen.mean(axis=1))
    rng = np.random.default_rng(0)
    drawn = rng.integers(REPLICATES, size=(estimates.RESAMPLES, *fallen.shape))
    begins = [_begin(u, np.take_along_axis(fallen, row, 1).mean(axis=1)) for row in drawn]
    low, high = np.quantile(np.nan_to_num(begins, nan=np.inf), [0.025, 0.975], method="nearest")
    grid = u[1] - u[0]  # which leaves open where between two velocities it begins
    row = {"runs": deviation.size, "plateau": plateau}
    row |= {"begin": begin, "begin_low": low - grid, "begin_high": high}
    yield row | critical.named("critical", "critical_low", "critical_high")


def _begin(velocity: np.ndarray, share: np.ndarray) -> float:
    """The first of two neighbouring velocities at which half or more have fallen, or NaN.

    At one alone it may be a periodic window.
    """
    half = share >= 0.5
    places = np.flatnonzero(half[:-1] & half[1:])
    return velocity[places[0]] if places.size else np.nan


def _deviations(springs: str, friction_ratio: float) -> np.ndarray:
    """Standard deviation of x_N (velocities, replicates)."""
    chains = [
        ChainParameters(
            5, scaled * (1 - friction_ratio), friction_ratio=friction_ratio, **SPRINGS[springs]
        )
        for scaled in VELOCITIES
        for _ in range(REPLICATES)
    ]
    lengths = chains[0].rest_length + spring_extension(balance_tension(chains[0]), chains[0])
    runs = scan(
        chains,
        replicate=list(range(1, REPLICATES + 1)) * len(VELOCITIES),
        method="event",
        initial_positions=[np.cumsum(lengths)] * len(chains),
        initial_spread=SPREAD * (1 - friction_ratio),
        duration=DURATION,
        transient=TRANSIENT,
    )
    deviation = runs["disorder_parameter"] * runs["mean_length"]
    return np.reshape(deviation, (len(VELOCITIES), REPLICATES))


if __name__ == "__main__":
    published.extend(
        Path(__file__).with_name("falls.csv"),
        (
            {"springs": springs, "friction_ratio": ratio}
            for springs in SPRINGS
            for ratio in FRICTION_RATIOS
        ),
        falls,
    )
