"""audit.csv: whether sampled runs obey the law, judged without the integrators."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd

from beltrepro.replication.plan import files
from beltrepro.replication.plan.registry import Table
from beltrepro.simulation import audit

TABLE = Table(
    title="Whether sampled runs obey the law, judged without the integrators.",
    uses=("u20", "u17", "friction_event", "n10_u28"),
    columns={
        "dataset": "name",
        "energy_residual": "share of the belt's work that the energy balance does not account for",
        "wrong_way": "greatest speed over the belt at which friction pushed a block on",
        "overload": "greatest external force on a stuck block over F_st0",
        "windows": "pieces of a run without noise that were computed anew",
        "deviation": "greatest distance of a block at their ends from where it is in the run",
        "noise_ratio": "variance of what noise does to the momentum of blocks, over the right one",
        "noise_error": "standard error of noise_ratio",
    },
)


def derive(data) -> pd.DataFrame:
    """A row for each run."""
    return pd.DataFrame([{"dataset": name} | _row(data[name]) for name in TABLE.uses])


def _row(dataset) -> dict:
    run: Any = SimpleNamespace(  # what an audit asks of a run
        parameters=files.chain(dataset),
        method=str(dataset.attributes["method"]),
        time_step=float(dataset.attributes["time_step"]),
        energy_residual=float(np.ravel(dataset.arrays["energy_residual"])[0]),
        **{name: dataset.arrays[name] for name in ("time", "positions", "velocities", "friction")},
    )
    chain = run.parameters
    how = {"method": run.method, "n_blocks": chain.n_blocks}
    how |= {"belt_velocity": chain.belt_velocity, "noise": chain.noise}
    return how | vars(audit.audit(run))
