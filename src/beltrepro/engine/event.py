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

from beltrepro.engine.candidates import find_candidates, first_events, may_pass, taylor_step
from beltrepro.engine.events import CROSSINGS_FULL, DONE, EVENTS_FULL, STORM, record_event
from beltrepro.engine.law import (
    COMPRESSION_RATE,
    EXTENSION_RATE,
    FRICTION_RATIO,
    LINEAR_LIMIT,
    STATIC_FRICTION,
)
from beltrepro.engine.noise import normal_pair, normal_pairs_where
from beltrepro.engine.simd import (
    LANES,
    extract,
    fma,
    lane_numbers,
    load,
    lowest_lane,
    mask_bits,
    minimum,
    select,
    spread,
    square_root,
    store,
    store_where,
    to_float,
)
from beltrepro.engine.taylor import (
    NOISY_ORDER,
    ORDER,
    WALL,
    at,
    evaluate,
    evaluate_one,
    extend_series,
    integral,
    mean_change,
    start_springs,
)
from beltrepro.engine.vector import inlined, kernel, separate_arrays

# Last terms of the series of F_ex allowed at the end of a step: the last, and the one before it.
TOLERANCE = 1e-10
# The same with noise, as a share of sqrt(q): its impulse in a time h has deviation sqrt(q h).
NOISE_SHARE = 1e-2
# Longest cell of the noise, model time; in shorter ones it is where v_r might graze zero.
_CELL = 0.5
_GRAZING = 2.0


@inlined
def _start_positions(lane, kinetic, direction, noise_force, series, force):
    """X_2 and X_3 from the forces, the friction and the noise."""
    for block in range(direction.shape[0]):
        heading = load(direction, (block, lane))
        slipping = heading != 0.0
        push = load(noise_force, (0, block, lane)) - heading * kinetic
        acceleration = load(force, (at(0, block),)) + push
        jerk = load(force, (at(1, block),)) + load(noise_force, (1, block, lane))
        store(series, (at(2, block + 1),), select(slipping, 0.5 * acceleration, 0.0))
        store(series, (at(3, block + 1),), select(slipping, jerk * (1.0 / 6.0), 0.0))


@inlined
def _cell_length(lane, drawing, power, kinetic, velocity, direction, force):
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
            # the vertex is at -slope / bend
            ahead = (slope * bend < 0.0) & (abs(slope) < 1.5 * length * abs(bend))
            twice = 2.0 * bend
            depth = fma(twice, load(velocity, (block, lane)), -(slope * slope))
            near = ahead & (abs(depth) < margin * abs(twice))
            grazing = grazing | (near & drawing & (heading != 0.0))
        if mask_bits(grazing) == 0:
            break
        length = select(grazing, 0.25 * length, length)
    return length


@inlined
def _draw_cells(lane, drawing, length, power, streams, noise_force, cell):
    """New noise cells for the chains of a mask: force a + b t until `cell` runs out."""
    rate = 1.0 / length
    strength = square_root(power * rate)
    for block in range(noise_force.shape[1]):
        first, second = normal_pairs_where(streams, lane, drawing)
        tilt = strength * (math.sqrt(3.0) * second)
        level = strength * first - tilt
        start = load(noise_force, (0, block, lane))
        slope = load(noise_force, (1, block, lane))
        store(noise_force, (0, block, lane), select(drawing, level, start))
        store(noise_force, (1, block, lane), select(drawing, 2.0 * tilt * rate, slope))
    store(cell, (lane,), select(drawing, length, load(cell, (lane,))))


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
def _value_and_slope(order, time, column, i, series):
    """Position and relative velocity of one chain in a column of the series."""
    value = series[at(order, column) + i]
    slope = 0.0
    for k in range(order - 1, -1, -1):
        slope = fma(slope, time, value)
        value = fma(value, time, series[at(k, column) + i])
    return value, slope


@inlined
def _record_crossings(
    order,
    lane,
    i,
    position,
    step,
    start,
    series,
    belt_velocity,
    section_block,
    crossings,
    crossing_count,
):
    """Downward crossings of the section within the step of one chain."""
    n_blocks = (crossings.shape[2] - 1) // 2
    column = section_block + 1
    chain = lane + i
    resolution = 1e-14 * max(step, 1.0)
    above = series[at(0, column) + i] >= position
    passed = 0.0
    while passed < step:
        # the first eighth of the rest after which the side differs; a step holds few crossings
        eighth = 0.125 * (step - passed)
        places = fma(to_float(lane_numbers()) + 1.0, eighth, passed)
        value = spread(series[at(order, column) + i])
        for k in range(order - 1, -1, -1):
            value = fma(value, places, spread(series[at(k, column) + i]))
        changed = mask_bits(fma(belt_velocity, places, value) >= position)
        if above:
            changed ^= 0xFF
        if changed == 0:
            return
        low = passed
        while changed & 1 == 0:
            changed >>= 1
            low += eighth
        high = low + eighth
        # Newton's method in the bracket, by halves where it leaves it
        place = 0.5 * (low + high)
        for _ in range(60):
            value, slope = _value_and_slope(order, place, column, i, series)
            value += belt_velocity * place - position
            if (value >= 0.0) != above:
                high = place
            else:
                low = place
            following = place - value / (slope + belt_velocity)
            if not low <= following <= high:
                following = 0.5 * (low + high)
            moved = abs(following - place)
            place = following
            if moved <= resolution or high - low <= resolution:
                break
        if above:
            slot = crossing_count[chain]
            if slot == crossings.shape[1]:
                return
            crossings[chain, slot, 0] = start + place
            for block in range(n_blocks):
                value, slope = _value_and_slope(order, place, block + 1, i, series)
                crossings[chain, slot, 1 + block] = value + belt_velocity * place
                crossings[chain, slot, 1 + n_blocks + block] = slope
            crossing_count[chain] = slot + 1
        above = not above
        passed = place + resolution


@inlined
def _record_samples(
    order,
    lane,
    i,
    until,
    kinetic,
    time,
    belt_velocity,
    direction,
    series,
    sample_interval,
    sample_offset,
    end,
    n_samples,
    sample_row,
    first_sampled,
    samples,
):
    """Samples of one chain until `until`, eight at a time: they lie side by side."""
    n_blocks = direction.shape[0]
    chain = lane + i
    row = sample_row[chain]
    count = LANES
    while count == LANES:
        rows = lane_numbers() + row
        instants = minimum(fma(to_float(rows), sample_interval, sample_offset), end)
        due = (rows < n_samples) & (instants <= until)
        since = instants - time[chain]
        for block in range(first_sampled, n_blocks):
            position, relative = evaluate_one(order, series, block, i, since)
            shown = block - first_sampled
            friction = spread(direction[block, chain] * -kinetic)
            shifted = fma(belt_velocity[chain], since, position)
            store_where(samples, (0, shown, chain, row), shifted, due)
            store_where(samples, (1, shown, chain, row), relative, due)
            store_where(samples, (2, shown, chain, row), friction, due)
        count = lowest_lane(~mask_bits(due))
        row += count
    sample_row[chain] = row


def _advance(order, resolution, noisy):
    """The kernel for chains with noise or those without, with series of one order.

    resolution : of the instants of events, as a share of the step.
    """

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
        stretching,
        growth,
        force,
        wall_pull,
        polynomials,
        sources,
        tails,
        steps,
        found_sources,
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
        log_tolerance,
    ):
        """Advance W chains (W a multiple of 8) from their times to `end`, both since `start_time`.

        Chains of the other kind, with or without noise, stay where they are.
        Returns DONE; or EVENTS_FULL or CROSSINGS_FULL, to be called again with a larger buffer; or
        STORM when some chain has not arrived after `max_passes` steps.

        State: time (W,) since start_time; displacement, velocity (relative to the belt), direction,
        threshold, regime, branch_changed, dissipated (N, W); noise_force (2, N, W); cell,
        wall_impulse (W,); streams (4, W).
        constants : see `law_constants`; belt_velocity, noise_power (q = f_s^2 sigma^2 dt), noise
        (W,).
        series of N+1, stretching, growth, force of N, wall_pull of one and polynomials of
        N * CANDIDATES_PER_BLOCK columns (see `beltrepro.engine.taylor.at`), sources (8 of each of
        the latter), rates, tails (8 N,), steps, found_sources (8,): scratch.
        log_tolerance : (W,) log2 of the force that the last terms may reach at the end of a step.
        Sample m < n_samples is taken at sample_offset + m * sample_interval; sample_row (W,) is the
        next m. samples (3, B, W, S) : displacement, relative velocity and kinetic friction of the
        last B blocks; events, crossings : as for `beltrepro.engine.verlet.verlet_steps`.
        """
        separate_arrays()
        n_blocks, width = displacement.shape
        limit = constants[LINEAR_LIMIT]
        compression_rate = constants[COMPRESSION_RATE]
        extension_rate = constants[EXTENSION_RATE]
        mean_threshold = constants[STATIC_FRICTION]
        kinetic = mean_threshold * constants[FRICTION_RATIO]
        force_order = order - 2

        for lane in range(0, width, LANES):
            belt = load(belt_velocity, (lane,))
            power = load(noise_power, (lane,))
            accuracy = load(log_tolerance, (lane,))
            store(series, (at(1, WALL),), -belt)
            own = power > 0.0
            if not noisy:
                own = ~own
            passes = 0
            while True:
                now = load(time, (lane,))
                remaining = end - now
                active = own & (remaining > 0.0)
                if mask_bits(active) == 0:
                    break
                passes += 1
                if passes > max_passes:
                    return STORM
                if mask_bits(load(event_count, (lane,)) + 2 > events.shape[1]) != 0:
                    return EVENTS_FULL
                crossings_full = load(crossing_count, (lane,)) + 8 > crossings.shape[1]
                if section_block >= 0 and mask_bits(crossings_full) != 0:
                    return CROSSINGS_FULL

                # --- the series of all chains, and their steps ---
                sliding = belt < 0.0
                for block in range(n_blocks):
                    heading = load(direction, (block, lane))
                    sliding = sliding | (heading != 0.0)
                    store(series, (at(0, block + 1),), load(displacement, (block, lane)))
                    store(series, (at(1, block + 1),), load(velocity, (block, lane)))
                moving = active & sliding
                start_springs(
                    constants, regime, lane, series, rates, stretching, growth, force, wall_pull
                )
                if noisy:
                    drawing = moving & (load(cell, (lane,)) <= 0.0)
                    if mask_bits(drawing) != 0:
                        length = _cell_length(
                            lane, drawing, power, kinetic, velocity, direction, force
                        )
                        _draw_cells(lane, drawing, length, power, streams, noise_force, cell)
                _start_positions(lane, kinetic, direction, noise_force, series, force)
                extend_series(
                    order, direction, lane, series, rates, stretching, growth, force, wall_pull
                )
                step = minimum(taylor_step(order, n_blocks, accuracy, force), remaining)
                rest_of_cell = load(cell, (lane,))
                if noisy:
                    step = minimum(step, rest_of_cell)
                step = select(moving, step, 0.0)

                # --- the first event of each chain ---
                n_columns = find_candidates(
                    order,
                    lane,
                    step,
                    moving,
                    limit,
                    direction,
                    threshold,
                    branch_changed,
                    rates,
                    series,
                    force,
                    polynomials,
                    sources,
                    tails,
                )
                step, source = first_events(
                    order, resolution, n_columns, step, polynomials, sources
                )
                store(steps, (0,), step)
                store(found_sources, (0,), source)
                # chains at rest on the belt: only the first spring stretches, next slip known
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
                            found_sources[i] = first if wait <= rest else -1
                            steps[i] = min(wait, rest)
                    step = load(steps, (0,))
                    source = load(found_sources, (0,))

                # --- to the first event or the end of the step ---
                later = now + step
                arrived = step >= remaining
                later = select(arrived, end, later)
                if section_block >= 0:
                    goal = load(section_displacement, (lane,))
                    # when all blocks are stuck the last one only moves up
                    crossing = mask_bits(
                        moving & may_pass(section_block, goal, belt, step, series, tails)
                    )
                    while crossing:
                        i = lowest_lane(crossing)
                        crossing &= crossing - 1
                        _record_crossings(
                            order,
                            lane,
                            i,
                            section_displacement[lane + i],
                            steps[i],
                            start_time + time[lane + i],
                            series,
                            belt_velocity[lane + i],
                            section_block,
                            crossings,
                            crossing_count,
                        )
                row = load(sample_row, (lane,))
                instant = minimum(fma(to_float(row), sample_interval, sample_offset), end)
                sampled = mask_bits(active & (row < n_samples) & (instant <= later))
                while sampled:
                    i = lowest_lane(sampled)
                    sampled &= sampled - 1
                    _record_samples(
                        order,
                        lane,
                        i,
                        extract(later, i),
                        kinetic,
                        time,
                        belt_velocity,
                        direction,
                        series,
                        sample_interval,
                        sample_offset,
                        end,
                        n_samples,
                        sample_row,
                        first_sampled,
                        samples,
                    )

                impulse = select(moving, integral(force_order, wall_pull, 0, step), 0.0)
                store(wall_impulse, (lane,), load(wall_impulse, (lane,)) + impulse)
                for block in range(n_blocks):
                    position, relative = evaluate(order, series, block, step)
                    start = load(series, (at(0, block + 1),))
                    shift = position - start
                    loss = load(direction, (block, lane)) * kinetic * shift
                    if noisy:
                        slope = load(noise_force, (1, block, lane))
                        mean_shift = mean_change(order, series, block, step)
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
                changing = mask_bits(source >= 0) | still
                while changing:
                    i = lowest_lane(changing)
                    changing &= changing - 1
                    chain = lane + i
                    what = found_sources[i]
                    if (still >> i) & 1:
                        here = displacement[0, chain]
                        before = here - belt_velocity[chain] * steps[i]
                        gained = _stored_energy(here, limit, compression_rate, extension_rate)
                        gained -= _stored_energy(before, limit, compression_rate, extension_rate)
                        wall_impulse[chain] += gained / belt_velocity[chain]
                        regime[0, chain] = _branch(here, limit)
                        if what >= 0:
                            external = -threshold[0, chain]
                            if steps[i] == 0.0:
                                external = force[at(0, what) + i]
                            direction[what, chain] = 1.0 if external > 0.0 else -1.0
                            record_event(
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
                        since = steps[i]
                        external = force[at(force_order, what) + i]
                        for k in range(force_order - 1, -1, -1):
                            external = fma(external, since, force[at(k, what) + i])
                        here = displacement[what, chain]
                        loss = dissipated[what, chain]
                        way = 1.0 if external > 0.0 else -1.0
                        starts = True
                        if direction[what, chain] != 0.0:
                            if noisy:
                                first, _ = normal_pair(streams, chain)
                                threshold[what, chain] = mean_threshold + noise[chain] * first
                            starts = abs(external) > threshold[what, chain]
                            velocity[what, chain] = 0.0
                            direction[what, chain] = 0.0
                            record_event(
                                chain, instant, what, 0.0, external, here, loss, events, event_count
                            )
                        if starts:
                            direction[what, chain] = way
                            record_event(
                                chain, instant, what, 1.0, external, here, loss, events, event_count
                            )
        return DONE

    # no arrays are made or kept: no references to count, which numba does by calls in the loop
    advance_chains.targetoptions["_nrt"] = False
    return advance_chains


advance_quiet_chains = _advance(ORDER, 1e-15, False)
advance_noisy_chains = _advance(NOISY_ORDER, 1e-10, True)
