"""Lyapunov exponents of chains, from the exact tangent dynamics (docs/chaos.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from beltrepro import checks
from beltrepro.engine.tangent_integrator import TangentIntegrator
from beltrepro.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.observe.stuck import MostStuck
from beltrepro.simulation import arguments, tangents
from beltrepro.simulation.arguments import PerChain
from beltrepro.simulation.points import Point, Progress, groups, integrator_of, observe, points

METHOD = "event"  # the tangent dynamics is that of the exact motion
_ALIGNED = 0.2  # last share of the transient, in which the vectors turn to their directions


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum:
    """Lyapunov exponents of a chain, per unit of model time.

    Parameters
    ----------
    parameters : ChainParameters
        The chain.
    exponents : array (K,)
        Mean over the runs, largest first; minus infinity for directions that a stick erases.
    standard_error : array (K,)
        Of the mean, from the scatter of the runs, or of the parts of a single one; 0 where the
        exponent is minus infinity.
    runs : array (R, K)
        Of each run.
    growth : array (R, T, K)
        Growth of each vector, as a rate, in the T intervals after the transient: finite-time
        exponents.
    interval : float
        Length of these intervals, model time.
    """

    parameters: ChainParameters
    exponents: np.ndarray
    standard_error: np.ndarray
    runs: np.ndarray
    growth: np.ndarray
    interval: float

    @property
    def erased(self) -> int:
        """Number of exponents of the K that are minus infinity."""
        return int(np.isneginf(self.exponents).sum())

    @property
    def trivial(self) -> int | None:
        """Index of the exponent of the direction of the motion itself, which is zero.

        None with noise, where no shift of time leads from one motion to another.
        """
        finite = np.isfinite(self.exponents)
        if self.parameters.noise > 0 or not finite.any():
            return None
        return int(np.argmin(np.abs(self.exponents[finite])))

    def __repr__(self) -> str:
        first = ", ".join(
            f"{value:.3g} ± {error:.1g}"
            for value, error in zip(self.exponents[:3], self.standard_error[:3], strict=True)
        )
        more = ", ..." if len(self.exponents) > 3 else ""
        return f"LyapunovSpectrum({self.parameters.describe()}: {first}{more})"


def lyapunov_spectrum(
    parameters: ChainParameters,
    *,
    duration: float,
    transient: float,
    n_exponents: int | None = None,
    method: str = METHOD,
    time_step: float = 0.001,
    tolerance: float | None = None,
    seed: int = 1,
    replicate: Sequence[int] = range(8),
    initial_spread: float = 1.0,
    initial_state=None,
    progress: Progress | None = None,
) -> LyapunovSpectrum:
    """Lyapunov exponents of one chain from several runs.

    Deviation vectors follow the linearised motion through slips, sticks and reversals, and are made
    orthonormal again every 20 time units (Benettin et al. 1980); their logarithmic growth is
    counted after the transient. With noise the exponents are those of the motion under one given
    realisation of the noise.

    Parameters
    ----------
    parameters : ChainParameters
        The chain.
    duration : float
        Model time of each run, the transient included.
    transient : float
        The first part of it, which is not counted. The vectors turn to their directions in its last
        fifth.
    n_exponents : int or None
        How many exponents, the largest; all 2N if not given.
    method : str
        "event", the only one with a tangent dynamics.
    time_step, tolerance, seed
        As in `simulate`.
    replicate : sequence of int
        One run for each.
    initial_spread, initial_state, progress
        As in `simulate`.

    Returns
    -------
    LyapunovSpectrum

    Raises
    ------
    InputError
        A value is not allowed.
    ModelStateError
        A state left the range of the model.
    """
    if not isinstance(parameters, ChainParameters):
        raise InputError(f"parameters = {parameters!r}: a ChainParameters is needed")
    replicates = [replicate] if np.ndim(replicate) == 0 else list(replicate)
    found = exponents(
        [parameters] * len(replicates),
        duration=duration,
        transient=transient,
        n_exponents=n_exponents,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=seed,
        replicate=replicates,
        initial_spread=0.0 if initial_state is not None else initial_spread,
        initial_state=initial_state,
        progress=progress,
    )
    runs, growth = found["exponents"], found["growth"]
    erased = np.isneginf(runs).any(axis=0)
    error = found["standard_error"][0]
    if len(runs) > 1:
        scatter = np.where(erased, 0.0, np.where(np.isneginf(runs), 0.0, runs)).std(axis=0, ddof=1)
        error = scatter / np.sqrt(len(runs))
    return LyapunovSpectrum(
        parameters=parameters,
        exponents=np.where(erased, -np.inf, np.where(erased, 0.0, runs).mean(axis=0)),
        standard_error=np.where(erased, 0.0, error),
        runs=runs,
        growth=growth,
        interval=float(found["interval"]),
    )


def exponents(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    transient: float = 0.0,
    n_exponents: int | None = None,
    method: PerChain[str] = METHOD,
    time_step: PerChain[float] = 0.001,
    tolerance: PerChain[float | None] = None,
    seed: PerChain[int | None] = None,
    replicate: PerChain[int | None] = None,
    initial_positions=None,
    initial_spread: PerChain[float] = 0.0,
    initial_state=None,
    progress: Progress | None = None,
) -> dict[str, np.ndarray]:
    """Lyapunov exponents of each of P chains, which may differ in everything.

    Parameters
    ----------
    parameters, duration, transient, method, time_step, tolerance, seed, replicate
        As in `lyapunov_spectrum` and `simulate`.
    n_exponents : int or None
        K, the largest; all 2N of the longest chain if not given.
    initial_positions, initial_spread, initial_state, progress
        As in `simulate`.

    Returns
    -------
    dict of arrays with first axis P
        exponents (P, K) per model time, largest first: minus infinity for directions that a stick
        erases, NaN for those that a shorter chain lacks; standard_error (P, K) from the parts of
        the run; most_stuck (P,) blocks stuck at once; growth (P, T, K) rates of growth in the
        intervals; and the length of these, interval ().

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
    for point in chains:
        if point.method != METHOD:
            raise InputError(f"method = {point.method!r}: only {METHOD!r} has a tangent dynamics")
    widest = 2 * max(point.parameters.n_blocks for point in chains)
    count = widest if n_exponents is None else checks.whole_number("n_exponents", n_exponents)
    if not 1 <= count <= widest:
        raise InputError(f"n_exponents = {count}: allowed are 1 to 2N = {widest}")
    intervals = max(1, round((duration - transient) / tangents.INTERVAL))
    table = {
        "most_stuck": np.zeros(len(chains), dtype=np.int64),
        "growth": np.full((len(chains), intervals, count), np.nan),
    }
    for group, report in groups(chains, progress):
        members = [chains[index] for index in group]
        size = min(count, 2 * members[0].parameters.n_blocks)
        growth, stuck = _follow(members, duration, transient, intervals, size, report)
        table["growth"][group, :, :size] = growth
        table["most_stuck"][group] = stuck
    means = table["growth"].mean(axis=1)
    order = np.argsort(-means, axis=1, kind="stable")  # NaN last
    table["growth"] = np.take_along_axis(table["growth"], order[:, None], axis=2)
    return table | {
        "exponents": np.take_along_axis(means, order, axis=1),
        "standard_error": tangents.standard_errors(table["growth"]),
        "interval": np.float64((duration - transient) / intervals),
    }


def _follow(
    members: list[Point],
    duration: float,
    transient: float,
    intervals: int,
    size: int,
    report: Progress,
) -> tuple[np.ndarray, np.ndarray]:
    """Growth rates (W, T, K) of the vectors of a group, and most blocks stuck at once (W,)."""
    before = integrator_of(members, sampling=tangents.NO_SAMPLES, sampled_blocks=1)
    stuck = MostStuck(np.array([np.sum(point.state.directions == 0) for point in members]))
    alone = (1 - _ALIGNED) * transient
    if alone > 0:
        observe(before, alone, [stuck], lambda fraction: report(fraction * alone / duration))
    chains = TangentIntegrator(
        before.state(),
        n_vectors=size,
        time_step=members[0].time_step,
        sampling=tangents.NO_SAMPLES,
        sampled_blocks=1,
        **members[0].accuracy,
    )
    tangents.randomise(chains)
    whole = members[0].state.time + duration

    def done(time):
        report(1 - (whole - time) / duration)

    if alone > 0:
        tangents.grow(chains, transient - alone, None, [stuck], done)
    growth = tangents.grow(chains, duration - transient, intervals, [stuck], done)
    erased = np.arange(size) >= 2 * chains.n_blocks - stuck.most[:, None]
    return np.where(erased[:, None], -np.inf, growth), stuck.most
