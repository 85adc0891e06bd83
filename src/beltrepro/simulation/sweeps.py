"""Sweeps: chains go on from value to value of one of their quantities."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.model.parameters import PER_BLOCK
from beltrepro.simulation.grid import QUANTITIES, check_chains
from beltrepro.simulation.groups import Report, check_progress
from beltrepro.simulation.results import Results, in_one_table
from beltrepro.simulation.scans import scan_of
from beltrepro.simulation.setup import (
    Chains,
    PerChain,
    Setup,
    setup_of,
    warn,
    with_setup,
    with_value,
)

_SWEPT = QUANTITIES[1:]  # a chain has its number of blocks for ever


@partial(with_setup, more=_SWEPT)
def sweep(
    chains: Chains,
    *,
    duration: float,
    transient: float = 0.0,
    section_position: PerChain[float] | None = None,
    section_values: int = 500,
    laminar_time: float | None = None,
    on_error: str = "raise",
    store: str | Path | None = None,
    progress: Report | None = None,
    **setup: Any,
) -> Results:
    """Scan chains at one value of a quantity after the other, each from where the last has ended.

    `sweep(chain, belt_velocity=[10, 15, 20, 15, 10], duration=2000)` raises u and lowers it again,
    and shows on which way each motion is met. The numbers are those of five calls of `scan`, with
    `initial_state=results.final_states` from the second on.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        One chain or P chains, each of which has all values in turn.
    duration, transient : float
        As in `scan`, at each value.
    section_position, section_values, laminar_time : as in `scan`
        What is measured at each value.
    on_error : str
        As in `scan`; a chain that has failed stays so at all values that come after.
    store : str or Path, optional
        As in `scan`; its file is one of `scan`, which sweeps of other replicates, or to further
        values, add to. `Results.load` gives its rows without step and way: this function gives
        them if it is called again with the same store.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.
    belt_velocity, noise, static_friction, friction_ratio, rest_length, linear_limit, \
compression_rate, extension_rate, mass, stiffness, weakening_velocity, viscosity : sequence
        One of them has the values that it takes, in their order. Where blocks differ a value is a
        tuple, as in mass=[(1, 1, 1), (1, 2, 1)].

    Returns
    -------
    Results
        The arrays of `scan` with a row for each chain at each value, in the order of the values.
        Before them step, the number of the value from 0, and way, "up" or "down": to it from the
        one before, at the first to the second; of two equal values the second has the way on.
        "both" where it goes up in some blocks and down in others.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    given = {name: setup.pop(name) for name in _SWEPT if name in setup}
    quantity, values = _swept(given)
    check_progress(progress)
    settings = section_position, section_values, None, laminar_time, on_error, store
    parts: list[Results] = []
    warned_at: list = []  # the value at which each warning came
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        made = setup_of(with_value(chains, quantity, values[0]), setup)
        sizes = {case.parameters.n_blocks for case in made.cases}
        if isinstance(given[quantity], tuple) and quantity in PER_BLOCK and len(values) in sizes:
            check_chains(quantity, given[quantity], {quantity: values, "n_blocks": [*sizes]})
        with warnings.catch_warnings(action="ignore"):  # a wrong one is refused now
            for value in values:
                _continued(made, quantity, value, [case.state for case in made.cases])
        for step, value in enumerate(values):
            if parts:
                made = _continued(made, quantity, value, parts[-1].final_states)
            report = partial(_reported, progress, step, len(values)) if progress else None
            parts.append(scan_of(made, (duration, transient), *settings, report, bool(parts)))
            warned_at += [value] * (len(heard) - len(warned_at))
    if heard:
        many = f"{len(heard)} warnings on the way, the first " if len(heard) > 1 else ""
        warn(f"{many}at {quantity} = {checks.shown(warned_at[0])}: {heard[0].message}")
    steps = np.repeat(np.arange(len(values)), len(made.cases))
    tables = [part | part.of_runs for part in parts]
    table = {"step": steps, "way": _ways(values)[steps]} | in_one_table(tables)
    about = parts[0].settings | {"kind": "sweep", "quantity": quantity}
    return Results(table, about)


def _swept(given: dict[str, Any]) -> tuple[str, list]:
    """The quantity that is swept, and its values."""
    given = {name: values for name, values in given.items() if values is not None}
    if len(given) != 1:
        needed = "one quantity with the values that it takes is needed, as belt_velocity=[5, 10]"
        raise InputError(f"sweep: {needed}; given are {', '.join(given) or 'none'}")
    ((name, values),) = given.items()
    if not checks.is_sequence(values) or not (listed := checks.listed(name, values)):
        raise InputError(f"{name} = {checks.shown(values)}: the values that it takes are needed")
    return name, listed


def _continued(made: Setup, quantity: str, value: Any, states: Any) -> Setup:
    """The chains at the next value, from where they have ended."""
    chains = [replace(case.parameters, **{quantity: value}) for case in made.cases]
    begin: Any = dict.fromkeys(("seed", "replicate", "initial_positions"))
    begin |= {"initial_spread": 0.0, "initial_state": states}
    return replace(made, chains=chains, **begin)


def _reported(progress: Report, step: int, steps: int, fraction: float) -> None:
    progress((step + fraction) / steps)


def _ways(values: Sequence) -> np.ndarray:
    """Which way each value is met."""
    # compared, not subtracted: infinite values have no difference
    pairs = [map(np.asarray, pair) for pair in pairwise(values)]
    changes = np.array([(a < b).any() + 2 * (a > b).any() for a, b in pairs], dtype=int)
    turns = np.flatnonzero(changes)
    # the next change for a value that stays, the last one after all
    to_come = np.append(changes[turns], changes[turns[-1:]]) if len(turns) else np.ones(1, int)
    before = np.append(0, changes)
    nexts = to_come[np.searchsorted(turns, np.arange(len(values)))]
    return np.array(["", "up", "down", "both"])[np.where(before == 0, nexts, before)]
