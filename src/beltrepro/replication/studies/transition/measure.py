"""Where r falls with the belt velocity, over independent runs."""

import numpy as np
import pandas as pd

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.plan.registry import Table
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import estimates
from beltrepro.stats.estimates import Estimate
from beltrepro.stats.transition import QUANTITIES

TABLES = {
    "critical_velocities": Table(
        uses=("n5_replicates", "n5_replicates_check", "n5_replicates_wide", "size_replicates")
    )
}


def fall(scan, n_blocks: int, noise: float) -> dict[str, Estimate]:
    """The fall of r in a row of a scan; nothing found where there are too few runs for one."""
    try:
        return Cut.of(scan, n_blocks=n_blocks, noise=noise).fall
    except NotEnoughDataError:
        return dict.fromkeys(QUANTITIES, estimates.absent())


def critical_velocities(data) -> pd.DataFrame:
    """A row for each dataset, number of blocks and noise."""
    rows = []
    for name in TABLES["critical_velocities"].uses:
        arrays = data[name].arrays
        points = np.column_stack([arrays["n_blocks"], arrays["noise"]])
        for n_blocks, noise in np.unique(points, axis=0):
            region = fall(data[name], int(n_blocks), noise)
            critical = region["critical"]
            row = {"dataset": name, "n_blocks": int(n_blocks), "noise": noise}
            row |= {"runs": critical.runs, "critical": critical.value}
            row |= {"low": critical.low, "high": critical.high}
            rows.append(row | {edge: region[edge].value for edge in ("lower", "upper")})
    return pd.DataFrame(rows)
