"""Catalogues: every slip, avalanche and section point of some chains."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Section
from beltrepro.engine.law import law_constants
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.observe.crossings import ReturnLog
from beltrepro.observe.length import Reach
from beltrepro.observe.slips import EventLog, slips_and_avalanches
from beltrepro.simulation.gathering import LOADING, gathered
from beltrepro.simulation.groups import Group, Report, integrator_of
from beltrepro.simulation.loading import LoadingWatch
from beltrepro.simulation.setup import (
    Chains,
    PerChain,
    check_lengths,
    section_positions,
    setup_of,
    warn,
    with_setup,
)
from beltrepro.simulation.tables import OF_RUNS, Arrays, blocks, frame, one_panel

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

_MISSING = OF_RUNS + "missing"  # of each chain, what it has none of


class Catalogue(Arrays):
    """Slips, avalanches and section points of P chains: a dict of structured arrays.

    `catalogue` says what their fields are.

    Attributes
    ----------
    parameters : tuple of ChainParameters
        The P chains.
    """

    def __init__(self, arrays: Iterable = (), parameters: Sequence[ChainParameters] = ()) -> None:
        super().__init__(arrays)
        self.parameters = tuple(parameters)

    def __repr__(self) -> str:
        return f"Catalogue({', '.join(f'{len(rows)} {name}' for name, rows in self.items())})"

    @names.checked
    def table(self, kind: str = "avalanches") -> pd.DataFrame:
        """One of the arrays as a table of pandas.

        Parameters
        ----------
        kind : str
            slips, avalanches or section.

        Returns
        -------
        pandas.DataFrame
            A row for each, a column for each field, and for each block where a field has N numbers.

        Raises
        ------
        InputError
            There is no such array, or pandas is not installed.
        """
        rows = self[names.one_of("kind", kind, self)]
        columns = {name: rows[name] for name in rows.dtype.names or () if rows[name].ndim == 1}
        if kind == "section":
            columns |= blocks("position", rows["positions"])
            columns |= blocks("velocity", rows["velocities"])
        return frame(columns)

    @one_panel
    def plot(
        self, path: str | Path | None = None, *, ax: Any = None, kind: str = "avalanches",
        size: str = "dissipated", bins_per_decade: int = 8, **look: Any,
    ) -> Axes:  # fmt: skip
        """Draw the probability density of the sizes of avalanches or slips, on logarithmic axes.

        Parameters
        ----------
        kind : str
            avalanches or slips.
        size : str
            Of avalanches dissipated, spring_energy_drop, slips or blocks; of slips dissipated or
            displacement, positive towards the wall. Sizes of 0 and below are left out.
        bins_per_decade : int
            Bins of equal width in the logarithm.
        """
        from beltrepro.simulation import plots

        return plots.sizes(ax, self, kind, size, bins_per_decade, look)

    @one_panel
    def plot_slips(
        self, path: str | Path | None = None, *, ax: Any = None, point: int = 0, **look: Any
    ) -> Axes:
        """Draw the slips of a chain in time and space: a line from where each starts to its stop.

        Parameters
        ----------
        point : int
            The number of the chain, from 0.
        """
        from beltrepro.simulation import plots

        return plots.slips(ax, self, point, look)


@with_setup
def catalogue(
    chains: Chains,
    *,
    duration: float,
    transient: float = 0.0,
    section_block: int | None = None,
    section_position: PerChain[float] | None = None,
    on_error: str = "raise",
    store: str | Path | None = None,
    progress: Report | None = None,
    **setup: Any,
) -> Catalogue:
    """Slips, avalanches and section points of P chains (Figs. 9 and 10).

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        P chains; one with `replicate=range(32)` is followed 32 times.
    duration, transient : float
        As in `simulate`.
    section_block : int
        Block of the section x_block = position, dx_block/dt < 0 (Fig. 10: 2), from 1; the last one
        if not given.
    section_position : float, or a sequence of P
        Position of the section, model length (Fig. 10: 304.3). If not given, by the rule
        `beltrepro.model.section_position`.
    on_error : str
        What a run does that leaves the range of the model: "raise" ends all; "nan" leaves its chain
        without rows, as in `scan`, and adds the array errors: point, error (its line).
    store : str or Path, optional
        As in `scan`; the file holds the rows of all its chains, and this function reads it, called
        again with it: `Results.load` does not.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

    Returns
    -------
    Catalogue
        Structured arrays of what starts after the transient. Times, places from the wall on and
        energies are in model units; `point` is the number of the chain, from 0:

        - slips: block, from 1; start_time, stop_time; start_position, stop_position of the block;
          dissipated, the energy that friction takes from it, positive
        - avalanches, from the first slip of a resting chain until all blocks stick: start_time,
          stop_time; how many slips, of how many blocks; dissipated by all; spring_energy_drop,
          positive where springs lose energy; last_block_displacement, negative towards the wall
        - section: time; positions (N,), velocities (N,), N that of the longest chain, NaN padded

        A chain of which there is none gets a warning that says what it did instead.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    duration, transient = check_lengths(duration, transient)
    made = setup_of(chains, setup)
    sizes = [case.parameters.n_blocks for case in made.cases]
    if section_block is not None:
        section_block = checks.whole_number("section_block", section_block)
        if not 1 <= section_block <= min(sizes):
            raise InputError(f"section_block = {section_block}: allowed are 1 to {min(sizes)}")
    sections = section_positions(section_position, made.cases, section_block)
    loading = LoadingWatch(made.cases, duration, transient)
    vectors = [(name, "f8", (max(sizes),)) for name in ("positions", "velocities")]
    crossing = np.dtype([("point", "i4"), ("time", "f8"), *vectors])
    record = partial(_recorded, sections, section_block, crossing, transient, loading)
    settings: dict[str, Any] = {"duration": duration, "transient": transient}
    settings["section_block"] = section_block or "the last"
    if isinstance(section_position, Real):
        settings["section_position"] = float(section_position)
    how = progress, on_error, store
    results = gathered("catalogue", made, record, *how, also=sections, **settings)
    of_runs = results.of_runs
    loading.noted = of_runs[LOADING]
    loading.warn()
    if missing := list(filter(None, of_runs[_MISSING].tolist())):
        many = f"{len(missing)} of {len(sizes)} chains{', the first' * (len(missing) > 1)}: "
        warn((many if len(sizes) > 1 else "") + missing[0])
    arrays = {name: of_runs[OF_RUNS + name] for name in ("slips", "avalanches", "section")}
    if (points := arrays["section"]).dtype != crossing:  # a store has longer chains
        arrays["section"] = np.empty(len(points), crossing)
        for name in crossing.names or ():
            here = arrays["section"][name]
            here[...] = points[name][..., : here.shape[-1]]
    whole = Catalogue(arrays, [case.parameters for case in made.cases])
    if on_error == "nan":
        lines = results["error"]
        fields = [("point", "i4"), ("error", lines.dtype)]
        whole["errors"] = np.array([row for row in enumerate(lines) if row[1]], fields)
    return whole


def _recorded(
    sections: np.ndarray,
    section_block: int | None,
    crossing: np.dtype,
    transient: float,
    loading: LoadingWatch,
    group: Group,
) -> dict[str, np.ndarray]:
    """Slips, avalanches, section points of the chains of a group, and what each has none of."""
    chain, width, start = group.chain, len(group.cases), group.start + transient
    section = Section(section_block or chain.n_blocks, sections[group.indices])
    events, crossings = EventLog(width, chain.rest_positions), ReturnLog(width)
    reach, sampled = Reach(width, start), chain.n_blocks + 1 - section.block
    chains = integrator_of(group.cases, section=section, sampled_blocks=sampled)
    loading.observe(group, chains, events, crossings, reach)
    low, high = (end + chain.rest_positions[section.block - 1] for end in (reach.low, reach.high))
    since, ends = np.maximum(crossings.last_event, group.start), chains.state()
    law = law_constants(chain)
    tables: list[tuple[Any, ...]] = []
    for lane, case in enumerate(group.cases):
        times, states, _ = crossings.returns(lane)
        late = times >= start
        points = np.zeros(late.sum(), crossing)
        points["positions"] = points["velocities"] = np.nan
        points["point"], points["time"] = lane, times[late]
        positions, velocities = np.hsplit(states[late], 2)
        points["positions"][:, : chain.n_blocks] = positions + chain.rest_positions
        points["velocities"][:, : chain.n_blocks] = velocities + case.parameters.belt_velocity
        slips = slips_and_avalanches(events.events(lane), lane, case.state, law, start)
        none = []
        if not len(slips[0]):
            doing = _doing(ends[lane])
            none.append(f"no slip begins and ends: {doing} from t = {since[lane]:g} on")
        elif not len(slips[1]):
            none.append("no avalanche from one rest of all blocks to the next")
        if not len(points) and np.isfinite(low[lane]):
            way, level = f"{low[lane]:.6g} to {high[lane]:.6g}", section.positions[lane]
            none.append(f"x_{section.block} runs from {way}, never down through {level:g}")
        about = f"{case.parameters.describe()}: {'; '.join(none)}" if none else ""
        tables.append((*slips, points, about))
    *rows, missing = zip(*tables, strict=True)
    joined = zip(("slips", "avalanches", "section"), map(np.concatenate, rows), strict=True)
    return {
        **{OF_RUNS + name: table for name, table in joined},
        _MISSING: np.array(missing),
        LOADING: loading.noted[group.indices],
    }


def _doing(state: ChainState) -> str:
    """What the blocks of a chain do."""
    slipping, n_blocks = int(np.count_nonzero(state.directions)), len(state.directions)
    some = f"{slipping} of {n_blocks} blocks slip"
    return {n_blocks: "all blocks slip", 0: "all blocks stick"}.get(slipping, some)
