"""One simulated chain as a value: what made it and what it did.

Its HDF5 file has datasets time (T,), positions, velocities, friction (T, N) and events, as `Run`
names them; groups initial_state and final_state with the arrays of `ChainState`, and in them a
group scheme with the variables of the integrator. Of a belt that changes its velocity, belt has the
rows of `Run.belt`, and groups change_0, ... the states. All other values are attributes.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import checks, names, store
from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError, needing
from beltrepro.engine.state import ChainState, Scheme, equal_fields
from beltrepro.model import ChainParameters
from beltrepro.observe import sum_rule
from beltrepro.simulation.grid import QUANTITIES
from beltrepro.simulation.packed import OF_STATE
from beltrepro.simulation.tables import Tabled, blocks, one_panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ARRAYS = ("time", "positions", "velocities", "friction", "events")
_STATES = ("initial_state", "final_state")
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
        Truncation allowed in a step, as in `Setup` (the method's own may be larger with noise);
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
        Of the package that made the run, with its commit where that is known.
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
    changes : tuple of ChainState
        Where another velocity of the belt begins, as the chain was before; the audit begins there.
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
    changes: tuple[ChainState, ...] = ()

    def __repr__(self) -> str:
        start, end = self.initial_state.time, self.final_state.time
        more = f", then {len(self.changes)} other u" if self.changes else ""
        return (
            f"Run({self.parameters.describe()}{more}, {self.method}, t={start:g} to {end:g}: "
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
    def belt(self) -> list[tuple[float, float]]:
        """Since when, from the beginning of the run on, the belt has had which velocity."""
        begun = self.initial_state.time
        pieces = self._pieces()
        return [(begin.time - begun, end.parameters.belt_velocity) for begin, end in pieces]

    def _pieces(self) -> list[tuple[ChainState, ChainState]]:
        """First and last state at each velocity of the belt."""
        ends = *self.changes, self.final_state
        begins = [end.under(after.parameters) for end, after in pairwise(ends)]
        return list(zip([self.initial_state, *begins], ends, strict=True))

    @property
    def mean_wall_tension(self) -> float:
        """Exact mean of the first spring's pull over the whole run, unit of force."""
        begins, ends = map(list, zip(*self._pieces(), strict=True))
        times = [end.time - begin.time for begin, end in zip(begins, ends, strict=True)]
        return _mean(sum_rule.mean_wall_tension(begins, ends), times)

    @property
    def sum_rule_residual(self) -> float:
        """What the sum rule does not explain of it, as a share of N k (docs/physics.md).

        Without noise that is rounding for "event", and of the order of dt for "verlet". Of several
        velocities of the belt each counts by the way of the belt.
        """
        columns = [self.events[name] for name in ("time", "block", "force", "position")]
        time, block, force, position = columns
        place = position - self.parameters.rest_positions[block - 1]
        slips = self.events["kind"] == "slip"
        rows = np.column_stack([time, block - 1, slips, force, place])
        cuts = np.searchsorted(time, [state.time for state in self.changes], side="right")
        residuals, ways = [], []
        for (begin, end), part in zip(self._pieces(), np.split(rows, cuts), strict=True):
            forward = sum_rule.ForwardSlip([begin])
            forward.follow(part[None], np.array([len(part)]))
            ends = [begin], [end]
            residuals += sum_rule.sum_rule_residual(*ends, forward.way(ends[1])).tolist()
            ways.append((end.time - begin.time) * end.parameters.belt_velocity)
        return _mean(residuals, ways)

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
        path = None if path is None else checks.path("path", path)
        return picture.put(lambda: picture.draw(self), path, f"{self!r}, beltrepro {self.version}")

    @one_panel
    def plot_length(
        self, path: str | Path | None = None, *, ax: Any = None, window: Any = None, **look: Any
    ) -> Axes:
        """Draw x_N(t); of more samples than pixels the least and greatest x_N in each column.

        Parameters
        ----------
        window : pair of float, optional
            Begin and end of the time to show; all if not given.
        """
        from beltrepro.simulation import plots

        return plots.length(ax, self, window, look)

    @one_panel
    def plot_slips(self, path: str | Path | None = None, *, ax: Any = None, **look: Any) -> Axes:
        """Draw who slips when: a row for each block, with a bar for each slip.

        The last 200 time units are shown; `ax.set_xlim` moves the picture to others.
        """
        from beltrepro.simulation import plots

        return plots.slipping(ax, self, look)

    @one_panel
    def plot_phase(
        self, path: str | Path | None = None, *, ax: Any = None, block: int = -1,
        window: Any = None, **look: Any,
    ) -> Axes:  # fmt: skip
        """Draw the phase portrait of a block: its velocity by its position.

        Parameters
        ----------
        block : int
            From 1; -1 for the last one.
        window : pair of float, optional
            Begin and end of the time to show; what follows the transient if not given.
        """
        from beltrepro.simulation import plots

        return plots.phase(ax, self, block, window, look)

    @names.checked
    def save(self, path: str | Path) -> None:
        """Write the run to an HDF5 file, over one that is there; `load` makes an equal run of it.

        Parameters
        ----------
        path : str or Path
            The file, .h5; it appears under its name when it is complete.

        Raises
        ------
        InputError
            It is no path, or has another ending.
        """
        path = checks.path("path", path, (".h5",))
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        attributes = {"kind": "run", "units": "model units"}
        attributes |= {name: getattr(self, name) for name in _numbers()}
        for name, value in asdict(self.parameters).items():
            attributes[name] = json.dumps(value) if isinstance(value, tuple) else value
        states = {name: getattr(self, name) for name in _STATES}
        if self.changes:
            states |= {f"change_{number}": state for number, state in enumerate(self.changes)}
            arrays["belt"] = np.array(self.belt)
        for name, state in states.items():
            arrays |= {f"{name}/{part}": getattr(state, part) for part in OF_STATE}
            if scheme := state.scheme:
                attributes[f"{name}_integrator"] = scheme.integrator
                attributes[f"{name}_time_step"] = scheme.time_step
                arrays |= {f"{name}/scheme/{part}": one for part, one in scheme.variables.items()}
        given = {name: value for name, value in attributes.items() if value is not None}
        store.write(path, arrays, given)

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
        data = store.read(checks.path("path", path))
        stored = data.attributes
        if (kind := stored.get("kind")) != "run":
            raise InputError(f"{path}: not a run, but of kind {shown(kind)}")
        try:
            chain = ChainParameters(**{name: _constant(stored[name]) for name in QUANTITIES})
            values: dict[str, Any] = {name: stored.get(name) for name in _numbers()}
            values |= {name: data.arrays[name] for name in _ARRAYS}
            first, *later = data.arrays.get("belt", np.array([[0, chain.belt_velocity]]))[:, 1]
            places = [f"change_{number}" for number in range(len(later))]
            moving = [replace(chain, belt_velocity=u) for u in (first, *later)]
            places, moving = [_STATES[0], *places, _STATES[1]], [chain, *moving]
            states = [_state(*pair, data) for pair in zip(places, moving, strict=True)]
            values |= dict(zip(_STATES, (states[0], states[-1]), strict=True))
            values["changes"] = tuple(states[1:-1])
        except (InputError, ValueError, TypeError) as error:
            raise InputError(f"{path}: {error}") from None
        except KeyError as error:
            raise InputError(f"{path}: a run without {error.args[0]!r}") from None
        return cls(parameters=chain, **values)


def _numbers() -> list[str]:
    """The fields of a run that are single numbers or text."""
    others = ("parameters", "changes", *_ARRAYS, *_STATES)
    return [field.name for field in fields(Run) if field.name not in others]


def _mean(values: Any, weights: list[float]) -> float:
    """The weighted mean; of one value this one, bit by bit."""
    return float(np.dot(values, np.divide(weights, sum(weights))))


def _constant(value: Any) -> Any:
    """A constant of a chain; a text holds those of its blocks."""
    return json.loads(value) if isinstance(value, str) else value


def _state(name: str, chain: ChainParameters, data: store.Dataset) -> ChainState:
    arrays = {part: data.arrays[f"{name}/{part}"] for part in OF_STATE}
    values: Any = {part: array if array.ndim else array.item() for part, array in arrays.items()}
    scheme, prefix = None, f"{name}/scheme/"
    if integrator := data.attributes.get(f"{name}_integrator"):
        places = [place for place in data.arrays if place.startswith(prefix)]
        variables = {place.removeprefix(prefix): np.asarray(data.arrays[place]) for place in places}
        scheme = Scheme(integrator, data.attributes[f"{name}_time_step"], variables)
    return ChainState(parameters=chain, **values, scheme=scheme)
