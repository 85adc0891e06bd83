"""CSV files, and beside each what made it and what its columns are.

The metadata follow CSV on the Web (W3C, https://www.w3.org/TR/tabular-metadata/): NAME.csv stays
plain, NAME.csv-metadata.json describes it.
"""

from pathlib import Path

import pandas as pd

from beltrepro import provenance
from beltrepro.datasets.quantities import QUANTITIES, UNITS

DIGITS = "%.6g"


def write(
    path, table: pd.DataFrame, *, title: str, columns: dict[str, str], sources: dict[str, dict]
) -> None:
    """Write a table and its metadata.

    Parameters
    ----------
    path : path-like
        The CSV file; missing folders are made.
    table : DataFrame
        Numbers are written with six digits.
    title : str
        One sentence.
    columns : dict
        What single columns are; quantities of a point explain themselves.
    sources : dict
        What was told to the datasets that it is derived from, by name.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    described = {"columns": [_column(name, table[name], columns) for name in table]}
    provenance.write_about(path, title=title, sources=sources, tableSchema=described)
    table.to_csv(path, index=False, float_format=DIGITS)


def _column(name: str, values: pd.Series, columns: dict[str, str]) -> dict:
    described = {"name": name, "datatype": _datatype(values)}
    if name in columns:
        return described | {"dc:description": columns[name]}
    if name in QUANTITIES:
        each = QUANTITIES[name]
        titles = {"titles": [name, each.symbol]} if each.symbol else {}
        return described | titles | {"dc:description": each.description, "unit": UNITS[each.unit]}
    return described


def _datatype(values: pd.Series) -> str:
    if pd.api.types.is_bool_dtype(values):
        return "boolean"
    if pd.api.types.is_integer_dtype(values):
        return "integer"
    return "number" if pd.api.types.is_numeric_dtype(values) else "string"
