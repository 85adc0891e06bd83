"""Parameters of one chain in model units (Sec. III)."""

import math
from dataclasses import dataclass, fields
from functools import cached_property
from operator import attrgetter
from typing import Any

import numpy as np

from beltrepro.base import names
from beltrepro.base.checks import is_infinite, is_sequence, listed, shown, whole_number, within
from beltrepro.base.errors import InputError
from beltrepro.base.names import one_of
from beltrepro.model import units

LARGEST = 1e9  # of every number: beyond it forces and positions have no digits left for the motion
LONGEST = 1e12  # model time: instants beyond are not told apart to 1e-4

_POSITIVE = {"gt": 0, "le": LARGEST}
_NOT_NEGATIVE = {"ge": 0, "le": LARGEST}
_RATE = {"ge": 1e-6, "le": LARGEST}  # forces are (e^x - 1) / rate, which rounds by 1e-16 / rate
LIMITS: dict[str, dict[str, Any]] = {
    "n_blocks": {"ge": 1, "le": 1_000_000},  # a thousand chains of so many fill any memory
    "belt_velocity": _POSITIVE,
    "noise": _NOT_NEGATIVE,
    "static_friction": _POSITIVE,
    "friction_ratio": {"ge": 0, "lt": 1},
    "rest_length": _POSITIVE,
    "linear_limit": _POSITIVE,
    "compression_rate": _RATE,
    "extension_rate": _RATE,
    "mass": _POSITIVE,
    "stiffness": _POSITIVE,
    "weakening_velocity": _POSITIVE,
    "viscosity": _NOT_NEGATIVE,
    "initial_spread": _NOT_NEGATIVE,
    "duration": {"gt": 0, "le": LONGEST},
    "time_step": {"ge": 1e-9, "le": 0.1},  # oscillations take 3
    "tolerance": {"ge": 1e-16, "le": 1},  # of forces of some tens, which round by 1e-16 of them
}
"""What each quantity may be, by the names that `checks.within` and pydantic have for ends."""
_LETTERS, _MOST_SHOWN = {"belt_velocity": "u", "noise": "sigma"}, 3  # blocks, in messages
PER_BLOCK = ("static_friction", "friction_ratio", "rest_length", "mass", "stiffness")
_MAY_BE_INFINITE = ("linear_limit", "weakening_velocity")

PerBlock = Any  # float, or a tuple of N of them


@names.checked
@dataclass(frozen=True, repr=False)
class ChainParameters:
    """One chain on the belt, in model units (mass = spring constant = 1, length 1.4 mm).

    No number may be greater than 1e9, but for those that may be infinite. What says "per block" is
    a number for all or a sequence of N, block 1 or the spring at the wall first. The law of the
    paper has neither `weakening_velocity` nor `viscosity`, and blocks that are alike: others are
    computed by kernels of their own, which are slower (docs/laws.md).

    Attributes
    ----------
    n_blocks : int
        Number of blocks N, 1 to a million; cost: docs/integrators.md.
    belt_velocity : float
        Velocity u of the belt, > 0.
    noise : float
        Standard deviation sigma of the static friction force, >= 0.
    static_friction : float or tuple of float
        Mean static friction force F_st0, > 0, per block (Sec. III: 71.4).
    friction_ratio : float or tuple of float
        Kinetic over static friction f_s, from 0 to below 1, per block (Sec. II: 0.45).
    rest_length : float or tuple of float
        Undeformed spring length l, > 0, per spring (Sec. III: 50).
    linear_limit : float
        Deformation up to which a spring is linear, > 0; `math.inf`: linear springs (Sec. III: 20).
    compression_rate : float
        Exponent b_1 of the compressed branch, 1e-6 or more (Sec. III: 0.2).
    extension_rate : float
        Exponent b_2 of the stretched branch, 1e-6 or more (Sec. III: 0.01).
    mass : float or tuple of float
        Mass m, > 0, per block (Sec. III: 1).
    stiffness : float or tuple of float
        Factor k of the tension, > 0, per spring (Sec. III: 1).
    weakening_velocity : float
        Slip velocity v_w that halves kinetic friction, > 0; `math.inf`: it does not weaken.
    viscosity : float
        Coefficient eta of a further friction force -eta v_r, >= 0 (Sec. III: 0).

    Raises
    ------
    InputError
        If a value is missing, not a number or out of its range; names the key and what is allowed.
    """

    n_blocks: int
    belt_velocity: float
    noise: float = 0.0
    static_friction: PerBlock = 71.4
    friction_ratio: PerBlock = 0.45
    rest_length: PerBlock = 50.0
    linear_limit: float = 20.0
    compression_rate: float = 0.2
    extension_rate: float = 0.01
    mass: PerBlock = 1.0
    stiffness: PerBlock = 1.0
    weakening_velocity: float = math.inf
    viscosity: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "n_blocks", whole_number("n_blocks", self.n_blocks))
        within("n_blocks", self.n_blocks, **LIMITS["n_blocks"])
        for field in fields(self)[1:]:
            value = getattr(self, field.name)
            if field.name in PER_BLOCK and is_sequence(value):
                value = _of_blocks(field.name, value, self.n_blocks)
            elif field.name not in _MAY_BE_INFINITE or not is_infinite(value):
                value = within(field.name, value, **LIMITS[field.name])
            object.__setattr__(self, field.name, value)

    def __repr__(self) -> str:
        values = ((field, getattr(self, field.name)) for field in fields(self))
        given = (f"{field.name}={value!r}" for field, value in values if value != field.default)
        return f"ChainParameters({', '.join(given)})"

    @property
    def law(self) -> tuple:
        """Everything but n_blocks, belt_velocity and noise: chains advanced together share it."""
        return _law(self)

    @cached_property
    def varied(self) -> bool:
        """Whether the law is another than the paper's: blocks that differ, or friction with v."""
        further = self.mass, self.stiffness, self.weakening_velocity, self.viscosity
        return further != _PAPER_LAW or any(isinstance(value, tuple) for value in self.law)

    @property
    def friction_varies(self) -> bool:
        """Whether kinetic friction depends on the velocity."""
        return self.viscosity > 0 or math.isfinite(self.weakening_velocity)

    @property
    def rest_positions(self) -> np.ndarray:
        """Positions (N,) of the blocks with undeformed springs: the initial state of Sec. III."""
        if isinstance(self.rest_length, tuple):
            return np.cumsum(self.rest_length)
        return self.rest_length * np.arange(1, self.n_blocks + 1, dtype=float)

    @names.checked
    def by_block(self, quantity: str) -> np.ndarray:
        """A constant of each block, or of the spring before it, as numbers.

        Parameters
        ----------
        quantity : str
            As `static_friction` or `stiffness`.

        Returns
        -------
        array (N,)
            In model units.

        Raises
        ------
        InputError
            There is no such constant.
        """
        one_of("quantity", quantity, [field.name for field in fields(self)[1:]])
        return np.full(self.n_blocks, getattr(self, quantity))

    def describe(self, si: bool = False) -> str:
        """Short text that names the chain, for messages.

        Parameters
        ----------
        si : bool
            Whether its numbers are in SI, as "N=5, u=0.1831 m/s, sigma=0.01386 N".

        Returns
        -------
        str
            As "N=5, u=10, sigma=0.5", and what differs from the law of the paper: "mass=(1, 3, 1)".
        """
        parts = [f"N={self.n_blocks}"]
        for name, default in ((field.name, field.default) for field in fields(self)[1:]):
            value, letter = getattr(self, name), _LETTERS.get(name)
            if letter or value != default:
                parts.append(f"{letter or name}={_in_words(name, value, si)}")
        return ", ".join(parts)


def _in_words(name: str, value: Any, si: bool) -> str:
    """A constant as text; of many blocks the first few."""
    size, symbol = units.SI.get(units.UNIT_OF.get(name, "") if si else "", (1.0, ""))
    first = np.atleast_1d(value)[: _MOST_SHOWN + 1]
    texts = [f"{size * number:{'.4g' if si else 'g'}}" for number in first]
    text = ", ".join([*texts[:_MOST_SHOWN], *["..." for _ in texts[_MOST_SHOWN:]]])
    return (f"({text}) {symbol}" if isinstance(value, tuple) else f"{text} {symbol}").rstrip()


def check_chain(parameters: Any) -> None:
    if not isinstance(parameters, ChainParameters):
        raise InputError(f"parameters = {shown(parameters)}: a ChainParameters is needed")


def _of_blocks(name: str, values: Any, n_blocks: int) -> float | tuple[float, ...]:
    """N numbers, or one if they are all the same."""
    values = listed(name, values)
    if len(values) != n_blocks:
        needed = f"one number or {n_blocks} are needed, as n_blocks = {n_blocks}"
        raise InputError(f"{name} = {shown(values)} has {len(values)} numbers: {needed}")
    limits = LIMITS[name]
    numbers = tuple(within(f"{name}[{i}]", value, **limits) for i, value in enumerate(values))
    return numbers[0] if len(set(numbers)) == 1 else numbers


_law = attrgetter(*(field.name for field in fields(ChainParameters)[3:]))
_PAPER_LAW = (1.0, 1.0, math.inf, 0.0)  # mass, stiffness, weakening_velocity, viscosity
