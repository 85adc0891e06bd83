"""Tests of two samples of runs against each other, and of many such tests together.

A run gives one number, so that runs are independent whatever happens within them. A comparison is
a row of agreement.csv, whose columns say what it holds; NaN in a sample is left out.
"""

import numpy as np
import scipy

LEVEL = 0.05  # a corrected p-value below this is a difference
NEAR = 0.01  # a smaller distance between distributions, as a share of their size, is negligible
MINIMUM_RUNS = 5  # fewer runs on a side are no sample
PERMUTATIONS = 9999

AGREE = "agree"
CLOSE = "differ by less than 1 %"
DIFFER = "differ"
UNKNOWN = "not measured"
VERDICTS = (AGREE, CLOSE, DIFFER, UNKNOWN)


def compare_samples(tested, reference) -> dict:
    """Means and distributions, the latter by the test of Kolmogorov and Smirnov.

    Its p is exact for these sizes; ties make it too large, never too small.
    """
    sides = [np.asarray(side, dtype=float) for side in (tested, reference)]
    sides = [side[np.isfinite(side)] for side in sides]
    p = scipy.stats.ks_2samp(*sides).pvalue if _enough(sides) else np.nan
    return _comparison(sides, "Kolmogorov-Smirnov", p, _distance(*sides))


def compare_shares(tested, reference, *, labels, counted) -> dict:
    """Which of several labels the runs got; means and errors are shares of the one that is counted.

    The p is that of chi^2 of the table of counts among all tables with the same margins
    (permutation test), so it holds for rare labels too.
    """
    sides = [np.asarray(side) for side in (tested, reference)]
    counts = np.array([[np.sum(side == label) for label in labels] for side in sides])
    p = _permutation_p(counts) if _enough(sides) else np.nan
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    distance = np.abs(shares[0] - shares[1]).sum() / 2
    return _comparison(
        [(side == counted).astype(float) for side in sides], "permutation", p, distance
    )


def compare_lifetimes(tested, reference, escaped_tested, escaped_reference) -> dict:
    """Lifetimes, with those of runs that did not escape censored: log-rank test (Mantel 1966).

    Means are of lifetimes cut off at the end of the run (restricted means).
    """
    sides = [np.asarray(side, dtype=float) for side in (tested, reference)]
    escaped = [np.asarray(side, dtype=bool) for side in (escaped_tested, escaped_reference)]
    p = np.nan
    if sum(side.sum() for side in escaped) >= MINIMUM_RUNS:
        censored = (
            scipy.stats.CensoredData(uncensored=lifetime[gone], right=lifetime[~gone])
            for lifetime, gone in zip(sides, escaped, strict=True)
        )
        p = scipy.stats.logrank(*censored).pvalue
    return _comparison(sides, "log-rank", p, _distance(*sides))


def _comparison(sides, test, p, distance) -> dict:
    row = dict(zip(("n_tested", "n_reference"), map(len, sides), strict=True))
    for role, side in zip(("tested", "reference"), sides, strict=True):
        row[f"mean_{role}"] = float(side.mean()) if side.size else np.nan
        row[f"error_{role}"] = float(scipy.stats.sem(side)) if side.size > 1 else np.nan
    z, mean_p = np.nan, np.nan
    if _enough(sides):
        difference = row["mean_tested"] - row["mean_reference"]
        error = np.hypot(row["error_tested"], row["error_reference"])
        if error > 0:
            z, mean_p = difference / error, scipy.stats.ttest_ind(*sides, equal_var=False).pvalue
        elif difference == 0:  # nothing varies: no test, and nothing to test
            z = 0.0
        else:
            z, mean_p = np.inf * np.sign(difference), 0.0
    row |= {"z": float(z), "mean_p": float(mean_p), "test": test, "p": float(p)}
    return row | {"distance": float(distance)}


def _permutation_p(counts) -> float:
    """Of a table of two rows; chi^2 follows from the first, as the columns are given."""
    columns = counts.sum(axis=0)
    counts, columns = counts[:, columns > 0], columns[columns > 0]
    expected = counts[0].sum() * columns / columns.sum()
    variance = expected * (1 - expected / columns)
    draws = np.random.default_rng(0).multivariate_hypergeometric(
        columns, counts[0].sum(), size=PERMUTATIONS
    )
    drawn, seen = (np.sum((first - expected) ** 2 / variance, -1) for first in (draws, counts[0]))
    return (1 + np.sum(drawn >= seen * (1 - 1e-12))) / (1 + PERMUTATIONS)


def _distance(tested, reference) -> float:
    """Wasserstein distance as a share of the root mean square: how much a difference matters."""
    size = np.sqrt(np.mean(np.square(reference))) if tested.size and reference.size else 0.0
    return scipy.stats.wasserstein_distance(tested, reference) / size if size > 0 else np.nan


def _enough(sides) -> bool:
    return min(map(len, sides)) >= MINIMUM_RUNS


def holm(p) -> np.ndarray:
    """p-values corrected for their number by Holm's step-down method, valid if they depend too."""
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
