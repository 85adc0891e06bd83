"""What the report says of the two integrators, from the tables of a run."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from beltrepro.replication.studies.integrators import divergence, measure, samples

PARTS = {
    "trajectories": "Trajectories without noise",
    "disorder": "With noise",
    "slips": "Slips and section points",
    "attractors": "Attractors and lifetimes without noise",
}
DATASETS = {
    "trajectories": "pairs_paths_verlet",
    "disorder": "pairs_r_verlet",
    "slips": "pairs_slips_verlet",
    "attractors": "pairs_states_verlet",
}
"""Dataset of the tested integrator in each part, whose lengths the other one shares."""
TOLD_BY = ("agreement", "families", "partings", "convergence")
SHOWN = (measure.DISORDER, measure.STILL_STICKING, measure.FINAL_DISORDER)


def describe(tables: dict[str, pd.DataFrame], settings: dict) -> dict:
    """Rows of tables, and the numbers of the sentences on what no row can tell."""
    comparisons, families, partings, convergence = (tables[name] for name in TOLD_BY)
    methods = {role: comparisons[role].iloc[0] for role in ("tested", "reference")}
    base = settings["defaults"]["time_step"]
    # with one method on both sides the reference is the one with the base step
    at_base = np.isclose(partings["time_step"], base) & (partings["method"] == methods["tested"])
    return {
        "methods": methods,
        "base": base,
        "infinity": np.inf,
        "level": samples.LEVEL,
        "verdicts": samples.VERDICTS,
        "parts": PARTS,
        "lengths": {part: settings["datasets"][name] for part, name in DATASETS.items()},
        "apart": divergence.PARTED,
        "parted": partings[at_base],
        "orders": list(_orders(convergence)),
        "ends": _ends(comparisons, base),
        "families": families.to_dict("records"),
        "partings": partings.to_dict("records"),
        "comparisons": comparisons[comparisons["quantity"].isin(SHOWN)].to_dict("records"),
    }


def _orders(convergence: pd.DataFrame) -> Iterator[dict]:
    """Orders in the step of the first errors of each method, at each belt velocity."""
    # before the first event there is only rounding, and after many of them the errors are large
    early = convergence[convergence["order"].notna() & (convergence["after_events"] > 0)]
    early = early[(early["varied"] == "tolerance") | (early["after_events"] <= 5)]
    for (varied, method, u), fits in early.groupby(["varied", "method", "belt_velocity"]):
        orders = fits.drop_duplicates(["n_blocks", "after_events"])["order"]
        place = {"varied": varied, "method": method, "belt_velocity": u}
        yield place | {"events": fits["after_events"], "orders": orders}


def _ends(comparisons: pd.DataFrame, base: float) -> dict:
    """At how many points the r at the end differs, and whether from the most distant states too."""
    final = comparisons["quantity"] == measure.FINAL_DISORDER
    rows = comparisons[final & np.isclose(comparisons["time_step"], base)]
    differ = rows[rows["verdict"] == samples.DIFFER]
    wide = (differ["initial_spread"] == rows["initial_spread"].max()).any()
    return {"points": len(rows), "differ": len(differ), "wide": wide}
