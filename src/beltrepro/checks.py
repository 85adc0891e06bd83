"""Checks of values: each failure is one line that names the value and says what is allowed.

Each takes the name of a value and the value, and returns it as it is used.
"""

import math
from numbers import Integral, Real
from typing import Any

import numpy as np

from beltrepro.errors import InputError

_LARGEST_KEY = 2**63 - 1  # what a file can hold


def whole_number(name: str, value: Any) -> int:
    """The value as an int; InputError names it if it is not a whole number."""
    is_whole = isinstance(value, Integral) or (isinstance(value, Real) and value % 1 == 0)
    if isinstance(value, bool) or not is_whole:
        raise InputError(f"{name} = {value!r}: a whole number is needed")
    return int(value)


def finite_number(name: str, value: Any) -> float:
    """The value as a float; InputError names it if it is not a finite number."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{name} = {value!r}: a number is needed")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{name} = {number}: a finite number is needed")
    return number


def positive(name: str, value: Any) -> float:
    """A number greater than 0."""
    if finite_number(name, value) <= 0:
        raise InputError(f"{name} = {value:g}: must be greater than 0")
    return float(value)


def not_negative(name: str, value: Any) -> float:
    """A number of 0 or greater."""
    if finite_number(name, value) < 0:
        raise InputError(f"{name} = {value:g}: must be 0 or greater")
    return float(value)


def key(name: str, value: Any) -> int:
    """A whole number of 0 or greater: a seed, a replicate, a count."""
    if not 0 <= whole_number(name, value) <= _LARGEST_KEY:
        raise InputError(f"{name} = {value!r}: a whole number of 0 or greater is needed")
    return int(value)


def numbers(name: str, value: Any, count: int) -> np.ndarray:
    """An array of so many finite numbers, one for each block."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {value!r}: {count} numbers are needed") from None
    if array.shape != (count,):
        raise InputError(
            f"{name} of shape {array.shape}: {count} numbers are needed, one for each block"
        )
    if not np.all(np.isfinite(array)):
        raise InputError(f"{name} = {array.tolist()}: finite numbers are needed")
    return array


def positions(name: str, value: Any, n_blocks: int) -> np.ndarray:
    """Positions (N,) of the blocks of one chain, from the wall outwards."""
    array = numbers(name, value, n_blocks)
    if not np.all(np.diff(array, prepend=0.0) > 0):
        raise InputError(f"{name} = {array.tolist()}: must be positive and increasing")
    return array
