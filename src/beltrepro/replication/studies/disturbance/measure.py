"""What disturbance loses an orbit, and how the lifetime of irregular motion grows with N."""

from pathlib import Path

import numpy as np
import pandas as pd
import scipy

from beltrepro.model.scheme_error import equivalent_kick
from beltrepro.replication.plan.registry import Table
from beltrepro.stats import estimates, fits, survival

TABLES = {
    "orbits_lost": Table(
        title="Periodic orbits, and the disturbance of each slip beyond which they are lost.",
        uses=(),
        columns={
            "starts": "random starts at this point",
            "ended": "of them, those that end on this orbit by exact motion",
            "scheme": "and by the paper's scheme with its time step of 0.001",
            "slips": "of all blocks in a period",
            "period_time": "length of a period (model time)",
            "multiplier": "modulus of the largest multiplier besides the trivial one",
            "margin": "smallest displacement at one start of a slip that loses the orbit",
            "scatter": "distance from the orbit at returns, rms, over the size of small kicks",
            "kick": "size of kicks that lose it within 10000 in half of the runs (model length)",
            "kick_low": "largest size below which no run leaves",
            "kick_high": "smallest size from which on all leave",
            "step": "the same for u dt / sqrt(3) of the scheme; 0 if lost at all dt from 0.0001 on",
            "step_low": "as kick_low",
            "step_high": "as kick_high",
            "noise": "the same for sigma; inf if kept up to 5",
            "noise_low": "as kick_low",
            "noise_high": "as kick_high",
            "noise_as_kick": "kicks that move slips as much as sigma = 1 does, by the pull's rate",
        },
    ),
    "loss_lines": Table(
        title="Whether the size that loses an orbit is a share of its margin.",
        uses=("orbits_lost",),
        columns={
            "disturbance": "kick, step, noise, or noise as the kicks that move slips as much",
            "orbits": "orbits with a size of both kinds",
            "power": "of the margin that the size grows with",
            "power_low": "lower end of its 95 % interval",
            "power_high": "upper end",
            "share": "size over margin, geometric mean",
            "share_low": "lower end of its 95 % interval",
            "share_high": "upper end",
            "spread": "factor by which one orbit differs from this share, one standard deviation",
            "spread_by_slips": "likewise from the best power of the number of slips",
            "spread_by_scatter": "likewise from the best power of the scatter",
        },
    ),
    "lifetime_laws": Table(
        title="Laws of lifetimes of irregular motion, compared by likelihood.",
        uses=(),
        columns={
            "runs": "runs from different starts",
            "ended": "of them, those whose motion settled",
            "mean": "mean lifetime (model time)",
            "shape": "of the Weibull distribution: above 1 if the rate of ends rises with time",
            "shape_low": "lower end of its 95 % interval",
            "shape_high": "upper end",
            "best": "law with the least AIC",
            "aic_exponential": "of Akaike above the best; 2 or less does not tell laws apart",
            "aic_weibull": "likewise",
            "aic_gamma": "likewise",
            "aic_lognormal": "likewise",
            "aic_inverse_gaussian": "likewise",
        },
    ),
    "lifetime_growth": Table(
        title="Mean lifetime and exponent of irregular motion for each N and u.",
        uses=(),
        columns={
            "runs": "runs from different starts",
            "start": "time from which lifetimes count (model time): five e-foldings",
            "counted": "runs that are irregular then",
            "ended": "of these, those that ended in the first half of the time they were followed",
            "time": "time under observation (model time), all runs together",
            "lifetime": "mean lifetime (model time); inf if none ended",
            "lifetime_low": "lower end of its interval (chi-square, 95 %)",
            "lifetime_high": "upper end; inf if none ended",
            "exponent": "largest exponent of the irregular motion (1 / model time)",
            "exponent_error": "its standard error, from the scatter of the runs",
            "exponent_runs": "runs with an exponent",
        },
    ),
    "lifetime_rates": Table(
        title="By what factor a block more lengthens irregular motion, at each u.",
        uses=("lifetime_growth",),
        columns={
            "sizes": "numbers of blocks of which some runs ended",
            "rate": "c of a lifetime that grows as exp(c N)",
            "rate_low": "lower end of its 95 % interval, widened by the scatter about the line",
            "rate_high": "upper end",
        },
    ),
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
    return rows[[*POINT, *TABLES["orbits_lost"].columns]]


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
