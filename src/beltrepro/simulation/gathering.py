"""What is measured of many chains, gathered as results; a file of them grows."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import atomic, checks, names, provenance
from beltrepro.base.errors import InputError, ModelStateError, warn
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
from beltrepro.simulation.packed import packed
from beltrepro.simulation.results import (
    KEY,
    Results,
    cut,
    in_rows,
    keys_of,
    refuse_others,
    some_of,
    together,
)
from beltrepro.simulation.setup import Case, Setup, columns
from beltrepro.simulation.tables import OF_RUNS

Arrays = dict[str, np.ndarray]

LOADING = OF_RUNS + "loading"  # which runs begin with loading, as a `LoadingWatch` notes it
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
    going_on: bool = False,
    **settings: Any,
) -> Results:
    """A row for each chain, of the arrays (W, ...) or records that are measured of each group.

    also : a number of each chain on which they depend too. ends : whether final states are there.
    going_on : whether the runs go on from others, in one store with them; then all may fail.
    """
    names.one_of("on_error", on_error, ON_ERROR)
    cases = setup.cases
    numbers = np.zeros(len(cases)) if also is None else also
    keys = [f"{case.key} {number:.17g}" for case, number in zip(cases, numbers, strict=True)]
    asked = Results(columns(setup) | {KEY: np.array(keys)}, {"kind": kind} | settings)
    work = partial(parts_of, measure, on_error)
    if store is None:
        made = in_groups(cases, work, progress, workers=setup.workers)
        results = _filled(asked, cases, [part for _, parts in made for part in parts], ends)
    else:
        results = _Store(store, asked, ends, going_on).grown(cases, work, progress, setup.workers)
    lines = results["error"].tolist()
    if going_on and on_error == "nan" and all(lines):
        warn(f"all chains have failed; the first is {lines[0]}")
    else:
        warn_of_failures(lines, on_error)
    if on_error == "raise":
        del results["error"]
    return results


def _filled(
    asked: Results, cases: Sequence[Case], parts: list[Part[Arrays]], ends: bool
) -> Results:
    """What the chains are, what is measured of them, and the line of each that has failed."""
    arrays, lines = asked | asked.of_runs, [""] * len(cases)
    pieces: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for rows, part in parts:
        if isinstance(part, ModelStateError):
            lines[rows[0]] = str(part)
            nowhere = _nowhere(cases[rows[0]], asked.settings["duration"])
            part = packed([nowhere]) if ends else {}
        for name in list(part):
            pieces.setdefault(name, []).append((rows, part.pop(name)))
    for name in list(pieces):  # a scan of many chains is held but once
        arrays[name] = in_rows(len(cases), pieces.pop(name))
    return Results(arrays | {"error": np.array(lines)}, asked.settings)


def _nowhere(case: Case, duration: float) -> ChainState:
    """The final state of a chain that has failed."""
    state = case.state
    places = np.full_like(state.displacements, np.nan)
    return replace(state, time=state.time + duration, displacements=places, scheme=None)


class _Store:
    """A file of results that grows while chains of them are computed, by several processes too."""

    def __init__(self, path: str | Path, asked: Results, ends: bool, going_on: bool) -> None:
        self._path, self._asked, self._ends = checks.path("store", path, (".h5",)), asked, ends
        self._going_on = going_on
        self._new: list[Results] = []
        self._lock, self._next = threading.Lock(), 0.0
        self._held = self._read()

    def grown(
        self,
        cases: Sequence[Case],
        work: Callable[[Group], list[Part[Arrays]]],
        progress: Report | None,
        workers: int | None,
    ) -> Results:
        """What is asked for; what the file lacks of it is computed and added."""
        held, keep = self._rows(), partial(self._keep, work)
        if held:
            self._warn_of_other_code()
        if len(held) < len(cases):
            atomic.begun(self._path).unlink(missing_ok=True)  # can it be? before hours
        try:
            in_groups(cases, keep, progress, workers=workers, skipped=held)
        finally:  # Ctrl-C too
            with self._lock:
                if self._new:
                    self._save()
        rows = self._rows()
        results = some_of(self._held[0], [rows[index] for index in range(len(cases))])
        results.update(self._asked)
        cut(results)
        about = self._held[0].settings
        made_by = {name: about[name] for name in provenance.origin() if name in about}
        results.settings = self._asked.settings | made_by
        return results

    def _read(self) -> list[Results]:
        """What the file holds, if there is one."""
        held = [Results._of_file(self._path)] if self._path.exists() else []
        for results in held:
            if results.settings.get("kind") == "sweep":
                needed = "the store of a sweep is a file that store= wrote, not save"
                raise InputError(f"store = {self._path}: {needed}")
            refuse_others(f"store = {self._path}", results, self._asked, self._going_on)
            results.setdefault("error", np.full(len(results["replicate"]), ""))
        return held

    def _warn_of_other_code(self) -> None:
        """Say that rows of the file may not be what this code would make."""
        here, there = provenance.code_version(), self._held[0].settings["code_version"]
        is_edited = here.endswith(".dirty")
        if here != there or is_edited:
            since = ", which edits that no commit has may have changed since" * is_edited
            warn(
                f"store = {self._path}: it has rows of code {there}, and this is {here}{since}; "
                "a new file has those of this code alone"
            )

    def _rows(self) -> dict[int, int]:
        """In which row of the file the chains are that it has."""
        rows = {key: row for held in self._held for row, key in enumerate(keys_of(held))}
        keys = enumerate(keys_of(self._asked))
        return {index: rows[key] for index, key in keys if key in rows}

    def _keep(self, work: Callable[[Group], list[Part[Arrays]]], group: Group) -> None:
        """Add what is made of a group; the file is written if it was not just before."""
        parts = [(np.searchsorted(group.indices, rows), part) for rows, part in work(group)]
        with self._lock:
            asked = some_of(self._asked, group.indices.tolist())
            self._new.append(_filled(asked, group.cases, parts, self._ends))
            if time.monotonic() >= self._next:
                self._save()

    def _save(self) -> None:
        """Add what is new to the file as it is now: last what is asked for, in its order."""
        begun = time.monotonic()
        with atomic.alone(self._path):
            held = together(*self._read(), *self._held, *self._new)
            held["error"] = held.pop("error")  # is last, also where the first chains have failed
            order = {key: index for index, key in enumerate(keys_of(self._asked))}
            places = [order.get(key, -1) for key in keys_of(held)]
            held = some_of(held, np.argsort(places, kind="stable").tolist())
            held.save(self._path)
        self._held, self._new = [held], []
        self._next = time.monotonic() + _PATIENCE * (time.monotonic() - begun)
