"""The paper's numerical scheme (Appendix), step for step, for many chains at once.

In the frame of the belt a stuck block has exactly zero relative velocity. With the slip step
w(t) = x(t) - x(t-dt) - u dt the printed formulas read

    w(t+dt) = w(t) + a(t) dt^2,                               x(t+dt) = x(t) + u dt + w(t+dt)
    v_r(t+dt) dt = w(t) + 11/6 a(t) dt^2 - 1/3 a(t-dt) dt^2

which rounds better than 2x(t) - x(t-dt) and is the same scheme. Velocities are kept times dt and
accelerations times dt^2, and all three along the direction of slip, so that a block may turn where
its velocity is not positive.

Hardly any step turns a block (stick to slip, slip to stick, or reversal). `_forces` finds the
forces and how far the blocks are from a turn; only where one is due, `_turn` applies the stick and
slip rules (`beltrepro.model.friction.next_direction`) and records events. `_move` is the formulas
above for all blocks: a stuck block has direction, push and kinetic friction zero, and in place of
w, and so of v_r dt, its threshold. Both kinds then turn where v_r dt - stuck |F_ex| <= 0.
"""

import numpy as np

from beltrepro.engine.events import (
    EVENT_BLOCK,
    EVENT_DISSIPATED,
    EVENT_FORCE,
    EVENT_POSITION,
    EVENT_SLIP,
    EVENT_TIME,
)
from beltrepro.engine.law import FRICTION_RATIO, STATIC_FRICTION, spring_law, tension
from beltrepro.engine.memory import zeros
from beltrepro.engine.noise import normal_pairs_wide
from beltrepro.engine.simd import (
    WIDE_LANES,
    copysign,
    extract,
    fma,
    load_wide,
    mask_bits,
    minimum,
    select,
    store,
)
from beltrepro.engine.vector import inlined, kernel

LANES = WIDE_LANES

# The state of a block of sixteen chains: twelve vectors in a row, at these offsets.
# displacement from the rest position; w, v_r dt and a dt^2; direction of slip (0 if stuck)
DISPLACEMENT, SLIP_STEP, VELOCITY, ACCELERATION, DIRECTION = range(0, 5 * LANES, LANES)
# 1 if stuck; direction times dt^2; kinetic friction times dt^2: its mean and what noise adds
STUCK, PUSH, KINETIC, KINETIC_NOISE = range(5 * LANES, 9 * LANES, LANES)
# friction loss times dt^2; force and normal deviate of the last step
DISSIPATED, FORCE, NORMAL = range(9 * LANES, 12 * LANES, LANES)
_ROW = 12 * LANES


def initial_state(displacement, threshold):
    """State (W/16, N rounded up to even, row) of W chains with all blocks stuck.

    displacement, threshold : (N, W).
    """
    n_blocks, lanes = displacement.shape
    state = zeros((lanes // LANES, n_blocks + n_blocks % 2, _ROW))
    for field, values in (
        (DISPLACEMENT, displacement),
        (SLIP_STEP, threshold),
        (VELOCITY, threshold),
        (STUCK, np.ones_like(threshold)),
    ):
        vectors = values.reshape(n_blocks, -1, LANES).swapaxes(0, 1)
        state[:, :n_blocks, field : field + LANES] = vectors
    return state


def of_blocks(state, field, n_blocks):
    """One field of the state as an array (N, W)."""
    return np.concatenate(state[:, :n_blocks, field : field + LANES], axis=1)


@inlined
def _margin(state, vector, block, force):
    """Keep the force on a block; returns how far the block is from a turn."""
    store(state, (vector, block, FORCE), force)
    stuck = load_wide(state, (vector, block, STUCK))
    return fma(-stuck, abs(force), load_wide(state, (vector, block, VELOCITY)))


@inlined
def _forces(state, vector, n_blocks, law):
    """Forces on the blocks; returns the first spring's pull and the least margin to a turn."""
    displacement = load_wide(state, (vector, 0, DISPLACEMENT))
    margin = load_wide(state, (vector, 0, VELOCITY))
    wall_pull = tension(displacement, law)
    pull = wall_pull
    for block in range(1, n_blocks):
        next_displacement = load_wide(state, (vector, block, DISPLACEMENT))
        next_pull = tension(next_displacement - displacement, law)
        margin = minimum(_margin(state, vector, block - 1, next_pull - pull), margin)
        displacement = next_displacement
        pull = next_pull
    margin = minimum(_margin(state, vector, n_blocks - 1, -pull), margin)
    return wall_pull, margin


@inlined
def _record(state, vector, block, lane, kind, time, square, events, event_count):
    """Record the start (kind 1) or end (kind 0) of a slip."""
    chain = vector * LANES + lane
    slot = event_count[chain]
    events[chain, slot, EVENT_TIME] = time
    events[chain, slot, EVENT_BLOCK] = block
    events[chain, slot, EVENT_SLIP] = kind
    events[chain, slot, EVENT_FORCE] = state[vector, block, FORCE + lane]
    events[chain, slot, EVENT_POSITION] = state[vector, block, DISPLACEMENT + lane]
    events[chain, slot, EVENT_DISSIPATED] = state[vector, block, DISSIPATED + lane] / square
    event_count[chain] = slot + 1


@inlined
def _turn(state, vector, n_blocks, mean, ratio, noise, square, time, events, event_count):
    """Apply the stick and slip rules to all blocks and record what they change."""
    for block in range(n_blocks):
        force = load_wide(state, (vector, block, FORCE))
        w = load_wide(state, (vector, block, SLIP_STEP))
        old = load_wide(state, (vector, block, DIRECTION))
        slipping = old != 0.0
        # drawn anew while slipping, kept while stuck
        drawn = fma(noise, load_wide(state, (vector, block, NORMAL)), mean)
        threshold = select(slipping, drawn, w)
        free = select(abs(force) > threshold, copysign(1.0, force), 0.0)
        goes_on = slipping & (load_wide(state, (vector, block, VELOCITY)) > 0.0)
        new = select(goes_on, old, free)
        changed = new != old
        if mask_bits(changed):
            moving = new != 0.0
            sticks = mask_bits(changed & slipping)
            slips = mask_bits(changed & moving)
            for lane in range(LANES):
                if (sticks >> lane) & 1:
                    _record(state, vector, block, lane, 0, time, square, events, event_count)
                if (slips >> lane) & 1:
                    _record(state, vector, block, lane, 1, time, square, events, event_count)
            turned = old * new
            before = load_wide(state, (vector, block, ACCELERATION))
            kinetic = select(moving, ratio * square, 0.0)
            store(state, (vector, block, SLIP_STEP), select(moving, turned * w, threshold))
            store(state, (vector, block, ACCELERATION), turned * before)
            store(state, (vector, block, DIRECTION), new)
            store(state, (vector, block, STUCK), select(moving, 0.0, 1.0))
            store(state, (vector, block, PUSH), new * square)
            store(state, (vector, block, KINETIC), kinetic * mean)
            store(state, (vector, block, KINETIC_NOISE), kinetic * noise)


@inlined
def _move(state, vector, n_blocks, belt_step, noisy):
    """Advance all blocks by the scheme."""
    for block in range(n_blocks):
        kinetic = load_wide(state, (vector, block, KINETIC))
        if noisy:
            normal = load_wide(state, (vector, block, NORMAL))
            kinetic = fma(load_wide(state, (vector, block, KINETIC_NOISE)), normal, kinetic)
        push = load_wide(state, (vector, block, PUSH))
        before = load_wide(state, (vector, block, ACCELERATION))
        w = load_wide(state, (vector, block, SLIP_STEP))
        direction = load_wide(state, (vector, block, DIRECTION))
        displacement = load_wide(state, (vector, block, DISPLACEMENT))
        dissipated = load_wide(state, (vector, block, DISSIPATED))
        a = fma(push, load_wide(state, (vector, block, FORCE)), -kinetic)
        velocity = fma(a, 11.0 / 6.0, fma(before, -1.0 / 3.0, w))
        w = w + a
        store(state, (vector, block, ACCELERATION), a)
        store(state, (vector, block, VELOCITY), velocity)
        store(state, (vector, block, SLIP_STEP), w)
        store(state, (vector, block, DISSIPATED), fma(kinetic, w, dissipated))
        store(state, (vector, block, DISPLACEMENT), displacement + fma(direction, w, belt_step))


@inlined
def _cross(
    state, vector, n_blocks, belt_step, section_block, level, time, time_step, crossings, count
):
    """Record the chains whose block came down through its level in the step that ends at `time`."""
    after = load_wide(state, (vector, section_block, DISPLACEMENT)) - level
    direction = load_wide(state, (vector, section_block, DIRECTION))
    w = load_wide(state, (vector, section_block, SLIP_STEP))
    move = fma(direction, w, belt_step)
    hits = mask_bits((after < 0.0) & (after - move >= 0.0))
    if hits:
        back = after / move
        for lane in range(LANES):
            if (hits >> lane) & 1:
                chain = vector * LANES + lane
                share = extract(back, lane)
                slot = count[chain]
                count[chain] = slot + 1
                crossings[chain, slot, 0] = time - share * time_step
                for block in range(n_blocks):
                    sign = state[vector, block, DIRECTION + lane]
                    move_one = sign * state[vector, block, SLIP_STEP + lane] + extract(
                        belt_step, lane
                    )
                    velocity = state[vector, block, VELOCITY + lane]
                    velocity -= share * state[vector, block, ACCELERATION + lane]
                    crossings[chain, slot, 1 + block] = (
                        state[vector, block, DISPLACEMENT + lane] - share * move_one
                    )
                    crossings[chain, slot, 1 + n_blocks + block] = sign * velocity / time_step


@inlined
def _sample(state, vector, n_blocks, first_sampled, time_step, samples, row):
    """Write one row of samples of the vector's chains."""
    lane = vector * LANES
    for block in range(first_sampled, n_blocks):
        column = block - first_sampled
        direction = load_wide(state, (vector, block, DIRECTION))
        velocity = load_wide(state, (vector, block, VELOCITY))
        noise = load_wide(state, (vector, block, KINETIC_NOISE))
        kinetic = load_wide(state, (vector, block, KINETIC))
        kinetic = fma(noise, load_wide(state, (vector, block, NORMAL)), kinetic)
        displacement = load_wide(state, (vector, block, DISPLACEMENT))
        store(samples, (row, 0, column, lane), displacement)
        store(samples, (row, 1, column, lane), direction * velocity / time_step)
        store(samples, (row, 2, column, lane), -direction * kinetic / (time_step * time_step))


@kernel
def verlet_steps(
    n_blocks,
    first_step,
    n_steps,
    time_step,
    constants,
    belt_step,
    noise,
    noisy,
    state,
    wall_pull,
    streams,
    sample_stride,
    first_sampled,
    samples,
    events,
    event_count,
    section_block,
    section_displacement,
    crossings,
    crossing_count,
):
    """Advance W chains by at most n_steps steps of the Appendix; returns the steps done.

    It stops early when a buffer of events or crossings is nearly full.

    first_step : index of the first step (time = index * time_step).
    constants : (9,) see `law_constants`; belt_step : (W,) u*dt; noise : (W,) sigma;
    noisy : whether any of them is not zero.
    state : see `initial_state`; wall_pull : (W,) sum of the first spring's pull over the steps;
    streams : (4, W) random streams.
    sample_stride : samples are taken where the step index is a multiple of it;
    first_sampled : first block sampled;
    samples : (S, 3, N-first_sampled, W) displacement, relative velocity, kinetic friction.
    events : (W, E, 6), crossings : (W, C, 1+2N) and their counts (W,).
    section_block : 0-based, or -1 for none; section_displacement : (W,).
    """
    law = spring_law(constants)
    mean = constants[STATIC_FRICTION]
    ratio = constants[FRICTION_RATIO]
    square = time_step * time_step
    # sixteen chains take this many steps before the next sixteen do, so that they stay in the
    # fastest memory; it cannot fill more than a quarter of a buffer
    stretch = min(events.shape[1] // (8 * n_blocks), crossings.shape[1] // 4)
    last = first_step + n_steps
    step = first_step
    row = 0
    full = False
    while step < last and not full:
        start = step
        step = min(last, start + stretch, (start // sample_stride + 1) * sample_stride)
        sampled = step % sample_stride == 0
        for vector in range(len(state)):
            lane = vector * LANES
            spread = load_wide(noise, (lane,))
            belt = load_wide(belt_step, (lane,))
            level = load_wide(section_displacement, (lane,))
            pull = load_wide(wall_pull, (lane,))
            for now in range(start, step):
                first_pull, margin = _forces(state, vector, n_blocks, law)
                pull = pull + first_pull
                if noisy:
                    for block in range(0, n_blocks, 2):
                        first, second = normal_pairs_wide(streams, lane)
                        store(state, (vector, block, NORMAL), first)
                        store(state, (vector, block + 1, NORMAL), second)
                if mask_bits(margin <= 0.0):
                    time = now * time_step
                    _turn(
                        state,
                        vector,
                        n_blocks,
                        mean,
                        ratio,
                        spread,
                        square,
                        time,
                        events,
                        event_count,
                    )
                if noisy:
                    _move(state, vector, n_blocks, belt, True)
                else:
                    _move(state, vector, n_blocks, belt, False)
                if section_block >= 0:
                    time = (now + 1) * time_step
                    _cross(
                        state,
                        vector,
                        n_blocks,
                        belt,
                        section_block,
                        level,
                        time,
                        time_step,
                        crossings,
                        crossing_count,
                    )
            store(wall_pull, (lane,), pull)
            if sampled:
                _sample(state, vector, n_blocks, first_sampled, time_step, samples, row)
            for chain in range(lane, lane + LANES):
                if event_count[chain] + 2 * n_blocks * stretch > events.shape[1]:
                    full = True
                if crossing_count[chain] + stretch > crossings.shape[1]:
                    full = True
        row += sampled
    return step - first_step
