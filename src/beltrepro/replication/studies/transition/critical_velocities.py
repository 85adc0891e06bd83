"""critical_velocities.csv: where r falls, for each noise and number of blocks, over replicates."""

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.stats.errors import NotEnoughDataError
from beltrepro.stats.transitions import transition_region

TABLE = Table(
    title="Belt velocity at which r falls, over replicates.",
    uses=("n5_replicates", "n5_replicates_check", "n5_replicates_wide", "size_replicates"),
    columns={
        "dataset": "the replicates",
        "runs": "replicates, each a row of runs at all belt velocities",
        "falls": "replicates in which r falls, each by itself",
        "critical": "middle of the transition region (model velocity); empty if r does not fall",
        "error": "standard error of critical, by drawing replicates anew",
        "lower": "u at which the fall begins (model velocity)",
        "upper": "u at which it ends (model velocity)",
    },
)

RESAMPLES = 100


def derive(data) -> pd.DataFrame:
    """A row for each dataset, number of blocks and noise."""
    rows = []
    for name in TABLE.uses:
        arrays = data[name].arrays
        points = np.column_stack([arrays["n_blocks"], arrays["noise"]])
        for n_blocks, noise in np.unique(points, axis=0):
            own = (arrays["n_blocks"] == n_blocks) & (arrays["noise"] == noise)
            row = {"dataset": name, "n_blocks": int(n_blocks), "noise": noise}
            rows.append(row | _falls(arrays, own))
    return pd.DataFrame(rows)


def _falls(arrays, own):
    """Where r of all replicates together falls, and how sure that is."""
    rows = [np.flatnonzero(own & (arrays["replicate"] == k)) for k in _replicates(arrays, own)]
    lower, critical, upper = _region(arrays, np.flatnonzero(own))
    return {
        "runs": len(rows),
        "falls": int(sum(np.isfinite(_region(arrays, row)[1]) for row in rows)),
        "critical": critical,
        "error": _error(arrays, rows) if np.isfinite(critical) and len(rows) > 1 else np.nan,
        "lower": lower,
        "upper": upper,
    }


def _replicates(arrays, own):
    return np.unique(arrays["replicate"][own])


def _error(arrays, rows):
    """Scatter of the middle when as many replicates are drawn anew, with repetition."""
    rng = np.random.default_rng(0)
    middles = []
    for _ in range(RESAMPLES):
        drawn = rng.integers(0, len(rows), len(rows))
        middles.append(_region(arrays, np.concatenate([rows[index] for index in drawn]))[1])
    middles = [each for each in middles if np.isfinite(each)]
    return float(np.std(middles)) if len(middles) > 1 else np.nan


def _region(arrays, chosen):
    """(lower, middle, upper) of the transition region; NaN where r does not fall."""
    velocity, disorder = (arrays[each][chosen] for each in ("belt_velocity", "disorder_parameter"))
    try:
        fall = transition_region(velocity, disorder, bootstrap=0)
    except NotEnoughDataError:
        return np.nan, np.nan, np.nan
    return fall.lower, fall.critical, fall.upper
