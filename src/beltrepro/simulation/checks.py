"""Checks of what the public functions are told: each failure is one line that says what is allowed.

A quantity that may differ from chain to chain is given as one value for all, or as a sequence with
one value for each chain.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import numpy as np

from beltrepro.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.model.parameters import finite_number, whole_number
from beltrepro.simulation.methods import METHODS, TOLERANCE_RANGE, TOLERANCES

T = TypeVar("T")
PerChain = T | Sequence[T]

LONGEST_STEP = 0.1  # model time; oscillations take 3
_LARGEST_KEY = 2**63 - 1  # what a file can hold


def chains_of(parameters) -> list[ChainParameters]:
    """The chains of a call, given alone or as a sequence of at least one."""
    if isinstance(parameters, ChainParameters):
        return [parameters]
    chains = list(parameters) if isinstance(parameters, Iterable) else [None]
    for chain in chains or [None]:
        if not isinstance(chain, ChainParameters):
            raise InputError(
                f"parameters = {parameters!r}: "
                "a ChainParameters, or a sequence of at least one, is needed"
            )
    return chains


def for_each(name: str, value, n_chains: int, check: Callable[[str, Any], T]) -> list[T]:
    """One checked value for each chain, from one for all or a sequence of them.

    check : takes the name and a value, returns the value as it is used, or raises InputError.
    """
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        return [check(name, value)] * n_chains
    values = list(value)
    if len(values) != n_chains:
        raise InputError(
            f"{name} of length {len(values)}: one value for all chains is needed, "
            f"or one for each of {n_chains}"
        )
    return [check(name, each) for each in values]


def method_name(name: str, value) -> str:
    """A known method."""
    if not isinstance(value, str) or value not in METHODS:
        raise InputError(f"{name} = {value!r}: allowed are {', '.join(METHODS)}")
    return value


def key(name: str, value) -> int:
    """A seed or a replicate."""
    if whole_number(name, value) < 0 or value > _LARGEST_KEY:
        raise InputError(f"{name} = {value!r}: a whole number of 0 or greater is needed")
    return int(value)


def step(name: str, value) -> float:
    """A time step."""
    if not 0 < finite_number(name, value) <= LONGEST_STEP:
        raise InputError(f"{name} = {value:g}: must be greater than 0 and at most {LONGEST_STEP:g}")
    return float(value)


def tolerance(name: str, value) -> float | None:
    """A tolerance, or None for the method's own."""
    if value is None:
        return None
    low, high = TOLERANCE_RANGE
    if not low <= finite_number(name, value) <= high:
        raise InputError(f"{name} = {value:g}: must be at least {low:g} and at most {high:g}")
    return float(value)


def method_has_tolerance(method: str, value: float | None) -> None:
    """That a method which is told a tolerance has one."""
    if value is not None and method not in TOLERANCES:
        raise InputError(
            f"tolerance = {value:g}: method {method!r} has none, only {', '.join(TOLERANCES)}"
        )


def not_negative(name: str, value) -> float:
    """A number of 0 or greater."""
    if finite_number(name, value) < 0:
        raise InputError(f"{name} = {value:g}: must be 0 or greater")
    return float(value)


def positive(name: str, value) -> float:
    """A number greater than 0."""
    if finite_number(name, value) <= 0:
        raise InputError(f"{name} = {value:g}: must be greater than 0")
    return float(value)


def count(name: str, value) -> int:
    """A whole number of 0 or greater."""
    if whole_number(name, value) < 0:
        raise InputError(f"{name} = {value}: must be 0 or greater")
    return int(value)


def lengths(duration, transient) -> tuple[float, float]:
    """Duration of a run, and the part of it that is left out of the results."""
    duration = positive("duration", duration)
    if not 0 <= finite_number("transient", transient) < duration:
        raise InputError(
            f"transient = {transient:g}: must be at least 0 and less than duration = {duration:g}"
        )
    return duration, float(transient)


def positions(name: str, value, n_blocks: int) -> np.ndarray:
    """Positions (N,) of the blocks of one chain: finite, from the wall outwards."""
    try:
        values = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {value!r}: {n_blocks} numbers are needed") from None
    if values.shape != (n_blocks,):
        raise InputError(
            f"{name} of shape {values.shape}: {n_blocks} numbers are needed, one for each block"
        )
    if not (np.all(np.isfinite(values)) and np.all(np.diff(values, prepend=0.0) > 0)):
        raise InputError(f"{name} = {values.tolist()}: must be finite, positive and increasing")
    return values
