"""What replicates of the points along an axis have in common, and how far they spread."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

SHARE = 0.8  # of the replicates that a band holds


@dataclass(frozen=True)
class Spread:
    """Replicates at each place along an axis."""

    place: np.ndarray  # distinct places, rising; unit of the axis
    # quantile below which half of those lie that the band leaves out; unit of the values
    low: np.ndarray
    median: np.ndarray  # half of the values lie below
    high: np.ndarray  # quantile above which the other half of those left out lies
    mean: np.ndarray  # mean of the values
    error: np.ndarray  # standard error of the mean; NaN of a single value
    count: np.ndarray  # how many values there are


def spread(abscissa: npt.ArrayLike, values: npt.ArrayLike, *, share: float = SHARE) -> Spread:
    """Quantiles and means over the replicates at each place."""
    abscissa, values = (np.asarray(each, dtype=float) for each in (abscissa, values))
    known = np.isfinite(values)
    places = np.unique(abscissa[known])
    levels = (0.5 - share / 2, 0.5, 0.5 + share / 2)
    runs = [values[known & (abscissa == place)] for place in places]
    low, median, high = np.reshape([np.quantile(each, levels) for each in runs], (-1, 3)).T
    count = np.array([each.size for each in runs], dtype=int)
    deviation = np.array([each.std(ddof=1) if each.size > 1 else np.nan for each in runs])
    return Spread(
        place=places,
        low=low,
        median=median,
        high=high,
        mean=np.array([each.mean() for each in runs]),
        error=deviation / np.sqrt(count),
        count=count,
    )
