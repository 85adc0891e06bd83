"""What replicates of the points along an axis have in common, and how far they spread."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

SHARE = 0.8  # of the replicates that a band holds


@dataclass(frozen=True)
class Spread:
    """Replicates at each place along an axis.

    Attributes
    ----------
    place : array (D,)
        Distinct places, rising; unit of the axis.
    low : array (D,)
        Quantile below which half of those lie that the band leaves out; unit of the values.
    median : array (D,)
        Half of the values lie below.
    high : array (D,)
        Quantile above which the other half of those left out lies.
    mean : array (D,)
        Mean of the values.
    error : array (D,)
        Standard error of the mean; NaN of a single value.
    count : array (D,) of int
        How many values there are.
    """

    place: np.ndarray
    low: np.ndarray
    median: np.ndarray
    high: np.ndarray
    mean: np.ndarray
    error: np.ndarray
    count: np.ndarray


def spread(abscissa: npt.ArrayLike, values: npt.ArrayLike, *, share: float = SHARE) -> Spread:
    """Quantiles and means over the replicates at each place.

    Parameters
    ----------
    abscissa : array (P,)
        Place of each run, in any order.
    values : array (P,)
        What was measured of it; NaN is left out, and so is a place where nothing else is.
    share : float
        Of the values between the outer quantiles, 0 to 1.

    Returns
    -------
    Spread
        D places. Quantiles are interpolated between values, so that the band of two values is
        narrower than their distance.
    """
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
