"""Which starts end at small r and on which orbits, where orbits begin, what sweeps show."""

from dataclasses import replace
from math import nan

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.evidence import by_point
from beltrepro.stats import survival
from beltrepro.stats.estimates import Estimate, absent, bootstrap, share_of
from beltrepro.stats.motion import UNSETTLED
from beltrepro.stats.places import share_over

TABLES = {
    "basin_shares": Table(uses=("basins",)),
    "sweep_falls": Table(uses=("sweeps", "sweeps_fast", "sweeps_slow")),
    "birth_lines": Table(uses=("small_orbits",)),
    "fall_onsets": Table(uses=("friction_map",)),
    "fall_shares": Table(uses=("fall_orbits",)),
    "chaos_lifetimes": Table(uses=("chaos_ends", "chaos_ends_near")),
    "contraction": Table(uses=("motion_map", "survival")),
    "disturbance_shares": Table(uses=("disturbances", "disturbances_scheme")),
}
PAPER_RATIO = 0.45
SMALL = 0.05  # r between the orbits of small r, up to 0.04, and all others, from 0.07


def basin_shares(data) -> pd.DataFrame:
    """A row for each N, u and energy of the starts."""
    arrays, rows = data["basins"].arrays, []
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


# --- on which orbits runs end ---------------------------------------------------------------------

RANGE = 0.5  # of u, over which shares are means: within 0.1 they change from 0 to 1
MET = (5, 11, 23)  # slips of the orbits of small r that most runs end on
LONG = 100  # slips: longer orbits are of large r, each over little of u


def ends(arrays) -> dict[str, np.ndarray]:
    """Which runs end where, by words for it; those of small r first."""
    slips, small = arrays["period_events"], small_ends(arrays)
    where = {f"{count}": small & (slips == count) for count in MET}
    where["other of small r"] = small & ~np.isin(slips, MET)
    where["33"] = ~small & (slips == 33)
    where[f"other up to {LONG}"] = ~small & (slips > 0) & (slips <= LONG) & (slips != 33)
    where[f"more than {LONG}"] = ~small & (slips > LONG)
    return where | {"irregular": ~small & (slips == 0)}


def small_ends(arrays) -> np.ndarray:
    """Which runs end at small r."""
    return is_small(arrays["disorder_parameter"], arrays["state"].astype(str))


def fall_shares(data) -> pd.DataFrame:
    """A row for each range of u and end."""
    arrays, rows = data["fall_orbits"].arrays, []
    velocity, where = arrays["belt_velocity"], {"small r": small_ends(arrays)} | ends(arrays)
    number = np.floor(velocity / RANGE + 1e-9)
    for place in np.unique(number):
        here = number == place
        for end, runs in where.items():
            share = share_over(velocity[here], runs[here])
            row = {"begin": place * RANGE, "end": end, "runs": share.runs}
            rows.append(row | share.named("share", "low", "high"))
    return pd.DataFrame(rows)


# --- what a disturbance clears --------------------------------------------------------------------

ABOVE = 17.5, 19.5  # u: just above the fall, where half of the exact runs end at small r


def disturbed_shares(data) -> dict[tuple[str, float], Estimate]:
    """Share at small r just above the fall, for each noise: exact, and by the paper's scheme."""
    shares = {}
    for name in TABLES["disturbance_shares"].uses:
        arrays = data[name].arrays
        u, small = arrays["belt_velocity"], arrays["disorder_parameter"] < SMALL
        above = (u >= ABOVE[0]) & (u < ABOVE[1])
        for noise in np.unique(arrays["noise"][above]):
            here = above & (arrays["noise"] == noise)
            shares[name, float(noise)] = share_over(u[here], small[here])
    return shares


def disturbance_shares(data) -> pd.DataFrame:
    """A row for each noise of exact runs, and one for the paper's scheme."""
    columns = "dataset", "noise", "runs", "share", "low", "high"
    rows = [(*key, one.runs, *one.numbers) for key, one in disturbed_shares(data).items()]
    return pd.DataFrame(rows, columns=columns)


def noise_of_step(velocity: float, time_step: float) -> tuple[float, float]:
    """Noise that disturbs as a time step does: of the last block, and of those inside.

    A slip begins late by up to a step, while each spring of a block pulls by u more per unit time.
    """
    last = velocity * time_step / np.sqrt(12)
    return last, 2 * last


# --- how long motion is irregular -----------------------------------------------------------------

WIDTHS = {"chaos_ends": 0.5, "chaos_ends_near": 0.002}  # ranges of u, over which runs are counted


def chaos_lifetimes(data) -> pd.DataFrame:
    """A row for each dataset and range of u."""
    rows = []
    for name, width in WIDTHS.items():
        arrays = data[name].arrays
        settled, number = (
            arrays["settled"].astype(bool),
            np.floor(arrays["belt_velocity"] / width + 1e-6),
        )
        for place in np.unique(number):
            here = number == place
            ended = share_over(arrays["belt_velocity"][here], settled[here])
            row = {"begin": place * width, "width": width, "runs": ended.runs}
            row |= ended.named("settled", "low", "high")
            lifetime = bootstrap(np.median, [arrays["lifetime"][here]])
            row |= lifetime.named("lifetime", "lifetime_low", "lifetime_high")
            slips = arrays["period_events"][here & settled]
            rows.append(row | {"slips": np.median(slips) if slips.size else nan})
    return pd.DataFrame(rows)


# --- whether deviations shrink --------------------------------------------------------------------

FOLLOWED_AT = 30.0  # u, above the fall of five blocks, at which chains of each N were followed


def contraction(data) -> pd.DataFrame:
    """A row for each N."""
    arrays, rows = data["motion_map"].arrays, []
    irregular, followed = ends_irregular(arrays), data["survival"].arrays
    for place, runs in by_point(arrays, "n_blocks"):
        row = place | {"runs": runs.size, "irregular": irregular[runs].sum()}
        for name, column in (("exponent", "nontrivial_exponent"), ("erased", "erased")):
            spread = np.quantile(arrays[column][runs], (0.5, 0.1, 0.9))
            row |= dict(zip((name, f"{name}_low", f"{name}_high"), spread, strict=True))
        growth = arrays["nontrivial_exponent"][runs[irregular[runs]]]
        row["exponent_irregular"] = np.median(growth) if growth.size else nan
        lifetime = mean_lifetime(followed, place["n_blocks"])
        rows.append(row | lifetime.named("lifetime", "lifetime_low", "lifetime_high"))
    return pd.DataFrame(rows)


def mean_lifetime(arrays, n_blocks) -> Estimate:
    """Mean time for which so many blocks are irregular at `FOLLOWED_AT`, if any were followed."""
    here = (arrays["n_blocks"] == n_blocks) & (arrays["belt_velocity"] == FOLLOWED_AT)
    if not here.any():
        return absent()
    return survival.mean_lifetime(arrays["lifetime"][here], arrays["settled"][here].astype(bool))


def ends_irregular(arrays) -> np.ndarray:
    """Which runs are irregular to the end."""
    return np.isin(arrays["state"].astype(str), UNSETTLED)


# --- the plane of friction ratio and belt velocity ------------------------------------------------

FIRST, SECOND = 5, 11  # slips of the orbits whose births are compared with the fall
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


def births_at_paper(lines: pd.DataFrame, slips: int) -> np.ndarray:
    """Belt velocities at which the orbit of so many slips begins with the paper's constants."""
    here = np.isclose(lines["friction_ratio"], PAPER_RATIO) & ~lines["linear"]
    return lines["birth"][here & (lines["slips"] == slips)].to_numpy()


BEGUN = 1 / 4  # share at small r: orbits of large r take most runs at many u above, too


def fall_onsets(data) -> pd.DataFrame:
    """A row for each friction ratio."""
    arrays, rows = data["friction_map"].arrays, []
    for place, runs in by_point(arrays, "friction_ratio"):
        # without a stiffening of the springs r scales with what f_s leaves of the friction
        limit = SMALL * (1 - place["friction_ratio"]) / (1 - PAPER_RATIO)
        small = arrays["disorder_parameter"][runs] < limit
        first = onset(arrays["belt_velocity"][runs], small)
        rows.append(place | {"runs": first.runs} | first.named("onset", "low", "high"))
    return pd.DataFrame(rows)


def onset(velocity: np.ndarray, small: np.ndarray) -> Estimate:
    """Middle of the first range of u, 1 wide, in which a quarter of the runs or more are small."""
    number = np.floor(velocity)
    places = np.unique(number) + 0.5

    def first(*groups):
        return next(
            (u for u, runs in zip(places, groups, strict=True) if runs.mean() >= BEGUN), nan
        )

    groups = [small[number == place] for place in np.unique(number)]
    return replace(bootstrap(first, groups, grid_spacing=1.0), runs=small.size)
