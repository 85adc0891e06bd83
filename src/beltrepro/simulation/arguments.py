"""Checks of what the public functions are told: each failure is one line that says what is allowed.

A quantity that may differ from chain to chain is given as one value for all, or as a sequence with
one value for each chain.
"""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, TypeVar

from beltrepro.base import checks, names
from beltrepro.base.checks import finite_number, is_sequence, positive, shown
from beltrepro.base.errors import InputError
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model.friction import noise_beyond_event
from beltrepro.model.parameters import LONGEST
from beltrepro.simulation.methods import KICKED, METHODS, TOLERANCE_RANGE, TOLERANCES

T = TypeVar("T")
PerChain: TypeAlias = T | Sequence[T]

_STEP_SHARE = 1e-6  # by which an instant may miss a whole number of steps
SHORTEST_STEP, LONGEST_STEP = 1e-9, 0.1  # model time; oscillations take 3


def chains_of(parameters: Any) -> list[ChainParameters]:
    """The chains of a call, given alone or as a sequence of at least one."""
    if isinstance(parameters, ChainParameters):
        return [parameters]
    chains = list(parameters) if is_sequence(parameters) else []
    if not chains or not all(isinstance(chain, ChainParameters) for chain in chains):
        raise InputError(
            f"parameters = {shown(parameters)}: "
            "a ChainParameters, or a sequence of at least one, is needed"
        )
    return chains


def of_one_chain(parameters: Any, **quantities: Any) -> None:
    """That a call about one chain is given one, and one value of each quantity."""
    if not isinstance(parameters, ChainParameters):
        raise InputError(f"parameters = {shown(parameters)}: a ChainParameters is needed")
    for name, value in quantities.items():
        if is_sequence(value):
            raise InputError(f"{name} = {shown(value)}: one value is needed, for one chain")


def progress(value: Any) -> None:
    """That a report of progress can be called."""
    if value is not None and not callable(value):
        raise InputError(f"progress = {shown(value)}: a function of the fraction done is needed")


def for_each(name: str, value: Any, n_chains: int, check: Callable[[str, Any], T]) -> list[T]:
    """One checked value for each chain, from one for all or a sequence of them.

    check : takes the name and a value, returns the value as it is used, or raises InputError.
    """
    if not is_sequence(value):
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
    return names.one_of(name, value, METHODS)


def optional_key(name: str, value: Any) -> int | None:
    """A seed or a replicate, or None if it is left to the rule."""
    return None if value is None else checks.key(name, value)


def optional_state(name: str, value: Any) -> ChainState | None:
    """A state to begin from, or None."""
    if value is not None and not isinstance(value, ChainState):
        raise InputError(f"{name} = {shown(value)}: a ChainState is needed")
    return value


def step(name: str, value: Any) -> float:
    """A time step."""
    return _within(name, value, SHORTEST_STEP, LONGEST_STEP)


def tolerance(name: str, value: Any) -> float | None:
    """A tolerance, or None for the method's own."""
    if value is None:
        return None
    return _within(name, value, *TOLERANCE_RANGE)


def _within(name: str, value: Any, low: float, high: float) -> float:
    """A number from `low` to `high`."""
    number = finite_number(name, value)
    if not low <= number <= high:
        raise InputError(f"{name} = {number:g}: must be at least {low:g} and at most {high:g}")
    return number


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
    if method == "event" and (text := noise_beyond_event(chain)):
        raise InputError(f"noise {text}")


def whole_steps(name: str, value: float, time_step: float) -> None:
    """That an instant of a scheme in steps is a multiple of the step."""
    steps = value / time_step
    if abs(steps - round(steps)) > _STEP_SHARE:
        raise InputError(
            f"{name} = {value!r}: method 'verlet' needs a multiple of time_step = {time_step:g}"
        )


def lengths(duration: Any, transient: Any) -> tuple[float, float]:
    """Duration of a run, and the part of it that is left out of the results."""
    duration, transient = length(duration), finite_number("transient", transient)
    if not 0 <= transient < duration:
        raise InputError(
            f"transient = {transient:g}: must be at least 0 and less than duration = {duration:g}"
        )
    return duration, transient


def length(duration: Any) -> float:
    """Duration of a run."""
    return positive("duration", duration, LONGEST)
