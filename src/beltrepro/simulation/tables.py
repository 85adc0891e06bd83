"""Results as tables of pandas, in notebooks too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from html import escape
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import names
from beltrepro.base.checks import shown
from beltrepro.base.errors import needing

if TYPE_CHECKING:
    import pandas as pd

_OF_CHAIN = ("n_blocks", "belt_velocity", "noise")
_MOST_ROWS = 20  # in a notebook
OF_RUNS = "run/"  # begins the names of arrays that only the functions look at which make results


def frame(columns: Mapping[str, Any]) -> pd.DataFrame:
    """A table of pandas with these columns."""
    with needing("a table"):
        import pandas as pd

    return pd.DataFrame(dict(columns))


def blocks(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """Values (T, N) as a column for each block, from 1."""
    return {f"{name}_{number}": column for number, column in enumerate(values.T, start=1)}


def html(result: Any) -> str:
    """What a notebook shows of a result: its line and the first rows of its table."""
    return f"<p>{escape(repr(result))}</p>{result.table().head(_MOST_ROWS).to_html()}"


def brief(result: Any) -> str:
    """The numbers and texts of a dataclass in one line, to six digits."""
    values = {field.name: getattr(result, field.name) for field in fields(result)}
    texts = {name: one for name, one in values.items() if isinstance(one, str | int | float)}
    texts |= {name: f"{one:.6g}" for name, one in values.items() if isinstance(one, float)}
    return ", ".join(f"{name}={text}" for name, text in texts.items())


class Arrays(dict[str, np.ndarray]):
    """Arrays by name."""

    def __missing__(self, name: object) -> Any:
        meant = names.hint(name, self) if isinstance(name, str) else ""
        there = f": there are {shorten(', '.join(self), 300)}"
        raise KeyError(f"no array {shown(name)}{meant or there}")

    _repr_html_ = html


class Tabled:
    """A result that is a dataclass: with a table, and its fields by name."""

    def _columns(self) -> dict[str, Any]:
        """The columns of the table: one row of the numbers and texts, if it is not told."""
        row: dict[str, Any] = {}
        for name in (field.name for field in fields(self)):  # type: ignore[arg-type]
            value = getattr(self, name)
            if name == "parameters":
                row |= {quantity: getattr(value, quantity) for quantity in _OF_CHAIN}
            elif isinstance(value, str | int | float):
                row[name] = value
        return {name: [value] for name, value in row.items()}

    def table(self) -> pd.DataFrame:
        """The result as a table of pandas.

        A row for each sample of a run, exponent of a spectrum, attractor at each value or orbit of
        a branch; of others one row. InputError if pandas is not installed.
        """
        return frame(self._columns())

    def __getitem__(self, name: str) -> Any:
        """What the field of this name holds."""
        public = [word for word in dir(self) if not word.startswith("_")]
        return getattr(self, names.one_of("name", name, public))

    _repr_html_ = html
