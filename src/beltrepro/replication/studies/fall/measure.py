"""Which starts end at small r, where orbits of small r begin and end, and what sweeps show."""

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.evidence import by_point
from beltrepro.stats.estimates import share_of

TABLES = {
    "basin_shares": Table(uses=("basins", "basins_sizes")),
    "sweep_falls": Table(uses=("sweeps", "sweeps_fast", "sweeps_slow")),
}
SMALL = 0.05  # r between the orbits of small r, up to 0.04, and all others, from 0.07


def basin_shares(data) -> pd.DataFrame:
    """A row for each N, u and energy of the starts."""
    rows = []
    for name in TABLES["basin_shares"].uses:
        arrays = data[name].arrays
        for place, runs in by_point(arrays, "n_blocks", "belt_velocity"):
            for start, energy in enumerate(arrays["start_energy"]):
                state = arrays["state"][runs, start].astype(str)
                small = share_of(is_small(arrays["disorder_parameter"][runs, start], state))
                row = place | {"start_energy": energy, "runs": small.runs}
                rows.append(row | small.named("share", "low", "high"))
    return pd.DataFrame(rows)


def is_small(disorder, state) -> np.ndarray:
    """Which runs end at small r; slip without any stick keeps the r that it began with."""
    return (disorder < SMALL) | (state == "equilibrium slip")


def sweep_falls(data) -> pd.DataFrame:
    """A row for each hold, noise, way and u."""
    rows = []
    for name in TABLES["sweep_falls"].uses:
        arrays, hold = data[name].arrays, data[name].attributes["duration"]
        for place, runs in by_point(arrays, "noise", "belt_velocity"):
            for number, way in enumerate(("up", "down")):
                small = share_of(arrays["disorder_parameter"][runs, number] < SMALL)
                row = {"hold": hold, **place, "way": way, "runs": small.runs}
                rows.append(row | small.named("share", "low", "high"))
    return pd.DataFrame(rows)
