"""friction_falls.csv: where r falls, for each friction ratio f_s."""

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.stats.errors import NotEnoughDataError
from beltrepro.stats.transitions import Transition, transition_region

TABLE = Table(
    title="Belt velocity at which r falls, for each friction ratio.",
    uses=("friction_ratio",),
    columns={
        "points": "points of the scan, replicates included",
        "critical": "middle of the transition region (model velocity); empty if r does not fall",
        "error": "standard error of critical",
        "lower": "u at which the fall begins (model velocity)",
        "upper": "u at which it ends (model velocity)",
        "r_high": "plateau of r below the transition",
        "r_low": "plateau of r above it",
    },
)


def derive(data) -> pd.DataFrame:
    """A row for each friction ratio."""
    arrays = data["friction_ratio"].arrays
    rows = []
    for ratio in np.unique(arrays["friction_ratio"]):
        chosen = arrays["friction_ratio"] == ratio
        fall = _fall(arrays["belt_velocity"][chosen], arrays["disorder_parameter"][chosen])
        names = ("critical", "error", "lower", "upper", "r_high", "r_low")
        row = {"friction_ratio": ratio, "points": int(chosen.sum())}
        rows.append(row | {name: getattr(fall, name, np.nan) for name in names})
    return pd.DataFrame(rows)


def _fall(velocity, disorder) -> Transition | None:
    """The transition region; None where there are too few points."""
    try:
        return transition_region(velocity, disorder)
    except NotEnoughDataError:
        return None
