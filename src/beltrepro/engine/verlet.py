"""The paper's numerical scheme (Appendix), step for step, for many chains at once.

In the frame of the belt a stuck block has exactly zero relative velocity. With the slip step
w(t) = x(t) - x(t-dt) - u dt the printed formulas read

    w(t+dt) = w(t) + a(t) dt^2,                               x(t+dt) = x(t) + u dt + w(t+dt)
    v_r(t+dt) dt = w(t+dt) + 5/6 a(t) dt^2 - 1/3 a(t-dt) dt^2

which rounds better than 2x(t) - x(t-dt) and is the same scheme. Velocities are kept times dt and
accelerations times dt^2. A stuck block has w, push and kinetic friction zero, so that one formula
moves all blocks.

A run is cut into stretches of ten steps. At the start of one, `_prepare` finds the tensions as
series of the deformations, and bounds on how far the chain can go before the end. They tell which
blocks might turn (stick to slip, slip to stick, or reversal): only those are watched. They also
tell which springs the series serves. Elsewhere the law itself is evaluated in every step.

Both decisions follow from the chain's own state at the start of the stretch. What is watched or
evaluated and then not used depends on the neighbours; the numbers of a chain do not.
"""

from typing import NamedTuple

import numpy as np

from beltrepro.engine.law import Law, expand_spring, next_direction, tension
from beltrepro.engine.noise import normal_pairs_wide
from beltrepro.engine.records import DONE, Crossings, Events, full_buffer, record_event
from beltrepro.engine.simd import LANES as HALF
from beltrepro.engine.simd import (
    WIDE_LANES,
    extract,
    fma,
    load_wide,
    lowest_lane,
    mask_bits,
    select,
    store,
)
from beltrepro.engine.vector import inlined, kernel, maximum, minimum, zeros

LANES = WIDE_LANES
STRETCH = 10  # steps
_ALL = (1 << LANES) - 1

# The state of a block of sixteen chains, and of the spring before it: vectors in a row, at these
# offsets. Up to date after every call: displacement from the rest position, v_r dt, direction of
# slip (0 if stuck), friction loss times dt^2
DISPLACEMENT, VELOCITY, DIRECTION, DISSIPATED = range(0, 4 * LANES, LANES)
# slip over the belt since the start of the stretch; w and a dt^2; dt^2, or 0 if stuck; kinetic
# friction times dt^2, with the sign of the direction: its mean and what noise adds
_SLIP, SLIP_STEP, ACCELERATION, _PUSH, _KINETIC, _KINETIC_NOISE = range(
    4 * LANES, 10 * LANES, LANES
)
# tension: coefficients of the powers 0 to 5 of the change of the deformation in the stretch. Where
# the series does not serve, power 0 is the tension itself, found anew in every step
_SERIES = 10 * LANES
# displacement, deformation of the spring and loss at the start of the stretch; the slip up to which
# the loss counts
_START, _DEFORMATION, _LOSS, _SETTLED = range(16 * LANES, 20 * LANES, LANES)
# F_st of a stuck block; force at the start of the stretch or at the last turn in it; normal deviate
# of the last step
THRESHOLD, _FORCE, _NORMAL = range(20 * LANES, 23 * LANES, LANES)
_ROW = 23 * LANES

# Six terms of exp(y) for |y| below this leave y^6/720, 1e-16.
_SERIES_REACH = 0.0065
_LARGEST_DEVIATE = 8.5  # sqrt(-2 ln 2^-52), see `beltrepro.engine.noise`
# The bounds hold while no tension changes by more than this share of the mean F_st.
_TENSION_SHARE = 1 / 16


class Chains(NamedTuple):
    """State of W chains, W a multiple of 16."""

    state: np.ndarray  # (W/16, rows of all blocks), see `empty_state`
    wall_pull: np.ndarray  # (W,) sum of the first spring's pull over the steps
    streams: np.ndarray  # (4, W) random streams
    contact: np.ndarray  # (W,) index of the step before which blocks met; infinite: not yet


class Sixteen(NamedTuple):
    """Sixteen of the chains, as the functions of the kernel see them."""

    state: np.ndarray  # as in `Chains`
    vector: int  # row of the state
    n_blocks: int


class Group(NamedTuple):
    """Chains of one law with all that moves them."""

    law: Law
    time_step: float  # dt
    belt_step: np.ndarray  # (W,) u dt
    noise: np.ndarray  # (W,) sigma
    noisy: bool  # whether any sigma is not zero
    n_blocks: int
    chains: Chains


class Samples(NamedTuple):
    """Samples of W chains at the steps whose index is a multiple of `stride`."""

    values: np.ndarray  # (S, 3, B, W) displacement, relative velocity, kinetic friction
    first_block: int  # the first of the B blocks, from 0
    stride: int


class Records(NamedTuple):
    """All that the kernel records."""

    samples: Samples
    events: Events
    crossings: Crossings


def empty_state(n_blocks, belt_step):
    """State (W/16, N + 2 rows) of W chains, without its blocks; belt_step : (W,) u dt."""
    # row 0 is the wall, which slips by -u dt in every step; row N + 1 a spring that never pulls
    state = zeros((len(belt_step) // LANES, n_blocks + 2, _ROW))
    state[:, 0, SLIP_STEP : SLIP_STEP + LANES] = -belt_step.reshape(-1, LANES)
    return state.reshape(len(state), -1)


def write_blocks(
    group,
    step,
    *,
    displacement,
    velocity,
    direction,
    threshold,
    dissipated,
    slip_step,
    acceleration,
):
    """Let the blocks be in other states (N, W) at the start of the step of that index.

    velocity : v_r dt; dissipated : loss times dt^2; slip_step : w; acceleration : a(t-dt) dt^2.
    In the middle of a stretch it goes on without series, as if the stretch had begun without slip.
    """
    state = group.chains.state.reshape(len(group.chains.state), -1, _ROW)
    rows = state[:, 1 : group.n_blocks + 1]
    square = group.time_step * group.time_step
    kinetic = direction * (group.law.friction_ratio * square)
    start = displacement - group.belt_step * float(step % STRETCH)
    rows[...] = 0.0
    for field, values in (
        (DISPLACEMENT, displacement),
        (VELOCITY, velocity),
        (DIRECTION, direction),
        (DISSIPATED, dissipated),
        (SLIP_STEP, slip_step),
        (ACCELERATION, acceleration),
        (_PUSH, np.where(direction != 0, square, 0.0)),
        (_KINETIC, kinetic * group.law.static_friction),
        (_KINETIC_NOISE, kinetic * group.noise),
        (_START, start),
        (_DEFORMATION, np.diff(start, axis=0, prepend=0.0)),
        (_LOSS, dissipated),
        (THRESHOLD, threshold),
    ):
        columns = values.reshape(group.n_blocks, -1, LANES)
        rows[..., field : field + LANES] = columns.swapaxes(0, 1)


def of_blocks(state, field, n_blocks):
    """One field of the state as an array (N, W)."""
    state = state.reshape(len(state), -1, _ROW)
    return np.concatenate(state[:, 1 : n_blocks + 1, field : field + LANES], axis=1)


# Rows are of constant length, so that one register points to all fields of a block.


@inlined
def _get(chains, block, field):
    return load_wide(chains.state, (chains.vector, block * _ROW + field))


@inlined
def _put(chains, block, field, value):
    store(chains.state, (chains.vector, block * _ROW + field), value)


# --- stretches ---


@inlined
def _bit(block):
    """The bit of a block, or of the spring before it, which it shares with those 64 further on."""
    # what is watched or evaluated without need changes no number
    return 1 << ((block - 1) & 63)


@inlined
def _expand(chains, spring, deformation, law):
    """Write the power series of a tension; returns the tension."""
    pull, slope, rate, _ = expand_spring(deformation, law)
    _put(chains, spring, _DEFORMATION, deformation)
    _put(chains, spring, _SERIES, pull)
    _put(chains, spring, _SERIES + LANES, slope)
    coefficient = slope
    for power in range(2, 6):
        # every derivative is `rate` times the one before
        coefficient = coefficient * rate * (1.0 / power)
        _put(chains, spring, _SERIES + power * LANES, coefficient)
    return pull


@inlined
def _prepare(chains, strongest, square, law):
    """Start a stretch: write the series, bound the motion.

    strongest : kinetic friction. Returns the bound A on |a| dt^2, bits of the springs that need the
    law and of the blocks that might turn, and whether the bounds fail for some chain.

    While tensions change by at most `change`, F_ex changes by twice as much, which bounds a. Slips
    then change by less than K |w| + K (K + 11)/2 A in K steps, of which 5 A a step are for blocks
    that stick, where |w| < 5 A. And this must keep the tensions within `change`.
    """
    change = _TENSION_SHARE * law.static_friction
    greatest, fastest = _start_stretch(chains, law)
    greatest = greatest + (strongest + 2.0 * change)
    fastest = maximum(greatest * square, fastest)
    drift = fastest * (STRETCH * (STRETCH + 11.0))
    braking = (strongest, square, fastest)

    bent = 0
    watched = 0
    hold = drift >= 0.0
    beyond = 0.0 * drift
    w = _get(chains, chains.n_blocks, SLIP_STEP)
    for block in range(chains.n_blocks, 0, -1):
        left = _get(chains, block - 1, SLIP_STEP)
        span = fma(abs(w - left), STRETCH, drift)
        reach, holds, serves = _bound_spring(chains, block, span, change, law)
        hold = hold & holds
        if mask_bits(serves) != _ALL:
            bent |= _bit(block)
            _bend(chains, block, serves)
        if mask_bits(_goes_on(chains, block, w, reach + beyond, braking) > 0.0) != _ALL:
            watched |= _bit(block)
        beyond = reach
        w = left
    loose = mask_bits(hold) != _ALL
    if loose:
        bent = -1
        watched = -1
        for block in range(1, chains.n_blocks + 1):
            _bend(chains, block, hold)
    return fastest, bent, watched, loose


@inlined
def _start_stretch(chains, law):
    """Write the series of all tensions, and F_ex; returns the greatest |F_ex| and |a| dt^2."""
    left = _get(chains, 0, _START)
    pull = left
    fastest = left
    greatest = left
    for block in range(1, chains.n_blocks + 1):
        displacement = _get(chains, block, _START)
        next_pull = _expand(chains, block, displacement - left, law)
        force = next_pull - pull
        if block > 1:
            _put(chains, block - 1, _FORCE, force)
            greatest = maximum(abs(force), greatest)
        fastest = maximum(abs(_get(chains, block, ACCELERATION)), fastest)
        left = displacement
        pull = next_pull
    _put(chains, chains.n_blocks, _FORCE, -pull)
    return maximum(abs(pull), greatest), fastest


@inlined
def _bound_spring(chains, spring, span, change, law):
    """How much a tension changes while the deformation changes by at most `span`.

    Returns that, whether it is a bound and within `change`, and whether the series serves.
    """
    highest_rate = max(law.compression_rate, law.extension_rate)
    slope = _get(chains, spring, _SERIES + LANES)
    second = _get(chains, spring, _SERIES + 2 * LANES)
    deformation = _get(chains, spring, _DEFORMATION)
    # e^y < 1 + 3/2 y for y < 1/2
    reach = slope * span * fma(span, 1.5 * highest_rate, 1.0)
    holds = (reach <= change) & (span * highest_rate <= 0.5)
    # second / slope is half the rate
    serves = (span < abs(abs(deformation) - law.linear_limit)) & (
        span * abs(second) <= 0.5 * _SERIES_REACH * slope
    )
    # where blocks might meet, the law, which looks for that
    serves = serves & (deformation - span > -law.rest_length)
    return reach, holds, serves


@inlined
def _goes_on(chains, block, w, reach, braking):
    """Positive where a block cannot turn in the stretch, in which F_ex changes by `reach`.

    braking : strongest kinetic friction, dt^2, and the bound A.
    """
    strongest, square, fastest = braking
    force = _get(chains, block, _FORCE)
    direction = _get(chains, block, DIRECTION)
    velocity = _get(chains, block, VELOCITY)
    threshold = _get(chains, block, THRESHOLD)
    # v_r > w - A/3 and K + 1 times the strongest braking
    slowing = minimum(fma(direction, force, -strongest) - reach, 0.0) * square
    slowest = fma(slowing, STRETCH + 1.0, fma(direction, w, -0.34 * fastest))
    return select(
        direction == 0.0, threshold - abs(force) - reach, minimum(direction * velocity, slowest)
    )


@inlined
def _bend(chains, spring, serves):
    """Do without the series of a spring in the lanes where it does not serve: all powers are 0."""
    for power in range(6):
        place = _SERIES + power * LANES
        coefficient = _get(chains, spring, place)
        _put(chains, spring, place, select(serves, coefficient, 0.0))


@inlined
def _resume(chains):
    """Bits of the springs that need the law, in the middle of a stretch."""
    bent = 0
    for spring in range(1, chains.n_blocks + 1):
        # a spring has a slope
        if mask_bits(_get(chains, spring, _SERIES + LANES) == 0.0):
            bent |= _bit(spring)
    return bent


@inlined
def _conclude(chains, belt_travel, ended):
    """Bring displacements and losses up to date; if the stretch has ended, count from there."""
    for block in range(1, chains.n_blocks + 1):
        slip = _get(chains, block, _SLIP)
        displacement = _get(chains, block, _START) + (belt_travel + slip)
        unsettled = slip - _get(chains, block, _SETTLED)
        kinetic = _get(chains, block, _KINETIC)
        loss = fma(kinetic, unsettled, _get(chains, block, _LOSS))
        _put(chains, block, DISPLACEMENT, displacement)
        _put(chains, block, DISSIPATED, loss)
        if ended:
            _put(chains, block, _START, displacement)
            _put(chains, block, _LOSS, loss)
            _put(chains, block, _SLIP, 0.0 * slip)
            _put(chains, block, _SETTLED, 0.0 * slip)


# --- steps ---


@inlined
def scheme_velocity(slip_step, acceleration, before):
    """v_r dt after a step, from w after it, and a dt^2 at its start and one step before."""
    return fma(acceleration, 5.0 / 6.0, fma(before, -1.0 / 3.0, slip_step))


@inlined
def _tension(chains, spring, growth):
    """Tension of a spring whose deformation has changed by `growth` since the stretch began."""
    # summed by halves, which keeps the chain of operations short
    growth_2 = growth * growth
    t0 = _get(chains, spring, _SERIES)
    t1 = _get(chains, spring, _SERIES + LANES)
    t2 = _get(chains, spring, _SERIES + 2 * LANES)
    t3 = _get(chains, spring, _SERIES + 3 * LANES)
    t4 = _get(chains, spring, _SERIES + 4 * LANES)
    t5 = _get(chains, spring, _SERIES + 5 * LANES)
    high = fma(fma(t5, growth, t4), growth_2, fma(t3, growth, t2))
    return fma(high, growth_2, fma(t1, growth, t0))


@inlined
def _apply_law(chains, bent, step, law, contact):
    """Find the tensions of the springs in `bent` by the law, in the lanes without a series.

    Where one has no length its chain has a contact, in the first such step.
    """
    for spring in range(1, chains.n_blocks + 1):
        if bent & _bit(spring):
            deformation = _get(chains, spring, _DEFORMATION) + (
                _get(chains, spring, _SLIP) - _get(chains, spring - 1, _SLIP)
            )
            without = _get(chains, spring, _SERIES + LANES) == 0.0
            pull = _get(chains, spring, _SERIES)
            pull = select(without, tension(deformation, law), pull)
            _put(chains, spring, _SERIES, pull)
            meeting = mask_bits(without & ~(deformation > -law.rest_length))
            for lane in range(LANES * (meeting != 0)):
                if (meeting >> lane) & 1:
                    chain = chains.vector * LANES + lane
                    contact[chain] = min(contact[chain], float(step))


@inlined
def _move(chains, noisy):
    """Advance all blocks by the scheme; returns the pull of the first spring."""
    slip = _get(chains, chains.n_blocks, _SLIP)
    pull = 0.0 * slip
    for block in range(chains.n_blocks, 0, -1):
        left = _get(chains, block - 1, _SLIP)
        next_pull = pull
        pull = _tension(chains, block, slip - left)
        w = _get(chains, block, SLIP_STEP)
        kinetic = _get(chains, block, _KINETIC)
        if noisy:
            added = _get(chains, block, _KINETIC_NOISE)
            added = added * _get(chains, block, _NORMAL)
            kinetic = kinetic + added
        a = fma(_get(chains, block, _PUSH), next_pull - pull, -kinetic)
        w = w + a
        _put(chains, block, ACCELERATION, a)
        _put(chains, block, SLIP_STEP, w)
        _put(chains, block, _SLIP, slip + w)
        if noisy:
            loss = _get(chains, block, _LOSS)
            _put(chains, block, _LOSS, fma(added, w, loss))
        slip = left
    return pull


# --- turns ---


@inlined
def _check_turns(chains, watched, belt_travel, time, noise, group, events):
    """Apply the stick and slip rules to the watched blocks."""
    for block in range(1, chains.n_blocks + 1):
        if watched & _bit(block):
            slip = _get(chains, block, _SLIP)
            pull = _tension(chains, block, slip - _get(chains, block - 1, _SLIP))
            force = _tension(chains, block + 1, _get(chains, block + 1, _SLIP) - slip) - pull
            direction = _get(chains, block, DIRECTION)
            ahead = direction * _get(chains, block, VELOCITY)
            holds = _get(chains, block, THRESHOLD) - abs(force)
            if mask_bits(select(direction == 0.0, holds, ahead) <= 0.0):
                _turn(chains, block, force, belt_travel, time, noise, group, events)


@inlined
def _turn(chains, block, force, belt_travel, time, noise, group, events):
    """Apply the stick and slip rules to a block and record what they change."""
    law = group.law
    old = _get(chains, block, DIRECTION)
    # drawn anew while slipping, kept while stuck
    drawn = fma(noise, _get(chains, block, _NORMAL), law.static_friction)
    threshold = select(old != 0.0, drawn, _get(chains, block, THRESHOLD))
    new = next_direction(old, _get(chains, block, VELOCITY), force, threshold)
    changed = new != old
    if mask_bits(changed):
        _settle(chains, block, changed, force, belt_travel)
        _record_turns(chains, block, changed, old, new, time, group.time_step, events)
        _redirect(chains, block, old, new, threshold, noise, group)


@inlined
def _settle(chains, block, changed, force, belt_travel):
    """Bring displacement and loss of a block up to date where it changes its direction."""
    slip = _get(chains, block, _SLIP)
    settled = _get(chains, block, _SETTLED)
    loss = _get(chains, block, _LOSS)
    loss = select(changed, fma(_get(chains, block, _KINETIC), slip - settled, loss), loss)
    displacement = _get(chains, block, _START) + (belt_travel + slip)
    _put(chains, block, _LOSS, loss)
    _put(chains, block, _SETTLED, select(changed, slip, settled))
    _put(chains, block, _FORCE, force)
    _put(chains, block, DISPLACEMENT, displacement)
    _put(chains, block, DISSIPATED, loss)


@inlined
def _record_turns(chains, block, changed, old, new, time, time_step, events):
    """Record the ends and starts of slips of one block of sixteen chains."""
    sticks = mask_bits(changed & (old != 0.0))
    slips = mask_bits(changed & (new != 0.0))
    for lane in range(LANES):
        if ((sticks | slips) >> lane) & 1:
            place = block * _ROW + lane
            force = chains.state[chains.vector, place + _FORCE]
            here = chains.state[chains.vector, place + DISPLACEMENT]
            loss = chains.state[chains.vector, place + DISSIPATED] / (time_step * time_step)
            chain = chains.vector * LANES + lane
            if (sticks >> lane) & 1:
                record_event(chain, time, block - 1, 0.0, force, here, loss, events)
            if (slips >> lane) & 1:
                record_event(chain, time, block - 1, 1.0, force, here, loss, events)


@inlined
def _redirect(chains, block, old, new, threshold, noise, group):
    """Let a block move as its new direction wants."""
    law = group.law
    square = group.time_step * group.time_step
    w = _get(chains, block, SLIP_STEP)
    before = _get(chains, block, ACCELERATION)
    turned = old * new != 0.0
    kinetic = new * (law.friction_ratio * square)
    _put(chains, block, THRESHOLD, threshold)
    _put(chains, block, SLIP_STEP, select(turned, w, 0.0))
    _put(chains, block, ACCELERATION, select(turned, before, 0.0))
    _put(chains, block, DIRECTION, new)
    _put(chains, block, _PUSH, select(new != 0.0, square, 0.0))
    _put(chains, block, _KINETIC, kinetic * law.static_friction)
    _put(chains, block, _KINETIC_NOISE, kinetic * noise)


# --- velocities, which serve the rules, samples and crossings ---


@inlined
def _keep_accelerations(chains, blocks):
    """Before a step, keep a(t-dt) of some blocks in place of the velocity."""
    for block in range(1, chains.n_blocks + 1):
        if blocks & _bit(block):
            _put(chains, block, VELOCITY, _get(chains, block, ACCELERATION))


@inlined
def _find_velocities(chains, blocks):
    """Velocities of the same blocks after the step."""
    for block in range(1, chains.n_blocks + 1):
        if blocks & _bit(block):
            before = _get(chains, block, VELOCITY)
            a = _get(chains, block, ACCELERATION)
            w = _get(chains, block, SLIP_STEP)
            _put(chains, block, VELOCITY, scheme_velocity(w, a, before))


# --- crossings and samples ---


@inlined
def _near(chains, block, level, belt, fastest):
    """Whether a block of some chain may come to its level in the stretch."""
    away = _get(chains, block, _START) - level
    w = _get(chains, block, SLIP_STEP)
    span = fma(fastest, 0.5 * STRETCH * (STRETCH + 11.0), STRETCH * abs(w + belt))
    return mask_bits(abs(away) > span) != _ALL


@inlined
def _record_crossings(chains, belt, belt_travel, time, time_step, crossings):
    """Record the chains whose block came down through its level in the step that ends at `time`.

    belt_travel : u t since the start of the stretch.
    """
    block = crossings.block + 1
    level = load_wide(crossings.level, (chains.vector * LANES,))
    after = _get(chains, block, _START) + (belt_travel + _get(chains, block, _SLIP)) - level
    move = _get(chains, block, SLIP_STEP) + belt
    hits = mask_bits((after < 0.0) & (after - move >= 0.0))
    while hits:
        lane = lowest_lane(hits)
        hits &= hits - 1
        # linear interpolation in the step
        share = extract(after / move, lane)
        belt_step, travel = extract(belt, lane), extract(belt_travel, lane)
        chain = chains.vector * LANES + lane
        slot = crossings.count[chain]
        crossings.count[chain] = slot + 1
        crossings.rows[chain, slot, 0] = time - share * time_step
        for number in range(1, chains.n_blocks + 1):
            place = number * _ROW + lane
            slip = chains.state[chains.vector, place + _SLIP]
            here = chains.state[chains.vector, place + _START] + (travel + slip)
            moved = chains.state[chains.vector, place + SLIP_STEP] + belt_step
            velocity = chains.state[chains.vector, place + VELOCITY]
            velocity -= share * chains.state[chains.vector, place + ACCELERATION]
            crossings.rows[chain, slot, number] = here - share * moved
            crossings.rows[chain, slot, chains.n_blocks + number] = velocity / time_step


@inlined
def _sample(chains, time_step, samples, row):
    """Write one row of samples of the vector's chains."""
    lane = chains.vector * LANES
    for column in range(chains.n_blocks - samples.first_block):
        block = 1 + samples.first_block + column
        velocity = _get(chains, block, VELOCITY)
        noise = _get(chains, block, _KINETIC_NOISE)
        kinetic = _get(chains, block, _KINETIC)
        kinetic = fma(noise, _get(chains, block, _NORMAL), kinetic)
        displacement = _get(chains, block, DISPLACEMENT)
        store(samples.values, (row, 0, column, lane), displacement)
        store(samples.values, (row, 1, column, lane), velocity / time_step)
        store(samples.values, (row, 2, column, lane), -kinetic / (time_step * time_step))


# --- the kernel ---


@inlined
def _pause(start, last, visit, stride):
    """The step at which sixteen chains hand over to the next, from `start` on."""
    pause = start + visit
    pause = max(pause - pause % STRETCH, min(pause, (start // STRETCH + 1) * STRETCH))
    return min(last, pause, (start // stride + 1) * stride)


@inlined
def _draw(chains, streams):
    """New normal deviates for all blocks."""
    for block in range(1, chains.n_blocks + 1, 2):
        first, second = normal_pairs_wide(streams, chains.vector * LANES)
        _put(chains, block, _NORMAL, first)
        _put(chains, block + 1, _NORMAL, second)


@inlined
def _choose(chains, now, base, belt, noise, group, crossings):
    """What the steps from `now` on, in the stretch from `base` on, need.

    Returns bits: springs that need the law, blocks to watch, and whether the section may be met.
    """
    law = group.law
    near = crossings.block >= 0
    if now == base:
        strongest = law.friction_ratio * fma(noise, _LARGEST_DEVIATE, law.static_friction)
        square = group.time_step * group.time_step
        fastest, bent, watched, loose = _prepare(chains, strongest, square, law)
        if near and not loose:
            level = load_wide(crossings.level, (chains.vector * LANES,))
            near = _near(chains, crossings.block + 1, level, belt, fastest)
    else:
        bent = _resume(chains)
        watched = -1
    if near:
        watched = -1
    return bent, watched, near


@inlined
def _advance(chains, start, stop, group, records):
    """Advance sixteen chains from one step to another, stretch by stretch."""
    time_step = group.time_step
    lane = chains.vector * LANES
    noise = load_wide(group.noise, (lane,))
    belt = load_wide(group.belt_step, (lane,))
    pull = load_wide(group.chains.wall_pull, (lane,))
    now = start
    while now < stop:
        base = now - now % STRETCH
        end = min(stop, base + STRETCH)
        bent, watched, near = _choose(chains, now, base, belt, noise, group, records.crossings)
        # most steps: a loop with nothing else in it leaves the registers to `_move`
        if not (group.noisy or bent or watched):
            for quiet_step in range(now, end - 1):
                _put(chains, 0, _SLIP, belt * float(base - quiet_step))
                pull = pull + _move(chains, False)
            now = end - 1
        for step in range(now, end):
            if group.noisy:
                _draw(chains, group.chains.streams)
            belt_travel = belt * float(step - base)
            _put(chains, 0, _SLIP, -belt_travel)
            if bent:
                _apply_law(chains, bent, step, group.law, group.chains.contact)
            if watched:
                time = step * time_step
                _check_turns(chains, watched, belt_travel, time, noise, group, records.events)
            kept = watched if step < end - 1 else -1
            if kept:
                _keep_accelerations(chains, kept)
            pull = pull + (_move(chains, True) if group.noisy else _move(chains, False))
            if kept:
                _find_velocities(chains, kept)
            if near:
                travel, time = belt * float(step + 1 - base), (step + 1) * time_step
                _record_crossings(chains, belt, travel, time, time_step, records.crossings)
        now = end
        _conclude(chains, belt * float(end - base), end == base + STRETCH)
    store(group.chains.wall_pull, (lane,), pull)


@kernel
def verlet_steps(first_step, n_steps, group, records):
    """Advance the chains of a group by at most n_steps steps of the Appendix; returns the number.

    It stops early when a buffer of events or crossings is nearly full.

    first_step : index of the first step (time = index * dt). group : Group; records : Records.
    """
    state, n_blocks = group.chains.state, group.n_blocks
    samples, events, crossings = records.samples, records.events, records.crossings
    # sixteen chains take this many steps before the next sixteen do, so that they stay in the
    # fastest memory; it cannot fill more than a quarter of a buffer
    visit = min(events.rows.shape[1] // (8 * n_blocks), crossings.rows.shape[1] // 4)
    last = first_step + n_steps
    step = first_step
    row = 0
    full = False
    while step < last and not full:
        start = step
        step = _pause(start, last, visit, samples.stride)
        sampled = step % samples.stride == 0
        for vector in range(len(state)):
            chains = Sixteen(state, vector, n_blocks)
            _advance(chains, start, step, group, records)
            if sampled:
                _sample(chains, group.time_step, samples, row)
            for lane in range(vector * LANES, (vector + 1) * LANES, HALF):
                if full_buffer(lane, 2 * n_blocks * visit, visit, records) != DONE:
                    full = True
        row += sampled
    return step - first_step
