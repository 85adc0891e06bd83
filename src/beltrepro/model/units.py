"""Model units and SI (Sec. III).

The three base units are the block's mass, the spring constant and a length; time, velocity,
force and energy follow: [t] = sqrt([m]/[k]), [u] = [l]/[t], [F] = [k][l], [E] = [k][l]^2.
"""

import math
from typing import Any, TypeVar

import numpy as np

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError

Number = TypeVar("Number", float, np.ndarray)

MASS_KG = 0.1158
SPRING_CONSTANT_N_M = 19.8
LENGTH_M = 1.4e-3

TIME_S = math.sqrt(MASS_KG / SPRING_CONSTANT_N_M)
VELOCITY_M_S = LENGTH_M / TIME_S
FORCE_N = SPRING_CONSTANT_N_M * LENGTH_M
ENERGY_J = SPRING_CONSTANT_N_M * LENGTH_M**2

STATIC_FRICTION_N = 1.98
KINETIC_FRICTION_N = 0.89

SI = {
    "mass": (MASS_KG, "kg"), "length": (LENGTH_M, "m"), "1/length": (1 / LENGTH_M, "1/m"),
    "time": (TIME_S, "s"), "1/time": (1 / TIME_S, "1/s"), "velocity": (VELOCITY_M_S, "m/s"),
    "force": (FORCE_N, "N"), "energy": (ENERGY_J, "J"), "stiffness": (SPRING_CONSTANT_N_M, "N/m"),
    "viscosity": (FORCE_N / VELOCITY_M_S, "N s/m"), "1": (1.0, ""),
}  # fmt: skip
"""Size and symbol of each unit."""
TEXTS = {name: f"model {name} ({size:.3g} {symbol})" for name, (size, symbol) in SI.items()}
TEXTS |= {"1": "1", "length": f"model length ({1e3 * LENGTH_M:.3g} mm)"}
TEXTS |= {f"1/{name}": f"1 / {TEXTS[name]}" for name in ("length", "time")}
"""Each unit as files carry it."""

_UNITS = {
    "1": "n_blocks friction_ratio disorder_parameter final_disorder section_count slip_count "
    "section_histogram laminar_fraction laminar_count energy_residual sum_rule_residual",
    "length": "rest_length linear_limit initial_spread mean_length minimum_length maximum_length "
    "section_position final_mean_length final_amplitude",
    "1/length": "compression_rate extension_rate",
    "time": "time_step laminar_mean laminar_longest last_stick_time lifetime period_time "
    "irregular_time interval",
    "1/time": "final_stick_rate largest_exponent standard_error irregular_exponent irregular_error "
    "nontrivial_exponent nontrivial_error exponents growth",
    "velocity": "belt_velocity weakening_velocity section_velocity",
    "force": "static_friction noise tolerance mean_wall_tension",
}
UNIT_OF = {name: unit for unit, words in _UNITS.items() for name in words.split()}
UNIT_OF |= {name: name for name in SI}
"""The unit of each constant of a chain and array of results; the others are numbers."""


@names.checked
def to_si(value: Number, quantity: str) -> Number:
    """Convert from model units to SI, as `to_si(10, "velocity")`: 0.183 m/s.

    Parameters
    ----------
    value : float or array
        In model units.
    quantity : str
        mass, length, time, velocity, force, energy, 1/length, 1/time, stiffness or viscosity; or
        the name of a constant of a chain or of an array of results, as "mean_length"; those without
        a unit stay as they are.

    Returns
    -------
    float or array
        In kg, m, s, m/s, N, J, 1/m, 1/s, N/m or N s/m.

    Raises
    ------
    InputError
        There is no such quantity, or the value is no number and no array of them.
    """
    number, size = _read(value, quantity)
    return number * size


@names.checked
def from_si(value: Number, quantity: str) -> Number:
    """Convert from SI to model units, as `from_si(0.18, "velocity")`: 9.83.

    Parameters
    ----------
    value : float or array
        In the unit that `to_si` gives.
    quantity : str
        As of `to_si`.

    Returns
    -------
    float or array
        In model units.

    Raises
    ------
    InputError
        As of `to_si`.
    """
    number, size = _read(value, quantity)
    return number / size


def _read(value: Any, quantity: Any) -> tuple[Any, float]:
    """A number or array, and the size of a unit."""
    unit = UNIT_OF.get(quantity, quantity) if isinstance(quantity, str) else quantity
    size = SI[names.one_of("quantity", unit, [*SI, *UNIT_OF])][0]
    if checks.is_real(value):
        floats = isinstance(value, float | np.floating)  # which may be infinite
        return float(value) if floats else checks.finite_number("value", value), size
    if (value := checks.as_numbers(given := value)).ndim:
        return value, size
    raise InputError(f"value = {checks.shown(given)}: a number or an array of them is needed")
