"""Claim on the numerical method (Appendix): r by both integrators, point by point."""

import numpy as np
import pandas as pd
import scipy

from beltrepro.base.errors import require
from beltrepro.replication.verdicts.criteria import Measurement
from beltrepro.replication.verdicts.ledger import claim
from beltrepro.stats import estimates

PLACE = ["n_blocks", "belt_velocity", "noise"]
# by the scheme and by exact motion: short runs everywhere, and long ones where r changes
NOISY = (
    ("pairs_r_verlet", "pairs_r_event"),
    ("n5_edge", "n5_replicates"),
    ("n5_u7_check", "n5_u7"),
)
QUIET = (("n5_replicates_check", "n5_replicates"),)
SEEN = np.log(1.1)  # a shift of r by a tenth is the least that is seen in the paper's figures
MINIMUM_POINTS, MINIMUM_RUNS = 8, 4


@claim("method-independence", "with noise")
def with_noise(evidence):
    """Points at which r by the two integrators differs, with noise."""
    return _differing(evidence, NOISY, "with noise")


@claim("method-independence", "with and without noise")
def method_independence(evidence):
    """The same, and without noise too."""
    noisy, quiet = with_noise(evidence), _differing(evidence, QUIET, "without noise")
    return Measurement(noisy.judged | quiet.judged, noisy.also | quiet.also)


def _differing(evidence, pairs, words):
    """Share of the points whose mean r differs by a tenth and more than by chance; mean shift."""
    points = [
        point
        for names in pairs
        if all(map(evidence.has, names))
        for point in _points(evidence, names, noisy=pairs is NOISY)
    ]
    count = f"{len(points)} points {words} by both integrators"
    require(len(points) >= MINIMUM_POINTS, f"{count}, {MINIMUM_POINTS} are needed")
    shifts = np.array([event.mean() - verlet.mean() for verlet, event in points])
    p = [scipy.stats.mannwhitneyu(verlet, event).pvalue for verlet, event in points]
    differ = (np.abs(shifts) > SEEN) & (scipy.stats.false_discovery_control(p) < 0.05)
    return Measurement(
        {f"points that differ, {words}": estimates.share_of(differ)},
        {f"mean shift, {words}": estimates.mean(shifts)},
    )


def _points(evidence, names, *, noisy):
    """ln r of the runs by the scheme, and by exact motion, at each point that both have."""
    # In the same stretch of time after the same starts transients may be compared, too.
    runs = pd.concat([_runs(evidence.dataset(name).arrays) for name in names])
    points = [
        [np.log(r) for _, r in sorted(pair.groupby("method")["r"], reverse=True)]
        for (*_, noise), pair in runs.groupby(PLACE)
        if (noise > 0) == noisy
    ]
    return [pair for pair in points if len(pair) == 2 and min(map(len, pair)) >= MINIMUM_RUNS]


def _runs(arrays):
    """r of the runs, with their method and their point to the digits of a grid."""
    place = {name: np.round(arrays[name], 6) for name in PLACE}
    method, r = arrays["method"].astype(str), arrays["disorder_parameter"]
    return pd.DataFrame(place | {"method": method, "r": r})
