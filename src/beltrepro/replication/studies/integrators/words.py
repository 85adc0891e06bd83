"""What the report says of the two integrators, from the tables of a run."""

import numpy as np
import pandas as pd

from beltrepro.replication.studies.integrators import measure, samples

PARTS = {
    "disorder": "With noise",
    "slips": "Slips and section points",
    "attractors": "Attractors and lifetimes without noise",
}
DATASETS = {
    "disorder": "pairs_r_verlet",
    "slips": "pairs_slips_verlet",
    "attractors": "pairs_states_verlet",
}
"""Dataset of the tested integrator in each part, whose lengths the other one shares."""
TOLD_BY = ("agreement", "families")
SHOWN = (measure.DISORDER, measure.STILL_STICKING, measure.FINAL_DISORDER)


def describe(tables: dict[str, pd.DataFrame], settings: dict) -> dict:
    """Rows of tables, and the numbers of the sentences on what no row can tell."""
    comparisons, families = (tables[name] for name in TOLD_BY)
    methods = {role: comparisons[role].iloc[0] for role in ("tested", "reference")}
    return {
        "methods": methods,
        "infinity": np.inf,
        "level": samples.LEVEL,
        "verdicts": samples.VERDICTS,
        "parts": PARTS,
        "lengths": {part: settings["datasets"][name] for part, name in DATASETS.items()},
        "ends": _ends(comparisons, settings["defaults"]["time_step"]),
        "families": families.to_dict("records"),
        "comparisons": comparisons[comparisons["quantity"].isin(SHOWN)].to_dict("records"),
    }


def _ends(comparisons: pd.DataFrame, base: float) -> dict:
    """At how many points the r at the end differs, and whether from the most distant states too."""
    final = comparisons["quantity"] == measure.FINAL_DISORDER
    rows = comparisons[final & np.isclose(comparisons["time_step"], base)]
    differ = rows[rows["verdict"] == samples.DIFFER]
    wide = (differ["initial_spread"] == rows["initial_spread"].max()).any()
    return {"points": len(rows), "differ": len(differ), "wide": wide}
