"""States of many chains as tables of a file: one for each size of chain and scheme."""

from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from beltrepro.engine.state import ChainState, Scheme
from beltrepro.model import ChainParameters
from beltrepro.simulation.grid import QUANTITIES

OF_STATE = [one.name for one in fields(ChainState) if one.name not in ("parameters", "scheme")]
_PLACE, _SCHEME = "final_states/", "scheme "


def packed(states: Iterable[ChainState]) -> dict[str, np.ndarray]:
    """Tables with a row for each state; `row` says which it is."""
    tables: dict[tuple, list[tuple]] = {}
    for row, state in enumerate(states):
        values: dict[str, Any] = {name: getattr(state, name) for name in OF_STATE} | {"row": row}
        if scheme := state.scheme:
            values |= {"integrator": scheme.integrator, "scheme_step": scheme.time_step}
            values |= {_SCHEME + name: value for name, value in scheme.variables.items()}
        arrays = {name: np.asarray(value) for name, value in values.items()}
        dtype = tuple((name, array.dtype.str, array.shape) for name, array in arrays.items())
        tables.setdefault(dtype, []).append(tuple(arrays.values()))
    made = enumerate(tables.items())
    return {f"{_PLACE}{number}": np.array(rows, list(dtype)) for number, (dtype, rows) in made}


def unpacked(arrays: Mapping[str, np.ndarray]) -> list[ChainState] | None:
    """The states that `packed` has put beside the columns of their chains, if it has."""
    states: dict[int, ChainState] = {}
    tables = [array for name, array in arrays.items() if name.startswith(_PLACE)]
    constants = [arrays[name].tolist() for name in QUANTITIES] if tables else []
    for table in tables:
        for record in table:
            values: Any = {name: record[name] for name in record.dtype.names}
            values |= {name: one.item() for name, one in values.items() if one.ndim == 0}
            schemes = [name for name in values if name.startswith(_SCHEME)]
            variables = {name.removeprefix(_SCHEME): np.array(values.pop(name)) for name in schemes}
            steps = values.pop("integrator", ""), values.pop("scheme_step", 0.0)
            row, scheme = values.pop("row"), Scheme(*steps, variables) if schemes else None
            size, *others = (constant[row] for constant in constants)
            others = [one[:size] if isinstance(one, list) else one for one in others]
            states[row] = ChainState(ChainParameters(size, *others), **values, scheme=scheme)
    return [states[row] for row in range(len(states))] if tables else None
