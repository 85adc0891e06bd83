"""Runs in HDF5 files.

Datasets time (T,), positions, velocities, friction (T, N) and events, as `Run` names them; groups
initial_state and final_state with the arrays of `ChainState`, and in them a group scheme with the
variables of the integrator. All other values are attributes of the file.
"""

import json
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from beltrepro.base import store
from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError
from beltrepro.engine.state import ChainState, Scheme
from beltrepro.model import ChainParameters
from beltrepro.simulation.grid import QUANTITIES

R = TypeVar("R", bound=Any)
_ARRAYS = ("time", "positions", "velocities", "friction", "events")
_STATES = ("initial_state", "final_state")
_OF_STATE = [one.name for one in fields(ChainState) if one.name not in ("parameters", "scheme")]


def save_run(path: Path, run: Any) -> None:
    """Write a run; the file appears under its name when it is complete."""
    arrays = {name: getattr(run, name) for name in _ARRAYS}
    attributes = {name: getattr(run, name) for name in _numbers(run)}
    for name, value in asdict(run.parameters).items():
        attributes[name] = json.dumps(value) if isinstance(value, tuple) else value
    for name in _STATES:
        state = getattr(run, name)
        arrays |= {f"{name}/{part}": getattr(state, part) for part in _OF_STATE}
        if scheme := state.scheme:
            attributes[f"{name}_integrator"] = scheme.integrator
            attributes[f"{name}_time_step"] = scheme.time_step
            arrays |= {f"{name}/scheme/{part}": one for part, one in scheme.variables.items()}
    attributes |= {"kind": "run", "units": "model units"}
    store.write(path, arrays, {name: one for name, one in attributes.items() if one is not None})


def load_run(path: Path, kind: type[R]) -> R:
    """Read a run of this class that `save_run` wrote; InputError if the file holds no run."""
    data = store.read(path)
    if data.attributes.get("kind") != "run":
        raise InputError(f"{path}: not a run, but of kind {shown(data.attributes.get('kind'))}")
    try:
        chain = ChainParameters(**{name: _plain(data.attributes[name]) for name in QUANTITIES})
        values: dict[str, Any] = {name: data.attributes.get(name) for name in _numbers(kind)}
        values |= {name: data.arrays[name] for name in _ARRAYS}
        values |= {name: _state(name, chain, data) for name in _STATES}
    except (InputError, ValueError, TypeError) as error:
        raise InputError(f"{path}: {error}") from None
    except KeyError as error:
        raise InputError(f"{path}: a run without {error.args[0]!r}") from None
    return kind(parameters=chain, **values)


def _numbers(run: Any) -> list[str]:
    """The fields of a run that are single numbers or text."""
    others = ("parameters", *_ARRAYS, *_STATES)
    return [field.name for field in fields(run) if field.name not in others]


def _plain(value: Any) -> Any:
    """A constant of a chain; a text holds those of its blocks."""
    return json.loads(value) if isinstance(value, str) else value


def _state(name: str, chain: ChainParameters, data: store.Dataset) -> ChainState:
    arrays = {part: data.arrays[f"{name}/{part}"] for part in _OF_STATE}
    values: Any = {part: array if array.ndim else array.item() for part, array in arrays.items()}
    scheme, prefix = None, f"{name}/scheme/"
    if integrator := data.attributes.get(f"{name}_integrator"):
        places = [place for place in data.arrays if place.startswith(prefix)]
        variables = {place.removeprefix(prefix): np.asarray(data.arrays[place]) for place in places}
        scheme = Scheme(integrator, data.attributes[f"{name}_time_step"], variables)
    return ChainState(parameters=chain, **values, scheme=scheme)
