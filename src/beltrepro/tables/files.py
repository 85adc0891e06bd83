"""CSV files, and beside each what made it, what its columns are, and its checksum.

The metadata follow CSV on the Web (W3C, https://www.w3.org/TR/tabular-metadata/): NAME.csv stays
plain, NAME.csv-metadata.json describes it.
"""

import hashlib
import json
from pathlib import Path

import pandas as pd

from beltrepro import provenance
from beltrepro.atomic import replacing
from beltrepro.datasets.files import repair
from beltrepro.datasets.quantities import QUANTITIES, UNITS
from beltrepro.errors import InputError

DIGITS = "%.6g"


def write(
    path,
    table: pd.DataFrame,
    *,
    title: str,
    columns: dict[str, str],
    sources: dict[str, dict],
    lineage: dict[str, dict] | None = None,
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
    lineage : dict, optional
        What made those datasets, see `beltrepro.inputs`.
    """
    path = Path(path)
    content = table.to_csv(index=False, float_format=DIGITS).encode()
    about = {
        "@context": "http://www.w3.org/ns/csvw",
        "url": path.name,
        "dc:title": title,
        "dc:source": sources,
        "beltrepro:origin": provenance.origin(),
        "beltrepro:lineage": lineage or {},
        "beltrepro:checksum": checksum(content),
        "tableSchema": {"columns": [_column(name, table[name], columns) for name in table]},
    }
    with replacing(metadata_path(path)) as unfinished:
        unfinished.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")
    with replacing(path) as unfinished:
        unfinished.write_bytes(content)


def check(path: Path, expected: dict) -> None:
    """Check that a table is whole and is what it should be.

    expected : preset and run, and in `sources` what was told to the datasets and tables that it is
    derived from, by name.

    Raises InputError, with the command that makes it again.
    """
    try:
        content = path.read_bytes()
        about = json.loads(metadata_path(path).read_text(encoding="utf-8"))
        known = about["url"], about["beltrepro:checksum"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        reason = f"cannot be read with its metadata ({type(error).__name__})"
    else:
        if known != (path.name, checksum(content)):
            reason = "damaged, or another table: it does not have its checksum"
        elif about.get("dc:source") != json.loads(json.dumps(expected["sources"])):
            reason = "was derived from other datasets"
        else:
            return
    raise InputError(f"{path}: {reason}; {repair(path, expected)}")


def lineage(path: Path) -> dict[str, dict]:
    """What made the datasets behind a table, as it was written beside it.

    Raises InputError for a table of an older version, which does not say it.
    """
    about = json.loads(metadata_path(path).read_text(encoding="utf-8"))
    if "beltrepro:lineage" not in about:
        raise InputError(
            f"{path}: of an older version, without what made its datasets; remove it and run the "
            "same command again"
        )
    return about["beltrepro:lineage"]


def checksum(content: bytes) -> str:
    """Sixteen hexadecimal digits of the bytes of a file."""
    return hashlib.sha256(content).hexdigest()[:16]


def metadata_path(path: Path) -> Path:
    """Where the metadata of a CSV file lie."""
    return path.with_name(f"{path.name}-metadata.json")


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
