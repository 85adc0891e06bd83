"""attractors.csv: the attractors that runs end on, at every point."""

import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.chaos import orbits as attractors
from beltrepro.replication.studies.chaos.mean_lifetimes import by_point, with_point

TABLE = Table(
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
)

_OF_ATTRACTOR = (
    "state",
    "period_time",
    "period_events",
    "period_returns",
    "disorder_parameter",
    "mean_length",
)


def derive(data) -> pd.DataFrame:
    """A row for each attractor at each point of each dataset."""
    rows = []
    for name in TABLE.uses:
        for point, runs in by_point(data[name].arrays):
            for number, each in enumerate(attractors.catalogue(runs), start=1):
                row = {"runs": runs["state"].size, "number": number, "reached": each.runs}
                basin = {"share": each.basin.value}
                basin |= {"share_lower": each.basin.lower, "share_upper": each.basin.upper}
                known = {field: getattr(each, field) for field in _OF_ATTRACTOR}
                rows.append({"dataset": name} | point | row | basin | known)
    return pd.DataFrame(rows, columns=with_point(TABLE.columns))
