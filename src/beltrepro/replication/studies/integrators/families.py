"""families.csv: each quantity of agreement.csv over all points."""

import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.integrators import agreement
from beltrepro.replication.studies.integrators import compared as analysis

TABLE = Table(
    title="Each quantity that two methods are compared by, with tests over all points.",
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
        "points": "number of points",
        "runs": "smallest number of runs by the reference at a point",
        "test": "test of the distributions",
        "smallest_p": "smallest corrected p of the points",
        "largest_distance": "largest distance of the distributions at a point",
        "chi2": "sum of the squared normal scores of the tests of the means",
        "degrees": "number of these tests",
        "chi2_p": "p-value of chi2",
        "uniform_p": "p-value of the test that the p-values of the means are uniform",
        "shift": "mean relative difference of the means",
        "shift_error": "standard error of shift",
    },
)


def derive(data) -> pd.DataFrame:
    """A row for each family: what one quantity gives at all points."""
    return pd.DataFrame(
        [
            row | agreement.methods(data, row["part"])
            for row in analysis.summarise(agreement.judged(data))
        ]
    )
