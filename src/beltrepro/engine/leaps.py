"""The paper's scheme (Appendix): without noise many steps at a leap, else step for step.

In the frame of the belt a stuck block has exactly zero relative velocity. With the slip step
w(t) = x(t) - x(t-dt) - u dt the printed formulas read

    w(t+dt) = w(t) + a(t) dt^2,                               x(t+dt) = x(t) + u dt + w(t+dt)
    v_r(t+dt) dt = w(t+dt) + 5/6 a(t) dt^2 - 1/3 a(t-dt) dt^2

which rounds better than 2x(t) - x(t-dt) and is the same scheme.

Between two turns and on one branch of every spring the scheme
x(t+dt) - 2 x(t) + x(t-dt) = dt^2 a(x(t)) has smooth solutions, whose Taylor series are known:
y = x + dt^2/12 a(x) obeys y'' = a(x) up to dt^4/240 a'''' (Numerov's transformation). One pass of
the loop makes the series of eight chains, finds for how many whole steps no turn can happen and no
spring changes its branch, and goes there at once. Where a turn may be due the next step is taken
literally. So is every step while a spring is too stiff; and, by a kernel of its own, every step of
a chain with noise, of blocks that differ or with friction that depends on the velocity
(docs/integrators.md).
"""

import math
from typing import NamedTuple

import numpy as np

from beltrepro.engine.candidates import (
    Candidates,
    find_candidates,
    first_events,
    may_pass,
    new_candidates,
    taylor_step,
)
from beltrepro.engine.law import (
    Law,
    Varied,
    braking,
    expand_spring,
    inverse_mass,
    kinetic_friction,
    mean_threshold,
    next_direction,
    rest_length,
    stiffness,
    tension,
)
from beltrepro.engine.noise import normal_pairs_where
from beltrepro.engine.records import (
    CONTACT,
    CROSSINGS_AT_ONCE,
    DONE,
    full_buffer,
    record_event,
    write_samples,
)
from beltrepro.engine.simd import (
    LANES,
    extract,
    fma,
    lane_numbers,
    load,
    lowest_lane,
    mask_bits,
    select,
    spread,
    store,
    to_float,
)
from beltrepro.engine.taylor import (
    ORDER,
    WALL,
    Series,
    at,
    evaluate_one,
    extend_pair,
    force_order,
    integral,
    new_series,
    polynomial,
    push_position,
    store_pull,
    value_and_slope,
)
from beltrepro.engine.vector import inlined, kernel, maximum, minimum, separate_arrays, zeros

_RESOLUTION = 1e-15  # share of a leap by which the instant of an event may be missed
# A turn due less than this share of a step after the end of a step may be due there: the curve
# leaves out dt^4, and the scheme looks at positions that are rounded.
_DOUBT = 1e-3
_NEAREST = 6755399441055744.0  # 1.5 * 2^52: adding it rounds to whole numbers


class SchemeChains(NamedTuple):
    """State of W chains, W a multiple of 8; positions are displacements from the rest positions."""

    steps_done: np.ndarray  # (W,) steps since the start of the span, whole numbers
    displacement: np.ndarray  # (N, W)
    slip_step: np.ndarray  # (N, W) w
    acceleration: np.ndarray  # (N, W) a(t-dt) dt^2
    velocity: np.ndarray  # (N, W) v_r dt
    direction: np.ndarray  # (N, W) of the slip, 0: stuck
    threshold: np.ndarray  # (N, W) F_st
    branch_changed: np.ndarray  # (N, W) zeros: every leap finds the branches anew
    dissipated: np.ndarray  # (N, W) friction force times slip since t = 0
    wall_impulse: np.ndarray  # (W,) sum over steps of the first spring's pull, times dt


class Noise(NamedTuple):
    """What makes the friction of W chains random."""

    sigma: np.ndarray  # (W,)
    streams: np.ndarray  # (4, W)
    deviates: np.ndarray  # (8 (N + N % 2),) of eight chains in the step


class SchemeGroup(NamedTuple):
    """Chains of one law with all that moves them; leaps are for those with None of two."""

    law: Law
    varied: Varied | None
    belt_velocity: np.ndarray  # (W,)
    time_step: float  # dt
    log_tolerance: float  # to the base 2, of the last terms of the series of F_ex at its end
    stiffest: float  # slope of a tension from which on no leaps are taken
    chains: SchemeChains
    noise: Noise | None


class SchemeScratch(NamedTuple):
    """What a pass of the loop makes of eight chains."""

    series: Series
    slopes: np.ndarray  # (8 N,) of the tensions over the deformations
    pulls: np.ndarray  # (8 N,) tensions in a single step
    candidates: Candidates


def new_scratch(n_blocks: int) -> SchemeScratch:
    """Room for eight chains of N blocks."""
    slopes, pulls = (zeros(n_blocks * LANES) for _ in range(2))
    return SchemeScratch(new_series(n_blocks), slopes, pulls, new_candidates(n_blocks))


@inlined
def _scheme_velocity(slip_step, acceleration, before):
    """v_r dt after a step, from w after it, and a dt^2 at its start and one step before."""
    return fma(acceleration, 5.0 / 6.0, fma(before, -1.0 / 3.0, slip_step))


@inlined
def _round_down(x):
    """Greatest whole number up to x, |x| < 2^51."""
    nearest = (x + _NEAREST) - _NEAREST
    return nearest - select(nearest > x, spread(1.0), 0.0)


# --- the series ---


@inlined
def _make_series(lane, group, scratch):
    """Series of eight chains about their step: of y up to level 9, the same of x beyond."""
    square = group.time_step * group.time_step
    kinetic = kinetic_friction(group.law)
    _start_springs(lane, group.law, group.chains, scratch)
    _start_velocities(lane, square, 1.0 / group.time_step, kinetic, group.chains, scratch)
    _refine_velocities(lane, square, group.chains, scratch)
    _extend_series(square * (1.0 / 12.0), lane, group.chains.direction, scratch)


@inlined
def _start_springs(lane, law, chains, scratch):
    """Level 0 of all series, and the branches of the springs."""
    series = scratch.series
    n_blocks = chains.direction.shape[0]
    place_before = spread(0.0)
    tension_before = spread(0.0)
    store(series.position, (at(0, WALL),), place_before)
    for spring in range(n_blocks):
        place = load(chains.displacement, (spring, lane))
        store(series.position, (at(0, spring + 1),), place)
        change = place - place_before
        place_before = place
        pull, slope, rate, softness = expand_spring(change, law)
        store(series.rate, (spring * LANES,), rate)
        store(scratch.slopes, (spring * LANES,), slope)
        store(series.growth, (at(0, spring),), select(rate != 0.0, slope * softness, 0.0))
        store_pull(0, spring, pull, tension_before, series)
        tension_before = pull
    store(series.force, (at(0, n_blocks - 1),), -tension_before)


@inlined
def _start_velocities(lane, square, inverse_step, kinetic, chains, scratch):
    """Level 2 of y, and level 1 from the central difference.

    The scheme's positions at t and t +- dt give the derivative at t: their central difference is
    dt x' + dt^3/6 x''', where x''' is the coefficient F_1.
    """
    position, force = scratch.series.position, scratch.series.force
    for block in range(chains.direction.shape[0]):
        heading = load(chains.direction, (block, lane))
        slipping = heading != 0.0
        acceleration = load(force, (at(0, block),)) - heading * kinetic
        difference = fma(acceleration, 0.5 * square, load(chains.slip_step, (block, lane)))
        speed = select(slipping, difference * inverse_step, 0.0)
        store(position, (at(1, block + 1),), speed)
        store(position, (at(2, block + 1),), select(slipping, 0.5 * acceleration, 0.0))
    _start_rates(lane, chains, scratch)


@inlined
def _refine_velocities(lane, square, chains, scratch):
    """Level 1 without the third derivative."""
    position = scratch.series.position
    for block in range(chains.direction.shape[0]):
        speed = load(position, (at(1, block + 1),))
        jerk = load(position, (at(3, block + 1),))
        store(position, (at(1, block + 1),), fma(jerk, -square, speed))
    _start_rates(lane, chains, scratch)


@inlined
def _start_rates(lane, chains, scratch):
    """Level 1 of the springs from that of the positions, and level 3 of y."""
    series = scratch.series
    n_blocks = chains.direction.shape[0]
    speed_before = load(series.position, (at(1, WALL),))
    tension_before = spread(0.0)
    for spring in range(n_blocks):
        speed = load(series.position, (at(1, spring + 1),))
        change = speed - speed_before
        speed_before = speed
        pull = load(scratch.slopes, (spring * LANES,)) * change
        newest = load(series.rate, (spring * LANES,)) * change
        store(series.stretching, (at(1, spring),), newest)
        store(series.growth, (at(1, spring),), pull)
        store_pull(1, spring, pull, tension_before, series)
        tension_before = pull
    store(series.force, (at(1, n_blocks - 1),), -tension_before)
    for block in range(n_blocks):
        slipping = load(chains.direction, (block, lane)) != 0.0
        jerk = load(series.force, (at(1, block),)) * (1.0 / 6.0)
        store(series.position, (at(3, block + 1),), select(slipping, jerk, 0.0))


@inlined
def _extend_series(share, lane, direction, scratch):
    """All levels from 2 on of the forces and of the positions."""
    series = scratch.series
    extend_pair(2, None, direction, lane, series)
    _correct(2, share, lane, direction, scratch)
    extend_pair(4, None, direction, lane, series)
    _correct(4, share, lane, direction, scratch)
    extend_pair(6, None, direction, lane, series)
    _correct(6, share, lane, direction, scratch)
    extend_pair(8, None, direction, lane, series)
    _correct(8, share, lane, direction, scratch)
    # terms from here on are 1e-5 of the first at the end of a leap, corrections 1e-7 of them
    extend_pair(10, None, direction, lane, series)
    extend_pair(12, None, direction, lane, series)
    extend_pair(14, None, direction, lane, series)
    extend_pair(16, None, direction, lane, series)


@inlined
def _correct(k, share, lane, direction, scratch):
    """From y to x in the levels k and k+1, k even: x = y - share a, share = dt^2/12."""
    position, force = scratch.series.position, scratch.series.force
    wall_pull = scratch.series.wall_pull
    n_blocks = direction.shape[0]
    shift_before, next_before = spread(0.0), spread(0.0)
    tension_before, rise_before = spread(0.0), spread(0.0)
    for spring in range(n_blocks + 1):
        tension, rise = spread(0.0), spread(0.0)
        if spring < n_blocks:
            slipping = load(direction, (spring, lane)) != 0.0
            weight = select(slipping, spread(-share), 0.0)
            shift = weight * load(force, (at(k, spring),))
            following = weight * load(force, (at(k + 1, spring),))
            _add(position, at(k, spring + 1), shift)
            _add(position, at(k + 1, spring + 1), following)
            tension, rise = _correct_spring(
                k, spring, shift - shift_before, following - next_before, scratch
            )
            shift_before, next_before = shift, following
        if spring == 0:
            _add(wall_pull, at(k, 0), tension)
            _add(wall_pull, at(k + 1, 0), rise)
        else:
            block = spring - 1
            slipping = load(direction, (block, lane)) != 0.0
            pull = load(force, (at(k, block),)) + (tension - tension_before)
            pull_rise = load(force, (at(k + 1, block),)) + (rise - rise_before)
            store(force, (at(k, block),), pull)
            store(force, (at(k + 1, block),), pull_rise)
            push_position(k, spring, slipping, pull, scratch.series)
            push_position(k + 1, spring, slipping, pull_rise, scratch.series)
        tension_before, rise_before = tension, rise


@inlined
def _correct_spring(k, spring, change, change_next, scratch):
    """Levels k and k+1 of a spring whose deformation is corrected; returns those of its tension."""
    series = scratch.series
    rate = load(series.rate, (spring * LANES,))
    slope = load(scratch.slopes, (spring * LANES,))
    newest = rate * float(k) * change
    tension = slope * change
    first = load(series.stretching, (at(1, spring),))
    rise = fma(first, tension, newest * load(series.growth, (at(1, spring),)))
    rise = fma(rise, 1.0 / (k + 1.0), slope * change_next)
    _add(series.stretching, at(k, spring), newest)
    _add(series.stretching, at(k + 1, spring), rate * (k + 1.0) * change_next)
    _add(series.growth, at(k, spring), tension)
    _add(series.growth, at(k + 1, spring), rise)
    return tension, rise


@inlined
def _add(array, place, value):
    store(array, (place,), load(array, (place,)) + value)


# --- how far to go ---


@inlined
def _literal_due(lane, group, scratch):
    """Lanes whose next step is taken literally.

    There the rules may change the direction of a block, or a spring is so stiff that leaps would
    differ from steps.
    """
    chains = group.chains
    due = spread(0.0) > 1.0
    for block in range(chains.direction.shape[0]):
        heading = load(chains.direction, (block, lane))
        turned = heading * load(chains.velocity, (block, lane)) <= 0.0
        external = load(scratch.series.force, (at(0, block),))
        beyond = abs(external) > group.law.static_friction
        due = due | (turned & ((heading != 0.0) | beyond))
        due = due | (load(scratch.slopes, (block * LANES,)) > group.stiffest)
    return due


@inlined
def _choose_leap(lane, leaping, remaining, group, scratch):
    """Whole steps that the series serve; chains with a turn at their end, or a contact."""
    inverse_step = 1.0 / group.time_step
    n_blocks = group.chains.direction.shape[0]
    reach = taylor_step(ORDER, group.log_tolerance, None, scratch.series) * inverse_step
    # one step at least, or the chain would stand still
    reach = maximum(_round_down(minimum(reach, remaining)), 1.0)
    reach = select(leaping, reach, 0.0)
    longest = reach * group.time_step
    n_columns = find_candidates(ORDER, True, lane, longest, leaping, None, group, scratch)
    instant, source = first_events(ORDER, _RESOLUTION, n_columns, longest, scratch.candidates)
    turning = leaping & (source >= 0) & (source < n_blocks)
    ending = leaping & (source >= n_blocks)
    # A leap ends at the first whole step after the root, where the scheme notices it; a turn is
    # then left to a literal step, which may come one too early. Without a source the search has
    # ended early: the last whole step before the place reached.
    count = instant * inverse_step
    before = maximum(_round_down(count), 1.0)
    after = -_round_down(-count)
    leap = select(instant < longest, before, reach)
    leap = select(ending, maximum(after, 1.0), leap)
    leap = select(turning, maximum(-_round_down(_DOUBT - count), 0.0), leap)
    return minimum(leap, reach), turning, leaping & (source >= 2 * n_blocks)


# --- there at once ---


@inlined
def _leap(lane, leaping, leap, group, scratch):
    """Write the state after a leap: the scheme's variables of the smooth solution."""
    chains, series, dt = group.chains, scratch.series, group.time_step
    step = leap * dt
    belt = load(group.belt_velocity, (lane,))
    moved = leaping & (leap > 0.0)
    # the scheme sums the wall's pull over steps instead of integrating it: Euler and Maclaurin's
    # formula makes the one of the other
    impulse = integral(force_order(ORDER), series.wall_pull, 0, step)
    pull, rise = polynomial(ORDER, series.wall_pull, 0, step)
    impulse = impulse - 0.5 * dt * (pull - load(series.wall_pull, (at(0, 0),)))
    rise = rise - load(series.wall_pull, (at(1, 0),))
    impulse = select(leaping, fma(rise, dt * dt * (1.0 / 12.0), impulse), 0.0)
    store(chains.wall_impulse, (lane,), load(chains.wall_impulse, (lane,)) + impulse)
    for block in range(chains.direction.shape[0]):
        _leap_block(lane, block, moved, step, belt, group, series)
    store(chains.steps_done, (lane,), load(chains.steps_done, (lane,)) + leap)


@inlined
def _leap_block(lane, block, moved, step, belt, group, series):
    chains, dt = group.chains, group.time_step
    kinetic = kinetic_friction(group.law)
    place = (block, lane)
    square = dt * dt
    cube = square * dt
    heading = load(chains.direction, place)
    position, speed = polynomial(ORDER, series.position, block + 1, step)
    pull, rise, bend = _with_derivatives(series.force, block, step)
    a = square * (pull - heading * kinetic)
    # F has no friction, which is constant: its derivatives are those of a
    central = fma(speed, dt, rise * (cube / 6.0))
    w = fma(a, -0.5, central)
    rise = rise * cube
    bend = bend * (square * square)
    before = fma(bend, 0.5, a - rise)
    # the step before had a(t-dt) and a(t-2 dt), both by Taylor's series about its end
    v = _scheme_velocity(w, before, fma(bend, 2.0, a - 2.0 * rise))
    changed = moved & (heading != 0.0)
    store(chains.slip_step, place, select(changed, w, load(chains.slip_step, place)))
    store(chains.acceleration, place, select(changed, before, load(chains.acceleration, place)))
    store(chains.velocity, place, select(changed, v, load(chains.velocity, place)))
    shift = position - load(series.position, (at(0, block + 1),))
    loss = fma(heading * kinetic, shift, load(chains.dissipated, place))
    store(chains.dissipated, place, loss)
    store(chains.displacement, place, fma(belt, step, position))


@inlined
def _with_derivatives(coefficients, column, time):
    """Value and two derivatives of the forces in a column."""
    highest = force_order(ORDER)
    value = load(coefficients, (at(highest, column),))
    slope, bend = spread(0.0), spread(0.0)
    for k in range(highest - 1, -1, -1):
        bend = fma(bend, time, slope)
        slope = fma(slope, time, value)
        value = fma(value, time, load(coefficients, (at(k, column),)))
    return value, slope, 2.0 * bend


# --- the step in which the turn may happen ---


@inlined
def _literal_step(lane, taken, first_step, group, scratch, records):
    """One step of the Appendix for some of the chains, the rules first.

    Returns those of them whose blocks have met.
    """
    chains = group.chains
    lowest = _find_pulls(lane, group, scratch)
    impulse = load(chains.wall_impulse, (lane,))
    added = load(scratch.pulls, (0,)) * group.time_step
    store(chains.wall_impulse, (lane,), select(taken, impulse + added, impulse))
    for block in range(chains.direction.shape[0]):
        _step_block(lane, block, taken, first_step, group, scratch, records.events)
    done = load(chains.steps_done, (lane,))
    store(chains.steps_done, (lane,), select(taken, done + 1.0, done))
    if records.crossings.block >= 0:
        _record_literal_crossings(lane, taken, first_step, group, records.crossings)
    _record_literal_samples(lane, taken, group, records.samples)
    return taken & ~(lowest > 0.0)


@inlined
def _find_pulls(lane, group, scratch):
    """Tensions of all springs, from the law; returns the least length of one."""
    law, varied = group.law, group.varied
    left = spread(0.0)
    lowest = spread(1e300)
    for spring in range(group.chains.direction.shape[0]):
        place = load(group.chains.displacement, (spring, lane))
        stretch = place - left
        store(scratch.pulls, (spring * LANES,), tension(stretch, law) * stiffness(varied, spring))
        lowest = minimum(lowest, stretch + rest_length(law, varied, spring))
        left = place
    return lowest


@inlined
def _step_block(lane, block, taken, first_step, group, scratch, events):
    """The rules and the scheme for one block of some of the chains."""
    chains, dt = group.chains, group.time_step
    place = (block, lane)
    external = -load(scratch.pulls, (block * LANES,))
    if block < chains.direction.shape[0] - 1:
        external = external + load(scratch.pulls, ((block + 1) * LANES,))
    old = load(chains.direction, place)
    velocity = load(chains.velocity, place)
    threshold = _threshold(lane, block, old, group.law, group.varied, group.noise, chains)
    new = select(taken, next_direction(old, velocity, external, threshold), old)
    changed = new != old
    before = load(chains.acceleration, place)
    w = load(chains.slip_step, place)
    here = load(chains.displacement, place)
    loss = load(chains.dissipated, place)
    if mask_bits(changed) != 0:
        _record_turns(lane, block, changed, old, new, external, first_step, group, events)
        # a stuck block has no w and no a(t-dt); one that reverses keeps both, as in the Appendix
        keeps = ~changed | (old * new != 0.0)
        before = select(keeps, before, 0.0)
        w = select(keeps, w, 0.0)
        store(chains.threshold, place, select(changed, threshold, load(chains.threshold, place)))
    # where the block has just turned, v_r is still that of the other way
    speed = maximum(new * velocity, 0.0) / dt
    kinetic = _braking(lane, block, speed, group.law, group.varied, group.noise)
    a = dt * dt * (external - new * kinetic) * inverse_mass(group.varied, block)
    a = select(new != 0.0, a, 0.0)
    w = w + a
    v = _scheme_velocity(w, a, before)
    store(chains.direction, place, new)
    store(chains.slip_step, place, select(taken, w, load(chains.slip_step, place)))
    store(chains.acceleration, place, select(taken, a, load(chains.acceleration, place)))
    store(chains.velocity, place, select(taken, v, load(chains.velocity, place)))
    store(chains.dissipated, place, select(taken, fma(new * kinetic, w, loss), loss))
    moved = here + fma(load(group.belt_velocity, (lane,)), dt, w)
    store(chains.displacement, place, select(taken, moved, here))


@inlined
def _threshold(lane, block, direction, law, varied, noise, chains):
    """F_st of a block in this step: what holds it, or would hold it if it came to rest."""
    mean = spread(mean_threshold(law, varied, block))
    if varied is None:
        return mean
    drawn = mean + _deviation(lane, block, noise)
    return select(direction != 0.0, drawn, load(chains.threshold, (block, lane)))


@inlined
def _braking(lane, block, speed, law, varied, noise):
    """Kinetic friction in this step at |v_r| = speed."""
    kinetic = braking(law, varied, block, speed)
    if noise is None:
        return kinetic
    ratio = varied.kinetic_friction[block] / varied.static_friction[block]
    return kinetic + ratio * _deviation(lane, block, noise) / (1.0 + varied.weakening * speed)


@inlined
def _deviation(lane, block, noise):
    """What noise adds to F_st of a block in this step."""
    if noise is None:
        return spread(0.0)
    return load(noise.sigma, (lane,)) * load(noise.deviates, (block * LANES,))


@inlined
def _draw(lane, taken, n_blocks, noise):
    """New deviates for some of eight chains."""
    if noise is None:
        return
    for block in range(0, n_blocks, 2):
        first, second = normal_pairs_where(noise.streams, lane, taken)
        store(noise.deviates, (block * LANES,), first)
        store(noise.deviates, ((block + 1) * LANES,), second)


@inlined
def _record_turns(lane, block, changed, old, new, external, first_step, group, events):
    """Record the ends and starts of slips of one block of eight chains."""
    chains = group.chains
    sticks = mask_bits(changed & (old != 0.0))
    slips = mask_bits(changed & (new != 0.0))
    turned = sticks | slips
    while turned:
        i = lowest_lane(turned)
        turned &= turned - 1
        chain = lane + i
        time = (first_step + chains.steps_done[chain]) * group.time_step
        force = extract(external, i)
        here, loss = chains.displacement[block, chain], chains.dissipated[block, chain]
        if (sticks >> i) & 1:
            record_event(chain, time, block, 0.0, force, here, loss, events)
        if (slips >> i) & 1:
            record_event(chain, time, block, 1.0, force, here, loss, events)


# --- crossings ---


@inlined
def _record_crossings(lane, leaping, leap, first_step, group, scratch, crossings):
    """Crossings of the section within the leaps of eight chains."""
    crossing = may_pass(lane, leaping, leap * group.time_step, group, scratch, crossings)
    while crossing:
        i = lowest_lane(crossing)
        crossing &= crossing - 1
        _cross_in_leap(lane, i, extract(leap, i), first_step, group, scratch.series, crossings)


@inlined
def _cross_in_leap(lane, i, leap, first_step, group, series, crossings):
    """Steps of a leap of one chain in which the section's block comes down through its level."""
    chain = lane + i
    start = first_step + group.chains.steps_done[chain]
    low = 0.0
    above = series.position[at(0, crossings.block + 1) + i] >= crossings.level[chain]
    while low < leap:
        # the first eighth of the rest after which the side differs; a leap holds few crossings, and
        # the scheme does not see those that begin and end between two of its steps
        eighth = max(1.0, math.floor(0.125 * (leap - low)))
        high = low
        height = 0.0
        while high < leap:
            high = min(high + eighth, leap)
            height = _height(chain, i, high, group, series, crossings)
            if (height >= 0.0) != above:
                break
            low = high
        if low == leap:
            return
        while high - low > 1.0:
            middle = math.floor(0.5 * (low + high))
            between = _height(chain, i, middle, group, series, crossings)
            if (between >= 0.0) == above:
                low = middle
            else:
                high, height = middle, between
        if above:
            if crossings.count[chain] == crossings.rows.shape[1]:
                return
            _record_crossing(chain, i, high, height, start, group, series, crossings)
        low = high
        above = not above


@inlined
def _height(chain, i, steps, group, series, crossings):
    """Distance of the section's block of one chain from its level, some steps after the start."""
    time = steps * group.time_step
    value, _ = value_and_slope(ORDER, series.position, crossings.block + 1, i, time)
    return fma(group.belt_velocity[chain], time, value) - crossings.level[chain]


@inlined
def _record_crossing(chain, i, high, height, start, group, series, crossings):
    """Record a crossing in the step that ends `high` steps after the start, at `height`.

    The instant within the step and the state there are those of linear interpolation.
    """
    n_blocks = (crossings.rows.shape[2] - 1) // 2
    dt = group.time_step
    belt_velocity = group.belt_velocity[chain]
    slot = crossings.count[chain]
    crossings.count[chain] = slot + 1
    time = high * dt
    belt_step = belt_velocity * dt
    _, c1, c2, c3, c4 = _shifted(time, crossings.block + 1, i, series)
    # w = x(t) - x(t-dt) - u dt by the series about the end of the step
    w = dt * (c1 - dt * (c2 - dt * (c3 - dt * c4)))
    share = height / (w + belt_step)
    crossings.rows[chain, slot, 0] = (start + high - share) * dt
    for block in range(n_blocks):
        c0, c1, c2, c3, c4 = _shifted(time, block + 1, i, series)
        w = dt * (c1 - dt * (c2 - dt * (c3 - dt * c4)))
        # a = x'' + dt^2/12 x'''' at t - dt; the velocity of the scheme is x' - dt^3/4 x''''
        a = 2.0 * c2 - dt * (6.0 * c3 - 14.0 * dt * c4)
        v = c1 - 6.0 * dt**3 * c4
        place = fma(belt_velocity, time, c0)
        crossings.rows[chain, slot, 1 + block] = place - share * (w + belt_step)
        crossings.rows[chain, slot, 1 + n_blocks + block] = v - share * dt * a


@inlined
def _shifted(time, column, i, series):
    """Coefficients 0 to 4 of the series of one chain about another instant."""
    c0, c1, c2, c3, c4 = series.position[at(ORDER, column) + i], 0.0, 0.0, 0.0, 0.0
    for k in range(ORDER - 1, -1, -1):
        c4 = fma(c4, time, c3)
        c3 = fma(c3, time, c2)
        c2 = fma(c2, time, c1)
        c1 = fma(c1, time, c0)
        c0 = fma(c0, time, series.position[at(k, column) + i])
    return c0, c1, c2, c3, c4


@inlined
def _record_literal_crossings(lane, taken, first_step, group, crossings):
    """Crossings of the section in the single steps that some of the chains have just done."""
    chains, dt = group.chains, group.time_step
    n_blocks = chains.direction.shape[0]
    stepping = mask_bits(taken)
    while stepping:
        chain = lane + lowest_lane(stepping)
        stepping &= stepping - 1
        belt_step = group.belt_velocity[chain] * dt
        after = chains.displacement[crossings.block, chain] - crossings.level[chain]
        move = chains.slip_step[crossings.block, chain] + belt_step
        if not (after < 0.0 and after - move >= 0.0):
            continue
        slot = crossings.count[chain]
        crossings.count[chain] = slot + 1
        share = after / move
        crossings.rows[chain, slot, 0] = (first_step + chains.steps_done[chain] - share) * dt
        for block in range(n_blocks):
            w, a = chains.slip_step[block, chain], chains.acceleration[block, chain]
            place = chains.displacement[block, chain] - share * (w + belt_step)
            crossings.rows[chain, slot, 1 + block] = place
            speed = (chains.velocity[block, chain] - share * a) * (1.0 / dt)
            crossings.rows[chain, slot, 1 + n_blocks + block] = speed


# --- samples ---


@inlined
def _record_samples(lane, leaping, leap, group, series, samples):
    """Samples within the leaps of eight chains."""
    done = load(group.chains.steps_done, (lane,))
    row = load(samples.following, (lane,))
    following = fma(to_float(row), samples.interval, samples.first)
    sampled = mask_bits(leaping & (following <= done + leap))
    while sampled:
        i = lowest_lane(sampled)
        sampled &= sampled - 1
        _sample_leap(lane, i, extract(leap, i), group, series, samples)


@inlined
def _sample_leap(lane, i, leap, group, series, samples):
    """Samples of one chain in a leap, eight at a time: they lie side by side."""
    chains, dt = group.chains, group.time_step
    kinetic = kinetic_friction(group.law)
    chain = lane + i
    row = samples.following[chain]
    cube = dt * dt * dt
    count = LANES
    while count == LANES:
        rows = lane_numbers() + row
        steps = fma(to_float(rows), samples.interval, samples.first) - chains.steps_done[chain]
        due = steps <= leap
        since = steps * dt
        for block in range(samples.first_block, chains.direction.shape[0]):
            heading = chains.direction[block, chain]
            position, relative = evaluate_one(ORDER, series, block, i, since)
            if heading != 0.0:
                # the velocity of the scheme is x' - dt^3/4 a''
                relative = fma(_bend_one(block, i, since, series.force), -0.25 * cube, relative)
            shifted = fma(group.belt_velocity[chain], since, position)
            friction = spread(heading * -kinetic)
            write_samples(samples, chain, block, row, shifted, relative, friction, due)
        count = lowest_lane(~mask_bits(due))
        row += count
    samples.following[chain] = row


@inlined
def _bend_one(block, i, times, force):
    """Second derivative of the force on a block of the chain in lane i at eight times."""
    first = at(0, block) + i
    bend = spread(0.0)
    for k in range(force_order(ORDER), 1, -1):
        bend = fma(bend, times, k * (k - 1.0) * force[first + k * LANES])
    return bend


@inlined
def _record_literal_samples(lane, taken, group, samples):
    """Samples after the single steps that some of the chains have just done."""
    chains = group.chains
    row = load(samples.following, (lane,))
    following = fma(to_float(row), samples.interval, samples.first)
    due = taken & (following == load(chains.steps_done, (lane,)))
    if mask_bits(due) == 0:
        return
    for block in range(samples.first_block, chains.direction.shape[0]):
        shown = block - samples.first_block
        position = load(chains.displacement, (block, lane))
        relative = load(chains.velocity, (block, lane)) * (1.0 / group.time_step)
        kinetic = _braking(lane, block, abs(relative), group.law, group.varied, group.noise)
        friction = load(chains.direction, (block, lane)) * -kinetic
        sampled = mask_bits(due)
        while sampled:
            i = lowest_lane(sampled)
            sampled &= sampled - 1
            place = samples.following[lane + i]
            samples.values[0, shown, lane + i, place] = extract(position, i)
            samples.values[1, shown, lane + i, place] = extract(relative, i)
            samples.values[2, shown, lane + i, place] = extract(friction, i)
    store(samples.following, (lane,), select(due, row + 1, row))


# --- the kernels ---


@kernel
def leap_steps(first_step, n_steps, group, scratch, records):
    """Advance the chains of a group by n_steps steps of the Appendix.

    Returns DONE; EVENTS_FULL or CROSSINGS_FULL, to be called again with a larger buffer; or CONTACT
    when blocks meet.

    first_step : index of the first (time = index * dt); records : with samples at instants counted
    in steps.
    """
    separate_arrays()
    chains, series = group.chains, scratch.series
    n_blocks = chains.direction.shape[0]
    for lane in range(0, chains.steps_done.size, LANES):
        store(series.position, (at(1, WALL),), -load(group.belt_velocity, (lane,)))
        while True:
            remaining = n_steps - load(chains.steps_done, (lane,))
            active = remaining > 0.0
            if mask_bits(active) == 0:
                break
            status = full_buffer(lane, 2 * n_blocks, CROSSINGS_AT_ONCE, records)
            if status != DONE:
                return status

            _make_series(lane, group, scratch)
            due = active & _literal_due(lane, group, scratch)
            leaping = active & ~due
            leap, turning, meeting = _choose_leap(lane, leaping, remaining, group, scratch)
            if records.crossings.block >= 0:
                crossings = records.crossings
                _record_crossings(lane, leaping, leap, first_step, group, scratch, crossings)
            _record_samples(lane, leaping, leap, group, series, records.samples)
            _leap(lane, leaping, leap, group, scratch)
            taken = (due | turning) & (load(chains.steps_done, (lane,)) < n_steps)
            if mask_bits(taken) != 0:
                met = _literal_step(lane, taken, first_step, group, scratch, records)
                meeting = meeting | met
            if mask_bits(meeting) != 0:
                return CONTACT
    return DONE


@kernel
def literal_steps(first_step, n_steps, group, scratch, records):
    """As `leap_steps`, for chains of any law, with noise or without: every step taken literally."""
    separate_arrays()
    chains = group.chains
    n_blocks = chains.direction.shape[0]
    for lane in range(0, chains.steps_done.size, LANES):
        while True:
            taken = load(chains.steps_done, (lane,)) < n_steps
            if mask_bits(taken) == 0:
                break
            status = full_buffer(lane, 2 * n_blocks, CROSSINGS_AT_ONCE, records)
            if status != DONE:
                return status
            _draw(lane, taken, n_blocks, group.noise)
            met = _literal_step(lane, taken, first_step, group, scratch, records)
            if mask_bits(met) != 0:
                return CONTACT
    return DONE
