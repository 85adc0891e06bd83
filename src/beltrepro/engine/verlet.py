"""The paper's numerical scheme (Appendix), step for step, for many chains at once.

State per block and chain, arrays (N, W), in the frame of the belt so that a stuck block has exactly
zero relative velocity: displacement from the rest position, displacement relative to the belt in
the last step, relative velocity, acceleration of the last step, threshold F_st, direction of slip.
With w(t) = x(t) - x(t-dt) - u dt the printed formulas read

    w(t+dt) = w(t) + a(t) dt^2,                               x(t+dt) = x(t) + u dt + w(t+dt)
    v_r(t+dt) = w(t)/dt + dt/6 [11 a(t) - 2 a(t-dt)]

which rounds better than 2x(t) - x(t-dt) and is the same scheme. Both rules that end or start a slip
are one expression without branches, see `beltrepro.model.friction.next_direction`.
"""

from beltrepro.engine.events import (
    EVENT_BLOCK,
    EVENT_DISSIPATED,
    EVENT_FORCE,
    EVENT_POSITION,
    EVENT_SLIP,
    EVENT_TIME,
)
from beltrepro.engine.law import FRICTION_RATIO, STATIC_FRICTION, spring_law, tension
from beltrepro.engine.noise import fill_normals
from beltrepro.engine.simd import copysign, fma
from beltrepro.engine.vector import inlined, kernel, separate_arrays


@inlined
def _spring_pass(displacement, pull, constants):
    separate_arrays()
    law = spring_law(constants)
    n_blocks, lanes = displacement.shape
    for lane in range(lanes):
        pull[0, lane] = tension(displacement[0, lane], law)
    for block in range(1, n_blocks):
        for lane in range(lanes):
            deformation = displacement[block, lane] - displacement[block - 1, lane]
            pull[block, lane] = tension(deformation, law)


@kernel
def verlet_steps(
    first_step,
    n_steps,
    time_step,
    constants,
    belt_step,
    noise,
    displacement,
    slip_step,
    velocity,
    acceleration,
    threshold,
    direction,
    known_direction,
    dissipated,
    wall_impulse,
    streams,
    normals,
    pull,
    sample_stride,
    first_sampled,
    samples,
    events,
    event_count,
    section_block,
    section_displacement,
    crossings,
    crossing_count,
    noisy,
):
    """Advance W chains by at most n_steps steps of the Appendix; returns the steps done.

    It stops early only when a buffer of events or crossings might overflow in the next step.

    first_step : index of the first step (time = index * time_step).
    constants : (9,) see `law_constants`; belt_step : (W,) u*dt; noise : (W,) sigma.
    displacement ... dissipated : (N, W) state; wall_impulse : (W,) integral of the first spring's
    pull; streams : (4, W) and normals : (even >= N, W) random numbers; pull : (N+1, W) scratch,
    last row zero.
    sample_stride : samples are taken where the step index is a multiple of it;
    first_sampled : first block sampled;
    samples : (S, 3, N-first_sampled, W) displacement, relative velocity, kinetic friction.
    events : (W, E, 6), crossings : (W, C, 1+2N) and their counts (W,).
    section_block : 0-based, or -1 for none; section_displacement : (W,).
    """
    separate_arrays()
    n_blocks, lanes = displacement.shape
    mean_threshold = constants[STATIC_FRICTION]
    ratio = constants[FRICTION_RATIO]
    rate = 1.0 / time_step
    square = time_step * time_step
    weight = 11.0 * time_step / 6.0
    previous_weight = -2.0 * time_step / 6.0
    n_normals = n_blocks + (n_blocks & 1)
    row = 0

    for step in range(first_step, first_step + n_steps):
        _spring_pass(displacement, pull, constants)
        for lane in range(lanes):
            wall_impulse[lane] += pull[0, lane] * time_step
        if noisy:
            fill_normals(streams, normals, n_normals)
        changes = 0
        for block in range(n_blocks):
            for lane in range(lanes):
                force = pull[block + 1, lane] - pull[block, lane]
                old = direction[block, lane]
                # drawn anew while slipping, kept while stuck
                drawn = fma(noise[lane], normals[block, lane], mean_threshold)
                limit_force = drawn if old != 0.0 else threshold[block, lane]
                threshold[block, lane] = limit_force
                free = copysign(1.0, force) if abs(force) > limit_force else 0.0
                new = free if old * velocity[block, lane] <= 0.0 else old
                changed = 1 if new != old else 0
                changes |= changed
                moving = new != 0.0
                w = slip_step[block, lane] if moving else 0.0
                before = acceleration[block, lane] if moving else 0.0
                kinetic = new * (ratio * limit_force)
                a = force - kinetic if moving else 0.0
                velocity[block, lane] = fma(w, rate, fma(weight, a, previous_weight * before))
                w = fma(a, square, w)
                slip_step[block, lane] = w
                acceleration[block, lane] = a
                direction[block, lane] = new
                displacement[block, lane] += w + belt_step[lane]
                dissipated[block, lane] = fma(kinetic, w, dissipated[block, lane])

        full = False
        if changes:
            time = step * time_step
            for block in range(n_blocks):
                for lane in range(lanes):
                    new = direction[block, lane]
                    old = known_direction[block, lane]
                    if new != old:
                        known_direction[block, lane] = new
                        w = slip_step[block, lane]
                        position = displacement[block, lane] - (w + belt_step[lane])
                        loss = dissipated[block, lane] - new * ratio * threshold[block, lane] * w
                        force = pull[block + 1, lane] - pull[block, lane]
                        for kind in range(2):
                            if (kind == 0 and old != 0.0) or (kind == 1 and new != 0.0):
                                slot = event_count[lane]
                                events[lane, slot, EVENT_TIME] = time
                                events[lane, slot, EVENT_BLOCK] = block
                                events[lane, slot, EVENT_SLIP] = kind
                                events[lane, slot, EVENT_FORCE] = force
                                events[lane, slot, EVENT_POSITION] = position
                                events[lane, slot, EVENT_DISSIPATED] = loss
                                event_count[lane] = slot + 1
                        if event_count[lane] + 2 * n_blocks > events.shape[1]:
                            full = True

        if section_block >= 0:
            crossed = 0
            for lane in range(lanes):
                after = displacement[section_block, lane] - section_displacement[lane]
                move = slip_step[section_block, lane] + belt_step[lane]
                hit = 1 if (after < 0.0) & (after - move >= 0.0) else 0
                crossed |= hit
            if crossed:
                for lane in range(lanes):
                    after = displacement[section_block, lane] - section_displacement[lane]
                    move = slip_step[section_block, lane] + belt_step[lane]
                    if after < 0.0 and after - move >= 0.0:
                        back = after / move
                        slot = crossing_count[lane]
                        crossings[lane, slot, 0] = (step + 1 - back) * time_step
                        for block in range(n_blocks):
                            move = slip_step[block, lane] + belt_step[lane]
                            crossings[lane, slot, 1 + block] = (
                                displacement[block, lane] - back * move
                            )
                            crossings[lane, slot, 1 + n_blocks + block] = (
                                velocity[block, lane] - back * time_step * acceleration[block, lane]
                            )
                        crossing_count[lane] = slot + 1
                        if slot + 2 > crossings.shape[1]:
                            full = True

        if (step + 1) % sample_stride == 0:
            for block in range(first_sampled, n_blocks):
                for lane in range(lanes):
                    kinetic = -direction[block, lane] * ratio * threshold[block, lane]
                    samples[row, 0, block - first_sampled, lane] = displacement[block, lane]
                    samples[row, 1, block - first_sampled, lane] = velocity[block, lane]
                    samples[row, 2, block - first_sampled, lane] = kinetic
            row += 1
        if full:
            return step + 1 - first_step
    return n_steps
