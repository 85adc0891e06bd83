"""Deviation vectors of a group of chains: how they start, grow and are kept apart."""

from collections.abc import Sequence

import numpy as np

from beltrepro.base import names
from beltrepro.base.errors import InputError
from beltrepro.engine import tangent
from beltrepro.engine.integrator import Sampling, Section
from beltrepro.engine.law import inverse_mass
from beltrepro.engine.simd import load, select, store
from beltrepro.engine.state import ChainState
from beltrepro.engine.tangent import TangentIntegrator
from beltrepro.engine.vector import inlined
from beltrepro.model.energy import as_lengths, slow_unit, times_as_fast
from beltrepro.simulation.groups import Report
from beltrepro.simulation.setup import Case

METHOD = "event"  # the only one with a tangent dynamics, that of the exact motion
REST = "rest"  # the clock of the noise, see INTEGRATORS
# Model time between two orthonormalisations in the paper's chain; e-folding takes 60 and more, and
# a vector that shrinks by e^36 against another before them is lost.
INTERVAL = 20.0
NO_SAMPLES = Sampling(1, 10 * INTERVAL)
_STEADY = 1e-6  # share of the belt velocity: a chain with less flow in the end is in steady slip
_BATCHES = 32  # of the growth of one run, whose scatter is its error
# Times the error from the ends: that of batches, about 1.2 of it where rates are independent, is so
# small only where all batches begin and end at one phase of a motion that repeats itself.
_IN_PHASE = 0.25
_SLOPE = 1.2  # variance of a slope of a random walk by least squares over that by its ends


def check_method(cases: Sequence[Case], noise_clock: str = REST) -> None:
    """That all cases are simulated by a method with a tangent dynamics, by a known clock."""
    for case in cases:
        if case.method != METHOD:
            raise InputError(f"method = {case.method!r}: only {METHOD!r} has a tangent dynamics")
    names.one_of("noise_clock", noise_clock, INTEGRATORS)


def part(progress: Report | None, low: float, high: float) -> Report:
    """Report of a part of the work, from its share `low` to its share `high`."""
    if progress is None:
        return lambda done: None
    return lambda done: progress(low * (1 - done) + high * done)


# What "the same noise" means for a second chain: `event` begins the noise anew with the slip that
# ends a rest of the whole chain. If the second chain ends its rest later, its noise is later too:
# `TangentIntegrator` carries that delay. By the clock of the laboratory the noise stays where it is
# in time, and only its begin is later.


@inlined
def _hold_noise(order, lane, active, sliding, group, scratch, deviations):
    """Hook: after a rest the second chain misses the noise until its own slip, and no more."""
    chains = group.chains
    begun = active & sliding
    for vector in range(deviations.delay.shape[0]):
        delay = select(begun, load(deviations.delay, (vector, lane)), 0.0)
        for block in range(chains.direction.shape[0]):
            slipping = load(chains.direction, (block, lane)) != 0.0
            force = select(slipping, load(chains.noise_force, (0, block, lane)), 0.0)
            force = force * inverse_mass(group.varied, block)
            place = (vector, block, lane)
            store(deviations.velocity, place, load(deviations.velocity, place) - force * delay)
        kept = select(begun, 0.0, load(deviations.delay, (vector, lane)))
        store(deviations.delay, (vector, lane), kept)


class LaboratoryIntegrator(TangentIntegrator):
    """Chains with deviations under noise that is the same at the same time."""

    _hooks = tangent.HOOKS._replace(series_made=_hold_noise)

    def flow(self) -> np.ndarray:
        """As without noise; with it a shift of time leads to no motion of the same noise: 0."""
        return np.where(self._noise[: self._width, None] > 0.0, 0.0, super().flow())


INTEGRATORS = {REST: TangentIntegrator, "laboratory": LaboratoryIntegrator}


def with_vectors(
    states: Sequence[ChainState],
    case: Case,
    n_vectors: int,
    sampling: Sampling = NO_SAMPLES,
    section: Section | None = None,
    noise_clock: str = REST,
    across: bool = False,
) -> TangentIntegrator:
    """Chains with random orthonormal vectors, all the same, by the means of one case.

    across : whether the first of them is there once more, as the one that `grow` keeps across the
    flow.
    """
    chains = INTEGRATORS[noise_clock](
        states,
        n_vectors=n_vectors + across,
        sampling=sampling,
        sampled_blocks=1,
        section=section,
        **case.numerics,
    )
    vectors, rows = chains.deviations(), 2 * chains.n_blocks
    random = np.random.default_rng(chains.n_blocks).standard_normal((rows, n_vectors))
    directions = np.linalg.qr(random).Q
    vectors[:, :rows] = np.hstack([directions, directions[:, : int(across)]])
    chains.set_deviations(vectors / _factors(chains))
    return chains


def _factors(chains: TangentIntegrator) -> np.ndarray:
    """Factors (D, 1) of the rows of deviations, which may have a delay."""
    chain = chains.parameters[0]
    delay = [1 / slow_unit(chain)] * (chains.deviations().shape[1] - 2 * chains.n_blocks)
    return np.concatenate([as_lengths(chain), delay])[:, None]


def intervals_in(length: float) -> int:
    """Number of intervals in a time, of the paper's chain."""
    return max(1, round(length / INTERVAL))


def grow(
    chains: TangentIntegrator,
    length: float,
    observers: Sequence,
    report: Report,
    across: bool = False,
) -> np.ndarray:
    """Rates of growth (W, T, K) in T intervals, after which vectors are made orthonormal.

    across : whether the last vector is not, but is kept across the flow: what is left of a
    deviation if a shift of time does not count, and grows by the largest nontrivial exponent.
    """
    begin, factors = chains.time, _factors(chains)
    count = intervals_in(length) * times_as_fast(chains.parameters[0])
    growth: list[np.ndarray] = []
    for number in range(1, count + 1):
        for chunk in chains.advance(begin + number * length / count):
            for observer in observers:
                observer.observe(chunk)
        moved = factors * chains.deviations()
        directions, triangle = np.linalg.qr(moved[..., : moved.shape[2] - across])
        stretch = np.abs(np.diagonal(triangle, axis1=1, axis2=2))
        if across:
            rest = _across(moved[..., -1], factors[:, 0] * chains.flow())
            size = np.linalg.norm(rest, axis=1, keepdims=True)
            stretch = np.concatenate([stretch, size], axis=1)
            rest = rest / np.maximum(size, np.finfo(float).tiny)
            directions = np.concatenate([directions, rest[..., None]], axis=2)
        chains.set_deviations(directions / factors)
        growth.append(np.log(np.maximum(stretch, np.finfo(float).tiny)))
        report(number / count)
    rates = np.stack(growth, axis=1) * (count / length)
    if across:  # where nothing moves in the end, or nothing is trivial, the first vector serves
        velocities = np.array([chain.belt_velocity for chain in chains.parameters])
        steady = np.linalg.norm(chains.flow(), axis=1) <= _STEADY * velocities
        rates[steady, :, -1] = rates[steady, :, 0]
    # in this order, so that sums over intervals round the same way for any number of chains
    return np.ascontiguousarray(rates)


def _across(vectors: np.ndarray, flow: np.ndarray) -> np.ndarray:
    """What vectors (W, D) have across the flow; all of them where there is none."""
    size = np.linalg.norm(flow, axis=1, keepdims=True)
    along = flow / np.where(size > 0.0, size, np.inf)
    return vectors - along * np.sum(along * vectors, axis=1, keepdims=True)


def none_across(chains: TangentIntegrator, most_stuck: np.ndarray) -> np.ndarray:
    """Whether sticks have erased (W,) all that is across the flow: one block has but its phase."""
    return 2 * chains.n_blocks - most_stuck <= chains.flow().any(axis=1)


def slopes(growth: np.ndarray) -> np.ndarray:
    """Exponents (P, K): slopes of least-squares lines through the sums of growth rates (P, T, K).

    The mean would be the slope between the two ends, which the phase of the motion there decides.
    """
    number = np.arange(1.0, growth.shape[1] + 1)
    weights = number * number[::-1]
    return np.einsum("t,ptk->pk", weights / weights.sum(), growth)


def standard_errors(growth: np.ndarray) -> np.ndarray:
    """Standard errors (P, K) of `slopes`: NaN of one interval, 0 where that is minus infinity."""
    # from the scatter of batches: successive rates are correlated, means of batches hardly
    batches = min(_BATCHES, growth.shape[1])
    if batches < 2:
        return np.full((growth.shape[0], growth.shape[2]), np.nan)
    means = np.stack([part.mean(axis=1) for part in np.array_split(_finite(growth), batches, 1)])
    errors = means.std(axis=0, ddof=1) * np.sqrt(_SLOPE / batches)
    ends = end_errors(growth)
    return np.where(errors < _IN_PHASE * ends, ends, errors)


def end_errors(growth: np.ndarray) -> np.ndarray:
    """Standard errors (P, K) of `slopes` from the scatter about the lines alone."""
    # those of a motion that repeats itself, whose vectors grow and shrink in turn: runs of it that
    # begin at one phase agree in all of this error
    finite, count = _finite(growth), growth.shape[1]
    about = np.cumsum(finite - slopes(finite)[:, None], axis=1).std(axis=1)
    return about * np.sqrt(12 / count) / count


def _finite(growth: np.ndarray) -> np.ndarray:
    return np.where(np.isneginf(growth), 0.0, growth)
