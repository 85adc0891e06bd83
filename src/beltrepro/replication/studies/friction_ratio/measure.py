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
    ),
    "scaled_falls": Table(
        title="Where r of five blocks falls without noise, for linear springs and the paper's.",
        uses=(),
        columns={
            "runs": "runs, at 41 belt velocities from starts at rest",
            "begin": "u over (1 - f_s) F_st0 at which half of the runs first have less than half "
            "the fluctuation of slow belts; empty if they have at none up to 0.92",
            "begin_low": "lower end of its 95 % interval, with the spacing of u",
            "begin_high": "upper end; inf if it may lie beyond",
            "critical": "likewise the middle of the fall; empty if none is found",
            "critical_low": "lower end of its 95 % interval",
            "critical_high": "upper end",
        },
    ),
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
    names = list(TABLES["scaled_falls"].columns)[1:]
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
