"""The paper's scheme without noise, many steps at a leap.

Between two turns (stick to slip, slip to stick, reversal) and on one branch of every spring the
scheme x(t+dt) - 2 x(t) + x(t-dt) = dt^2 a(x(t)) has smooth solutions, whose Taylor series are known
like those of the equation of motion: y = x + dt^2/12 a(x) obeys y'' = a(x) up to dt^4/240 a''''
(Numerov's transformation). Eight chains are advanced together, each with its own step index. One
pass of the loop makes the series, finds for how many whole steps no turn can happen and no spring
changes its branch, and goes there at once. Where a turn may be due the next step is taken
literally, with the stick and slip rules (`beltrepro.model.friction.next_direction`) applied at its
start. What is exact and what is approximate, see docs/verlet.md.
"""

import math

from beltrepro.engine.candidates import find_candidates, first_events, may_pass, taylor_step
from beltrepro.engine.events import CROSSINGS_FULL, DONE, EVENTS_FULL, record_event
from beltrepro.engine.law import (
    COMPRESSION_RATE,
    EXTENSION_RATE,
    FRICTION_RATIO,
    LINEAR_LIMIT,
    STATIC_FRICTION,
    spring_law,
    tension,
    tension_and_slope,
)
from beltrepro.engine.simd import (
    LANES,
    copysign,
    extract,
    fma,
    lane_numbers,
    load,
    lowest_lane,
    mask_bits,
    maximum,
    minimum,
    select,
    spread,
    store,
    store_where,
    to_float,
)
from beltrepro.engine.taylor import (
    ORDER,
    WALL,
    at,
    evaluate,
    evaluate_one,
    extend_pair,
    integral,
    polynomial,
)
from beltrepro.engine.vector import inlined, kernel, separate_arrays

_FORCE_ORDER = ORDER - 2
_RESOLUTION = 1e-15  # share of a leap by which the instant of an event may be missed
# Last terms of the series of F_ex allowed at the end of a leap.
_TOLERANCE = 1e-10
# A turn due less than this share of a step after the end of a step may be due there.
_DOUBT = 1e-3
_NEAREST = 6755399441055744.0  # 1.5 * 2^52: adding it rounds to whole numbers


@inlined
def _round_down(x):
    """Greatest whole number up to x, |x| < 2^51."""
    nearest = (x + _NEAREST) - _NEAREST
    return nearest - select(nearest > x, spread(1.0), 0.0)


@inlined
def _start_series(
    lane,
    square,
    inverse_step,
    kinetic,
    law,
    curvatures,
    displacement,
    slip_step,
    direction,
    series,
    rates,
    slopes,
    stretching,
    growth,
    force,
    wall_pull,
):
    """Levels 0 and 1 of all series, 2 and 3 of y, from the state of eight chains.

    The scheme's positions at t and t +- dt give the derivative at t: their central difference is
    dt x' + dt^3/6 x''', where x''' is the coefficient F_1.
    """
    _, _, _, compression_softness, extension_softness = law
    n_blocks = direction.shape[0]
    place_before = spread(0.0)
    tension_before = spread(0.0)
    store(series, (at(0, WALL),), place_before)
    for spring in range(n_blocks):
        place = load(displacement, (spring, lane))
        store(series, (at(0, spring + 1),), place)
        change = place - place_before
        place_before = place
        pull, slope, excess = tension_and_slope(change, law)
        curved = excess != 0.0
        compressed = change < 0.0
        rate = select(compressed, -curvatures[0], curvatures[1])
        softness = select(compressed, -compression_softness, extension_softness)
        store(rates, (spring * LANES,), select(curved, rate, 0.0))
        store(slopes, (spring * LANES,), slope)
        store(growth, (at(0, spring),), select(curved, slope * softness, 0.0))
        if spring == 0:
            store(wall_pull, (at(0, 0),), pull)
        else:
            store(force, (at(0, spring - 1),), pull - tension_before)
        tension_before = pull
    store(force, (at(0, n_blocks - 1),), -tension_before)
    # the velocity from the central difference, then without its third derivative
    for refined in range(2):
        speed_before = load(series, (at(1, WALL),))
        tension_before = spread(0.0)
        for spring in range(n_blocks):
            heading = load(direction, (spring, lane))
            if refined == 0:
                acceleration = load(force, (at(0, spring),)) - heading * kinetic
                difference = fma(acceleration, 0.5 * square, load(slip_step, (spring, lane)))
                speed = select(heading != 0.0, difference * inverse_step, 0.0)
                store(series, (at(2, spring + 1),), select(heading != 0.0, 0.5 * acceleration, 0.0))
            else:
                speed = load(series, (at(1, spring + 1),))
                jerk = load(series, (at(3, spring + 1),))
                speed = fma(jerk, -square, speed)
            store(series, (at(1, spring + 1),), speed)
            change = speed - speed_before
            speed_before = speed
            pull = load(slopes, (spring * LANES,)) * change
            store(stretching, (at(1, spring),), load(rates, (spring * LANES,)) * change)
            store(growth, (at(1, spring),), pull)
            if spring == 0:
                store(wall_pull, (at(1, 0),), pull)
            else:
                store(force, (at(1, spring - 1),), pull - tension_before)
            tension_before = pull
        store(force, (at(1, n_blocks - 1),), -tension_before)
        for block in range(n_blocks):
            slipping = load(direction, (block, lane)) != 0.0
            jerk = load(force, (at(1, block),)) * (1.0 / 6.0)
            store(series, (at(3, block + 1),), select(slipping, jerk, 0.0))


@inlined
def _correct(
    k, share, direction, lane, series, rates, slopes, stretching, growth, force, wall_pull
):
    """From y to x in the levels k and k+1, k even: x = y - share a, share = dt^2/12."""
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
            place, place_next = (at(k, spring + 1),), (at(k + 1, spring + 1),)
            store(series, place, load(series, place) + shift)
            store(series, place_next, load(series, place_next) + following)
            change, change_next = shift - shift_before, following - next_before
            shift_before, next_before = shift, following
            rate = load(rates, (spring * LANES,))
            slope = load(slopes, (spring * LANES,))
            newest = rate * float(k) * change
            tension = slope * change
            rise = fma(
                load(stretching, (at(1, spring),)), tension, newest * load(growth, (at(1, spring),))
            )
            rise = fma(rise, 1.0 / (k + 1.0), slope * change_next)
            level, level_next = (at(k, spring),), (at(k + 1, spring),)
            store(stretching, level, load(stretching, level) + newest)
            newest = rate * (k + 1.0) * change_next
            store(stretching, level_next, load(stretching, level_next) + newest)
            store(growth, level, load(growth, level) + tension)
            store(growth, level_next, load(growth, level_next) + rise)
        if spring == 0:
            store(wall_pull, (at(k, 0),), load(wall_pull, (at(k, 0),)) + tension)
            store(wall_pull, (at(k + 1, 0),), load(wall_pull, (at(k + 1, 0),)) + rise)
        else:
            block = spring - 1
            slipping = load(direction, (block, lane)) != 0.0
            pull = load(force, (at(k, block),)) + (tension - tension_before)
            pull_rise = load(force, (at(k + 1, block),)) + (rise - rise_before)
            store(force, (at(k, block),), pull)
            store(force, (at(k + 1, block),), pull_rise)
            weight, weight_next = 1.0 / ((k + 1.0) * (k + 2.0)), 1.0 / ((k + 2.0) * (k + 3.0))
            store(series, (at(k + 2, spring),), select(slipping, pull * weight, 0.0))
            store(series, (at(k + 3, spring),), select(slipping, pull_rise * weight_next, 0.0))
        tension_before, rise_before = tension, rise


@inlined
def _extend_series(
    share, direction, lane, series, rates, slopes, stretching, growth, force, wall_pull
):
    """All levels from 2 on of the forces and of the positions."""
    extend_pair(2, direction, lane, series, rates, stretching, growth, force, wall_pull)
    _correct(2, share, direction, lane, series, rates, slopes, stretching, growth, force, wall_pull)
    extend_pair(4, direction, lane, series, rates, stretching, growth, force, wall_pull)
    _correct(4, share, direction, lane, series, rates, slopes, stretching, growth, force, wall_pull)
    extend_pair(6, direction, lane, series, rates, stretching, growth, force, wall_pull)
    _correct(6, share, direction, lane, series, rates, slopes, stretching, growth, force, wall_pull)
    extend_pair(8, direction, lane, series, rates, stretching, growth, force, wall_pull)
    _correct(8, share, direction, lane, series, rates, slopes, stretching, growth, force, wall_pull)
    # terms from here on are 1e-5 of the first at the end of a leap, corrections 1e-7 of them
    extend_pair(10, direction, lane, series, rates, stretching, growth, force, wall_pull)
    extend_pair(12, direction, lane, series, rates, stretching, growth, force, wall_pull)
    extend_pair(14, direction, lane, series, rates, stretching, growth, force, wall_pull)
    extend_pair(16, direction, lane, series, rates, stretching, growth, force, wall_pull)


@inlined
def _turn_due(lane, mean, velocity, direction, force):
    """Lanes where the rules may change the direction of a block in the step that starts now."""
    due = spread(0.0) > 1.0
    for block in range(direction.shape[0]):
        heading = load(direction, (block, lane))
        turned = heading * load(velocity, (block, lane)) <= 0.0
        beyond = abs(load(force, (at(0, block),))) > mean
        due = due | (turned & ((heading != 0.0) | beyond))
    return due


@inlined
def _with_derivatives(coefficients, column, time):
    """Value and two derivatives of the forces in a column."""
    value = load(coefficients, (at(_FORCE_ORDER, column),))
    slope, bend = spread(0.0), spread(0.0)
    for k in range(_FORCE_ORDER - 1, -1, -1):
        bend = fma(bend, time, slope)
        slope = fma(slope, time, value)
        value = fma(value, time, load(coefficients, (at(k, column),)))
    return value, slope, 2.0 * bend


@inlined
def _scheme_velocity(slip_step, acceleration, before):
    """v_r dt of the Appendix, from w, a(t-dt) dt^2 and a(t-2dt) dt^2."""
    return fma(acceleration, 5.0 / 6.0, fma(before, -1.0 / 3.0, slip_step))


@inlined
def _leap(
    lane,
    leaping,
    step,
    time_step,
    kinetic,
    belt,
    displacement,
    slip_step,
    acceleration,
    velocity,
    direction,
    dissipated,
    series,
    force,
):
    """Write the state after a leap: the scheme's variables of the smooth solution."""
    square = time_step * time_step
    cube = square * time_step
    for block in range(direction.shape[0]):
        heading = load(direction, (block, lane))
        position, speed = evaluate(ORDER, series, block, step)
        pull, rise, bend = _with_derivatives(force, block, step)
        a = square * (pull - heading * kinetic)
        central = fma(speed, time_step, rise * (cube / 6.0))
        w = fma(a, -0.5, central)
        rise = rise * cube
        bend = bend * (square * square)
        before = fma(bend, 0.5, a - rise)
        v = _scheme_velocity(w, before, fma(bend, 2.0, a - 2.0 * rise))
        changed = leaping & (heading != 0.0)
        place = (block, lane)
        store(slip_step, place, select(changed, w, load(slip_step, place)))
        store(acceleration, place, select(changed, before, load(acceleration, place)))
        store(velocity, place, select(changed, v, load(velocity, place)))
        shift = position - load(series, (at(0, block + 1),))
        store(dissipated, place, fma(heading * kinetic, shift, load(dissipated, place)))
        store(displacement, place, fma(belt, step, position))


@inlined
def _literal_step(
    lane,
    taken,
    first_step,
    steps_done,
    time_step,
    mean,
    kinetic,
    law,
    belt,
    displacement,
    slip_step,
    acceleration,
    velocity,
    direction,
    dissipated,
    wall_impulse,
    pulls,
    events,
    event_count,
):
    """One step of the Appendix for some of the chains, the rules first."""
    n_blocks = direction.shape[0]
    square = time_step * time_step
    left = spread(0.0)
    for block in range(n_blocks):
        place = load(displacement, (block, lane))
        store(pulls, (block * LANES,), tension(place - left, law))
        left = place
    impulse = load(wall_impulse, (lane,))
    added = load(pulls, (0,)) * time_step
    store(wall_impulse, (lane,), select(taken, impulse + added, impulse))
    for block in range(n_blocks):
        place = (block, lane)
        external = -load(pulls, (block * LANES,))
        if block < n_blocks - 1:
            external = external + load(pulls, ((block + 1) * LANES,))
        old = load(direction, place)
        undecided = taken & (old * load(velocity, place) <= 0.0)
        free = select(abs(external) > mean, copysign(spread(1.0), external), 0.0)
        new = select(undecided, free, old)
        changed = new != old
        before = load(acceleration, place)
        w = load(slip_step, place)
        here = load(displacement, place)
        loss = load(dissipated, place)
        if mask_bits(changed) != 0:
            sticks = mask_bits(changed & (old != 0.0))
            slips = mask_bits(changed & (new != 0.0))
            turned = sticks | slips
            while turned:
                i = lowest_lane(turned)
                turned &= turned - 1
                chain = lane + i
                time = (first_step + steps_done[chain]) * time_step
                force = extract(external, i)
                position = extract(here, i)
                dissipation = extract(loss, i)
                if (sticks >> i) & 1:
                    record_event(
                        chain, time, block, 0.0, force, position, dissipation, events, event_count
                    )
                if (slips >> i) & 1:
                    record_event(
                        chain, time, block, 1.0, force, position, dissipation, events, event_count
                    )
            keeps = ~changed | (old * new != 0.0)
            before = select(keeps, before, 0.0)
            w = select(keeps, w, 0.0)
        a = select(new != 0.0, square * (external - new * kinetic), 0.0)
        w = w + a
        v = _scheme_velocity(w, a, before)
        store(direction, place, new)
        store(slip_step, place, select(taken, w, load(slip_step, place)))
        store(acceleration, place, select(taken, a, load(acceleration, place)))
        store(velocity, place, select(taken, v, load(velocity, place)))
        store(dissipated, place, select(taken, fma(new * kinetic, w, loss), loss))
        moved = here + fma(belt, time_step, w)
        store(displacement, place, select(taken, moved, here))


@inlined
def _height(steps, time_step, column, i, series, belt_velocity, level):
    """Distance of the section's block of one chain from its level, some steps after the start."""
    time = steps * time_step
    value = series[at(ORDER, column) + i]
    for k in range(ORDER - 1, -1, -1):
        value = fma(value, time, series[at(k, column) + i])
    return fma(belt_velocity, time, value) - level


@inlined
def _shifted(time, column, i, series):
    """Coefficients 0 to 4 of the series of one chain about another instant."""
    c0, c1, c2, c3, c4 = series[at(ORDER, column) + i], 0.0, 0.0, 0.0, 0.0
    for k in range(ORDER - 1, -1, -1):
        c4 = fma(c4, time, c3)
        c3 = fma(c3, time, c2)
        c2 = fma(c2, time, c1)
        c1 = fma(c1, time, c0)
        c0 = fma(c0, time, series[at(k, column) + i])
    return c0, c1, c2, c3, c4


@inlined
def _record_crossings(
    lane,
    i,
    leap,
    first_step,
    time_step,
    series,
    belt_velocity,
    section_block,
    level,
    crossings,
    crossing_count,
):
    """Steps of a leap of one chain in which the section's block comes down through its level.

    The instant within the step and the state there are those of linear interpolation.
    """
    n_blocks = (crossings.shape[2] - 1) // 2
    column = section_block + 1
    chain = lane + i
    low = 0.0
    above = series[at(0, column) + i] >= level
    while low < leap:
        # the first eighth of the rest after which the side differs; a leap holds few crossings
        eighth = max(1.0, math.floor(0.125 * (leap - low)))
        high = low
        height = 0.0
        while high < leap:
            high = min(high + eighth, leap)
            height = _height(high, time_step, column, i, series, belt_velocity, level)
            if (height >= 0.0) != above:
                break
            low = high
        if low == leap:
            return
        while high - low > 1.0:
            middle = math.floor(0.5 * (low + high))
            between = _height(middle, time_step, column, i, series, belt_velocity, level)
            if (between >= 0.0) == above:
                low = middle
            else:
                high, height = middle, between
        if above:
            slot = crossing_count[chain]
            if slot == crossings.shape[1]:
                return
            crossing_count[chain] = slot + 1
            time = high * time_step
            belt_step = belt_velocity * time_step
            _, c1, c2, c3, c4 = _shifted(time, column, i, series)
            w = time_step * (c1 - time_step * (c2 - time_step * (c3 - time_step * c4)))
            share = height / (w + belt_step)
            crossings[chain, slot, 0] = (first_step + high - share) * time_step
            for block in range(n_blocks):
                c0, c1, c2, c3, c4 = _shifted(time, block + 1, i, series)
                w = time_step * (c1 - time_step * (c2 - time_step * (c3 - time_step * c4)))
                a = 2.0 * c2 - time_step * (6.0 * c3 - 14.0 * time_step * c4)
                v = c1 - 6.0 * time_step**3 * c4
                place = fma(belt_velocity, time, c0)
                crossings[chain, slot, 1 + block] = place - share * (w + belt_step)
                crossings[chain, slot, 1 + n_blocks + block] = v - share * time_step * a
        low = high
        above = not above


@inlined
def _cross_literally(
    chain,
    now,
    time_step,
    belt_velocity,
    displacement,
    slip_step,
    acceleration,
    velocity,
    section_block,
    level,
    crossings,
    crossing_count,
):
    """Record a crossing in a single step of one chain that ends at step `now`."""
    n_blocks = displacement.shape[0]
    belt_step = belt_velocity * time_step
    after = displacement[section_block, chain] - level
    move = slip_step[section_block, chain] + belt_step
    if after < 0.0 and after - move >= 0.0:
        slot = crossing_count[chain]
        crossing_count[chain] = slot + 1
        share = after / move
        crossings[chain, slot, 0] = (now - share) * time_step
        for block in range(n_blocks):
            w, a = slip_step[block, chain], acceleration[block, chain]
            place = displacement[block, chain] - share * (w + belt_step)
            crossings[chain, slot, 1 + block] = place
            speed = (velocity[block, chain] - share * a) * (1.0 / time_step)
            crossings[chain, slot, 1 + n_blocks + block] = speed


@inlined
def _bend_one(block, i, times, force):
    """Second derivative of the force on a block of the chain in lane i at eight times."""
    first = at(0, block) + i
    bend = spread(0.0)
    for k in range(_FORCE_ORDER, 1, -1):
        bend = fma(bend, times, k * (k - 1.0) * force[first + k * LANES])
    return bend


@inlined
def _record_samples(
    lane,
    i,
    leap,
    time_step,
    kinetic,
    steps_done,
    belt_velocity,
    direction,
    series,
    force,
    stride,
    first_sample,
    sample_row,
    first_sampled,
    samples,
):
    """Samples of one chain in a leap, eight at a time: they lie side by side."""
    n_blocks = direction.shape[0]
    chain = lane + i
    row = sample_row[chain]
    cube = time_step * time_step * time_step
    count = LANES
    while count == LANES:
        rows = lane_numbers() + row
        steps = fma(to_float(rows), stride, first_sample) - steps_done[chain]
        due = steps <= leap
        since = steps * time_step
        for block in range(first_sampled, n_blocks):
            shown = block - first_sampled
            heading = direction[block, chain]
            position, relative = evaluate_one(ORDER, series, block, i, since)
            if heading != 0.0:
                relative = fma(_bend_one(block, i, since, force), -0.25 * cube, relative)
            shifted = fma(belt_velocity[chain], since, position)
            store_where(samples, (0, shown, chain, row), shifted, due)
            store_where(samples, (1, shown, chain, row), relative, due)
            store_where(samples, (2, shown, chain, row), spread(heading * -kinetic), due)
        count = lowest_lane(~mask_bits(due))
        row += count
    sample_row[chain] = row


@kernel
def leap_steps(
    first_step,
    n_steps,
    time_step,
    constants,
    belt_velocity,
    displacement,
    slip_step,
    acceleration,
    velocity,
    direction,
    dissipated,
    threshold,
    branch_changed,
    wall_impulse,
    steps_done,
    series,
    rates,
    stretching,
    growth,
    force,
    wall_pull,
    polynomials,
    sources,
    tails,
    slopes,
    pulls,
    sample_stride,
    sample_row,
    first_sampled,
    samples,
    events,
    event_count,
    section_block,
    section_displacement,
    crossings,
    crossing_count,
):
    """Advance W chains (W a multiple of 8) by n_steps steps of the Appendix.

    Returns DONE; or EVENTS_FULL or CROSSINGS_FULL, to be called again with a larger buffer.

    first_step : index of the first step (time = index * time_step). steps_done : (W,) of each
    chain, whole numbers, zero to begin with; sample_row : (W,) samples taken, likewise.
    State: displacement from the rest positions, slip_step w, acceleration a(t-dt) dt^2, velocity
    v_r dt, direction, dissipated (N, W); wall_impulse (W,). belt_velocity : (W,).
    threshold : (N, W) F_st; branch_changed : (N, W) zeros, see `find_candidates`.
    constants : (9,) see `law_constants`.
    series of N+1, stretching, growth, force of N, wall_pull of one and polynomials of
    N * CANDIDATES_PER_BLOCK columns (see `beltrepro.engine.taylor.at`), sources (8 of each of the
    latter), rates, tails, slopes, pulls (8 N,): scratch.
    Samples are taken where the step index is a multiple of sample_stride.
    samples : (3, N-first_sampled, W, S) displacement, relative velocity, kinetic friction.
    events, crossings : as for `beltrepro.engine.verlet.verlet_steps`.
    """
    separate_arrays()
    n_blocks, width = displacement.shape
    limit = constants[LINEAR_LIMIT]
    law = spring_law(constants)
    curvatures = constants[COMPRESSION_RATE], constants[EXTENSION_RATE]
    mean = constants[STATIC_FRICTION]
    kinetic = mean * constants[FRICTION_RATIO]
    square = time_step * time_step
    inverse_step = 1.0 / time_step
    log_tolerance = math.log2(_TOLERANCE)
    first_sample = float((first_step // sample_stride + 1) * sample_stride - first_step)
    stride = float(sample_stride)

    for lane in range(0, width, LANES):
        belt = load(belt_velocity, (lane,))
        store(series, (at(1, WALL),), -belt)
        while True:
            done = load(steps_done, (lane,))
            remaining = float(n_steps) - done
            active = remaining > 0.0
            if mask_bits(active) == 0:
                break
            if mask_bits(load(event_count, (lane,)) + 2 * n_blocks > events.shape[1]) != 0:
                return EVENTS_FULL
            crossings_full = load(crossing_count, (lane,)) + 8 > crossings.shape[1]
            if section_block >= 0 and mask_bits(crossings_full) != 0:
                return CROSSINGS_FULL

            # --- the series of all chains, and how many steps they serve ---
            _start_series(
                lane,
                square,
                inverse_step,
                kinetic,
                law,
                curvatures,
                displacement,
                slip_step,
                direction,
                series,
                rates,
                slopes,
                stretching,
                growth,
                force,
                wall_pull,
            )
            due = active & _turn_due(lane, mean, velocity, direction, force)
            leaping = active & ~due
            _extend_series(
                square * (1.0 / 12.0),
                direction,
                lane,
                series,
                rates,
                slopes,
                stretching,
                growth,
                force,
                wall_pull,
            )
            reach = taylor_step(ORDER, n_blocks, log_tolerance, force) * inverse_step
            reach = maximum(_round_down(minimum(reach, remaining)), 1.0)
            reach = select(leaping, reach, 0.0)

            # --- the first turn or change of branch of each chain ---
            longest = reach * time_step
            n_columns = find_candidates(
                ORDER,
                lane,
                longest,
                leaping,
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
            instant, source = first_events(
                ORDER, _RESOLUTION, n_columns, longest, polynomials, sources
            )
            turning = leaping & (source >= 0) & (source < n_blocks)
            ending = leaping & (source >= n_blocks)
            # the next whole step; without a source, the last one before the place reached
            count = instant * inverse_step
            before = maximum(_round_down(count), 1.0)
            after = -_round_down(-count)
            leap = select(instant < longest, before, reach)
            leap = select(ending, maximum(after, 1.0), leap)
            leap = select(turning, maximum(-_round_down(_DOUBT - count), 0.0), leap)
            leap = minimum(leap, reach)
            step = leap * time_step

            # --- there at once ---
            if section_block >= 0:
                goal = load(section_displacement, (lane,))
                crossing = mask_bits(
                    leaping & may_pass(section_block, goal, belt, step, series, tails)
                )
                while crossing:
                    i = lowest_lane(crossing)
                    crossing &= crossing - 1
                    _record_crossings(
                        lane,
                        i,
                        extract(leap, i),
                        first_step + steps_done[lane + i],
                        time_step,
                        series,
                        belt_velocity[lane + i],
                        section_block,
                        section_displacement[lane + i],
                        crossings,
                        crossing_count,
                    )
            row = load(sample_row, (lane,))
            following = fma(to_float(row), stride, first_sample)
            sampled = mask_bits(leaping & (following <= done + leap))
            while sampled:
                i = lowest_lane(sampled)
                sampled &= sampled - 1
                _record_samples(
                    lane,
                    i,
                    extract(leap, i),
                    time_step,
                    kinetic,
                    steps_done,
                    belt_velocity,
                    direction,
                    series,
                    force,
                    stride,
                    first_sample,
                    sample_row,
                    first_sampled,
                    samples,
                )

            # a sum over steps instead of an integral: Euler and Maclaurin
            impulse = integral(_FORCE_ORDER, wall_pull, 0, step)
            pull, rise = polynomial(ORDER, wall_pull, 0, step)
            impulse = impulse - 0.5 * time_step * (pull - load(wall_pull, (at(0, 0),)))
            impulse = fma(rise - load(wall_pull, (at(1, 0),)), square * (1.0 / 12.0), impulse)
            impulse = select(leaping, impulse, 0.0)
            store(wall_impulse, (lane,), load(wall_impulse, (lane,)) + impulse)
            _leap(
                lane,
                leaping & (leap > 0.0),
                step,
                time_step,
                kinetic,
                belt,
                displacement,
                slip_step,
                acceleration,
                velocity,
                direction,
                dissipated,
                series,
                force,
            )
            done = done + leap
            store(steps_done, (lane,), done)

            # --- the step in which the turn may happen ---
            taken = (due | turning) & (done < float(n_steps))
            if mask_bits(taken) != 0:
                _literal_step(
                    lane,
                    taken,
                    first_step,
                    steps_done,
                    time_step,
                    mean,
                    kinetic,
                    law,
                    belt,
                    displacement,
                    slip_step,
                    acceleration,
                    velocity,
                    direction,
                    dissipated,
                    wall_impulse,
                    pulls,
                    events,
                    event_count,
                )
                done = select(taken, done + 1.0, done)
                store(steps_done, (lane,), done)
                if section_block >= 0:
                    stepping = mask_bits(taken)
                    while stepping:
                        i = lowest_lane(stepping)
                        stepping &= stepping - 1
                        _cross_literally(
                            lane + i,
                            first_step + steps_done[lane + i],
                            time_step,
                            belt_velocity[lane + i],
                            displacement,
                            slip_step,
                            acceleration,
                            velocity,
                            section_block,
                            section_displacement[lane + i],
                            crossings,
                            crossing_count,
                        )
                row = load(sample_row, (lane,))
                following = fma(to_float(row), stride, first_sample)
                sampled = mask_bits(taken & (following == done))
                while sampled:
                    i = lowest_lane(sampled)
                    sampled &= sampled - 1
                    chain = lane + i
                    place = sample_row[chain]
                    for block in range(first_sampled, n_blocks):
                        shown = block - first_sampled
                        samples[0, shown, chain, place] = displacement[block, chain]
                        samples[1, shown, chain, place] = velocity[block, chain] * inverse_step
                        samples[2, shown, chain, place] = direction[block, chain] * -kinetic
                    sample_row[chain] = place + 1
    return DONE


# It makes no arrays and keeps none: no references to count, which numba does by calls in the loop.
leap_steps.targetoptions["_nrt"] = False
