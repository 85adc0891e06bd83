"""Parameters of one chain in model units (Sec. III)."""

from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any

import numpy as np

from beltrepro.base import names
from beltrepro.base.checks import is_infinite, whole_number, within

MAXIMUM_BLOCKS = 64
LARGEST = 1e9  # of every number: beyond it forces and positions have no digits left for the motion
LONGEST = 1e12  # model time: instants beyond are not told apart to 1e-4

_POSITIVE = {"gt": 0, "le": LARGEST}
_NOT_NEGATIVE = {"ge": 0, "le": LARGEST}
LIMITS: dict[str, dict[str, Any]] = {
    "n_blocks": {"ge": 1, "le": MAXIMUM_BLOCKS},
    "belt_velocity": _POSITIVE,
    "noise": _NOT_NEGATIVE,
    "static_friction": _POSITIVE,
    "friction_ratio": {"ge": 0, "lt": 1},
    "rest_length": _POSITIVE,
    "linear_limit": _POSITIVE,
    "compression_rate": _POSITIVE,
    "extension_rate": _POSITIVE,
    "initial_spread": _NOT_NEGATIVE,
    "kick": _NOT_NEGATIVE,
    "duration": {"gt": 0, "le": LONGEST},
    "time_step": {"ge": 1e-9, "le": 0.1},  # oscillations take 3
    "tolerance": {"ge": 1e-16, "le": 1},  # of forces of some tens, which round by 1e-16 of them
}
"""What each quantity may be, by the names that `checks.within` and pydantic have for ends."""


@names.checked
@dataclass(frozen=True)
class ChainParameters:
    """One chain on the belt, in model units (mass = spring constant = 1, length 1.4 mm).

    No number may be greater than 1e9, but for the limit of linear springs.

    Attributes
    ----------
    n_blocks : int
        Number of blocks N, 1 to 64.
    belt_velocity : float
        Velocity u of the belt, > 0.
    noise : float
        Standard deviation sigma of the static friction force, >= 0.
    static_friction : float
        Mean static friction force F_st0, > 0 (Sec. III: 71.4).
    friction_ratio : float
        Kinetic over static friction f_s, from 0 to below 1 (Sec. II: 0.45).
    rest_length : float
        Undeformed spring length l, > 0 (Sec. III: 50).
    linear_limit : float
        Deformation up to which a spring is linear, > 0; `math.inf`: linear springs (Sec. III: 20).
    compression_rate : float
        Exponent b_1 of the compressed branch, > 0 (Sec. III: 0.2).
    extension_rate : float
        Exponent b_2 of the stretched branch, > 0 (Sec. III: 0.01).

    Raises
    ------
    InputError
        If a value is missing, not a number or out of its range; names the key and what is allowed.
    """

    n_blocks: int
    belt_velocity: float
    noise: float = 0.0
    static_friction: float = 71.4
    friction_ratio: float = 0.45
    rest_length: float = 50.0
    linear_limit: float = 20.0
    compression_rate: float = 0.2
    extension_rate: float = 0.01

    def __post_init__(self) -> None:
        object.__setattr__(self, "n_blocks", whole_number("n_blocks", self.n_blocks))
        within("n_blocks", self.n_blocks, **LIMITS["n_blocks"])
        for field in fields(self)[1:]:
            value = getattr(self, field.name)
            if field.name != "linear_limit" or not is_infinite(value):
                value = within(field.name, value, **LIMITS[field.name])
            object.__setattr__(self, field.name, float(value))

    @property
    def law(self) -> tuple[float, ...]:
        """Everything but n_blocks, belt_velocity and noise: chains advanced together share it."""
        return _law(self)

    @property
    def rest_positions(self) -> np.ndarray:
        """Positions (N,) of the blocks with undeformed springs: the initial state of Sec. III."""
        return self.rest_length * np.arange(1, self.n_blocks + 1, dtype=float)

    def describe(self) -> str:
        """Short text that names the chain, for messages.

        Returns
        -------
        str
            As "N=5, u=10, sigma=0.5".
        """
        return f"N={self.n_blocks}, u={self.belt_velocity:g}, sigma={self.noise:g}"


_law = attrgetter(*(field.name for field in fields(ChainParameters)[3:]))
