"""agreement.csv: r, slips and attractors by two methods, compared at every point."""

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.integrators import compared as agreement

TABLE = Table(
    title="Every quantity that two methods are compared by, at every point, with the outcome.",
    uses=(
        "pairs_r_verlet",
        "pairs_r_event",
        "pairs_slips_verlet",
        "pairs_slips_event",
        "pairs_states_verlet",
        "pairs_states_event",
    ),
    columns={
        "part": "which pair of datasets",
        "quantity": "what is compared",
        "n_tested": "runs by the tested method",
        "n_reference": "runs by the reference",
        "mean_tested": "mean over the runs",
        "mean_reference": "mean over the runs",
        "error_tested": "standard error of the mean",
        "error_reference": "standard error of the mean",
        "z": "difference of the means over its standard error",
        "mean_p": "p-value of Welch's test of the means",
        "p": "p-value of the test named",
        "distance": "Wasserstein distance over root mean square, or difference of shares",
        "test": "test of the distributions",
        "tested": "method",
        "reference": "method",
        "corrected_p": "p after the correction for many tests (Holm), within a family",
        "verdict": "outcome",
    },
    on_top=True,
)

PARTS = {"disorder": "pairs_r", "slips": "pairs_slips", "attractors": "pairs_states"}
"""Parts of the comparison, and the beginning of the names of their datasets."""


def derive(data) -> pd.DataFrame:
    """A row for each quantity and point."""
    return pd.DataFrame(judged(data))


def judged(data) -> list[dict]:
    """The rows, with verdicts; p-values are corrected within families."""
    rows = {
        "disorder": _disorder(*_sides(data, "disorder")),
        "slips": _slips(*_sides(data, "slips")),
        "attractors": _attractors(*_sides(data, "attractors")),
    }
    return agreement.judge(
        [
            {"part": part} | row | methods(data, part)
            for part, compared in rows.items()
            for row in compared
        ]
    )


def _disorder(tested, reference):
    statistics = [
        agreement.disorder_statistics(
            side.arrays, measured_time=side.attributes["duration"] - side.attributes["transient"]
        )
        for side in (tested, reference)
    ]
    return agreement.compare_points(tested.arrays, reference.arrays, *statistics)


def _slips(tested, reference):
    sides = tested.arrays, reference.arrays
    return agreement.compare_points(*sides, *map(agreement.slip_statistics, sides))


def _attractors(tested, reference):
    """Against the reference with its smallest step."""
    sides = tested.arrays, reference.arrays
    return agreement.compare_attractors(
        *sides, reference_step=float(np.min(reference.arrays["time_step"]))
    )


def _sides(data, part):
    return [data[f"{PARTS[part]}_{method}"] for method in ("verlet", "event")]


def methods(data, part: str) -> dict[str, str]:
    """Names of the tested method and of the reference of a part."""
    sides = zip(("tested", "reference"), _sides(data, part), strict=True)
    return {role: side.attributes["method"] for role, side in sides}
