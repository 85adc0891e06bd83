"""The paper's numerical scheme (Appendix), step for step, for many chains at once.

In the frame of the belt a stuck block has exactly zero relative velocity. With the slip step
w(t) = x(t) - x(t-dt) - u dt the printed formulas read

    w(t+dt) = w(t) + a(t) dt^2,                               x(t+dt) = x(t) + u dt + w(t+dt)
    v_r(t+dt) dt = w(t+dt) + 5/6 a(t) dt^2 - 1/3 a(t-dt) dt^2

which rounds better than 2x(t) - x(t-dt) and is the same scheme. Velocities are kept times dt and
accelerations times dt^2. A stuck block has w, push and kinetic friction zero, so that one formula
moves all blocks.

A run is cut into stretches of ten steps, at multiples of ten of the step's index. At the start of
one, `_prepare` finds for every spring its tension as a power series of the deformation, and bounds
on how far the chain can go before the end. They tell which blocks might turn (stick to slip, slip
to stick, or reversal): only those are watched, in every step, and `_turn` applies the stick and
slip rules (`beltrepro.model.friction.next_direction`) where one is due. They also tell which
springs the series serves: its error must stay below rounding, and the spring on its branch of the
law. Elsewhere the law itself is evaluated in every step.

Both decisions, series or law and turn or no turn, follow from the chain's own state at the start of
the stretch. Which blocks of a vector are watched, and what is evaluated and then not used, depends
on the neighbours and on where a run is cut into pieces; the numbers of a chain do not.
"""

from typing import NamedTuple

import numpy as np

from beltrepro.engine.law import Law, tension, tension_and_slope
from beltrepro.engine.memory import zeros
from beltrepro.engine.noise import normal_pairs_wide
from beltrepro.engine.records import Crossings, Events, record_event
from beltrepro.engine.simd import (
    WIDE_LANES,
    copysign,
    extract,
    fma,
    load_wide,
    mask_bits,
    maximum,
    minimum,
    select,
    store,
)
from beltrepro.engine.vector import inlined, kernel

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


class BlockState(NamedTuple):
    """The blocks of one chain at the start of a step; arrays (N,)."""

    displacement: np.ndarray
    velocity: np.ndarray  # v_r dt
    direction: np.ndarray
    threshold: np.ndarray
    dissipated: np.ndarray  # friction loss times dt^2
    slip_step: np.ndarray  # w
    acceleration: np.ndarray  # a(t-dt) dt^2


def empty_state(n_blocks, belt_step):
    """State (W/16, N + 2 rows) of W chains, without its blocks.

    Row 0 is the wall, which slips by -u dt in every step; row N + 1 is a spring that never pulls.

    belt_step : (W,) u dt.
    """
    state = zeros((len(belt_step) // LANES, n_blocks + 2, _ROW))
    state[:, 0, SLIP_STEP : SLIP_STEP + LANES] = -belt_step.reshape(-1, LANES)
    return state.reshape(len(state), -1)


def write_blocks(group, lane, step, blocks):
    """Let a chain be in another state at the start of the step of that index.

    In the middle of a stretch it goes on without series, as if the stretch had begun without slip.
    """
    state = group.chains.state.reshape(len(group.chains.state), -1, _ROW)
    rows = state[lane // LANES, 1 : group.n_blocks + 1]
    place = lane % LANES
    square = group.time_step * group.time_step
    kinetic = blocks.direction * (group.law.friction_ratio * square)
    start = blocks.displacement - group.belt_step[lane] * float(step % STRETCH)
    rows[:, place::LANES] = 0.0
    for field, values in (
        (DISPLACEMENT, blocks.displacement),
        (VELOCITY, blocks.velocity),
        (DIRECTION, blocks.direction),
        (DISSIPATED, blocks.dissipated),
        (SLIP_STEP, blocks.slip_step),
        (ACCELERATION, blocks.acceleration),
        (_PUSH, np.where(blocks.direction != 0, square, 0.0)),
        (_KINETIC, kinetic * group.law.static_friction),
        (_KINETIC_NOISE, kinetic * group.noise[lane]),
        (_START, start),
        (_DEFORMATION, np.diff(start, prepend=0.0)),
        (_LOSS, blocks.dissipated),
        (THRESHOLD, blocks.threshold),
    ):
        rows[:, field + place] = values


def of_blocks(state, field, n_blocks):
    """One field of the state as an array (N, W)."""
    state = state.reshape(len(state), -1, _ROW)
    return np.concatenate(state[:, 1 : n_blocks + 1, field : field + LANES], axis=1)


# Rows are of constant length, so that one register points to all fields of a block.


@inlined
def _get(state, vector, block, field):
    return load_wide(state, (vector, block * _ROW + field))


@inlined
def _put(state, vector, block, field, value):
    store(state, (vector, block * _ROW + field), value)


# --- stretches ---


@inlined
def _expand(state, vector, spring, deformation, law):
    """Write the power series of a tension; returns the tension."""
    pull, slope, excess = tension_and_slope(deformation, law)
    rate = select(deformation < 0.0, -law.compression_rate, law.extension_rate)
    rate = select(excess == 0.0, 0.0, rate)
    _put(state, vector, spring, _DEFORMATION, deformation)
    _put(state, vector, spring, _SERIES, pull)
    # every derivative is `rate` times the one before
    _put(state, vector, spring, _SERIES + LANES, slope)
    second = slope * rate * (1.0 / 2.0)
    _put(state, vector, spring, _SERIES + 2 * LANES, second)
    third = second * rate * (1.0 / 3.0)
    _put(state, vector, spring, _SERIES + 3 * LANES, third)
    fourth = third * rate * (1.0 / 4.0)
    _put(state, vector, spring, _SERIES + 4 * LANES, fourth)
    _put(state, vector, spring, _SERIES + 5 * LANES, fourth * rate * (1.0 / 5.0))
    return pull


@inlined
def _prepare(state, vector, n_blocks, strongest, square, law):
    """Start a stretch: write the series, bound the motion.

    strongest : kinetic friction. Returns the bound A on |a| dt^2, and bits: springs that need the
    law, blocks that might turn, and whether the bounds fail for some chain.

    While tensions change by at most `change`, F_ex changes by twice as much, which bounds a. Slips
    then change by less than K |w| + K (K + 11)/2 A in K steps, of which 5 A a step are for blocks
    that stick, where |w| < 5 A. And this must keep the tensions within `change`.
    """
    limit = law.linear_limit
    highest_rate = max(law.compression_rate, law.extension_rate)
    change = _TENSION_SHARE * law.static_friction
    left = _get(state, vector, 0, _START)
    pull = left
    fastest = left
    greatest = left
    for block in range(1, n_blocks + 1):
        displacement = _get(state, vector, block, _START)
        next_pull = _expand(state, vector, block, displacement - left, law)
        force = next_pull - pull
        if block > 1:
            _put(state, vector, block - 1, _FORCE, force)
            greatest = maximum(abs(force), greatest)
        fastest = maximum(abs(_get(state, vector, block, ACCELERATION)), fastest)
        left = displacement
        pull = next_pull
    _put(state, vector, n_blocks, _FORCE, -pull)
    greatest = maximum(abs(pull), greatest) + (strongest + 2.0 * change)
    fastest = maximum(greatest * square, fastest)

    bent = 0
    watched = 0
    drift = fastest * (STRETCH * (STRETCH + 11.0))
    hold = drift >= 0.0
    beyond = 0.0 * drift
    w = _get(state, vector, n_blocks, SLIP_STEP)
    for block in range(n_blocks, 0, -1):
        left = _get(state, vector, block - 1, SLIP_STEP)
        span = fma(abs(w - left), STRETCH, drift)
        slope = _get(state, vector, block, _SERIES + LANES)
        second = _get(state, vector, block, _SERIES + 2 * LANES)
        deformation = _get(state, vector, block, _DEFORMATION)
        # e^y < 1 + 3/2 y for y < 1/2
        own = slope * span * fma(span, 1.5 * highest_rate, 1.0)
        hold = hold & (own <= change) & (span * highest_rate <= 0.5)
        # second / slope is half the rate
        serves = (span < abs(abs(deformation) - limit)) & (
            span * abs(second) <= 0.5 * _SERIES_REACH * slope
        )
        if mask_bits(serves) != _ALL:
            bent |= 1 << (block - 1)
            _bend(state, vector, block, serves)
        force = _get(state, vector, block, _FORCE)
        direction = _get(state, vector, block, DIRECTION)
        velocity = _get(state, vector, block, VELOCITY)
        threshold = _get(state, vector, block, THRESHOLD)
        # v_r > w - A/3 and K + 1 times the strongest braking
        reach = own + beyond
        braking = minimum(fma(direction, force, -strongest) - reach, 0.0) * square
        slowest = fma(braking, STRETCH + 1.0, fma(direction, w, -0.34 * fastest))
        goes_on = select(
            direction == 0.0, threshold - abs(force) - reach, minimum(direction * velocity, slowest)
        )
        if mask_bits(goes_on > 0.0) != _ALL:
            watched |= 1 << (block - 1)
        beyond = own
        w = left
    loose = mask_bits(hold) != _ALL
    if loose:
        bent = -1
        watched = -1
        for block in range(1, n_blocks + 1):
            _bend(state, vector, block, hold)
    return fastest, bent, watched, loose


@inlined
def _bend(state, vector, spring, serves):
    """Do without the series of a spring in the lanes where it does not serve: all powers are 0."""
    for power in range(6):
        place = _SERIES + power * LANES
        coefficient = _get(state, vector, spring, place)
        _put(state, vector, spring, place, select(serves, coefficient, 0.0))


@inlined
def _resume(state, vector, n_blocks):
    """Bits of the springs that need the law, in the middle of a stretch."""
    bent = 0
    for spring in range(1, n_blocks + 1):
        # a spring has a slope
        if mask_bits(_get(state, vector, spring, _SERIES + LANES) == 0.0):
            bent |= 1 << (spring - 1)
    return bent


@inlined
def _conclude(state, vector, n_blocks, belt_travel, ended):
    """Bring displacements and losses up to date; if the stretch has ended, count from there."""
    for block in range(1, n_blocks + 1):
        slip = _get(state, vector, block, _SLIP)
        displacement = _get(state, vector, block, _START) + (belt_travel + slip)
        unsettled = slip - _get(state, vector, block, _SETTLED)
        kinetic = _get(state, vector, block, _KINETIC)
        loss = fma(kinetic, unsettled, _get(state, vector, block, _LOSS))
        _put(state, vector, block, DISPLACEMENT, displacement)
        _put(state, vector, block, DISSIPATED, loss)
        if ended:
            _put(state, vector, block, _START, displacement)
            _put(state, vector, block, _LOSS, loss)
            _put(state, vector, block, _SLIP, 0.0 * slip)
            _put(state, vector, block, _SETTLED, 0.0 * slip)


# --- steps ---


@inlined
def _tension(state, vector, spring, growth):
    """Tension of a spring whose deformation has changed by `growth` since the stretch began."""
    # summed by halves, which keeps the chain of operations short
    growth_2 = growth * growth
    t0 = _get(state, vector, spring, _SERIES)
    t1 = _get(state, vector, spring, _SERIES + LANES)
    t2 = _get(state, vector, spring, _SERIES + 2 * LANES)
    t3 = _get(state, vector, spring, _SERIES + 3 * LANES)
    t4 = _get(state, vector, spring, _SERIES + 4 * LANES)
    t5 = _get(state, vector, spring, _SERIES + 5 * LANES)
    high = fma(fma(t5, growth, t4), growth_2, fma(t3, growth, t2))
    return fma(high, growth_2, fma(t1, growth, t0))


@inlined
def _apply_law(state, vector, n_blocks, bent, law):
    """Find the tensions of the springs in `bent` by the law, in the lanes without a series."""
    for spring in range(1, n_blocks + 1):
        if (bent >> (spring - 1)) & 1:
            deformation = _get(state, vector, spring, _DEFORMATION) + (
                _get(state, vector, spring, _SLIP) - _get(state, vector, spring - 1, _SLIP)
            )
            without = _get(state, vector, spring, _SERIES + LANES) == 0.0
            pull = _get(state, vector, spring, _SERIES)
            pull = select(without, tension(deformation, law), pull)
            _put(state, vector, spring, _SERIES, pull)


@inlined
def _force(state, vector, block):
    """F_ex on a block."""
    slip = _get(state, vector, block, _SLIP)
    pull = _tension(state, vector, block, slip - _get(state, vector, block - 1, _SLIP))
    growth = _get(state, vector, block + 1, _SLIP) - slip
    return _tension(state, vector, block + 1, growth) - pull


@inlined
def _margin(state, vector, block, force):
    """How far a block is from a turn: not where it is positive."""
    direction = _get(state, vector, block, DIRECTION)
    threshold = _get(state, vector, block, THRESHOLD)
    velocity = _get(state, vector, block, VELOCITY)
    return select(direction == 0.0, threshold - abs(force), direction * velocity)


@inlined
def _move(state, vector, n_blocks, noisy):
    """Advance all blocks by the scheme; returns the pull of the first spring."""
    slip = _get(state, vector, n_blocks, _SLIP)
    pull = 0.0 * slip
    for block in range(n_blocks, 0, -1):
        left = _get(state, vector, block - 1, _SLIP)
        next_pull = pull
        pull = _tension(state, vector, block, slip - left)
        w = _get(state, vector, block, SLIP_STEP)
        kinetic = _get(state, vector, block, _KINETIC)
        if noisy:
            added = _get(state, vector, block, _KINETIC_NOISE)
            added = added * _get(state, vector, block, _NORMAL)
            kinetic = kinetic + added
        a = fma(_get(state, vector, block, _PUSH), next_pull - pull, -kinetic)
        w = w + a
        _put(state, vector, block, ACCELERATION, a)
        _put(state, vector, block, SLIP_STEP, w)
        _put(state, vector, block, _SLIP, slip + w)
        if noisy:
            loss = _get(state, vector, block, _LOSS)
            _put(state, vector, block, _LOSS, fma(added, w, loss))
        slip = left
    return pull


@inlined
def _record(state, vector, block, lane, slips, time, square, events):
    """Record the start (slips 1) or end (slips 0) of a slip."""
    place = block * _ROW + lane
    force = state[vector, place + _FORCE]
    here = state[vector, place + DISPLACEMENT]
    loss = state[vector, place + DISSIPATED] / square
    record_event(vector * LANES + lane, time, block - 1, slips, force, here, loss, events)


@inlined
def _turn(state, vector, block, force, belt_travel, law, noise, square, time, events):
    """Apply the stick and slip rules to a block and record what they change."""
    w = _get(state, vector, block, SLIP_STEP)
    old = _get(state, vector, block, DIRECTION)
    slipping = old != 0.0
    # drawn anew while slipping, kept while stuck
    drawn = fma(noise, _get(state, vector, block, _NORMAL), law.static_friction)
    threshold = select(slipping, drawn, _get(state, vector, block, THRESHOLD))
    free = select(abs(force) > threshold, copysign(1.0, force), 0.0)
    goes_on = slipping & (old * _get(state, vector, block, VELOCITY) > 0.0)
    new = select(goes_on, old, free)
    changed = new != old
    if mask_bits(changed):
        moving = new != 0.0
        slip = _get(state, vector, block, _SLIP)
        settled = _get(state, vector, block, _SETTLED)
        loss = _get(state, vector, block, _LOSS)
        loss = select(
            changed, fma(_get(state, vector, block, _KINETIC), slip - settled, loss), loss
        )
        displacement = _get(state, vector, block, _START) + (belt_travel + slip)
        _put(state, vector, block, _LOSS, loss)
        _put(state, vector, block, _SETTLED, select(changed, slip, settled))
        _put(state, vector, block, _FORCE, force)
        _put(state, vector, block, DISPLACEMENT, displacement)
        _put(state, vector, block, DISSIPATED, loss)
        sticks = mask_bits(changed & slipping)
        slips = mask_bits(changed & moving)
        for lane in range(LANES):
            if (sticks >> lane) & 1:
                _record(state, vector, block, lane, 0, time, square, events)
            if (slips >> lane) & 1:
                _record(state, vector, block, lane, 1, time, square, events)
        turned = old * new != 0.0
        before = _get(state, vector, block, ACCELERATION)
        kinetic = new * (law.friction_ratio * square)
        _put(state, vector, block, THRESHOLD, threshold)
        _put(state, vector, block, SLIP_STEP, select(turned, w, 0.0))
        _put(state, vector, block, ACCELERATION, select(turned, before, 0.0))
        _put(state, vector, block, DIRECTION, new)
        _put(state, vector, block, _PUSH, select(moving, square, 0.0))
        _put(state, vector, block, _KINETIC, kinetic * law.static_friction)
        _put(state, vector, block, _KINETIC_NOISE, kinetic * noise)


@inlined
def _keep_accelerations(state, vector, n_blocks, blocks):
    """Before a step, keep a(t-dt) of some blocks in place of the velocity."""
    for block in range(1, n_blocks + 1):
        if (blocks >> (block - 1)) & 1:
            _put(state, vector, block, VELOCITY, _get(state, vector, block, ACCELERATION))


@inlined
def _find_velocities(state, vector, n_blocks, blocks):
    """Velocities of the same blocks after the step."""
    for block in range(1, n_blocks + 1):
        if (blocks >> (block - 1)) & 1:
            before = _get(state, vector, block, VELOCITY)
            a = _get(state, vector, block, ACCELERATION)
            w = _get(state, vector, block, SLIP_STEP)
            velocity = fma(a, 5.0 / 6.0, fma(before, -1.0 / 3.0, w))
            _put(state, vector, block, VELOCITY, velocity)


@inlined
def _near(state, vector, block, level, belt, fastest):
    """Whether a block of some chain may come to its level in the stretch."""
    away = _get(state, vector, block, _START) - level
    w = _get(state, vector, block, SLIP_STEP)
    span = fma(fastest, 0.5 * STRETCH * (STRETCH + 11.0), STRETCH * abs(w + belt))
    return mask_bits(abs(away) > span) != _ALL


@inlined
def _cross(
    state,
    vector,
    n_blocks,
    belt,
    belt_travel,
    level,
    time,
    time_step,
    crossings,
):
    """Record the chains whose block came down through its level in the step that ends at `time`.

    belt_travel : u t since the start of the stretch.
    """
    section_block = crossings.block + 1
    slip = _get(state, vector, section_block, _SLIP)
    after = _get(state, vector, section_block, _START) + (belt_travel + slip) - level
    move = _get(state, vector, section_block, SLIP_STEP) + belt
    hits = mask_bits((after < 0.0) & (after - move >= 0.0))
    if hits:
        back = after / move
        for lane in range(LANES):
            if (hits >> lane) & 1:
                chain = vector * LANES + lane
                share = extract(back, lane)
                slot = crossings.count[chain]
                crossings.count[chain] = slot + 1
                crossings.rows[chain, slot, 0] = time - share * time_step
                for block in range(1, n_blocks + 1):
                    place = state[vector, block * _ROW + _START + lane] + (
                        extract(belt_travel, lane) + state[vector, block * _ROW + _SLIP + lane]
                    )
                    move_one = state[vector, block * _ROW + SLIP_STEP + lane] + extract(belt, lane)
                    velocity = state[vector, block * _ROW + VELOCITY + lane]
                    velocity -= share * state[vector, block * _ROW + ACCELERATION + lane]
                    crossings.rows[chain, slot, block] = place - share * move_one
                    crossings.rows[chain, slot, n_blocks + block] = velocity / time_step


@inlined
def _sample(state, vector, n_blocks, time_step, samples, row):
    """Write one row of samples of the vector's chains."""
    lane = vector * LANES
    for column in range(n_blocks - samples.first_block):
        block = 1 + samples.first_block + column
        velocity = _get(state, vector, block, VELOCITY)
        noise = _get(state, vector, block, _KINETIC_NOISE)
        kinetic = _get(state, vector, block, _KINETIC)
        kinetic = fma(noise, _get(state, vector, block, _NORMAL), kinetic)
        displacement = _get(state, vector, block, DISPLACEMENT)
        store(samples.values, (row, 0, column, lane), displacement)
        store(samples.values, (row, 1, column, lane), velocity / time_step)
        store(samples.values, (row, 2, column, lane), -kinetic / (time_step * time_step))


@kernel
def verlet_steps(first_step, n_steps, group, records):
    """Advance the chains of a group by at most n_steps steps of the Appendix; returns the number.

    It stops early when a buffer of events or crossings is nearly full.

    first_step : index of the first step (time = index * dt). group : Group; records : Records.
    """
    law, n_blocks, noisy = group.law, group.n_blocks, group.noisy
    state, streams, wall_pull = group.chains.state, group.chains.streams, group.chains.wall_pull
    events, crossings = records.events, records.crossings
    sample_stride = records.samples.stride
    section_block = crossings.block + 1
    time_step = group.time_step
    square = time_step * time_step
    # sixteen chains take this many steps before the next sixteen do, so that they stay in the
    # fastest memory; it cannot fill more than a quarter of a buffer
    visit = min(events.rows.shape[1] // (8 * n_blocks), crossings.rows.shape[1] // 4)
    last = first_step + n_steps
    step = first_step
    row = 0
    full = False
    while step < last and not full:
        start = step
        pause = start + visit
        pause = max(pause - pause % STRETCH, min(pause, (start // STRETCH + 1) * STRETCH))
        step = min(last, pause, (start // sample_stride + 1) * sample_stride)
        sampled = step % sample_stride == 0
        for vector in range(len(state)):
            lane = vector * LANES
            spread = load_wide(group.noise, (lane,))
            belt = load_wide(group.belt_step, (lane,))
            level = load_wide(crossings.level, (lane,))
            pull = load_wide(wall_pull, (lane,))
            strongest = fma(spread, _LARGEST_DEVIATE, law.static_friction) * law.friction_ratio
            now = start
            while now < step:
                base = now - now % STRETCH
                end = min(step, base + STRETCH)
                near = section_block > 0
                if now == base:
                    fastest, bent, watched, loose = _prepare(
                        state, vector, n_blocks, strongest, square, law
                    )
                    if near and not loose:
                        near = _near(state, vector, section_block, level, belt, fastest)
                else:
                    bent = _resume(state, vector, n_blocks)
                    watched = -1
                if near:
                    watched = -1
                # most steps: a loop with nothing else in it leaves the registers to `_move`
                if not (noisy or bent or watched):
                    for quiet_step in range(now, end - 1):
                        _put(state, vector, 0, _SLIP, belt * float(base - quiet_step))
                        pull = pull + _move(state, vector, n_blocks, False)
                    now = end - 1
                for step_index in range(now, end):
                    if noisy:
                        for block in range(1, n_blocks + 1, 2):
                            first, second = normal_pairs_wide(streams, lane)
                            _put(state, vector, block, _NORMAL, first)
                            _put(state, vector, block + 1, _NORMAL, second)
                    belt_travel = belt * float(step_index - base)
                    _put(state, vector, 0, _SLIP, -belt_travel)
                    if bent:
                        _apply_law(state, vector, n_blocks, bent, law)
                    if watched:
                        for block in range(1, n_blocks + 1):
                            if (watched >> (block - 1)) & 1:
                                force = _force(state, vector, block)
                                if mask_bits(_margin(state, vector, block, force) <= 0.0):
                                    _turn(
                                        state,
                                        vector,
                                        block,
                                        force,
                                        belt_travel,
                                        law,
                                        spread,
                                        square,
                                        step_index * time_step,
                                        events,
                                    )
                    # velocities serve the rules, samples and crossings
                    kept = watched if step_index < end - 1 else -1
                    if kept:
                        _keep_accelerations(state, vector, n_blocks, kept)
                    if noisy:
                        pull = pull + _move(state, vector, n_blocks, True)
                    else:
                        pull = pull + _move(state, vector, n_blocks, False)
                    if kept:
                        _find_velocities(state, vector, n_blocks, kept)
                    if near:
                        _cross(
                            state,
                            vector,
                            n_blocks,
                            belt,
                            belt * float(step_index + 1 - base),
                            level,
                            (step_index + 1) * time_step,
                            time_step,
                            crossings,
                        )
                now = end
                _conclude(state, vector, n_blocks, belt * float(end - base), end == base + STRETCH)
            store(wall_pull, (lane,), pull)
            if sampled:
                _sample(state, vector, n_blocks, time_step, records.samples, row)
            for chain in range(lane, lane + LANES):
                if events.count[chain] + 2 * n_blocks * visit > events.rows.shape[1]:
                    full = True
                if crossings.count[chain] + visit > crossings.rows.shape[1]:
                    full = True
        row += sampled
    return step - first_step
