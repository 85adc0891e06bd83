"""The first root of a polynomial on an interval [0, length], for eight polynomials at once."""

from beltrepro.engine.simd import fma, load, mask_bits, maximum, select, spread, square_root
from beltrepro.engine.taylor import at, polynomial
from beltrepro.engine.vector import inlined

_MAX_ITERATIONS = 200


@inlined
def _curvature_bounds(order, polynomials, column, length):
    """M, to which a positive term of q'' adds nothing, and a bound of |q''|."""
    square = length * length
    curvature, curvature_odd, greatest, greatest_odd = (
        spread(0.0),
        spread(0.0),
        spread(0.0),
        spread(0.0),
    )
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

    Returns place (float64x8), found, undecided (mask8): a root at `place`; or none up to `place`,
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
        step = select(downward, 2.0 * value, slope + discriminant) / select(
            downward, discriminant - slope, curvature
        )
        reached = value <= 0.0
        following = select(reached, position, position + step)
        # the root lies within about M step^2 / |slope| beyond the next place
        close = greatest * (step * step) <= accuracy * discriminant
        found = searching & (reached | close) & (following <= length)
        place = select(searching, following, place)
        position = following
        located = located | found
        searching = searching & ~found & (position < length)
        if mask_bits(searching) == 0:
            break
        value, slope = polynomial(order, polynomials, column, position)
    return place, located, searching
