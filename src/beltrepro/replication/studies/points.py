"""Runs of a dataset point by point."""

from collections.abc import Iterator

import numpy as np
import pandas as pd


def by_point(arrays: dict[str, np.ndarray], *names: str) -> Iterator[tuple[dict, np.ndarray]]:
    """Each point as the values that these quantities have together, in rising order, and its runs.

    The runs are the places in the arrays, in their order.
    """
    columns = pd.DataFrame({name: arrays[name] for name in names})
    for values, runs in columns.groupby(list(names)):
        yield dict(zip(names, values, strict=True)), runs.index.to_numpy()
