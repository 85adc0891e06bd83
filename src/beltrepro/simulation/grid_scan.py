"""What a scan measures, over a grid of chains: one call, one table."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np

from beltrepro.base import atomic, checks, names, provenance, store
from beltrepro.base.errors import InputError, needing
from beltrepro.model import ChainParameters
from beltrepro.simulation import scan

if TYPE_CHECKING:
    import pandas as pd

T = TypeVar("T")
Axis: TypeAlias = T | Sequence[T]
"""One value of a quantity, or the values that it takes in turn."""
Progress = Callable[[float], None]

SUFFIXES = (".csv", ".h5")
KIND = "grid scan"
MOST_POINTS = 1_000_000  # each is a run
_PAPER = ChainParameters(n_blocks=1, belt_velocity=1.0)


@dataclass(frozen=True, eq=False, repr=False)
class GridScan:
    """What a scan has measured at the P points of a grid, in model units.

    Attributes
    ----------
    arrays : dict of arrays with first axis P
        A column for each quantity of a chain and for the replicate; what `scan` measures.
    settings : dict
        duration, transient, method, time_step, seed, initial_spread; tolerance, if one was given.
    """

    arrays: dict[str, np.ndarray]
    settings: dict[str, Any]

    def __repr__(self) -> str:
        points = len(self.arrays["replicate"])
        return f"GridScan({points} points of {', '.join(self.axes) or 'one chain'})"

    @property
    def axes(self) -> list[str]:
        """Names of the quantities that have more than one value."""
        quantities = (*vars(_PAPER), "replicate")
        return [name for name in quantities if len(np.unique(self.arrays[name])) > 1]

    def table(self) -> pd.DataFrame:
        """The points as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            A row for each point, a column for each array that has one number for a point; of the
            others `arrays` has all.

        Raises
        ------
        InputError
            pandas is not installed.
        """
        with needing("the table of a scan"):
            import pandas as pd
        columns = {name: values for name, values in self.arrays.items() if values.ndim == 1}
        return pd.DataFrame(columns)

    @names.checked
    def save(self, path: str | Path) -> None:
        """Write the table as CSV, or all arrays with the settings as HDF5.

        Parameters
        ----------
        path : str or Path
            The file, .csv or .h5; it appears under its name when it is complete.

        Raises
        ------
        InputError
            It is no path, or has another ending; or it is .csv and pandas is not installed.
        """
        path = checks.path("path", path)
        if path.suffix.lower() not in SUFFIXES:
            raise InputError(f"path = {path}: must end in {', '.join(SUFFIXES)}")
        if path.suffix.lower() == ".csv":
            with atomic.replacing(path) as unfinished:
                self.table().to_csv(unfinished, index=False)
            return
        known = {name: value for name, value in self.settings.items() if value is not None}
        store.write(path, self.arrays, provenance.origin() | {"kind": KIND} | known)


@names.checked
def scan_grid(
    *,
    n_blocks: Axis[int],
    belt_velocity: Axis[float],
    noise: Axis[float] = _PAPER.noise,
    static_friction: Axis[float] = _PAPER.static_friction,
    friction_ratio: Axis[float] = _PAPER.friction_ratio,
    rest_length: Axis[float] = _PAPER.rest_length,
    linear_limit: Axis[float] = _PAPER.linear_limit,
    compression_rate: Axis[float] = _PAPER.compression_rate,
    extension_rate: Axis[float] = _PAPER.extension_rate,
    replicates: int = 1,
    duration: float,
    transient: float = 0.0,
    method: str = "event",
    time_step: float = 0.001,
    tolerance: float | None = None,
    seed: int = 1,
    initial_spread: float = 1.0,
    section_values: int = 0,
    laminar_time: float = 200.0,
    progress: Progress | None = None,
) -> GridScan:
    """Measure r and what else `scan` does at every combination of some values.

    Parameters
    ----------
    n_blocks : int or sequence of int
        Number of blocks N, at most 10.
    belt_velocity : float or sequence of float
        Velocity u of the belt.
    noise : float or sequence of float
        Standard deviation sigma of the static friction force.
    static_friction, friction_ratio : float or sequence of float
        F_st0 and f_s.
    rest_length, linear_limit : float or sequence of float
        l and Delta l_max of the springs.
    compression_rate, extension_rate : float or sequence of float
        b_1 and b_2 of the springs.
    replicates : int
        Runs at each combination, with other random numbers: replicates 0, 1, ...
    duration, transient : float
        As in `simulate`.
    method : str
        "event", the exact dynamics, or "verlet", the scheme of the paper.
    time_step : float
        As in `simulate`.
    tolerance : float, optional
        As in `simulate`.
    seed : int
        As in `simulate`.
    initial_spread : float
        Standard deviation of the displacements at the start of replicates other than 0.
    section_values : int
        As in `scan`.
    laminar_time : float
        As in `scan`.
    progress : callable, optional
        Called with the fraction done; `beltrepro.Progress("scan")` shows a bar.

    Returns
    -------
    GridScan
        A point for each combination, in the order of the arguments: the replicate varies fastest.

    Raises
    ------
    InputError
        A value is not allowed, or there are more than a million points.
    ModelStateError
        A state left the range of the model.
    """
    given = locals()
    axes = {name: _values(name, given[name]) for name in vars(_PAPER)}
    copies = checks.key("replicates", replicates)
    count = copies * math.prod(map(len, axes.values()))
    if not 1 <= count <= MOST_POINTS:
        largest = max(axes, key=lambda name: len(axes[name]))
        name = "replicates" if copies in (0, count) else largest
        raise InputError(f"{name}: makes {count} points, allowed are 1 to {MOST_POINTS}")
    chains = [
        ChainParameters(*values)
        for values in itertools.product(*axes.values())
        for _ in range(copies)
    ]
    settings: dict[str, Any] = {
        "duration": duration,
        "transient": transient,
        "method": _single("method", method),
        "time_step": _single("time_step", time_step),
        "tolerance": _single("tolerance", tolerance),
        "seed": checks.key("seed", seed),
        "initial_spread": _single("initial_spread", initial_spread),
    }
    measured = scan(
        chains,
        replicate=list(range(copies)) * (count // copies),
        section_values=section_values,
        laminar_time=laminar_time,
        progress=progress,
        **settings,
    )
    quantities = {
        name: np.array([getattr(chain, name) for chain in chains]) for name in vars(_PAPER)
    }
    return GridScan(quantities | measured, settings)


def _values(name: str, given: Any) -> list:
    """The values of an axis; whether each is right, its chain will say."""
    if not checks.is_sequence(given):
        return [given]
    values = list(given)
    if not values:
        raise InputError(f"{name} is empty: at least one number is needed")
    return values


def _single(name: str, value: T) -> T:
    """The value of what is the same at all points."""
    if checks.is_sequence(value):
        raise InputError(f"{name} = {checks.shown(value)}: one value is needed, for all points")
    return value
