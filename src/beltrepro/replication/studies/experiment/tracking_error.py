"""How far measured places of the last block are from the true ones."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from beltrepro.stats.errors import require

_LATE = 0.01  # of the time between true places, by which instants may differ


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
    return TrackingError(
        offset=float(error.mean()),
        scatter=float(error.std()),
        largest=float(np.abs(error).max()),
        scale=float(scale),
        places=number.size,
    )
