"""Power laws as straight lines on doubly logarithmic axes, and rank correlation."""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from beltrepro.analysis.errors import require


@dataclass(frozen=True)
class PowerLawFit:
    """y = prefactor * x**exponent, fitted for low <= x <= high.

    exponent_error is one standard error; sample_size counts what was fitted (bins or values).
    """

    exponent: float
    exponent_error: float
    prefactor: float
    low: float
    high: float
    sample_size: int = 0

    def __call__(self, abscissa):
        """Value of the fitted law at `abscissa` (any shape)."""
        return self.prefactor * np.asarray(abscissa, dtype=float) ** self.exponent


def fit_log_log(abscissa, ordinate, *, low, high, weight=None) -> PowerLawFit:
    """Least-squares line through (log x, log y) of the points with low <= x <= high and y > 0.

    weight : weight of each squared residual, e.g. counts (variance of log count = 1/count); None
        weighs all alike. The error is that of the slope, from the scatter about the line.
    Raises NotEnoughDataError with fewer than 4 points in the range.
    """
    abscissa, ordinate = (np.asarray(values, dtype=float) for values in (abscissa, ordinate))
    weight = np.ones_like(abscissa) if weight is None else np.asarray(weight, dtype=float)
    used = (abscissa >= low) & (abscissa <= high) & (abscissa > 0) & (ordinate > 0) & (weight > 0)
    require(used.sum() >= 4, f"{used.sum()} points between {low:.3g} and {high:.3g}, 4 are needed")
    logs, weight = np.log(abscissa[used]), weight[used]
    coefficients, covariance = np.polyfit(
        logs, np.log(ordinate[used]), 1, w=np.sqrt(weight), cov=True
    )
    return PowerLawFit(
        exponent=float(coefficients[0]),
        exponent_error=float(np.sqrt(covariance[0, 0])),
        prefactor=float(np.exp(coefficients[1])),
        low=float(low),
        high=float(high),
        sample_size=int(used.sum()),
    )


def rank_correlation(abscissa, ordinate) -> float:
    """Spearman's rank correlation, 0 when either of them (P,) does not vary: no trend."""
    abscissa, ordinate = np.asarray(list(abscissa)), np.asarray(list(ordinate))
    if np.ptp(abscissa) == 0 or np.ptp(ordinate) == 0:
        return 0.0
    return float(stats.spearmanr(abscissa, ordinate).statistic)
