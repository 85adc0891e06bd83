"""Runs in HDF5 files.

Datasets time (T,), positions, velocities, friction (T, N) and events, as `Run` names them; groups
initial_state and final_state with the arrays of `ChainState`, and in them a group scheme with the
variables of the integrator. All other values are attributes of the file.
"""

from dataclasses import asdict, fields
from pathlib import Path

import numpy as np

from beltrepro import store
from beltrepro.engine.state import ChainState, Scheme
from beltrepro.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.simulation.run import Run

KIND = "run"
_ARRAYS = ("time", "positions", "velocities", "friction", "events")
_STATES = ("initial_state", "final_state")


def save_run(path: str | Path, run: Run) -> None:
    """Write a run; the file appears under its name when it is complete."""
    arrays = {name: getattr(run, name) for name in _ARRAYS}
    for name in _STATES:
        arrays |= _state_arrays(name, getattr(run, name))
    numbers = {name: getattr(run, name) for name in _attributes()}
    known = {name: value for name, value in numbers.items() if value is not None}
    schemes = {f"{name}_{part}": text for name in _STATES for part, text in _scheme(run, name)}
    units = {"kind": KIND, "units": "model units"}
    store.write(path, arrays, asdict(run.parameters) | known | schemes | units)


def load_run(path: str | Path) -> Run:
    """Read a run that `save_run` wrote; InputError if the file holds anything else."""
    data = store.read(path)
    if data.attributes.get("kind") != KIND:
        raise InputError(f"{path}: not a run, but of kind {data.attributes.get('kind')!r}")
    try:
        names = [field.name for field in fields(ChainParameters)]
        chain = ChainParameters(**{name: data.attributes[name] for name in names})
        return Run(
            parameters=chain,
            **{name: data.attributes.get(name) for name in _attributes()},
            **{name: data.arrays[name] for name in _ARRAYS},
            **{name: _state(name, chain, data) for name in _STATES},
        )
    except KeyError as error:
        raise InputError(f"{path}: a run without {error.args[0]!r}") from None


def _attributes() -> list[str]:
    """The fields of a run that are single numbers or text."""
    others = ("parameters", *_ARRAYS, *_STATES)
    return [field.name for field in fields(Run) if field.name not in others]


def _own_fields() -> list[str]:
    """The fields of a state that are its own arrays and numbers."""
    others = ("parameters", "scheme")
    return [field.name for field in fields(ChainState) if field.name not in others]


def _state_arrays(name: str, state: ChainState) -> dict[str, np.ndarray]:
    arrays = {f"{name}/{own}": np.asarray(getattr(state, own)) for own in _own_fields()}
    variables = {} if state.scheme is None else state.scheme.variables
    return arrays | {f"{name}/scheme/{own}": value for own, value in variables.items()}


def _scheme(run: Run, name: str) -> list[tuple[str, object]]:
    scheme = getattr(run, name).scheme
    if scheme is None:
        return []
    return [("integrator", scheme.integrator), ("time_step", scheme.time_step)]


def _state(name: str, chain: ChainParameters, data: store.Dataset) -> ChainState:
    own = {each: data.arrays[f"{name}/{each}"] for each in _own_fields()}
    values = {each: value if value.ndim else value.item() for each, value in own.items()}
    scheme = None
    if f"{name}_integrator" in data.attributes:
        prefix = f"{name}/scheme/"
        scheme = Scheme(
            data.attributes[f"{name}_integrator"],
            data.attributes[f"{name}_time_step"],
            {
                each.removeprefix(prefix): value
                for each, value in data.arrays.items()
                if each.startswith(prefix)
            },
        )
    return ChainState(parameters=chain, **values, scheme=scheme)
