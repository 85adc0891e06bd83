"""What disturbance loses an orbit, and how the lifetime of irregular motion grows with N."""

from pathlib import Path

import numpy as np
import pandas as pd
import scipy

from beltrepro.model.scheme_error import equivalent_kick
from beltrepro.replication.plan.registry import Table
from beltrepro.stats import estimates, fits, survival

TABLES = {
    "orbits_lost": Table(uses=()),
    "loss_lines": Table(uses=("orbits_lost",)),
    "lifetime_laws": Table(uses=()),
    "lifetime_growth": Table(uses=()),
    "lifetime_rates": Table(uses=("lifetime_growth",)),
}

POINT = ["n_blocks", "belt_velocity"]
FEWEST_FOR_A_LAW = 100


def _ends(name: str) -> list[str]:
    """Columns of an estimate and of its interval."""
    return [name, f"{name}_low", f"{name}_high"]


def _published(name: str) -> pd.DataFrame:
    """Rows of a table that `runs` has made."""
    return pd.read_csv(Path(__file__).with_name(f"{name}.csv"))


# --- orbits and their disturbance -----------------------------------------------------------------


def orbits_lost(data) -> pd.DataFrame:
    """A row for each orbit."""
    rows = _published("orbits_lost")
    for size, step in zip(_ends("step"), _ends("time_step"), strict=True):
        rows[size] = equivalent_kick(rows["belt_velocity"], rows[step])
    disturbed = [column for name in ("kick", "step", "noise") for column in _ends(name)]
    measured = ["slips", "period_time", "multiplier", "margin", "scatter"]
    return rows[[*POINT, "starts", "ended", "scheme", *measured, *disturbed, "noise_as_kick"]]


def loss_lines(data) -> pd.DataFrame:
    """A row for each disturbance."""
    orbits = data["orbits_lost"]
    sizes = {name: orbits[name] for name in ("kick", "step", "noise")}
    sizes["noise as kick"] = orbits["noise"] * orbits["noise_as_kick"]
    return pd.DataFrame([{"disturbance": name} | _line(orbits, sizes[name]) for name in sizes])


def _line(orbits: pd.DataFrame, size: pd.Series) -> dict:
    """The size as a power and as a share of the margin, and what is left by others."""
    usable = np.isfinite(size) & (size > 0) & np.isfinite(orbits["margin"])
    size, orbits = size[usable], orbits[usable]
    law = fits.fit_log_log(orbits["margin"], size, low=0, high=np.inf)
    reach = scipy.stats.t.ppf(0.975, len(size) - 2) * law.exponent_error
    share = estimates.exponential(estimates.mean(np.log(size / orbits["margin"])))
    row = {"orbits": len(size), "power": law.exponent}
    row |= {"power_low": law.exponent - reach, "power_high": law.exponent + reach}
    row |= share.named(*_ends("share"))
    row["spread"] = np.exp(np.log(size / orbits["margin"]).std(ddof=1))
    for name in ("slips", "scatter"):
        other = fits.fit_log_log(orbits[name], size, low=0, high=np.inf)
        row[f"spread_by_{name}"] = np.exp(np.log(size / other(orbits[name])).std(ddof=2))
    return row


# --- lifetimes ------------------------------------------------------------------------------------


def lifetime_laws(data) -> pd.DataFrame:
    """A row for each point with enough runs to tell a law."""
    rows = []
    for point, runs in _published("irregular_lifetimes").groupby(POINT):
        if len(runs) < FEWEST_FOR_A_LAW:
            continue
        lifetime, ended = runs["lifetime"].to_numpy(), runs["settled"].to_numpy()
        laws = survival.compare_laws(lifetime, ended)
        shape = estimates.bootstrap(_shape, [np.column_stack([lifetime, ended])], resamples=400)
        row = dict(zip(POINT, point, strict=True)) | {"runs": len(runs), "ended": ended.sum()}
        row |= {"mean": survival.mean_lifetime(lifetime, ended).mean}
        row |= shape.named(*_ends("shape")) | {"best": min(laws, key=lambda law: laws[law])}
        rows.append(row | {f"aic_{law}": excess for law, excess in laws.items()})
    return pd.DataFrame(rows)


def _shape(runs: np.ndarray) -> float:
    return survival.weibull_test(runs[:, 0], runs[:, 1].astype(bool)).shape


def lifetime_growth(data) -> pd.DataFrame:
    """A row for each point."""
    rows = []
    for point, runs in _published("irregular_lifetimes").groupby(POINT):
        horizon = survival.SEEN * float(runs["duration"].iloc[0])
        irregular = (runs[f"irregular_{name}"].to_numpy() for name in ("exponent", "error", "time"))
        exponent = survival.pool_exponents(*irregular)
        start = survival.spreading_time(exponent, horizon)
        lasting = survival.mean_lifetime(
            runs["lifetime"], runs["settled"], start=start, horizon=horizon
        )
        row = dict(zip(POINT, point, strict=True)) | {"runs": len(runs), "start": start}
        row |= {"counted": lasting.runs, "ended": lasting.ended, "time": lasting.time}
        mean = lasting.mean, lasting.lower, lasting.upper
        row |= dict(zip(_ends("lifetime"), mean, strict=True))
        row |= {"exponent": exponent.value, "exponent_error": exponent.error}
        rows.append(row | {"exponent_runs": exponent.runs})
    return pd.DataFrame(rows)


def lifetime_rates(data) -> pd.DataFrame:
    """A row for each belt velocity with three numbers of blocks whose motion ends."""
    rows = []
    for velocity, points in data["lifetime_growth"].groupby("belt_velocity"):
        ending = points[points["ended"] > 0]
        if len(ending) < 3:
            continue
        logs = [estimates.Estimate(*row) for row in np.log(ending[_ends("lifetime")]).to_numpy()]
        rate = estimates.slope(ending["n_blocks"].to_numpy(), logs)
        row = {"belt_velocity": velocity, "sizes": len(ending)}
        rows.append(row | rate.named(*_ends("rate")))
    return pd.DataFrame(rows)
