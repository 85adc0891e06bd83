"""Tests of two samples of runs against each other, and of many such tests together.

A run gives one number, so that runs are independent whatever happens within them. A comparison is
a row of agreement.csv, whose columns say what it holds; NaN in a sample is left out.
"""

from collections.abc import Sequence

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


# --- samples --------------------------------------------------------------------------------------


def compare_samples(tested: npt.ArrayLike, reference: npt.ArrayLike) -> dict:
    """Means and distributions of two independent samples (one number for each run).

    The p of the distributions is that of the two-sample Kolmogorov-Smirnov test, exact for these
    sizes; ties make it too large, never too small.
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
) -> dict:
    """Which of several labels the runs of two samples got; means and errors are shares of one.

    The p is that of chi^2 of the table of counts among all tables with the same margins
    (permutation test), so it holds for rare labels too.
    """
    tested, reference = np.asarray(tested), np.asarray(reference)
    counts = np.array([[np.sum(side == label) for label in labels] for side in (tested, reference)])
    p = _permutation_p(counts, n_permutations, seed) if _enough(tested, reference) else np.nan
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    distance = float(np.abs(shares[0] - shares[1]).sum() / 2)
    sides = ((side == counted).astype(float) for side in (tested, reference))
    return _comparison(*sides, "permutation", p, distance)


def compare_lifetimes(
    tested: npt.ArrayLike,
    reference: npt.ArrayLike,
    escaped_tested: npt.ArrayLike,
    escaped_reference: npt.ArrayLike,
) -> dict:
    """Lifetimes, with those of runs that did not escape censored: log-rank test (Mantel 1966).

    Means are of lifetimes cut off at the end of the run (restricted means).
    """
    tested, reference = (np.asarray(side, dtype=float) for side in (tested, reference))
    escaped = [np.asarray(side, dtype=bool) for side in (escaped_tested, escaped_reference)]
    p = np.nan
    if sum(side.sum() for side in escaped) >= MINIMUM_RUNS:
        censored = (
            scipy.stats.CensoredData(uncensored=lifetime[gone], right=lifetime[~gone])
            for lifetime, gone in zip((tested, reference), escaped, strict=True)
        )
        p = float(scipy.stats.logrank(*censored).pvalue)
    return _comparison(tested, reference, "log-rank", p, _distance(tested, reference))


def _comparison(
    tested: np.ndarray, reference: np.ndarray, test: str, p: float, distance: float
) -> dict:
    means, errors = [], []
    for side in (tested, reference):
        means.append(float(np.mean(side)) if side.size else np.nan)
        errors.append(float(np.std(side, ddof=1) / np.sqrt(side.size)) if side.size > 1 else np.nan)
    z, mean_p = np.nan, np.nan
    if _enough(tested, reference):
        difference, error = means[0] - means[1], float(np.hypot(*errors))
        if error > 0:
            z = difference / error
            mean_p = float(scipy.stats.ttest_ind(tested, reference, equal_var=False).pvalue)
        elif difference == 0:  # nothing varies: no test, and nothing to test
            z = 0.0
        else:
            z, mean_p = np.inf * np.sign(difference), 0.0
    row: dict = {"n_tested": tested.size, "n_reference": reference.size}
    for number, side in enumerate(("tested", "reference")):
        row |= {f"mean_{side}": means[number], f"error_{side}": errors[number]}
    return row | {"z": float(z), "mean_p": mean_p, "test": test, "p": p, "distance": distance}


def _permutation_p(counts: np.ndarray, n_permutations: int, seed: int) -> float:
    total, expected = counts.sum(axis=0), counts.sum(axis=1, keepdims=True) * counts.sum(axis=0)
    occurring = total > 0
    expected = (expected / counts.sum())[0, occurring]
    share = expected / total[occurring]

    # chi^2 of both rows follows from the first, as the columns are given
    def statistic(first: np.ndarray) -> np.ndarray:
        return np.sum((first - expected) ** 2 / (expected * (1 - share)), axis=-1)

    draws = np.random.default_rng(seed).multivariate_hypergeometric(
        total[occurring], counts[0].sum(), size=n_permutations
    )
    beyond = np.sum(statistic(draws) >= statistic(counts[0, occurring]) * (1 - 1e-12))
    return float((1 + beyond) / (1 + n_permutations))


def _distance(tested: np.ndarray, reference: np.ndarray) -> float:
    """Wasserstein distance as a share of the root mean square: how much a difference matters."""
    if not (tested.size and reference.size):
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

    Holm's step-down method (1979), valid for dependent tests too.
    """
    p = np.asarray(p, dtype=float)
    corrected = np.full(p.shape, np.nan)
    finite = np.flatnonzero(np.isfinite(p))
    order = finite[np.argsort(p[finite])]
    factors = np.arange(finite.size, 0, -1)
    corrected[order] = np.minimum(np.maximum.accumulate(factors * p[order]), 1.0)
    return corrected


def verdict(corrected_p: float, distance: float) -> str:
    """What a comparison says in a word."""
    if not np.isfinite(corrected_p):
        return UNKNOWN
    if corrected_p >= LEVEL:
        return AGREE
    return CLOSE if distance < NEAR else DIFFER


def overall(comparisons: list[dict]) -> dict:
    """All comparisons of one quantity at independent points together: columns of families.csv.

    The squared normal scores of the p-values of the means follow the chi^2 distribution if the
    means are equal everywhere. The test that these p-values are uniform also notices that they are
    too large.
    """
    mean_p = _finite([row["mean_p"] for row in comparisons])
    together = dict.fromkeys(("chi2", "chi2_p", "uniform_p", "shift", "shift_error"), np.nan)
    if not mean_p.size:
        return {"degrees": 0} | together
    chi2 = float(np.sum(scipy.stats.norm.isf(np.maximum(mean_p, 1e-300) / 2) ** 2))
    relative = [
        (
            row["mean_tested"] / row["mean_reference"] - 1,
            np.hypot(row["error_tested"], row["error_reference"]) / row["mean_reference"],
        )
        for row in comparisons
        if np.isfinite(row["mean_p"]) and row["mean_reference"] != 0
    ]
    if relative:
        shift, errors = np.transpose(relative)
        together["shift"] = float(shift.mean())
        together["shift_error"] = float(np.sqrt(np.sum(errors**2)) / shift.size)
    return {"degrees": int(mean_p.size)} | together | {
        "chi2": chi2,
        "chi2_p": float(scipy.stats.chi2.sf(chi2, mean_p.size)),
        "uniform_p": float(scipy.stats.kstest(mean_p, "uniform").pvalue),
    }  # fmt: skip


def largest_of(count: int) -> float:
    """What the largest in size of several normal deviates exceeds in 5 of 100 cases."""
    return float(scipy.stats.norm.isf((1 - (1 - LEVEL) ** (1 / count)) / 2))
