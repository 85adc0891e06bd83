"""Claim on the numerical method (Appendix): results by both integrators side by side."""

import numpy as np

from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.registry import claim
from beltrepro.stats import estimates
from beltrepro.stats.errors import NotEnoughDataError, require

# Pairs of datasets with points in common, of which each was computed by one and by the other.
BY_BOTH = (
    ("pairs_r_verlet", "pairs_r_event"),
    ("n5_replicates_check", "n5_replicates"),
    ("n5_rows_check", "n5_rows"),
    ("size_rows_check", "size_rows"),
)
DIFFERS = np.log(1.1)
MINIMUM_POINTS = 8


@claim("method-independence")
def method_independence(evidence):
    """r at points that were computed with both integrators, without and with noise."""
    ratios = _ratios(evidence)
    judged, also = {}, {}
    for words, noisy in (("with noise", True), ("without noise", False)):
        own = np.array([ratio for (_, _, noise), ratio in ratios.items() if (noise > 0) == noisy])
        require(
            own.size >= MINIMUM_POINTS,
            f"{own.size} points {words} by both integrators, {MINIMUM_POINTS} are needed",
        )
        judged[f"mean shift, {words}"] = estimates.mean(own)
        far = int(np.sum(np.abs(own) > DIFFERS))
        judged[f"points that differ, {words}"] = estimates.share(far, own.size)
        also[f"largest shift, {words}"] = estimates.sure(float(own[np.argmax(np.abs(own))]))
    return Measurement(judged, also)


def _ratios(evidence):
    """ln(r_event / r_verlet) by (N, u, sigma), of means over runs; each point from one pair."""
    found = {}
    for names in BY_BOTH:
        if not all(map(evidence.has, names)):
            continue
        try:
            points = [_points(evidence.table(name)) for name in names]
        except NotEnoughDataError:
            continue  # transients say nothing of what follows
        by_method = {"verlet": {}, "event": {}}
        for each in points:
            for (method, *place), disorder in each.items():
                by_method[method].setdefault(tuple(place), []).extend(disorder)
        for place in sorted(by_method["verlet"].keys() & by_method["event"].keys()):
            event, verlet = (np.mean(by_method[name][place]) for name in ("event", "verlet"))
            found.setdefault(place, float(np.log(event / verlet)))
    return found


def _points(table):
    """r of the runs by (method, N, u, sigma)."""
    runs = {}
    columns = (
        table.points["method"].astype(str),
        table.points["n_blocks"],
        np.round(table.belt_velocity, 6),
        np.round(table.noise, 6),
        table.disorder,
    )
    for method, n_blocks, velocity, noise, disorder in zip(*columns, strict=True):
        runs.setdefault((method, int(n_blocks), velocity, noise), []).append(disorder)
    return runs
