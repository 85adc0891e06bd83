"""What was measured of several chains: arrays by name, a row for each chain."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import atomic, checks, names, provenance, store
from beltrepro.base.errors import InputError
from beltrepro.model.units import TEXTS, UNIT_OF
from beltrepro.simulation.grid import QUANTITIES
from beltrepro.simulation.groups import Group, Report, in_groups
from beltrepro.simulation.setup import Setup, columns
from beltrepro.simulation.tables import Arrays, frame

if TYPE_CHECKING:
    import pandas as pd

Measure = Callable[[Group], dict[str, np.ndarray]]
# Axes of arrays after that of the chains, where they are not the blocks.
_AXES = {"section_velocity": "crossing", "return_state": "coordinate", "exponents": "exponent"}
_AXES |= {"standard_error": "exponent", "growth": "stretch exponent"}


class Results(Arrays):
    """What was measured of P chains: a dict of arrays with first axis P, in model units.

    What each chain is and how it was advanced comes first, then what the function has measured.
    Where the vectors of a chain are shorter than those of another they end with NaN, counts with 0.

    Attributes
    ----------
    settings : dict
        What the function was told beside the setup, and its name.
    """

    def __init__(self, arrays: dict[str, np.ndarray], settings: dict[str, Any]) -> None:
        super().__init__(arrays)
        self.settings = settings

    def __repr__(self) -> str:
        chains = len(self["replicate"])
        return f"Results({chains} of {', '.join(self.axes) or 'one chain'}: {', '.join(self)})"

    def __getitem__(self, name: Any) -> Any:
        """The array of this name, or by the number of a chain what was measured of it."""
        if isinstance(name, bool) or not isinstance(name, int | np.integer):
            return super().__getitem__(name) if isinstance(name, str) else self.__missing__(name)
        chains = len(self["replicate"])
        if not -chains <= name < chains:
            raise IndexError(f"chain {name} of {chains}")  # it ends a loop over the chains
        return {word: one[name] for word, one in self.items() if np.shape(one)[:1] == (chains,)}

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(names.left(name) or f"Results has no attribute {name!r}")

    @property
    def axes(self) -> list[str]:
        """Names of the quantities of a chain that have more than one value, with the replicate."""
        columns = {name: self[name] for name in (*QUANTITIES, "replicate")}
        return [name for name, column in columns.items() if (column != column[0]).any()]

    def table(self) -> pd.DataFrame:
        """The results as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            A row for each chain, a column for each array that has one number for a chain, and N
            columns for a constant that differs among the blocks: mass_1, mass_2, ...

        Raises
        ------
        InputError
            pandas is not installed.
        """
        shape = self["replicate"].shape
        columns = {name: array for name, array in self.items() if np.shape(array) == shape}
        if np.isnan(columns.get("tolerance", 0.0)).all():  # of methods that have none
            del columns["tolerance"]
        for name in QUANTITIES:
            if self[name].ndim > 1:
                columns |= {f"{name}_{i}": one for i, one in enumerate(self[name].T, start=1)}
        return frame(columns)

    @names.checked
    def save(self, path: str | Path) -> None:
        """Write the table as CSV, or all arrays with the settings as HDF5, over what is there.

        Parameters
        ----------
        path : str or Path
            The file, .csv or .h5; it appears under its name when it is complete. An .h5 has named
            axes and units, with `xarray.open_dataset` too.

        Raises
        ------
        InputError
            It is no path, or has another ending; or it is .csv and pandas is not installed.
        """
        path = checks.path("path", path, (".csv", ".h5"))
        if path.suffix.lower() == ".csv":
            with atomic.replacing(path) as unfinished:
                self.table().to_csv(unfinished, index=False)
        else:
            # the file has the arrays by name, and xarray takes coordinates from here
            order = {"columns": json.dumps(list(self)), "coordinates": " ".join(self.axes)}
            about = {name: {"units": TEXTS[UNIT_OF.get(name, "1")]} for name in self}
            axes = {name: ["chain", *_AXES.get(name, "block").split()] for name in self}
            store.write(path, self, provenance.origin() | self.settings | order, about, axes)

    @classmethod
    @names.checked
    def load(cls, path: str | Path) -> Results:
        """Read results that `save` wrote as HDF5.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Results
            With the arrays that were saved; its settings say too what made the file.

        Raises
        ------
        InputError
            The file is missing, damaged, or holds something else.
        """
        if checks.path("path", path).suffix.lower() == ".csv":
            raise InputError(f"path = {path}: pandas.read_csv reads a table; this needs an .h5")
        data = store.read(path)
        if missing := [name for name in (*QUANTITIES, "replicate") if name not in data.arrays]:
            raise InputError(f"{path}: not a file of results: it lacks {missing[0]}")
        data.attributes.pop("coordinates", None)
        order = json.loads(data.attributes.pop("columns", "[]")) or data.arrays
        return cls({name: data.arrays[name] for name in order}, data.attributes)


def gathered(
    kind: str, setup: Setup, measure: Measure, progress: Report | None, **settings: Any
) -> Results:
    """A row for each chain, of the arrays (W, ...) that are measured of each group."""
    measured = in_groups(setup.cases, measure, progress, workers=setup.workers)
    groups, parts = zip(*measured, strict=True)
    table = columns(setup)
    for name in list(parts[0]):
        # a scan of many chains is held but once
        table[name] = _joined(groups, [part.pop(name) for part in parts])
    return Results(table, {"kind": kind} | settings)


def _joined(groups: list[np.ndarray], arrays: list[np.ndarray]) -> np.ndarray:
    """Arrays (W, ...) of groups as one (P, ...), padded with NaN or 0."""
    shape = np.max([array.shape[1:] for array in arrays], axis=0).astype(int)
    dtype = np.result_type(*arrays)
    joined = np.full((sum(map(len, groups)), *shape), np.nan if dtype.kind == "f" else 0, dtype)
    for group, array in zip(groups, arrays, strict=True):
        corner: Any = (group, *map(slice, array.shape[1:]))
        joined[corner] = array
    return joined
