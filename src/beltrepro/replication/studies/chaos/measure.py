"""Numbers on irregular and periodic motion: where runs end, for how long they are irregular."""

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.chaos import orbits
from beltrepro.replication.studies.points import by_point
from beltrepro.stats import sections, survival
from beltrepro.stats.estimates import share_of
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
    rows = []
    for place, runs in by_point(arrays, "n_blocks", "belt_velocity"):
        state, disorder = arrays["state"][runs].astype(str), arrays["disorder_parameter"][runs]
        counts = {name: int(np.sum(state == name)) for name in MOTIONS}
        row = place | {"runs": runs.size} | counts | _exponent(arrays["largest_exponent"][runs])
        row["longest_period"] = int(arrays["period_events"][runs].max())
        row["r_periodic"] = pd.Series(disorder[state == PERIODIC]).mean()
        row["r_irregular"] = pd.Series(disorder[np.isin(state, (CHAOTIC, TRANSIENT))]).mean()
        rows.append(row)
    return pd.DataFrame(rows)


def noisy_motions(data) -> pd.DataFrame:
    """A row for each belt velocity and noise."""
    arrays = data["noisy_motion"].arrays
    rows = []
    for place, runs in by_point(arrays, "belt_velocity", "noise"):
        row = place | {"runs": runs.size} | _exponent(arrays["largest_exponent"][runs])
        rows.append(row | {"r": pd.Series(arrays["disorder_parameter"][runs]).mean()})
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
    return pd.DataFrame(rows, columns=_columns("mean_lifetimes"))


def attractors(data) -> pd.DataFrame:
    """A row for each attractor at each point of each dataset."""
    rows = []
    for name in TABLES["attractors"].uses:
        for point, runs in by_point(data[name].arrays, *POINT):
            reached = orbits.catalogue(sections.select(data[name].arrays, runs))
            for number, attractor in enumerate(reached, start=1):
                row = vars(attractor) | attractor.basin.named(*_SHARE) | point
                row |= {"dataset": name, "number": number, "reached": attractor.runs}
                rows.append(row | {"runs": runs.size})
    return pd.DataFrame(rows, columns=_columns("attractors"))


def _columns(table: str) -> list[str]:
    """Columns of a table with those of the points after the dataset."""
    first, *others = TABLES[table].columns
    return [first, *POINT, *others]


def _lasting(runs, horizon) -> dict:
    """The lifetimes of the runs of one point, their exponent, and where most of them end."""
    lifetime, settled = runs["lifetime"], runs["settled"].astype(bool)
    irregular = (runs[f"irregular_{name}"] for name in ("exponent", "error", "time"))
    exponent = survival.pool_exponents(*irregular)
    span = {"start": survival.spreading_time(exponent, horizon), "horizon": horizon}
    row = {"runs": settled.size, "settled": int(settled.sum())}
    row |= share_of(~settled).named(*_SHARE) | span | _lifetime(lifetime, settled, span)
    row |= {"exponent": exponent.value, "exponent_error": exponent.error}
    row |= {"exponent_runs": exponent.runs}
    # regular too where irregular motion is too short for an exponent
    regular = settled.all() and not exponent.runs
    row["verdict"] = survival.REGULAR if regular else survival.decide(lifetime, settled, **span)
    first = orbits.catalogue(runs)[0]
    row |= {"attractor": first.state, "attractor_period": first.period_time}
    row |= {"attractor_events": first.period_events, "attractor_share": first.basin.value}
    return row


def _lifetime(lifetime, settled, span) -> dict:
    """Mean lifetime and tests; empty where too few runs carry them."""
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
