"""Grids of chains: every combination of some values of the quantities of a chain."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields
from numbers import Real
from typing import Any, TypeAlias, TypeVar

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.model.parameters import PER_BLOCK

T = TypeVar("T")
Axis: TypeAlias = T | Sequence[T]
"""One value of a quantity, or the values that it takes in turn."""

MOST_CHAINS = 1_000_000  # each is a run
QUANTITIES = tuple(quantity.name for quantity in fields(ChainParameters))
_PAPER = ChainParameters(n_blocks=1, belt_velocity=1.0)


@names.checked
@dataclass(frozen=True, eq=False, repr=False)
class Grid:
    """Chains at every combination of some values, for the functions that take several chains.

    They are in the order of the fields: the replicate varies fastest, then `viscosity`.

    Attributes
    ----------
    n_blocks : int or sequence of int
        Number of blocks N.
    belt_velocity : float or sequence of float
        Velocity u of the belt.
    noise : float or sequence of float
        Standard deviation sigma of the static friction force.
    static_friction, friction_ratio : float or sequence of float
        F_st0 and f_s.
    rest_length, linear_limit : float or sequence of float
        l and Delta l_max of the springs.
    compression_rate, extension_rate : float or sequence of float
        b_1 and b_2 of the springs.
    mass, stiffness : float or sequence of float
        m of all blocks and k of all springs; mass=[(1, 3, 1)] is one chain whose blocks differ.
    weakening_velocity, viscosity : float or sequence of float
        v_w and eta of kinetic friction.
    replicates : int or sequence of int
        Runs at each combination, with other random numbers: how many, the replicates 0, 1, ...; or
        which, as in `range(16, 32)`.
    chains : tuple of ChainParameters
        The P chains.
    replicate : tuple of int
        Which replicate each is.

    Raises
    ------
    InputError
        A value is not allowed, or there are more than a million chains.
    """

    n_blocks: Axis[int]
    belt_velocity: Axis[float]
    noise: Axis[float] = _PAPER.noise
    static_friction: Axis[float] = _PAPER.static_friction
    friction_ratio: Axis[float] = _PAPER.friction_ratio
    rest_length: Axis[float] = _PAPER.rest_length
    linear_limit: Axis[float] = _PAPER.linear_limit
    compression_rate: Axis[float] = _PAPER.compression_rate
    extension_rate: Axis[float] = _PAPER.extension_rate
    mass: Axis[float] = _PAPER.mass
    stiffness: Axis[float] = _PAPER.stiffness
    weakening_velocity: Axis[float] = _PAPER.weakening_velocity
    viscosity: Axis[float] = _PAPER.viscosity
    replicates: int | Sequence[int] = 1
    chains: tuple[ChainParameters, ...] = field(init=False)
    replicate: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        axes = {name: _values(name, getattr(self, name)) for name in QUANTITIES}
        for name in PER_BLOCK:
            check_chains(name, getattr(self, name), axes)
        copies = _replicates(self.replicates)
        for name, values in (axes | {"replicates": copies}).items():
            if isinstance(getattr(self, name), Iterator):  # it has no values any more
                object.__setattr__(self, name, values)
        count = len(copies) * (combinations := math.prod(map(len, axes.values())))
        if not 1 <= count <= MOST_CHAINS:
            largest = max(axes, key=lambda name: len(axes[name]))
            name = "replicates" if len(copies) in (0, count) else largest
            raise InputError(f"{name}: makes {count} points, allowed are 1 to {MOST_CHAINS}")
        different = [ChainParameters(*values) for values in itertools.product(*axes.values())]
        chains = tuple(chain for chain in different for _ in copies)
        object.__setattr__(self, "chains", chains)
        object.__setattr__(self, "replicate", tuple(copies) * combinations)

    def __len__(self) -> int:
        return len(self.chains)

    def __repr__(self) -> str:
        axes = [name for name in QUANTITIES if checks.is_sequence(getattr(self, name))]
        return f"Grid({len(self)} chains over {', '.join([*axes, 'replicate'])})"


def _values(name: str, value: Any) -> list:
    """The values of an axis; whether each is right, its chain will say."""
    if not checks.is_sequence(value):
        return [value]
    if values := checks.listed(name, value):
        return values
    raise InputError(f"{name} is empty: at least one number is needed")


def _replicates(value: Any) -> Sequence[int]:
    """Which replicates there are, of a number of them or of themselves."""
    if not checks.is_sequence(value):
        return range(checks.key("replicates", value))
    copies = [checks.key("replicates", item) for item in checks.listed("replicates", value)]
    if len(set(copies)) < len(copies):
        raise InputError(f"replicates = {checks.shown(value)}: each may be there once")
    return copies


def check_chains(name: str, value: Any, axes: dict[str, list]) -> None:
    """That numbers which each block can have are not meant as those of the blocks of one chain."""
    numbers = [item for item in axes[name] if isinstance(item, Real)]
    fits = len(numbers) > 1 and len(numbers) in axes["n_blocks"]
    if (fits and isinstance(value, tuple)) or len(set(numbers)) < len(numbers):
        written = [repr(float(item)).removesuffix(".0") for item in numbers]
        one = f"{name}=[({', '.join(written)})] for one chain whose blocks differ so, "
        several = f"{name}=[{', '.join(dict.fromkeys(written))}] for several of equal blocks"
        either = one + several if fits else several
        raise InputError(f"{name} = {checks.shown(value)}: write {either}")
