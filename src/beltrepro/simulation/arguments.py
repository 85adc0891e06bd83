"""Checks of what the public functions are told: each failure is one line that says what is allowed.

A quantity that may differ from chain to chain is given as one value for all, or as a sequence with
one value for each chain.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias, TypeVar

from beltrepro import checks
from beltrepro.accuracy import START_NOISE
from beltrepro.checks import finite_number, positive
from beltrepro.engine.state import ChainState
from beltrepro.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.model.friction import start_noise
from beltrepro.simulation.methods import KICKED, METHODS, TOLERANCE_RANGE, TOLERANCES

T = TypeVar("T")
PerChain: TypeAlias = T | Sequence[T]

_STEP_SHARE = 1e-6  # by which an instant may miss a whole number of steps
LONGEST_STEP = 0.1  # model time; oscillations take 3


def chains_of(parameters: Any) -> list[ChainParameters]:
    """The chains of a call, given alone or as a sequence of at least one."""
    if isinstance(parameters, ChainParameters):
        return [parameters]
    chains = list(parameters) if isinstance(parameters, Iterable) else []
    if not chains or not all(isinstance(chain, ChainParameters) for chain in chains):
        raise InputError(
            f"parameters = {parameters!r}: "
            "a ChainParameters, or a sequence of at least one, is needed"
        )
    return chains


def for_each(name: str, value: Any, n_chains: int, check: Callable[[str, Any], T]) -> list[T]:
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


def method_name(name: str, value: Any) -> str:
    """A known method."""
    if not isinstance(value, str) or value not in METHODS:
        raise InputError(f"{name} = {value!r}: allowed are {', '.join(METHODS)}")
    return value


def optional_key(name: str, value: Any) -> int | None:
    """A seed or a replicate, or None if it is left to the rule."""
    return None if value is None else checks.key(name, value)


def optional_state(name: str, value: Any) -> ChainState | None:
    """A state to begin from, or None."""
    if value is not None and not isinstance(value, ChainState):
        raise InputError(f"{name} = {value!r}: a ChainState is needed")
    return value


def step(name: str, value: Any) -> float:
    """A time step."""
    if not 0 < finite_number(name, value) <= LONGEST_STEP:
        raise InputError(f"{name} = {value:g}: must be greater than 0 and at most {LONGEST_STEP:g}")
    return float(value)


def tolerance(name: str, value: Any) -> float | None:
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


def method_has_kicks(method: str, kick: float) -> None:
    """That a method which is told to kick can."""
    if kick > 0 and method != KICKED:
        raise InputError(f"kick = {kick:g}: method {method!r} has none, only {KICKED!r}")


def method_has_law(method: str, chain: ChainParameters) -> None:
    """That the noise of "event" has the law of the paper's scheme where slips begin gently."""
    share = start_noise(chain)
    if method != "event" or share <= START_NOISE:
        return
    most = chain.noise * START_NOISE / share
    raise InputError(
        f"noise = {chain.noise:g}: with friction_ratio = {chain.friction_ratio:g} and "
        f"static_friction = {chain.static_friction:g}, method 'event' is checked up to {most:.3g}; "
        "beyond that take 'verlet'"
    )


def whole_steps(name: str, value: float, time_step: float) -> None:
    """That an instant of a scheme in steps is a multiple of the step."""
    steps = value / time_step
    if abs(steps - round(steps)) > _STEP_SHARE:
        raise InputError(
            f"{name} = {value!r}: method 'verlet' needs a multiple of time_step = {time_step:g}"
        )


def lengths(duration: Any, transient: Any) -> tuple[float, float]:
    """Duration of a run, and the part of it that is left out of the results."""
    duration = positive("duration", duration)
    if not 0 <= finite_number("transient", transient) < duration:
        raise InputError(
            f"transient = {transient:g}: must be at least 0 and less than duration = {duration:g}"
        )
    return duration, float(transient)
