"""alternation.csv: at which belt velocities trials show both regimes."""

import numpy as np
import pandas as pd

from beltrepro.model import units
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.experiment import trials
from beltrepro.stats.shares import share

TABLE = Table(
    title="How many trials show both regimes, at each noise, friction ratio and belt velocity.",
    uses=("trials_free",),
    columns={
        "runs": "trials",
        "alternating": "trials with both regimes, each for 15.3 s or more",
        "share": "share of the trials that alternate",
        "share_lower": "lower end of its interval (Clopper and Pearson, 95 %)",
        "share_upper": "upper end",
        "lasting_share": "mean share of the time in small amplitudes that last",
        "all_slip_longest_s": "longest time in any trial in which no block sticks (s)",
        "all_slip": "trials in which no block sticks for a minute",
        "r": "disorder parameter, median over the trials",
    },
)

_POINT = ["noise", "friction_ratio", "belt_velocity"]


def derive(data) -> pd.DataFrame:
    """A row for each noise, friction ratio and belt velocity."""
    arrays = data["trials_free"].arrays
    names = (*_POINT, "lasting_share", "disorder_parameter")
    runs = pd.DataFrame({name: arrays[name] for name in names})
    runs["alternates"] = trials.alternates(arrays)
    runs["all_slip_longest_s"] = units.to_si(arrays["all_slip_longest"], "time")
    runs["all_slip"] = runs["all_slip_longest_s"] >= trials.EXPERIMENT[0].lasting_s
    grouped = runs.groupby(_POINT)
    found = pd.DataFrame({"runs": grouped.size(), "alternating": grouped["alternates"].sum()})
    shares = [share(*counts) for counts in found[["alternating", "runs"]].to_numpy()]
    found[["share", "share_lower", "share_upper"]] = np.reshape(shares, (-1, 3))
    found["lasting_share"] = grouped["lasting_share"].mean()
    found["all_slip_longest_s"] = grouped["all_slip_longest_s"].max()
    found["all_slip"] = grouped["all_slip"].sum()
    found["r"] = grouped["disorder_parameter"].median()
    return found.reset_index()
