"""Checks of values: each failure is one line that names the value and says what is allowed.

Each takes the name of a value and the value, and returns it as it is used.
"""

import decimal
import math
from collections.abc import Iterable, Mapping, Sequence, Set
from numbers import Real
from os import PathLike
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np

from beltrepro.base.errors import InputError

_PLAIN = "plain numbers are needed, with no mask and no unit"
LONGEST_GRID = 100_000  # values of one quantity


def shown(value: Any) -> str:
    """A value as a message shows it: in one short line."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # of a class of somebody else, or an int of thousands of digits
        text = type(value).__name__
    return text if len(text) <= 60 else f"{text[:57]}..."


def rounded(value: float, *, up: bool) -> str:
    """A limit in four digits, rounded to the side where it is kept."""
    rounding = decimal.ROUND_CEILING if up else decimal.ROUND_FLOOR
    return f"{float(decimal.Context(prec=4, rounding=rounding).create_decimal_from_float(value)):g}"


def is_sequence(value: Any) -> TypeGuard[Iterable]:
    """Whether a value has others in an order; text counts as one value."""
    unordered = isinstance(value, str | bytes | bytearray | memoryview | Mapping | Set)
    return isinstance(value, Iterable) and not unordered and getattr(value, "ndim", 1) > 0


def listed(name: str, value: Iterable) -> list:
    """What a sequence holds: of an array or a table of pandas its rows."""
    if not hasattr(value, "__array__"):
        return list(value)
    # to iterate over a table gives the names of its columns
    if (array := _as_array(value)) is None:
        raise InputError(f"{name} = {shown(value)}: {_PLAIN}")
    return list(array)


def whole_number(name: str, value: Any) -> int:
    """The value as an int; InputError names it if it is not a whole number."""
    if not (is_real(value) and value % 1 == 0):
        raise InputError(f"{name} = {shown(value)}: a whole number is needed")
    return int(value)


def finite_number(name: str, value: Any) -> float:
    """The value as a float; InputError names it if it is not a finite number."""
    if not is_real(value):
        raise InputError(f"{name} = {shown(value)}: a number is needed")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{name} = {number}: a finite number is needed")
    return number


def is_infinite(value: Any) -> bool:
    """Whether a value is the number +infinity, for the few quantities that may be infinite."""
    return isinstance(value, float | np.floating) and value == math.inf


def within(
    name: str, value: Any, *, gt: float = -math.inf, ge: float = -math.inf,
    lt: float = math.inf, le: float = math.inf,
) -> float:  # fmt: skip
    """A number between two ends; with `ge` and `le` it may be the end, with `gt` and `lt` not."""
    number = finite_number(name, value)
    if gt < number < lt and ge <= number <= le:
        return number
    ends = {"greater than": gt, "at least": ge, "below": lt, "at most": le}
    limits = " and ".join(f"{word} {end:g}" for word, end in ends.items() if math.isfinite(end))
    raise InputError(f"{name} = {number:g}: must be {limits}")


def positive(name: str, value: Any, most: float = math.inf) -> float:
    """A number greater than 0, and at most `most`."""
    return within(name, value, gt=0, le=most)


def not_negative(name: str, value: Any, most: float = math.inf) -> float:
    """A number of 0 or greater, and at most `most`."""
    return within(name, value, ge=0, le=most)


def key(name: str, value: Any) -> int:
    """A whole number of 0 or greater that a file can hold: a seed, a replicate, a count."""
    number = whole_number(name, value)
    if not 0 <= number < 2**63:
        raise InputError(f"{name} = {shown(value)}: a whole number from 0 to 2**63 - 1 is needed")
    return number


def spaced(name: str, start: float, stop: float, step: float) -> tuple[float, ...]:
    """Numbers from `start` to `stop`, both ends included, `step` apart."""
    positive(f"{name}.step", step)
    if stop < start:
        raise InputError(f"{name}.stop = {stop:g}: must not be less than start = {start:g}")
    steps = (stop - start) / step + 1e-9  # 0.3 / 0.1 is 2.9999999999999996
    if steps >= LONGEST_GRID:
        many = f"gives {steps:.3g} values, at most {LONGEST_GRID} allowed"
        raise InputError(f"{name}.step = {step:g}: {many}")
    # 35 steps of 0.2 and 14 of 0.5 are both 7.0: random numbers depend on it
    return tuple(round(float(start + index * step), 10) for index in range(math.floor(steps) + 1))


def series(name: str, value: Any) -> np.ndarray:
    """An array of numbers along one axis."""
    array = as_numbers(value)
    if array.ndim != 1:
        raise InputError(f"{name} = {shown(value)}: a sequence of numbers is needed")
    return array


def numbers(name: str, value: Any, count: int, *, rows: bool = False) -> np.ndarray:
    """An array of so many finite numbers, one for each block; if allowed, several rows of them."""
    array = as_numbers(value)
    fits = array.shape[-1:] == (count,) and array.ndim <= 1 + rows
    if not (fits and np.isfinite(array).all()):
        needed = f"{count} numbers are needed, one for each block, all finite"
        raise InputError(f"{name} = {shown(value)}: {needed}")
    return array


def positions(name: str, value: Any, n_blocks: int, *, rows: bool = False) -> np.ndarray:
    """Positions (N,) of the blocks of one chain, from the wall outwards; if allowed, (T, N)."""
    array = numbers(name, value, n_blocks, rows=rows)
    # np.diff takes five times as long
    if not (np.all(array[..., 0] > 0) and np.all(array[..., 1:] > array[..., :-1])):
        raise InputError(f"{name} = {shown(array.tolist())}: must be positive and increasing")
    return array


def path(name: str, value: Any, endings: Sequence[str] = ()) -> Path:
    """Where a file is; its name has one of the endings, if any are told."""
    if not isinstance(value, str | PathLike) or "\0" in str(value):
        raise InputError(f"{name} = {shown(value)}: the path of a file is needed")
    if endings and Path(value).suffix.lower() not in endings:
        raise InputError(f"{name} = {value}: must end in {', '.join(endings)}")
    return Path(value)


def is_real(value: Any) -> bool:
    """Whether a value is a number; NumPy counts a duration among the whole ones."""
    return isinstance(value, Real) and not isinstance(value, bool | np.timedelta64)


def as_numbers(value: Any) -> np.ndarray:
    """The value as an array of floats; of no axis if it is none of numbers."""
    array = _as_array(value)
    if array is None or (array.size and array.dtype.kind not in "iuf"):
        return np.array(math.nan)
    return array.astype(float)


def _as_array(value: Any) -> np.ndarray | None:
    """The value as an array; None if something of it would be lost, or it makes none."""
    if not is_sequence(value):
        return None
    try:
        return None if _has_more(value) else np.asarray(value)
    except Exception:  # lists of different lengths; arrays of somebody else on another device
        return None


def _has_more(value: Any) -> bool:
    """Whether a value or one in its lists is a bool, has a unit or a mask: an array loses that."""
    kind = type(value)  # as a table may have a column of such a name
    has_unit = hasattr(kind, "unit") or hasattr(kind, "units")
    is_masked = isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value)
    is_list = is_sequence(value) and not hasattr(kind, "__array__")
    is_lost = has_unit or is_masked or isinstance(value, bool | np.bool_)
    return is_lost or (is_list and any(map(_has_more, value)))
