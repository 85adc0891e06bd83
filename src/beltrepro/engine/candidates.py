"""Where events may be on a Taylor series: its reach, bounds that clear most event functions, roots.

An event function is positive until its event: d v_r of a slipping block, F_st - F_ex and
F_st + F_ex of a stuck one, the distance of a deformation from the end of its branch. Those that a
bound does not clear become candidates, at most one of each chain in a column of vectors, and the
first root of all ends the step.
"""

from beltrepro.engine.roots import first_roots
from beltrepro.engine.simd import (
    LANES,
    as_bits,
    fma,
    load,
    mask_bits,
    maximum,
    minimum,
    select,
    spread,
    store,
    to_float,
)
from beltrepro.engine.taylor import at, bounds, deformation
from beltrepro.engine.vector import exp2, inlined

CANDIDATES_PER_BLOCK = 4


@inlined
def _binary_logarithm(x):
    """Upper bound of log2(x), x > 0, by 0.09 at most: linear between powers of two."""
    return fma(to_float(as_bits(x)), 2.0**-52, 0.0861 - 1023.0)


@inlined
def taylor_step(order, n_blocks, log_tolerance, force):
    """Step at which the last two terms of the series of all forces are within the tolerance."""
    force_order = order - 2
    last = spread(1e-200)
    before = spread(1e-200)
    for block in range(n_blocks):
        last = maximum(last, abs(load(force, (at(force_order, block),))))
        before = maximum(before, abs(load(force, (at(force_order - 1, block),))))
    exponent = minimum(
        (log_tolerance - _binary_logarithm(last)) * (1.0 / force_order),
        (log_tolerance - _binary_logarithm(before)) * (1.0 / (force_order - 1)),
    )
    return exp2(exponent, 1.0)


@inlined
def force_tail(order, block, step, force):
    """Bound on the step of the terms of F_ex from the third order on."""
    force_order = order - 2
    square = step * step
    odd = abs(load(force, (at(force_order, block),)))
    even = abs(load(force, (at(force_order - 1, block),)))
    for k in range(force_order - 2, 3, -2):
        odd = fma(odd, square, abs(load(force, (at(k, block),))))
        even = fma(even, square, abs(load(force, (at(k - 1, block),))))
    odd = fma(odd, square, abs(load(force, (at(3, block),))))
    return fma(even, step, odd) * (step * square)


@inlined
def block_bounds(block, heading, tail, step, series, force):
    """Bounds on the step of d v_r of slipping and F_ex of stuck blocks.

    tail : from `force_tail`; v_r has the terms F_{k-1} t^k / k, so a quarter of it bounds them
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
def position_tail(block, heading, tail, step, series):
    """Bound on the step of the terms of the position over t from the third order on.

    From X_{k+2} = F_k / ((k+1)(k+2)), with `tail` from `force_tail`.
    """
    third = abs(load(series, (at(3, block + 1),)))
    fourth = abs(load(series, (at(4, block + 1),)))
    bound = fma(fourth, step, third) * (step * step)
    return select(heading != 0.0, fma(0.05 * tail, step, bound), 0.0)


@inlined
def spring_bounds(spring, tail, step, series):
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
def reserve(lanes, source, used, column, polynomials, sources):
    """Find a column with free places for the candidates of some lanes, and note their source.

    used : bits of the lanes taken in the last column, which is number `column` (-1: none yet).

    Returns used and column after that.
    """
    bits = mask_bits(lanes)
    if column < 0 or used & bits != 0:
        column += 1
        used = 0
        store(sources, (column * LANES,), -1)
    store(sources, (column * LANES,), select(lanes, source, load(sources, (column * LANES,))))
    return used | bits, column


@inlined
def _put(k, column, lanes, coefficient, polynomials):
    """Coefficient k of the candidates of some lanes."""
    place = (at(k, column),)
    store(polynomials, place, select(lanes, coefficient, load(polynomials, place)))


@inlined
def put_slip_end(order, column, lanes, block, heading, begins, series, polynomials):
    """Candidates: the first root of d v_r; of d v_r / t where it starts at 0."""
    rate = load(series, (at(1, block + 1),))
    for k in range(order):
        divided = spread(0.0)
        if k + 2 <= order:
            divided = load(series, (at(k + 2, block + 1),)) * (k + 2.0)
        _put(k, column, lanes, heading * select(begins, divided, rate), polynomials)
        rate = divided
    _put(order, column, lanes, spread(0.0), polynomials)


@inlined
def put_slip_start(order, column, lanes, block, way, threshold, force, polynomials):
    """Candidates: the first root of F_st - way F_ex."""
    _put(0, column, lanes, threshold - way * load(force, (at(0, block),)), polynomials)
    for k in range(1, order - 1):
        _put(k, column, lanes, -way * load(force, (at(k, block),)), polynomials)
    for k in range(order - 1, order + 1):
        _put(k, column, lanes, spread(0.0), polynomials)


@inlined
def put_branch_end(order, column, lanes, spring, sign, offset, divided, series, polynomials):
    """Candidates: the first root of offset + sign D; divided by t where it is zero at the start."""
    change = deformation(0, spring, series)
    for k in range(order + 1):
        following = spread(0.0)
        if k < order:
            following = deformation(k + 1, spring, series)
        coefficient = sign * select(divided, following, change)
        if k == 0:
            coefficient = coefficient + select(divided, 0.0, offset)
        _put(k, column, lanes, coefficient, polynomials)
        change = following


@inlined
def first_events(order, resolution, n_columns, step, polynomials, sources):
    """First events of the eight chains: their instants (else the step), their sources (else -1)."""
    instant = step
    source = spread(-1)
    for column in range(n_columns):
        candidate = load(sources, (column * LANES,))
        place, found, undecided = first_roots(
            order, resolution, polynomials, column, step, candidate >= 0
        )
        earlier = (found | undecided) & (place < instant)
        first = found & (place == instant) & (source < 0)
        source = select(earlier | first, select(found, candidate, -1), source)
        instant = select(earlier, place, instant)
    return instant, source
