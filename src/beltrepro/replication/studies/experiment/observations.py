"""What the paper prints of its two recordings, and which trials show it (Secs. II and IV.B)."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from beltrepro.base.errors import require
from beltrepro.model import units
from beltrepro.replication.camera.recording import LASTING_S
from beltrepro.replication.camera.scene import Scene, lengths_of_blocks
from beltrepro.replication.studies.experiment.inference import Simulated

ALIKE = 1e-3  # share by which two belt velocities of a grid count as one
FRICTION_RATIO = 0.45  # printed, and measured (Sec. II)
TOLERANCE = 0.1  # of ln r: within 10 % of what is printed
MINIMUM_AGREED = 20  # trials that agree with a recording; fewer make no posterior


@dataclass(frozen=True)
class Observation:
    """What is printed of one recording."""

    speed_m_s: float  # speed of the belt
    disorder_parameter: float  # r of the recording, in which x_5 holds lengths of blocks
    # it has a small amplitude, and a time without one that lasts, of this length or longer
    lasting_s: float
    lively_s: float

    @property
    def belt_velocity(self) -> float:
        """Speed of the belt in model units."""
        return units.from_si(self.speed_m_s, "velocity")


EXPERIMENT = (
    Observation(0.22, 0.072, lasting_s=60.0, lively_s=125.0),
    Observation(0.28, 0.052, lasting_s=LASTING_S, lively_s=LASTING_S),
)
"""At 0.22 m/s avalanches for 125 s and continuous slip for more than a minute, at 0.28 m/s both."""

RECORDED = [math.log(row.disorder_parameter) for row in EXPERIMENT]
"""ln r of both recordings; both show their regimes."""

ERRORS = {"friction_ratio": 0.075, "speed_factor": 0.2}
"""How far the true friction ratio and the logarithm of the true speed may be from the printed ones.

Standard deviations, for what is probable before the trials. The paper prints no errors: these are
what we allow, a sixth of the ratio and a fifth of the speed. They were chosen after a pilot with
five pairs; what others make of it is in docs/experiment.md.
"""

ASSIGNED = (1.0, 2.0)
"""Noise that the paper assigns to the experiment."""


BLOCKS_M = lengths_of_blocks(5, Scene().block_length)
"""Lengths of blocks that x_5 of the experiment holds, in metres, and that of the model does not.

The paper calls x_5 the centre of mass of the last block and the length of the chain, reads it from
a tape measure, and says nothing of the blocks in between (Sec. II).
"""


def disorder_along_tape(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """r of runs as a tape tells it: x_5 scatters as much, and its mean holds lengths of blocks."""
    mean = arrays["mean_length"]
    return arrays["disorder_parameter"] * mean / (mean + units.from_si(BLOCKS_M, "length"))


def shows(observation: Observation, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which trials show the two regimes as long as the recording does."""
    lasting, lively = (
        units.to_si(arrays[name], "time") for name in ("lasting_longest", "lively_longest")
    )
    return (lasting >= observation.lasting_s) & (lively >= observation.lively_s)


def agrees(observation: Observation, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which trials agree with a recording: in r, and in showing its regimes."""
    distance = np.abs(np.log(disorder_along_tape(arrays) / observation.disorder_parameter))
    return (distance <= TOLERANCE) & shows(observation, arrays)


def at_speed(observation: Observation, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which trials have the belt velocity of a recording."""
    return np.isclose(arrays["belt_velocity"], observation.belt_velocity, rtol=ALIKE, atol=0)


def alternates(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which trials show both regimes, each for as long as a small amplitude lasts at least."""
    return shows(EXPERIMENT[1], arrays)


BANDWIDTH = {"speed_factor": 0.035}
"""How far shares of trials are averaged over, of the logarithms of these parameters.

The friction ratio is not averaged over: r changes by 15 % where it changes by 0.025. The noise is
not, either: it changes little, and sets of noises would be wider than they need be.
"""


def assigned(noise: np.ndarray) -> np.ndarray:
    """Which noises are those that the paper assigns to the experiment."""
    return (noise >= ASSIGNED[0] - 1e-9) & (noise <= ASSIGNED[1] + 1e-9)


def on_grid(arrays: Mapping[str, np.ndarray]) -> Simulated:
    """Trials at all noises, friction ratios and belt velocities, as pairs of recordings.

    Where the belt velocities stand in the ratio of the two speeds of the experiment, the trials at
    one serve as the first recording and those at the other as the second. Both speeds are then
    multiplied by one factor. Before the trials all noises are equally probable, and friction ratios
    and speeds the less the farther they are from the printed ones.
    """
    names = ("noise", "friction_ratio", "belt_velocity")
    points = np.array([arrays[name] for name in names])
    noise, ratio, velocity = levels = [np.unique(row) for row in points]
    order = np.lexsort(points[::-1])
    cells = np.array(list(itertools.product(*levels))).reshape(-1, 3).T
    runs = points.shape[1] // max(1, cells.shape[1])
    full = runs and np.array_equal(points[:, order], np.repeat(cells, runs, axis=1))
    require(full, f"{points.shape[1]} trials are no full grid of {cells.shape[1]} cells")
    wanted = velocity * EXPERIMENT[1].speed_m_s / EXPERIMENT[0].speed_m_s
    pairs = np.nonzero(np.isclose(wanted[:, np.newaxis], velocity, rtol=ALIKE, atol=0))
    require(pairs[0].size, "no two belt velocities have the ratio of those of the experiment")

    def paired(values: list[np.ndarray]) -> np.ndarray:
        """Values of the trials, as judged for each recording, at its velocities: (2, *C, R)."""
        shape = (noise.size, ratio.size, velocity.size, runs)
        of_both = zip(values, pairs, strict=True)
        return np.stack([of_one[order].reshape(shape)[:, :, at] for of_one, at in of_both])

    summary = np.log(paired([disorder_along_tape(arrays)] * 2))
    shown = paired([shows(observation, arrays) for observation in EXPERIMENT])
    factor = velocity[pairs[0]] / EXPERIMENT[0].belt_velocity
    axes = {"noise": noise, "friction_ratio": ratio, "speed_factor": factor}
    smoothing = {
        name: width / np.diff(np.log(axes[name])).mean()
        for name, width in BANDWIDTH.items()
        if axes[name].size > 1
    }
    weights = {
        "friction_ratio": np.exp(-(((ratio - FRICTION_RATIO) / ERRORS["friction_ratio"]) ** 2) / 2),
        "speed_factor": np.exp(-((np.log(factor) / ERRORS["speed_factor"]) ** 2) / 2),
    }
    quiet_share = paired([arrays["lasting_share"]] * 2)
    return Simulated(axes, summary, shown, smoothing, weights, quiet_share)
