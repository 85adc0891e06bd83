"""Numbers on irregular and periodic motion: where runs end, for how long they are irregular."""

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.chaos import orbits
from beltrepro.stats import survival
from beltrepro.stats.estimates import share
from beltrepro.stats.motion import CHAOTIC, MOTIONS, PERIODIC, TRANSIENT

TABLES = {
    "motions": Table(
        title="Motions that runs end in, and largest Lyapunov exponents, for each N and u.",
        uses=("motion_map",),
        columns={
            "runs": "runs from different starts",
            "equilibrium slip": "of them, those that end in it; likewise the other motions",
            "exponent": "largest Lyapunov exponent, mean over the runs (per model time)",
            "error": "standard error of the mean, from the scatter of the runs",
            "longest_period": "slips of all blocks in the longest period found; 0 if none",
            "r_periodic": "r of the runs that end periodic, mean; empty if none does",
            "r_irregular": "r of the runs that are chaotic or transient, mean; empty if none is",
        },
    ),
    "noisy_motions": Table(
        title="Largest Lyapunov exponents under noise, and r, for each u and noise.",
        uses=("noisy_motion",),
        columns={
            "runs": "runs with different starts and noise",
            "exponent": "largest Lyapunov exponent, mean over the runs (per model time)",
            "error": "standard error of the mean, from the scatter of the runs",
            "r": "disorder parameter, mean over the runs",
        },
    ),
    "mean_lifetimes": Table(
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
    ),
    "attractors": Table(
        title="Attractors that runs from different starts end on, with their share of the starts.",
        uses=("survival", "survival_many", "survival_long"),
        columns={
            "dataset": "of the runs: survival, survival_many or survival_long",
            "runs": "runs at this point",
            "number": "of the attractor, the most frequent first",
            "state": "periodic, equilibrium slip, or irregular when the run was given up",
            "reached": "runs that ended on it",
            "share": "share of the runs",
            "share_lower": "lower end of the interval of the share (Clopper and Pearson, 95 %)",
            "share_upper": "upper end",
            "period_time": "length of a period (model time); empty if not periodic",
            "period_events": "slips of all blocks in a period; 0 if not periodic",
            "period_returns": "returns to the section in a period; 0 if not periodic",
            "disorder_parameter": "r on it (model length), median",
            "mean_length": "mean of x_N on it (model length), median",
        },
    ),
}

POINT = ("n_blocks", "belt_velocity", "initial_spread")
"""What tells the points of a dataset apart; runs that differ in the replicate share a row."""

_SHARE = ("share", "share_lower", "share_upper")


# --- runs of a given length -----------------------------------------------------------------------


def motions(data) -> pd.DataFrame:
    """A row for each number of blocks and belt velocity."""
    arrays = data["motion_map"].arrays
    names = ("state", "largest_exponent", "period_events", "disorder_parameter")
    place = ["n_blocks", "belt_velocity"]
    runs = pd.DataFrame({name: arrays[name] for name in (*place, *names)})
    return pd.DataFrame(
        [
            dict(zip(place, point, strict=True)) | _end_together(at_point)
            for point, at_point in runs.groupby(place)
        ]
    )


def _end_together(runs: pd.DataFrame) -> dict:
    """What the runs of one point say together."""
    states, disorder = runs["state"].astype(str), runs["disorder_parameter"]
    return {
        "runs": len(runs),
        **{name: int((states == name).sum()) for name in MOTIONS},
        "exponent": runs["largest_exponent"].mean(),
        "error": runs["largest_exponent"].std(ddof=1) / np.sqrt(len(runs)),
        "longest_period": int(runs["period_events"].max()),
        "r_periodic": disorder[states == PERIODIC].mean(),
        "r_irregular": disorder[states.isin([CHAOTIC, TRANSIENT])].mean(),
    }


def noisy_motions(data) -> pd.DataFrame:
    """A row for each belt velocity and noise."""
    arrays = data["noisy_motion"].arrays
    names = ("belt_velocity", "noise", "largest_exponent", "disorder_parameter")
    grouped = pd.DataFrame({name: arrays[name] for name in names}).groupby(list(names[:2]))
    exponent = grouped["largest_exponent"]
    return pd.DataFrame(
        {
            "runs": grouped.size(),
            "exponent": exponent.mean(),
            "error": exponent.std(ddof=1) / np.sqrt(grouped.size()),
            "r": grouped["disorder_parameter"].mean(),
        }
    ).reset_index()


# --- runs that are followed until they settle -----------------------------------------------------


def mean_lifetimes(data) -> pd.DataFrame:
    """A row for each dataset, N, u and initial spread."""
    rows = []
    for name in TABLES["mean_lifetimes"].uses:
        horizon = survival.SEEN * float(data[name].attributes["duration"])
        for point, runs in by_point(data[name].arrays):
            rows.append({"dataset": name} | point | _lasting(runs, horizon))
    return pd.DataFrame(rows, columns=_columns("mean_lifetimes"))


def attractors(data) -> pd.DataFrame:
    """A row for each attractor at each point of each dataset."""
    rows = []
    for name in TABLES["attractors"].uses:
        for point, runs in by_point(data[name].arrays):
            count = {"runs": runs["state"].size}
            for number, attractor in enumerate(orbits.catalogue(runs), start=1):
                row = {"dataset": name, "number": number, "reached": attractor.runs} | point
                row |= dict(zip(_SHARE, attractor.basin.numbers, strict=True))
                rows.append(vars(attractor) | row | count)
    return pd.DataFrame(rows, columns=_columns("attractors"))


def _columns(table: str) -> list[str]:
    """Columns of a table with those of the points after the dataset."""
    first, *others = TABLES[table].columns
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


def _lasting(runs, horizon) -> dict:
    lifetime, settled = runs["lifetime"], runs["settled"].astype(bool)
    exponent = survival.pool_exponents(
        runs["irregular_exponent"], runs["irregular_error"], runs["irregular_time"]
    )
    span = {"start": survival.spreading_time(exponent, horizon), "horizon": horizon}
    left = share(int(np.sum(~settled)), settled.size)
    return {
        "runs": settled.size,
        "settled": int(settled.sum()),
        **dict(zip(_SHARE, left.numbers, strict=True)),
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
    first = orbits.catalogue(runs)[0]
    return {
        "attractor": first.state,
        "attractor_period": first.period_time,
        "attractor_events": first.period_events,
        "attractor_share": first.basin.value,
    }
