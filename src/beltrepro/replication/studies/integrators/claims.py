"""Claim on the numerical method (Appendix): results by both integrators side by side."""

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError, require
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates

# Pairs of datasets with points in common, of which each was computed by one and by the other.
BY_BOTH = (
    ("pairs_r_verlet", "pairs_r_event"),
    ("n5_replicates_check", "n5_replicates"),
    ("n5_rows_check", "n5_rows"),
    ("size_rows_check", "size_rows"),
)
PLACE = ["n_blocks", "belt_velocity", "noise"]
DIFFERS = np.log(1.1)
MINIMUM_POINTS = 8


@claim("method-independence")
def method_independence(evidence):
    """r at points that were computed with both integrators, without and with noise."""
    ratios = _ratios(evidence)
    judged, also = {}, {}
    for words, noisy in (("with noise", True), ("without noise", False)):
        shifts = np.array([ratio for (*_, noise), ratio in ratios.items() if (noise > 0) == noisy])
        require(
            shifts.size >= MINIMUM_POINTS,
            f"{shifts.size} points {words} by both integrators, {MINIMUM_POINTS} are needed",
        )
        judged[f"mean shift, {words}"] = estimates.mean(shifts)
        far = int(np.sum(np.abs(shifts) > DIFFERS))
        judged[f"points that differ, {words}"] = estimates.share(far, shifts.size)
        also[f"largest shift, {words}"] = estimates.sure(float(shifts[np.argmax(np.abs(shifts))]))
    return Measurement(judged, also)


def _ratios(evidence):
    """ln(r_event / r_verlet) by (N, u, sigma), of means over runs; each point from one pair."""
    ratios = {}
    for names in BY_BOTH:
        if not all(map(evidence.has, names)):
            continue
        try:
            runs = pd.concat([_runs(evidence.table(name)) for name in names])
        except NotEnoughDataError:
            continue  # transients say nothing of what follows
        means = runs.groupby([*PLACE, "method"])["r"].mean().unstack().dropna()
        if {"verlet", "event"} <= set(means):
            for place, ratio in np.log(means["event"] / means["verlet"]).items():
                ratios.setdefault(place, ratio)
    return ratios


def _runs(table):
    """r of the runs, with their method and their point to the digits of a grid."""
    return pd.DataFrame(
        {
            "method": table.points["method"].astype(str),
            "n_blocks": table.points["n_blocks"],
            "belt_velocity": np.round(table.belt_velocity, 6),
            "noise": np.round(table.noise, 6),
            "r": table.disorder,
        }
    )
