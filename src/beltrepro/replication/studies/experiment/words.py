"""What the page says on the virtual experiment and on trials of the length of the recordings."""

import numpy as np
import pandas as pd

from beltrepro.model import units
from beltrepro.replication.studies.experiment import measure

_HALF = 0.5


TRIALS_TOLD_BY = ("experiment_odds", "alternation")


def of_trials(tables: dict[str, pd.DataFrame], settings: dict) -> dict:
    """Numbers of the sentences on trials, and rows of tables, as text."""
    odds, alternation = (tables[name] for name in TRIALS_TOLD_BY)
    together = odds[odds["noise"].isna()]
    rows = [_odds(row) for row in together.to_dict("records")]
    return {
        "rows": rows,
        "noises": _span(odds["noise"].dropna()),
        "tolerance": f"{measure.TOLERANCE:.0%}",
        "none_agree": bool((together["agrees"] == 0).all()),
        "all_slip": _all_slip(together, alternation),
        "alternating": _alternating(alternation),
    }


def _odds(row: dict) -> dict:
    """One recording, with the trials at all noises, as text."""
    return {
        "speed": f"{row['speed_m_s']:g}",
        "length": f"{row['recorded_s']:.0f}",
        "runs": row["runs"],
        "recorded": f"{row['r_recorded']:g}",
        "r": f"{row['r']:.3f} ({row['r_lower']:.3f} to {row['r_upper']:.3f})",
        "least": f"{row['r_least']:.3f}",
        "longest": f"{row['lasting_longest_s']:.0f}",
        **{name: _share(row, name) for name in ("below", "shows", "both")},
    }


def _share(row: dict, name: str) -> str:
    """A share with its interval: 0.02 (0.01 to 0.05)."""
    ends = (f"{row[f'{name}_{end}']:.2g}" for end in ("lower", "upper"))
    return f"{row[name]:.2g} ({' to '.join(ends)})"


def _all_slip(printed: pd.DataFrame, free: pd.DataFrame) -> dict:
    """How long all blocks slip at once, with the printed constants and with others."""
    return {
        "printed": f"{printed['all_slip_longest_s'].max():.2g}",
        "free": f"{free['all_slip_longest_s'].max():.2g}",
        "minutes": int(free["all_slip"].sum()),
        "trials": int(free["runs"].sum()),
        "ratios": _span(free.loc[free["all_slip"] > 0, "friction_ratio"]),
    }


def _alternating(table: pd.DataFrame) -> list[dict]:
    """For each noise, the belt velocities at which half of the trials or more alternate."""
    rows = []
    printed = table[np.isclose(table["friction_ratio"], measure.FRICTION_RATIO)]
    for noise, points in printed.groupby("noise"):
        velocity = points.loc[points["share"] >= _HALF, "belt_velocity"]
        metres = velocity.map(lambda u: units.to_si(u, "velocity"))
        rows.append(
            {
                "noise": f"{noise:g}",
                "runs": int(points["runs"].min()),
                "u": _span(velocity, ".3g"),
                "m_s": _span(metres, ".2f"),
                "most": f"{points['share'].max():.2g}",
            }
        )
    return rows


def _span(values, form: str = "g") -> str:
    """The ends of a range; its value if there is one only, and nothing if there is none."""
    values = np.unique(values)
    if not values.size:
        return ""
    ends = f"{values[0]:{form}}", f"{values[-1]:{form}}"
    return ends[0] if values.size == 1 else " to ".join(ends)


def of_recordings(tables: dict[str, pd.DataFrame], settings: dict) -> dict:
    """Rows of the recordings, as text."""
    rows = tables["recordings"].to_dict("records")
    return {
        "recordings": [_recording(row) for row in rows],
        "rate": rows[0]["frames_per_second"],
    }


def _recording(row: dict) -> dict:
    return {
        "speed": f"{row['belt_speed']:.2f}",
        "noise": f"{row['noise']:g}",
        "seconds": f"{row['seconds']:.0f}",
        "r": [f"{row[name]:.5f}" for name in ("r_run", "r_sampled", "r_tracked")],
        "mean": [f"{100 * row[name]:.3f}" for name in ("mean_sampled", "mean_tracked")],
        "small": [f"{100 * row[name]:.1f}" for name in ("small_sampled", "small_tracked")],
        "error": [f"{row[name]:.3f}" for name in ("scatter", "offset", "largest")],
    }
