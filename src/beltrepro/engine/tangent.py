"""Deviations from chains that `event` advances: the tangent dynamics of the hybrid motion.

A deviation (dx, dv) obeys the linearised equations of motion between events: dT = T'(D) dD, with
T' = 1 on the linear branch of a spring and c G on a curved one (`beltrepro.engine.taylor`). A stuck
block has dv = 0. Friction that depends on the velocity brakes by R'(v_r) dv, R' with the series of
eta - (K / v_w) w^2. At an event dv jumps:

- stick: dv = 0;
- slip: dv = a dF_ex / (dF_ex/dt), a the acceleration with which the slip starts;
- reversal: dv is multiplied by the ratio of the accelerations after and before.

With noise all random numbers are given, as functions of the time since the last rest of the whole
chain. docs/exponents.md derives all that.
"""

from typing import NamedTuple

import numpy as np

from beltrepro.engine.event import REVERSAL, SLIP, STICK, Hooks, stretch
from beltrepro.engine.event_integrator import EventIntegrator
from beltrepro.engine.law import braking, inverse_mass, pull_and_slope, stiffness
from beltrepro.engine.simd import LANES, fma, load, mask_bits, select, spread, square_root, store
from beltrepro.engine.taylor import LEVELS, at, force_order, polynomial
from beltrepro.engine.vector import inlined, maximum, minimum, zeros

# Of a step, times the fastest rate of change: the terms left out are below 2.5^20 / 20! = 4e-11,
# 4e-6 with noise. A motion that is not at rest has shorter steps.
_REACH = 2.5


class Deviations(NamedTuple):
    """K deviations of each of W chains, and scratch space for their series."""

    displacement: np.ndarray  # (K, N, W) dx
    velocity: np.ndarray  # (K, N, W) dv
    # of the instants at which the noise changes, since the last rest of the whole chain
    delay: np.ndarray  # (K, W)
    noise_force: np.ndarray  # (N, W) at the end of the last step, 0 while the chain rests
    position: np.ndarray  # N+1 columns of series, see `beltrepro.engine.taylor.at`: dX_k
    slope: np.ndarray  # N columns of series: T'(D)
    damping: np.ndarray  # the same: R'(v_r); none where blocks are alike


@inlined
def carry(order, lane, active, sliding, step, group, scratch, deviations):
    """Hook: carries the deviations of eight chains through their steps."""
    n_blocks = group.chains.direction.shape[0]
    noisy = mask_bits(load(group.noise_power, (lane,)) > 0.0) != 0
    if noisy:
        _delay_noise(lane, sliding, step, group, deviations)
    _find_slopes(order, n_blocks, group.varied, scratch.series, deviations)
    _find_damping(order, n_blocks, group.varied, scratch.series, deviations)
    left = step
    while True:
        # the series of a motion that is at rest, or nearly so, reaches further than theirs
        part = minimum(left, _reach(lane, group, deviations))
        for vector in range(deviations.displacement.shape[0]):
            _make_series(order, noisy, vector, lane, group, scratch.series, deviations)
            for block in range(n_blocks):
                place = (vector, block, lane)
                position, velocity = polynomial(order, deviations.position, block + 1, part)
                store(deviations.displacement, place, position)
                store(deviations.velocity, place, velocity)
        left = left - part
        if mask_bits(left > 0.0) == 0:
            break
        for block in range(n_blocks):
            if mask_bits(load(scratch.series.rate, (block * LANES,)) != 0.0) != 0:
                _shift(order, deviations.slope, block, part)
            if group.varied is not None:
                _shift(order, deviations.damping, block, part)


@inlined
def _reach(lane, group, deviations):
    """Step in which the series of all deviations converge, by the fastest change there can be."""
    fastest, following = spread(0.0), spread(0.0)
    for block in range(group.chains.direction.shape[0] - 1, -1, -1):
        stiff = load(deviations.slope, (at(0, block),))
        inverse = inverse_mass(group.varied, block)
        # squares of frequencies are below the largest sum of a row of their matrix (Gershgorin)
        rate = square_root(2.0 * (stiff + following) * inverse)
        if group.varied is not None:
            rate = rate + abs(load(deviations.damping, (at(0, block),))) * inverse
        slipping = load(group.chains.direction, (block, lane)) != 0.0
        fastest = maximum(fastest, select(slipping, rate, 0.0))
        following = stiff
    return _REACH / fastest


@inlined
def _shift(order, coefficients, column, step):
    """The polynomials of a column about an instant that is a step later."""
    for first in range(force_order(order)):
        for k in range(force_order(order) - 1, first - 1, -1):
            place = (at(k, column),)
            higher = load(coefficients, (at(k + 1, column),))
            store(coefficients, place, fma(higher, step, load(coefficients, place)))


@inlined
def _delay_noise(lane, sliding, step, group, deviations):
    """What the change of the force of the noise since the last step does to the velocities."""
    chains = group.chains
    for block in range(chains.direction.shape[0]):
        place = (block, lane)
        level = load(chains.noise_force, (0, block, lane))
        start = level - load(chains.noise_force, (1, block, lane)) * step
        change = load(deviations.noise_force, place) - start
        change = select(load(chains.direction, place) != 0.0, change, 0.0)
        change = change * inverse_mass(group.varied, block)
        store(deviations.noise_force, place, select(sliding, level, 0.0))
        for vector in range(deviations.delay.shape[0]):
            velocity = load(deviations.velocity, (vector, block, lane))
            delay = load(deviations.delay, (vector, lane))
            store(deviations.velocity, (vector, block, lane), fma(change, delay, velocity))


@inlined
def _find_slopes(order, n_blocks, varied, series, deviations):
    """Series of T'(D) of all springs: 1 on the linear branch, c G on a curved one."""
    for spring in range(n_blocks):
        linear = stiffness(varied, spring)
        rate = load(series.rate, (spring * LANES,))
        curved = rate != 0.0
        first = rate * load(series.growth, (at(0, spring),))
        store(deviations.slope, (at(0, spring),), select(curved, first, linear))
        if mask_bits(curved) != 0:
            for k in range(1, force_order(order) + 1):
                grown = rate * load(series.growth, (at(k, spring),))
                store(deviations.slope, (at(k, spring),), select(curved, grown, 0.0))


@inlined
def _find_damping(order, n_blocks, varied, series, deviations):
    """Series of R'(v_r) of all blocks."""
    if varied is None:
        return
    for block in range(n_blocks):
        falling = varied.kinetic_friction[block] * varied.weakening
        for k in range(force_order(order) + 1):
            square = spread(0.0)
            for j in range(k + 1):
                one = load(series.weakening, (at(j, block),))
                square = fma(one, load(series.weakening, (at(k - j, block),)), square)
            damping = -falling * square
            if k == 0:
                damping = damping + varied.viscosity
            store(deviations.damping, (at(k, block),), damping)


@inlined
def _damped(k, block, pull, varied, deviations):
    """Coefficient k of the acceleration of a deviation that springs pull."""
    if varied is None:
        return pull
    for j in range(k + 1):
        speed = (j + 1.0) * load(deviations.position, (at(j + 1, block + 1),))
        pull = fma(-load(deviations.damping, (at(k - j, block),)), speed, pull)
    return pull * varied.inverse_mass[block]


@inlined
def _make_series(order, noisy, vector, lane, group, series, deviations):
    """Series of one deviation of eight chains about now."""
    chains = group.chains
    n_blocks = chains.direction.shape[0]
    position = deviations.position
    for block in range(n_blocks):
        place = (vector, block, lane)
        store(position, (at(0, block + 1),), load(deviations.displacement, place))
        store(position, (at(1, block + 1),), load(deviations.velocity, place))
    for k in range(force_order(order) + 1):
        weight = 1.0 / ((k + 1.0) * (k + 2.0))
        tension_before = spread(0.0)
        for spring in range(n_blocks + 1):
            tension = spread(0.0)
            if spring < n_blocks:
                tension = _tension(k, spring, series, deviations)
            if spring > 0:
                slipping = load(chains.direction, (spring - 1, lane)) != 0.0
                pull = tension - tension_before
                pull = _damped(k, spring - 1, pull, group.varied, deviations)
                pull = pull * weight
                store(position, (at(k + 2, spring),), select(slipping, pull, 0.0))
            tension_before = tension
        if noisy and k == 0:
            _add_noise(vector, lane, group, deviations)


@inlined
def _add_noise(vector, lane, group, deviations):
    """The part of the noise in the coefficients of order 2, on which the others depend."""
    chains = group.chains
    delay = load(deviations.delay, (vector, lane))
    for block in range(chains.direction.shape[0]):
        slope = load(chains.noise_force, (1, block, lane))
        slope = select(load(chains.direction, (block, lane)) != 0.0, slope, 0.0)
        slope = slope * inverse_mass(group.varied, block)
        column = (at(2, block + 1),)
        store(deviations.position, column, load(deviations.position, column) - 0.5 * slope * delay)


@inlined
def _tension(k, spring, series, deviations):
    """Coefficient k of dT."""
    position, slope = deviations.position, deviations.slope
    newest = load(position, (at(k, spring + 1),)) - load(position, (at(k, spring),))
    total = load(slope, (at(0, spring),)) * newest
    if mask_bits(load(series.rate, (spring * LANES,)) != 0.0) != 0:
        for m in range(k):
            change = load(position, (at(m, spring + 1),)) - load(position, (at(m, spring),))
            total = fma(load(slope, (at(k - m, spring),)), change, total)
    return total


@inlined
def apply_jumps(kind, block, lane, i, group, scratch, deviations):
    """Hook: what the event of one chain does to its deviations."""
    chain = lane + i
    velocity = deviations.velocity
    if kind == STICK:
        for vector in range(velocity.shape[0]):
            velocity[vector, block, chain] = 0.0
    elif kind in (SLIP, REVERSAL):
        external, rate, slope_before, following = _pull(block, chain, group)
        way = group.chains.direction[block, chain]
        push = external
        begins = group.chains.cell[chain] <= 0.0  # the noise, with the slip that ends a rest
        if not begins:
            push += group.chains.noise_force[0, block, chain]
        kinetic = way * braking(group.law, group.varied, block, 0.0)
        after = push - kinetic
        starts = after * inverse_mass(group.varied, block)
        for vector in range(velocity.shape[0]):
            if kind == REVERSAL:
                velocity[vector, block, chain] *= after / (push + kinetic)
            else:
                change = _pull_change(vector, block, chain, slope_before, following, deviations)
                velocity[vector, block, chain] = starts * change / rate
                if begins and group.noise_power[chain] > 0.0:
                    deviations.delay[vector, chain] = -change / rate


@inlined
def _pull(block, chain, group):
    """F_ex on a block of one chain, dF_ex/dt, and the slopes of the springs before and after it."""
    chains = group.chains
    speed = chains.velocity[block, chain]
    speed_before = -group.belt_velocity[chain]
    if block > 0:
        speed_before = chains.velocity[block - 1, chain]
    deformation = stretch(block, chain, chains.displacement)
    pull, slope_before = pull_and_slope(block, deformation, group.law, group.varied)
    external, rate, following = -pull, -slope_before * (speed - speed_before), 0.0
    if block < chains.direction.shape[0] - 1:
        deformation = stretch(block + 1, chain, chains.displacement)
        pull, following = pull_and_slope(block + 1, deformation, group.law, group.varied)
        external += pull
        rate += following * (chains.velocity[block + 1, chain] - speed)
    return external, rate, slope_before, following


@inlined
def _pull_change(vector, block, chain, slope_before, following, deviations):
    """dF_ex on a block."""
    displacement = deviations.displacement[vector]
    change = -slope_before * stretch(block, chain, displacement)
    if block < displacement.shape[0] - 1:
        change += following * stretch(block + 1, chain, displacement)
    return change


HOOKS = Hooks(moved=carry, event_applied=apply_jumps)


class TangentIntegrator(EventIntegrator):
    """Chains integrated by `event`, each with K deviations that follow the linearised motion.

    Parameters as for `EventIntegrator`, and n_vectors : K. The deviations are zero to begin with.
    """

    _hooks = HOOKS

    def __init__(self, states, *, n_vectors: int, **settings):
        super().__init__(states, **settings)
        self._noisy = bool(np.any(self._noise > 0))
        n_blocks, lanes = self._chains.displacement.shape
        self._companion = Deviations(
            displacement=zeros((n_vectors, n_blocks, lanes)),
            velocity=zeros((n_vectors, n_blocks, lanes)),
            delay=zeros((n_vectors, lanes)),
            noise_force=zeros((n_blocks, lanes)),
            position=zeros((n_blocks + 1) * LEVELS * LANES),
            slope=zeros(n_blocks * LEVELS * LANES),
            damping=zeros(n_blocks * LEVELS * LANES * (self._varied is not None)),
        )

    def deviations(self) -> np.ndarray:
        """Deviations (W, D, K) now: of the N positions, then of the N velocities.

        With noise a last row has the delay of the noise: D is 2N, or 2N+1 with noise.
        """
        now = self._companion
        rows = [now.displacement, now.velocity, now.delay[:, None]][: 3 if self._noisy else 2]
        return np.concatenate(rows, axis=1)[..., : self._width].transpose(2, 1, 0)

    def flow(self) -> np.ndarray:
        """The deviation (W, D) of the chain a moment later from itself, over that moment.

        Noise that goes on with the chain is earlier by the moment: a delay of -1.
        """
        rates = self.accelerations(noise=self._of_chains(self._chains.noise_force[0]))
        delay = np.where(self._noise[: self._width, None] > 0.0, -1.0, 0.0)
        rows = [self.velocities(), rates, delay]
        return np.concatenate(rows[: 3 if self._noisy else 2], axis=1)

    def set_deviations(self, values: np.ndarray) -> None:
        """Set the deviations (W, D, K); a stuck block has no deviation of its velocity."""
        columns = values[self._source].transpose(2, 1, 0)
        n_blocks, now = self.n_blocks, self._companion
        stuck = self._chains.direction == 0
        now.displacement[...] = columns[:, :n_blocks]
        now.velocity[...] = np.where(stuck, 0.0, columns[:, n_blocks : 2 * n_blocks])
        if self._noisy:
            now.delay[...] = columns[:, -1]
