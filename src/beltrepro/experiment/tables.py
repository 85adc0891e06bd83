"""The table of a track: a CSV file that people and other programs write too."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.errors import InputError

_NEEDED, _OPTIONAL = ("time_s", "x_m"), ("error_m",)


def read_track(path: Path) -> tuple[list[np.ndarray], dict[str, Any]]:
    """Read the columns of a track, and the settings in its first line if it has them.

    Parameters
    ----------
    path : Path
        The file: a line that begins with # is a remark, the first other one names the columns.

    Returns
    -------
    columns : list of arrays (T,)
        time_s, x_m and error_m, which is NaN if the file does not have it.
    settings : dict
        What the first remark says, if it is JSON.

    Raises
    ------
    InputError
        The file is missing, is no text, lacks a column or a row, or holds something else than
        numbers in the order of time.
    """
    remarks, rows = _lines(path)
    names = [name.strip() for name in rows[0]] if rows else []
    missing = [name for name in _NEEDED if name not in names]
    if missing:
        raise InputError(f"{path}: lacks the column {', '.join(missing)}")
    numbers = _numbers(path, rows[1:], len(names))
    columns = [
        numbers[:, names.index(name)] if name in names else np.full(len(numbers), np.nan)
        for name in _NEEDED + _OPTIONAL
    ]
    for name, column in zip(_NEEDED, columns, strict=False):
        if not np.all(np.isfinite(column)):
            row = int(np.flatnonzero(~np.isfinite(column))[0]) + 1
            raise InputError(f"{path}: {name} in row {row} is not a finite number")
    if np.any(np.diff(columns[0]) <= 0):
        row = int(np.flatnonzero(np.diff(columns[0]) <= 0)[0]) + 2
        raise InputError(f"{path}: time_s in row {row} is not later than in the row before")
    return columns, _settings(remarks)


def _lines(path: Path) -> tuple[list[str], list[list[str]]]:
    """Remarks and rows of a file."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file") from None
    lines = [line for line in text.splitlines() if line.strip()]
    remarks = [line for line in lines if line.startswith("#")]
    try:
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    except csv.Error:
        raise InputError(f"{path}: not a table of comma-separated values") from None
    return remarks, rows


def _numbers(path: Path, rows: list[list[str]], width: int) -> np.ndarray:
    """The rows as numbers (T, width)."""
    if not rows:
        raise InputError(f"{path}: has no rows")
    for number, row in enumerate(rows, 1):
        if len(row) != width:
            raise InputError(f"{path}: row {number} has {len(row)} values, {width} are needed")
    try:
        return np.array(rows, dtype=float)
    except ValueError as error:
        word = str(error).rpartition(": ")[2]
        raise InputError(f"{path}: {word} is not a number") from None


def _settings(remarks: list[str]) -> dict[str, Any]:
    try:
        settings = json.loads(remarks[0].lstrip("#"))
    except (IndexError, ValueError):
        return {}
    return settings if isinstance(settings, dict) else {}
