"""The chains of a call as values, and which of them advance together."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import CUT_TIME, GROUP_SIZE, Integrator, Sampling, Section
from beltrepro.engine.kicks import KickedIntegrator
from beltrepro.engine.noise import stream_key
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.simulation import arguments, checkpoints
from beltrepro.simulation.methods import METHODS

Progress = Callable[[float], None]

DEFAULT_SEED = 1
_INITIAL_POSITIONS = 1  # purpose of a random stream: initial positions, not friction


@dataclass(frozen=True, eq=False)
class Point:
    """One chain to simulate: from which state, by what means.

    tolerance : as asked for; None for the method's own.
    kick : standard deviation of the move of a block that starts to slip, model length.
    """

    state: ChainState
    method: str
    time_step: float
    tolerance: float | None
    kick: float = 0.0

    @property
    def parameters(self) -> ChainParameters:
        """The chain."""
        return self.state.parameters

    @property
    def kind(self) -> tuple:
        """What chains have in common that advance together.

        An integrator may treat chains without noise in another way, and what a chain does must not
        depend on the others.
        """
        chain = self.parameters
        numerics = self.method, self.time_step, self.tolerance, self.kick > 0
        return chain.n_blocks, chain.law, chain.noise > 0, self.state.time, *numerics

    @property
    def accuracy(self) -> dict[str, float]:
        """What the integrator is told about its accuracy."""
        if self.tolerance is None:
            return {}
        return {"tolerance": self.tolerance, "noise_share": 0.0}  # as asked, noise or not

    @property
    def identity(self) -> tuple:
        """What decides all numbers of a run: points that agree in it give the same run."""
        state = self.state
        arrays = [state.displacements, state.relative_velocities, state.directions]
        if self.parameters.noise > 0:
            arrays += [state.thresholds]
        if self.parameters.noise > 0 or self.kick > 0:
            arrays += [state.stream]
        return self.parameters, self.kind, self.kick, *(array.tobytes() for array in arrays)


def points(
    parameters: Any,
    *,
    method: Any,
    time_step: Any,
    tolerance: Any,
    seed: Any,
    replicate: Any,
    initial_positions: Any,
    initial_spread: Any,
    initial_state: Any,
    kick: Any = 0.0,
) -> list[Point]:
    """Check what a call is told about its chains; one point for each.

    Warns in one line when two of them are the same in all that decides their numbers.
    """
    chains = arguments.chains_of(parameters)
    if isinstance(parameters, ChainParameters) and initial_positions is not None:
        initial_positions = [initial_positions]
    columns = {
        "method": (method, arguments.method_name),
        "time_step": (time_step, arguments.step),
        "tolerance": (tolerance, arguments.tolerance),
        "seed": (seed, arguments.optional_key),
        "replicate": (replicate, arguments.optional_key),
        "initial_spread": (initial_spread, checks.not_negative),
        "initial_state": (initial_state, arguments.optional_state),
        "kick": (kick, checks.not_negative),
    }
    checked: dict[str, list] = {
        name: arguments.for_each(name, value, len(chains), check)
        for name, (value, check) in columns.items()
    }
    checked["initial_positions"] = _positions(initial_positions, chains)
    rows = zip(chains, *checked.values(), strict=True)
    found = [_point(chain, **dict(zip(checked, row, strict=True))) for chain, *row in rows]
    _warn_of_repeats(found)
    return found


def _point(
    chain: ChainParameters,
    *,
    method: str,
    time_step: float,
    tolerance: float | None,
    kick: float,
    **start: Any,
) -> Point:
    arguments.method_has_tolerance(method, tolerance)
    arguments.method_has_kicks(method, kick)
    arguments.method_has_law(method, chain)
    if start["initial_state"] is None:
        state = _fresh_state(chain, **start)
    else:
        state = _later_state(chain, **start)
    if method == "verlet":
        arguments.whole_steps("initial_state at t", state.time, time_step)
    return Point(state, method, time_step, tolerance, kick)


def _fresh_state(
    chain: ChainParameters,
    *,
    seed: int | None,
    replicate: int | None,
    initial_positions: np.ndarray | None,
    initial_spread: float,
    initial_state: ChainState | None,
) -> ChainState:
    """All blocks stuck, at the positions given or with undeformed springs.

    Replicates other than 0 have normal deviates of standard deviation `initial_spread` added to
    them, which follow from chain, seed and replicate.
    """
    seed = DEFAULT_SEED if seed is None else seed
    replicate = replicate or 0
    positions = chain.rest_positions if initial_positions is None else initial_positions
    if replicate != 0 and initial_spread != 0:
        key = stream_key(chain, seed, replicate, _INITIAL_POSITIONS)
        deviates = np.random.default_rng(key).standard_normal(chain.n_blocks)
        positions = positions + initial_spread * deviates
        if not np.all(np.diff(positions, prepend=0.0) > 0):
            raise InputError(
                f"initial_spread = {initial_spread:g}: "
                f"blocks of replicate {replicate} would begin on the wrong side of each other"
            )
    return ChainState.at_rest(chain, positions, seed=seed, replicate=replicate)


def _later_state(
    chain: ChainParameters,
    *,
    seed: int | None,
    replicate: int | None,
    initial_positions: np.ndarray | None,
    initial_spread: float,
    initial_state: ChainState,
) -> ChainState:
    """The state given, as one of the chain; its random stream goes on unless told otherwise."""
    if initial_positions is not None or initial_spread != 0:
        name = "initial_spread" if initial_positions is None else "initial_positions"
        raise InputError(f"{name}: not together with initial_state, see ChainState.moved")
    state = initial_state.under(chain)
    return state.keyed(
        state.seed if seed is None else seed,
        state.replicate if replicate is None else replicate,
    )


def _positions(given: Any, chains: Sequence[ChainParameters]) -> list[np.ndarray | None]:
    """Positions (N,) of the blocks of each chain, or None."""
    if given is None:
        return [None] * len(chains)
    starts = list(given) if checks.is_sequence(given) else [given]
    if len(starts) != len(chains):
        raise InputError(
            f"initial_positions of length {len(starts)}: "
            f"one array for each of {len(chains)} chains is needed"
        )
    return [
        checks.positions("initial_positions", start, chain.n_blocks)
        for chain, start in zip(chains, starts, strict=True)
    ]


def _warn_of_repeats(found: Sequence[Point]) -> None:
    repeated = len(found) - len({point.identity for point in found})
    if repeated:
        noise = any(point.parameters.noise > 0 or point.kick > 0 for point in found)
        advice = "" if noise else " and an initial_spread"
        warnings.warn(
            f"{repeated} of {len(found)} chains repeat another bit by bit; for runs that differ "
            f"give them other replicates: replicate=range({len(found)}){advice}",
            stacklevel=5,  # past the check of names around the public function
        )


def groups(
    points: Sequence[Point], progress: Progress | None
) -> Iterator[tuple[np.ndarray, Progress]]:
    """Indices of the points that advance together, at most GROUP_SIZE, and how to report.

    progress : called with the fraction done of all groups, or None.
    """
    arguments.progress(progress)
    alike: dict = {}
    for index, point in enumerate(points):
        alike.setdefault(point.kind, []).append(index)
    found = [
        np.array(members[first : first + GROUP_SIZE])
        for members in alike.values()
        for first in range(0, len(members), GROUP_SIZE)
    ]
    sizes = [points[group[0]].parameters.n_blocks * len(group) for group in found]
    before = np.concatenate([[0.0], np.cumsum(sizes)]) / sum(sizes)
    for number, group in enumerate(found):

        def report(fraction, low=before[number], high=before[number + 1]):
            if progress is not None:
                progress(low + (high - low) * fraction)

        yield group, report


def integrator_of(
    members: Sequence[Point],
    *,
    sampling: Sampling,
    sampled_blocks: int,
    section: Section | None = None,
) -> Integrator:
    """The integrator that advances a group of points."""
    first = members[0]
    settings: dict[str, Any] = {
        "time_step": first.time_step,
        "sampling": sampling,
        "sampled_blocks": sampled_blocks,
        "section": section,
        **first.accuracy,
    }
    states = [point.state for point in members]
    if first.kick > 0:
        return KickedIntegrator(states, sizes=[point.kick for point in members], **settings)
    return METHODS[first.method](states, **settings)


def observe(
    integrator: Integrator,
    duration: float,
    observers: Sequence,
    report: Progress,
    *,
    kept: bool = True,
) -> None:
    """Advance a group by `duration`, and show every chunk of it to the observers.

    kept : whether a checkpoint keeps how far it is, at instants where a cut changes no bit.
    """
    start = integrator.time
    with checkpoints.step(kept) as step:
        if step.kept is not None:
            states, seen = step.kept
            integrator.reinit(states)
            checkpoints.restore(observers, seen)
        for chunk in integrator.advance(start + duration):
            for observer in observers:
                observer.observe(chunk)
            report((chunk.end - start) / duration)
            if step.due and chunk.end % CUT_TIME == 0:
                step.keep((integrator.state(), observers))
        step.end(lambda: (integrator.state(), observers))


def slipping_since(members: Sequence[Point]) -> np.ndarray:
    """When the slip of the last block (W,) began that goes on in the initial states, if it does.

    That of the state, since no more is known; NaN for a stuck block.
    """
    return np.array(
        [point.state.time if point.state.directions[-1] else np.nan for point in members]
    )
