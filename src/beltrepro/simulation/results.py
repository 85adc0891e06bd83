"""What was measured of several chains: arrays by name, a row for each chain."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import atomic, checks, names, provenance, store
from beltrepro.base.errors import InputError
from beltrepro.engine.state import ChainState
from beltrepro.model.units import TEXTS, UNIT_OF
from beltrepro.simulation.grid import QUANTITIES
from beltrepro.simulation.packed import unpacked
from beltrepro.simulation.tables import OF_RUNS, Arrays, frame, one_panel

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

KEY = OF_RUNS + "key"
# Quantities of the setup that all chains of a table share as a rule
_MEANS = ("method", "time_step", "tolerance", "initial_spread", "seed")
SLIP_COLUMNS = 10  # of slip_count, at least: results of chains of few blocks are of one shape
# Axes of arrays after that of the chains, where they are not the blocks.
_AXES = {"section_velocity": "crossing", "section_histogram": "bin", "return_state": "coordinate"}
_AXES |= {"exponents": "exponent", "standard_error": "exponent", "growth": "stretch exponent"}


class Results(Arrays):
    """What was measured of P chains: a dict of arrays with first axis P, in model units.

    What each chain is and how it was advanced comes first, then what the function has measured.
    Where the vectors of a chain are shorter than those of another they end with NaN, counts with 0.

    Attributes
    ----------
    settings : dict
        What the function was told beside the setup, and its name.
    """

    def __init__(self, arrays: Mapping[str, np.ndarray], settings: dict[str, Any]) -> None:
        of_runs = {name: array for name, array in arrays.items() if name.startswith(OF_RUNS)}
        super().__init__({name: array for name, array in arrays.items() if name not in of_runs})
        self.settings = settings
        self.of_runs = of_runs  # arrays (P, ...) that are no columns

    @cached_property
    def final_states(self) -> list[ChainState] | None:
        """Where the chains have ended, of `scan` and `time_to_continuous_slip`.

        As `initial_state` they continue it. A chain that has failed has a state of NaN, from which
        it fails again.
        """
        return unpacked(self | self.of_runs)

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

    @one_panel
    def plot(
        self, path: str | Path | None = None, *, ax: Any = None, y: str = "disorder_parameter",
        x: str | None = None, by: str | Sequence[str] | None = None,
        where: Mapping[str, Any] | None = None, **look: Any,
    ) -> Axes:  # fmt: skip
        """Draw an array along a quantity: the mean of the replicates, and a band of 10 to 90 %.

        Parameters
        ----------
        y, x : str
            Arrays of one number for each chain. If x is not given, it is the quantity of most
            values.
        by : str or sequence of str, optional
            What has a curve for each of its values; if not given, the other quantities that differ.
        where : dict, optional
            Values of quantities, as {"noise": 1}: only such chains are drawn.
        """
        from beltrepro.simulation import plots

        return plots.results(ax, self, y, x, by, where, look)

    @one_panel
    def plot_section(
        self, path: str | Path | None = None, *, ax: Any = None, x: str | None = None,
        where: Mapping[str, Any] | None = None, bins: int | None = None, bar: bool = True,
        **look: Any,
    ) -> Axes:  # fmt: skip
        """Draw the density of v_N at the section along a quantity: a bifurcation diagram.

        Parameters
        ----------
        x : str, optional
            The quantity; if not given, that of most values. At each of its values the density is
            that of the crossings kept there, or of all with `section_bins`; its integral is 1. At a
            section of the last block itself its place is fixed, and v_N is all that is left.
        where : dict, optional
            Values of the other quantities, as {"noise": 1}: only such chains are drawn.
        bins : int, optional
            Of v_N; if not given those of `section_bins`, or 120 to 400, by how many crossings there
            are.
        bar : bool
            Whether to draw the scale of the colours, which is logarithmic.
        """
        from beltrepro.simulation import plots

        return plots.section(ax, self, x, where, bins, bar, look)

    @names.checked
    def joined(self, other: Results) -> Results:
        """These results and those of further chains, as one table.

        Parameters
        ----------
        other : Results
            Of the same function with the same settings.

        Returns
        -------
        Results
            First the chains of this one, then those of `other` that it has not: a run of the same
            chain, replicate and start is there once.

        Raises
        ------
        InputError
            A setting differs, which the line names with both its values; or one of the two is of a
            file of an earlier version.
        """
        if not isinstance(other, Results):
            raise InputError(f"other = {checks.shown(other)}: Results are needed")
        refuse_others("other", other, self)
        return together(self, other)

    @names.checked
    def save(self, path: str | Path) -> None:
        """Write the table as CSV, or all arrays with the settings as HDF5, over what is there.

        Parameters
        ----------
        path : str or Path
            The file, .csv or .h5; it appears under its name when it is complete. An .h5 has named
            axes and units, with `xarray.open_dataset` too, which needs h5netcdf.

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
            mixed = f"{TEXTS['length']}, then {TEXTS['velocity']}"
            about.get("return_state", {})["units"] = mixed
            axes = {name: ["chain", *_AXES.get(name, "block").split()] for name in self}
            attributes = provenance.origin() | self.settings | order
            store.write(path, self | self.of_runs, attributes, about, axes)

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
        results = cls._of_file(path)
        if results.settings.get("kind") == "catalogue":
            again = f"catalogue(..., store={str(path)!r}), called as before, reads it"
            raise InputError(f"{path}: the store of a catalogue; {again}")
        return results

    @classmethod
    def _of_file(cls, path: str | Path) -> Results:
        data = store.read(checks.path("path", path))
        if data.attributes.get("kind") == "run":
            raise InputError(f"{path}: a run, not results; Run.load reads it")
        if missing := [name for name in (*QUANTITIES, "replicate") if name not in data.arrays]:
            raise InputError(f"{path}: not a file of results: it lacks {missing[0]}")
        data.attributes.pop("coordinates", None)
        order = json.loads(data.attributes.pop("columns", "[]")) or data.arrays
        of_runs = [name for name in data.arrays if name.startswith(OF_RUNS)]
        table = {name: data.arrays[name] for name in (*order, *of_runs)}
        return cls(table, data.attributes)


def refuse_others(what: str, held: Results, new: Results, going_on: bool = False) -> None:
    """That results were made with the settings of others, beside which they shall stand.

    Of a quantity of the setup chains of one table may have several values: they share one. Those
    that go on from others have no initial spread.
    """
    if not (KEY in held.of_runs and KEY in new.of_runs):
        raise InputError(f"{what}: its runs have no keys, as in files of earlier versions")
    values: dict[str, list[list]] = {}
    for name in dict.fromkeys((*new.settings, *held.settings)):
        if name not in provenance.origin():
            pair = [np.array(result.settings.get(name, "none")) for result in (held, new)]
            values[name] = [[value.tolist()] for value in pair]  # a file has arrays for lists
    means = [name for name in _MEANS if not (going_on and name == "initial_spread")]
    values |= {name: [result[name].tolist() for result in (held, new)] for name in means}
    for name, pair in values.items():
        there, here = (dict.fromkeys(map(str, some)) for some in pair)
        if there.keys().isdisjoint(here):
            texts = (checks.shown(", ".join(some)).strip("'") for some in (there, here))
            raise InputError("{}: {} is {} there and {} here".format(what, name, *texts))


def keys_of(results: Results) -> list[str]:
    """The keys of the runs: those of one key are the same run."""
    return results.of_runs[KEY].tolist()


def some_of(results: Results, rows: list[int]) -> Results:
    """Results of some of the chains."""
    count, arrays = len(results["replicate"]), results | results.of_runs
    for name, array in arrays.items():
        if np.asarray(array).dtype.names:
            ends = (np.searchsorted(array["point"], rows, side) for side in ("left", "right"))
            ranges = [np.arange(*pair) for pair in zip(*ends, strict=True)]
            arrays[name] = array[np.concatenate([np.zeros(0, int), *ranges])]
            arrays[name]["point"] = np.repeat(np.arange(len(rows)), [*map(len, ranges)])
        elif np.shape(array)[:1] == (count,):
            arrays[name] = np.asarray(array)[rows]
    return Results(arrays, results.settings)


def cut(results: Results) -> None:
    """Make the arrays as wide as those of its chains alone, where there were longer ones."""
    size = int(results["n_blocks"].max())
    for name, array in results.items():
        ends = {"block": max(size, SLIP_COLUMNS * (name == "slip_count")), "exponent": 2 * size}
        words = _AXES.get(name, "block").split()[: array.ndim - 1]
        results[name] = array[(slice(None), *(slice(ends.get(word)) for word in words))]


def together(*parts: Results) -> Results:
    """Results of some chains, and below them those of others, without runs that are above."""
    settings, seen, tables = parts[0].settings, set(), []
    for part in parts:
        keys = keys_of(part)
        fresh = some_of(part, [row for row, key in enumerate(keys) if key not in seen])
        tables.append(fresh | fresh.of_runs)
        seen.update(keys)
    if any("code_version" in part.settings for part in parts):
        settings = settings | provenance.of_all(provenance.origin() | one.settings for one in parts)
    return Results(in_one_table(tables), settings)


def in_one_table(tables: Sequence[Mapping[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """The arrays of several results, those that are no columns too, their chains in order."""
    sizes = [table["n_blocks"] for table in tables]
    rows = np.split(np.arange(sum(map(len, sizes))), np.cumsum([len(size) for size in sizes])[:-1])
    all_sizes, arrays = np.concatenate(sizes), {}
    for name in dict.fromkeys(name for table in tables for name in table):
        held = [pair for pair in zip(rows, tables, strict=True) if name in pair[1]]
        pieces = [(row, np.asarray(table[name])) for row, table in held]
        if any(array.ndim > 1 for _, array in pieces):
            pieces = [(row, _by_block(array, all_sizes[row])) for row, array in pieces]
        is_of_chains = all(one.dtype.names or one.shape[:1] == row.shape for row, one in pieces)
        arrays[name] = in_rows(len(all_sizes), pieces) if is_of_chains else pieces[0][1]
    return arrays


def in_rows(total: int, pieces: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Arrays (W, ...), each with the numbers of its rows, as one (P, ...).

    It is padded with NaN, 0 or an empty text, and has these in rows that no array has. Records,
    which name the row of their chain as `point`, come in the order of the rows.
    """
    if pieces[0][1].dtype.names:
        return _records(pieces)
    shape = np.max([array.shape[1:] for _, array in pieces], axis=0).astype(int)
    dtype = np.result_type(*(array for _, array in pieces))
    joined = np.zeros((total, *shape), dtype)
    if dtype.kind == "f":
        joined[...] = np.nan
    for rows, array in pieces:
        corner: Any = (rows, *map(slice, array.shape[1:]))
        joined[corner] = array
    return joined


def _records(pieces: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Records of chains as one table; their vectors are padded with NaN."""
    dtype = max((array.dtype for _, array in pieces), key=lambda dtype: dtype.itemsize)
    tables = []
    for rows, array in pieces:
        table = np.zeros(len(array), dtype)
        for name in array.dtype.names or ():
            if dtype[name].shape:
                table[name] = np.nan
            table[name][..., : array[name].shape[-1]] = array[name]
        table["point"] = rows[array["point"]]
        tables.append(table)
    joined = np.concatenate(tables)
    return joined[np.argsort(joined["point"], kind="stable")]


def _by_block(values: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Constants (P,) of chains of these sizes as those of their blocks (P, N), if they are none."""
    if values.ndim != 1:
        return values
    return np.where(np.arange(sizes.max(initial=0)) < sizes[:, None], values[:, None], np.nan)
