"""The exact dynamics: Taylor series between events, instants of slip and stick located on them.

Eight chains are advanced together, each with its own time. One pass of the loop makes the series of
all eight, chooses their steps, clears most event functions by a bound, looks for the first root of
the others, and moves every chain to its first event or to the end of its step:

- a slipping block ends its slip where d v_r = 0 (d: direction of the slip);
- a stuck block starts to slip where F_st - F_ex or F_st + F_ex = 0;
- a spring changes its branch where |dl| = dl_max;
- blocks meet where a spring has no length, which ends the run.

A function that is zero at the start because its own event has just happened is divided by t. What
is exact and what is approximate, see docs/integrators.md.

Another computation can follow the chains: `Hooks` are functions that the kernel calls on the way,
and `companion` is whatever they keep, a named tuple of arrays with the chains along the last axis.

    series_made(order, lane, active, sliding, group, scratch, companion)
    moved(order, lane, active, sliding, step, group, scratch, companion)
    event_applied(kind, block, lane, i, group, scratch, companion)

`order` is that of the series; `lane` is the first of the eight chains; `active` are those that move
in this pass, `sliding` those of which a block slips. (The others wait on the belt: their series
serve only until the first spring changes its branch.) `step` is the time that they have moved.
`kind` is SLIP, STICK, REVERSAL or BRANCH, of the chain `lane + i` and the block, or the spring.

`scratch.series` is about the start of the step in all three, and `scratch.step[i]` its length.
After the move `group.chains` holds the new positions and velocities with the old directions,
branches and thresholds; after the event, all that it has changed. The force of the noise is
a + b t, `group.chains.noise_force`: a at the start of the step when series are made, at its end
after.
"""

import functools
import math
from collections.abc import Callable
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
    branch_at,
    extension,
    inverse_mass,
    kinetic_friction,
    mean_threshold,
    noise_share,
    slip_direction,
    spring_energy,
    stiffness,
)
from beltrepro.engine.noise import normal_pair, normal_pairs_where
from beltrepro.engine.records import (
    CONTACT,
    CROSSINGS_AT_ONCE,
    DONE,
    STORM,
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
    square_root,
    store,
    to_float,
)
from beltrepro.engine.taylor import (
    NOISY_ORDER,
    ORDER,
    WALL,
    Series,
    at,
    evaluate_one,
    extend_series,
    force_order,
    friction_term,
    integral,
    mean_change,
    new_series,
    polynomial,
    start_springs,
    value_and_slope,
)
from beltrepro.engine.vector import inlined, kernel, minimum, separate_arrays, zeros

# Longest cell of the noise, model time, of the paper's chain: variances are then too small by
# (omega h)^4 / 720, 1.4e-3 at the highest frequency of linear springs, omega = 2.
NOISE_CELL = 0.5
# Cells of the noise are shorter where v_r is nearer to zero than so many standard deviations.
_GRAZING = 2.0

# Of a step, on which the power of friction that depends on the velocity is integrated: a smooth
# function, for which ten nodes are as exact as the series.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
_NODES, _WEIGHTS = tuple((_NODES + 1) / 2), tuple(_WEIGHTS / 2)

_EVENTS_AT_ONCE = 2  # of a chain at one instant: the end of a slip and the start of the next
SLIP, STICK, REVERSAL, BRANCH, NOTHING = range(5)  # kinds of events, as the hooks are told


class EventChains(NamedTuple):
    """State of W chains, W a multiple of 8; positions are displacements from the rest positions."""

    time: np.ndarray  # (W,) since the start of the span
    passes: np.ndarray  # (W,) steps taken since then
    displacement: np.ndarray  # (N, W)
    velocity: np.ndarray  # (N, W) relative to the belt
    direction: np.ndarray  # (N, W) of the slip, 0: stuck
    threshold: np.ndarray  # (N, W) F_st
    branch: np.ndarray  # (N, W) of the springs: -1, 0, 1 compressed, linear, stretched
    branch_changed: np.ndarray  # (N, W) 1: at the end of its branch, which it has just changed
    dissipated: np.ndarray  # (N, W) friction force times slip since t = 0
    wall_impulse: np.ndarray  # (W,) integral of the first spring's pull since t = 0
    cell: np.ndarray  # (W,) rest of the cell of the noise, model time
    noise_force: np.ndarray  # (2, N, W) force of the noise in the rest of the cell, a + b t
    streams: np.ndarray  # (4, W) random streams


class EventGroup(NamedTuple):
    """W chains of one law with all that moves them; arrays (W,)."""

    law: Law
    varied: Varied | None
    belt_velocity: np.ndarray
    noise: np.ndarray  # sigma
    noise_power: np.ndarray  # q = f_s^2 sigma^2 dt, of the block with the greatest f_s
    noise_cell: float  # longest cell of the noise, model time
    log_tolerance: np.ndarray  # log2 of the force that the last terms may reach in a step
    chains: EventChains


class EventScratch(NamedTuple):
    """What a pass of the loop makes of eight chains."""

    series: Series
    candidates: Candidates
    step: np.ndarray  # (8,) time to the first event, or to the end of the step
    source: np.ndarray  # (8,) of that event, as `Candidates.sources`


def new_scratch(n_blocks: int, varied: bool = False) -> EventScratch:
    """Room for eight chains of N blocks."""
    end = zeros(LANES), zeros(LANES, dtype=np.int64)
    return EventScratch(new_series(n_blocks, varied), new_candidates(n_blocks), *end)


class Span(NamedTuple):
    """What time a call of the kernel is about."""

    start: float  # time since the start of the run
    end: float  # time since `start`
    # a chain that has taken more steps than these since `start` is stopped
    passes_at_once: float
    passes_per_time: float


# --- the series ---


@inlined
def make_series(order, noisy, lane, active, group, series):
    """Series of eight chains about now; draws new cells of the noise where they are used up.

    Returns the chains of which a block slips.
    """
    chains = group.chains
    sliding = load(chains.cell, (lane,)) < 0.0  # none: a rest is not negative
    for block in range(chains.direction.shape[0]):
        place = (block, lane)
        sliding = sliding | (load(chains.direction, place) != 0.0)
        store(series.position, (at(0, block + 1),), load(chains.displacement, place))
        store(series.position, (at(1, block + 1),), load(chains.velocity, place))
    start_springs(group.law, group.varied, chains.branch, lane, series)
    if noisy:
        drawing = active & sliding & (load(chains.cell, (lane,)) <= 0.0)
        if mask_bits(drawing) != 0:
            _draw_cells(lane, drawing, group, series)
    _start_accelerations(lane, group.law, group.varied, chains, series)
    extend_series(order, group.varied, chains.direction, lane, series)
    return sliding


@inlined
def _start_accelerations(lane, law, varied, chains, series):
    """X_2 and X_3 from the forces, the friction and the noise."""
    for block in range(chains.direction.shape[0]):
        heading = load(chains.direction, (block, lane))
        slipping = heading != 0.0
        speed = abs(load(chains.velocity, (block, lane)))
        push = load(chains.noise_force, (0, block, lane))
        push = push - heading * braking(law, varied, block, speed)
        acceleration = load(series.force, (at(0, block),)) + push
        acceleration = acceleration * inverse_mass(varied, block)
        store(series.position, (at(2, block + 1),), select(slipping, 0.5 * acceleration, 0.0))
        jerk = load(series.force, (at(1, block),)) + load(chains.noise_force, (1, block, lane))
        if varied is not None:
            store(series.weakening, (at(0, block),), 1.0 / (1.0 + varied.weakening * speed))
            jerk = jerk - heading * friction_term(1, block, heading, varied, series)
        jerk = jerk * inverse_mass(varied, block)
        store(series.position, (at(3, block + 1),), select(slipping, jerk * (1.0 / 6.0), 0.0))


@inlined
def _draw_cells(lane, drawing, group, series):
    """New noise cells for the chains of a mask: force a + b t until `cell` runs out."""
    chains = group.chains
    power = load(group.noise_power, (lane,))
    length = _cell_length(lane, drawing, power, group, series)
    rate = 1.0 / length
    strength = square_root(power * rate)
    for block in range(chains.noise_force.shape[1]):
        first, second = normal_pairs_where(chains.streams, lane, drawing)
        # on the functions 1 and 2 t / h - 1 white noise has the variances q / h and 3 q / h
        tilt = strength * (math.sqrt(3.0) * second)
        level = strength * first - tilt
        share = noise_share(group.varied, block)
        level, tilt = level * share, tilt * share
        start = load(chains.noise_force, (0, block, lane))
        slope = load(chains.noise_force, (1, block, lane))
        store(chains.noise_force, (0, block, lane), select(drawing, level, start))
        store(chains.noise_force, (1, block, lane), select(drawing, 2.0 * tilt * rate, slope))
    store(chains.cell, (lane,), select(drawing, length, load(chains.cell, (lane,))))


@inlined
def _cell_length(lane, drawing, power, group, series):
    """Length of the next noise cell: short where the noise could decide whether v_r reaches zero.

    Where the parabola of v_r has its vertex in the cell, less than `_GRAZING` standard deviations
    of the noise in the cell away from zero, a cell of a quarter is tried, and so on down to about
    the step of the paper. It looks at the state only, not at the noise to come.
    """
    chains = group.chains
    length = spread(group.noise_cell)
    for _ in range(4):
        grazing = power < 0.0
        margin = square_root(power * length) * _GRAZING
        for block in range(chains.direction.shape[0]):
            heading = load(chains.direction, (block, lane))
            speed = abs(load(chains.velocity, (block, lane)))
            kinetic = braking(group.law, group.varied, block, speed)
            slope = load(series.force, (at(0, block),)) - heading * kinetic
            bend = load(series.force, (at(1, block),))
            inverse = inverse_mass(group.varied, block)
            slope, bend = slope * inverse, bend * inverse
            # the vertex is at -slope / bend; half a length beyond the cell may yet come into it
            ahead = (slope * bend < 0.0) & (abs(slope) < 1.5 * length * abs(bend))
            twice = 2.0 * bend
            depth = fma(twice, load(chains.velocity, (block, lane)), -(slope * slope))
            near = ahead & (abs(depth) < margin * inverse * abs(twice))
            grazing = grazing | (near & drawing & (heading != 0.0))
        if mask_bits(grazing) == 0:
            break
        length = select(grazing, 0.25 * length, length)
    return length


# --- the first events ---


@inlined
def find_first_event(order, noisy, resolution, lane, moving, remaining, group, scratch):
    """Write the first event of each moving chain, or the end of its step, to the scratch.

    A step ends within the tolerance, the cell of the noise and the span.
    """
    accuracy = load(group.log_tolerance, (lane,))
    step = minimum(taylor_step(order, accuracy, group.varied, scratch.series), remaining)
    if noisy:
        step = minimum(step, load(group.chains.cell, (lane,)))
    step = select(moving, step, 0.0)
    n_columns = find_candidates(order, False, lane, step, moving, group.varied, group, scratch)
    step, source = first_events(order, resolution, n_columns, step, scratch.candidates)
    store(scratch.step, (0,), step)
    store(scratch.source, (0,), source)


@inlined
def wait_on_belt(lane, i, end, group, scratch):
    """The same for a chain at rest on the belt, in closed form: only the first spring stretches."""
    chains, series = group.chains, scratch.series
    chain = lane + i
    pull = series.force[at(0, 0) + i] + series.wall_pull[i] + chains.threshold[0, chain]
    pull = pull / stiffness(group.varied, 0)
    way = extension(pull, group.law) - chains.displacement[0, chain]
    wait = max(way / group.belt_velocity[chain], 0.0)
    first = 0
    # only a start beyond the threshold can put a block here, at time 0
    for block in range(chains.direction.shape[0] - 1, -1, -1):
        if abs(series.force[at(0, block) + i]) > chains.threshold[block, chain]:
            first, wait = block, 0.0
    rest = end - chains.time[chain]
    scratch.source[i] = first if wait <= rest else -1
    scratch.step[i] = min(wait, rest)


@inlined
def record_crossings(order, lane, moving, step, start, group, scratch, crossings):
    """Downward crossings of the section within the steps of moving chains.

    When all blocks are stuck the last one only moves up.
    """
    crossing = may_pass(lane, moving, step, group, scratch, crossings)
    while crossing:
        i = lowest_lane(crossing)
        crossing &= crossing - 1
        _cross(order, lane, i, start + group.chains.time[lane + i], group, scratch, crossings)


@inlined
def _cross(order, lane, i, start, group, scratch, crossings):
    """Downward crossings of the section within the step of one chain."""
    chain, series, step = lane + i, scratch.series, scratch.step[i]
    belt_velocity = group.belt_velocity[chain]
    # nearer to a crossing rounding decides on the side, so the search for the next begins beyond
    resolution = 1e-14 * max(step, 1.0)
    above = series.position[at(0, crossings.block + 1) + i] >= crossings.level[chain]
    passed = 0.0
    while passed < step:
        # the first eighth of the rest after which the side differs; a step holds few crossings
        eighth = 0.125 * (step - passed)
        changed = _sides(order, chain, i, passed, eighth, belt_velocity, series, crossings)
        if above:
            changed ^= 0xFF
        if changed == 0:
            return
        low = passed
        while changed & 1 == 0:
            changed >>= 1
            low += eighth
        high = low + eighth
        place = _locate_crossing(
            order, chain, i, low, high, above, resolution, belt_velocity, series, crossings
        )
        if above:
            slot = crossings.count[chain]
            if slot == crossings.rows.shape[1]:
                return
            n_blocks = group.chains.direction.shape[0]
            crossings.rows[chain, slot, 0] = start + place
            for block in range(n_blocks):
                value, slope = value_and_slope(order, series.position, block + 1, i, place)
                crossings.rows[chain, slot, 1 + block] = value + belt_velocity * place
                crossings.rows[chain, slot, 1 + n_blocks + block] = slope
            crossings.count[chain] = slot + 1
        above = not above
        passed = place + resolution


@inlined
def _sides(order, chain, i, passed, eighth, belt_velocity, series, crossings):
    """Bits of those of the next eight instants at which a chain is above the section."""
    column = crossings.block + 1
    places = fma(to_float(lane_numbers()) + 1.0, eighth, passed)
    value = spread(series.position[at(order, column) + i])
    for k in range(order - 1, -1, -1):
        value = fma(value, places, spread(series.position[at(k, column) + i]))
    return mask_bits(fma(belt_velocity, places, value) >= crossings.level[chain])


@inlined
def _locate_crossing(
    order, chain, i, low, high, above, resolution, belt_velocity, series, crossings
):
    """Instant of a crossing: Newton's method in its bracket, by halves where it leaves it."""
    place = 0.5 * (low + high)
    for _ in range(60):  # 44 halvings would do
        value, slope = value_and_slope(order, series.position, crossings.block + 1, i, place)
        value += belt_velocity * place - crossings.level[chain]
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
    return place


@inlined
def record_samples(order, noisy, lane, active, later, end, group, series, samples):
    """Samples of active chains until the instants `later`."""
    row = load(samples.following, (lane,))
    instant = minimum(fma(to_float(row), samples.interval, samples.first), end)
    sampled = mask_bits(active & (row < samples.count) & (instant <= later))
    while sampled:
        i = lowest_lane(sampled)
        sampled &= sampled - 1
        _sample(order, noisy, lane, i, extract(later, i), end, group, series, samples)


@inlined
def _sample(order, noisy, lane, i, until, end, group, series, samples):
    """Samples of one chain until `until`, eight at a time: they lie side by side."""
    chains = group.chains
    chain = lane + i
    belt_velocity = group.belt_velocity[chain]
    row = samples.following[chain]
    count = LANES
    while count == LANES:
        rows = lane_numbers() + row
        instants = minimum(fma(to_float(rows), samples.interval, samples.first), end)
        due = (rows < samples.count) & (instants <= until)
        since = instants - chains.time[chain]
        for block in range(samples.first_block, chains.direction.shape[0]):
            position, relative = evaluate_one(order, series, block, i, since)
            heading = chains.direction[block, chain]
            kinetic = braking(group.law, group.varied, block, abs(relative))
            friction = spread(-heading) * kinetic
            # nobody looks at the friction where not all blocks are sampled, and it takes time
            if noisy and samples.first_block == 0:
                slips = heading * heading
                level = slips * chains.noise_force[0, block, chain]
                slope = slips * chains.noise_force[1, block, chain]
                friction = friction + fma(slope, since, level)
            shifted = fma(belt_velocity, since, position)
            write_samples(samples, chain, block, row, shifted, relative, friction, due)
        count = lowest_lane(~mask_bits(due))
        row += count
    samples.following[chain] = row


# --- to the first events ---


@inlined
def move(order, noisy, lane, moving, step, group, series):
    """Advance the blocks by the steps; those of chains at rest move with the belt."""
    chains = group.chains
    belt = load(group.belt_velocity, (lane,))
    impulse = select(moving, integral(force_order(order), series.wall_pull, 0, step), 0.0)
    store(chains.wall_impulse, (lane,), load(chains.wall_impulse, (lane,)) + impulse)
    for block in range(chains.direction.shape[0]):
        place = (block, lane)
        position, relative = polynomial(order, series.position, block + 1, step)
        shift = position - load(series.position, (at(0, block + 1),))
        heading = load(chains.direction, place)
        loss = _friction_loss(order, block, heading, shift, step, group.law, group.varied, series)
        if noisy:
            slipping = heading != 0.0
            work = _move_noise(order, lane, block, step, shift, chains, series)
            loss = loss - select(slipping, work, 0.0)
        store(chains.dissipated, place, load(chains.dissipated, place) + loss)
        store(chains.displacement, place, fma(belt, step, position))
        store(chains.velocity, place, relative)
        # of events at one instant the next comes in a step of no length: the spring is still there
        flag = load(chains.branch_changed, place)
        store(chains.branch_changed, place, select(step > 0.0, 0.0, flag))


@inlined
def _friction_loss(order, block, heading, shift, step, law, varied, series):
    """Energy that friction takes from a block in the step: the integral of force times speed.

    Where friction may vary by the rule of Gauss and Legendre, from the law and not its series.
    """
    if varied is None:
        return heading * kinetic_friction(law) * shift
    total = spread(0.0)
    for node in range(len(_NODES)):
        _, relative = polynomial(order, series.position, block + 1, _NODES[node] * step)
        speed = heading * relative
        power = braking(law, varied, block, abs(speed)) * speed
        total = fma(_WEIGHTS[node], power, total)
    return total * step


@inlined
def _move_noise(order, lane, block, step, shift, chains, series):
    """Advance the force of the noise on a block by the step; returns its work."""
    level = load(chains.noise_force, (0, block, lane))
    slope = load(chains.noise_force, (1, block, lane))
    mean_shift = mean_change(order, series, block, step)
    store(chains.noise_force, (0, block, lane), fma(slope, step, level))
    return fma(level, shift, slope * step * (shift - mean_shift))


# --- what the events change ---


@inlined
def apply_event(order, noisy, rests, lane, i, start, group, scratch, events):
    """What the event of one chain changes; rests : whether it was at rest on the belt.

    Returns the kind of the event and the block, or the spring for BRANCH.
    """
    source = scratch.source[i]
    chains, chain = group.chains, lane + i
    n_blocks = chains.direction.shape[0]
    if rests:
        _end_rest(chain, scratch.step[i], group)
        if source < 0:
            return NOTHING, 0
        external = -chains.threshold[0, chain]
        if scratch.step[i] == 0.0:
            external = scratch.series.force[at(0, source) + i]
        chains.direction[source, chain] = slip_direction(external, -1.0)
        _record(chain, source, 1.0, external, start, chains, events)
        return SLIP, source
    if source >= n_blocks:
        spring = source - n_blocks
        way = 1.0 if stretch(spring, chain, chains.displacement) > 0.0 else -1.0
        chains.branch[spring, chain] = way if chains.branch[spring, chain] == 0.0 else 0.0
        chains.branch_changed[spring, chain] = 1.0
        return BRANCH, spring
    return _turn(order, noisy, lane, i, source, start, group, scratch, events), source


@inlined
def _end_rest(chain, waited, group):
    """The first spring after a rest on the belt: what it has pulled and where it is."""
    law, chains = group.law, group.chains
    belt_velocity = group.belt_velocity[chain]
    here = chains.displacement[0, chain]
    before = here - belt_velocity * waited
    gained = spring_energy(0, here, law, group.varied)
    gained -= spring_energy(0, before, law, group.varied)
    chains.wall_impulse[chain] += gained / belt_velocity
    chains.branch[0, chain] = branch_at(here, law)


@inlined
def _record(chain, block, slips, external, start, chains, events):
    here, loss = chains.displacement[block, chain], chains.dissipated[block, chain]
    record_event(chain, start + chains.time[chain], block, slips, external, here, loss, events)


@inlined
def stretch(spring, chain, displacement):
    """Deformation of a spring of one chain, from displacements (N, W)."""
    here = displacement[spring, chain]
    return here - displacement[spring - 1, chain] if spring > 0 else here


@inlined
def _turn(order, noisy, lane, i, block, start, group, scratch, events):
    """A slip that ends, or starts, or ends and starts at once; returns which."""
    chains, since = group.chains, scratch.step[i]
    chain = lane + i
    external, _ = value_and_slope(force_order(order), scratch.series.force, block, i, since)
    kind, way = SLIP, slip_direction(external, -1.0)
    if chains.direction[block, chain] != 0.0:
        if noisy:
            # the other deviate is dropped: a chain keeps nothing between draws but its stream
            first, _ = normal_pair(chains.streams, chain)
            noise = group.noise[chain]
            mean = mean_threshold(group.law, group.varied, block)
            chains.threshold[block, chain] = mean + noise * first
        way = slip_direction(external, chains.threshold[block, chain])
        kind = STICK if way == 0.0 else REVERSAL
        chains.velocity[block, chain] = 0.0
        chains.direction[block, chain] = 0.0
        _record(chain, block, 0.0, external, start, chains, events)
    if kind != STICK:
        chains.direction[block, chain] = way
        _record(chain, block, 1.0, external, start, chains, events)
    return kind


# --- the kernel ---


@inlined
def _no_hook(*arguments):
    """Nothing follows the chains."""


class Hooks(NamedTuple):
    """Functions, made with `inlined`, that the kernel calls on the way; see above."""

    series_made: Callable = _no_hook
    moved: Callable = _no_hook
    event_applied: Callable = _no_hook


@functools.cache
def advance_kernel(noisy: bool, hooks: Hooks) -> Callable:
    """The kernel for chains with noise, or for those without."""
    # of the series, and of the instants of events, as a share of the step: a few roundings, so that
    # a contact is missed by rounding alone; with noise, which is approximate itself, less will do
    order, resolution = (NOISY_ORDER, 1e-10) if noisy else (ORDER, 1e-15)
    series_made, moved, event_applied = hooks

    @kernel
    def advance_chains(span, group, scratch, records, companion):
        """Advance the chains of a group from their times to `span.end`.

        Chains of the other kind, with or without noise, stay where they are.
        Returns DONE; EVENTS_FULL or CROSSINGS_FULL, to be called again with a larger buffer; STORM
        when some chain has taken more steps than `span` allows; or CONTACT when blocks meet.

        span : Span; group : EventGroup; scratch : EventScratch; records : Records; companion :
        whatever the hooks need, () without any.
        """
        separate_arrays()
        chains, series = group.chains, scratch.series
        for lane in range(0, chains.time.size, LANES):
            store(series.position, (at(1, WALL),), -load(group.belt_velocity, (lane,)))
            served = load(group.noise, (lane,)) > 0.0
            if not noisy:
                served = ~served
            while True:
                now = load(chains.time, (lane,))
                remaining = span.end - now
                active = served & (remaining > 0.0)
                if mask_bits(active) == 0:
                    break
                passes = load(chains.passes, (lane,)) + select(active, 1.0, 0.0)
                store(chains.passes, (lane,), passes)
                if mask_bits(passes > fma(now, span.passes_per_time, span.passes_at_once)) != 0:
                    return STORM
                status = full_buffer(lane, _EVENTS_AT_ONCE, CROSSINGS_AT_ONCE, records)
                if status != DONE:
                    return status

                sliding = make_series(order, noisy, lane, active, group, series)
                series_made(order, lane, active, sliding, group, scratch, companion)
                moving = active & sliding
                find_first_event(order, noisy, resolution, lane, moving, remaining, group, scratch)
                resting = mask_bits(active & ~sliding)
                waiting = resting
                while waiting:
                    i = lowest_lane(waiting)
                    waiting &= waiting - 1
                    wait_on_belt(lane, i, span.end, group, scratch)
                step = load(scratch.step, (0,))
                # the end itself, to the bit: now + (end - now) may be rounded
                later = select(step >= remaining, span.end, now + step)

                if records.crossings.block >= 0:
                    record_crossings(
                        order, lane, moving, step, span.start, group, scratch, records.crossings
                    )
                record_samples(
                    order, noisy, lane, active, later, span.end, group, series, records.samples
                )
                move(order, noisy, lane, moving, step, group, series)
                store(chains.time, (lane,), later)
                if noisy:
                    # cells of the noise end with the slips: at rest no noise acts, and white noise
                    # after it owes nothing to that before
                    rest = load(chains.cell, (lane,))
                    rest = select(step >= rest, 0.0, rest - step)
                    store(chains.cell, (lane,), select(sliding, rest, 0.0))
                moved(order, lane, active, sliding, step, group, scratch, companion)

                source = load(scratch.source, (0,))
                changing = mask_bits(source >= 0) | resting
                if changing and mask_bits(source >= 2 * chains.direction.shape[0]) != 0:
                    return CONTACT
                while changing:
                    i = lowest_lane(changing)
                    changing &= changing - 1
                    rests = (resting >> i) & 1
                    kind, block = apply_event(
                        order, noisy, rests, lane, i, span.start, group, scratch, records.events
                    )
                    if kind != NOTHING:
                        event_applied(kind, block, lane, i, group, scratch, companion)
        return DONE

    return advance_chains
