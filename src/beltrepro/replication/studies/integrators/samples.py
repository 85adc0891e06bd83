"""Tests of two samples of runs against each other, and of many such tests together.

A run gives one number, so that runs are independent whatever happens within them. Samples are
compared by their means (Welch's t) and as a whole (two-sample Kolmogorov-Smirnov), labels by their
shares, lifetimes by the log-rank test, and p-values are corrected for the number of tests (Holm
1979). NaN in a sample is left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

LEVEL = 0.05  # a corrected p-value below this is a difference
NEAR = 0.01  # a smaller distance between distributions, as a share of their size, is negligible
MINIMUM_RUNS = 5  # fewer runs on a side are no sample

AGREE = "agree"
CLOSE = "differ by less than 1 %"
DIFFER = "differ"
UNKNOWN = "not measured"
VERDICTS = (AGREE, CLOSE, DIFFER, UNKNOWN)


@dataclass(frozen=True)
class Comparison:
    """Two samples side by side; NaN where a number does not exist."""

    n_tested: int  # runs of the tested side
    n_reference: int  # runs of the reference
    mean_tested: float  # mean of the tested side
    error_tested: float  # standard error of that mean
    mean_reference: float  # mean of the reference
    error_reference: float
    z: float  # difference of the means (tested minus reference) in units of its standard error
    mean_p: float  # p-value of Welch's t-test on the means, NaN if no run differs from any
    test: str  # name of the test on the whole distributions
    p: float  # p-value of that test
    # of the distributions (Wasserstein, or total variation of shares) as a share of the root mean
    # square of the reference: how much a difference matters
    distance: float


# --- samples --------------------------------------------------------------------------------------


def compare_samples(tested: npt.ArrayLike, reference: npt.ArrayLike) -> Comparison:
    """Means and distributions of two independent samples (one number for each run).

    The p of the distributions is that of the two-sample Kolmogorov-Smirnov test, exact for these
    sizes; ties make it too large, never too small. Below MINIMUM_RUNS on a side p and z are NaN.
    """
    tested, reference = _finite(tested), _finite(reference)
    p = np.nan
    if _enough(tested, reference):
        p = float(scipy.stats.ks_2samp(tested, reference, method="auto").pvalue)
    return _comparison(tested, reference, "Kolmogorov-Smirnov", p, _distance(tested, reference))


def compare_shares(
    tested: npt.ArrayLike,
    reference: npt.ArrayLike,
    *,
    labels: Sequence[str],
    counted: str,
    n_permutations: int = 9999,
    seed: int = 0,
) -> Comparison:
    """Which of several labels the runs of two samples got; means and errors are shares of one.

    The p is that of chi^2 of the table of counts among all tables with the same margins
    (permutation test), so it holds for rare labels too; it cannot be less than
    1 / (n_permutations + 1).
    """
    tested, reference = np.asarray(tested), np.asarray(reference)
    counts = np.array([[np.sum(side == label) for label in labels] for side in (tested, reference)])
    p = _permutation_p(counts, n_permutations, seed) if _enough(tested, reference) else np.nan
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    distance = float(np.abs(shares[0] - shares[1]).sum() / 2)
    ours, theirs = ((side == counted).astype(float) for side in (tested, reference))
    return _comparison(ours, theirs, "permutation", p, distance)


def compare_lifetimes(
    tested: npt.ArrayLike,
    reference: npt.ArrayLike,
    *,
    escaped_tested: npt.ArrayLike,
    escaped_reference: npt.ArrayLike,
) -> Comparison:
    """Lifetimes, with those of runs that did not escape censored: log-rank test (Mantel 1966).

    Means are of lifetimes cut off at the end of the run (restricted means). With fewer than
    MINIMUM_RUNS escapes on both sides together p is NaN.
    """
    sides = []
    for lifetime, escaped in ((tested, escaped_tested), (reference, escaped_reference)):
        lifetime, escaped = np.asarray(lifetime, dtype=float), np.asarray(escaped, dtype=bool)
        sides.append(
            scipy.stats.CensoredData(uncensored=lifetime[escaped], right=lifetime[~escaped])
        )
    p = np.nan
    if np.sum(escaped_tested) + np.sum(escaped_reference) >= MINIMUM_RUNS:
        p = float(scipy.stats.logrank(*sides).pvalue)
    return _comparison(
        np.asarray(tested, dtype=float),
        np.asarray(reference, dtype=float),
        "log-rank",
        p,
        _distance(tested, reference),
    )


def _comparison(
    tested: np.ndarray, reference: np.ndarray, test: str, p: float, distance: float
) -> Comparison:
    means, errors = [], []
    for side in (tested, reference):
        means.append(float(np.mean(side)) if side.size else np.nan)
        errors.append(float(np.std(side, ddof=1) / np.sqrt(side.size)) if side.size > 1 else np.nan)
    z, mean_p = np.nan, np.nan
    if _enough(tested, reference):
        difference, error = means[0] - means[1], float(np.hypot(errors[0], errors[1]))
        if error > 0:
            z = difference / error
            mean_p = float(scipy.stats.ttest_ind(tested, reference, equal_var=False).pvalue)
        elif difference == 0:  # nothing varies: no test, and nothing to test
            z = 0.0
        else:
            z, mean_p = np.inf * np.sign(difference), 0.0
    return Comparison(
        n_tested=int(tested.size),
        n_reference=int(reference.size),
        mean_tested=means[0],
        error_tested=errors[0],
        mean_reference=means[1],
        error_reference=errors[1],
        z=float(z),
        mean_p=mean_p,
        test=test,
        p=p,
        distance=distance,
    )


def _permutation_p(counts: np.ndarray, n_permutations: int, seed: int) -> float:
    total, expected = counts.sum(axis=0), counts.sum(axis=1, keepdims=True) * counts.sum(axis=0)
    known = total > 0
    expected = (expected / counts.sum())[0, known]
    share = expected / total[known]

    # chi^2 of both rows follows from the first, as the columns are given
    def statistic(first: np.ndarray) -> np.ndarray:
        return np.sum((first - expected) ** 2 / (expected * (1 - share)), axis=-1)

    draws = np.random.default_rng(seed).multivariate_hypergeometric(
        total[known], counts[0].sum(), size=n_permutations
    )
    beyond = np.sum(statistic(draws) >= statistic(counts[0, known]) * (1 - 1e-12))
    return float((1 + beyond) / (1 + n_permutations))


def _distance(tested: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    if not (np.size(tested) and np.size(reference)):
        return np.nan
    size = np.sqrt(np.mean(np.square(reference)))
    return float(scipy.stats.wasserstein_distance(tested, reference) / size) if size > 0 else np.nan


def _enough(tested: np.ndarray, reference: np.ndarray) -> bool:
    return min(len(tested), len(reference)) >= MINIMUM_RUNS


def _finite(values: npt.ArrayLike) -> np.ndarray:
    values = np.asarray(values, dtype=float)
    return values[np.isfinite(values)]


# --- many tests -----------------------------------------------------------------------------------


def holm(p: npt.ArrayLike) -> np.ndarray:
    """p-values corrected for their number: any of them below LEVEL by chance in 5 of 100.

    Holm's step-down method, valid for dependent tests too.
    """
    p = np.asarray(p, dtype=float)
    corrected = np.full(p.shape, np.nan)
    known = np.flatnonzero(np.isfinite(p))
    order = known[np.argsort(p[known])]
    factors = np.arange(known.size, 0, -1)
    corrected[order] = np.minimum(np.maximum.accumulate(factors * p[order]), 1.0)
    return corrected


def verdict(corrected_p: float, distance: float) -> str:
    """What a comparison says in a word."""
    if not np.isfinite(corrected_p):
        return UNKNOWN
    if corrected_p >= LEVEL:
        return AGREE
    return CLOSE if distance < NEAR else DIFFER


@dataclass(frozen=True)
class Overall:
    """All comparisons of one quantity together; NaN without comparisons."""

    degrees: int  # degrees of freedom of chi2: number of comparisons with a mean_p
    # sum of the squared normal scores of the mean_p; it follows the chi^2 distribution if the
    # means are equal everywhere
    chi2: float
    chi2_p: float  # its p-value, small when there are too many differences or a common one
    # p-value of the test that the mean_p are uniform (Kolmogorov-Smirnov, one sample), which also
    # notices that they are too large
    uniform_p: float
    shift: float  # mean relative difference of the means
    shift_error: float  # standard error of the shift


def overall(comparisons: list[Comparison]) -> Overall:
    """Test the comparisons of one quantity at independent points together."""
    mean_p = _finite([each.mean_p for each in comparisons])
    if not mean_p.size:
        return Overall(0, np.nan, np.nan, np.nan, np.nan, np.nan)
    scores = scipy.stats.norm.isf(np.maximum(mean_p, 1e-300) / 2)
    chi2 = float(np.sum(scores**2))
    relative = [
        (
            each.mean_tested / each.mean_reference - 1,
            np.hypot(each.error_tested, each.error_reference) / each.mean_reference,
        )
        for each in comparisons
        if np.isfinite(each.mean_p) and each.mean_reference != 0
    ]
    shift, errors = np.array(relative).reshape(-1, 2).T
    return Overall(
        degrees=int(mean_p.size),
        chi2=chi2,
        chi2_p=float(scipy.stats.chi2.sf(chi2, mean_p.size)),
        uniform_p=float(scipy.stats.kstest(mean_p, "uniform").pvalue),
        shift=float(shift.mean()) if shift.size else np.nan,
        shift_error=float(np.sqrt(np.sum(errors**2)) / shift.size) if shift.size else np.nan,
    )


def largest_of(count: int) -> float:
    """What the largest in size of several normal deviates exceeds in 5 of 100 cases."""
    return float(scipy.stats.norm.isf((1 - (1 - LEVEL) ** (1 / count)) / 2))
