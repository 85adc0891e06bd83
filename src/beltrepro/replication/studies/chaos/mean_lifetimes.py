"""mean_lifetimes.csv: how long irregular motion lasts, and whether it ends, at every point."""

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.chaos import orbits as attractors
from beltrepro.stats import survival
from beltrepro.stats.errors import NotEnoughDataError
from beltrepro.stats.shares import share

TABLE = Table(
    title="Mean lifetime of irregular motion, and whether it ends.",
    uses=("survival", "survival_many", "survival_long"),
    columns={
        "dataset": "of the runs: survival, survival_many or survival_long",
        "runs": "runs at this point",
        "settled": "runs that settled",
        "share": "share of the runs that have not settled when they are given up",
        "share_lower": "lower end of its interval (Clopper and Pearson, 95 %)",
        "share_upper": "upper end",
        "start": "time from which lifetimes count (model time): five e-foldings of a deviation",
        "horizon": "time up to which ends count (model time): later ones are not all known",
        "counted": "runs that are irregular at the start",
        "ended": "of these, the runs that ended up to the horizon",
        "lifetime": "mean lifetime from the start on (model time); inf if none of them ended",
        "lifetime_lower": "lower end of its interval (chi-square, 95 %)",
        "lifetime_upper": "upper end; inf if none of them ended",
        "exponential_p": "p-value of the test that lifetimes are exponential (Lilliefors)",
        "shape": "of the Weibull distribution; below 1 if the rate of ends falls with time",
        "shape_p": "p-value of the test that the shape is 1",
        "exponent": "largest exponent of the irregular motion (1 / model time)",
        "exponent_error": "its standard error, from the scatter of the runs",
        "exponent_runs": "runs with an exponent",
        "verdict": "regular, transient, lasting (as far as these runs tell) or open",
        "attractor": "state in which most runs are at the end",
        "attractor_period": "period of the most frequent attractor (model time)",
        "attractor_events": "slips of all blocks in this period",
        "attractor_share": "share of the runs that end on it",
    },
)

POINT = ("n_blocks", "belt_velocity", "initial_spread")
"""What tells the points of a dataset apart; runs that differ in the replicate share a row."""


def derive(data) -> pd.DataFrame:
    """A row for each dataset, N, u and initial spread."""
    rows = []
    for name in TABLE.uses:
        horizon = survival.SEEN * float(data[name].attributes["duration"])
        for point, runs in by_point(data[name].arrays):
            rows.append({"dataset": name} | point | _row(runs, horizon))
    return pd.DataFrame(rows, columns=with_point(TABLE.columns))


def with_point(columns) -> list[str]:
    """Columns of a table with those of the points after the dataset."""
    first, *others = columns
    return [first, *POINT, *others]


def by_point(arrays):
    """What tells a point apart, and the arrays of its runs, for each point in rising order."""
    columns = [arrays[name] for name in POINT]
    points, index = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    for number, values in enumerate(points):
        point = dict(zip(POINT, values.tolist(), strict=True))
        chosen = index == number
        runs = {name: column[chosen] for name, column in arrays.items()}
        yield point | {"n_blocks": int(point["n_blocks"])}, runs


def _row(runs, horizon) -> dict:
    lifetime, settled = runs["lifetime"], runs["settled"].astype(bool)
    exponent = survival.pool_exponents(
        runs["irregular_exponent"], runs["irregular_error"], runs["irregular_time"]
    )
    span = {"start": survival.spreading_time(exponent, horizon), "horizon": horizon}
    left = share(int(np.sum(~settled)), settled.size)
    return {
        "runs": settled.size,
        "settled": int(settled.sum()),
        "share": left.value,
        "share_lower": left.lower,
        "share_upper": left.upper,
        **span,
        **_lifetime(lifetime, settled, span),
        "exponent": exponent.value,
        "exponent_error": exponent.error,
        "exponent_runs": exponent.runs,
        "verdict": _verdict(lifetime, settled, exponent, span),
        **_most_frequent(runs),
    }


def _lifetime(lifetime, settled, span) -> dict:
    """Mean lifetime and test; empty where too few runs carry them."""
    row: dict = {"counted": 0, "ended": 0}
    try:
        mean = survival.mean_lifetime(lifetime, settled, **span)
        row |= {"counted": mean.runs, "ended": mean.ended, "lifetime": mean.mean}
        row |= {"lifetime_lower": mean.lower, "lifetime_upper": mean.upper}
        test = survival.weibull_test(lifetime, settled, **span)
        row |= {"shape": test.shape, "shape_p": test.p}
        row["exponential_p"] = survival.exponential_test(lifetime, settled, **span)
    except NotEnoughDataError:
        pass
    return row


def _verdict(lifetime, settled, exponent, span) -> str:
    """That of the lifetimes; regular too where irregular motion is too short for an exponent."""
    if settled.all() and not exponent.runs:
        return survival.REGULAR
    return survival.decide(lifetime, settled, **span)


def _most_frequent(runs) -> dict:
    first = attractors.catalogue(runs)[0]
    return {
        "attractor": first.state,
        "attractor_period": first.period_time,
        "attractor_events": first.period_events,
        "attractor_share": first.basin.value,
    }
