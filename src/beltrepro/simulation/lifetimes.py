"""Lifetimes of chaotic transients: when the last block of a chain has stuck for the last time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.observe.length import LengthMoments
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

SETTLE_SHARE = 0.1  # of the duration, over which the final state is measured unless told otherwise


@names.checked
def escapes(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    settle_time: float | None = None,
    method: PerChain[str] = "verlet",
    time_step: PerChain[float] = 0.001,
    tolerance: PerChain[float | None] = None,
    seed: PerChain[int] | None = None,
    replicate: PerChain[int] | None = None,
    initial_positions: ArrayLike | Sequence[ArrayLike] | None = None,
    initial_spread: PerChain[float] = 0.0,
    initial_state: PerChain[ChainState] | None = None,
    laminar_time: float = 200.0,
    progress: Progress | None = None,
) -> dict[str, np.ndarray]:
    """Lifetimes of the chaotic transients of P chains (inset of Fig. 12).

    A chain escapes at the last stick of its last block, if after that the last block slips to the
    end of the run and for longer than `laminar_time`.

    Parameters
    ----------
    parameters : ChainParameters or sequence of them
        P chains; `[chain] * 200` with `replicate=range(200)` and an `initial_spread` begins in 200
        slightly different states.
    duration : float
        As in `simulate`.
    settle_time : float, optional
        The end of each run over which its final state is measured, model time; a tenth of the
        duration if not given. Where fewer than 10 samples, one about every 0.1, fall into it, r and
        <x_N> are NaN, with a warning.
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
    laminar_time : float
        Shortest slip of the last block that counts as an escape, model time.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    dict of arrays with first axis P
        n_blocks, belt_velocity, noise, replicate; lifetime (the duration if not escaped), escaped;
        final_disorder, final_mean_length, final_amplitude (range of x_N); final_stick_rate (P, N)
        sticks per model time, N that of the longest chain, NaN padded. Model units.

    Raises
    ------
    InputError
        A value is not allowed.
    ModelStateError
        A state left the range of the model.
    """
    duration = arguments.length(duration)
    settle_time = SETTLE_SHARE * duration if settle_time is None else settle_time
    settle_time = checks.finite_number("settle_time", settle_time)
    if not 0 < settle_time <= duration:
        raise InputError(
            f"settle_time = {settle_time:g}: must be greater than 0 "
            f"and at most duration = {duration:g}"
        )
    laminar_time = checks.not_negative("laminar_time", laminar_time)
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
    width = max(point.parameters.n_blocks for point in chains)
    table: dict[str, np.ndarray] = {
        "n_blocks": np.array([point.parameters.n_blocks for point in chains]),
        "belt_velocity": np.array([point.parameters.belt_velocity for point in chains]),
        "noise": np.array([point.parameters.noise for point in chains]),
        "replicate": np.array([point.state.replicate for point in chains], dtype=np.int64),
        "final_stick_rate": np.full((len(chains), width), np.nan),
    }
    for group, report in groups(chains, progress):
        members = [chains[index] for index in group]
        measured = once(_measure, members, duration, settle_time, laminar_time, report)
        rates = measured.pop("final_stick_rate")
        table["final_stick_rate"][group, : rates.shape[1]] = rates
        for name, values in measured.items():
            table.setdefault(name, np.empty(len(chains), values.dtype))[group] = values
    return table


def _measure(
    members: list[Point],
    duration: float,
    settle_time: float,
    laminar_time: float,
    report: Progress,
) -> dict[str, np.ndarray]:
    """What is measured of a group of W points: arrays with first axis W."""
    chain, width = members[0].parameters, len(members)
    sampling = sampling_of(None, members[0].method, members[0].time_step)
    start = members[0].state.time
    settled = start + (duration - settle_time)
    integrator = integrator_of(members, sampling=sampling, sampled_blocks=1)
    moments = LengthMoments(width, settled)
    slips = SlipActivity(width, chain.n_blocks, settled, laminar_time, slipping_since(members))
    observe(integrator, duration, [moments, slips], report)
    rest_length = chain.rest_positions[-1]
    final = moments_of(moments, rest_length, sampling, settled, integrator.time)
    # NaN (stuck at the end) compares false; without a stick on the way the lifetime is 0
    escaped = integrator.time - slips.slipping_since > laminar_time
    last_stick = np.nan_to_num(slips.last_stick_time, nan=start)
    return {
        "lifetime": np.where(escaped, last_stick - start, duration),
        "escaped": escaped,
        "final_disorder": final["disorder_parameter"],
        "final_mean_length": final["mean_length"],
        "final_amplitude": final["maximum_length"] - final["minimum_length"],
        "final_stick_rate": slips.stick_count / settle_time,
    }
