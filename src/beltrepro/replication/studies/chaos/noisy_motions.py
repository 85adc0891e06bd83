"""noisy_motions.csv: largest exponents under noise, for each u and noise."""

import numpy as np
import pandas as pd

from beltrepro.replication.plan.registry import Table

TABLE = Table(
    title="Largest Lyapunov exponents under noise, and r, for each u and noise.",
    uses=("noisy_motion",),
    columns={
        "runs": "runs with different starts and noise",
        "exponent": "largest Lyapunov exponent, mean over the runs (per model time)",
        "error": "standard error of the mean, from the scatter of the runs",
        "r": "disorder parameter, mean over the runs",
    },
)


def derive(data) -> pd.DataFrame:
    """A row for each belt velocity and noise."""
    arrays = data["noisy_motion"].arrays
    names = ("belt_velocity", "noise", "largest_exponent", "disorder_parameter")
    runs = pd.DataFrame({name: arrays[name] for name in names})
    grouped = runs.groupby(["belt_velocity", "noise"])
    exponent = grouped["largest_exponent"]
    return pd.DataFrame(
        {
            "runs": grouped.size(),
            "exponent": exponent.mean(),
            "error": exponent.std(ddof=1) / np.sqrt(grouped.size()),
            "r": grouped["disorder_parameter"].mean(),
        }
    ).reset_index()
