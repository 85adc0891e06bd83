"""What the paper prints of its recordings, what trials as long show, and films of the model."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from beltrepro.base.errors import require
from beltrepro.model.units import from_si, to_si
from beltrepro.replication.camera.recording import LASTING_S
from beltrepro.replication.camera.scene import Scene, lengths_of_blocks
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.evidence import by_point
from beltrepro.stats.estimates import share

TABLES = {
    "alternation": Table(uses=("trials_free",)),
    "experiment_odds": Table(uses=("trials", "trials_short")),
}

# --- what the paper prints of its two recordings, and which trials show it (Secs. II and IV.B) ----

ALIKE = 1e-3  # share by which two belt velocities of a grid count as one
FRICTION_RATIO = 0.45  # printed, and measured (Sec. II)
TOLERANCE = 0.1  # of ln r: within 10 % of what is printed
ASSIGNED = (1.0, 2.0)  # noise that the paper assigns to the experiment
# Lengths of blocks that x_5 of the experiment holds, in metres, and that of the model does not. The
# paper calls x_5 the centre of mass of the last block and the length of the chain, reads it from a
# tape measure, and says nothing of the blocks in between (Sec. II).
BLOCKS_M = lengths_of_blocks(5, Scene().block_length)


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
        return from_si(self.speed_m_s, "velocity")


# At 0.22 m/s avalanches for 125 s and continuous slip for more than a minute, at 0.28 m/s both.
EXPERIMENT = (
    Observation(0.22, 0.072, lasting_s=60.0, lively_s=125.0),
    Observation(0.28, 0.052, lasting_s=LASTING_S, lively_s=LASTING_S),
)


def disorder_along_tape(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """r of runs as a tape tells it: x_5 scatters as much, and its mean holds lengths of blocks."""
    mean = arrays["mean_length"]
    return arrays["disorder_parameter"] * mean / (mean + from_si(BLOCKS_M, "length"))


def shows(observation: Observation, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which trials show the two regimes as long as the recording does."""
    lasting, lively = (to_si(arrays[f"{name}_longest"], "time") for name in ("lasting", "lively"))
    return (lasting >= observation.lasting_s) & (lively >= observation.lively_s)


def agrees(observation: Observation, arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which trials agree with a recording: in r, and in showing its regimes."""
    distance = np.abs(np.log(disorder_along_tape(arrays) / observation.disorder_parameter))
    return (distance <= TOLERANCE) & shows(observation, arrays)


def at_speed(speed_m_s: float, runs: Mapping[str, np.ndarray]) -> np.ndarray:
    velocity = from_si(speed_m_s, "velocity")
    return np.isclose(runs["belt_velocity"], velocity, rtol=ALIKE, atol=0)


def alternates(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which trials show both regimes, each for as long as a small amplitude lasts at least."""
    return shows(EXPERIMENT[1], arrays)


# --- trials of the length of the recordings -------------------------------------------------------


def alternation(data) -> pd.DataFrame:
    """A row for each noise, friction ratio and belt velocity."""
    arrays, rows = data["trials_free"].arrays, []
    for place, trials in by_point(arrays, "noise", "friction_ratio", "belt_velocity"):
        slip_s = to_si(arrays["all_slip_longest"][trials], "time")
        row = place | {"runs": trials.size, "alternating": alternates(arrays)[trials].sum()}
        row |= {"all_slip_longest_s": slip_s.max()}
        rows.append(row | {"all_slip": np.sum(slip_s >= EXPERIMENT[0].lasting_s)})
    return pd.DataFrame(rows)


def experiment_odds(data) -> pd.DataFrame:
    """A row for each dataset, recording and noise, and one for all noises together."""
    rows = []
    for name in TABLES["experiment_odds"].uses:
        arrays, attributes = data[name].arrays, data[name].attributes
        length = to_si(attributes["duration"] - attributes["transient"], "time")
        for observation in EXPERIMENT:
            here = at_speed(observation.speed_m_s, arrays)
            for noise in (*np.unique(arrays["noise"][here]), np.nan):
                chosen = here if np.isnan(noise) else here & (arrays["noise"] == noise)
                trials = {key: values[chosen] for key, values in arrays.items()}
                place = {"dataset": name, "speed_m_s": observation.speed_m_s}
                place |= {"recorded_s": length, "noise": noise}
                rows.append(place | _odds(observation, trials))
    return pd.DataFrame(rows)


def _odds(observation, trials) -> dict:
    """What the trials of one recording at one noise say together."""
    disorder, shown = disorder_along_tape(trials), shows(observation, trials)
    below = disorder <= observation.disorder_parameter
    lower, median, upper = np.quantile(disorder, [0.025, 0.5, 0.975])
    row = {
        "runs": disorder.size,
        "r_recorded": observation.disorder_parameter,
        "r": median,
        "r_lower": lower,
        "r_upper": upper,
        "r_least": disorder.min(),
        "lasting_longest_s": to_si(trials["lasting_longest"].max(), "time"),
        "all_slip_longest_s": to_si(trials["all_slip_longest"].max(), "time"),
    }
    for name, having in {
        "below": below,
        "shows": shown,
        "agrees": agrees(observation, trials),
        "both": below & shown,
    }.items():
        row |= share(having.sum(), having.size).named(name, f"{name}_lower", f"{name}_upper")
    return row


# --- films and their tracks -----------------------------------------------------------------------

BELTS = ("belt_022", "belt_028", "belt_035")
TRACK = "_track"
_LATE = 0.01  # of the time between true places, by which instants may differ


class TrackingError(NamedTuple):
    """Errors of a track, lengths in metres."""

    offset: float  # mean error of the place
    scatter: float  # standard deviation of the error
    largest: float  # largest error, without sign
    scale: float  # relative error of the scale: slope of the error against the true place


def filmed(run) -> tuple[np.ndarray, float]:
    """The positions of the last block that were filmed, and the time between them, in SI."""
    interval_s = to_si(float(run.attributes["sample_interval"]), "time")
    return to_si(run.arrays["positions"][:, -1], "length"), interval_s


def tracking_error(
    time_s: np.ndarray, x_m: np.ndarray, true_x_m: np.ndarray, interval_s: float
) -> TrackingError:
    """Compare measured places with true ones at the same instants."""
    require(len(time_s) >= 3, f"{len(time_s)} places, 3 are needed")
    steps = time_s / interval_s
    number = np.rint(steps).astype(int)
    at_true_instants = np.abs(steps - number).max() < _LATE and number.max() < true_x_m.size
    require(at_true_instants, "places at other instants than the true ones")
    error = x_m - true_x_m[number]
    scale, _ = np.polyfit(true_x_m[number], error, 1)
    return TrackingError(error.mean(), error.std(), np.abs(error).max(), scale)
