"""The table of a track: a CSV file that people and other programs write too."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import reading
from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError

_NEEDED, _OPTIONAL = ("time_s", "x_m"), ("error_m",)
_SEPARATORS = ",;\t"
# Samples at equal intervals from the first to the last instant that fit into memory.
_MOST_SAMPLES = 10**7
_MOST_BYTES = 10**9  # of the file: 100 for each of as many rows


def read_track(path: Path) -> tuple[list[np.ndarray], dict[str, Any]]:
    """Read the columns of a track, and the settings in its first line if it has them.

    Values are separated by commas, semicolons or tabs. Where they are not separated by commas, a
    comma in a number is a decimal point. Other columns and rows without any value are left out.
    """
    remarks, lines = _lines(path)
    header = lines[0] if lines else ""
    separator = max(_SEPARATORS, key=header.count)
    try:
        rows = [row for row in csv.reader(lines, delimiter=separator) if any(map(str.strip, row))]
    except csv.Error:
        raise InputError(f"{path}: not a table of comma-separated values") from None
    names = [name.strip().lower() for name in rows[0]] if rows else []
    _check_names(path, names, header)
    if not rows[1:]:
        raise InputError(f"{path}: has no rows")
    for number, row in enumerate(rows[1:], 1):
        if len(row) != len(names):
            raise InputError(f"{path}: row {number} has {len(row)} values, {len(names)} are needed")
    columns = []
    for name in _NEEDED + _OPTIONAL:
        words = [row[names.index(name)] if name in names else "" for row in rows[1:]]
        if separator != ",":
            words = [word.replace(",", ".") for word in words]
        columns.append(_numbers(path, name, words))
    if np.any(columns[2] < 0):
        row = int(np.flatnonzero(columns[2] < 0)[0]) + 1
        raise InputError(f"{path}: error_m in row {row} is less than 0")
    _check_instants(path, columns[0])
    return columns, _settings(remarks)


def _lines(path: Path) -> tuple[list[str], list[str]]:
    """Remarks and other lines of a file."""
    lines = [line for line in reading.text(path, _MOST_BYTES).splitlines() if line.strip()]
    remarks = [line for line in lines if line.startswith(("#", '"#'))]  # quoted by a spreadsheet
    return remarks, [line for line in lines if line not in remarks]


def _check_names(path: Path, names: list[str], header: str) -> None:
    """Refuse a table without the columns that are needed, or with one of them twice."""
    missing = [name for name in _NEEDED if name not in names]
    if missing:
        first = f"; its first line is {shown(header)}" if header else ""
        raise InputError(f"{path}: lacks the column {', '.join(missing)}{first}")
    for name in _NEEDED + _OPTIONAL:
        if names.count(name) > 1:
            raise InputError(f"{path}: has {names.count(name)} columns {name}")


def _numbers(path: Path, name: str, words: list[str]) -> np.ndarray:
    """A column as numbers (T,); what is optional may be missing."""
    optional = name in _OPTIONAL
    if optional:
        words = [word if word.strip() else "nan" for word in words]
    try:
        column = np.array(words, dtype=float)
    except ValueError as error:
        word = str(error).rpartition(": ")[2]
        raise InputError(f"{path}: {name}: {word} is not a number") from None
    if not (optional or np.all(np.isfinite(column))):
        row = int(np.flatnonzero(~np.isfinite(column))[0]) + 1
        raise InputError(f"{path}: {name} in row {row} is not a finite number")
    return column


def _check_instants(path: Path, time_s: np.ndarray) -> None:
    """Refuse instants that do not rise, or leap too far to be sampled at equal intervals."""
    steps = np.diff(time_s)
    if np.any(steps <= 0):
        row = int(np.flatnonzero(steps <= 0)[0]) + 2
        raise InputError(f"{path}: time_s in row {row} is not later than in the row before")
    if steps.size and time_s[-1] - time_s[0] > _MOST_SAMPLES * np.median(steps):
        row = int(np.argmax(steps)) + 2
        raise InputError(
            f"{path}: time_s in row {row} is {steps.max():.3g} s later than in the row before: "
            f"that is too far apart for samples every {np.median(steps):.3g} s"
        )


def _settings(remarks: list[str]) -> dict[str, Any]:
    try:
        settings = json.loads(remarks[0].lstrip("#"))
    except (IndexError, ValueError, RecursionError):
        return {}
    return settings if isinstance(settings, dict) else {}
