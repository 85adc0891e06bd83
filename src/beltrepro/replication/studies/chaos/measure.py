"""Irregular and periodic motion: where runs end, how long they are irregular, and exponents."""

import numpy as np
import pandas as pd
import scipy

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.evidence import by_point
from beltrepro.stats import estimates, sections, survival
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.motion import MOTIONS, PERIODIC, UNSETTLED

TABLES = {
    "motions": Table(uses=("motion_map",)),
    "mean_lifetimes": Table(uses=("survival", "survival_many", "survival_long")),
}
POINT = ("n_blocks", "belt_velocity", "initial_spread")
"""What tells the points of a dataset apart; runs that differ in the replicate share a row."""


# --- runs of a given length -----------------------------------------------------------------------


def motions(data) -> pd.DataFrame:
    """A row for each number of blocks and belt velocity."""
    arrays = data["motion_map"].arrays
    rows = []
    for place, runs in by_point(arrays, "n_blocks", "belt_velocity"):
        state, disorder = arrays["state"][runs].astype(str), arrays["disorder_parameter"][runs]
        counts = {name: int(np.sum(state == name)) for name in MOTIONS}
        row = place | {"runs": runs.size} | counts | _exponent(arrays["largest_exponent"][runs])
        row["longest_period"] = int(arrays["period_events"][runs].max())
        row["r_periodic"] = pd.Series(disorder[state == PERIODIC]).mean()
        row["r_irregular"] = pd.Series(disorder[np.isin(state, UNSETTLED)]).mean()
        rows.append(row)
    return pd.DataFrame(rows)


def _exponent(exponents: np.ndarray) -> dict:
    """Mean over runs, and its error."""
    runs = pd.Series(exponents)
    return {"exponent": runs.mean(), "error": runs.std(ddof=1) / np.sqrt(runs.size)}


# --- runs that are followed until they settle -----------------------------------------------------


def mean_lifetimes(data) -> pd.DataFrame:
    """A row for each dataset, N, u and initial spread."""
    rows = []
    for name in TABLES["mean_lifetimes"].uses:
        horizon = survival.SEEN * float(data[name].attributes["duration"])
        for point, runs in by_point(data[name].arrays, *POINT):
            lasting = _lasting(sections.select(data[name].arrays, runs), horizon)
            rows.append({"dataset": name} | point | lasting)
    return pd.DataFrame(rows)


def _lasting(runs, horizon) -> dict:
    """The lifetimes of the runs of one point, their exponent, and where most of them end."""
    lifetime, settled = runs["lifetime"], runs["settled"].astype(bool)
    irregular = (runs[f"irregular_{name}"] for name in ("exponent", "error", "time"))
    exponent = survival.pool_exponents(*irregular)
    span = {"start": survival.spreading_time(exponent, horizon), "horizon": horizon}
    row = {"runs": settled.size, "settled": int(settled.sum())} | span
    row |= _lifetime(lifetime, settled, span)
    row |= {"exponent": exponent.value, "exponent_error": exponent.error}
    # regular too where irregular motion is too short for an exponent
    regular = settled.all() and not exponent.runs
    row["verdict"] = survival.REGULAR if regular else survival.decide(lifetime, settled, **span)
    names, count = np.unique(runs["state"].astype(str), return_counts=True)
    return row | {"attractor": names[np.argmax(count)]}


def _lifetime(lifetime, settled, span) -> dict:
    """Mean lifetime; empty where too few runs carry one."""
    time, ended = survival.observed(lifetime, settled, **span)
    try:
        mean = survival.mean_lifetime(time, ended)
    except NotEnoughDataError:
        mean = estimates.absent()
    return {"counted": time.size} | mean.named("lifetime", "lifetime_lower", "lifetime_upper")


# --- the section of Fig. 10 -----------------------------------------------------------------------

POINTS_OF_GROUP = 700  # section points, of which a dimension needs 500; groups differ in size
FEWEST_GROUPS = 3


def before_settling(points: np.ndarray) -> np.ndarray:
    """Which section points come before their run repeats itself to its end, seen twice or more."""
    coordinates, kept = _coordinates(points), np.ones(points.size, dtype=bool)
    limit = sections.NEAR * np.max(np.ptp(coordinates, axis=0)) if points.size else 0.0
    for run in np.unique(points["point"]):
        rows = np.flatnonzero(points["point"] == run)
        states = coordinates[rows]
        again = np.flatnonzero(np.abs(states[:-1] - states[-1]).max(axis=1) < limit)
        if again.size:
            period = rows.size - 1 - again[-1]
            apart = np.abs(states[period:] - states[:-period]).max(axis=1)
            since = np.flatnonzero(apart >= limit).max(initial=-1) + 1
            if rows.size - since >= 2 * period:
                kept[rows[since:]] = False
    return kept


def _coordinates(points: np.ndarray) -> np.ndarray:
    """All but x_2, which is the same at all points."""
    return np.hstack([np.delete(points["positions"], 1, axis=1), points["velocities"]])


def section_dimension(points: np.ndarray, n_groups: int) -> Estimate:
    """Correlation dimension of section points in their nine coordinates.

    The scatter of groups of runs and the error of the fit are in its interval.
    """
    coordinates = _coordinates(points)
    runs, place = np.unique(points["point"], return_inverse=True)
    n_groups = min(n_groups, runs.size, points.size // POINTS_OF_GROUP)
    require(n_groups >= FEWEST_GROUPS, f"{points.size} section points are too few")
    whole, error = sections.correlation_dimension(coordinates)
    parts = [
        sections.correlation_dimension(coordinates[place % n_groups == group])[0]
        for group in range(n_groups)
    ]
    scatter = estimates.mean(parts)
    reach = np.hypot(scatter.high - scatter.value, scipy.stats.norm.ppf(0.975) * error)
    return estimates.about(whole, reach, reach, runs.size)
