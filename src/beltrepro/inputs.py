"""What figures, tables and claims are made from: datasets and tables by name, read and checked."""

from pathlib import Path

import pandas as pd

from beltrepro.datasets import files
from beltrepro.store import Dataset


def load(paths: dict[str, str | Path], expected: dict[str, dict]) -> dict:
    """Read datasets (.h5) and tables (.csv).

    Parameters
    ----------
    paths : dict
        Files by name of the dataset or table.
    expected : dict
        For each dataset what its file must say of itself, see `datasets.files.expected`.

    Returns
    -------
    dict
        `store.Dataset` or DataFrame by name. A series of a single point is given as that run: its
        arrays without the axis of points (`datasets.files.single_run`).

    Raises
    ------
    InputError
        If a file cannot be read or holds something else.
    """
    return {
        name: pd.read_csv(path) if Path(path).suffix == ".csv" else _dataset(path, expected[name])
        for name, path in paths.items()
    }


def _dataset(path: str | Path, expected: dict) -> Dataset:
    found = files.read(path, expected)
    return files.single_run(found) if files.is_single_run(found) else found
