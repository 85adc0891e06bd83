"""convergence.csv: errors of trajectories against the step, and the order of the methods."""

import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.integrators import compared as agreement
from beltrepro.replication.studies.integrators import divergence, partings

TABLE = Table(
    title="Errors of trajectories against time step and tolerance, with the order in the step.",
    uses=("pairs_paths_verlet", "pairs_paths_event", "pairs_paths_tolerances"),
    columns={
        "varied": "time_step or tolerance",
        "tolerance": "truncation error allowed in a step (model force)",
        "step": "mean step (model time)",
        "after_events": "number of events after which the error is taken",
        "members": "pairs of trajectories",
        "error": "largest distance of a block (model length), root mean square over pairs",
        "order": "order of convergence in the step, over all rows of a point",
        "order_error": "its standard error",
    },
)


def derive(data) -> pd.DataFrame:
    """A row for each method, point, number of events, and time step or tolerance."""
    tolerances = data["pairs_paths_tolerances"]
    method = {"method": tolerances.attributes["method"]}
    by_tolerance = agreement.compare_tolerances(divergence.with_steps(tolerances.arrays))
    return pd.DataFrame(partings.compared(data)[1] + [method | row for row in by_tolerance])
