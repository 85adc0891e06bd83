"""What the paper prints of its two recordings, and which trials show it (Secs. II and IV.B)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from beltrepro.model import units
from beltrepro.replication.camera.recording import LASTING_S
from beltrepro.replication.camera.scene import Scene, lengths_of_blocks

ALIKE = 1e-3  # share by which two belt velocities of a grid count as one
FRICTION_RATIO = 0.45  # printed, and measured (Sec. II)
TOLERANCE = 0.1  # of ln r: within 10 % of what is printed


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


def assigned(noise: np.ndarray) -> np.ndarray:
    """Which noises are those that the paper assigns to the experiment."""
    return (noise >= ASSIGNED[0] - 1e-9) & (noise <= ASSIGNED[1] + 1e-9)
