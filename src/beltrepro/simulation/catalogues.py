"""Catalogues: every slip, avalanche and section point of some chains."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Section
from beltrepro.engine.law import law_constants
from beltrepro.observe.crossings import CrossingLog
from beltrepro.observe.slips import AVALANCHE, SLIP, EventLog, slips_and_avalanches
from beltrepro.simulation.groups import Report, in_groups, integrator_of
from beltrepro.simulation.loading import LoadingWatch
from beltrepro.simulation.setup import (
    Case,
    Chains,
    PerChain,
    check_lengths,
    section_positions,
    setup_of,
    with_setup,
)
from beltrepro.simulation.tables import blocks, frame, html

if TYPE_CHECKING:
    import pandas as pd


_ONE = {"positions": "position", "velocities": "velocity"}


class Catalogue(dict[str, np.ndarray]):
    """Slips, avalanches and section points of P chains: a dict of structured arrays.

    In all of them `point` is the number of the chain. Model units, laboratory frame.
    """

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
        columns: dict[str, np.ndarray] = {}
        for field in rows.dtype.names or ():
            values = rows[field]
            columns |= {field: values} if values.ndim == 1 else blocks(_ONE[field], values)
        return frame(columns)

    def _repr_html_(self) -> str:
        return html(self)


@with_setup
def catalogue(
    chains: Chains,
    *,
    duration: float,
    transient: float = 0.0,
    section_block: int | None = None,
    section_position: PerChain[float] | None = None,
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
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

    Returns
    -------
    Catalogue
        A dict of structured arrays. slips, avalanches : those that start after the transient, see
        `beltrepro.observe.slips`. section : point, time, positions (N,), velocities (N,) of each
        crossing after the transient, N that of the longest chain, NaN padded.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    duration, transient = check_lengths(duration, transient)
    made = setup_of(chains, setup)
    cases = made.cases
    block = None if section_block is None else _section_block(section_block, cases)
    sections = section_positions(section_position, cases, block)
    tables: dict[str, list[np.ndarray]] = {"slips": [], "avalanches": [], "section": []}
    loading = LoadingWatch(cases, duration, transient)
    record = partial(_record, sections, block, transient, loading)
    for _, recorded in in_groups(cases, record, progress, workers=made.workers):
        for name, parts in tables.items():
            parts += recorded[name]
    loading.warn()
    width = max(case.parameters.n_blocks for case in cases)
    dtypes = {"slips": SLIP, "avalanches": AVALANCHE, "section": _section_dtype(width)}
    return Catalogue({name: _joined(tables[name], dtype) for name, dtype in dtypes.items()})


def _section_dtype(n_blocks: int) -> np.dtype:
    vectors = [(name, "f8", (n_blocks,)) for name in ("positions", "velocities")]
    return np.dtype([("point", "i4"), ("time", "f8"), *vectors])


def _section_block(value: Any, cases: Sequence[Case]) -> int:
    most = min(case.parameters.n_blocks for case in cases)
    if not 1 <= checks.whole_number("section_block", value) <= most:
        raise InputError(f"section_block = {checks.shown(value)}: allowed are 1 to {most}")
    return int(value)


def _record(
    sections: np.ndarray,
    block: int | None,
    transient: float,
    loading: LoadingWatch,
    group: np.ndarray,
    members: list[Case],
    report: Report,
) -> dict[str, tuple[np.ndarray, ...]]:
    """Slips, avalanches and section points of a group with these numbers: tables of each chain."""
    chain = members[0].parameters
    integrator = integrator_of(members, section=Section(block or chain.n_blocks, sections[group]))
    start = members[0].state.time + transient
    events = EventLog(len(members), chain.rest_positions)
    crossings = CrossingLog(start)
    loading.observe(group, integrator, [events, crossings], report)
    rows = crossings.rows(chain.n_blocks)
    law = law_constants(chain)
    tables = []
    for lane, (number, case) in enumerate(zip(group, members, strict=True)):
        crossed = rows[rows[:, 0] == lane]
        records = np.zeros(len(crossed), dtype=_section_dtype(chain.n_blocks))
        records["point"], records["time"] = number, crossed[:, 1]
        positions, velocities = np.hsplit(crossed[:, 2:], 2)
        records["positions"] = positions + case.parameters.rest_positions
        records["velocities"] = velocities + case.parameters.belt_velocity
        slips = slips_and_avalanches(events.events(lane), number, case.state, law, start)
        tables.append((*slips, records))
    return dict(zip(("slips", "avalanches", "section"), zip(*tables, strict=True), strict=True))


def _joined(parts: list[np.ndarray], dtype: np.dtype) -> np.ndarray:
    """Tables of several chains as one, in the order of the chains; short vectors end with NaN."""
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
