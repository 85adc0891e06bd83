"""Which starts end at small r, where orbits begin and end, what sweeps show, at any friction."""

import numpy as np
import pandas as pd
from scipy.special import xlogy

from beltrepro.base.errors import require
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.evidence import by_point
from beltrepro.stats.estimates import Estimate, share_of

TABLES = {
    "basin_shares": Table(uses=("basins", "basins_sizes")),
    "sweep_falls": Table(uses=("sweeps", "sweeps_fast", "sweeps_slow")),
    "birth_lines": Table(uses=("small_orbits",)),
    "fall_onsets": Table(uses=("friction_map",)),
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


# --- the plane of friction ratio and belt velocity ------------------------------------------------

FIRST = 5  # slips of the orbit whose birth is compared with the fall
_LINEAR = 1e3  # limit of linear springs: from here on no spring gets there


def birth_lines(data) -> pd.DataFrame:
    """A row for each kind of springs, orbit and friction ratio."""
    arrays = data["small_orbits"].arrays
    births = np.sort(arrays["births"], order=["point", "period_events", "friction_ratio"])
    births = births[births["end"] != "edge"]
    limit, static = (arrays[name][births["point"]] for name in ("linear_limit", "static_friction"))
    ratio, u = births["friction_ratio"], births["belt_velocity"]
    table = {"linear": limit >= _LINEAR, "slips": births["period_events"], "friction_ratio": ratio}
    table |= {"birth": u, "scaled": u / ((1 - ratio) * static)}
    names = "disorder_parameter", "largest_multiplier", "end", "end_block"
    return pd.DataFrame(table | {name: births[name] for name in names})


def fall_onsets(data) -> pd.DataFrame:
    """A row for each friction ratio."""
    arrays, rows = data["friction_map"].arrays, []
    for place, runs in by_point(arrays, "friction_ratio"):
        small = arrays["disorder_parameter"][runs] < SMALL
        if small.any() and not small.all():
            found = onset(arrays["belt_velocity"][runs], small)
            rows.append(place | {"runs": found.runs} | found.named("onset", "low", "high"))
    return pd.DataFrame(rows, columns=["friction_ratio", "runs", "onset", "low", "high"])


def onset(velocity: np.ndarray, small: np.ndarray) -> Estimate:
    """u from which on more runs are small: the place that parts two shares most likely.

    The interval has all places that are at least exp(-1.92) as likely.
    """
    places, index = np.unique(velocity, return_inverse=True)
    require(places.size >= 3, f"{places.size} belt velocities, not 3")
    below, runs_below = (np.bincount(index, weights).cumsum() for weights in (small, None))
    likelihood = np.zeros(places.size - 1)
    shares = []
    for k, n in ((below, runs_below), (below[-1] - below, runs_below[-1] - runs_below)):
        k, n = k[:-1], n[:-1]
        likelihood += xlogy(k, k / n) + xlogy(n - k, 1 - k / n)
        shares.append(k / n)
    likelihood[shares[0] >= shares[1]] = -np.inf
    best = int(np.argmax(likelihood))
    good = np.flatnonzero(likelihood > likelihood[best] - 1.92)
    middle = (places[best] + places[best + 1]) / 2
    return Estimate(middle, places[good[0]], places[good[-1] + 1], len(small))
