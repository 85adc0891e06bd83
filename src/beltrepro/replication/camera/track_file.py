"""A track and its table: a CSV file that people and other programs write too."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import checks, reading
from beltrepro.base.errors import InputError

if TYPE_CHECKING:
    from beltrepro.replication.camera.survey import Survey

_NEEDED, _OPTIONAL = ("time_s", "x_m"), ("error_m",)
_SEPARATORS = ",;\t"
# Samples at equal intervals from the first to the last instant that fit into memory.
_MOST_SAMPLES = 10**7
_MOST_BYTES = 10**9  # of the file: 100 for each of as many rows
# Fields of a track that its file has in the first line.
_NUMBERS = ("metres_per_pixel", "angle", "scale_error", "zero_error_m")


@dataclass(frozen=True, eq=False)
class Track:
    """Places of the white block."""

    # instants of the frames in which it was found, seconds from the beginning of the video
    time_s: np.ndarray
    # its middle along the belt, metres from the first mark of the tape (plus what it reads)
    x_m: np.ndarray
    error_m: np.ndarray  # one standard error of x_m, of which some is common to all frames
    metres_per_pixel: float  # scale of the picture
    angle: float  # by which the belt is turned in the picture, degrees, clockwise
    lost_s: np.ndarray  # begin and end of each stretch of frames in which the block was not found
    # What all frames have in common: x is wrong by zero_error_m + scale_error x, one standard error
    # of each. Both are part of error_m; nan where they are not known.
    scale_error: float = math.nan
    zero_error_m: float = math.nan
    survey: Survey | None = None  # by which it was measured; files do not keep it

    def save(self, path: str | Path) -> None:
        """Write the track as CSV: a line of settings, which begins with #, and three columns."""
        settings: dict[str, Any] = {"lost_s": self.lost_s.tolist()}
        for name in _NUMBERS:
            number = getattr(self, name)
            settings[name] = number if math.isfinite(number) else None
        rows = np.column_stack([self.time_s, self.x_m, self.error_m])
        with Path(path).open("w", encoding="utf-8") as file:
            file.write(f"# {json.dumps(settings)}\ntime_s,x_m,error_m\n")
            np.savetxt(file, rows, delimiter=",", fmt="%.9g")

    @classmethod
    def load(cls, path: str | Path) -> Track:
        """Read a CSV file with the columns time_s, x_m and, if known, error_m.

        Values are separated by commas, semicolons or tabs. Where they are not separated by commas,
        a comma in a number is a decimal point. Other columns and rows without any value are left
        out.
        """
        path = checks.path("path", path)
        lines = [line for line in reading.text(path, _MOST_BYTES).splitlines() if line.strip()]
        remarks = [line for line in lines if line.startswith(("#", '"#'))]  # as spreadsheets quote
        try:
            time_s, x_m, error_m = _columns([line for line in lines if line not in remarks])
            return cls(time_s, x_m, error_m, **_settings(remarks))
        except InputError as reason:
            raise InputError(f"{path}: {reason}") from None


def _columns(lines: list[str]) -> list[np.ndarray]:
    """The columns of a table, the optional one of nan where it is missing."""
    header = lines[0] if lines else ""
    separator = max(_SEPARATORS, key=header.count)
    try:
        rows = [row for row in csv.reader(lines, delimiter=separator) if any(map(str.strip, row))]
    except csv.Error:
        raise InputError("not a table of comma-separated values") from None
    names = [name.strip().lower() for name in rows[0]] if rows else []
    if missing := [name for name in _NEEDED if name not in names]:
        first = f"; its first line is {checks.shown(header)}" if header else ""
        raise InputError(f"lacks the column {', '.join(missing)}{first}")
    for name in _NEEDED + _OPTIONAL:
        if names.count(name) > 1:
            raise InputError(f"has {names.count(name)} columns {name}")
    if not rows[1:]:
        raise InputError("has no rows")
    for number, row in enumerate(rows[1:], 1):
        if len(row) != len(names):
            raise InputError(f"row {number} has {len(row)} values, {len(names)} are needed")
    columns = []
    for name in _NEEDED + _OPTIONAL:
        words = [row[names.index(name)] if name in names else "" for row in rows[1:]]
        if separator != ",":
            words = [word.replace(",", ".") for word in words]
        if name in _OPTIONAL:
            words = [word if word.strip() else "nan" for word in words]
        try:
            columns.append(np.array(words, dtype=float))
        except ValueError as error:
            word = str(error).rpartition(": ")[2]
            raise InputError(f"{name}: {word} is not a number") from None
    _check(*columns)
    return columns


def _check(time_s: np.ndarray, x_m: np.ndarray, error_m: np.ndarray) -> None:
    """Refuse a row with no finite numbers, or at an instant too early or too late."""
    steps = np.diff(time_s, prepend=-np.inf)
    usual = float(np.median(steps[1:])) if time_s.size > 1 else math.inf
    too_far = (steps == steps[1:].max(initial=0)) & (np.ptp(time_s) > _MOST_SAMPLES * usual)
    for wrong, words in (
        (~np.isfinite(time_s), "time_s in row {} is not a finite number"),
        (~np.isfinite(x_m), "x_m in row {} is not a finite number"),
        (error_m < 0, "error_m in row {} is less than 0"),
        (steps <= 0, "time_s in row {} is not later than in the row before"),
        (too_far, f"time_s in row {{}} is {steps[1:].max(initial=0):.3g} s later than in the row "
         f"before: that is too far apart for samples every {usual:.3g} s"),
    ):  # fmt: skip
        if wrong.any():
            raise InputError(words.format(np.argmax(wrong) + 1))


def _settings(remarks: list[str]) -> dict[str, Any]:
    """Fields of a track in the first remark, as far as it has them."""
    try:
        remark = json.loads(remarks[0].lstrip("#"))
    except (IndexError, ValueError, RecursionError):
        remark = {}
    settings: dict[str, Any] = {"lost_s": np.empty((0, 2))}
    remark = remark if isinstance(remark, dict) else {}
    try:
        for name in _NUMBERS:
            value = remark.get(name)
            settings[name] = math.nan if value is None else checks.finite_number(name, value)
        if stretches := remark.get("lost_s"):
            settings["lost_s"] = checks.numbers("lost_s", stretches, 2, rows=True).reshape(-1, 2)
    except InputError as reason:
        raise InputError(f"its first line has {reason}") from None
    return settings
