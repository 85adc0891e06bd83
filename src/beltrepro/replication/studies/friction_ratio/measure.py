"""Where r falls, for each friction ratio f_s."""

from pathlib import Path

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.model.parameters import ChainParameters
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.points import by_point
from beltrepro.stats import branches

TABLES = {
    "friction_falls": Table(uses=("friction_ratio",)),
    "scaled_falls": Table(uses=()),
}


def friction_falls(data) -> pd.DataFrame:
    """A row for each friction ratio."""
    arrays = data["friction_ratio"].arrays
    rows = []
    for place, runs in by_point(arrays, "friction_ratio"):
        curve = (arrays[name][runs] for name in ("belt_velocity", "disorder_parameter"))
        rows.append(place | {"points": runs.size} | _fall(*curve))
    return pd.DataFrame(rows)


def scaled_falls(data) -> pd.DataFrame:
    """A row for each kind of springs and friction ratio, in units of the force that is left."""
    rows = pd.read_csv(Path(__file__).with_name("falls.csv"))
    names = [f"{name}{end}" for name in ("begin", "critical") for end in ("", "_low", "_high")]
    force = (1 - rows["friction_ratio"]) * ChainParameters(5, 1.0).static_friction
    rows[names] = rows[names].div(force, axis=0)
    return rows[["springs", "friction_ratio", "runs", *names]]


def _fall(velocity, disorder) -> dict[str, float]:
    """Numbers of the fall; NaN where there are too few runs, or none is found."""
    names = ("lower", "upper", "r_high", "r_low")
    try:
        fall = branches.fall(velocity, disorder)
    except NotEnoughDataError:
        return dict.fromkeys(("critical", "low", "high", *names), np.nan)
    critical = fall["critical"].named("critical", "low", "high")
    return critical | {name: fall[name].value for name in names}
