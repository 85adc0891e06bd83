"""Catalogues: every slip, avalanche and section point of some chains."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Section
from beltrepro.engine.law import law_constants
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model import section_position as section_rule
from beltrepro.observe.sections import CrossingLog
from beltrepro.observe.slips import AVALANCHE, SLIP, EventLog, slips_and_avalanches
from beltrepro.simulation import arguments
from beltrepro.simulation.arguments import PerChain
from beltrepro.simulation.checkpoints import once
from beltrepro.simulation.memory import EventWatch
from beltrepro.simulation.points import Point, Progress, groups, integrator_of, observe, points
from beltrepro.simulation.sampling import sampling_of


@names.checked
def catalogue(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    transient: float = 0.0,
    method: PerChain[str] = "verlet",
    time_step: PerChain[float] = 0.001,
    tolerance: PerChain[float | None] = None,
    seed: PerChain[int] | None = None,
    replicate: PerChain[int] | None = None,
    initial_positions: ArrayLike | Sequence[ArrayLike] | None = None,
    initial_spread: PerChain[float] = 0.0,
    initial_state: PerChain[ChainState] | None = None,
    section_block: int | None = None,
    section_position: PerChain[float] | None = None,
    progress: Progress | None = None,
) -> dict[str, np.ndarray]:
    """Slips, avalanches and section points of P chains (Figs. 9 and 10).

    Parameters
    ----------
    parameters : ChainParameters or sequence of them
        P chains; `[chain] * 32` with `replicate=range(32)` follows one chain 32 times.
    duration, transient : float
        As in `simulate`.
    method : str or sequence of str
        As in `simulate`.
    time_step, tolerance : float or sequence of float
        As in `simulate`.
    seed, replicate : int or sequence of int
        As in `simulate`.
    initial_positions : array or sequence of arrays
        As in `simulate`.
    initial_spread : float or sequence of float
        As in `simulate`.
    initial_state : ChainState or sequence of them
        As in `simulate`.
    section_block : int
        Block of the section x_block = position, dx_block/dt < 0 (Fig. 10: 2), from 1; the last one
        if not given.
    section_position : float, or a sequence of P
        Position of the section, model length (Fig. 10: 304.3). If not given, for the last block, by
        the rule `beltrepro.model.section_position`.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    dict of structured arrays
        slips, avalanches : those that start after the transient, see `beltrepro.observe.slips`.
        section : point, time, positions (N,), velocities (N,) of each crossing after the transient,
        N that of the longest chain, NaN padded. In all of them `point` is the row in `parameters`.
        Model units, laboratory frame.

    Raises
    ------
    InputError
        A value is not allowed.
    ModelStateError
        A state left the range of the model.
    """
    duration, transient = arguments.lengths(duration, transient)
    chains = points(
        parameters,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=seed,
        replicate=replicate,
        initial_positions=initial_positions,
        initial_spread=initial_spread,
        initial_state=initial_state,
    )
    block = None if section_block is None else _section_block(section_block, chains)
    sections = _section_positions(section_position, block, chains)
    tables: dict[str, list[np.ndarray]] = {"slips": [], "avalanches": [], "section": []}
    for group, report in groups(chains, progress):
        members = [chains[index] for index in group]
        found = once(_record, group, members, sections[group], block, duration, transient, report)
        for name, parts in tables.items():
            parts += found[name]
    width = max(point.parameters.n_blocks for point in chains)
    dtypes = {"slips": SLIP, "avalanches": AVALANCHE, "section": _section_dtype(width)}
    return {name: _joined(tables[name], dtype) for name, dtype in dtypes.items()}


def _section_dtype(n_blocks: int) -> np.dtype:
    """The record of one crossing of the section."""
    vector = (n_blocks,)
    return np.dtype(
        [
            ("point", "i4"),
            ("time", "f8"),
            ("positions", "f8", vector),
            ("velocities", "f8", vector),
        ]
    )


def _section_block(value: Any, chains: Sequence[Point]) -> int:
    most = min(point.parameters.n_blocks for point in chains)
    if not 1 <= checks.whole_number("section_block", value) <= most:
        raise InputError(f"section_block = {checks.shown(value)}: allowed are 1 to {most}")
    return int(value)


def _section_positions(given: Any, block: int | None, chains: Sequence[Point]) -> np.ndarray:
    if given is not None:
        return np.array(arguments.for_each("section_position", given, len(chains), checks.positive))
    if any(block not in (None, point.parameters.n_blocks) for point in chains):
        raise InputError(
            f"section_position is needed with section_block = {block}: "
            "only that of the last block has a rule"
        )
    return np.array([section_rule(point.parameters) for point in chains])


def _record(
    group: np.ndarray,
    members: list[Point],
    sections: np.ndarray,
    block: int | None,
    duration: float,
    transient: float,
    report: Progress,
) -> dict[str, list[np.ndarray]]:
    """Slips, avalanches and section points of a group with these numbers: tables of each chain."""
    chain = members[0].parameters
    integrator = integrator_of(
        members,
        sampling=sampling_of(None, members[0].method, members[0].time_step),
        sampled_blocks=1,
        section=Section(block or chain.n_blocks, sections),
    )
    start = members[0].state.time + transient
    events = EventLog(len(members), chain.rest_positions)
    crossings = CrossingLog(start)
    watch = EventWatch(members, events)
    observe(integrator, duration, [events, crossings, watch], report)
    rows = crossings.rows(chain.n_blocks)
    law = law_constants(chain)
    tables: dict[str, list[np.ndarray]] = {"slips": [], "avalanches": [], "section": []}
    for lane, (number, point) in enumerate(zip(group, members, strict=True)):
        slips, avalanches = slips_and_avalanches(
            events.events(lane), number, point.state, law, start
        )
        tables["slips"].append(slips)
        tables["avalanches"].append(avalanches)
        own = rows[rows[:, 0] == lane]
        tables["section"].append(_section_records(own, number, point.parameters))
    return tables


def _section_records(rows: np.ndarray, number: int, chain: ChainParameters) -> np.ndarray:
    n_blocks = chain.n_blocks
    records = np.zeros(len(rows), dtype=_section_dtype(n_blocks))
    records["point"] = number
    records["time"] = rows[:, 1]
    records["positions"] = rows[:, 2 : 2 + n_blocks] + chain.rest_positions
    records["velocities"] = rows[:, 2 + n_blocks :] + chain.belt_velocity
    return records


def _joined(parts: list[np.ndarray], dtype: np.dtype) -> np.ndarray:
    """Tables of several chains as one, in the order of the points; short vectors end with NaN."""
    joined = np.empty(sum(map(len, parts)), dtype)
    start = 0
    for part in parts:
        rows = joined[start : start + len(part)]
        for name in dtype.names or ():
            if part[name].ndim > 1:
                rows[name] = np.nan
                rows[name][:, : part[name].shape[1]] = part[name]
            else:
                rows[name] = part[name]
        start += len(part)
    return joined[np.argsort(joined["point"], kind="stable")]
