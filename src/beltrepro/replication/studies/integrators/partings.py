"""partings.csv: when trajectories from the same states part."""

import pandas as pd

from beltrepro.replication.plan.registry import Table
from beltrepro.replication.studies.integrators import compared as agreement
from beltrepro.replication.studies.integrators import divergence

TABLE = Table(
    title="When trajectories by two methods, or with two steps, from the same states part.",
    uses=("pairs_paths_verlet", "pairs_paths_event"),
    columns={
        "members": "pairs of trajectories; all numbers are medians over them",
        "parting_time": "first time (model time) at which a block is 1 apart; inf if never",
        "shared_events": "events that both trajectories have",
        "reference_events": "events of the reference",
        "first_shift": "largest shift in time (model time) of the first 10 shared events",
        "shift": "largest shift in time (model time) of all shared events",
    },
)


def derive(data) -> pd.DataFrame:
    """A row for each method, point and time step."""
    return pd.DataFrame(compared(data)[0])


def compared(data) -> tuple[list[dict], list[dict]]:
    """Partings, and errors by time step, of both methods against the reference."""
    sides = [divergence.with_steps(data[name].arrays) for name in TABLE.uses]
    reference = sides[1]
    partings, errors = [], []
    for name, side in zip(TABLE.uses, sides, strict=True):
        method = {"method": data[name].attributes["method"]}
        parted, found = agreement.compare_trajectories(
            side, reference, reference_step=float(reference["time_step"].min())
        )
        partings += [method | row for row in parted]
        errors += [method | row for row in found]
    return partings, errors
