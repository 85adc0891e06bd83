"""States of many chains as arrays with a row for each."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import cache
from typing import Any

import numpy as np

from beltrepro.engine.state import ChainState, Scheme
from beltrepro.model import ChainParameters
from beltrepro.simulation.grid import QUANTITIES
from beltrepro.simulation.tables import OF_RUNS

OF_STATE = [one.name for one in fields(ChainState) if one.name not in ("parameters", "scheme")]
_PLACE = OF_RUNS + "state/"


def packed(states: Sequence[ChainState]) -> dict[str, np.ndarray]:
    """Arrays (W, ...) of states of chains of one size that one integrator has made."""
    rows: list[dict[str, Any]] = []
    for state in states:
        rows.append({name: getattr(state, name) for name in OF_STATE})
        if scheme := state.scheme:
            name = scheme.integrator
            rows[-1] |= {"integrator": name, "scheme_step": scheme.time_step}
            rows[-1] |= {f"{name}/{variable}": one for variable, one in scheme.variables.items()}
    return {_PLACE + name: np.array([row[name] for row in rows]) for name in rows[0]}


def unpacked(columns: Mapping[str, np.ndarray]) -> list[ChainState] | None:
    """The states that `packed` has put beside the columns of their chains, if it has."""
    arrays = {
        name.removeprefix(_PLACE): one for name, one in columns.items() if name.startswith(_PLACE)
    }
    if not arrays:
        return None
    states, chain = [], cache(ChainParameters)  # replicates share theirs
    constants = zip(*(columns[name].tolist() for name in QUANTITIES), strict=True)
    for row, (size, *law) in enumerate(constants):
        law = [tuple(one[:size]) if isinstance(one, list) else one for one in law]
        values: dict[str, Any] = {name: array[row] for name, array in arrays.items()}
        for name, value in values.items():
            if value.ndim == 0:
                values[name] = value.item()
            else:  # without what pads shorter chains
                values[name] = np.array(value if name == "stream" else value[..., :size])
        scheme, integrator = None, values.get("integrator")
        if integrator:
            of_scheme = [name for name in values if name.startswith(f"{integrator}/")]
            variables = {name.partition("/")[2]: values[name] for name in of_scheme}
            scheme = Scheme(integrator, values["scheme_step"], variables)
        parts = {name: values[name] for name in OF_STATE}
        states.append(ChainState(chain(size, *law), **parts, scheme=scheme))
    return states
