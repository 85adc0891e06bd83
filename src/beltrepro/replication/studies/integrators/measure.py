"""Two integrators side by side: which quantities are compared at which points, and the outcome.

The sides, `tested` and `reference`, have one row for each run. Statistics within a run are
correlated, so a run enters as one number for each quantity. All runs of a side have random numbers
of their own: the samples are independent. A comparison is a row of agreement.csv.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import scipy

from beltrepro.replication.plan.registry import Table
from beltrepro.stats import states

TABLES = {
    "agreement": Table(
        uses=(
            "pairs_r_verlet",
            "pairs_r_event",
            "pairs_slips_verlet",
            "pairs_slips_event",
            "pairs_states_verlet",
            "pairs_states_event",
        ),
    ),
}

DISORDER = "disorder parameter r"
STILL_STICKING = "share that still sticks at the end"
FINAL_DISORDER = "disorder parameter r at the end"
LIFETIME = "lifetime of the chaotic transient"

LEVEL = 0.05  # a corrected p-value below this is a difference
NEAR = 0.01  # a smaller distance between distributions, as a share of their size, is negligible
MINIMUM_RUNS = 5  # fewer runs on a side are no sample
PERMUTATIONS = 9999
AGREE, CLOSE, DIFFER, UNKNOWN = "agree", "differ by less than 1 %", "differ", "not measured"

_POINT = ["n_blocks", "belt_velocity", "noise"]
# What tells the families apart: a family is what one quantity gives at all points.
_FAMILY = ["part", "quantity", "time_step", "initial_spread"]
_IN_ORDER = {"sort": False, "dropna": False}  # families as they come, those without a step too


# --- agreement.csv --------------------------------------------------------------------------------


def agreement(data) -> pd.DataFrame:
    """A row for each quantity and point, family after family, with verdicts."""
    return judge(pd.DataFrame(_compared(data)))


def judge(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with corrected_p and verdict; the p of a family are corrected together."""
    families = rows.groupby(_FAMILY, **_IN_ORDER)
    corrected = families["p"].transform(holm)
    words = map(verdict, corrected, rows["distance"])
    judged = rows.assign(corrected_p=corrected, verdict=list(words))
    return judged.iloc[np.argsort(families.ngroup(), kind="stable")]


def _compared(data) -> Iterator[dict]:
    """The comparisons of each part, before any correction for their number."""
    for part, name, compare in (
        ("disorder", "pairs_r", lambda *sides: compare_points(*map(disorder_statistics, sides))),
        ("slips", "pairs_slips", lambda *sides: compare_points(*map(slip_statistics, sides))),
        ("attractors", "pairs_states", compare_attractors),
    ):
        sides = [data[f"{name}_{method}"] for method in ("verlet", "event")]
        tested, reference = (side.attributes["method"] for side in sides)
        for row in compare(*sides):
            yield {"part": part} | row | {"tested": tested, "reference": reference}


def disorder_statistics(scan) -> pd.DataFrame:
    """Per run: r, mean length, rates of slips and crossings, v_N at the section."""
    points = scan.arrays
    measured_time = scan.attributes["duration"] - scan.attributes["transient"]
    sections = [values[np.isfinite(values)] for values in points["section_velocity"]]
    last = np.arange(len(sections)), points["n_blocks"] - 1
    statistics = {
        DISORDER: points["disorder_parameter"],
        "mean length": points["mean_length"],
        "slips of the last block per time": points["slip_count"][last] / measured_time,
        "crossings of the section per time": points["section_count"] / measured_time,
        "v_N at the section, mean": [_of(np.mean, values) for values in sections],
        "v_N at the section, standard deviation": [_of(np.std, values) for values in sections],
    }
    return pd.DataFrame({name: points[name] for name in _POINT} | statistics)


def slip_statistics(catalogue) -> pd.DataFrame:
    """Per run: number, sizes and losses of the slips of the last block, and section points.

    Sizes are those in the laboratory frame (Fig. 9).
    """
    arrays, rows = catalogue.arrays, []
    for run, n_blocks in enumerate(arrays["n_blocks"]):
        slips, section = (
            events[events["point"] == run] for events in (arrays["slips"], arrays["section"])
        )
        slips = slips[slips["block"] == n_blocks]
        sizes = slips["start_position"] - slips["stop_position"]
        at_section = section["velocities"][:, n_blocks - 1]
        rows.append(
            {name: arrays[name][run] for name in _POINT}
            | {
                "slips of the last block": sizes.size,
                "slip size, mean": _of(np.mean, sizes),
                "slip size, median": _of(np.quantile, sizes, 0.5),
                "slip size, 90 % quantile": _of(np.quantile, sizes, 0.9),
                "energy dissipated in a slip, mean": _of(np.mean, slips["dissipated"]),
                "section points": at_section.size,
                "v_N at section points, mean": _of(np.mean, at_section),
                "v_N at section points, standard deviation": _of(np.std, at_section),
            }
        )
    return pd.DataFrame(rows)


def _of(statistic, values: np.ndarray, *options: float) -> float:
    return statistic(values, *options) if values.size else np.nan


def compare_points(tested: pd.DataFrame, reference: pd.DataFrame) -> Iterator[dict]:
    """Every quantity at every point (N, u, sigma) that both sides have; a row is a run."""
    at_point = dict(iter(reference.groupby(_POINT)))
    for point, runs in tested.groupby(_POINT):
        for quantity in tested.columns.drop(_POINT) if point in at_point else ():
            place = dict(zip(_POINT, point, strict=True))
            comparison = compare_samples(runs[quantity], at_point[point][quantity])
            yield {"quantity": quantity} | place | comparison


def compare_attractors(tested, reference) -> Iterator[dict]:
    """Where runs without noise end, for each u, initial spread and time step of the tested side.

    The reference is the one with its smallest step.
    """
    names = [*_POINT, "initial_spread", "time_step"]
    columns = (*names, "final_disorder", "lifetime", "escaped")
    ours, theirs = (
        pd.DataFrame({name: side.arrays[name] for name in columns}).assign(
            label=states.label_ends(side.arrays)
        )
        for side in (tested, reference)
    )
    finest = theirs[theirs["time_step"] == theirs["time_step"].min()]
    at_point = dict(iter(finest.groupby(names[:-1])))
    for (*point, step), runs in ours.groupby(names):
        if tuple(point) not in at_point:
            continue
        sides = runs, at_point[tuple(point)]
        place = dict(zip(names, (*point, step), strict=True))
        for quantity, comparison in (
            (STILL_STICKING, compare_labels(*(side["label"] for side in sides))),
            (FINAL_DISORDER, compare_samples(*(side["final_disorder"] for side in sides))),
            (LIFETIME, compare_lifetimes(*sides)),
        ):
            yield {"quantity": quantity} | place | comparison


# --- two samples, and many such tests together ----------------------------------------------------


def compare_samples(tested, reference) -> dict:
    """Means and distributions, the latter by the test of Kolmogorov and Smirnov.

    Its p is exact for these sizes; ties make it too large, never too small. NaN is left out.
    """
    sides = [np.asarray(side, dtype=float) for side in (tested, reference)]
    sides = [side[np.isfinite(side)] for side in sides]
    p = scipy.stats.ks_2samp(*sides).pvalue if _enough(sides) else np.nan
    return _comparison(sides, "Kolmogorov-Smirnov", p, _distance(*sides))


def compare_labels(tested, reference) -> dict:
    """In which attractor the runs end; means and errors are shares of those that still stick.

    The p is that of chi^2 of the table of counts among all tables with the same margins
    (permutation test), so it holds for rare attractors too.
    """
    sides = [np.asarray(side) for side in (tested, reference)]
    counts = np.array([[np.sum(side == label) for label in states.ATTRACTORS] for side in sides])
    p = _permutation_p(counts) if _enough(sides) else np.nan
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    distance = np.abs(shares[0] - shares[1]).sum() / 2
    sticking = [(side == states.STICK_SLIP).astype(float) for side in sides]
    return _comparison(sticking, "permutation", p, distance)


def compare_lifetimes(tested, reference) -> dict:
    """Lifetimes, with those of runs that did not escape censored: log-rank test (Mantel 1966).

    Means are of lifetimes cut off at the end of the run (restricted means).
    """
    sides = [np.asarray(side["lifetime"], dtype=float) for side in (tested, reference)]
    escaped = [np.asarray(side["escaped"], dtype=bool) for side in (tested, reference)]
    p = np.nan
    if sum(side.sum() for side in escaped) >= MINIMUM_RUNS:
        censored = (
            scipy.stats.CensoredData(uncensored=lifetime[gone], right=lifetime[~gone])
            for lifetime, gone in zip(sides, escaped, strict=True)
        )
        p = scipy.stats.logrank(*censored).pvalue
    return _comparison(sides, "log-rank", p, _distance(*sides))


def _comparison(sides, test: str, p: float, distance: float) -> dict:
    row = {"n_tested": len(sides[0]), "n_reference": len(sides[1])}
    for role, side in zip(("tested", "reference"), sides, strict=True):
        row[f"mean_{role}"] = float(side.mean()) if side.size else np.nan
        row[f"error_{role}"] = float(scipy.stats.sem(side)) if side.size > 1 else np.nan
    z = np.nan
    if _enough(sides):
        difference = row["mean_tested"] - row["mean_reference"]
        error = np.hypot(row["error_tested"], row["error_reference"])
        # where nothing varies the means are equal or surely differ
        z = difference / error if error > 0 else np.inf * difference if difference else 0.0
    return row | {"z": float(z), "test": test, "p": float(p), "distance": float(distance)}


def _permutation_p(counts: np.ndarray) -> float:
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


def _distance(tested: np.ndarray, reference: np.ndarray) -> float:
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
    if not np.isfinite(corrected_p):
        return UNKNOWN
    if corrected_p >= LEVEL:
        return AGREE
    return CLOSE if distance < NEAR else DIFFER
