"""What a call is told of its chains, as one value that is made and checked once."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property, partial
from inspect import Parameter, cleandoc, signature
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names, provenance
from beltrepro.base.checks import is_sequence, listed, shown
from beltrepro.base.errors import InputError, warn
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.noise import stream_key
from beltrepro.engine.state import ChainState, states_at_rest
from beltrepro.engine.verlet_integrator import VerletIntegrator, longest_step
from beltrepro.model import ChainParameters, section_position
from beltrepro.model.friction import noise_beyond_event
from beltrepro.model.parameters import LIMITS
from beltrepro.simulation.grid import QUANTITIES, Grid

provenance.code_version()  # noted as the code is loaded: another may be checked out later
T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])
PerChain: TypeAlias = T | Sequence[T]
"""One value for all chains, or one for each."""
Check: TypeAlias = Callable[[str, Any], Any]

METHODS = {"verlet": VerletIntegrator, "event": EventIntegrator}
# Of a step, unless told otherwise; "verlet" has none.
TOLERANCES: dict[str, float] = {"event": signature(EventIntegrator).parameters["tolerance"].default}
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
    def numerics(self) -> dict[str, float]:
        """What the integrator is told of its steps."""
        steps = {"time_step": self.time_step}
        if self.tolerance is not None:  # as asked, noise or not
            steps |= {"tolerance": self.tolerance, "noise_share": 0.0}
        return steps

    @property
    def identity(self) -> tuple:
        """What decides all numbers of a run: cases that agree in it give the same run."""
        state = self.state
        arrays = [state.displacements, state.relative_velocities, state.directions]
        if self.parameters.noise > 0:
            arrays += [state.thresholds, state.stream]
        return self.parameters, self.kind, *(array.tobytes() for array in arrays)

    @property
    def key(self) -> str:
        """A digest of that and of what runs of equal numbers may differ in: replicate, audit."""
        state, scheme = self.state, self.state.scheme
        values = [value for name, value in vars(state).items() if name != "scheme"]
        values += [self.method, self.time_step, self.tolerance]
        if scheme:
            values += [scheme.integrator, scheme.time_step]
            values += map(np.asarray, scheme.variables.values())
        digest = hashlib.sha256()
        for value in values:
            is_array = isinstance(value, np.ndarray)
            digest.update(value.tobytes() if is_array else f"{value!r};".encode())
        return digest.hexdigest()[:16]


def _optional(check: Check) -> Check:
    """A check that lets None pass."""
    return lambda name, value: None if value is None else check(name, value)


def _state(name: str, value: Any) -> ChainState:
    if not isinstance(value, ChainState):
        raise InputError(f"{name} = {shown(value)}: a ChainState is needed")
    return value


check_tolerance = _optional(partial(checks.within, **LIMITS["tolerance"]))
_CHECKS: dict[str, Check] = {
    "method": partial(names.one_of, allowed=METHODS),
    "time_step": partial(checks.within, **LIMITS["time_step"]),
    "tolerance": check_tolerance,
    "seed": _optional(checks.key),
    "replicate": _optional(checks.key),
    "initial_positions": _optional(checks.series),
    "initial_spread": partial(checks.within, **LIMITS["initial_spread"]),
    "initial_state": _optional(_state),
}
"""Of the quantities of which each chain may have its own."""


@names.checked
@dataclass(frozen=True, eq=False, repr=False)
class Setup:
    """Chains, by what means they are advanced, and where they begin.

    All functions take one, or its chains and keywords: `simulate(Setup(chain, method="verlet"),
    duration=100)` is `simulate(chain, method="verlet", duration=100)`. One chain with a sequence is
    simulated once for each value in it: `Setup(chain, replicate=range(200))` are 200 runs of it.

    Attributes
    ----------
    chains : ChainParameters, sequence of them, or Grid
        The chains, which may differ in everything.
    method : str
        "event", the exact dynamics (docs/integrators.md), or "verlet", the scheme of the Appendix.
        This and what follows, up to `workers`, is one value for all chains, or a sequence with one
        for each.
    time_step : float
        dt, model time, at most 0.1; for "event" it only sets the strength of the noise.
    tolerance : float or None
        Only for "event": last terms of the series of a force allowed at the end of a step, 1e-16 to
        1, in the unit of force, or in the static friction where that is less. None for the method's
        own, which is larger with noise (docs/integrators.md).
    seed, replicate : int or None
        Of 0 or greater; with the parameters they fix all random numbers. If not given, 1 and 0, or
        those of `initial_state`, whose random stream then goes on. A Grid has its own replicates.
    initial_positions : array (N,), or one for each chain, or None
        Of the blocks at t = 0, all stuck, model length; undeformed springs if not given.
    initial_spread : float
        Standard deviation of normal deviates that are added to the initial positions of replicates
        other than 0, model length.
    initial_state : ChainState or None
        Where to go on, for instance `final_state` of a run; time goes on from that of the state.
        The chain may have another belt velocity, noise or law than that of the state
        (`ChainState.under`), and another method may go on.
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
    method: PerChain[str] = "event"
    time_step: PerChain[float] = 0.001
    tolerance: PerChain[float | None] = None
    seed: PerChain[int] | None = None
    replicate: PerChain[int] | None = None
    initial_positions: ArrayLike | Sequence[ArrayLike] | None = None
    initial_spread: PerChain[float] = 0.0
    initial_state: PerChain[ChainState] | None = None
    workers: int | None = 1
    cases: tuple[Case, ...] = field(init=False)

    def __post_init__(self) -> None:
        for name, value in vars(self).copy().items():
            if is_sequence(value) and not isinstance(value, Grid):
                object.__setattr__(self, name, listed(name, value))  # it may be an iterator
        object.__setattr__(self, "workers", _cores(self.workers))
        object.__setattr__(self, "cases", _cases(self))
        _warn_of_repeats(self)

    @property
    def alone(self) -> bool:
        """Whether it is one run of one chain, not a sequence or a grid."""
        return isinstance(self.chains, ChainParameters) and not _several(self)

    def __repr__(self) -> str:
        many = "" if len(self.cases) == 1 else f", one of {len(self.cases)}"
        return f"Setup({self.cases[0].parameters.describe()}, {self.cases[0].method}{many})"


Chains: TypeAlias = ChainParameters | Sequence[ChainParameters] | Grid | Setup


_KEYWORDS = list(signature(Setup).parameters.values())[1:]
_TEXT = cleandoc(Setup.__doc__ or "").partition("\nmethod : ")[2].partition("cases : ")[0]


def with_setup(function: F, more: Sequence[str] = ()) -> F:
    """Decorate a function that takes the keywords of a setup beside its own, and show them.

    more : keywords that it takes with them, None if not given.
    """
    called: Any = names.checked(function, also=(*more, *_CHECKS, "workers"))
    shown = signature(function)
    added = [Parameter(name, Parameter.KEYWORD_ONLY, default=None) for name in more]
    # in place of **setup
    keywords = [*shown.parameters.values()][:-1] + added + _KEYWORDS
    called.__signature__ = shown.replace(parameters=keywords)
    text = re.sub(r", \*\*setup( : callable).*", r"\1", cleandoc(function.__doc__ or ""))
    called.__doc__ = text.replace("\n\nReturns\n", f"\nmethod : {_TEXT}\nReturns\n")
    return called


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


def with_value(chains: Any, quantity: str, value: Any) -> Any:
    """Chains, or a setup of some, with another value of a quantity in each of them."""
    if isinstance(chains, Setup):
        return replace(chains, chains=with_value(chains.chains, quantity, value))
    if isinstance(chains, Grid):
        if len({getattr(chain, quantity) for chain in chains.chains}) > 1:
            raise InputError(f"{quantity}: not together with a Grid of several values of it")
        axis: Any = {quantity: [value]}
        return replace(chains, **axis)
    if is_sequence(chains):
        return [with_value(chain, quantity, value) for chain in listed("chains", chains)]
    if isinstance(chains, ChainParameters):
        return replace(chains, **{quantity: value})
    return chains  # a setup says what is wrong


def columns(setup: Setup) -> dict[str, np.ndarray]:
    """What each chain is, how it is advanced and where it begins: arrays (P,) by name."""
    cases = setup.cases
    table = {name: _quantity(name, [case.parameters for case in cases]) for name in QUANTITIES}
    table |= {name: np.array([getattr(case, name) for case in cases]) for name in _MEANS}
    tolerances = [case.tolerance or TOLERANCES.get(case.method, np.nan) for case in cases]
    table["tolerance"] = np.array(tolerances)  # as a Run has it; NaN where the method has none
    for name in ("seed", "replicate"):
        table[name] = np.array([getattr(case.state, name) for case in cases])
    return table


def _quantity(name: str, chains: Sequence[ChainParameters]) -> np.ndarray:
    """A quantity of P chains; where blocks differ in it (P, N), padded with NaN."""
    values = [getattr(chain, name) for chain in chains]
    if not any(isinstance(value, tuple) for value in values):
        return np.array(values)
    rows = np.full((len(chains), max(chain.n_blocks for chain in chains)), np.nan)
    for row, chain in zip(rows, chains, strict=True):
        row[: chain.n_blocks] = chain.by_block(name)
    return rows


def check_duration(duration: Any) -> float:
    """Duration of a run."""
    return checks.within("duration", duration, **LIMITS["duration"])


def check_lengths(duration: Any, transient: Any) -> tuple[float, float]:
    """Duration of a run, and the part of it that is left out of the results."""
    duration, transient = check_duration(duration), checks.finite_number("transient", transient)
    if not 0 <= transient < duration:
        raise InputError(
            f"transient = {transient:g}: must be at least 0 and less than duration = {duration:g}"
        )
    return duration, transient


def section_positions(
    positions: Any, cases: Sequence[Case], block: int | None = None
) -> np.ndarray:
    """Positions (P,) of a block's section, by the rule of the model if none are given."""
    if positions is None:
        return np.array([section_position(case.parameters, block) for case in cases])
    return np.array(_for_each("section_position", positions, len(cases), checks.positive))


def _several(setup: Setup) -> dict[str, Any]:
    """The quantities that have a value for each chain, not one for all."""
    values = {name: getattr(setup, name) for name in _CHECKS}
    return {name: value for name, value in values.items() if _is_several(name, value)}


def _is_several(name: str, value: Any) -> bool:
    if name == "initial_positions" and is_sequence(value):  # an array is one value
        return is_sequence(next(iter(value), None))
    return is_sequence(value)


def _for_each(name: str, value: Any, n_chains: int, check: Check) -> list:
    """One checked value for each chain, from one for all or a sequence of them."""
    if not _is_several(name, value):
        return [check(name, value)] * n_chains
    values = listed(name, value)
    if not values:
        raise InputError(f"{name} is empty: at least one value is needed")
    if len(values) != n_chains:
        raise InputError(
            f"{name} of length {len(values)}: one value for all chains is needed, "
            f"or one for each of {n_chains}"
        )
    return [check(name, item) for item in values]


def _cores(workers: Any) -> int:
    """Cores to use: so many, or all that this process may."""
    if workers is None:
        has_affinity = hasattr(os, "sched_getaffinity")
        return len(os.sched_getaffinity(0)) if has_affinity else os.cpu_count() or 1
    if checks.key("workers", workers) < 1:
        raise InputError("workers = 0: at least 1 is needed, or None for all cores")
    return int(workers)


def _cases(setup: Setup) -> tuple[Case, ...]:
    """The state of each chain, and how it is advanced."""
    rows = _rows(setup)
    begun = iter(_begun([row for row in rows if row["initial_state"] is None]))
    states = [next(begun) if row["initial_state"] is None else _continued(row) for row in rows]
    means = [[row[name] for name in _MEANS] for row in rows]
    return tuple(Case(state, *values) for state, values in zip(states, means, strict=True))


def _rows(setup: Setup) -> list[dict[str, Any]]:
    """For each chain its checked quantities by name, and itself as "chain"."""
    values = {name: getattr(setup, name) for name in _CHECKS}
    if isinstance(setup.chains, Grid):
        if setup.replicate is not None:
            raise InputError("replicate: not together with a Grid, which has replicates")
        chains, values["replicate"] = setup.chains.chains, setup.chains.replicate
    elif isinstance(setup.chains, ChainParameters):
        counts = [len(value) for value in _several(setup).values()]
        chains = (setup.chains,) * (counts[0] if counts else 1)
    else:
        chains = tuple(setup.chains) if is_sequence(setup.chains) else ()
        if not chains or not all(isinstance(chain, ChainParameters) for chain in chains):
            raise InputError(
                f"chains = {shown(setup.chains)}: "
                "a ChainParameters, or a sequence of at least one, a Grid or a Setup is needed"
            )
    lists = [_for_each(name, values[name], len(chains), _CHECKS[name]) for name in values]
    rows = [
        dict(zip(("chain", *values), row, strict=True)) for row in zip(chains, *lists, strict=True)
    ]
    for row in rows:
        _check_means(row)
    return rows


def _check_means(row: dict[str, Any]) -> None:
    """That the method can advance the chain as asked."""
    method, tolerance, chain = row["method"], row["tolerance"], row["chain"]
    if tolerance is not None and method not in TOLERANCES:
        raise InputError(
            f"tolerance = {tolerance:g}: method {method!r} has none, only {', '.join(TOLERANCES)}"
        )
    if method == "event" and (text := noise_beyond_event(chain)):
        raise InputError(f"noise {text}")
    # of the paper's law it is 0.1, as long as a step may be
    most = longest_step(chain) if method == "verlet" and chain.varied else np.inf
    if row["time_step"] > (1 + _STEP_SHARE) * most:
        raise InputError(
            f"time_step = {row['time_step']:g}: for blocks so light, springs so stiff or friction "
            f"so viscous ({chain.describe()}) 'verlet' needs {checks.rounded(most, up=False)} or "
            "less; or take 'event'"
        )


def _continued(row: dict[str, Any]) -> ChainState:
    """The state given, as one of this chain and with this key."""
    if row["initial_positions"] is not None or row["initial_spread"] != 0:
        name = "initial_spread" if row["initial_positions"] is None else "initial_positions"
        raise InputError(f"{name}: not together with initial_state, see ChainState.moved")
    state = row["initial_state"].under(row["chain"])
    check_steps("initial_state", state.time, row["method"], row["time_step"])
    key = {name: row[name] for name in ("seed", "replicate") if row[name] is not None}
    return state.keyed(**{"seed": state.seed, "replicate": state.replicate} | key)


def check_steps(name: str, time: float, method: str, time_step: float) -> None:
    """That chains of a method can be at an instant."""
    steps = time / time_step
    if method == "verlet" and abs(steps - round(steps)) > _STEP_SHARE:
        needed = f"method 'verlet' needs a multiple of time_step = {time_step:g}"
        raise InputError(f"{name} at t = {time!r}: {needed}")


def _begun(rows: Sequence[dict[str, Any]]) -> list[ChainState]:
    """States with all blocks stuck."""
    chains = [row["chain"] for row in rows]
    seeds = [1 if row["seed"] is None else row["seed"] for row in rows]
    replicates = [row["replicate"] or 0 for row in rows]
    starts = [_start(*keyed) for keyed in zip(rows, seeds, replicates, strict=True)]
    return states_at_rest(chains, starts, seeds, replicates)


def _start(row: dict[str, Any], seed: int, replicate: int) -> np.ndarray | None:
    """Where the blocks of a replicate begin, None for undeformed springs."""
    chain, positions, spread = row["chain"], row["initial_positions"], row["initial_spread"]
    if positions is not None:
        positions = checks.positions("initial_positions", positions, chain.n_blocks)
    if replicate == 0 or spread == 0:
        return positions
    random = np.random.default_rng(stream_key(chain, seed, replicate, _INITIAL_POSITIONS))
    deviates = random.standard_normal(chain.n_blocks)
    positions = (chain.rest_positions if positions is None else positions) + spread * deviates
    if positions[0] <= 0 or np.any(positions[1:] <= positions[:-1]):
        raise InputError(
            f"initial_spread = {spread:g}: "
            f"blocks of replicate {replicate} would begin on the wrong side of each other"
        )
    return positions


def _warn_of_repeats(setup: Setup) -> None:
    cases = setup.cases
    if len({case.parameters for case in cases}) == len(cases):
        return
    firsts: dict[tuple, Case] = {}
    pairs = [(firsts.setdefault(case.identity, case), case) for case in cases]
    repeats = [(one, other) for one, other in pairs if one is not other]
    if not repeats:
        return
    needed, is_grid = [], isinstance(setup.chains, Grid)
    twice = [one.state.replicate == other.state.replicate for one, other in repeats]
    if any(twice):
        needed.append("a Grid of each value once" if is_grid else f"replicate=range({len(cases)})")
    alike = [case for (_, case), same in zip(repeats, twice, strict=True) if not (is_grid and same)]
    if any(case.parameters.noise == case.initial_spread == 0 for case in alike):
        begun = setup.initial_state is None
        others = "other states, by ChainState.moved or ChainState.at_balance(replicate=...)"
        needed.append("an initial_spread" if begun else others)
    warn(
        f"{len(repeats)} of {len(cases)} chains repeat another bit by bit; runs that differ need "
        f"{' and '.join(needed)}"
    )
