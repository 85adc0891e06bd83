"""What the paper measures of runs and catalogues: spectra, slips, avalanches, sections."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from beltrepro.base import checks, names
from beltrepro.base.checks import is_sequence, shown
from beltrepro.base.errors import InputError, require, warn
from beltrepro.engine.law import law_constants
from beltrepro.engine.records import EVENT_DISSIPATED
from beltrepro.model.energy import as_lengths
from beltrepro.observe.slips import slips_and_avalanches
from beltrepro.simulation.catalogues import Catalogue
from beltrepro.simulation.run import Run
from beltrepro.simulation.tables import one_panel
from beltrepro.stats import sections, spectra
from beltrepro.stats.densities import ChainValues
from beltrepro.stats.power_law import PowerLaw

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FRAMES = ("laboratory", "belt")
_NUMBERS = [(name, "f8") for name in ("time", "position", "relative_velocity")]
SECTION_POINT = np.dtype([("point", "i4"), *_NUMBERS, ("repeated", "?")])
# A block slower than this relative to the belt is stuck; on a belt slower than 1, so much of it.
STUCK = 1e-6


def _runs(value: Any) -> list[Run]:
    """The run given, or each of a sequence of them; none if it is something else."""
    several = is_sequence(value) and not isinstance(value, np.ndarray)
    runs = list(value) if several else [value]
    return runs if all(isinstance(run, Run) for run in runs) else []


# --- spectra --------------------------------------------------------------------------------------


class PowerSpectrum(spectra.PowerSpectrum):
    __doc__ = spectra.PowerSpectrum.__doc__

    @one_panel
    def plot(
        self, path: str | Path | None = None, *, ax: Any = None, law: PowerLaw | None = None,
        **look: Any,
    ) -> Axes:  # fmt: skip
        """Draw the power by frequency, pale, and its medians, on logarithmic axes.

        Parameters
        ----------
        law : PowerLaw, optional
            What `law` gave, to be drawn over the range of its fit.
        """
        from beltrepro.simulation import plots

        return plots.spectrum(ax, self, law, look)


@names.checked
def spectrum(
    runs: Run | Sequence[Run] | npt.ArrayLike, *, sample_interval: float | None = None
) -> PowerSpectrum:
    """Power spectrum of the place x_N of the last block after the transient (Fig. 8).

    Parameters
    ----------
    runs : Run, sequence of R runs, or array (T,) or (R, T)
        One run; several independent ones; or samples of anything else, as `run.positions[:, 0]`.
        A run whose belt changes its velocity mixes the spectra of all its velocities; that of one
        is found of the samples at it, as `run.positions[run.time > 600, -1]`, with
        `sample_interval=run.sample_interval`.
    sample_interval : float, optional
        Model time between the samples of an array; runs have their own.

    Returns
    -------
    PowerSpectrum
        The mean over the runs, in model units.

    Raises
    ------
    InputError
        A value is not allowed, or runs differ in their samples or transients.
    NotEnoughDataError
        There are fewer than 16 samples.
    """
    if sampled := _runs(runs):
        if sample_interval is not None:
            raise InputError("sample_interval: not together with runs, which have their own")
        late = [run.time >= run.initial_state.time + run.transient for run in sampled]
        values = [run.positions[kept, -1] for run, kept in zip(sampled, late, strict=True)]
        spans = zip(sampled, map(len, values), strict=True)
        if len({(run.sample_interval, count, run.transient) for run, count in spans}) > 1:
            raise InputError("runs: samples at one interval, over one time, are needed of all")
        if any(len(run.belt) > 1 for run in sampled):
            warn("the belt changes its velocity: this is the spectrum of all velocities together")
        if (kinds := len({run.parameters for run in sampled})) > 1:
            warn(f"runs of {kinds} chains: this is the mean of their spectra")
        interval = float(np.median(np.diff(sampled[0].time))) if values[0].size else np.nan
    else:
        values = np.atleast_2d(checks.as_numbers(runs))
        if values.ndim > 2 or not values.size or not np.isfinite(values).all():
            needed = "a Run, a sequence of them, or an array of samples (T,) or (R, T) is needed"
            raise InputError(f"runs = {shown(runs)}: {needed}")
        if len(values) > values.shape[1]:
            raise InputError(f"runs of shape {values.shape}: (R, T) is needed, series are rows")
        interval = checks.positive("sample_interval", sample_interval)
    values = np.array(values)
    require(values.shape[1] >= 16, f"{values.shape[1]} samples, a spectrum needs 16")
    return PowerSpectrum(values, interval)


# --- slips and avalanches -------------------------------------------------------------------------


def _catalogue(value: Any) -> Catalogue:
    """The catalogue given, or that of the slips and avalanches of runs."""
    if isinstance(value, Catalogue) and value.parameters:
        return value
    if not (runs := _runs(value)):
        needed = "the Catalogue of some chains, a Run or a sequence of them is needed"
        raise InputError(f"source = {shown(value)}: {needed}")
    tables = zip(*map(_of_run, range(len(runs)), runs), strict=True)
    arrays = zip(("slips", "avalanches"), map(np.concatenate, tables), strict=True)
    return Catalogue(arrays, [run.parameters for run in runs])


def _of_run(number: int, run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Slips and avalanches of a run that start after its transient, as `catalogue` has them."""
    events, chain, state = run.events, run.parameters, run.initial_state
    numbers = [events[name] for name in ("force", "position", "dissipated")]
    rows = np.column_stack(
        [events["time"], events["block"] - 1.0, events["kind"] == "slip", *numbers]
    )
    pieces = run._pieces()
    cuts = np.searchsorted(events["time"], [change.time for change in run.changes], side="right")
    for cut, (_, end), (begin, _) in zip(cuts, pieces, pieces[1:], strict=False):
        lost = end.friction_losses - begin.friction_losses  # where the audit begins anew
        rows[cut:, EVENT_DISSIPATED] += lost[events["block"][cut:] - 1]
    start = state.time + run.transient
    return slips_and_avalanches(rows, number, state, law_constants(chain), start)


def _of_chain(catalogue: Catalogue, rows: np.ndarray, name: str) -> np.ndarray:
    """A quantity of the chain that each row is of."""
    return np.array([getattr(chain, name) for chain in catalogue.parameters])[rows["point"]]


def last_block_slips(catalogue: Catalogue) -> np.ndarray:
    """The slips of the last block of each chain."""
    slips = catalogue["slips"]
    return slips[slips["block"] == _of_chain(catalogue, slips, "n_blocks")]


def _belt_ways(source: Any, catalogue: Catalogue, slips: np.ndarray) -> np.ndarray:
    """The way of the belt during each slip, of a belt that changes its velocity too."""
    start, stop = slips["start_time"], slips["stop_time"]
    ways = _of_chain(catalogue, slips, "belt_velocity") * (stop - start)
    for number, run in enumerate(_runs(source)):
        steps = np.diff([velocity for _, velocity in run.belt])
        for change, step in zip(run.changes, steps, strict=True):
            after = np.maximum(stop - np.maximum(start, change.time), 0.0)
            ways += np.where(slips["point"] == number, step * after, 0.0)
    return ways


@names.checked
def slip_sizes(
    source: Catalogue | Run | Sequence[Run], *, frame: str = "laboratory"
) -> ChainValues:
    """Slip sizes of the last block: the place where a slip starts minus where it stops (Fig. 9a).

    Parameters
    ----------
    source : Catalogue, Run, or sequence of runs
        Slips that start after the transient count.
    frame : str
        Of the places: "laboratory", as Fig. 9a evidently has them, or "belt".

    Returns
    -------
    ChainValues
        Positive sizes, model length; slips forward in this frame are left out.

    Raises
    ------
    InputError
        The source is something else, or there is no such frame.
    """
    catalogue = _catalogue(source)
    slips = last_block_slips(catalogue)
    sizes = slips["start_position"] - slips["stop_position"]
    if names.one_of("frame", frame, FRAMES) == "belt":
        sizes = sizes + _belt_ways(source, catalogue, slips)
    return ChainValues(sizes[sizes > 0], slips["point"][sizes > 0])


@names.checked
def avalanche_energies(
    source: Catalogue | Run | Sequence[Run], *, last_block: bool = True, least_blocks: int = 1
) -> ChainValues:
    """Energies that the whole chain dissipates in avalanches (Fig. 9b).

    Parameters
    ----------
    source : Catalogue, Run, or sequence of runs
        Avalanches that start after the transient count.
    last_block : bool
        Whether only those count in which the last block slips, as in Fig. 9b.
    least_blocks : int
        Blocks that slip in an avalanche that counts, at least.

    Returns
    -------
    ChainValues
        Model energy.

    Raises
    ------
    InputError
        The source is something else, or a value is not allowed.
    """
    catalogue = _catalogue(source)
    avalanches, slips = catalogue["avalanches"], last_block_slips(catalogue)
    counted = avalanches["blocks"] >= checks.key("least_blocks", least_blocks)
    for chain in np.unique(avalanches["point"]) if last_block else ():
        starts = np.sort(slips["start_time"][slips["point"] == chain])
        of_chain = avalanches["point"] == chain
        before = np.searchsorted(starts, avalanches["start_time"][of_chain])
        after = np.searchsorted(starts, avalanches["stop_time"][of_chain], side="right")
        counted[of_chain] &= after > before
    return ChainValues(avalanches["dissipated"][counted], avalanches["point"][counted])


# --- sections -------------------------------------------------------------------------------------


class SectionPoints(np.ndarray):
    """Points of a Poincaré section: a structured array that can be drawn.

    Parameters
    ----------
    points : structured array (S,)
        With the fields that `section` names.
    """

    def __new__(cls, points: np.ndarray) -> SectionPoints:
        return points.view(cls)

    def __getitem__(self, item: Any) -> Any:
        """A field is a plain array."""
        part = super().__getitem__(item)
        return part.view(np.ndarray) if getattr(part, "dtype", self.dtype) != self.dtype else part

    def __repr__(self) -> str:
        if not self.dtype.names:  # what compares points, say
            return super().__repr__()
        return f"SectionPoints({self.size} points of {np.unique(self['point']).size} chains)"

    __str__ = __repr__

    @one_panel
    def plot(
        self, path: str | Path | None = None, *, ax: Any = None, density: bool = False,
        bar: bool = True, **look: Any,
    ) -> Axes:  # fmt: skip
        """Draw the velocity of the last block, relative to the belt, by its position.

        Parameters
        ----------
        density : bool
            Whether to draw the density of the points, in colours; its integral is 1.
        bar : bool
            Whether to draw the scale of these colours, which is logarithmic.
        """
        from beltrepro.simulation import plots

        return plots.plane(ax, self, density, bar, look)


@names.checked
def section(source: Catalogue) -> SectionPoints:
    """Poincaré section of chains, projected on the phase plane of the last block (Fig. 10).

    Parameters
    ----------
    source : Catalogue
        Of chains with one number of blocks; `section_block` and `section_position` of `catalogue`
        say where the section is.

    Returns
    -------
    SectionPoints
        A structured array (S,) of the points at which the last block slips: point, the number of
        the chain, from 0; time; position x_N and relative_velocity v_N - u, model units; repeated,
        whether the state of all blocks lies near that of an earlier point, so that this one says
        nothing new of a distribution: on a periodic orbit, or of a start that has not parted yet.

    Raises
    ------
    InputError
        The source is no catalogue, or chains differ in their number of blocks.
    """
    if not isinstance(source, Catalogue) or not source.parameters:
        needed = "the Catalogue of some chains is needed, whose crossings it records"
        raise InputError(f"source = {shown(source)}: {needed}")
    if len(sizes := {chain.n_blocks for chain in source.parameters}) > 1:
        raise InputError(f"source: chains of {sorted(sizes)} blocks; those of one N are needed")
    rows = source["section"]
    points = np.empty(len(rows), SECTION_POINT)
    points["point"], points["time"] = rows["point"], rows["time"]
    points["position"] = rows["positions"][:, -1]
    points["relative_velocity"] = rows["velocities"][:, -1]
    belt_velocity = _of_chain(source, rows, "belt_velocity")
    points["relative_velocity"] -= belt_velocity
    factors = np.array([as_lengths(chain) for chain in source.parameters])[rows["point"]]
    states = factors * np.hstack([rows["positions"], rows["velocities"]])
    points["repeated"] = sections.repeated(states)
    slips = points["relative_velocity"] < -STUCK * np.minimum(belt_velocity, 1.0)
    return SectionPoints(points[slips])
