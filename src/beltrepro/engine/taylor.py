"""Taylor series of the motion of eight chains between two events.

While no block changes between stick and slip and no spring crosses the end of its linear branch,
Eq. 1 is an analytic ODE. In every spring the tension is T = D (linear branch) or
T = const + G with G' = c D' G (exponential branch of signed rate c), D the deformation, so the
coefficients follow from each other: k G_k = sum_{j=1..k} (c j D_j) G_{k-j}, and
(k+1)(k+2) X_{k+2} = F_k + friction_k for a slipping block (Griewank and Walther, Evaluating
Derivatives, SIAM 2008, ch. 13).

Positions are those in the frame of the belt, from the rest positions at the start of the step; the
wall is column 0 of the series, block i (from 0) is column i+1. So X_1 is the relative velocity of a
block, zero if it is stuck, and minus the belt velocity for the wall.
"""

from beltrepro.engine.law import (
    COMPRESSION_RATE,
    COMPRESSION_RATE_2,
    COMPRESSION_SOFTNESS,
    EXTENSION_RATE,
    EXTENSION_RATE_2,
    EXTENSION_SOFTNESS,
    LINEAR_LIMIT,
)
from beltrepro.engine.simd import (
    LANES,
    fma,
    load,
    mask_bits,
    maximum,
    minimum,
    select,
    spread,
    store,
)
from beltrepro.engine.vector import exp2, inlined

ORDER = 16  # of the positions
FORCE_ORDER = ORDER - 2
LEVELS = ORDER + 1


@inlined
def at(level, column):
    """Index of the first of eight chains in an array of series.

    Flat arrays with a constant distance between levels: their addresses cost nothing.
    """
    return (column * LEVELS + level) * LANES


@inlined
def start_springs(constants, regime, lane, series, rates, growth, force, wall_pull):
    """Level 0: tensions and external forces from the positions; rates c of the branches.

    regime : (N, W) -1, 0, 1 compressed, linear, stretched; lane : first of the eight chains.
    series : of N+1 columns, positions X_k, of which X_0 and X_1 are given.
    rates : (8 N,), growth : N columns G_k, force : N columns F_k, wall_pull : one column, the
    tension of the first spring, are written.
    """
    n_blocks = regime.shape[0]
    limit = constants[LINEAR_LIMIT]
    before = load(series, (at(0, 0),))
    tension_before = spread(0.0)
    for spring in range(n_blocks):
        branch = load(regime, (spring, lane))
        here = load(series, (at(0, spring + 1),))
        deformation = here - before
        before = here
        stretched = branch > 0.0
        linear = branch == 0.0
        rate = select(stretched, constants[EXTENSION_RATE], spread(-constants[COMPRESSION_RATE]))
        rate_2 = select(
            stretched, constants[EXTENSION_RATE_2], spread(-constants[COMPRESSION_RATE_2])
        )
        softness = select(
            stretched, constants[EXTENSION_SOFTNESS], spread(-constants[COMPRESSION_SOFTNESS])
        )
        excess = select(linear, 0.0, fma(branch, -limit, deformation))
        exponential = exp2(excess, rate_2)
        tension = select(linear, deformation, fma(branch, limit, (exponential - 1.0) * softness))
        store(rates, (spring * LANES,), select(linear, 0.0, rate))
        store(growth, (at(0, spring),), select(linear, 0.0, exponential * softness))
        if spring == 0:
            store(wall_pull, (at(0, 0),), tension)
        else:
            store(force, (at(0, spring - 1),), tension - tension_before)
        tension_before = tension
    store(force, (at(0, n_blocks - 1),), -tension_before)


@inlined
def extend_springs(k, series, rates, stretching, growth, force, wall_pull):
    """Level k >= 1: tensions and external forces from X_k.

    stretching : N columns c j D_j, written at level k.
    """
    n_blocks = rates.shape[0] // LANES
    before = load(series, (at(k, 0),))
    tension_before = spread(0.0)
    for spring in range(n_blocks):
        here = load(series, (at(k, spring + 1),))
        deformation = here - before
        before = here
        rate = load(rates, (spring * LANES,))
        curved = rate != 0.0
        tension = deformation
        if mask_bits(curved):
            newest = rate * deformation * float(k)
            store(stretching, (at(k, spring),), newest)
            even = newest * load(growth, (at(0, spring),))
            odd = spread(0.0)
            for j in range(1, k - 1, 2):
                odd = fma(
                    load(stretching, (at(j, spring),)), load(growth, (at(k - j, spring),)), odd
                )
                even = fma(
                    load(stretching, (at(j + 1, spring),)),
                    load(growth, (at(k - j - 1, spring),)),
                    even,
                )
            if k & 1 == 0:
                odd = fma(
                    load(stretching, (at(k - 1, spring),)), load(growth, (at(1, spring),)), odd
                )
            coefficient = (even + odd) * (1.0 / k)
            store(growth, (at(k, spring),), coefficient)
            tension = select(curved, coefficient, deformation)
        if spring == 0:
            store(wall_pull, (at(k, 0),), tension)
        else:
            store(force, (at(k, spring - 1),), tension - tension_before)
        tension_before = tension
    store(force, (at(k, n_blocks - 1),), -tension_before)


@inlined
def evaluate(series, block, time):
    """Position and relative velocity of a block at `time` (float64x8) after the start."""
    position = load(series, (at(ORDER, block + 1),))
    velocity = spread(0.0)
    for k in range(ORDER - 1, -1, -1):
        velocity = fma(velocity, time, position)
        position = fma(position, time, load(series, (at(k, block + 1),)))
    return position, velocity


@inlined
def deformation(k, spring, series):
    """Coefficient k of the deformation of a spring."""
    return load(series, (at(k, spring + 1),)) - load(series, (at(k, spring),))


@inlined
def bounds(c0, c1, c2, rest, step):
    """Least and greatest value on [0, step] of a polynomial c0 + c1 t + c2 t^2 + ...

    rest : bound of the terms from the third order on; the parabola before them is taken as it is.
    """
    end = fma(step, fma(step, c2, c1), c0)
    vertex = -0.5 * c1 / c2
    inside = (vertex > 0.0) & (vertex < step)
    extreme = select(inside, fma(0.5 * c1, vertex, c0), c0)
    return (
        minimum(minimum(c0, end), extreme) - rest,
        maximum(maximum(c0, end), extreme) + rest,
    )
