"""Where r falls, for each friction ratio f_s."""

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.plan.registry import Table
from beltrepro.stats import branches

TABLES = {
    "friction_falls": Table(
        title="Belt velocity at which r falls, for each friction ratio.",
        uses=("friction_ratio",),
        columns={
            "points": "points of the scan, replicates included",
            "critical": "middle of the transition region (model velocity); empty if none is found",
            "low": "lower end of its 95 % interval",
            "high": "upper end",
            "lower": "u at which the fall begins (model velocity)",
            "upper": "u at which it ends (model velocity)",
            "r_high": "plateau of r below the transition",
            "r_low": "plateau of r above it",
        },
    )
}


def friction_falls(data) -> pd.DataFrame:
    """A row for each friction ratio."""
    arrays = data["friction_ratio"].arrays
    rows = []
    for ratio in np.unique(arrays["friction_ratio"]):
        chosen = arrays["friction_ratio"] == ratio
        row = {"friction_ratio": ratio, "points": int(chosen.sum())}
        rows.append(
            row | _fall(arrays["belt_velocity"][chosen], arrays["disorder_parameter"][chosen])
        )
    return pd.DataFrame(rows)


def _fall(velocity, disorder) -> dict[str, float]:
    """Numbers of the fall; NaN where there are too few runs, or none is found."""
    names = ("lower", "upper", "r_high", "r_low")
    try:
        fall = branches.fall(velocity, disorder)
    except NotEnoughDataError:
        return dict.fromkeys(("critical", "low", "high", *names), np.nan)
    critical = fall["critical"]
    ends = {"critical": critical.value, "low": critical.low, "high": critical.high}
    return ends | {name: fall[name].value for name in names}
