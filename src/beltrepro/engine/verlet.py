"""The paper's numerical scheme (Appendix), step for step, for many chains at once.

In the frame of the belt a stuck block has exactly zero relative velocity. With the slip step
w(t) = x(t) - x(t-dt) - u dt the printed formulas read

    w(t+dt) = w(t) + a(t) dt^2,                               x(t+dt) = x(t) + u dt + w(t+dt)
    v_r(t+dt) dt = w(t) + 11/6 a(t) dt^2 - 1/3 a(t-dt) dt^2

which rounds better than 2x(t) - x(t-dt) and is the same scheme. Velocities and accelerations are
kept times dt and dt^2, so that a step takes no more than the additions above.

Most steps change the direction of no block. `_forces` finds the forces on the blocks and how far
each is from a change; only where one is due, `_turn` applies the stick and slip rules
(`beltrepro.model.friction.next_direction`) and records events; `_move` is the formulas above, in
which a stuck block takes the factor zero instead of a branch.
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
from beltrepro.engine.noise import normal_pairs
from beltrepro.engine.simd import (
    LANES,
    copysign,
    extract,
    fma,
    load,
    mask_bits,
    minimum,
    select,
    spread,
    store,
)
from beltrepro.engine.vector import inlined, kernel, separate_arrays

# What is kept of a block, for eight chains each, as offsets into a row of the state.
# displacement from the rest position; w; v_r dt and a dt^2 of the last step; direction of slip;
# threshold F_st while stuck; friction loss times dt^2
(DISPLACEMENT, SLIP_STEP, VELOCITY, ACCELERATION, DIRECTION, THRESHOLD, DISSIPATED) = range(
    0, 7 * LANES, LANES
)
# force and normal deviate of this step
FORCE, NORMAL = range(7 * LANES, 9 * LANES, LANES)
# what follows from direction and threshold: 1 if stuck; F_st if stuck; dt^2 if moving; kinetic
# friction times dt^2, its mean and its standard deviation, with the sign of the direction
STUCK, HOLD, PUSH, KINETIC, KINETIC_NOISE = range(9 * LANES, 14 * LANES, LANES)
FIELDS = 14


def initial_state(displacement, threshold):
    """The state of W chains with all blocks stuck; arguments (N, W).

    Shape (W/8, N rounded up to even, FIELDS * 8): eight chains of a block lie together.
    """
    n_blocks, lanes = displacement.shape
    state = zeros((lanes // LANES, n_blocks + n_blocks % 2, FIELDS * LANES))
    for field, values in (
        (DISPLACEMENT, displacement),
        (THRESHOLD, threshold),
        (HOLD, threshold),
        (STUCK, np.ones_like(threshold)),
    ):
        rows = values.reshape(n_blocks, -1, LANES).transpose(1, 0, 2)
        state[:, :n_blocks, field : field + LANES] = rows
    return state


def of_blocks(state, field, n_blocks):
    """One field of the state as an array (N, W)."""
    return np.concatenate(state[:, :n_blocks, field : field + LANES], axis=1)


@inlined
def _forces(state, vector, n_blocks, law):
    """Forces on the blocks; returns the first spring's pull and the least margin to a change.

    The margin of a slipping block is its velocity along its direction, that of a stuck block what
    its threshold exceeds the force by.
    """
    margin = spread(1.0)
    before = load(state, (vector, 0, DISPLACEMENT))
    wall_pull = tension(before, law)
    pull = wall_pull
    for block in range(n_blocks):
        if block + 1 < n_blocks:
            displacement = load(state, (vector, block + 1, DISPLACEMENT))
            next_pull = tension(displacement - before, law)
            before = displacement
        else:
            next_pull = spread(0.0)
        force = next_pull - pull
        pull = next_pull
        store(state, (vector, block, FORCE), force)
        slack = fma(
            load(state, (vector, block, DIRECTION)),
            load(state, (vector, block, VELOCITY)),
            load(state, (vector, block, HOLD)),
        )
        slack = fma(-load(state, (vector, block, STUCK)), abs(force), slack)
        margin = minimum(slack, margin)
    return wall_pull, margin


@inlined
def _record(state, vector, block, lane, kind, time, square, events, event_count):
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
        force = load(state, (vector, block, FORCE))
        old = load(state, (vector, block, DIRECTION))
        # drawn anew while slipping, kept while stuck
        drawn = fma(noise, load(state, (vector, block, NORMAL)), mean)
        threshold = select(old != 0.0, drawn, load(state, (vector, block, THRESHOLD)))
        free = select(abs(force) > threshold, copysign(1.0, force), 0.0)
        undecided = old * load(state, (vector, block, VELOCITY)) <= 0.0
        new = select(undecided, free, old)
        changed = new != old
        if mask_bits(changed):
            moving = new != 0.0
            sticks = mask_bits(changed & (old != 0.0))
            slips = mask_bits(changed & moving)
            for lane in range(LANES):
                if (sticks >> lane) & 1:
                    _record(state, vector, block, lane, 0, time, square, events, event_count)
                if (slips >> lane) & 1:
                    _record(state, vector, block, lane, 1, time, square, events, event_count)
            store(state, (vector, block, DIRECTION), new)
            store(state, (vector, block, THRESHOLD), threshold)
            store(state, (vector, block, STUCK), select(moving, 0.0, 1.0))
            store(state, (vector, block, HOLD), select(moving, 0.0, threshold))
            store(state, (vector, block, PUSH), select(moving, square, 0.0))
            kinetic = new * (ratio * square)
            store(state, (vector, block, KINETIC), kinetic * mean)
            store(state, (vector, block, KINETIC_NOISE), kinetic * noise)
            step_before = load(state, (vector, block, SLIP_STEP))
            store(state, (vector, block, SLIP_STEP), select(moving, step_before, 0.0))
            before = load(state, (vector, block, ACCELERATION))
            store(state, (vector, block, ACCELERATION), select(moving, before, 0.0))


@inlined
def _move(state, vector, n_blocks, belt_step, noisy):
    """One step of the scheme."""
    for block in range(n_blocks):
        kinetic = load(state, (vector, block, KINETIC))
        if noisy:
            normal = load(state, (vector, block, NORMAL))
            kinetic = fma(load(state, (vector, block, KINETIC_NOISE)), normal, kinetic)
        push = load(state, (vector, block, PUSH))
        before = load(state, (vector, block, ACCELERATION))
        w = load(state, (vector, block, SLIP_STEP))
        a = fma(push, load(state, (vector, block, FORCE)), -kinetic)
        store(state, (vector, block, ACCELERATION), a)
        store(state, (vector, block, VELOCITY), fma(a, 11.0 / 6.0, fma(before, -1.0 / 3.0, w)))
        w = w + a
        store(state, (vector, block, SLIP_STEP), w)
        displacement = load(state, (vector, block, DISPLACEMENT))
        store(state, (vector, block, DISPLACEMENT), displacement + (w + belt_step))
        dissipated = load(state, (vector, block, DISSIPATED))
        store(state, (vector, block, DISSIPATED), fma(kinetic, w, dissipated))


@inlined
def _cross(
    state,
    vector,
    n_blocks,
    belt_step,
    section_block,
    level,
    time,
    time_step,
    crossings,
    crossing_count,
):
    """Record the chains whose block came down through its level in the step that ends at `time`."""
    after = load(state, (vector, section_block, DISPLACEMENT)) - level
    move = load(state, (vector, section_block, SLIP_STEP)) + belt_step
    hits = mask_bits((after < 0.0) & (after - move >= 0.0))
    if hits:
        back = after / move
        for lane in range(LANES):
            if (hits >> lane) & 1:
                chain = vector * LANES + lane
                share = extract(back, lane)
                slot = crossing_count[chain]
                crossing_count[chain] = slot + 1
                crossings[chain, slot, 0] = time - share * time_step
                for block in range(n_blocks):
                    move = state[vector, block, SLIP_STEP + lane] + extract(belt_step, lane)
                    crossings[chain, slot, 1 + block] = (
                        state[vector, block, DISPLACEMENT + lane] - share * move
                    )
                    crossings[chain, slot, 1 + n_blocks + block] = (
                        state[vector, block, VELOCITY + lane]
                        - share * state[vector, block, ACCELERATION + lane]
                    ) / time_step


@inlined
def _sample(state, vector, n_blocks, first_sampled, time_step, samples, row):
    lane = vector * LANES
    rate = 1.0 / time_step
    for block in range(first_sampled, n_blocks):
        kinetic = fma(
            load(state, (vector, block, KINETIC_NOISE)),
            load(state, (vector, block, NORMAL)),
            load(state, (vector, block, KINETIC)),
        )
        column = block - first_sampled
        displacement = load(state, (vector, block, DISPLACEMENT))
        velocity = load(state, (vector, block, VELOCITY)) * rate
        store(samples, (row, 0, column, lane), displacement)
        store(samples, (row, 1, column, lane), velocity)
        store(samples, (row, 2, column, lane), -kinetic * (rate * rate))


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

    It stops early, at a sample or after a stretch of steps, only when a buffer of events or
    crossings might overflow in the next stretch.

    first_step : index of the first step (time = index * time_step).
    constants : (9,) see `law_constants`; belt_step : (W,) u*dt; noise : (W,) sigma; noisy : whether
    any of them is not zero.
    state : see `initial_state`; wall_pull : (W,) sum of the first spring's pull over the steps;
    streams : (4, W) random numbers.
    sample_stride : samples are taken where the step index is a multiple of it;
    first_sampled : first block sampled;
    samples : (S, 3, N-first_sampled, W) displacement, relative velocity, kinetic friction.
    events : (W, E, 6), crossings : (W, C, 1+2N) and their counts (W,).
    section_block : 0-based, or -1 for none; section_displacement : (W,).
    """
    separate_arrays()
    vectors = state.shape[0]
    law = spring_law(constants)
    mean = constants[STATIC_FRICTION]
    ratio = constants[FRICTION_RATIO]
    square = time_step * time_step
    last = first_step + n_steps
    stretch = min(events.shape[1] // (8 * n_blocks), crossings.shape[1] // 4)
    step = first_step
    row = 0
    while step < last:
        start = step
        step = min(last, start + stretch, (start // sample_stride + 1) * sample_stride)
        sampled = step % sample_stride == 0
        room = 1
        for vector in range(vectors):
            lane = vector * LANES
            vector_noise = load(noise, (lane,))
            vector_belt_step = load(belt_step, (lane,))
            level = load(section_displacement, (lane,))
            pulled = load(wall_pull, (lane,))
            for now in range(start, step):
                wall, margin = _forces(state, vector, n_blocks, law)
                pulled = pulled + wall
                if noisy:
                    for block in range(0, n_blocks, 2):
                        first, second = normal_pairs(streams, lane)
                        store(state, (vector, block, NORMAL), first)
                        store(state, (vector, block + 1, NORMAL), second)
                if mask_bits(margin <= 0.0):
                    _turn(
                        state,
                        vector,
                        n_blocks,
                        mean,
                        ratio,
                        vector_noise,
                        square,
                        now * time_step,
                        events,
                        event_count,
                    )
                if noisy:
                    _move(state, vector, n_blocks, vector_belt_step, True)
                else:
                    _move(state, vector, n_blocks, vector_belt_step, False)
                if section_block >= 0:
                    _cross(
                        state,
                        vector,
                        n_blocks,
                        vector_belt_step,
                        section_block,
                        level,
                        (now + 1) * time_step,
                        time_step,
                        crossings,
                        crossing_count,
                    )
            store(wall_pull, (lane,), pulled)
            if sampled:
                _sample(state, vector, n_blocks, first_sampled, time_step, samples, row)
            for chain in range(lane, lane + LANES):
                if event_count[chain] + 2 * n_blocks * stretch > events.shape[1]:
                    room = 0
                if crossing_count[chain] + stretch > crossings.shape[1]:
                    room = 0
        row += sampled
        if not room:
            break
    return step - first_step
