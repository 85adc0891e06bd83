"""Lyapunov exponents of chains, from the exact tangent dynamics (docs/chaos.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from beltrepro.base import checks, names
from beltrepro.base.errors import InputError
from beltrepro.chaos.clocks import REST, integrator_by
from beltrepro.chaos.vectors import (
    METHOD,
    NO_SAMPLES,
    check_method,
    count_intervals,
    end_errors,
    grow,
    slopes,
    standard_errors,
    with_vectors,
)
from beltrepro.engine.integrator import Integrator
from beltrepro.engine.state import ChainState
from beltrepro.model import ChainParameters
from beltrepro.observe.slips import MostStuck
from beltrepro.simulation import arguments
from beltrepro.simulation.arguments import PerChain
from beltrepro.simulation.points import Point, Progress, groups, integrator_of, observe, points

_ALIGNED = 0.2  # last share of the transient, in which the vectors turn to their directions
_ERRORS = 3.0  # standard errors that the exponent of the motion itself may be from zero


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum:
    """Lyapunov exponents of a chain, per unit of model time.

    Attributes
    ----------
    parameters : ChainParameters
        The chain.
    exponents : array (K,)
        Mean over the runs, largest first; minus infinity for directions that a stick erases.
    standard_error : array (K,)
        Of the mean, from the scatter of the runs, or of the parts of a single one; 0 where the
        exponent is minus infinity.
    runs : array (R, K)
        Of each run: the slope of the logarithm of the growth, by least squares.
    growth : array (R, T, K)
        Growth of each vector, as a rate, in the T intervals after the transient: finite-time
        exponents.
    interval : float
        Length of these intervals, model time.
    most_stuck : array (R,)
        Most blocks that were stuck at once after the transient.
    noise_clock : str
        By which noise is the same for two chains, see `lyapunov_spectrum`.
    """

    parameters: ChainParameters
    exponents: np.ndarray
    standard_error: np.ndarray
    runs: np.ndarray
    growth: np.ndarray
    interval: float
    most_stuck: np.ndarray
    noise_clock: str = REST

    @property
    def erased(self) -> int:
        """Number of exponents of the K that are minus infinity."""
        return int(np.isneginf(self.exponents).sum())

    @property
    def trivial(self) -> int | None:
        """Index of the exponent that belongs to a shift of time, and is zero.

        The one nearest to zero. None if that is further from zero than its error and e^5 in the
        time of observation explain, since it is not among the K then. With noise a shift of time
        leads from one motion to another only if the noise is shifted too, which takes a rest of the
        whole chain; None if there was none, or if the noise is that of the laboratory.
        """
        finite = np.isfinite(self.exponents)
        rests = np.all(self.most_stuck == self.parameters.n_blocks)
        shifted = rests and self.noise_clock == REST
        if (self.parameters.noise > 0 and not shifted) or not finite.any():
            return None
        first = int(np.argmin(np.abs(self.exponents[finite])))
        time = self.growth.shape[1] * self.interval
        margin = np.nanmax([_ERRORS * self.standard_error[first], 5.0 / time])
        return first if abs(self.exponents[first]) <= margin else None

    @names.checked
    def finite_time(self, length: float) -> np.ndarray:
        """Exponents over stretches of the runs: the distribution of finite-time exponents.

        Parameters
        ----------
        length : float
            Of a stretch, model time; rounded to a whole number of intervals.

        Returns
        -------
        array (R, M, K)
            Mean growth, as a rate, in each of the M stretches that follow each other in a run and
            fit in whole; minus infinity for directions that a stick erases.

        Raises
        ------
        InputError
            The length is shorter than an interval, or longer than a run after the transient.
        """
        runs, intervals, count = self.growth.shape
        size = round(checks.positive("length", length) / self.interval)
        if not 1 <= size <= intervals:
            longest = intervals * self.interval
            raise InputError(f"length = {length:g}: allowed are {self.interval:g} to {longest:g}")
        stretches = intervals // size
        kept = self.growth[:, : stretches * size]
        return kept.reshape(runs, stretches, size, count).mean(axis=2)

    def __repr__(self) -> str:
        first = ", ".join(
            f"{value:.3g} ± {error:.1g}"
            for value, error in zip(self.exponents[:3], self.standard_error[:3], strict=True)
        )
        more = ", ..." if len(self.exponents) > 3 else ""
        return f"LyapunovSpectrum({self.parameters.describe()}: {first}{more})"


@names.checked
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
    replicate: int | Sequence[int] = range(8),
    initial_spread: float = 1.0,
    noise_clock: str = REST,
    progress: Progress | None = None,
) -> LyapunovSpectrum:
    """Lyapunov exponents of one chain from several runs.

    Deviation vectors follow the linearised motion through slips, sticks and reversals, and are made
    orthonormal again every 20 time units (Benettin et al. 1980); their logarithmic growth is
    counted after the transient. With noise the exponents are those of the motion under one given
    realisation of the noise. For a run from a given state see `exponents`.

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
        K, how many exponents, the largest; all 2N if not given.
    method : str
        "event", the only one with a tangent dynamics.
    time_step : float
        dt, model time; it only sets the strength of the noise.
    tolerance : float or None
        Truncation of the series, as in `simulate`.
    seed : int
        Of 0 or greater; with the parameters and the replicates it fixes all random numbers.
    replicate : int or sequence of int
        One run for each.
    initial_spread : float
        Standard deviation of normal deviates that are added to the initial positions of replicates
        other than 0, model length. Without noise only these make the runs differ.
    noise_clock : str
        When noise is the same for two chains: "rest", at the same time since the last rest of the
        whole chain, as in `event`; or "laboratory", at the same time.
    progress : callable
        Called with the fraction done.

    Returns
    -------
    LyapunovSpectrum
        Exponents with errors, and the growth that they are the means of.

    Raises
    ------
    InputError
        A value is not allowed, or the runs would all be the same.
    ModelStateError
        A state left the range of the model.
    """
    arguments.of_one_chain(
        parameters,
        method=method,
        time_step=time_step,
        tolerance=tolerance,
        seed=checks.key("seed", seed),
        initial_spread=initial_spread,
    )
    replicates = _replicates(replicate)
    if len(replicates) > 1 and parameters.noise == 0 and initial_spread == 0:
        raise InputError(
            "initial_spread = 0: without noise all runs would be the same; "
            "give a spread greater than 0, or one replicate"
        )
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
        initial_spread=initial_spread,
        noise_clock=noise_clock,
        progress=progress,
    )
    mean, error = _mean_of_runs(found["growth"], found["standard_error"])
    return LyapunovSpectrum(
        parameters=parameters,
        exponents=mean,
        standard_error=error,
        runs=found["exponents"],
        growth=found["growth"],
        interval=float(found["interval"]),
        most_stuck=found["most_stuck"],
        noise_clock=noise_clock,
    )


def _replicates(given: int | Sequence[int]) -> list[int]:
    """At least one, and none twice."""
    each = list(given) if checks.is_sequence(given) else [given]
    replicates = [checks.key("replicate", value) for value in each]
    if not replicates or len(set(replicates)) < len(replicates):
        raise InputError(
            f"replicate = {checks.shown(given)}: at least one is needed, and none twice"
        )
    return replicates


def _mean_of_runs(growth: np.ndarray, errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean exponents (K,) of R runs and their errors; `errors` (R, K) are those of each run."""
    runs = slopes(growth)
    erased = np.isneginf(runs).any(axis=0)  # by one run is enough
    finite = np.where(erased, 0.0, runs)
    error = errors[0]
    if len(runs) > 1:
        scatter = finite.std(axis=0, ddof=1) / np.sqrt(len(runs))
        error = np.hypot(scatter, end_errors(growth).mean(axis=0))
    return np.where(erased, -np.inf, finite.mean(axis=0)), np.where(erased, 0.0, error)


@names.checked
def exponents(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    transient: float = 0.0,
    n_exponents: int | None = None,
    method: PerChain[str] = METHOD,
    time_step: PerChain[float] = 0.001,
    tolerance: PerChain[float | None] = None,
    seed: PerChain[int] | None = None,
    replicate: PerChain[int] | None = None,
    initial_positions: ArrayLike | Sequence[ArrayLike] | None = None,
    initial_spread: PerChain[float] = 0.0,
    initial_state: PerChain[ChainState] | None = None,
    noise_clock: str = REST,
    progress: Progress | None = None,
) -> dict[str, np.ndarray]:
    """Lyapunov exponents of each of P chains, which may differ in everything.

    Parameters
    ----------
    parameters : ChainParameters or sequence of them
        P chains.
    duration : float
        Model time of each run, the transient included.
    transient : float
        The first part of it, which is not counted.
    n_exponents : int or None
        K, the largest; all 2N of the longest chain if not given.
    method : str
        "event", the only one with a tangent dynamics.
    time_step : float
        dt, model time; it only sets the strength of the noise.
    tolerance : float or None
        Truncation of the series, as in `simulate`.
    seed, replicate : int
        Of 0 or greater; with the parameters they fix all random numbers. 1 and 0 if not given.
    initial_positions : array (N,), or a sequence of such arrays for a sequence of chains
        Positions of the blocks at t = 0, model length; undeformed springs if not given.
    initial_spread : float
        Standard deviation of normal deviates that are added to the initial positions of replicates
        other than 0, model length.
    initial_state : ChainState
        Where to go on, instead of these.
    noise_clock : str
        As in `lyapunov_spectrum`.
    progress : callable
        Called with the fraction done.

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
    check_method(chains)
    integrator_by(noise_clock)
    count = _count(n_exponents, chains)
    intervals = count_intervals(duration - transient)
    most_stuck = np.zeros(len(chains), dtype=np.int64)
    growth = np.full((len(chains), intervals, count), np.nan)
    for group, report in groups(chains, progress):
        members = [chains[index] for index in group]
        size = min(count, 2 * members[0].parameters.n_blocks)
        rates, most_stuck[group] = _follow(members, duration, transient, size, noise_clock, report)
        growth[group, :, :size] = rates
    order = np.argsort(-slopes(growth), axis=1, kind="stable")  # NaN last
    growth = np.take_along_axis(growth, order[:, None], axis=2)
    return {
        "exponents": slopes(growth),
        "standard_error": standard_errors(growth),
        "most_stuck": most_stuck,
        "growth": growth,
        "interval": np.array((duration - transient) / intervals),
    }


def _count(n_exponents: int | None, chains: Sequence[Point]) -> int:
    """How many exponents are asked for."""
    widest = 2 * max(point.parameters.n_blocks for point in chains)
    count = widest if n_exponents is None else checks.whole_number("n_exponents", n_exponents)
    if not 1 <= count <= widest:
        raise InputError(f"n_exponents = {checks.shown(count)}: allowed are 1 to 2N = {widest}")
    return count


def _follow(
    members: list[Point],
    duration: float,
    transient: float,
    size: int,
    noise_clock: str,
    report: Progress,
) -> tuple[np.ndarray, np.ndarray]:
    """Growth rates (W, T, K) of the vectors of a group, and most blocks stuck at once (W,)."""
    before = integrator_of(members, sampling=NO_SAMPLES, sampled_blocks=1)
    alone = (1 - _ALIGNED) * transient
    if transient > 0:
        observe(before, alone, [], lambda fraction: report(fraction * alone / duration))
    chains = with_vectors(before, members, size, noise_clock=noise_clock)
    if transient > 0:
        grow(chains, transient - alone, [], lambda fraction: None)
    stuck = MostStuck(_stuck_now(chains))
    counted = duration - transient
    growth = grow(
        chains, counted, [stuck], lambda done: report((transient + done * counted) / duration)
    )
    erased = np.arange(size) >= 2 * chains.n_blocks - stuck.most[:, None]
    return np.where(erased[:, None], -np.inf, growth), stuck.most


def _stuck_now(chains: Integrator) -> np.ndarray:
    """Number of blocks (W,) of each chain that are stuck."""
    return np.array([np.sum(state.directions == 0) for state in chains.state()])
