"""Names of arguments, keys and targets: what is meant by one that is not known."""

import difflib
import functools
import inspect
import textwrap
from collections.abc import Callable, Collection, Iterable
from textwrap import shorten
from typing import Any, TypeVar, cast

from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError

F = TypeVar("F", bound=Callable[..., Any])
_LONGEST_LIST = 300  # letters

# Names by the symbols of the paper, in plain letters.
SYMBOLS = {"N": "n_blocks", "u": "belt_velocity", "sigma": "noise", "dt": "time_step",
           "F_st0": "static_friction", "f_s": "friction_ratio", "l": "rest_length",
           "Delta_l_max": "linear_limit", "b_1": "compression_rate", "b_2": "extension_rate",
           "m": "mass", "k": "stiffness", "v_w": "weakening_velocity", "eta": "viscosity",
           "t": "duration", "r": "disorder_parameter"}  # fmt: skip

# What left in version 2.0, and what does the same.
LEFT = {
    "Audit": "`energy_residual` and `sum_rule_residual` of a Run test it",
    "audit": "`energy_residual` and `sum_rule_residual` of a Run test it",
    "bench": "`make bench` measures the integrators",
    "branch": "in Python `orbit_branch` follows an orbit",
    "cache": "`make cache` compiles the integrators",
    "close_orbit": "`periodic_orbit` from a state near it, or `orbit_branch` gives the orbit",
    "finite_time": "means over stretches of `spectrum.growth` are the same",
    "kick": "nothing does the same",
    "publish": "`make publish` does it",
    "separation": "`simulate` from two states that lie close to each other does the same",
    "to_xarray": "`table().set_index(results.axes).to_xarray()` is the same",
}


def left(name: str) -> str:
    """A line about a name that was public before version 2.0; empty if it was none."""
    return f"{name} left in version 2.0: {LEFT[name]}; see CHANGELOG.md" if name in LEFT else ""


def hint(word: str, names: Iterable[str]) -> str:
    """What may be meant by a name, as the end of a line about it."""
    names = list(names)
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    meant = [name for name in (SYMBOLS.get(word), *near) if name in names]
    return f"; did you mean {meant[0]!r}?" if meant else ""


def one_of(name: str, value: Any, allowed: Iterable[str]) -> str:
    """Check that a value is one of some words."""
    allowed = list(allowed)
    if isinstance(value, str) and value in allowed:
        return value
    meant = hint(value, allowed) if isinstance(value, str) else ""
    listed = shorten(", ".join(allowed), _LONGEST_LIST, placeholder=" ...")
    raise InputError(f"{name} = {shown(value)}: allowed are {listed}{meant}")


def checked(called: F, also: Collection[str] = ()) -> F:
    """Decorate a callable so that a wrong argument is one clear line; `also`: its **keywords."""
    if isinstance(called, type):
        made: Any = called
        made.__init__ = checked(made.__init__)
        return called
    signature = inspect.signature(called)
    parameters = [item for item in signature.parameters.values() if item.kind is not _KEYWORDS]
    accepted = [item.name for item in parameters if item.name not in ("self", "cls")] + [*also]
    title = called.__qualname__.removesuffix(".__init__")

    @functools.wraps(called)
    def call(*args: Any, **kwargs: Any) -> Any:
        for name in kwargs:
            if name not in accepted:
                meant = hint(name, accepted) or f": allowed are {', '.join(accepted)}"
                raise InputError(left(name) or f"{title} has no argument {name!r}{meant}")
        try:
            return called(*args, **kwargs)
        except TypeError:  # looked at only now: to bind takes as long as to make a chain
            try:
                signature.bind(*args, **kwargs)
            except TypeError as error:
                named = _to_be_named(parameters, also, args, kwargs)
                needed = f"its arguments are {textwrap.shorten(', '.join(accepted), 300)}"
                words = f"write {named}" if named else f"{error}: {needed}"
                raise InputError(f"{title}: {words}") from None
            raise

    return cast(F, call)


_KEYWORDS = inspect.Parameter.VAR_KEYWORD


def _to_be_named(
    parameters: list[inspect.Parameter], also: Collection[str], args: tuple, kwargs: dict
) -> str:
    """Values without a name as they would be written; empty if there are not too many of them."""
    free = [item for item in parameters if item.name not in kwargs]
    named = [item.name for item in free if item.kind is inspect.Parameter.KEYWORD_ONLY]
    values = args[len(free) - len(named) :]
    if len(values) > len(named):
        return ""
    if len(values) == 2 and isinstance(values[0], str) and values[0] in also:
        return f"{values[0]}={shown(values[1])}"
    return ", ".join(f"{name}={shown(value)}" for name, value in zip(named, values, strict=False))
