"""Groups of cases that advance together, on several cores."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias, TypeVar

import numpy as np

from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError, ModelStateError, warn
from beltrepro.base.threads import in_threads
from beltrepro.engine.integrator import GROUP_SIZE, Integrator, Sampling, Section
from beltrepro.model import ChainParameters
from beltrepro.model.energy import times_as_fast
from beltrepro.observe.length import LengthMoments
from beltrepro.simulation.setup import METHODS, Case

Report: TypeAlias = Callable[[float], None]
"""Called with the fraction done."""
T = TypeVar("T")
Part: TypeAlias = tuple[np.ndarray, T | ModelStateError]
"""Numbers of some chains and what is made of them; or the number of one and why nothing is."""

ON_ERROR = ("raise", "nan")
_GROUPS_EACH = 2  # groups for each core, at least: they take different times
_VECTOR = 8  # chains that an integrator advances in about the time of one
MOMENTS_INTERVAL = 0.1  # that of the chain of the paper, in which oscillations take 3
_FEWEST = 10  # samples for r and <x_N>


@dataclass(frozen=True)
class Group:
    """Cases of one `kind`, which advance together."""

    cases: list[Case]
    indices: np.ndarray  # which of all they are
    report: Report

    @property
    def chain(self) -> ChainParameters:
        """The first chain, whose size and law all have."""
        return self.cases[0].parameters

    @property
    def start(self) -> float:
        """Instant at which they begin."""
        return self.cases[0].state.time


def check_progress(progress: Any) -> None:
    """That a report of progress can be called."""
    if progress is not None and not callable(progress):
        raise InputError(f"progress = {shown(progress)}: a function of the fraction done is needed")


def in_groups(
    cases: Sequence[Case],
    work: Callable[[Group], T],
    progress: Report | None,
    *,
    workers: int | None = 1,
    skipped: Collection[int] = (),
) -> list[tuple[np.ndarray, T]]:
    """The indices of the cases of each group, and what is made of it; some may be skipped."""
    check_progress(progress)
    workers = workers or 1
    groups = _groups(cases, workers, skipped)
    sizes = np.array([len(group) * cases[group[0]].parameters.n_blocks for group in groups])
    done = np.zeros(len(groups))
    shown = 0.0

    def show() -> None:
        nonlocal shown
        fraction = min(float(sizes @ done / sizes.sum()), 1.0) if groups else 1.0
        if progress is not None and fraction > shown:
            shown = fraction
            progress(fraction)

    def made(number: int, notify: Callable[[], None]) -> T:
        def report(fraction: float) -> None:
            done[number] = fraction
            notify()

        indices = groups[number]
        return work(Group([cases[index] for index in indices], indices, report))

    if workers == 1 or len(groups) <= 1:
        outcomes = [made(number, show) for number in range(len(groups))]
    else:
        outcomes = in_threads(made, np.argsort(-sizes, kind="stable"), show, workers)
    done[:] = 1.0
    show()
    return list(zip(groups, outcomes, strict=True))


def parts_of(work: Callable[[Group], T], on_error: str, group: Group) -> list[Part[T]]:
    """What is made of a group: one part, or where runs fail several, of each such run its error.

    No bit of a chain depends on its company: halves of a group go on without the one that fails.
    """
    try:
        return [(group.indices, work(group))]
    except ModelStateError as error:
        if on_error == "raise":
            raise
        if len(group.cases) == 1:
            return [(group.indices, error)]
    parts, middle = [], len(group.cases) // 2
    for begin, half in ((0.0, slice(middle)), (0.5, slice(middle, None))):
        report = partial(_report_from, begin, group.report)
        parts += parts_of(work, on_error, Group(group.cases[half], group.indices[half], report))
    return parts


def _report_from(begin: float, report: Report, fraction: float) -> None:
    report(begin + 0.5 * fraction)


def warn_of_failures(lines: Sequence[str], on_error: str) -> None:
    """Warn of chains that have failed, by the line of each; raise the first if all have."""
    failed = [line for line in lines if line]
    if failed and (on_error == "raise" or len(failed) == len(lines)):
        raise ModelStateError(failed[0])
    if failed:
        first = failed[0].partition(" at t = ")[0]
        warn(f"{len(failed)} of {len(lines)} chains have failed; the first is {first}")


def of_each(made: list[tuple[np.ndarray, list[T]]]) -> list[T]:
    """What was made of each case, in their order, from what was made of the groups."""
    outcomes = dict(pair for indices, parts in made for pair in zip(indices, parts, strict=True))
    return [outcomes[index] for index in range(len(outcomes))]


def _groups(cases: Sequence[Case], workers: int, skipped: Collection[int]) -> list[np.ndarray]:
    """Indices of the cases of each group: at most GROUP_SIZE, fewer where cores would idle."""
    alike: dict[tuple, list[int]] = {}
    for index, case in enumerate(cases):
        if index not in skipped:
            alike.setdefault(case.kind, []).append(index)
    size = GROUP_SIZE
    while True:
        groups = [
            np.array(members[first : first + size])
            for members in alike.values()
            for first in range(0, len(members), size)
        ]
        if workers == 1 or size <= _VECTOR or len(groups) >= _GROUPS_EACH * workers:
            return groups
        size //= 2


def integrator_of(
    members: Sequence[Case],
    *,
    sampling: Sampling | None = None,
    sampled_blocks: int = 1,
    section: Section | None = None,
) -> Integrator:
    """The integrator that advances a group; it samples the last block for r unless told more."""
    first = members[0]
    return METHODS[first.method](
        [case.state for case in members],
        sampling=sampling or for_moments(members),
        sampled_blocks=sampled_blocks,
        section=section,
        **first.numerics,
    )


def for_moments(members: Sequence[Case]) -> Sampling:
    """When a group takes samples of x_N for r alone."""
    time_step = members[0].time_step
    return Sampling(max(1, round(moments_interval(members[0]) / time_step)), time_step)


def moments_interval(case: Case) -> float:
    """Model time between samples of x_N for r, about: shorter where things are faster."""
    return MOMENTS_INTERVAL / times_as_fast(case.parameters)


def observe(integrator: Integrator, duration: float, observers: Sequence, report: Report) -> None:
    """Advance a group by `duration`, and show every chunk of it to the observers."""
    start = integrator.time
    for chunk in integrator.advance(start + duration):
        for observer in observers:
            observer.observe(chunk)
        report((chunk.end - start) / duration)
    if not integrator.time > start:
        raise InputError(f"duration = {duration:g}: too short for a step from t = {start:g} on")


def moments_of(moments: LengthMoments, chains: Integrator) -> dict[str, np.ndarray]:
    """Moments of the length (W,) of chains; r and <x_N> are NaN, warned, of too few samples."""
    lengths = moments.result(chains.parameters[0].rest_positions[-1])
    if moments.count < _FEWEST:
        warn(
            f"r and <x_N> are NaN: the {chains.time - moments.start:g} of model time over which "
            f"they are to be found hold {moments.count} samples, at least {_FEWEST} are needed"
        )
        lengths = {name: np.full_like(values, np.nan) for name, values in lengths.items()}
    return lengths
