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
    "motions": Table(uses=("motion_map",)),
    "noisy_motions": Table(uses=("noisy_motion",)),
    "mean_lifetimes": Table(uses=("survival", "survival_many", "survival_long")),
    "attractors": Table(uses=("survival", "survival_many", "survival_long")),
}

# Columns behind those of the point, of a table without rows too.
_LIFETIME = (
    *("runs", "settled", "share", "share_lower", "share_upper", "start", "horizon", "counted"),
    *("ended", "lifetime", "lifetime_lower", "lifetime_upper", "shape", "shape_p"),
    *("exponent", "exponent_error", "exponent_runs", "verdict"),
    *("attractor", "attractor_period", "attractor_events", "attractor_share"),
)
_ATTRACTOR = (
    *("runs", "number", "state", "reached", "share", "share_lower", "share_upper", "period_time"),
    *("period_events", "period_returns", "disorder_parameter", "mean_length"),
)
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
    return pd.DataFrame(rows, columns=["dataset", *POINT, *_LIFETIME])


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
    return pd.DataFrame(rows, columns=["dataset", *POINT, *_ATTRACTOR])


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
    """Mean lifetime and test; empty where too few runs carry them."""
    row: dict = {"counted": 0, "ended": 0}
    try:
        mean = survival.mean_lifetime(lifetime, settled, **span)
        row |= {"counted": mean.runs, "ended": mean.ended, "lifetime": mean.mean}
        row |= {"lifetime_lower": mean.lower, "lifetime_upper": mean.upper}
        test = survival.weibull_test(lifetime, settled, **span)
        row |= {"shape": test.shape, "shape_p": test.p}
    except NotEnoughDataError:
        pass
    return row
