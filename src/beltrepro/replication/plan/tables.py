"""CSV files, and beside each what made it, what its columns are, and its checksum."""

from pathlib import Path
from typing import Any

import pandas as pd

from beltrepro.base import reading
from beltrepro.base.atomic import replacing
from beltrepro.base.errors import InputError
from beltrepro.replication.plan.described import describe
from beltrepro.replication.plan.points import QUANTITIES, UNITS

DIGITS = "%.6g"


def write(
    path: str | Path,
    table: pd.DataFrame,
    *,
    title: str,
    columns: dict[str, str],
    sources: dict[str, dict],
    lineage: dict[str, dict] | None = None,
) -> None:
    """Write a table and its metadata."""
    path = Path(path)
    with replacing(path) as unfinished:
        table.to_csv(unfinished, index=False, float_format=DIGITS)
    described = {"columns": [_column(name, table[name], columns) for name in table]}
    describe(path, title=title, sources=sources, lineage=lineage, tableSchema=described)


def read(path: str | Path, **how: Any) -> pd.DataFrame:
    """Read a table as `pandas.read_csv`; how : more arguments of it."""
    with reading.opened(path, reading.MOST_TEXT) as file:
        try:
            return pd.read_csv(file, **how)
        except ValueError as error:  # what pandas raises is of it, too
            raise InputError(f"{path}: not a table of comma-separated values ({error})") from None


def read_as_text(path: str | Path) -> pd.DataFrame:
    """Read a table with each value as it is written."""
    return read(path, dtype=str, keep_default_na=False)


def _column(name: str, values: pd.Series, columns: dict[str, str]) -> dict:
    described = {"name": name, "datatype": _datatype(values)}
    if name in columns:
        return described | {"dc:description": columns[name]}
    if name in QUANTITIES:
        quantity = QUANTITIES[name]
        titles = {"titles": [name, quantity.symbol]} if quantity.symbol else {}
        return (
            described
            | titles
            | {"dc:description": quantity.description, "unit": UNITS[quantity.unit]}
        )
    return described


def _datatype(values: pd.Series) -> str:
    if pd.api.types.is_bool_dtype(values):
        return "boolean"
    if pd.api.types.is_integer_dtype(values):
        return "integer"
    return "number" if pd.api.types.is_numeric_dtype(values) else "string"
