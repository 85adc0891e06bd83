"""Results as tables of pandas, in notebooks too, and as pictures of one panel."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import wraps
from html import escape
from inspect import cleandoc, signature
from textwrap import shorten
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from beltrepro.base import names
from beltrepro.base.checks import shown
from beltrepro.base.errors import needing

if TYPE_CHECKING:
    import pandas as pd

F = TypeVar("F", bound=Callable[..., Any])

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


_HEAD = "\n\nParameters\n----------\n"
_PLACE = """path : str or Path, optional
    The file to write, .png, .pdf or .svg.
ax : matplotlib.axes.Axes, optional
    Where to draw. Without it and a path the picture is shown, if there is a display: in a window
    until that is closed, or in a notebook.
"""
_REST = """**look : keywords
    color, linewidth, label and the like, as matplotlib names them.

Returns
-------
matplotlib.axes.Axes
    The axes, new ones if none are given; no figure is left open.

Raises
------
InputError
    A value or the name of a keyword is not allowed, or matplotlib is not installed.
"""


def one_panel(method: F) -> F:
    """Decorate a method that draws into `ax`: new ones if there are none, and into a file.

    Its docstring has what it takes by itself, and gets what all such methods have in common.
    """
    arguments = [*signature(method).parameters][1:-1]

    @wraps(method)
    def plot(result: Any, path: Any = None, *, ax: Any = None, **how: Any) -> Any:
        with needing("a picture"):
            from beltrepro.simulation import picture
        how = picture.keywords(method.__qualname__, how, arguments)
        return picture.panel(lambda axes: method(result, ax=axes, **how), path, ax, repr(result))

    head, _, words = cleandoc(method.__doc__ or "").partition(_HEAD)
    plot.__doc__ = head + _HEAD + _PLACE + (f"{words}\n" if words else "") + _REST
    return cast(F, plot)


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
