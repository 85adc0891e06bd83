"""What the page says on chaos, from the tables of a run."""

import numpy as np
import pandas as pd

from beltrepro.replication.studies.chaos.measure import POINT
from beltrepro.stats.motion import CHAOTIC, ERRORS, PERIODIC, QUASI_PERIODIC, TRANSIENT

_LOW = 15.0  # belt velocity up to which no orbit of continuous slip competes
_STATES = (PERIODIC, QUASI_PERIODIC, CHAOTIC, TRANSIENT)


TOLD_BY = ("motions", "mean_lifetimes", "noisy_motions")


def describe(tables: dict[str, pd.DataFrame], settings: dict) -> dict:
    """Numbers of the sentences, and rows of tables."""
    motions, lifetimes, noisy = (tables[name] for name in TOLD_BY)
    lifetimes = lifetimes.drop_duplicates(list(POINT), keep="last")  # the longest runs come last
    five, others = (lifetimes[(lifetimes["n_blocks"] == 5) == chosen] for chosen in (True, False))
    above = five["exponent"] > ERRORS * five["exponent_error"]
    sizes = [_size(n_blocks, points) for n_blocks, points in motions.groupby("n_blocks")]
    return {
        "sizes": sizes,
        "onset": _onset(sizes),
        "five": _settled(five)
        | {"points": len(five), "above": above.sum()}
        | {"open": _span(five.loc[five["settled"] < five["runs"], "belt_velocity"])},
        "five_rows": five.to_dict("records"),
        "others": {n_blocks: _settled(points) for n_blocks, points in others.groupby("n_blocks")},
        "noise": {u: _under_noise(levels) for u, levels in noisy.groupby("belt_velocity")},
        "disorder": _disorder(motions),
    }


def _size(n_blocks: int, points: pd.DataFrame) -> dict:
    """What the runs of so many blocks end in, and where the exponent is largest."""
    top = points.loc[points["exponent"].idxmax()]
    return {
        "n_blocks": n_blocks,
        "runs": points["runs"].sum(),
        "counts": [points[name].sum() for name in _STATES],
        "chaotic": points[CHAOTIC].sum(),
        "chaotic_from": _span(points.loc[points[CHAOTIC] > 0, "belt_velocity"]),
        "top": top,
        "longest_period": points["longest_period"].max(),
    }


def _onset(sizes: list[dict]) -> int | None:
    """The smallest N from which on at least half of the runs are chaotic for every larger N."""
    onset = None
    for row in reversed(sizes):
        if row["chaotic"] < 0.5 * row["runs"]:
            break
        onset = row["n_blocks"]
    return onset


def _settled(points: pd.DataFrame) -> dict:
    """How many runs settled, and how many points are of which verdict."""
    verdicts = points["verdict"].value_counts()
    return {
        "settled": points["settled"].sum(),
        "runs": points["runs"].sum(),
        "verdicts": ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items()),
    }


def _under_noise(levels: pd.DataFrame) -> dict:
    """At which noise levels the exponent is above zero, and its range."""
    above = levels["exponent"] > ERRORS * levels["error"]
    return {
        "levels": len(levels),
        "span": _span(levels["noise"]),
        "above": _span(levels.loc[above, "noise"]),
        "low": levels["exponent"].min(),
        "high": levels["exponent"].max(),
        "error": levels["error"].max(),
    }


def _disorder(motions: pd.DataFrame) -> dict | None:
    """How r of irregular runs compares with that of periodic ones, where u is low."""
    low = motions[motions["belt_velocity"] <= _LOW]
    apart = np.abs(low["r_irregular"] / low["r_periodic"] - 1).dropna()
    numbers = {"points": apart.size, "median": apart.median(), "most": apart.max()}
    return numbers | {"up_to": _LOW} if apart.size else None


def _span(values: pd.Series) -> str:
    """Numbers as short text: none, a few, or the ends of a range."""
    values = np.unique(values)
    if values.size > 4:
        return f"{values[0]:g} to {values[-1]:g}"
    return ", ".join(f"{value:g}" for value in values)
