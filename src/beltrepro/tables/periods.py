"""periods.csv: the periodic orbits that runs end on, with their periods in time and in slips."""

import pandas as pd

from beltrepro.analysis.periods import orbits_reached
from beltrepro.tables.registry import Entry

ENTRY = Entry(
    title="Periodic orbits that runs end on, for each N and u: the distribution of their periods.",
    uses=("survival",),
    columns={
        "period_time": "length of the period (model time), mean of the runs",
        "period_events": "slips of all blocks in the period",
        "period_returns": "returns to the section in the period",
        "runs": "runs that end on the orbit",
        "share": "of all runs of this N and u",
    },
)


def derive(data) -> pd.DataFrame:
    """A row for each orbit."""
    return pd.DataFrame(orbits_reached(data[ENTRY.uses[0]].arrays))
