"""What is measured of many chains, gathered as results; a file of them grows."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial, reduce
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import ModelStateError
from beltrepro.engine.state import ChainState
from beltrepro.simulation.groups import (
    ON_ERROR,
    Group,
    Part,
    Report,
    in_groups,
    parts_of,
    warn_of_failures,
)
from beltrepro.simulation.results import Results, in_rows, read, refuse_others, some_of
from beltrepro.simulation.setup import Case, Setup, columns

Arrays = dict[str, np.ndarray]

STATES = "_final_states"  # array of objects, which is no column; others with _ are the caller's
_PATIENCE = 20  # times as long as it takes to write the file, until it is written again


def gathered(
    kind: str,
    setup: Setup,
    measure: Callable[[Group], Arrays],
    progress: Report | None,
    on_error: str,
    store: str | Path | None,
    *,
    also: np.ndarray | None = None,
    ends: bool = False,
    **settings: Any,
) -> Results:
    """A row for each chain, of the arrays (W, ...) that are measured of each group.

    also : a number of each chain on which they depend too. ends : whether STATES is among them.
    """
    names.one_of("on_error", on_error, ON_ERROR)
    numbers = np.zeros(len(setup.cases)) if also is None else also
    keys = [f"{case.key} {number:.17g}" for case, number in zip(setup.cases, numbers, strict=True)]
    told = Results(columns(setup), {"kind": kind} | settings, [] if ends else None, keys)
    work = partial(parts_of, measure, on_error)
    if store is None:
        made = in_groups(setup.cases, work, progress, workers=setup.workers)
        results = _filled(told, setup.cases, [part for _, parts in made for part in parts])
    else:
        with _Store(store, told) as kept:
            keep, known = partial(kept.keep, work), kept.rows()
            in_groups(setup.cases, keep, progress, workers=setup.workers, skipped=known)
        rows = kept.rows()
        results = some_of(kept.held[0], [rows[index] for index in range(len(keys))])
        results.update(told)
        results.settings = told.settings
    warn_of_failures(results["error"].tolist(), on_error)
    if on_error == "raise":
        del results["error"]
    return results


def _filled(told: Results, cases: Sequence[Case], parts: list[Part[Arrays]]) -> Results:
    """What the chains are, what is measured of them, and the line of each that has failed."""
    count = len(cases)
    lines = {int(rows[0]): str(part) for rows, part in parts if isinstance(part, ModelStateError)}
    measured = [(rows, part) for rows, part in parts if not isinstance(part, ModelStateError)]
    table, states = dict(told), None
    for name in list(measured[0][1]) if measured else ():
        # a scan of many chains is held but once
        table[name] = in_rows(count, [(rows, arrays.pop(name)) for rows, arrays in measured])
    if told.final_states is not None:
        ends, duration = table.pop(STATES, np.zeros(count)).tolist(), told.settings["duration"]
        states = [end or _nowhere(case, duration) for end, case in zip(ends, cases, strict=True)]
    table["error"] = np.array([lines.get(row, "") for row in range(count)])
    return Results(table, told.settings, states, told.run_keys)


def _nowhere(case: Case, duration: float) -> ChainState:
    """The final state of a chain that has failed."""
    state = case.state
    places = np.full_like(state.displacements, np.nan)
    return replace(state, time=state.time + duration, displacements=places, scheme=None)


class _Store:
    """A file of results that grows while chains of them are computed."""

    def __init__(self, path: str | Path, told: Results) -> None:
        self._path, self._told = checks.path("store", path, (".h5",)), told
        self.held: list[Results] = []  # the file, if there is one
        if self._path.exists():
            self.held.append(read(self._path))
            refuse_others(f"store = {path}", self.held[0], told)
        self._new: list[Results] = []
        self._next, self._lock = 0.0, threading.Lock()

    def rows(self) -> dict[int, int]:
        """In which row of the file the chains are that it has."""
        rows = {key: row for held in self.held for row, key in enumerate(held.run_keys)}
        keys = enumerate(self._told.run_keys)
        return {index: rows[key] for index, key in keys if key in rows}

    def keep(self, work: Callable[[Group], list[Part[Arrays]]], group: Group) -> None:
        """Add what is made of a group; the file is written if it was not just before."""
        parts = [(np.searchsorted(group.indices, rows), part) for rows, part in work(group)]
        with self._lock:
            told = some_of(self._told, group.indices.tolist())
            self._new.append(_filled(told, group.cases, parts))
            if time.monotonic() >= self._next:
                self._save()

    def _save(self) -> None:
        begun = time.monotonic()
        held = reduce(Results.joined, [*self.held, reduce(Results.joined, self._new)])
        held.save(self._path)
        self.held, self._new = [held], []
        self._next = time.monotonic() + _PATIENCE * (time.monotonic() - begun)

    def __enter__(self) -> _Store:
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            if self._new:
                self._save()
