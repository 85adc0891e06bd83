"""Numbers from films of the model: errors of their tracks, and what the recordings tell."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from beltrepro.base.errors import require
from beltrepro.model.units import TIME_S, to_si
from beltrepro.replication.camera.recording import analyse
from beltrepro.replication.plan.registry import Table
from beltrepro.stats.intermittency import slips_of_all

BELTS = ("belt_022", "belt_028", "belt_035")
TABLES = {
    "recordings": Table(
        uses=(
            "belt_022",
            "belt_028",
            "belt_035",
            "belt_022_track",
            "belt_028_track",
            "belt_035_track",
        )
    )
}

TRACK = "_track"
_LATE = 0.01  # of the time between true places, by which instants may differ


# --- errors of tracking ---------------------------------------------------------------------------


@dataclass(frozen=True)
class TrackingError:
    """Errors of a track, lengths in metres."""

    offset: float  # mean error of the place
    scatter: float  # standard deviation of the error
    largest: float  # largest error, without sign
    scale: float  # relative error of the scale: slope of the error against the true place
    places: int  # number of places compared


def tracking_error(
    time_s: npt.ArrayLike, x_m: npt.ArrayLike, true_x_m: npt.ArrayLike, interval_s: float
) -> TrackingError:
    """Compare measured places with true ones at the same instants."""
    position, true = np.asarray(x_m, dtype=float), np.asarray(true_x_m, dtype=float)
    steps = np.asarray(time_s, dtype=float) / interval_s
    number = np.rint(steps).astype(int)
    require(number.size >= 3, f"{number.size} places, 3 are needed")
    late = np.abs(steps - number).max()
    require(
        late < _LATE and number.max() < true.size, "places at other instants than the true ones"
    )
    error = position - true[number]
    scale, _ = np.polyfit(true[number], error, 1)
    numbers = error.mean(), error.std(), np.abs(error).max(), scale
    return TrackingError(*map(float, numbers), number.size)


def recordings(data) -> pd.DataFrame:
    """A row for each film."""
    return pd.DataFrame([_recording_row(data, film) for film in BELTS])


def _recording_row(data, film):
    run, track = data[film], data[film + TRACK]
    interval = float(run.attributes["sample_interval"]) * TIME_S
    true = to_si(run.arrays["positions"][:, -1], "length")
    error = tracking_error(track.time_s, track.x_m, true, interval)
    sampled = analyse(interval * np.arange(true.size), true)
    tracked = analyse(track.time_s, track.x_m)
    pixel = track.metres_per_pixel
    return {
        "film": film,
        "belt_speed": to_si(run.attributes["belt_velocity"], "velocity"),
        "noise": run.attributes["noise"],
        "seconds": true.size * interval,
        "frames_per_second": 1 / interval,
        "frames": error.places,
        "r_run": float(run.arrays["disorder_parameter"]),
        "r_sampled": sampled.disorder_parameter,
        "r_tracked": tracked.disorder_parameter,
        "mean_sampled": sampled.mean_length,
        "mean_tracked": tracked.mean_length,
        "small_sampled": sampled.lasting_share,
        "small_tracked": tracked.lasting_share,
        "offset": error.offset / pixel,
        "scatter": error.scatter / pixel,
        "largest": error.largest / pixel,
        "scale": error.scale,
        "metres_per_pixel": pixel,
    }


# --- what films tell ------------------------------------------------------------------------------


def longest_slip_of_all_s(run) -> float:
    """Longest time in seconds for which all blocks of a run slip at once."""
    time, velocities, events = (run.arrays[name] for name in ("time", "velocities", "events"))
    spans = slips_of_all(time, velocities - run.attributes["belt_velocity"], events)
    return TIME_S * float(np.diff(spans, axis=1).max(initial=0.0))
