"""Cases that advance together, and what is measured of each group put into one table."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np

from beltrepro.base.checks import shown
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import CUT_TIME, GROUP_SIZE, Integrator, Sampling, Section
from beltrepro.engine.kicks import KickedIntegrator
from beltrepro.simulation import checkpoints
from beltrepro.simulation.sampling import for_moments
from beltrepro.simulation.setup import METHODS, Case

# By the method of the cases, or what kicked ones take. As a table, so that the code behind a job of
# the workflow is that of its own integrator.
INTEGRATORS: dict[str, Any] = {
    "verlet": METHODS["verlet"],
    "event": METHODS["event"],
    "kicked": KickedIntegrator,
}

Report: TypeAlias = Callable[[float], None]
"""Called with the fraction done."""


def check_progress(progress: Any) -> None:
    """That a report of progress can be called."""
    if progress is not None and not callable(progress):
        raise InputError(f"progress = {shown(progress)}: a function of the fraction done is needed")


def groups(cases: Sequence[Case], progress: Report | None) -> Iterator[tuple[np.ndarray, Report]]:
    """Indices of the cases that advance together, at most GROUP_SIZE, and how to report."""
    check_progress(progress)
    alike: dict = {}
    for index, case in enumerate(cases):
        alike.setdefault(case.kind, []).append(index)
    batches = [
        np.array(members[first : first + GROUP_SIZE])
        for members in alike.values()
        for first in range(0, len(members), GROUP_SIZE)
    ]
    sizes = [cases[group[0]].parameters.n_blocks * len(group) for group in batches]
    before = np.concatenate([[0.0], np.cumsum(sizes)]) / sum(sizes)
    for number, group in enumerate(batches):

        def report(fraction, low=before[number], high=before[number + 1]):
            if progress is not None:
                progress(low + (high - low) * fraction)

        yield group, report


def integrator_of(
    members: Sequence[Case],
    *,
    sampling: Sampling | None = None,
    sampled_blocks: int = 1,
    section: Section | None = None,
) -> Integrator:
    """The integrator that advances a group; it samples the last block for r unless told more."""
    first = members[0]
    settings: dict[str, Any] = {
        "time_step": first.time_step,
        "sampling": sampling or for_moments(members),
        "sampled_blocks": sampled_blocks,
        "section": section,
        **first.accuracy,
    }
    states = [case.state for case in members]
    if first.kick > 0:
        settings["sizes"] = [case.kick for case in members]
    return INTEGRATORS["kicked" if first.kick > 0 else first.method](states, **settings)


def observe(
    integrator: Integrator,
    duration: float,
    observers: Sequence,
    report: Report,
    *,
    kept: bool = True,
) -> None:
    """Advance a group by `duration`, and show every chunk of it to the observers."""
    # a checkpoint keeps how far it is at instants where a cut changes no bit
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


def slipping_since(members: Sequence[Case]) -> np.ndarray:
    """When the slip of the last block (W,) began with which the cases begin; NaN if it is stuck."""
    # that of the state, since no more is known
    return np.array([case.state.time if case.state.directions[-1] else np.nan for case in members])
