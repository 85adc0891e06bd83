"""What figures, tables and claims are made from, by name: datasets, tables, films and tracks."""

from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from beltrepro.datasets import files
from beltrepro.datasets.films import FILM, TRACK
from beltrepro.store import Dataset


def load(paths: dict[str, str | Path], expected: dict[str, dict]) -> dict:
    """Read datasets (.h5), tables (.csv) and what the virtual experiment made.

    Parameters
    ----------
    paths : dict
        Files by name of the dataset or table; those of film F are "F_film" and "F_track".
    expected : dict
        For each dataset what its file must say of itself, see `datasets.files.expected`.

    Returns
    -------
    dict
        `store.Dataset` or DataFrame by name. A series of a single point is given as that run: its
        arrays without the axis of points (`datasets.files.single_run`). A track is an
        `experiment.Track`. A film is a function without arguments that yields its frames
        (`experiment.video.read_video`).

    Raises
    ------
    InputError
        If a file cannot be read or holds something else.
    """
    return {name: _read(name, Path(path), expected) for name, path in paths.items()}


def _read(name: str, path: Path, expected: dict[str, dict]) -> Any:
    if name.endswith(FILM):
        from beltrepro.experiment.video import read_video  # a second that others need not wait

        return partial(read_video, path)
    if name.endswith(TRACK):
        from beltrepro.experiment import Track

        return Track.load(path)
    return pd.read_csv(path) if path.suffix == ".csv" else _dataset(path, expected[name])


def _dataset(path: str | Path, expected: dict) -> Dataset:
    found = files.read(path, expected)
    return files.single_run(found) if files.is_single_run(found) else found
