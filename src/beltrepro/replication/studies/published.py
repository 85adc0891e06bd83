"""Tables that stand beside a study: made by a command of their own, not by a preset."""

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from beltrepro.base import atomic


def extend(
    path: Path, points: Iterable[dict], rows_of: Callable[..., Iterable[dict]]
) -> pd.DataFrame:
    """Add the rows of each point that a table lacks, and write it after each."""
    table = pd.read_csv(path) if path.exists() else pd.DataFrame()
    for point in points:
        if len(table) and np.all([table[name] == value for name, value in point.items()], 0).any():
            continue
        rows = pd.DataFrame([point | row for row in rows_of(**point)])
        table = pd.concat([table, rows], ignore_index=True)
        with atomic.replacing(path) as unfinished:
            table.to_csv(unfinished, index=False, float_format="%.6g")
        print(rows.to_string(), flush=True)
    return table
