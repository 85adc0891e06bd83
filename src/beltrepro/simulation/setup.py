"""What a call is told of its chains, as one value that is made and checked once."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, fields, replace
from functools import cached_property, partial
from inspect import signature
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.random.bit_generator import ISeedSequence
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.base.checks import is_sequence, shown
from beltrepro.base.errors import InputError
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.noise import stream_states
from beltrepro.engine.state import ChainState, states_at_rest
from beltrepro.engine.verlet_integrator import VerletIntegrator
from beltrepro.model import ChainParameters, section_position
from beltrepro.model.friction import noise_beyond_event
from beltrepro.model.parameters import LIMITS
from beltrepro.simulation.grid import QUANTITIES, Grid

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])
PerChain: TypeAlias = T | Sequence[T]
"""One value for all chains, or one for each."""

METHODS = {"verlet": VerletIntegrator, "event": EventIntegrator}
# Tolerance of a step that a method takes unless told otherwise, for those that have one.
TOLERANCES: dict[str, float] = {
    name: signature(integrator).parameters["tolerance"].default
    for name, integrator in METHODS.items()
    if "tolerance" in signature(integrator).parameters
}
DEFAULT_SEED = 1
_MEANS = ("method", "time_step", "tolerance", "initial_spread")
_STEP_SHARE = 1e-6  # by which an instant may miss a whole number of steps
_INITIAL_POSITIONS = 1  # purpose of a random stream: initial positions, not friction


@dataclass(frozen=True, eq=False)
class Case:
    """One chain to simulate: from which state, by what means."""

    state: ChainState
    method: str
    time_step: float
    tolerance: float | None  # as asked for; None for the method's own
    initial_spread: float = 0.0  # with which the state was made

    @property
    def parameters(self) -> ChainParameters:
        """The chain."""
        return self.state.parameters

    @cached_property
    def kind(self) -> tuple:
        """What chains have in common that advance together."""
        # An integrator may treat chains without noise in another way, and what a chain does must
        # not depend on the others.
        chain = self.parameters
        numerics = self.method, self.time_step, self.tolerance
        return chain.n_blocks, chain.law, chain.noise > 0, self.state.time, *numerics

    @property
    def accuracy(self) -> dict[str, float]:
        """What the integrator is told about its accuracy."""
        if self.tolerance is None:
            return {}
        return {"tolerance": self.tolerance, "noise_share": 0.0}  # as asked, noise or not

    @property
    def identity(self) -> tuple:
        """What decides all numbers of a run: cases that agree in it give the same run."""
        state = self.state
        arrays = [state.displacements, state.relative_velocities, state.directions]
        if self.parameters.noise > 0:
            arrays += [state.thresholds, state.stream]
        return self.parameters, self.kind, *(array.tobytes() for array in arrays)


def check_state(name: str, value: Any) -> ChainState:
    """A state of a chain."""
    if not isinstance(value, ChainState):
        raise InputError(f"{name} = {shown(value)}: a ChainState is needed")
    return value


def _or_none(check: Callable[..., T], name: str, value: Any, **limits: float) -> T | None:
    """A checked value, or None for that of a rule."""
    return None if value is None else check(name, value, **limits)


def check_tolerance(name: str, value: Any) -> float | None:
    """A tolerance, or None for the method's own."""
    return _or_none(checks.within, name, value, **LIMITS["tolerance"])


_check_method = partial(names.one_of, allowed=METHODS)
_check_time_step = partial(checks.within, **LIMITS["time_step"])
_check_key = partial(_or_none, checks.key)
_check_positions = partial(_or_none, checks.series)
_check_spread = partial(checks.within, **LIMITS["initial_spread"])
_check_start = partial(_or_none, check_state)


@names.checked
@dataclass(frozen=True, eq=False, repr=False)
class Setup:
    """Chains, by what means they are advanced, and where they begin.

    All functions take one, or its chains and keywords: `simulate(Setup(chain, method="verlet"),
    duration=100)` is `simulate(chain, method="verlet", duration=100)`. Each quantity is one value
    for all chains, or a sequence with one value for each. One chain with sequences is simulated
    once for each of their values: `Setup(chain, replicate=range(200))` are 200 runs of it.

    Attributes
    ----------
    chains : ChainParameters, sequence of them, or Grid
        The chains, which may differ in everything.
    method : str
        "event", the exact dynamics (docs/integrators.md), or "verlet", the scheme of the Appendix.
    time_step : float
        dt, model time, at most 0.1; for "event" it only sets the strength of the noise.
    tolerance : float or None
        Only for "event": last terms of the series of a force allowed at the end of a step, unit of
        force, 1e-16 to 1. None for the method's own, which is larger with noise
        (docs/integrators.md).
    seed, replicate : int or None
        Of 0 or greater; with the parameters they fix all random numbers. If not given, 1 and 0, or
        those of `initial_state`, whose random stream then goes on. A Grid has its own replicates.
    initial_positions : array (N,), or one for each chain, or None
        Positions of the blocks at t = 0, model length; undeformed springs if not given. All blocks
        are stuck.
    initial_spread : float
        Standard deviation of normal deviates that are added to the initial positions of replicates
        other than 0, model length.
    initial_state : ChainState or None
        Where to go on, for instance `final_state` of a run (docs/integrators.md). Time goes
        on from that of the state.
        The chain may have another belt velocity, noise or law than that of the
        state (`ChainState.under`), and another method may go on.
    workers : int or None
        Cores on which several chains are advanced at once; None for all that there are. No number
        depends on it.
    cases : tuple
        What follows from these: the state of each chain, and how it is advanced.

    Raises
    ------
    InputError
        A value is not allowed; the line names it and says what is.
    """

    chains: ChainParameters | Sequence[ChainParameters] | Grid
    _: KW_ONLY
    method: PerChain[str] = field(default="event", metadata={"check": _check_method})
    time_step: PerChain[float] = field(default=0.001, metadata={"check": _check_time_step})
    tolerance: PerChain[float | None] = field(default=None, metadata={"check": check_tolerance})
    seed: PerChain[int] | None = field(default=None, metadata={"check": _check_key})
    replicate: PerChain[int] | None = field(default=None, metadata={"check": _check_key})
    initial_positions: ArrayLike | Sequence[ArrayLike] | None = field(
        default=None, metadata={"check": _check_positions}
    )
    initial_spread: PerChain[float] = field(default=0.0, metadata={"check": _check_spread})
    initial_state: PerChain[ChainState] | None = field(
        default=None, metadata={"check": _check_start}
    )
    workers: int | None = 1
    cases: tuple[Case, ...] = field(init=False)

    def __post_init__(self) -> None:
        for name, value in vars(self).copy().items():
            if is_sequence(value) and not isinstance(value, np.ndarray | Grid):
                object.__setattr__(self, name, list(value))  # it may be an iterator
        object.__setattr__(self, "workers", _workers(self.workers))
        cases = _cases(*_rows(self))
        object.__setattr__(self, "cases", cases)
        _warn_of_repeats(cases)

    @property
    def alone(self) -> bool:
        """Whether it is one run of one chain, not a sequence or a grid."""
        several = any(_is_several(name, getattr(self, name)) for name in _CHECKS)
        return isinstance(self.chains, ChainParameters) and not several

    def __repr__(self) -> str:
        many = "" if len(self.cases) == 1 else f", one of {len(self.cases)}"
        return f"Setup({self.cases[0].parameters.describe()}, {self.cases[0].method}{many})"


Chains: TypeAlias = ChainParameters | Sequence[ChainParameters] | Grid | Setup
_CHECKS: dict[str, Callable[[str, Any], Any]] = {
    keyword.name: keyword.metadata["check"]
    for keyword in fields(Setup)
    if "check" in keyword.metadata
}


def with_setup(function: F) -> F:
    """Decorate a function that takes the keywords of a setup beside its own."""
    return names.checked(function, also=(*_CHECKS, "workers"))


def setup_of(chains: Chains, keywords: Mapping[str, Any]) -> Setup:
    """The setup that a function is given, or that it makes of chains and keywords."""
    if not isinstance(chains, Setup):
        return Setup(chains, **keywords)
    if keywords:
        name = next(iter(keywords))
        raise InputError(
            f"{name}: not together with a Setup; dataclasses.replace(setup, {name}=...) has it"
        )
    return chains


def _workers(value: Any) -> int:
    """Cores to use: so many, or all that this process may."""
    if value is None:
        has_affinity = hasattr(os, "sched_getaffinity")
        return len(os.sched_getaffinity(0)) if has_affinity else os.cpu_count() or 1
    if checks.key("workers", value) < 1:
        raise InputError("workers = 0: at least 1 is needed, or None for all cores")
    return int(value)


def part_of(setup: Setup, place: slice) -> Setup:
    """Some of the chains of a setup."""
    values: dict[str, Any] = {name: getattr(setup, name) for name in ("chains", *_CHECKS)}
    if isinstance(setup.chains, Grid):
        values |= {"chains": setup.chains.chains, "replicate": setup.chains.replicate}
    several = [name for name, value in values.items() if _is_several(name, value)]
    return replace(setup, **{name: values[name][place] for name in several})


def columns(setup: Setup) -> dict[str, np.ndarray]:
    """What each chain is, how it is advanced and where it begins: arrays (P,) by name."""
    table = {name: _column(name, setup.cases) for name in QUANTITIES}
    for name in _MEANS:
        table[name] = [getattr(case, name) for case in setup.cases]
    for name in ("seed", "replicate"):
        table[name] = [getattr(case.state, name) for case in setup.cases]
    numbers = table | {"tolerance": np.array(table["tolerance"], float)}  # NaN for None
    return {name: np.array(values) for name, values in numbers.items()}


def _column(name: str, cases: Sequence[Case]) -> Any:
    """A quantity of P chains; where blocks differ in it (P, N), padded with NaN."""
    values = [getattr(case.parameters, name) for case in cases]
    if not any(isinstance(value, tuple) for value in values):
        return values
    most = max(case.parameters.n_blocks for case in cases)
    rows = np.full((len(cases), most), np.nan)
    for row, case in zip(rows, cases, strict=True):
        row[: case.parameters.n_blocks] = case.parameters.by_block(name)
    return rows


def check_lengths(duration: Any, transient: Any) -> tuple[float, float]:
    """Duration of a run, and the part of it that is left out of the results."""
    duration, transient = check_duration(duration), checks.finite_number("transient", transient)
    if not 0 <= transient < duration:
        raise InputError(
            f"transient = {transient:g}: must be at least 0 and less than duration = {duration:g}"
        )
    return duration, transient


def check_duration(duration: Any) -> float:
    """Duration of a run."""
    return checks.within("duration", duration, **LIMITS["duration"])


def _is_several(name: str, value: Any) -> bool:
    """Whether a quantity has a value for each chain, not one for all."""
    if name == "initial_positions" and is_sequence(value):  # an array is one value
        return is_sequence(next(iter(value), None))
    return is_sequence(value)


def for_each(name: str, value: Any, n_chains: int, check: Callable[[str, Any], T]) -> list[T]:
    """One checked value for each chain, from one for all or a sequence of them."""
    if not _is_several(name, value):
        return [check(name, value)] * n_chains
    values = list(value)
    if not values:
        raise InputError(f"{name} is empty: at least one value is needed")
    if len(values) != n_chains:
        raise InputError(
            f"{name} of length {len(values)}: one value for all chains is needed, "
            f"or one for each of {n_chains}"
        )
    return [check(name, item) for item in values]


def section_positions(
    positions: Any, cases: Sequence[Case], block: int | None = None
) -> np.ndarray:
    """Positions (P,) of a block's section, by the rule of the model if none are given."""
    if positions is None:
        return np.array([section_position(case.parameters, block) for case in cases])
    return np.array(for_each("section_position", positions, len(cases), checks.positive))


def _rows(setup: Setup) -> tuple[list[ChainParameters], dict[str, list]]:
    """The chains, and the checked values of each quantity, one for each chain."""
    values = {name: getattr(setup, name) for name in _CHECKS}
    if isinstance(setup.chains, Grid):
        if values["replicate"] is not None:
            raise InputError("replicate: not together with a Grid, which has replicates")
        chains, values["replicate"] = list(setup.chains.chains), setup.chains.replicate
    elif isinstance(setup.chains, ChainParameters):
        counts = [len(value) for name, value in values.items() if _is_several(name, value)]
        chains = [setup.chains] * (counts[0] if counts else 1)
    else:
        chains = list(setup.chains) if is_sequence(setup.chains) else []
        if not chains or not all(isinstance(chain, ChainParameters) for chain in chains):
            raise InputError(
                f"chains = {shown(setup.chains)}: "
                "a ChainParameters, or a sequence of at least one, a Grid or a Setup is needed"
            )
    return chains, {
        name: for_each(name, values[name], len(chains), check) for name, check in _CHECKS.items()
    }


def _cases(chains: Sequence[ChainParameters], values: dict[str, list]) -> tuple[Case, ...]:
    rows = [dict(zip(values, row, strict=True)) for row in zip(*values.values(), strict=True)]
    states: dict[int, ChainState] = {}
    for number, (chain, row) in enumerate(zip(chains, rows, strict=True)):
        _check_means(chain, row)
        if row["initial_state"] is not None:
            states[number] = _continued(chain, row)
    if begin := [number for number in range(len(rows)) if number not in states]:
        begun = _begun([chains[number] for number in begin], [rows[number] for number in begin])
        states |= zip(begin, begun, strict=True)
    means = [[row[name] for name in _MEANS] for row in rows]
    return tuple(Case(states[number], *values) for number, values in enumerate(means))


def _check_means(chain: ChainParameters, row: Mapping[str, Any]) -> None:
    """That a method can advance a chain as asked."""
    method, tolerance = row["method"], row["tolerance"]
    if tolerance is not None and method not in TOLERANCES:
        raise InputError(
            f"tolerance = {tolerance:g}: method {method!r} has none, only {', '.join(TOLERANCES)}"
        )
    if method == "event" and (text := noise_beyond_event(chain)):
        raise InputError(f"noise {text}")


def _continued(chain: ChainParameters, row: Mapping[str, Any]) -> ChainState:
    """The state given, as one of this chain and with this key."""
    if row["initial_positions"] is not None or row["initial_spread"] != 0:
        name = "initial_spread" if row["initial_positions"] is None else "initial_positions"
        raise InputError(f"{name}: not together with initial_state, see ChainState.moved")
    state = row["initial_state"].under(chain)
    steps = state.time / row["time_step"]
    if row["method"] == "verlet" and abs(steps - round(steps)) > _STEP_SHARE:
        raise InputError(
            f"initial_state at t = {state.time!r}: "
            f"method 'verlet' needs a multiple of time_step = {row['time_step']:g}"
        )
    return state.keyed(
        state.seed if row["seed"] is None else row["seed"],
        state.replicate if row["replicate"] is None else row["replicate"],
    )


def _begun(chains: Sequence[ChainParameters], rows: Sequence[dict[str, Any]]) -> list[ChainState]:
    """States with all blocks stuck."""
    seeds = [DEFAULT_SEED if row["seed"] is None else row["seed"] for row in rows]
    replicates = [row["replicate"] or 0 for row in rows]
    words = stream_states(chains, seeds, replicates, _INITIAL_POSITIONS).T.copy()
    starts = [_spread(*start) for start in zip(chains, rows, replicates, words, strict=True)]
    return states_at_rest(chains, starts, seeds, replicates)


class _Seeded(ISeedSequence):
    """A SeedSequence whose words were made before, for the numbers of `default_rng`."""

    def __init__(self, words: np.ndarray) -> None:
        self._words = words

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> np.ndarray:
        """The words."""
        return self._words


def _spread(
    chain: ChainParameters, row: Mapping[str, Any], replicate: int, words: np.ndarray
) -> np.ndarray | None:
    """Where the blocks of a replicate begin, None for undeformed springs."""
    positions, spread = row["initial_positions"], row["initial_spread"]
    if positions is not None:
        positions = checks.positions("initial_positions", positions, chain.n_blocks)
    if replicate == 0 or spread == 0:
        return positions
    seeded: Any = _Seeded(words)
    deviates = np.random.Generator(np.random.PCG64(seeded)).standard_normal(chain.n_blocks)
    positions = (chain.rest_positions if positions is None else positions) + spread * deviates
    if positions[0] <= 0 or np.any(positions[1:] <= positions[:-1]):
        raise InputError(
            f"initial_spread = {spread:g}: "
            f"blocks of replicate {replicate} would begin on the wrong side of each other"
        )
    return positions


def _warn_of_repeats(cases: Sequence[Case]) -> None:
    if len({case.parameters for case in cases}) == len(cases):
        return
    if repeated := len(cases) - len({case.identity for case in cases}):
        noise = any(case.parameters.noise > 0 for case in cases)
        advice = "" if noise else " and an initial_spread"
        warnings.warn(
            f"{repeated} of {len(cases)} chains repeat another bit by bit; for runs that differ "
            f"give them other replicates: replicate=range({len(cases)}){advice}",
            stacklevel=caller(),
        )


def caller() -> int:
    """How many calls above is the one from outside this package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == "beltrepro":
        frame, level = frame.f_back, level + 1
    return level
