"""What the page says on chaos, from the tables of a run."""

import numpy as np
import pandas as pd

from beltrepro.stats.motion import CHAOTIC, PERIODIC, QUASI_PERIODIC, TRANSIENT

_POINT = ("n_blocks", "belt_velocity", "initial_spread")
_ERRORS = 3.0  # standard errors by which an exponent must be above zero
_LOW = 15.0  # belt velocity up to which no orbit of continuous slip competes
_STATES = (PERIODIC, QUASI_PERIODIC, CHAOTIC, TRANSIENT)


TOLD_BY = ("motions", "mean_lifetimes", "noisy_motions")


def describe(tables: dict[str, pd.DataFrame], settings: dict) -> dict:
    """Numbers of the sentences, and rows of tables, as text."""
    motions, lifetimes, noisy = (tables[name] for name in TOLD_BY)
    lifetimes = lifetimes.drop_duplicates(list(_POINT), keep="last")  # the longest runs come last
    sizes = [_size(n_blocks, runs) for n_blocks, runs in motions.groupby("n_blocks")]
    five = lifetimes[lifetimes["n_blocks"] == 5]
    return {
        "sizes": sizes,
        "onset": _onset(sizes),
        "regular": [row["n_blocks"] for row in sizes if not row["chaotic"]],
        "five": _five(five),
        "five_rows": [_lifetime(row) for row in five.to_dict("records")],
        "others": _others(lifetimes[lifetimes["n_blocks"] != 5]),
        "noise": _noise(noisy),
        "disorder": _disorder(motions),
    }


def _size(n_blocks: int, points: pd.DataFrame) -> dict:
    """What the runs of so many blocks end in, and where the exponent is largest."""
    top = points.loc[points["exponent"].idxmax()]
    chaotic = points.loc[points[CHAOTIC] > 0, "belt_velocity"]
    return {
        "n_blocks": n_blocks,
        "runs": int(points["runs"].sum()),
        "counts": [int(points[name].sum()) for name in _STATES],
        "chaotic": int(points[CHAOTIC].sum()),
        "chaotic_from": _span(chaotic),
        "exponent": f"{top['exponent']:.2g}",
        "error": _number(top["error"], ".1g"),
        "at": f"{top['belt_velocity']:g}",
        "longest_period": int(points["longest_period"].max()),
    }


def _onset(sizes: list[dict]) -> int | None:
    """The smallest N from which on at least half of the runs are chaotic for every larger N."""
    onset = None
    for row in reversed(sizes):
        if row["chaotic"] < 0.5 * row["runs"]:
            break
        onset = row["n_blocks"]
    return onset


def _five(five: pd.DataFrame) -> dict:
    """Numbers of five blocks in one place."""
    settled = five["settled"].sum() / five["runs"].sum()
    above = five["exponent"] > _ERRORS * five["exponent_error"]
    open_points = five.loc[five["settled"] < five["runs"], "belt_velocity"]
    return {
        "runs": int(five["runs"].sum()),
        "settled": int(five["settled"].sum()),
        "share": f"{settled:.0%}",
        "points": len(five),
        "above": int(above.sum()),
        "open": _span(open_points),
        "verdicts": _counts(five["verdict"]),
    }


def _lifetime(row: dict) -> dict:
    """One point of the table of lifetimes, as text."""
    ends = f"{row['lifetime_lower']:.3g} to {row['lifetime_upper']:.3g}"
    return {
        "u": f"{row['belt_velocity']:g}",
        "spread": f"{row['initial_spread']:g}",
        "settled": f"{row['settled']} of {row['runs']}",
        "lifetime": _number(row["lifetime"]),
        "interval": "" if np.isnan(row["lifetime"]) else ends,
        "exponent": _number(row["exponent"]),
        "error": _number(row["exponent_error"], ".1g"),
        "verdict": row["verdict"],
        "attractor": row["attractor"],
        "events": row["attractor_events"] or "",
    }


def _others(lifetimes: pd.DataFrame) -> list[dict]:
    """For each other N: how many points are of which verdict, and the runs that settled."""
    return [
        {
            "n_blocks": n_blocks,
            "settled": f"{points['settled'].sum()} of {points['runs'].sum()}",
            "verdicts": ", ".join(_counts(points["verdict"])),
        }
        for n_blocks, points in lifetimes.groupby("n_blocks")
    ]


def _noise(noisy: pd.DataFrame) -> list[dict]:
    """For each belt velocity: at which noise levels the exponent is above zero, and its range."""
    rows = []
    for velocity, levels in noisy.groupby("belt_velocity"):
        above = levels["exponent"] > _ERRORS * levels["error"]
        rows.append(
            {
                "u": f"{velocity:g}",
                "levels": len(levels),
                "span": _span(levels["noise"]),
                "above": _span(levels.loc[above, "noise"]),
                "low": f"{levels['exponent'].min():.2g}",
                "high": f"{levels['exponent'].max():.2g}",
                "error": f"{levels['error'].max():.1g}",
            }
        )
    return rows


def _disorder(motions: pd.DataFrame) -> dict | None:
    """How r of irregular runs compares with that of periodic ones, where u is low."""
    both = motions.dropna(subset=["r_periodic", "r_irregular"])
    both = both[both["belt_velocity"] <= _LOW]
    if both.empty:
        return None
    apart = np.abs(both["r_irregular"] / both["r_periodic"] - 1)
    return {
        "points": len(both),
        "up_to": f"{_LOW:g}",
        "median": f"{apart.median():.0%}",
        "most": f"{apart.max():.0%}",
    }


def _counts(verdicts: pd.Series) -> list[str]:
    return [f"{count} {verdict}" for verdict, count in verdicts.value_counts().items()]


def _span(values) -> str:
    """Numbers as short text: none, a few, or the ends of a range."""
    values = np.unique(values)
    if values.size > 4:
        return f"{values[0]:g} to {values[-1]:g}"
    return ", ".join(f"{value:g}" for value in values)


def _number(value: float, form: str = ".3g") -> str:
    return "" if np.isnan(value) else f"{value:{form}}"
