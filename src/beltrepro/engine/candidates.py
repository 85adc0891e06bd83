"""Where events may be on a Taylor series: its reach, bounds that clear most event functions, roots.

An event function is positive until its event: d v_r of a slipping block, F_st - F_ex and
F_st + F_ex of a stuck one, the distance of a deformation from the end of its branch, the length of
a spring. Those that a bound does not clear become candidates, at most one of each chain in a column
of vectors, and the first root of all ends the step.
"""

from typing import NamedTuple

import numpy as np

from beltrepro.engine.law import rest_length
from beltrepro.engine.simd import (
    LANES,
    as_bits,
    copysign,
    fma,
    load,
    mask_bits,
    select,
    spread,
    square_root,
    store,
    to_float,
)
from beltrepro.engine.taylor import LEVELS, at, bounds, deformation, drive, force_order, polynomial
from beltrepro.engine.vector import exp2, inlined, maximum, minimum, zeros

# A stuck block may slip both ways, its spring leave its branch at both ends and lose its length.
_CANDIDATES_PER_BLOCK = 5
# Of the search for a root. It converges quadratically but near a minimum that all but touches zero,
# where moves are short; what is not decided then is left to the next step.
_MAX_ITERATIONS = 200


class Candidates(NamedTuple):
    """Event functions of eight chains that may have a root in the step, at most 5 N columns."""

    polynomials: np.ndarray  # coefficients, in columns as those of `beltrepro.engine.taylor.Series`
    # (8 for each column) -1: none; b < N: block b sticks or slips; N + s: spring s changes branch;
    # 2 N + s: spring s has no length
    sources: np.ndarray
    tails: np.ndarray  # (8 N,) bounds of the positions over t from the third order on


def new_candidates(n_blocks: int) -> Candidates:
    """Room for the candidates of eight chains of N blocks."""
    columns = n_blocks * _CANDIDATES_PER_BLOCK
    return Candidates(
        polynomials=zeros(columns * LEVELS * LANES),
        sources=zeros(columns * LANES, dtype=np.int64),
        tails=zeros(n_blocks * LANES),
    )


@inlined
def _binary_logarithm(x):
    """Upper bound of log2(x), x > 0, by 0.09 at most: linear between powers of two."""
    return fma(to_float(as_bits(x)), 2.0**-52, 0.0861 - 1023.0)


@inlined
def taylor_step(order, log_tolerance, varied, series):
    """Step at which the last two terms of the series of all forces are within the tolerance."""
    highest = force_order(order)
    # two terms, since every second one may vanish; not zero, for the logarithm
    last = spread(1e-200)
    before = spread(1e-200)
    for block in range(series.rate.shape[0] // LANES):
        last = maximum(last, abs(load(series.force, (at(highest, block),))))
        before = maximum(before, abs(load(series.force, (at(highest - 1, block),))))
        if varied is not None:
            # friction has a series of its own, which may converge later
            pushed = (highest + 1.0) * (highest + 2.0) / varied.inverse_mass[block]
            last = maximum(last, pushed * abs(load(series.position, (at(order, block + 1),))))
            pushed = highest * (highest + 1.0) / varied.inverse_mass[block]
            last_but_one = load(series.position, (at(order - 1, block + 1),))
            before = maximum(before, pushed * abs(last_but_one))
    exponent = (log_tolerance - _binary_logarithm(last)) * (1.0 / highest)
    exponent_before = (log_tolerance - _binary_logarithm(before)) * (1.0 / (highest - 1))
    return exp2(minimum(exponent, exponent_before), 1.0)


@inlined
def _force_tail(order, block, slipping, step, varied, series):
    """Bound on the step of the terms of F_ex from the third order on, as `drive` has them."""
    highest = force_order(order)
    square = step * step
    odd = abs(drive(highest, block, slipping, varied, series))
    even = abs(drive(highest - 1, block, slipping, varied, series))
    for k in range(highest - 2, 3, -2):
        odd = fma(odd, square, abs(drive(k, block, slipping, varied, series)))
        even = fma(even, square, abs(drive(k - 1, block, slipping, varied, series)))
    odd = fma(odd, square, abs(drive(3, block, slipping, varied, series)))
    return fma(even, step, odd) * (step * square)


@inlined
def _block_bounds(block, heading, tail, step, varied, series):
    """Bounds on the step of d v_r of slipping and F_ex of stuck blocks.

    tail : from `_force_tail`; v_r has the terms F_{k-1} t^k / k, so a quarter of it bounds them
    from the fourth order on. The third value is a lower bound of d v_r / t where v_r starts at 0.
    """
    column = block + 1
    slipping = heading != 0.0
    bend = drive(2, block, slipping, varied, series)
    c0 = heading * load(series.position, (at(1, column),))
    c0 = select(slipping, c0, load(series.force, (at(0, block),)))
    c1 = heading * 2.0 * load(series.position, (at(2, column),))
    c1 = select(slipping, c1, load(series.force, (at(1, block),)))
    c2 = select(slipping, heading * 3.0 * load(series.position, (at(3, column),)), bend)
    rest_rate = fma(abs(bend) * (1.0 / 3.0), step * step, 0.25 * tail)
    least, greatest = bounds(c0, c1, c2, select(slipping, rest_rate * step, tail), step)
    return least, greatest, minimum(c1, fma(c2, step, c1)) - rest_rate


@inlined
def _position_tail(block, heading, tail, step, series):
    """Bound on the step of the terms of the position over t from the third order on.

    From X_{k+2} = F_k / ((k+1)(k+2)), with `tail` from `_force_tail`.
    """
    third = abs(load(series.position, (at(3, block + 1),)))
    fourth = abs(load(series.position, (at(4, block + 1),)))
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
def _reserve(lanes, source, used, column, candidates):
    """Find a column with free places for the candidates of some lanes, and note their source.

    used : bits of the lanes taken in the last column (-1: none yet); returns both after that.
    """
    bits = mask_bits(lanes)
    if column < 0 or used & bits != 0:
        column += 1
        used = 0
        store(candidates.sources, (column * LANES,), -1)
    sources = select(lanes, source, load(candidates.sources, (column * LANES,)))
    store(candidates.sources, (column * LANES,), sources)
    return used | bits, column


@inlined
def _put(k, column, lanes, coefficient, candidates):
    """Coefficient k of the candidates of some lanes."""
    place = (at(k, column),)
    others = load(candidates.polynomials, place)
    store(candidates.polynomials, place, select(lanes, coefficient, others))


@inlined
def _put_slip_end(order, column, lanes, block, heading, begins, series, candidates):
    """Candidates: the first root of d v_r; of d v_r / t where it starts at 0."""
    rate = load(series.position, (at(1, block + 1),))
    for k in range(order):
        divided = spread(0.0)
        if k + 2 <= order:
            divided = load(series.position, (at(k + 2, block + 1),)) * (k + 2.0)
        _put(k, column, lanes, heading * select(begins, divided, rate), candidates)
        rate = divided
    _put(order, column, lanes, spread(0.0), candidates)


@inlined
def _put_slip_start(order, column, lanes, block, way, threshold, series, candidates):
    """Candidates: the first root of F_st - way F_ex."""
    _put(0, column, lanes, threshold - way * load(series.force, (at(0, block),)), candidates)
    for k in range(1, order - 1):
        _put(k, column, lanes, -way * load(series.force, (at(k, block),)), candidates)
    for k in range(order - 1, order + 1):
        _put(k, column, lanes, spread(0.0), candidates)


@inlined
def _put_branch_end(order, column, lanes, spring, sign, offset, divided, series, candidates):
    """Candidates: the first root of offset + sign D; divided by t where it is zero at the start.

    By t^2 where its rate is zero too: a slip begins beside a spring at the end of its branch.
    """
    change = deformation(0, spring, series)
    following = deformation(1, spring, series)
    twice = divided & (following == 0.0)
    for k in range(order + 1):
        later = spread(0.0)
        if k + 2 <= order:
            later = deformation(k + 2, spring, series)
        coefficient = sign * select(divided, select(twice, later, following), change)
        if k == 0:
            coefficient = coefficient + select(divided, 0.0, offset)
        _put(k, column, lanes, coefficient, candidates)
        change, following = following, later


@inlined
def find_candidates(order, passed, lane, step, moving, varied, group, scratch):
    """Collect the event functions that bounds do not clear; returns how many columns of them.

    passed : whether a series may begin up to a step after an event instead of at it, a constant; a
    function then may stand on either side of its zero and is cleared if it goes away from it.
    lane : first of the eight chains; step (float64x8); moving : chains to look at.
    varied : that of the group, by itself: numba looks for None among the arguments only.
    """
    series, candidates = scratch.series, scratch.candidates
    n_blocks = group.chains.direction.shape[0]
    column, used = -1, 0
    for block in range(n_blocks):
        used, column = _block_candidates(
            order, passed, lane, block, step, moving, used, column, group, scratch
        )
    tail_before = spread(0.0)
    lowest = spread(0.0 if varied is None else 1e300)
    for spring in range(n_blocks):
        tail = load(candidates.tails, (spring * LANES,))
        limits = _spring_bounds(spring, tail + tail_before, step, series)
        tail_before = tail
        room = limits[0] if varied is None else limits[0] + varied.rest_length[spring]
        lowest = minimum(lowest, room)
        used, column = _spring_candidates(
            order, passed, lane, spring, limits, moving, used, column, group, scratch
        )
    near = moving & ~(lowest > (-group.law.rest_length if varied is None else 0.0))
    if mask_bits(near) != 0:
        # the lengths of all springs of these lanes
        for spring in range(n_blocks):
            used, column = _reserve(near, 2 * n_blocks + spring, used, column, candidates)
            length = rest_length(group.law, varied, spring)
            none = near & ~near
            _put_branch_end(order, column, near, spring, 1.0, length, none, series, candidates)
    return column + 1


@inlined
def _block_candidates(order, passed, lane, block, step, moving, used, column, group, scratch):
    """Candidates for the end or the start of a slip; returns used and column as `_reserve`."""
    varied, chains = group.varied, group.chains
    series, candidates = scratch.series, scratch.candidates
    heading = load(chains.direction, (block, lane))
    slipping = heading != 0.0
    tail = _force_tail(order, block, slipping, step, varied, series)
    position_tail = _position_tail(block, heading, tail, step, series)
    store(candidates.tails, (block * LANES,), position_tail)
    least, greatest, least_rate = _block_bounds(block, heading, tail, step, varied, series)
    threshold = load(chains.threshold, (block, lane))
    speed = heading * load(series.position, (at(1, block + 1),))
    # exactly zero only where the slip has just begun
    begins = slipping & (speed == 0.0)
    gains = begins & (least_rate > 0.0)
    if passed:
        gains = slipping & (speed >= 0.0) & (least_rate > 0.0)
    below = moving & ~gains & ~(least > select(slipping, 0.0, -threshold))
    above = moving & ~slipping & ~(greatest < threshold)
    if mask_bits(below | above) != 0:
        lanes = below & slipping
        if mask_bits(lanes) != 0:
            used, column = _reserve(lanes, block, used, column, candidates)
            _put_slip_end(order, column, lanes, block, heading, begins, series, candidates)
        lanes = (below & ~slipping) | above
        if mask_bits(lanes) != 0:
            used, column = _reserve(lanes, block, used, column, candidates)
            way = select(above, 1.0, spread(-1.0))
            _put_slip_start(order, column, lanes, block, way, threshold, series, candidates)
            lanes = below & above
            if mask_bits(lanes) != 0:
                used, column = _reserve(lanes, block, used, column, candidates)
                _put_slip_start(order, column, lanes, block, -way, threshold, series, candidates)
    return used, column


@inlined
def _spring_candidates(order, passed, lane, spring, limits, moving, used, column, group, scratch):
    """Candidates for a change of branch; limits : from `_spring_bounds`; returns as `_reserve`."""
    chains, series, candidates = group.chains, scratch.series, scratch.candidates
    least, greatest, least_rate = limits
    limit = group.law.linear_limit
    rate = load(series.rate, (spring * LANES,))
    linear = rate == 0.0
    changed = load(chains.branch_changed, (spring, lane)) != 0.0
    leaves = changed & (least_rate > 0.0)
    upper = changed & (deformation(0, spring, series) > 0.0)
    lower = changed & ~upper
    clear_above = (greatest < limit) | (upper & leaves)
    clear_below = (least > -limit) | (lower & leaves)
    clear_beyond = (select(rate < 0.0, -greatest, least) > limit) | leaves
    if passed:
        # the way of a deformation that does not turn
        way = select(least_rate > 0.0, deformation(1, spring, series), 0.0)
        clear_above = clear_above | (way < 0.0)
        clear_below = clear_below | (way > 0.0)
        clear_beyond = clear_beyond | (rate * way > 0.0)
    above = moving & linear & ~clear_above
    below = moving & linear & ~clear_below
    beyond = moving & ~linear & ~clear_beyond
    # between two stuck blocks a spring may stand at the end of its branch, and stays there
    lanes = (above | below | beyond) & (least != greatest)
    if mask_bits(lanes) != 0:
        above, below = above & lanes, below & lanes
        source = chains.direction.shape[0] + spring
        used, column = _reserve(lanes, source, used, column, candidates)
        sign = select(linear, select(above, -1.0, spread(1.0)), copysign(spread(1.0), rate))
        offset = select(linear, limit, spread(-limit))
        divided = changed & ~(linear & (above ^ upper))
        _put_branch_end(order, column, lanes, spring, sign, offset, divided, series, candidates)
        lanes = above & below
        if mask_bits(lanes) != 0:
            used, column = _reserve(lanes, source, used, column, candidates)
            _put_branch_end(order, column, lanes, spring, -sign, offset, lower, series, candidates)
    return used, column


@inlined
def first_events(order, resolution, n_columns, step, candidates):
    """First events of the eight chains: their instants (else the step), their sources (else -1)."""
    instant = step
    source = spread(-1)
    for column in range(n_columns):
        candidate = load(candidates.sources, (column * LANES,))
        place, hit, undecided = first_roots(
            order, resolution, candidates.polynomials, column, step, candidate >= 0
        )
        # of events at one instant the first column has it, the rest follow in steps of length zero
        earlier = (hit | undecided) & (place < instant)
        # one exactly at the end of the step counts
        first = hit & (place == instant) & (source < 0)
        source = select(earlier | first, select(hit, candidate, -1), source)
        instant = select(earlier, place, instant)
    return instant, source


@inlined
def may_pass(lane, moving, step, group, scratch, crossings):
    """Bits of the moving chains whose block may be at the section within the step.

    After `find_candidates`, which has left bounds of the positions.
    """
    position, column = scratch.series.position, crossings.block + 1
    level = load(crossings.level, (lane,))
    c0 = load(position, (at(0, column),))
    c1 = load(position, (at(1, column),)) + load(group.belt_velocity, (lane,))
    c2 = load(position, (at(2, column),))
    tail = load(scratch.candidates.tails, (crossings.block * LANES,))
    least, greatest = bounds(c0, c1, c2, tail * step, step)
    return mask_bits(moving & ~((least >= level) | (greatest < level)))


@inlined
def _curvature_bounds(order, polynomials, column, length):
    """M, to which a positive term of q'' adds nothing, and a bound of |q''|."""
    square = length * length
    curvature, curvature_odd = spread(0.0), spread(0.0)
    greatest, greatest_odd = spread(0.0), spread(0.0)
    for k in range(order - 1, 1, -2):
        weight = k * (k - 1.0)
        coefficient = load(polynomials, (at(k, column),))
        curvature = fma(curvature, square, weight * maximum(-coefficient, 0.0))
        greatest = fma(greatest, square, weight * abs(coefficient))
        weight_odd = (k + 1.0) * k
        coefficient_odd = load(polynomials, (at(k + 1, column),))
        curvature_odd = fma(curvature_odd, square, weight_odd * maximum(-coefficient_odd, 0.0))
        greatest_odd = fma(greatest_odd, square, weight_odd * abs(coefficient_odd))
    return fma(curvature_odd, length, curvature), fma(greatest_odd, length, greatest)


@inlined
def first_roots(order, resolution, polynomials, column, length, wanted):
    """First roots in [0, length] of the eight polynomials of a column.

    polynomials : coefficients up to `order`, odd (see `beltrepro.engine.taylor.at`), positive at 0;
    length : float64x8; wanted : lanes to look at; resolution : share of the length by which a root
    may be missed.

    Returns place (float64x8), hit, undecided (masks): a root at `place`; or none up to `place`,
    but not all of the interval could be searched.

    With q'' >= -M on the interval, q(t+s) >= q(t) + q'(t) s - M s^2/2, so the root of that parabola
    never lies beyond the first root of q: stepping from root to root approaches the first root from
    the left, quadratically where it is simple, and cannot pass a pair of roots that a test of signs
    at the ends would miss. A polynomial that is not positive at 0 has its root there.
    """
    curvature, greatest = _curvature_bounds(order, polynomials, column, length)
    accuracy = length * resolution
    position = spread(0.0)
    place = spread(0.0)
    located = length < 0.0
    searching = wanted
    value = load(polynomials, (at(0, column),))
    slope = load(polynomials, (at(1, column),))
    for _ in range(_MAX_ITERATIONS):
        discriminant = square_root(fma(slope, slope, 2.0 * curvature * maximum(value, 0.0)))
        downward = slope < 0.0
        # two forms of the same root, each without cancellation on its side
        numerator = select(downward, 2.0 * value, slope + discriminant)
        step = numerator / select(downward, discriminant - slope, curvature)
        reached = value <= 0.0
        following = select(reached, position, position + step)
        # the root lies within about M step^2 / |slope| beyond the next place
        close = greatest * (step * step) <= accuracy * discriminant
        hit = searching & (reached | close) & (following <= length)
        place = select(searching, following, place)
        position = following
        located = located | hit
        searching = searching & ~hit & (position < length)
        if mask_bits(searching) == 0:
            break
        value, slope = polynomial(order, polynomials, column, position)
    return place, located, searching
