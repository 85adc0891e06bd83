"""motions.csv: which motions runs end in, and their largest exponent, for each N and u."""

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.stats.motion import CHAOTIC, MOTIONS, PERIODIC, TRANSIENT

TABLE = Table(
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
)


_READ = (
    "n_blocks",
    "belt_velocity",
    "state",
    "period_events",
    "largest_exponent",
    "disorder_parameter",
)


def derive(data) -> pd.DataFrame:
    """A row for each number of blocks and belt velocity."""
    arrays = data["motion_map"].arrays
    names = (
        "n_blocks",
        "belt_velocity",
        "state",
        "largest_exponent",
        "period_events",
        "disorder_parameter",
    )
    runs = pd.DataFrame({name: arrays[name] for name in names})
    rows = [
        {"n_blocks": n_blocks, "belt_velocity": velocity} | _row(own)
        for (n_blocks, velocity), own in runs.groupby(["n_blocks", "belt_velocity"])
    ]
    return pd.DataFrame(rows)


def _row(own: pd.DataFrame) -> dict:
    """What the runs of one point say together."""
    states, disorder = own["state"].astype(str), own["disorder_parameter"]
    return {
        "runs": len(own),
        **{name: int((states == name).sum()) for name in MOTIONS},
        "exponent": own["largest_exponent"].mean(),
        "error": own["largest_exponent"].std(ddof=1) / np.sqrt(len(own)),
        "longest_period": int(own["period_events"].max()),
        "r_periodic": disorder[states == PERIODIC].mean(),
        "r_irregular": disorder[states.isin([CHAOTIC, TRANSIENT])].mean(),
    }
