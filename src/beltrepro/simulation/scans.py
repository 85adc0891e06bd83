"""What is measured of many chains without keeping samples."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from beltrepro.base import checks
from beltrepro.base.errors import InputError
from beltrepro.engine.integrator import Section
from beltrepro.model import ChainParameters
from beltrepro.model.energy import slow_unit
from beltrepro.observe.crossings import SectionVelocities
from beltrepro.observe.length import LengthMoments
from beltrepro.observe.slips import SlipActivity
from beltrepro.observe.sum_rule import ForwardSlip, mean_wall_tension, sum_rule_residual
from beltrepro.simulation.gathering import LOADING, gathered
from beltrepro.simulation.groups import Group, Report, integrator_of, moments_of, observe
from beltrepro.simulation.loading import LoadingWatch, warn_of_loading
from beltrepro.simulation.packed import packed
from beltrepro.simulation.results import SLIP_COLUMNS, Results
from beltrepro.simulation.setup import (
    Chains,
    PerChain,
    Setup,
    check_duration,
    check_lengths,
    section_positions,
    setup_of,
    warn,
    with_setup,
)

MOST_VALUES = 100_000  # of each chain at the section: they are kept in memory
LAMINAR_TIME = 200.0  # in units of sqrt(mass / stiffness): 30 periods of one block
_BY_LAW = f"{LAMINAR_TIME:g} sqrt(mass / stiffness)"
_BESIDE = 0.05  # share of the crossings outside all bins, from which on they are told
SETTLE_SHARE = 0.1  # of the duration, over which the final state is measured unless told otherwise


@with_setup
def scan(
    chains: Chains,
    *,
    duration: float,
    transient: float = 0.0,
    section_position: PerChain[float] | None = None,
    section_values: int = 500,
    section_bins: Sequence[float] | None = None,
    laminar_time: float | None = None,
    on_error: str = "raise",
    store: str | Path | None = None,
    progress: Report | None = None,
    **setup: Any,
) -> Results:
    """What Figs. 12 to 22 show of a point (N, u, sigma), for P chains.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        P chains of any mixture of sizes.
    duration, transient : float
        As in `simulate`, also where too few samples are left for r.
    section_position : float, or a sequence of P
        x_N of the section, model length (Fig. 12: 615). If not given, by the rule
        `beltrepro.model.section_position`.
    section_values : int
        Crossings of the section kept for each chain, at most 100 000.
    section_bins : sequence of B+1, optional
        Edges of bins of v_N, rising, model velocity: all crossings between them are counted by bin.
    laminar_time : float, optional
        Shortest slip of the last block that counts as a laminar phase, model time; if not given 200
        times sqrt(mass / stiffness) of each chain's heaviest block and softest spring.
    on_error : str
        What a run does that leaves the range of the model: "raise" ends all; "nan" gives its row
        NaN (counts 0, texts empty, a yes or no False) and the array error (P,) its line, empty for
        the others. A warning counts such rows; where no run is left the first error is raised.
    store : str or Path, optional
        A file, .h5, that keeps what is finished, also of a call that is interrupted; `Results.save`
        writes one too. What it has of these chains, whatever their order, is not computed again,
        and what it lacks is added, by several processes too. Another duration, transient, method,
        tolerance, seed or the like is refused, and a warning tells of rows of other code. Besides
        `scan`, `sweep`, `catalogue`, `classify`, `time_to_continuous_slip` and `lyapunov_spectrum`
        have it.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

    Returns
    -------
    Results
        Of the time after the transient, in model units, places and velocities from the wall on:

        - disorder_parameter, r (Eq. 4); mean_length, minimum_length, maximum_length of x_N
        - section_position; section_count, all downward crossings of x_N; section_velocity (P,
          section_values), v_N at the first of them, negative, NaN padded; with section_bins
          section_histogram (P, B), how many of all of them lie in each bin
        - slip_count (P, N) of the blocks, N that of the longest chain or 10
        - laminar_fraction, laminar_count; laminar_mean (NaN of none), laminar_longest, times; the
          fraction and the longest are NaN where no laminar phase fits into the time
        - of the whole run: energy_residual, sum_rule_residual as `Run` has them; mean_wall_tension,
          a force, positive where the wall is pulled; last_stick_time of the last block, NaN if it
          never came to stick

        `initial_state=results.final_states` goes on from its end.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    how = on_error, store, progress
    lengths = duration, transient
    measured = section_position, section_values, section_bins, laminar_time
    return scan_of(setup_of(chains, setup), lengths, *measured, *how)


def scan_of(
    made: Setup,
    lengths: tuple[float, float],
    section_position: PerChain[float] | None,
    section_values: int,
    section_bins: Sequence[float] | None,
    laminar_time: float | None,
    on_error: str,
    store: str | Path | None,
    progress: Report | None,
    going_on: bool = False,
) -> Results:
    """The scan of a setup, whose chains may go on from those of another (`gathered`)."""
    duration, transient = check_lengths(*lengths)
    section_values = checks.key("section_values", section_values)
    checks.within("section_values", section_values, le=MOST_VALUES)
    settings: dict[str, Any] = {"transient": transient, "section_values": section_values}
    if section_bins is not None:
        settings["section_bins"] = _edges(section_bins)
    sections = section_positions(section_position, made.cases)
    loading = LoadingWatch(made.cases, duration, transient)
    measure = partial(_scanned, sections, loading, **settings, laminar_time=laminar_time)
    settings["laminar_time"] = _as_setting(laminar_time)
    if isinstance(section_position, Real):
        settings["section_position"] = float(section_position)
    settings = {"duration": duration, **settings}
    settings |= {"also": sections, "ends": True, "going_on": going_on}
    results = gathered("scan", made, measure, progress, on_error, store, **settings)
    if LOADING not in results.of_runs:  # all have failed
        return results
    loading.noted = results.of_runs[LOADING]  # also of runs of earlier calls
    loading.warn()
    if section_position is not None and not results["section_count"].any():
        low, high = results["minimum_length"], results["maximum_length"]  # NaN of those that failed
        nearest = np.argmin(np.nan_to_num(np.maximum(low - sections, sections - high), nan=np.inf))
        runs = f"x_N runs from {low[nearest]:g} to {high[nearest]:g}"
        which = "" if low.size == 1 else " in the one that comes nearest"
        warn(f"no chain comes down through section_position: {runs}{which}")
    if section_bins is not None:
        count = results["section_count"]
        beside = count - results["section_histogram"].sum(axis=1, dtype=int) > _BESIDE * count
        if beside.any():
            many = f"{beside.sum()} of {len(count)} chains"
            warn(f"{many}: of the crossings more than {_BESIDE:.0%} lie outside section_bins")
    return results


def _scanned(
    sections: np.ndarray,
    loading: LoadingWatch,
    group: Group,
    *,
    transient: float,
    section_values: int,
    section_bins: tuple[float, ...] | None = None,
    laminar_time: float | None,
) -> dict[str, np.ndarray]:
    """What a scan measures of a group of W chains: arrays with first axis W."""
    n_blocks, levels, start = group.chain.n_blocks, sections[group.indices], group.start + transient
    begin = [case.state for case in group.cases]
    chains = integrator_of(group.cases, section=Section(n_blocks, levels))
    moments = LengthMoments(len(begin), start)
    belt_velocities = np.array([state.parameters.belt_velocity for state in begin])
    edges = np.array([0.0] if section_bins is None else section_bins)
    section = SectionVelocities(belt_velocities, section_values, edges, start)
    laminar_time = _laminar_time(laminar_time, group.chain)
    slips, forward = SlipActivity(begin, start, laminar_time), ForwardSlip(begin)
    loading.observe(group, chains, moments, section, slips, forward)
    end, more = chains.state(), max(0, SLIP_COLUMNS - n_blocks)
    return {
        **moments_of(moments, chains),
        "energy_residual": chains.energy_residual(),
        "mean_wall_tension": mean_wall_tension(begin, end),
        "sum_rule_residual": sum_rule_residual(begin, end, forward.way(end)),
        "section_position": levels,
        "section_count": section.count,
        "section_velocity": section.values,
        "slip_count": np.pad(slips.slip_count, ((0, 0), (0, more))),
        **slips.laminar(),
        "last_stick_time": slips.last_stick_time,
        **({} if section_bins is None else {"section_histogram": section.histogram}),
        LOADING: loading.noted[group.indices],
        **packed(end),
    }


def _edges(section_bins: Sequence[float]) -> tuple[float, ...]:
    """The edges of bins: numbers that rise."""
    edges = checks.series("section_bins", section_bins)
    if edges.size < 2 or not (np.isfinite(edges).all() and (np.diff(edges) > 0).all()):
        text = f"section_bins = {checks.shown(edges.tolist())}"
        raise InputError(f"{text}: at least two rising numbers, the edges of bins, are needed")
    return tuple(edges.tolist())


def _laminar_time(given: float | None, chain: ChainParameters) -> float:
    """The shortest laminar phase: as given, or by the law of a chain."""
    return LAMINAR_TIME * slow_unit(chain) if given is None else given


def _as_setting(laminar_time: Any) -> float | str:
    """It, or the rule, as settings have it."""
    return _BY_LAW if laminar_time is None else checks.not_negative("laminar_time", laminar_time)


@with_setup
def time_to_continuous_slip(
    chains: Chains,
    *,
    duration: float,
    settle_time: float | None = None,
    laminar_time: float | None = None,
    on_error: str = "raise",
    store: str | Path | None = None,
    progress: Report | None = None,
    **setup: Any,
) -> Results:
    """How long until the last block of each of P chains slips for good (inset of Fig. 12).

    That is the time of its last stick, if it then slips to the end of the run and for longer than
    `laminar_time`. A chain that has settled on an orbit with sticks, as many do, never comes to
    continuous slip: how long its motion is irregular, `time_to_orbit` tells.

    Parameters
    ----------
    chains : ChainParameters, sequence of them, Grid or Setup
        P chains; one with `replicate=range(200)` and an `initial_spread` begins in 200 slightly
        different states.
    duration : float
        As in `simulate`.
    settle_time : float, optional
        The end of each run over which its final state is measured, model time; a tenth of the
        duration if not given. Where fewer than 10 samples, one about every 0.1, fall into it, r and
        <x_N> are NaN, with a warning.
    laminar_time : float, optional
        Shortest slip of the last block that counts, as in `scan`.
    on_error, store : str, str or Path
        As in `scan`.
    progress, **setup : callable, keywords of `Setup`
        As in `simulate`.

    Returns
    -------
    Results
        lifetime, the time to continuous slip (the duration if it did not come), escaped, whether it
        came; final_disorder, final_mean_length, final_amplitude (range of x_N); final_stick_rate
        (P, N) sticks per model time, N that of the longest chain. Model units.

    Raises
    ------
    InputError, ModelStateError
        A value is not allowed, or a state left the range of the model.
    """
    duration = check_duration(duration)
    settle_time = SETTLE_SHARE * duration if settle_time is None else settle_time
    settle_time = checks.within("settle_time", settle_time, gt=0, le=duration)
    settings: dict[str, Any] = {"duration": duration, "settle_time": settle_time}
    made = setup_of(chains, setup)
    shortest = _as_setting(laminar_time)
    longest = max(_laminar_time(laminar_time, case.parameters) for case in made.cases)
    if duration <= longest:
        warn(f"duration = {duration:g}: no chain escapes in it whose laminar_time is {longest:g}")
    measure = partial(_until_slip, **settings, laminar_time=laminar_time)
    settings["laminar_time"] = shortest
    kind = "time to continuous slip"
    results = gathered(kind, made, measure, progress, on_error, store, ends=True, **settings)
    begun = duration - settle_time
    warn_of_loading(made.cases, results["final_disorder"], duration, begun, late="settle_time")
    return results


def _until_slip(
    group: Group, *, duration: float, settle_time: float, laminar_time: float | None
) -> dict[str, np.ndarray]:
    """When the W chains of a group come to continuous slip: arrays with first axis W."""
    start, settled = group.start, group.start + (duration - settle_time)
    chains, begin = integrator_of(group.cases), [case.state for case in group.cases]
    moments = LengthMoments(len(begin), settled)
    laminar_time = _laminar_time(laminar_time, group.chain)
    slips = SlipActivity(begin, settled, laminar_time)
    observe(chains, duration, [moments, slips], group.report)
    final = moments_of(moments, chains)
    # NaN (stuck at the end) compares false; without a stick on the way the lifetime is 0
    escaped = chains.time - slips.slipping_since > laminar_time
    last_stick = np.nan_to_num(slips.last_stick_time, nan=start)
    return {
        "lifetime": np.where(escaped, last_stick - start, duration),
        "escaped": escaped,
        "final_disorder": final["disorder_parameter"],
        "final_mean_length": final["mean_length"],
        "final_amplitude": final["maximum_length"] - final["minimum_length"],
        "final_stick_rate": slips.stick_count / settle_time,
        **packed(chains.state()),
    }
