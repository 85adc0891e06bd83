"""Power laws as straight lines on doubly logarithmic axes."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from beltrepro.base.errors import require


@dataclass(frozen=True)
class PowerLawFit:
    """y = prefactor * x**exponent, fitted for low <= x <= high."""

    exponent: float  # exponent of the law
    exponent_error: float  # one standard error of the exponent
    prefactor: float  # value of the law at x = 1
    low: float  # lower end of the range of the fit
    high: float  # upper end of the range of the fit
    sample_size: int = 0  # number of bins or values that were fitted

    def __call__(self, abscissa: npt.ArrayLike) -> np.ndarray:
        """Value of the fitted law at `abscissa` (any shape)."""
        return self.prefactor * np.asarray(abscissa, dtype=float) ** self.exponent


def fit_log_log(
    abscissa: npt.ArrayLike,
    ordinate: npt.ArrayLike,
    *,
    low: float,
    high: float,
    weight: npt.ArrayLike | None = None,
) -> PowerLawFit:
    """Least-squares line through (log x, log y) of the points with low <= x <= high and y > 0.

    The error of the exponent is that of the slope, from the scatter about the line.
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
