"""The first root of a polynomial on the unit interval, for eight polynomials at once."""

from beltrepro.engine.simd import (
    LANES,
    fma,
    load,
    mask_bits,
    maximum,
    select,
    spread,
    square_root,
    store,
)
from beltrepro.engine.taylor import LEVELS, ORDER, at
from beltrepro.engine.vector import inlined

NO_ROOT = 2.0
UNDECIDED = 3.0
_RESOLUTION = 1e-15
_MAX_ITERATIONS = 200


@inlined
def first_roots(polynomials, slot, roots):
    """Write the first root in [0, 1] of the eight polynomials from `slot` on, or NO_ROOT.

    UNDECIDED + t stands for: no root up to t, but not all of the interval could be searched.

    polynomials : candidate `slot` is lane slot % 8 of column slot // 8, coefficients in ascending
    order, positive at 0; roots : (S,).

    With q'' >= -M on the interval, q(t+s) >= q(t) + q'(t) s - M s^2/2, so the root of that parabola
    never lies beyond the first root of q: stepping from root to root approaches the first root from
    the left, quadratically where it is simple, and cannot pass a pair of roots that a test of signs
    at the ends would miss. A polynomial that is not positive at 0 has its root there.
    """
    column = slot // LANES
    curvature = spread(0.0)
    for k in range(2, LEVELS):
        curvature = fma(abs(load(polynomials, (at(k, column),))), k * (k - 1.0), curvature)
    position = spread(0.0)
    root = spread(NO_ROOT)
    searching = position == 0.0
    for _ in range(_MAX_ITERATIONS):
        # even and odd powers apart: chains of half the length
        square = position * position
        even, odd = load(polynomials, (at(ORDER, column),)), spread(0.0)
        even_slope, odd_slope = spread(0.0), spread(0.0)
        for k in range(ORDER - 2, -1, -2):
            even_slope = fma(even_slope, square, even)
            odd_slope = fma(odd_slope, square, odd)
            even = fma(even, square, load(polynomials, (at(k, column),)))
            odd = fma(odd, square, load(polynomials, (at(k + 1, column),)))
        value = fma(odd, position, even)
        slope = fma(2.0 * position, fma(odd_slope, position, even_slope), odd)
        discriminant = square_root(fma(slope, slope, 2.0 * curvature * maximum(value, 0.0)))
        downward = slope < 0.0
        # two forms of the same root, each without cancellation on its side
        step = select(downward, 2.0 * value, slope + discriminant) / select(
            downward, discriminant - slope, curvature
        )
        found = searching & ((value <= 0.0) | (step < _RESOLUTION))
        root = select(found, position, root)
        position = position + step
        searching = searching & ~found & (position < 1.0)
        if mask_bits(searching) == 0:
            break
    else:
        root = select(searching, UNDECIDED + position, root)
    store(roots, (slot,), root)
