"""The chains of a call as values, and which of them advance together."""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from beltrepro.engine.ensemble import LANES as GROUP_SIZE
from beltrepro.engine.ensemble import Section
from beltrepro.engine.noise import stream_key
from beltrepro.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.simulation import checks
from beltrepro.simulation.methods import METHODS

Progress = Callable[[float], None]

_INITIAL_STATE = 1  # purpose of a random stream: initial positions, not friction


@dataclass(frozen=True)
class Point:
    """One chain to simulate: its parameters, by what means, from where.

    tolerance : as asked for; None for the method's own. initial_positions : (N,), all blocks stuck.
    """

    parameters: ChainParameters
    method: str
    time_step: float
    tolerance: float | None
    seed: int
    replicate: int
    initial_positions: np.ndarray

    @property
    def kind(self) -> tuple:
        """What chains have in common that advance together.

        An integrator may treat chains without noise in another way, and what a chain does must not
        depend on the others.
        """
        chain = self.parameters
        numerics = self.method, self.time_step, self.tolerance
        return chain.n_blocks, chain.law, chain.noise > 0, *numerics, self.seed

    @property
    def identity(self) -> tuple:
        """What decides every number of a run: points that agree in it give the same run."""
        keys = (self.seed, self.replicate) if self.parameters.noise > 0 else ()
        return self.parameters, self.kind[:-1], keys, self.initial_positions.tobytes()


def points(
    parameters,
    *,
    method,
    time_step,
    tolerance,
    seed,
    replicate,
    initial_positions,
    initial_spread,
) -> list[Point]:
    """Check what a call is told about its chains; one point for each.

    Warns in one line when two of them are the same in all that decides their numbers.
    """
    single = isinstance(parameters, ChainParameters)
    chains = checks.chains_of(parameters)
    columns = {
        "method": (method, checks.method_name),
        "time_step": (time_step, checks.step),
        "tolerance": (tolerance, checks.tolerance),
        "seed": (seed, checks.key),
        "replicate": (replicate, checks.key),
    }
    checked = {
        name: checks.for_each(name, value, len(chains), check)
        for name, (value, check) in columns.items()
    }
    for each, asked in zip(checked["method"], checked["tolerance"], strict=True):
        checks.method_has_tolerance(each, asked)
    spreads = checks.for_each("initial_spread", initial_spread, len(chains), checks.not_negative)
    given = [initial_positions] if single and initial_positions is not None else initial_positions
    rows = [
        dict(zip(checked, values, strict=True)) for values in zip(*checked.values(), strict=True)
    ]
    starts = _given_positions(chains, given)
    found = [
        Point(chain, **row, initial_positions=_perturbed(chain, start, row, spread))
        for chain, row, start, spread in zip(chains, rows, starts, spreads, strict=True)
    ]
    _warn_of_repeats(found)
    return found


def _given_positions(chains, given) -> list[np.ndarray]:
    """Positions (N,) of the blocks of each chain: undeformed springs if none are given."""
    if given is None:
        return [chain.rest_positions for chain in chains]
    try:
        starts = list(given)
    except TypeError:
        starts = [given]
    if len(starts) != len(chains):
        raise InputError(
            f"initial_positions of length {len(starts)}: one array for each of {len(chains)} "
            "chains is needed"
        )
    return [
        checks.positions("initial_positions", start, chain.n_blocks)
        for chain, start in zip(chains, starts, strict=True)
    ]


def _perturbed(chain, positions, row, spread) -> np.ndarray:
    """The positions, for replicates other than 0 with normal deviates of standard deviation spread.

    The deviates follow from chain, seed and replicate.
    """
    if row["replicate"] == 0 or spread == 0:
        return positions
    key = stream_key(chain, row["seed"], row["replicate"], _INITIAL_STATE)
    deviates = np.random.default_rng(key).standard_normal(chain.n_blocks)
    moved = positions + spread * deviates
    if not np.all(np.diff(moved, prepend=0.0) > 0):
        raise InputError(
            f"initial_spread = {spread:g}: blocks of replicate {row['replicate']} "
            "would begin on the wrong side of each other"
        )
    return moved


def _warn_of_repeats(found: Sequence[Point]) -> None:
    repeated = len(found) - len({point.identity for point in found})
    if repeated:
        noise = any(point.parameters.noise > 0 for point in found)
        advice = "" if noise else " and initial_spread > 0"
        warnings.warn(
            f"{repeated} of {len(found)} chains repeat another bit by bit; runs that differ need "
            f"another seed or replicate, for instance replicate=range({len(found)}){advice}",
            stacklevel=4,
        )


def groups(
    points: Sequence[Point], progress: Progress | None
) -> Iterator[tuple[np.ndarray, Progress]]:
    """Indices of the points that advance together, at most GROUP_SIZE, and how to report.

    progress : called with the fraction done of all groups, or None.
    """
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
    sample_stride: int,
    sampled_blocks: int,
    section: Section | None = None,
):
    """The integrator that advances a group of points."""
    first = members[0]
    accuracy = {}
    if first.tolerance is not None:
        accuracy = {"tolerance": first.tolerance, "noise_share": 0.0}  # as asked, noise or not
    return METHODS[first.method](
        [point.parameters for point in members],
        seed=first.seed,
        replicates=[point.replicate for point in members],
        initial_positions=np.array([point.initial_positions for point in members]),
        time_step=first.time_step,
        sample_stride=sample_stride,
        sampled_blocks=sampled_blocks,
        section=section,
        **accuracy,
    )


def observe(integrator, duration: float, observers: Sequence, report: Progress) -> None:
    """Advance a group to the end, and show every chunk of it to the observers."""
    for chunk in integrator.advance(duration):
        for observer in observers:
            observer.observe(chunk)
        report(chunk.end / duration)
