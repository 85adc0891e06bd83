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

R = TypeVar("R", bound=Any)
KIND = "run"
_OF_OTHER_LAWS = ("mass", "stiffness", "weakening_velocity", "viscosity")
_STATES = ("initial_state", "final_state")
# Unit and dimensions of each array, of the samples and of a state.
_ARRAYS = {
    "time": ("model time", "sample"),
    "positions": ("model length", "sample, block"),
    "velocities": ("model velocity", "sample, block"),
    "friction": ("model force", "sample, block"),
    "events": ("by field: model time, 1, text, model force, length, energy", "event"),
}
_STATE_ARRAYS = {
    "time": ("model time", ""),
    "displacements": ("model length", "block"),
    "relative_velocities": ("model velocity", "block"),
    "directions": ("1", "block"),
    "thresholds": ("model force", "block"),
    "friction_losses": ("model energy", "block"),
    "wall_impulse": ("model force times time", ""),
    "initial_energy": ("model energy", ""),
    "initial_momentum": ("model force times time", ""),
    "seed": ("1", ""),
    "replicate": ("1", ""),
    "stream": ("1", "word"),
}


def save_run(path: str | Path, run: Any) -> None:
    """Write a run; the file appears under its name when it is complete."""
    parts = {name: (getattr(run, name), *words) for name, words in _ARRAYS.items()}
    attributes = {
        name: json.dumps(value) if isinstance(value, tuple) else value
        for name, value in asdict(run.parameters).items()
    }
    attributes |= {"kind": KIND, "units": "model units"}
    attributes |= {name: getattr(run, name) for name in _attributes(run)}
    for name in _STATES:
        state = getattr(run, name)
        for part, words in _STATE_ARRAYS.items():
            parts[f"{name}/{part}"] = (getattr(state, part), *words)
        if state.scheme is not None:
            attributes[f"{name}_integrator"] = state.scheme.integrator
            attributes[f"{name}_time_step"] = state.scheme.time_step
            for part, values in state.scheme.variables.items():
                parts[f"{name}/scheme/{part}"] = (values, "as the integrator keeps it", "")
    arrays = {name: array for name, (array, _, _) in parts.items()}
    about = {name: {"unit": unit, "dimensions": axes} for name, (_, unit, axes) in parts.items()}
    present = {name: value for name, value in attributes.items() if value is not None}
    store.write(path, arrays, present, about)


def load_run(path: str | Path, kind: type[R]) -> R:
    """Read a run of this class that `save_run` wrote; InputError if the file holds no run."""
    data = store.read(path)
    for name, value in data.attributes.items():
        if not isinstance(value, str | int | float):
            raise InputError(f"{path}: {name} = {shown(value)}: a number or text is needed")
    if data.attributes.get("kind") != KIND:
        raise InputError(f"{path}: not a run, but of kind {data.attributes.get('kind')!r}")
    try:
        chain = _chain(data.attributes)
        values: dict[str, Any] = {name: data.attributes.get(name) for name in _attributes(kind)}
        values |= {name: data.arrays[name] for name in _ARRAYS}
        _check_arrays(data, chain.n_blocks)
        values |= {name: _state(name, chain, data) for name in _STATES}
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except KeyError as error:
        raise InputError(f"{path}: a run without {error.args[0]!r}") from None
    return kind(parameters=chain, **values)


def _chain(attributes: dict[str, Any]) -> ChainParameters:
    """The chain of a run; files of the law of the paper need not have what other laws have."""
    values = {
        field.name: attributes[field.name]
        for field in fields(ChainParameters)
        if field.name not in _OF_OTHER_LAWS or field.name in attributes
    }
    return ChainParameters(**{name: _numbers(name, value) for name, value in values.items()})


def _numbers(name: str, value: Any) -> Any:
    """A number, or the numbers of the blocks that a text holds."""
    if not isinstance(value, str):
        return value
    try:
        return json.loads(value)
    except ValueError:
        raise InputError(f"{name} = {shown(value)}: a number or a list is needed") from None


def _check_arrays(data: store.Dataset, n_blocks: int) -> None:
    """Refuse arrays that are not as `save_run` writes them."""
    described = {name: axes for name, (_, axes) in _ARRAYS.items() if name != "events"}
    parts = _STATE_ARRAYS.items()
    described |= {f"{state}/{part}": axes for state in _STATES for part, (_, axes) in parts}
    sizes = {"block": n_blocks, "sample": len(np.atleast_1d(data.arrays["time"])), "word": 4}
    for name, axes in described.items():
        array = np.asarray(data.arrays[name])
        shape = tuple(sizes[axis] for axis in axes.split(", ") if axis)
        if array.shape != shape or array.dtype.kind not in "iuf" or not np.isfinite(array).all():
            held = f"{array.dtype} of shape {array.shape}"
            raise InputError(f"{name} is {held}: finite numbers of shape {shape} are needed")


def _attributes(run: Any) -> list[str]:
    """The fields of a run that are single numbers or text."""
    others = ("parameters", *_ARRAYS, *_STATES)
    return [field.name for field in fields(run) if field.name not in others]


def _state(name: str, chain: ChainParameters, data: store.Dataset) -> ChainState:
    arrays = {part: data.arrays[f"{name}/{part}"] for part in _STATE_ARRAYS}
    values: Any = {part: array if array.ndim else array.item() for part, array in arrays.items()}
    integrator, scheme = data.attributes.get(f"{name}_integrator"), None
    if integrator is not None:
        prefix = f"{name}/scheme/"
        variables = {
            place.removeprefix(prefix): np.asarray(value)
            for place, value in data.arrays.items()
            if place.startswith(prefix)
        }
        scheme = Scheme(integrator, data.attributes[f"{name}_time_step"], variables)
    return ChainState(parameters=chain, **values, scheme=scheme)
