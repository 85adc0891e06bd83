"""The exact dynamics: Taylor series between events, instants of slip and stick located on them.

Eight chains are advanced together, each with its own time. One pass of the loop makes the series of
all eight, chooses their steps, clears most event functions by a bound, looks for the first root of
the others, and moves every chain to its first event or to the end of its step:

- a slipping block ends its slip where d v_r = 0 (d: direction of the slip);
- a stuck block starts to slip where F_st - F_ex or F_st + F_ex = 0;
- a spring changes its branch where |dl| = dl_max.

A function that is zero at the start because its own event has just happened is divided by t. What
is exact and what is approximate, see docs/event.md.
"""

import math

from beltrepro.engine.events import (
    EVENT_BLOCK,
    EVENT_DISSIPATED,
    EVENT_FORCE,
    EVENT_POSITION,
    EVENT_SLIP,
    EVENT_TIME,
)
from beltrepro.engine.law import (
    COMPRESSION_RATE,
    EXTENSION_RATE,
    FRICTION_RATIO,
    LINEAR_LIMIT,
    STATIC_FRICTION,
)
from beltrepro.engine.noise import logarithm, normal_pair, normal_pairs_where
from beltrepro.engine.roots import NO_ROOT, UNDECIDED, first_roots
from beltrepro.engine.simd import (
    LANES,
    fma,
    load,
    mask_bits,
    maximum,
    minimum,
    select,
    spread,
    square_root,
    store,
    to_float,
)
from beltrepro.engine.taylor import (
    FORCE_ORDER,
    LEVELS,
    ORDER,
    at,
    bounds,
    deformation,
    evaluate,
    extend_springs,
    start_springs,
)
from beltrepro.engine.vector import LOG2_E, exp2, inlined, kernel, separate_arrays

DONE, EVENTS_FULL, CROSSINGS_FULL, STORM = range(4)
CANDIDATES_PER_BLOCK = 4 * LANES
WALL = 0  # column of the series, see `beltrepro.engine.taylor`

# Last terms of the series of F_ex allowed at the end of a step: the last, and the one before it.
_TOLERANCE = 1e-10
_LOG_TOLERANCE = math.log(_TOLERANCE)
# Longest cell of the noise, model time; in shorter ones it is where v_r might graze zero.
_CELL = 0.5
_GRAZING = 2.0


@inlined
def _accelerate(k, lane, direction, friction, series, force):
    """Level k+2 of the positions from level k of the forces."""
    weight = 1.0 / ((k + 1.0) * (k + 2.0))
    for block in range(direction.shape[0]):
        acceleration = load(force, (at(k, block),))
        if k < 2:
            acceleration = acceleration + load(friction, (at(k, block),))
        slipping = load(direction, (block, lane)) != 0.0
        store(series, (at(k + 2, block + 1),), select(slipping, acceleration * weight, 0.0))


@inlined
def _cell_length(lane, power, kinetic, velocity, direction, force):
    """Length of the next noise cell: short where the noise could decide whether v_r reaches zero.

    Where the parabola of v_r has its vertex in the cell, less than `_GRAZING` standard deviations
    of the noise in the cell away from zero, a cell of a quarter is tried, and so on down to about
    the step of the paper. It looks at the state only, not at the noise to come.
    """
    length = spread(_CELL)
    for _ in range(4):
        grazing = power < 0.0
        margin = square_root(power * length) * _GRAZING
        for block in range(direction.shape[0]):
            heading = load(direction, (block, lane))
            slope = load(force, (at(0, block),)) - heading * kinetic
            bend = load(force, (at(1, block),))
            vertex = -slope / bend
            depth = fma(0.5 * slope, vertex, load(velocity, (block, lane)))
            near = (vertex > 0.0) & (vertex < 1.5 * length) & (abs(depth) < margin)
            grazing = grazing | (near & (heading != 0.0))
        if mask_bits(grazing) == 0:
            break
        length = select(grazing, 0.25 * length, length)
    return length


@inlined
def _draw_cells(lane, drawing, length, power, streams, noise_force, cell):
    """New noise cells for the chains of a mask: force a + b t until `cell` runs out."""
    strength = square_root(power / length)
    for block in range(noise_force.shape[1]):
        first, second = normal_pairs_where(streams, lane, drawing)
        tilt = strength * (math.sqrt(3.0) * second)
        level = strength * first - tilt
        start = load(noise_force, (0, block, lane))
        slope = load(noise_force, (1, block, lane))
        store(noise_force, (0, block, lane), select(drawing, level, start))
        store(noise_force, (1, block, lane), select(drawing, 2.0 * tilt / length, slope))
    store(cell, (lane,), select(drawing, length, load(cell, (lane,))))


@inlined
def _taylor_step(n_blocks, force):
    """Step at which the last two terms of the series of all forces are within the tolerance."""
    last = spread(1e-200)
    before = spread(1e-200)
    for block in range(n_blocks):
        last = maximum(last, abs(load(force, (at(FORCE_ORDER, block),))))
        before = maximum(before, abs(load(force, (at(FORCE_ORDER - 1, block),))))
    exponent = minimum(
        (_LOG_TOLERANCE - logarithm(last)) * (LOG2_E / FORCE_ORDER),
        (_LOG_TOLERANCE - logarithm(before)) * (LOG2_E / (FORCE_ORDER - 1)),
    )
    return exp2(exponent, 1.0)


@inlined
def _force_tail(block, step, force):
    """Bound on the step of the terms of F_ex from the third order on."""
    tail = abs(load(force, (at(FORCE_ORDER, block),)))
    for k in range(FORCE_ORDER - 1, 2, -1):
        tail = fma(tail, step, abs(load(force, (at(k, block),))))
    return tail * (step * step * step)


@inlined
def _block_bounds(block, heading, tail, step, series, force):
    """Bounds on the step of d v_r of slipping and F_ex of stuck blocks.

    tail : from `_force_tail`; v_r has the terms F_{k-1} t^k / k, so a quarter of it bounds them
    from the fourth order on. The third value is a lower bound of d v_r / t where v_r starts at 0.
    """
    column = block + 1
    slipping = heading != 0.0
    bend = load(force, (at(2, block),))
    c0 = select(slipping, heading * load(series, (at(1, column),)), load(force, (at(0, block),)))
    c1 = select(
        slipping, heading * 2.0 * load(series, (at(2, column),)), load(force, (at(1, block),))
    )
    c2 = select(slipping, heading * 3.0 * load(series, (at(3, column),)), bend)
    rest_rate = fma(abs(bend) * (1.0 / 3.0), step * step, 0.25 * tail)
    least, greatest = bounds(c0, c1, c2, select(slipping, rest_rate * step, tail), step)
    return least, greatest, minimum(c1, fma(c2, step, c1)) - rest_rate


@inlined
def _position_tail(block, heading, tail, step, series):
    """Bound on the step of the terms of the position over t from the third order on.

    From X_{k+2} = F_k / ((k+1)(k+2)), with `tail` from `_force_tail`.
    """
    third = abs(load(series, (at(3, block + 1),)))
    fourth = abs(load(series, (at(4, block + 1),)))
    bound = fma(fourth, step, third) * (step * step)
    return select(heading != 0.0, fma(0.05 * tail, step, bound), 0.0)


@inlined
def _spring_bounds(spring, tail, step, series):
    """Bounds on the step of the deformation, and of its change over time in the way it starts.

    tail : bound of the terms over t from the third order on.
    """
    c0 = deformation(0, spring, series)
    c1 = deformation(1, spring, series)
    c2 = deformation(2, spring, series)
    least, greatest = bounds(c0, c1, c2, tail * step, step)
    turned = select(c1 < 0.0, -c2, c2)
    return least, greatest, minimum(abs(c1), fma(turned, step, abs(c1))) - tail


@inlined
def _place(k, slot):
    """Index of coefficient k of a candidate."""
    return at(k, slot // LANES) + slot % LANES


@inlined
def _push_slip_end(slot, lane, column, heading, step, series, polynomials):
    """Candidate: the first root of d v_r in units of the step; of d v_r / t if it starts at 0."""
    scale = heading
    shift = 2 if series[at(1, column) + lane] == 0.0 else 1
    for k in range(ORDER + 1 - shift):
        polynomials[_place(k, slot)] = scale * (k + shift) * series[at(k + shift, column) + lane]
        scale *= step
    for k in range(ORDER + 1 - shift, ORDER + 1):
        polynomials[_place(k, slot)] = 0.0


@inlined
def _push_slip_start(slot, lane, block, side, threshold, step, force, polynomials):
    """Candidate: the first root of F_st - side F_ex."""
    scale = -side
    for k in range(FORCE_ORDER + 1):
        polynomials[_place(k, slot)] = scale * force[at(k, block) + lane]
        scale *= step
    polynomials[_place(0, slot)] += threshold
    for k in range(FORCE_ORDER + 1, ORDER + 1):
        polynomials[_place(k, slot)] = 0.0


@inlined
def _push_branch_end(slot, lane, spring, sign, offset, divided, step, series, polynomials):
    """Candidate: the first root of offset + sign D; divided by t if it is zero at the start."""
    scale = sign
    shift = 1 if divided else 0
    for k in range(ORDER + 1 - shift):
        change = series[at(k + shift, spring + 1) + lane] - series[at(k + shift, spring) + lane]
        polynomials[_place(k, slot)] = scale * change
        scale *= step
    if divided:
        polynomials[_place(ORDER, slot)] = 0.0
    else:
        polynomials[_place(0, slot)] += offset


@inlined
def _extension(tension, limit, compression_rate, extension_rate):
    """Deformation at which a spring pulls with the given tension."""
    size = abs(tension)
    if size <= limit:
        return tension
    rate = extension_rate if tension > 0.0 else compression_rate
    return math.copysign(limit + math.log1p(rate * (size - limit)) / rate, tension)


@inlined
def _stored_energy(deformation, limit, compression_rate, extension_rate):
    """Potential energy of a spring."""
    size = abs(deformation)
    if size <= limit:
        return 0.5 * size * size
    rate = extension_rate if deformation > 0.0 else compression_rate
    excess = size - limit
    return limit * (0.5 * limit + excess) + (math.expm1(rate * excess) / rate - excess) / rate


@inlined
def _branch(deformation, limit):
    """Branch of the spring law: -1, 0, 1 compressed, linear, stretched."""
    if deformation > limit:
        return 1.0
    return -1.0 if deformation < -limit else 0.0


@inlined
def _find_candidates(
    lane,
    moving,
    limit,
    velocity,
    direction,
    threshold,
    regime,
    branch_changed,
    series,
    force,
    polynomials,
    candidate_lane,
    candidate_source,
    tails,
    work,
):
    """Collect the event functions that the bounds do not clear; returns how many.

    Source b < N: block b sticks or slips; N + s: spring s changes its branch.
    """
    n_blocks = direction.shape[0]
    step = load(work, (0, 0))
    count = 0
    for block in range(n_blocks):
        heading = load(direction, (block, lane))
        tail = _force_tail(block, step, force)
        store(tails, (block * LANES,), _position_tail(block, heading, tail, step, series))
        least, greatest, least_rate = _block_bounds(block, heading, tail, step, series, force)
        limit_force = load(threshold, (block, lane))
        slipping = heading != 0.0
        # v_r is exactly zero only where the slip has just begun
        begins = slipping & (load(velocity, (block, lane)) == 0.0)
        clear_below = select(begins, least_rate, least) > select(slipping, 0.0, -limit_force)
        below = mask_bits(moving & ~clear_below)
        above = mask_bits(moving & ~slipping & ~(greatest < limit_force))
        if below | above:
            for i in range(LANES):
                way = direction[block, lane + i]
                if (below >> i) & 1:
                    if way != 0.0:
                        _push_slip_end(count, i, block + 1, way, work[0, i], series, polynomials)
                    else:
                        _push_slip_start(
                            count,
                            i,
                            block,
                            -1.0,
                            threshold[block, lane + i],
                            work[0, i],
                            force,
                            polynomials,
                        )
                    candidate_lane[count] = i
                    candidate_source[count] = block
                    count += 1
                if (above >> i) & 1:
                    _push_slip_start(
                        count,
                        i,
                        block,
                        1.0,
                        threshold[block, lane + i],
                        work[0, i],
                        force,
                        polynomials,
                    )
                    candidate_lane[count] = i
                    candidate_source[count] = block
                    count += 1
    tail_before = spread(0.0)
    for spring in range(n_blocks):
        tail = load(tails, (spring * LANES,))
        least, greatest, least_rate = _spring_bounds(spring, tail + tail_before, step, series)
        tail_before = tail
        branch = load(regime, (spring, lane))
        changed = load(branch_changed, (spring, lane)) != 0.0
        # a spring that has just changed its branch stands at one limit and moves away from it
        leaves = changed & (least_rate > 0.0)
        upper = changed & (deformation(0, spring, series) > 0.0)
        lower = changed & ~upper
        clear_above = (greatest < limit) | (branch > 0.0) | (upper & leaves)
        clear_below = (least > -limit) | (branch < 0.0) | (lower & leaves)
        clear_stretched = (branch <= 0.0) | (least > limit) | leaves
        clear_compressed = (branch >= 0.0) | (greatest < -limit) | leaves
        above = mask_bits(moving & (branch == 0.0) & ~clear_above)
        below = mask_bits(moving & (branch == 0.0) & ~clear_below)
        beyond = mask_bits(moving & ~(clear_stretched & clear_compressed))
        if above | below | beyond:
            for i in range(LANES):
                fresh = branch_changed[spring, lane + i] != 0.0
                high = series[at(0, spring + 1) + i] - series[at(0, spring) + i] > 0.0
                for side in range(3):
                    if side == 0:
                        bits, sign, offset, divided = above, -1.0, limit, fresh and high
                    elif side == 1:
                        bits, sign, offset, divided = below, 1.0, limit, fresh and not high
                    else:
                        bits, sign, offset, divided = (
                            beyond,
                            regime[spring, lane + i],
                            -limit,
                            fresh,
                        )
                    if (bits >> i) & 1:
                        _push_branch_end(
                            count, i, spring, sign, offset, divided, work[0, i], series, polynomials
                        )
                        candidate_lane[count] = i
                        candidate_source[count] = n_blocks + spring
                        count += 1
    return count


@inlined
def _first_events(count, polynomials, candidate_lane, candidate_source, roots, work, source):
    """Shorten the steps to the first events, and say which; source -1 is none."""
    for slot in range(count, (count + LANES - 1) // LANES * LANES):
        for k in range(LEVELS):
            polynomials[_place(k, slot)] = 0.0
        polynomials[_place(0, slot)] = 1.0
    for slot in range(0, count, LANES):
        first_roots(polynomials, slot, roots)
    for slot in range(count):
        i = candidate_lane[slot]
        found = roots[slot] <= 1.0
        if roots[slot] == NO_ROOT:
            continue
        instant = (roots[slot] if found else roots[slot] - UNDECIDED) * work[0, i]
        if instant < work[1, i] or (found and source[i] < 0 and instant == work[1, i]):
            work[1, i] = instant
            source[i] = candidate_source[slot] if found else -1


@inlined
def _record_crossings(
    lane, i, position, step, start, series, belt_velocity, section_block, crossings, crossing_count
):
    """Downward crossings of the section within the step of one chain."""
    n_blocks = (crossings.shape[2] - 1) // 2
    column = section_block + 1
    passed = 0.0
    chain = lane + i
    above = series[at(0, column) + i] >= position
    while passed < step:
        # bisection between instants where the sign differs; a step holds at most a few crossings
        found = False
        low = passed
        high = passed
        for part in range(1, 9):
            high = passed + (step - passed) * part / 8
            value = series[at(ORDER, column) + i]
            for k in range(ORDER - 1, -1, -1):
                value = value * high + series[at(k, column) + i]
            if (value + belt_velocity * high >= position) != above:
                found = True
                break
            low = high
        if not found:
            return
        while high - low > 1e-14 * max(step, 1.0):
            middle = 0.5 * (low + high)
            if middle <= low or middle >= high:
                break
            value = series[at(ORDER, column) + i]
            for k in range(ORDER - 1, -1, -1):
                value = value * middle + series[at(k, column) + i]
            if (value + belt_velocity * middle >= position) != above:
                high = middle
            else:
                low = middle
        if above:
            slot = crossing_count[chain]
            if slot == crossings.shape[1]:
                return
            crossings[chain, slot, 0] = start + high
            for block in range(n_blocks):
                value = series[at(ORDER, block + 1) + i]
                slope = 0.0
                for k in range(ORDER - 1, -1, -1):
                    slope = slope * high + value
                    value = value * high + series[at(k, block + 1) + i]
                crossings[chain, slot, 1 + block] = value + belt_velocity * high
                crossings[chain, slot, 1 + n_blocks + block] = slope
            crossing_count[chain] = slot + 1
        above = not above
        passed = high


@inlined
def _record_event(chain, time, block, slips, force, position, loss, events, event_count):
    slot = event_count[chain]
    events[chain, slot, EVENT_TIME] = time
    events[chain, slot, EVENT_BLOCK] = block
    events[chain, slot, EVENT_SLIP] = slips
    events[chain, slot, EVENT_FORCE] = force
    events[chain, slot, EVENT_POSITION] = position
    events[chain, slot, EVENT_DISSIPATED] = loss
    event_count[chain] = slot + 1


@kernel
def advance_chains(
    end,
    start_time,
    constants,
    belt_velocity,
    noise_power,
    noise,
    time,
    displacement,
    velocity,
    direction,
    threshold,
    regime,
    branch_changed,
    noise_force,
    cell,
    dissipated,
    wall_impulse,
    streams,
    series,
    rates,
    growth,
    stretching,
    force,
    friction,
    wall_pull,
    polynomials,
    candidate_lane,
    candidate_source,
    roots,
    tails,
    work,
    source,
    sample_interval,
    sample_offset,
    n_samples,
    sample_row,
    first_sampled,
    samples,
    events,
    event_count,
    section_block,
    section_displacement,
    crossings,
    crossing_count,
    max_passes,
):
    """Advance W chains (W a multiple of 8) from their times to `end`, counted from `start_time`.

    Returns DONE; or EVENTS_FULL or CROSSINGS_FULL, to be called again with a larger buffer; or
    STORM when some chain has not arrived after `max_passes` steps.

    State: time (W,) since start_time; displacement, velocity (relative to the belt), direction,
    threshold, regime, branch_changed, dissipated (N, W); noise_force (2, N, W); cell, wall_impulse
    (W,); streams (4, W).
    constants : see `law_constants`; belt_velocity, noise_power (q = f_s^2 sigma^2 dt), noise (W,).
    series of N+1, growth, stretching, force, friction of N, wall_pull of one column (see
    `beltrepro.engine.taylor.at`), rates (8 N,), polynomials of C/8 columns, candidate_lane,
    candidate_source, roots (C,) with C = N * CANDIDATES_PER_BLOCK, tails (8 N,), work (4, 8) and
    source (8,): scratch.
    Sample m < n_samples is taken at sample_offset + m * sample_interval; sample_row (W,) is the
    next m. samples, events, crossings : as for `beltrepro.engine.verlet.verlet_steps`.
    """
    separate_arrays()
    n_blocks, width = displacement.shape
    limit = constants[LINEAR_LIMIT]
    compression_rate = constants[COMPRESSION_RATE]
    extension_rate = constants[EXTENSION_RATE]
    mean_threshold = constants[STATIC_FRICTION]
    kinetic = mean_threshold * constants[FRICTION_RATIO]

    for lane in range(0, width, LANES):
        belt = load(belt_velocity, (lane,))
        power = load(noise_power, (lane,))
        noisy = mask_bits(power > 0.0) != 0
        store(series, (at(1, WALL),), -belt)
        passes = 0
        while True:
            now = load(time, (lane,))
            remaining = end - now
            active = remaining > 0.0
            if mask_bits(active) == 0:
                break
            passes += 1
            if passes > max_passes:
                return STORM
            for chain in range(lane, lane + LANES):
                if event_count[chain] + 2 > events.shape[1]:
                    return EVENTS_FULL
                if section_block >= 0 and crossing_count[chain] + 8 > crossings.shape[1]:
                    return CROSSINGS_FULL

            # --- the series of all chains, and their steps ---
            sliding = belt < 0.0
            for block in range(n_blocks):
                heading = load(direction, (block, lane))
                sliding = sliding | (heading != 0.0)
                store(series, (at(0, block + 1),), load(displacement, (block, lane)))
                store(series, (at(1, block + 1),), load(velocity, (block, lane)))
            moving = active & sliding
            start_springs(constants, regime, lane, series, rates, growth, force, wall_pull)
            extend_springs(1, series, rates, stretching, growth, force, wall_pull)
            if noisy:
                drawing = moving & (load(cell, (lane,)) <= 0.0) & (power > 0.0)
                if mask_bits(drawing) != 0:
                    length = _cell_length(lane, power, kinetic, velocity, direction, force)
                    _draw_cells(lane, drawing, length, power, streams, noise_force, cell)
            for block in range(n_blocks):
                mean = load(direction, (block, lane)) * -kinetic
                store(friction, (at(0, block),), mean + load(noise_force, (0, block, lane)))
                store(friction, (at(1, block),), load(noise_force, (1, block, lane)))
            _accelerate(0, lane, direction, friction, series, force)
            _accelerate(1, lane, direction, friction, series, force)
            for k in range(2, FORCE_ORDER + 1):
                extend_springs(k, series, rates, stretching, growth, force, wall_pull)
                _accelerate(k, lane, direction, friction, series, force)
            step = minimum(_taylor_step(n_blocks, force), remaining)
            rest_of_cell = load(cell, (lane,))
            if noisy:
                step = select(power > 0.0, minimum(step, rest_of_cell), step)
            step = select(moving, step, 0.0)
            store(work, (0, 0), step)
            store(work, (1, 0), step)
            for i in range(LANES):
                source[i] = -1

            # --- the first event of each chain ---
            count = _find_candidates(
                lane,
                moving,
                limit,
                velocity,
                direction,
                threshold,
                regime,
                branch_changed,
                series,
                force,
                polynomials,
                candidate_lane,
                candidate_source,
                tails,
                work,
            )
            _first_events(count, polynomials, candidate_lane, candidate_source, roots, work, source)
            # chains at rest on the belt: only the first spring stretches, the next slip is known
            still = mask_bits(active & ~sliding)
            if still:
                for i in range(LANES):
                    if (still >> i) & 1:
                        chain = lane + i
                        pull = force[at(0, 0) + i] + wall_pull[i] + threshold[0, chain]
                        goal = _extension(pull, limit, compression_rate, extension_rate)
                        here = displacement[0, chain]
                        wait = max((goal - here) / belt_velocity[chain], 0.0)
                        first = 0
                        # only a start beyond the threshold can put a block here, at time 0
                        for block in range(n_blocks - 1, -1, -1):
                            if abs(force[at(0, block) + i]) > threshold[block, chain]:
                                first, wait = block, 0.0
                        rest = end - time[chain]
                        source[i] = first if wait <= rest else -1
                        work[1, i] = min(wait, rest)

            # --- to the first event or the end of the step ---
            step = load(work, (1, 0))
            later = now + step
            arrived = step >= remaining
            later = select(arrived, end, later)
            if section_block >= 0:
                column = section_block + 1
                c1 = load(series, (at(1, column),)) + belt
                c0 = load(series, (at(0, column),))
                tail = load(tails, (section_block * LANES,)) * step
                c2 = load(series, (at(2, column),))
                least, greatest = bounds(c0, c1, c2, tail, step)
                goal = load(section_displacement, (lane,))
                # when all blocks are stuck the last one only moves up
                crossing = mask_bits(moving & ~((least >= goal) | (greatest < goal)))
                if crossing:
                    for i in range(LANES):
                        if (crossing >> i) & 1:
                            _record_crossings(
                                lane,
                                i,
                                section_displacement[lane + i],
                                work[1, i],
                                start_time + time[lane + i],
                                series,
                                belt_velocity[lane + i],
                                section_block,
                                crossings,
                                crossing_count,
                            )
            while True:
                row = load(sample_row, (lane,))
                instant = minimum(fma(to_float(row), sample_interval, sample_offset), end)
                due = active & (row < n_samples) & (instant <= later)
                hits = mask_bits(due)
                if hits == 0:
                    break
                since = instant - now
                for block in range(first_sampled, n_blocks):
                    position, relative = evaluate(series, block, since)
                    store(work, (2, 0), fma(belt, since, position))
                    store(work, (3, 0), relative)
                    for i in range(LANES):
                        if (hits >> i) & 1:
                            row_of = sample_row[lane + i]
                            way = direction[block, lane + i]
                            shown = block - first_sampled
                            samples[row_of, 0, shown, lane + i] = work[2, i]
                            samples[row_of, 1, shown, lane + i] = work[3, i]
                            samples[row_of, 2, shown, lane + i] = -way * kinetic
                store(sample_row, (lane,), select(due, row + 1, row))

            impulse = spread(0.0)
            for k in range(FORCE_ORDER, -1, -1):
                impulse = fma(impulse, step, load(wall_pull, (at(k, 0),)) * (1.0 / (k + 1.0)))
            impulse = select(moving, impulse * step, 0.0)
            store(wall_impulse, (lane,), load(wall_impulse, (lane,)) + impulse)
            for block in range(n_blocks):
                position, relative = evaluate(series, block, step)
                start = load(series, (at(0, block + 1),))
                shift = position - start
                loss = load(direction, (block, lane)) * kinetic * shift
                if noisy:
                    slope = load(noise_force, (1, block, lane))
                    mean_shift = spread(0.0)
                    for k in range(ORDER, 0, -1):
                        mean_shift = fma(
                            mean_shift, step, load(series, (at(k, block + 1),)) * (1.0 / (k + 1.0))
                        )
                    mean_shift = mean_shift * step
                    level = load(noise_force, (0, block, lane))
                    work_of_noise = fma(level, shift, slope * step * (shift - mean_shift))
                    slipping = load(direction, (block, lane)) != 0.0
                    loss = loss - select(slipping, work_of_noise, 0.0)
                    store(noise_force, (0, block, lane), fma(slope, step, level))
                store(dissipated, (block, lane), load(dissipated, (block, lane)) + loss)
                store(displacement, (block, lane), fma(belt, step, position))
                store(velocity, (block, lane), relative)
                advanced = step > 0.0
                flag = load(branch_changed, (block, lane))
                store(branch_changed, (block, lane), select(advanced, 0.0, flag))
            store(time, (lane,), later)
            if noisy:
                rest_of_cell = select(step >= rest_of_cell, 0.0, rest_of_cell - step)
                store(cell, (lane,), select(sliding, rest_of_cell, 0.0))

            # --- what the events change ---
            for i in range(LANES):
                chain = lane + i
                what = source[i]
                if (still >> i) & 1:
                    here = displacement[0, chain]
                    before = here - belt_velocity[chain] * work[1, i]
                    gained = _stored_energy(here, limit, compression_rate, extension_rate)
                    gained -= _stored_energy(before, limit, compression_rate, extension_rate)
                    wall_impulse[chain] += gained / belt_velocity[chain]
                    regime[0, chain] = _branch(here, limit)
                    if what >= 0:
                        external = -threshold[0, chain]
                        if work[1, i] == 0.0:
                            external = force[at(0, what) + i]
                        direction[what, chain] = 1.0 if external > 0.0 else -1.0
                        _record_event(
                            chain,
                            start_time + time[chain],
                            what,
                            1.0,
                            external,
                            displacement[what, chain],
                            dissipated[what, chain],
                            events,
                            event_count,
                        )
                elif what >= n_blocks:
                    spring = what - n_blocks
                    stretch = displacement[spring, chain]
                    if spring > 0:
                        stretch -= displacement[spring - 1, chain]
                    if regime[spring, chain] == 0.0:
                        regime[spring, chain] = 1.0 if stretch > 0.0 else -1.0
                    else:
                        regime[spring, chain] = 0.0
                    branch_changed[spring, chain] = 1.0
                elif what >= 0:
                    instant = start_time + time[chain]
                    since = work[1, i]
                    external = force[at(FORCE_ORDER, what) + i]
                    for k in range(FORCE_ORDER - 1, -1, -1):
                        external = external * since + force[at(k, what) + i]
                    here = displacement[what, chain]
                    loss = dissipated[what, chain]
                    way = 1.0 if external > 0.0 else -1.0
                    starts = True
                    if direction[what, chain] != 0.0:
                        if noise[chain] > 0.0:
                            first, _ = normal_pair(streams, chain)
                            threshold[what, chain] = mean_threshold + noise[chain] * first
                        starts = abs(external) > threshold[what, chain]
                        velocity[what, chain] = 0.0
                        direction[what, chain] = 0.0
                        _record_event(
                            chain, instant, what, 0.0, external, here, loss, events, event_count
                        )
                    if starts:
                        direction[what, chain] = way
                        _record_event(
                            chain, instant, what, 1.0, external, here, loss, events, event_count
                        )
    return DONE
