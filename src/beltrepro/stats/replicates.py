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
    abscissa, values = (np.asarray(array, dtype=float) for array in (abscissa, values))
    is_number = np.isfinite(values)
    places = np.unique(abscissa[is_number])
    levels = (0.5 - share / 2, 0.5, 0.5 + share / 2)
    runs_at = [values[is_number & (abscissa == place)] for place in places]
    low, median, high = np.reshape([np.quantile(runs, levels) for runs in runs_at], (-1, 3)).T
    count = np.array([runs.size for runs in runs_at], dtype=int)
    deviation = np.array([runs.std(ddof=1) if runs.size > 1 else np.nan for runs in runs_at])
    return Spread(
        place=places,
        low=low,
        median=median,
        high=high,
        mean=np.array([runs.mean() for runs in runs_at]),
        error=deviation / np.sqrt(count),
        count=count,
    )
