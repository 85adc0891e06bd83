"""What is measured of each point of a scan, without keeping samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Section
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.model import section_position as section_rule
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.sections import SectionValues
from beltrepro.observe.slips import SlipActivity
from beltrepro.simulation import arguments
from beltrepro.simulation.arguments import PerChain
from beltrepro.simulation.checkpoints import once
from beltrepro.simulation.points import (
    Point,
    Progress,
    groups,
    integrator_of,
    observe,
    points,
    slipping_since,
)
from beltrepro.simulation.sampling import moments_of, sampling_of

MAXIMUM_BLOCKS = 10  # columns of slip_count
MOST_VALUES = 100_000  # of each point at the section: they are kept in memory


@names.checked
def scan(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    transient: float = 0.0,
    method: PerChain[str] = "verlet",
    time_step: PerChain[float] = 0.001,
    tolerance: PerChain[float | None] = None,
    seed: PerChain[int] | None = None,
    replicate: PerChain[int] | None = None,
    initial_positions: ArrayLike | Sequence[ArrayLike] | None = None,
    initial_spread: PerChain[float] = 0.0,
    initial_state: PerChain[ChainState] | None = None,
    section_position: PerChain[float] | None = None,
    section_values: int = 500,
    laminar_time: float = 200.0,
    progress: Progress | None = None,
) -> dict[str, np.ndarray]:
    """What Figs. 12 to 22 show of a point (N, u, sigma), for P points.

    Parameters
    ----------
    parameters : ChainParameters or sequence of them
        P chains of at most 10 blocks, of any mixture of sizes.
    duration, transient : float
        As in `simulate`, also where too few samples are left for r.
    method : str or sequence of str
        As in `simulate`.
    time_step, tolerance : float or sequence of float
        As in `simulate`.
    seed, replicate : int or sequence of int
        As in `simulate`.
    initial_positions : array or sequence of arrays
        As in `simulate`.
    initial_spread : float or sequence of float
        As in `simulate`.
    initial_state : ChainState or sequence of them
        As in `simulate`.
    section_position : float, or a sequence of P
        x_N of the section, model length (Fig. 12: 615). If not given, by the rule
        `beltrepro.model.section_position`.
    section_values : int
        Crossings of the section kept for each point, at most 100 000.
    laminar_time : float
        Shortest slip of the last block that counts as a laminar phase, model time.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    dict of arrays with first axis P
        n_blocks, belt_velocity, noise, replicate; mean_length, disorder_parameter (Eq. 4),
        minimum_length, maximum_length; energy_residual; section_position, section_count (all
        downward crossings of x_N after the transient), section_velocity (P, section_values) v_N at
        the first of them, NaN padded; slip_count (P, 10); laminar_fraction, laminar_count,
        laminar_mean, laminar_longest; last_stick_time of the last block, NaN if it never stuck.
        Model units, laboratory frame.

    Raises
    ------
    InputError
        A value is not allowed.
    ModelStateError
        A state left the range of the model.
    """
    duration, transient = arguments.lengths(duration, transient)
    chains = points(
        parameters,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=seed,
        replicate=replicate,
        initial_positions=initial_positions,
        initial_spread=initial_spread,
        initial_state=initial_state,
    )
    sections = _section_positions(section_position, chains)
    recording: dict[str, Any] = {
        "section_values": _section_values(section_values),
        "laminar_time": checks.not_negative("laminar_time", laminar_time),
    }
    table: dict[str, np.ndarray] = {
        "n_blocks": np.array([point.parameters.n_blocks for point in chains]),
        "belt_velocity": np.array([point.parameters.belt_velocity for point in chains]),
        "noise": np.array([point.parameters.noise for point in chains]),
        "replicate": np.array([point.state.replicate for point in chains], dtype=np.int64),
        "section_position": sections,
    }
    for group, report in groups(chains, progress):
        members = [chains[index] for index in group]
        measured = once(
            _measure, members, sections[group], duration, transient, **recording, report=report
        )
        for name, values in measured.items():
            if name not in table:
                table[name] = np.empty((len(chains), *values.shape[1:]), dtype=values.dtype)
            table[name][group] = values
    return table


def _section_values(given: Any) -> int:
    """How many values at the section are kept."""
    count = checks.key("section_values", given)
    if count > MOST_VALUES:
        raise InputError(f"section_values = {count}: must be at most {MOST_VALUES}")
    return count


def _section_positions(given: Any, chains: Sequence[Point]) -> np.ndarray:
    """Positions (P,) of the section, by the rule of the model if none are given."""
    for point in chains:
        if point.parameters.n_blocks > MAXIMUM_BLOCKS:
            raise InputError(
                f"n_blocks = {point.parameters.n_blocks}: "
                f"a scan takes at most {MAXIMUM_BLOCKS} blocks"
            )
    if given is None:
        return np.array([section_rule(point.parameters) for point in chains])
    return np.array(arguments.for_each("section_position", given, len(chains), checks.positive))


def _measure(
    members: list[Point],
    sections: np.ndarray,
    duration: float,
    transient: float,
    *,
    section_values: int,
    laminar_time: float,
    report: Progress,
) -> dict[str, np.ndarray]:
    """What is measured of a group of W points: arrays with first axis W."""
    n_blocks, width = members[0].parameters.n_blocks, len(members)
    sampling = sampling_of(None, members[0].method, members[0].time_step)
    start = members[0].state.time + transient
    integrator = integrator_of(
        members, sampling=sampling, sampled_blocks=1, section=Section(n_blocks, sections)
    )
    moments = LengthMoments(width, start)
    belt_velocities = np.array([point.parameters.belt_velocity for point in members])
    section = SectionValues(belt_velocities, section_values, start)
    slips = SlipActivity(width, n_blocks, start, laminar_time, slipping_since(members))
    observe(integrator, duration, [moments, section, slips], report)
    counts = np.zeros((width, MAXIMUM_BLOCKS), dtype=np.int64)
    counts[:, :n_blocks] = slips.slip_count
    return {
        **moments_of(
            moments, members[0].parameters.rest_positions[-1], sampling, start, integrator.time
        ),
        "energy_residual": integrator.energy_residual(),
        "section_count": section.count,
        "section_velocity": section.values,
        "slip_count": counts,
        **slips.laminar(),
        "last_stick_time": slips.last_stick_time,
    }
