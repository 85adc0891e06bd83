"""Simulate chains: single runs, points of a scan, catalogues of slips, ensembles of escapes.

All public functions check their input, advance the chains in groups of equal size and law, and
return plain arrays in model units. What a chain does depends on its parameters, seed and replicate
only, never on the chains beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from inspect import signature

import numpy as np

from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.integrator import GROUP_SIZE, Section
from beltrepro.engine.law import law_constants
from beltrepro.engine.noise import stream_key
from beltrepro.engine.records import (
    EVENT_BLOCK,
    EVENT_DISSIPATED,
    EVENT_FORCE,
    EVENT_POSITION,
    EVENT_SLIP,
    EVENT_TIME,
)
from beltrepro.engine.verlet_integrators import verlet_integrator
from beltrepro.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.model.spring import external_force
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.sections import CrossingLog, SectionValues
from beltrepro.observe.slips import (
    AVALANCHE,
    SLIP,
    EventLog,
    SlipActivity,
    slips_and_avalanches,
)

METHODS = {"verlet": verlet_integrator, "event": EventIntegrator}
# Tolerance that an integrator takes unless told otherwise, for those that have one.
TOLERANCES = {
    name: signature(integrator).parameters["tolerance"].default
    for name, integrator in METHODS.items()
    if "tolerance" in signature(integrator).parameters
}
TOLERANCE_RANGE = (1e-16, 1.0)  # unit of force; forces are some tens, and rounding 1e-16 of them
MOMENTS_INTERVAL = 0.1  # model time between samples of x_N for r, about; oscillations take 3
MAXIMUM_SCAN_BLOCKS = 10  # columns of slip_count
_INITIAL_STATE = 1  # purpose of a random stream: initial positions, not friction

EVENT = np.dtype(
    [
        ("time", "f8"),
        ("block", "i8"),
        ("kind", "U5"),
        ("force", "f8"),
        ("position", "f8"),
        ("dissipated", "f8"),
    ]
)


@dataclass(frozen=True)
class Run:
    """One simulated chain, in model units.

    tolerance : truncation allowed in a step (the method's own may be larger with noise), None for a
    method without one.
    disorder_parameter, mean_length : r and <x_N> after the transient (Eq. 4).
    energy_residual : share of the belt's work that the energy audit does not account for.
    time (T,), positions, velocities, friction (T, N) : samples; laboratory frame; friction is the
    friction force on each block (while stuck minus the external force).
    events : structured array with time, block (from 1), kind ("slip" or "stick"), force (external
    force F_ex there), position, dissipated (friction loss of that block since t = 0). A block that
    reverses without sticking has a stick and a slip at one time.
    """

    parameters: ChainParameters
    method: str
    tolerance: float | None
    seed: int
    disorder_parameter: float
    mean_length: float
    energy_residual: float
    time: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    friction: np.ndarray
    events: np.ndarray


def simulate(
    parameters: ChainParameters | Sequence[ChainParameters],
    *,
    duration: float,
    transient: float = 0.0,
    method: str = "verlet",
    seed: int = 1,
    initial_positions=None,
    sample_interval: float | None = 0.1,
    sample_start: float = 0.0,
    time_step: float = 0.001,
    tolerance: float | None = None,
    replicate: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Run | list[Run]:
    """Simulate one chain, or several together, from all blocks stuck at t = 0 (Sec. III).

    Parameters
    ----------
    parameters : one chain, or a sequence of chains that are advanced together.
    duration : model time simulated, the transient included. transient : left out of r and <x_N>.
    method : integrator, "verlet" (Appendix) or "event" (exact dynamics, docs/event.md).
    time_step : dt, model time; for "event" it only sets the strength of the noise.
    tolerance : only for "event": last terms of the series of a force allowed at the end of a step,
    unit of force, 1e-16 to 1; the method's own if not given, which is larger with noise
    (docs/event.md).
    seed, replicate : whole numbers >= 0; with the parameters they fix all random numbers.
    initial_positions : (N,) or, for a sequence, one such array for each chain; undeformed springs
    if not given.
    sample_interval : model time between samples, a multiple of time_step; None keeps no samples.
    sample_start : no samples are kept before this time.
    progress : called with the fraction done.

    Returns
    -------
    Run, or a list of Run for a sequence.

    Raises
    ------
    InputError : a value is out of range. ModelStateError : a state left the range of the model.
    """
    single = isinstance(parameters, ChainParameters)
    chains = [parameters] if single else list(parameters)
    _check_lengths(duration, transient, time_step, method, seed, replicate)
    accuracy = {}
    if tolerance is None:
        tolerance = TOLERANCES.get(method)
    else:
        _check_tolerance(tolerance, method)
        accuracy = {"tolerance": tolerance, "noise_share": 0.0}  # as asked for, noise or not
    stride = (
        _moments_stride(time_step)
        if sample_interval is None
        else _stride(sample_interval, time_step)
    )
    if single and initial_positions is not None:
        initial_positions = [initial_positions]
    starts = [
        _initial_positions(chain, None if initial_positions is None else initial_positions[index])
        for index, chain in enumerate(chains)
    ]
    runs: list[Run | None] = [None] * len(chains)
    for group, report in _groups(chains, progress):
        members = [chains[index] for index in group]
        n_blocks = members[0].n_blocks
        keeps_samples = sample_interval is not None
        integrator = METHODS[method](
            members,
            seed=seed,
            replicates=[replicate] * len(members),
            initial_positions=np.array([starts[index] for index in group]),
            time_step=time_step,
            sample_stride=stride,
            sampled_blocks=n_blocks if keeps_samples else 1,
            **accuracy,
        )
        moments = LengthMoments(len(members), transient)
        log = EventLog(len(members), members[0].rest_positions)
        observers = [moments, log]
        if keeps_samples:
            samples = _SampleLog(integrator, sample_start)
            observers.append(samples)
        _observe(integrator, duration, observers, report)
        length = moments.result(members[0].rest_positions[-1])
        residual = integrator.energy_residual()
        for lane, index in enumerate(group):
            sampled = samples.of(lane) if keeps_samples else _no_samples(n_blocks)
            runs[index] = Run(
                parameters=chains[index],
                method=method,
                tolerance=tolerance,
                seed=seed,
                disorder_parameter=float(length["disorder_parameter"][lane]),
                mean_length=float(length["mean_length"][lane]),
                energy_residual=float(residual[lane]),
                **sampled,
                events=_event_records(log, lane),
            )
    return runs[0] if single else runs


def measure_points(
    parameters: Sequence[ChainParameters],
    *,
    duration: float,
    transient: float,
    section_position: float | Sequence[float],
    section_values: int = 500,
    laminar_time: float = 200.0,
    method: str = "verlet",
    time_step: float = 0.001,
    seed: int = 1,
    replicates: Sequence[int] | None = None,
    initial_spread: float = 0.0,
    progress: Callable[[float], None] | None = None,
) -> dict[str, np.ndarray]:
    """What Figs. 12 to 22 show of a point (N, u, sigma), for P points from the declared state.

    Parameters
    ----------
    parameters : P chains of at most 10 blocks, of any mixture of sizes.
    duration, transient, method, time_step, seed, progress : as in `simulate`.
    section_position : x_N of the section (Fig. 12: 615), one for all or one for each point.
    section_values : crossings of the section kept for each point.
    laminar_time : shortest slip of the last block that counts as a laminar phase.
    replicates : (P,) whole numbers, 0 if not given: another replicate has other random numbers.
    initial_spread : standard deviation of the initial positions of replicates other than 0.

    Returns
    -------
    dict of arrays with first axis P: n_blocks, belt_velocity, noise, replicate; mean_length,
    disorder_parameter (Eq. 4), minimum_length, maximum_length; energy_residual; section_position,
    section_count (all downward crossings of x_N after the transient), section_velocity
    (P, section_values) v_N at the first of them, NaN padded; slip_count (P, 10);
    laminar_fraction, laminar_count, laminar_mean, laminar_longest; last_stick_time of the last
    block, NaN if it never stuck. Lengths in model units, from the laboratory frame.

    Raises
    ------
    InputError, ModelStateError : as in `simulate`.
    """
    chains = list(parameters)
    n_points = len(chains)
    _check_lengths(duration, transient, time_step, method, seed)
    for chain in chains:
        if chain.n_blocks > MAXIMUM_SCAN_BLOCKS:
            raise InputError(
                f"n_blocks = {chain.n_blocks}: a scan takes at most {MAXIMUM_SCAN_BLOCKS} blocks"
            )
    replicates = np.zeros(n_points, int) if replicates is None else np.asarray(replicates)
    positions = np.broadcast_to(np.asarray(section_position, dtype=float), (n_points,))
    starts = [
        _perturbed(chain, seed, replicate, initial_spread)
        for chain, replicate in zip(chains, replicates, strict=True)
    ]
    table: dict[str, np.ndarray] = {
        "n_blocks": np.array([chain.n_blocks for chain in chains]),
        "belt_velocity": np.array([chain.belt_velocity for chain in chains]),
        "noise": np.array([chain.noise for chain in chains]),
        "replicate": replicates.astype(np.int64),
        "section_position": positions.copy(),
    }
    for group, report in _groups(chains, progress):
        members = [chains[index] for index in group]
        n_blocks, width = members[0].n_blocks, len(members)
        integrator = METHODS[method](
            members,
            seed=seed,
            replicates=replicates[group],
            initial_positions=np.array([starts[index] for index in group]),
            time_step=time_step,
            sample_stride=_moments_stride(time_step),
            sampled_blocks=1,
            section=Section(n_blocks, positions[group]),
        )
        moments = LengthMoments(width, transient)
        section = SectionValues(table["belt_velocity"][group], section_values, transient)
        slips = SlipActivity(width, n_blocks, transient, laminar_time)
        _observe(integrator, duration, [moments, section, slips], report)
        counts = np.zeros((width, MAXIMUM_SCAN_BLOCKS), dtype=np.int64)
        counts[:, :n_blocks] = slips.slip_count
        measured = {
            **moments.result(members[0].rest_positions[-1]),
            "energy_residual": integrator.energy_residual(),
            "section_count": section.count,
            "section_velocity": section.values,
            "slip_count": counts,
            **slips.laminar(),
            "last_stick_time": slips.last_stick_time,
        }
        for name, values in measured.items():
            if name not in table:
                table[name] = np.empty((n_points, *values.shape[1:]), dtype=values.dtype)
            table[name][group] = values
    return table


def record_catalogue(
    parameters: ChainParameters,
    *,
    duration: float,
    transient: float,
    method: str = "verlet",
    time_step: float = 0.001,
    seed: int = 1,
    section_block: int = 2,
    section_position: float = 304.3,
    n_chains: int = 32,
    initial_spread: float = 1e-3,
    progress: Callable[[float], None] | None = None,
) -> dict[str, np.ndarray]:
    """Slips, avalanches and section points of several runs of one chain (Figs. 9 and 10).

    Parameters
    ----------
    parameters : the chain; n_chains runs of it differ in replicate: replicate 0 starts from the
    declared state, the others from positions with normal deviations of `initial_spread`.
    duration, transient, method, time_step, seed, progress : as in `simulate`; for each run.
    section_block, section_position : the section x_block = position, dx_block/dt < 0 (Fig. 10).

    Returns
    -------
    slips, avalanches : structured arrays, see `beltrepro.observe.slips`, those that start after
    the transient. section : structured array of chain, time, positions (N,), velocities (N,).

    Raises
    ------
    InputError, ModelStateError : as in `simulate`.
    """
    _check_lengths(duration, transient, time_step, method, seed)
    n_blocks = parameters.n_blocks
    if not 1 <= section_block <= n_blocks:
        raise InputError(f"section_block = {section_block}: allowed are 1 to {n_blocks}")
    if n_chains < 1:
        raise InputError(f"n_chains = {n_chains}: must be 1 or greater")
    chains = [parameters] * n_chains
    starts = [_perturbed(parameters, seed, index, initial_spread) for index in range(n_chains)]
    law = law_constants(parameters)
    slips, avalanches, crossings = [np.empty(0, SLIP)], [np.empty(0, AVALANCHE)], []
    for group, report in _groups(chains, progress):
        width = len(group)
        integrator = METHODS[method](
            [parameters] * width,
            seed=seed,
            replicates=group,
            initial_positions=np.array([starts[index] for index in group]),
            time_step=time_step,
            sample_stride=_moments_stride(time_step),
            sampled_blocks=1,
            section=Section(section_block, np.full(width, section_position)),
        )
        events = EventLog(width, parameters.rest_positions)
        section = CrossingLog(transient)
        _observe(integrator, duration, [events, section], report)
        for lane, index in enumerate(group):
            found = slips_and_avalanches(
                events.events(lane), index, starts[index], parameters, law, transient
            )
            slips.append(found[0])
            avalanches.append(found[1])
        rows = section.rows(n_blocks)
        rows[:, 0] = group[rows[:, 0].astype(int)]
        crossings.append(rows)
    return {
        "slips": np.concatenate(slips),
        "avalanches": np.concatenate(avalanches),
        "section": _section_records(np.concatenate(crossings), parameters),
    }


def escape_ensemble(
    parameters: ChainParameters,
    *,
    n_members: int,
    duration: float,
    settle_time: float,
    laminar_time: float = 200.0,
    method: str = "verlet",
    time_step: float = 0.001,
    seed: int = 1,
    initial_spread: float = 1e-3,
    progress: Callable[[float], None] | None = None,
) -> dict[str, np.ndarray]:
    """Lifetimes of chaotic transients from many slightly different states (inset of Fig. 12).

    A member escapes at its last stick of the last block, if after that the last block slips to the
    end of the run and for longer than `laminar_time`.

    Parameters
    ----------
    parameters : the chain. n_members : M initial states; member 0 is the declared one, the others
    deviate by normal deviates of `initial_spread` in every position.
    duration, method, time_step, seed, progress : as in `simulate`.
    settle_time : the end of each run over which its final state is measured.

    Returns
    -------
    dict of arrays with first axis M: belt_velocity, member, lifetime (duration if not escaped),
    escaped, final_disorder, final_mean_length, final_amplitude (range of x_N), final_stick_rate
    (M, N) sticks per model time.

    Raises
    ------
    InputError, ModelStateError : as in `simulate`.
    """
    _check_lengths(duration, duration - settle_time, time_step, method, seed)
    if n_members < 1:
        raise InputError(f"n_members = {n_members}: must be 1 or greater")
    n_blocks = parameters.n_blocks
    columns: list[dict[str, np.ndarray]] = []
    for group, report in _groups([parameters] * n_members, progress):
        width = len(group)
        integrator = METHODS[method](
            [parameters] * width,
            seed=seed,
            replicates=group,
            initial_positions=np.array(
                [_perturbed(parameters, seed, index, initial_spread) for index in group]
            ),
            time_step=time_step,
            sample_stride=_moments_stride(time_step),
            sampled_blocks=1,
        )
        settled = duration - settle_time
        moments = LengthMoments(width, settled)
        slips = SlipActivity(width, n_blocks, settled, laminar_time)
        _observe(integrator, duration, [moments, slips], report)
        final = moments.result(parameters.rest_positions[-1])
        # NaN (stuck at the end) compares false; the last block sticks at t = 0 to begin with
        escaped = duration - slips.slipping_since > laminar_time
        last_stick = np.nan_to_num(slips.last_stick_time, nan=0.0)
        columns.append(
            {
                "member": group,
                "lifetime": np.where(escaped, last_stick, duration),
                "escaped": escaped,
                "final_disorder": final["disorder_parameter"],
                "final_mean_length": final["mean_length"],
                "final_amplitude": final["maximum_length"] - final["minimum_length"],
                "final_stick_rate": slips.stick_count / settle_time,
            }
        )
    joined = {name: np.concatenate([part[name] for part in columns]) for name in columns[0]}
    return {"belt_velocity": np.full(n_members, parameters.belt_velocity), **joined}


class _SampleLog:
    """Keeps the samples of a run; the state at t = 0 included."""

    def __init__(self, integrator, start: float):
        self._start = start
        self._chains = integrator.parameters
        self._time = []
        self._parts = []
        if start <= 0:
            self._time.append(np.zeros(1))
            displacement = integrator.positions() - self._chains[0].rest_positions
            still = np.zeros_like(displacement)
            self._parts.append(np.stack([displacement, still, still])[:, None].swapaxes(2, 3))

    def observe(self, chunk) -> None:
        kept = chunk.time >= self._start
        if kept.any():
            parts = (chunk.displacement, chunk.relative_velocity, chunk.kinetic_friction)
            self._time.append(chunk.time[kept])
            self._parts.append(np.stack([part[kept] for part in parts]))

    def of(self, lane: int) -> dict[str, np.ndarray]:
        chain = self._chains[lane]
        if not self._time:
            return _no_samples(chain.n_blocks)
        displacement, slip_velocity, kinetic = np.concatenate(
            [part[..., lane] for part in self._parts], axis=1
        )
        positions = displacement + chain.rest_positions
        stuck = (slip_velocity == 0) & (kinetic == 0)
        return {
            "time": np.concatenate(self._time),
            "positions": positions,
            "velocities": slip_velocity + chain.belt_velocity,
            "friction": np.where(stuck, -external_force(positions, chain), kinetic),
        }


def _no_samples(n_blocks):
    empty = np.empty((0, n_blocks))
    return {"time": np.empty(0), "positions": empty, "velocities": empty, "friction": empty}


def _event_records(log: EventLog, lane):
    """Events of one chain as records; a long run has millions, so the log gives them up."""
    records = np.empty(log.count(lane), dtype=EVENT)
    start = 0
    for rows in log.give_up(lane):
        part = records[start : start + len(rows)]
        part["time"] = rows[:, EVENT_TIME]
        part["block"] = rows[:, EVENT_BLOCK].astype(np.int64) + 1
        part["kind"] = np.where(rows[:, EVENT_SLIP] > 0, "slip", "stick")
        part["force"] = rows[:, EVENT_FORCE]
        part["position"] = rows[:, EVENT_POSITION]
        part["dissipated"] = rows[:, EVENT_DISSIPATED]
        start += len(rows)
    return records


def _section_records(rows, parameters):
    n_blocks = parameters.n_blocks
    shape = (n_blocks,)
    dtype = [
        ("chain", "i4"),
        ("time", "f8"),
        ("positions", "f8", shape),
        ("velocities", "f8", shape),
    ]
    records = np.zeros(len(rows), dtype=dtype)
    records["chain"] = rows[:, 0]
    records["time"] = rows[:, 1]
    records["positions"] = rows[:, 2 : 2 + n_blocks] + parameters.rest_positions
    records["velocities"] = rows[:, 2 + n_blocks :] + parameters.belt_velocity
    return records


def _observe(integrator, duration, observers, report):
    for chunk in integrator.advance(duration):
        for observer in observers:
            observer.observe(chunk)
        report(chunk.end / duration)


def _groups(chains, progress):
    """Indices of the chains that can be advanced together, at most GROUP_SIZE, and how to report.

    An integrator may treat chains without noise in another way, and what a chain does must not
    depend on the others.
    """
    alike: dict = {}
    for index, chain in enumerate(chains):
        kind = chain.n_blocks, chain.law, chain.noise > 0
        alike.setdefault(kind, []).append(index)
    groups = [
        np.array(members[first : first + GROUP_SIZE])
        for members in alike.values()
        for first in range(0, len(members), GROUP_SIZE)
    ]
    weights = np.array([chains[group[0]].n_blocks * len(group) for group in groups], dtype=float)
    before = np.concatenate([[0.0], np.cumsum(weights)]) / weights.sum()
    for number, group in enumerate(groups):

        def report(fraction, low=before[number], high=before[number + 1]):
            if progress is not None:
                progress(low + (high - low) * fraction)

        yield group, report


def _perturbed(chain, seed, replicate, spread):
    if replicate == 0 or spread == 0:
        return chain.rest_positions
    stream = np.random.default_rng(stream_key(chain, seed, replicate, _INITIAL_STATE))
    return chain.rest_positions + spread * stream.standard_normal(chain.n_blocks)


def _initial_positions(chain, given):
    if given is None:
        return chain.rest_positions
    positions = np.asarray(given, dtype=float)
    if positions.shape != (chain.n_blocks,):
        raise InputError(
            f"initial_positions of shape {positions.shape}: "
            f"{chain.n_blocks} numbers are needed, one for each block"
        )
    if not (np.all(np.isfinite(positions)) and np.all(np.diff(positions, prepend=0.0) > 0)):
        raise InputError(
            f"initial_positions = {positions.tolist()}: must be finite, positive and increasing"
        )
    return positions


def _check_lengths(duration, transient, time_step, method, seed, replicate=0):
    if method not in METHODS:
        raise InputError(f"method = {method!r}: allowed are {', '.join(METHODS)}")
    for name, value in (("seed", seed), ("replicate", replicate)):
        if int(value) != value or value < 0:
            raise InputError(f"{name} = {value!r}: a whole number of 0 or greater is needed")
    if not 0 < time_step <= 0.1:
        raise InputError(f"time_step = {time_step:g}: must be greater than 0 and at most 0.1")
    if not (np.isfinite(duration) and duration > 0):
        raise InputError(f"duration = {duration:g}: must be finite and greater than 0")
    if not 0 <= transient < duration:
        raise InputError(
            f"transient = {transient:g}: must be at least 0 and less than duration = {duration:g}"
        )


def _check_tolerance(tolerance, method):
    if method not in TOLERANCES:
        raise InputError(
            f"tolerance = {tolerance:g}: method {method!r} has none, only {', '.join(TOLERANCES)}"
        )
    low, high = TOLERANCE_RANGE
    if not low <= tolerance <= high:
        raise InputError(
            f"tolerance = {tolerance:g}: must be at least {low:g} and at most {high:g}"
        )


def _moments_stride(time_step):
    """Steps between the samples behind r: about MOMENTS_INTERVAL."""
    return max(1, round(MOMENTS_INTERVAL / time_step))


def _stride(interval, time_step):
    steps = round(interval / time_step)
    if steps < 1 or abs(steps * time_step - interval) > 1e-9 * interval:
        raise InputError(
            f"sample_interval = {interval:g}: must be a multiple of time_step = {time_step:g}"
        )
    return steps
