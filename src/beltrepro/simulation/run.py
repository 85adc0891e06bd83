"""One simulated chain as a value: what made it and what it did."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import needing
from beltrepro.engine.state import ChainState, equal_fields
from beltrepro.model import ChainParameters
from beltrepro.observe import sum_rule
from beltrepro.simulation.run_file import load_run, save_run
from beltrepro.simulation.tables import Tabled, blocks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NUMBERS = [(name, "f8") for name in ("force", "position", "dissipated")]
EVENT = np.dtype([("time", "f8"), ("block", "i8"), ("kind", "U5"), *_NUMBERS])


@dataclass(frozen=True, eq=False, repr=False)
class Run(Tabled):
    """One simulated chain, in model units.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    method : str
        "verlet" or "event".
    duration, transient : float
        Time simulated, and the first part of it that r and <x_N> leave out.
    time_step : float
        dt of the scheme; for "event" it sets the strength of the noise.
    tolerance : float or None
        Truncation allowed in a step, unit of force (the method's own may be larger with noise);
        None for a method without one.
    seed, replicate : int
        With the parameters they fix all random numbers.
    sample_interval : float or None
        Time between samples; None if none were kept.
    sample_start : float
        The first part of the run that has no samples.
    initial_state, final_state : ChainState
        Where the run began and ended; a run can begin at either.
    version : str
        Of the package that made the run.
    disorder_parameter, mean_length : float
        r and <x_N> after the transient (Eq. 4).
    energy_residual : float
        Share of the belt's work that the energy audit does not account for.
    time : array (T,)
        Instants of the samples, counted like those of the states.
    positions, velocities, friction : array (T, N)
        Samples in the laboratory frame; friction is the friction force on each block (while stuck
        minus the external force).
    events : structured array (E,)
        time; block, from 1; kind, "slip" or "stick"; force, the external force F_ex there;
        position; dissipated, the friction loss of that block since the energy audit began (see
        `ChainState`). A block that reverses without sticking has a stick and a slip at one time.
    """

    parameters: ChainParameters
    method: str
    duration: float
    transient: float
    time_step: float
    tolerance: float | None
    seed: int
    replicate: int
    sample_interval: float | None
    sample_start: float
    initial_state: ChainState
    final_state: ChainState
    version: str
    disorder_parameter: float
    mean_length: float
    energy_residual: float
    time: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    friction: np.ndarray
    events: np.ndarray

    def __repr__(self) -> str:
        start, end = self.initial_state.time, self.final_state.time
        return (
            f"Run({self.parameters.describe()}, {self.method}, t={start:g} to {end:g}: "
            f"r={self.disorder_parameter:.6g}, <x_N>={self.mean_length:.6g}, "
            f"{len(self.time)} samples, {len(self.events)} events)"
        )

    def _columns(self) -> dict[str, np.ndarray]:
        moving = blocks("position", self.positions) | blocks("velocity", self.velocities)
        return {"time": self.time, **moving, **blocks("friction", self.friction)}

    def __eq__(self, other: object) -> bool:
        """Whether all numbers are the same bit by bit; NaN equals NaN."""
        if not isinstance(other, Run):
            return NotImplemented
        return equal_fields(self, other)

    @property
    def mean_wall_tension(self) -> float:
        """Exact mean of the first spring's pull over the whole run, unit of force."""
        return float(sum_rule.mean_wall_tension([self.initial_state], [self.final_state])[0])

    @property
    def sum_rule_residual(self) -> float:
        """What the sum rule does not explain of it, as a share of N k (docs/physics.md).

        Without noise that is rounding for "event", and of the order of dt for "verlet".
        """
        columns = [self.events[name] for name in ("time", "block", "force", "position")]
        time, block, force, position = columns
        place = position - self.parameters.rest_positions[block - 1]
        slips = self.events["kind"] == "slip"
        forward = sum_rule.ForwardSlip([self.initial_state])
        rows = np.column_stack([time, block - 1, slips, force, place])
        forward.follow(rows[None], np.array([len(rows)]))
        ends = [self.initial_state], [self.final_state]
        return float(sum_rule.sum_rule_residual(*ends, forward.way(ends[1]))[0])

    @names.checked
    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw x_N(t), r as it settles, and the slips of each block at the end of the run.

        Parameters
        ----------
        path : str or Path, optional
            The file to write, .png, .pdf or .svg. Without it the figure is shown: in a window until
            that is closed, or in a notebook.

        Returns
        -------
        matplotlib.figure.Figure
            The figure, to be changed.

        Raises
        ------
        InputError
            The path has another ending, or there is none and no display either; or matplotlib is
            not installed.
        """
        with needing("a picture of a run"):
            from beltrepro.simulation import picture
        return picture.plot(self, None if path is None else checks.path("path", path))

    @names.checked
    def save(self, path: str | Path) -> None:
        """Write the run to an HDF5 file, from which `load` makes an equal one.

        Parameters
        ----------
        path : str or Path
            The file; it appears under its name when it is complete.

        Raises
        ------
        InputError
            It is no path.
        """
        save_run(checks.path("path", path), self)

    @classmethod
    @names.checked
    def load(cls, path: str | Path) -> Run:
        """Read a run that `save` wrote.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Run
            Equal to the one that was saved.

        Raises
        ------
        InputError
            The file is missing, damaged, or holds something else.
        """
        return load_run(checks.path("path", path), cls)
