"""Which starts end at small r, where orbits of small r begin and end, and what sweeps show."""

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.evidence import by_point
from beltrepro.stats.estimates import share_of

TABLES = {
    "basin_shares": Table(uses=("basins", "basins_sizes")),
    "branch_ends": Table(uses=("basins", "basins_sizes")),
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
                row |= small.named("share", "low", "high")
                row["sliding"] = float(np.mean(state == "equilibrium slip"))
                row["irregular"] = float(np.mean(state == "irregular"))
                rows.append(row | {"attractors": np.unique(arrays["attractor"][runs, start]).size})
    return pd.DataFrame(rows)


def is_small(disorder, state) -> np.ndarray:
    """Which runs end at small r; slip without any stick keeps the r that it began with."""
    return (disorder < SMALL) | (state == "equilibrium slip")


def branch_ends(data) -> pd.DataFrame:
    """A row for each branch."""
    rows = []
    for name in TABLES["branch_ends"].uses:
        arrays = data[name].arrays
        orbits = arrays["branches"]
        sizes = arrays["n_blocks"][orbits["point"]]
        for n_blocks in np.unique(sizes):
            labels = arrays["attractor"][arrays["n_blocks"] == n_blocks]
            for label in np.unique(orbits["attractor"][sizes == n_blocks]):
                one = orbits[(sizes == n_blocks) & (orbits["attractor"] == label)]
                first, last = one[0], one[-1]
                row = {"n_blocks": n_blocks, "attractor": label}
                row["period_events"] = first["period_events"]
                for side, end in (("lower", first), ("upper", last)):
                    row[side], row[f"{side}_end"] = end["belt_velocity"], str(end["end"])
                    row[f"r_{side}"] = end["disorder_parameter"]
                rows.append(row | {"starts": int(np.sum(labels == label))})
    return pd.DataFrame(rows)


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
