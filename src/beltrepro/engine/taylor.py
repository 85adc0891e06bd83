"""Taylor series of the motion of eight chains between two events.

In every spring the tension is T = D (linear branch) or T = const + G with G' = c D' G (exponential
branch of signed rate c), D the deformation. So the coefficients follow from each other
(docs/integrators.md): k G_k = sum_{j=1..k} (c j D_j) G_{k-j}, and for a slipping block
(k+1)(k+2) X_{k+2} = F_k + friction_k.
Friction that depends on the velocity has the series of K w + eta s at the
speed s over the belt, w = 1 / q, q = 1 + s / v_w: w_k = -w_0 sum_{j=1..k} q_j w_{k-j}.

Positions are those in the frame of the belt, from the rest positions at the start of the step; the
wall is column 0 of the series, block i (from 0) is column i+1. So X_1 is the relative velocity of a
block, zero if it is stuck, and minus the belt velocity for the wall.
"""

from typing import NamedTuple

import numpy as np

from beltrepro.engine.law import curved_branch, stiffness
from beltrepro.engine.simd import LANES, fma, load, select, spread, store
from beltrepro.engine.vector import inlined, maximum, minimum, zeros

# Order of the series of the positions, odd: levels come in pairs. Higher ones make steps longer,
# but most steps end at an event before that; with noise steps are short anyway.
ORDER = 19
NOISY_ORDER = 13

# Functions take the order of the positions as an argument, a constant of the kernel that calls
# them: the compiler lays out their loops.
LEVELS = ORDER + 1
WALL = 0  # column of the positions


class Series(NamedTuple):
    """Taylor series of eight chains about the start of a step: columns of LEVELS vectors, see `at`.

    Every array but `rate` is flat, with one column for each spring or block.
    """

    position: np.ndarray  # N+1 columns, X_k: the wall and the blocks
    stretching: np.ndarray  # N columns, c k D_k
    growth: np.ndarray  # N columns, G_k
    force: np.ndarray  # N columns, F_k: external forces
    wall_pull: np.ndarray  # one column: tension of the first spring
    weakening: np.ndarray  # N columns, w_k, or none: by how much friction has weakened
    rate: np.ndarray  # (8 N,) signed rates c of the branches, 0 on the linear one


def new_series(n_blocks: int, varied: bool = False) -> Series:
    """Room for the series of eight chains of N blocks."""
    columns = (n_blocks + 1, n_blocks, n_blocks, n_blocks, 1, n_blocks * varied)
    # in one piece, so that no two of them compete for places in the fastest memory
    ends = np.cumsum([count * LEVELS * LANES for count in columns])
    *flat, rate = np.split(zeros(int(ends[-1]) + n_blocks * LANES), ends)
    return Series(*flat, rate=rate)


@inlined
def at(level, column):
    """Index of the first of eight chains in an array of series.

    Flat arrays with a constant distance between levels: their addresses cost nothing.
    """
    return (column * LEVELS + level) * LANES


@inlined
def force_order(order):
    """Order of the forces that belong to positions of an order."""
    return order - 2


@inlined
def drive(k, block, slipping, varied, series):
    """Coefficient k of F_ex; where blocks differ, of the acceleration of those that slip."""
    force = load(series.force, (at(k, block),))
    if varied is None:
        return force
    weight = (k + 1.0) * (k + 2.0)
    return select(slipping, weight * load(series.position, (at(k + 2, block + 1),)), force)


@inlined
def friction_term(k, block, heading, varied, series):
    """Coefficient k >= 1 of the force that brakes a block, along its slip; writes w_k."""
    total = spread(0.0)
    for j in range(1, k + 1):
        speed = heading * (j + 1.0) * load(series.position, (at(j + 1, block + 1),))
        total = fma(speed, load(series.weakening, (at(k - j, block),)), total)
    first = load(series.weakening, (at(0, block),))
    weakened = -first * total * varied.weakening
    store(series.weakening, (at(k, block),), weakened)
    speed = heading * (k + 1.0) * load(series.position, (at(k + 1, block + 1),))
    return varied.kinetic_friction[block] * weakened + varied.viscosity * speed


@inlined
def _push_varied(k, block, pull, heading, varied, series):
    """X_{k+2} of a block that has a mass, braked by friction that depends on v_r."""
    net = pull - heading * friction_term(k, block, heading, varied, series)
    weight = varied.inverse_mass[block] / ((k + 1.0) * (k + 2.0))
    store(series.position, (at(k + 2, block + 1),), select(heading != 0.0, net * weight, 0.0))


@inlined
def start_springs(law, varied, regime, lane, series):
    """Levels 0 and 1: tensions and external forces from X_0 and X_1; rates c of the branches.

    regime : (N, W) -1, 0, 1 compressed, linear, stretched; lane : first of the eight chains.
    All of the series but its positions is written.
    """
    n_blocks = regime.shape[0]
    limit = law.linear_limit
    place_before = load(series.position, (at(0, 0),))
    speed_before = load(series.position, (at(1, 0),))
    tension_before = spread(0.0)
    growth_before = spread(0.0)
    for spring in range(n_blocks):
        branch = load(regime, (spring, lane))
        place = load(series.position, (at(0, spring + 1),))
        speed = load(series.position, (at(1, spring + 1),))
        deformation = place - place_before
        change = speed - speed_before
        place_before = place
        speed_before = speed
        # by its branch, not its deformation: at a change rounding leaves that on either side
        linear = branch == 0.0
        excess = select(linear, 0.0, fma(branch, -limit, deformation))
        slope, rate, softness = curved_branch(excess, branch < 0.0, law)
        tension = select(linear, deformation, fma(branch, limit, (slope - 1.0) * softness))
        rate = select(linear, 0.0, rate)
        start = select(linear, 0.0, slope * softness)
        tension = tension * stiffness(varied, spring)
        start = start * stiffness(varied, spring)
        newest = rate * change
        change = change * stiffness(varied, spring)
        tension_growth = select(linear, change, newest * start)
        store(series.rate, (spring * LANES,), rate)
        store(series.stretching, (at(1, spring),), newest)
        store(series.growth, (at(0, spring),), start)
        store(series.growth, (at(1, spring),), tension_growth)
        store_pull(0, spring, tension, tension_before, series)
        store_pull(1, spring, tension_growth, growth_before, series)
        tension_before = tension
        growth_before = tension_growth
    store(series.force, (at(0, n_blocks - 1),), -tension_before)
    store(series.force, (at(1, n_blocks - 1),), -growth_before)


@inlined
def store_pull(k, spring, pull, pull_before, series):
    """Level k of the pull of a spring: of the wall's, or of the force on the block before it."""
    if spring == 0:
        store(series.wall_pull, (at(k, 0),), pull)
    else:
        store(series.force, (at(k, spring - 1),), pull - pull_before)


@inlined
def push_position(k, column, slipping, pull, series):
    """X_{k+2} of a slipping block of mass 1, from level k of the force on it."""
    weight = 1.0 / ((k + 1.0) * (k + 2.0))
    store(series.position, (at(k + 2, column),), select(slipping, pull * weight, 0.0))


@inlined
def extend_pair(k, varied, direction, lane, series):
    """Levels k and k+1 of the forces, so k+2 and k+3 of the positions; k is even.

    Two levels at once, since the positions of both are known: each G_m that is read serves both
    sums, and only the last term, c D_1 G_k, waits for the first.
    """
    n_blocks = series.rate.shape[0] // LANES
    place_before, next_before = spread(0.0), spread(0.0)
    tension_before, rise_before = spread(0.0), spread(0.0)
    for spring in range(n_blocks + 1):
        tension, rise = spread(0.0), spread(0.0)
        if spring < n_blocks:
            place = load(series.position, (at(k, spring + 1),))
            following = load(series.position, (at(k + 1, spring + 1),))
            tension, rise = place - place_before, following - next_before
            place_before, next_before = place, following
            rate = load(series.rate, (spring * LANES,))
            curved = rate != 0.0
            newest = rate * float(k) * tension
            newest_next = rate * (k + 1.0) * rise
            store(series.stretching, (at(k, spring),), newest)
            store(series.stretching, (at(k + 1, spring),), newest_next)
            # even and odd terms apart: chains of half the length
            start = load(series.growth, (at(0, spring),))
            even, even_next = newest * start, newest_next * start
            odd, odd_next = spread(0.0), spread(0.0)
            for m in range(2, k, 2):
                grown = load(series.growth, (at(m, spring),))
                even = fma(load(series.stretching, (at(k - m, spring),)), grown, even)
                even_next = fma(load(series.stretching, (at(k + 1 - m, spring),)), grown, even_next)
            for m in range(1, k, 2):
                grown = load(series.growth, (at(m, spring),))
                odd = fma(load(series.stretching, (at(k - m, spring),)), grown, odd)
                odd_next = fma(load(series.stretching, (at(k + 1 - m, spring),)), grown, odd_next)
            grown = (even + odd) * (1.0 / k)
            grown_next = fma(load(series.stretching, (at(1, spring),)), grown, even_next + odd_next)
            grown_next = grown_next * (1.0 / (k + 1.0))
            tension, rise = tension * stiffness(varied, spring), rise * stiffness(varied, spring)
            store(series.growth, (at(k, spring),), grown)
            store(series.growth, (at(k + 1, spring),), grown_next)
            tension = select(curved, grown, tension)
            rise = select(curved, grown_next, rise)
        store_pull(k, spring, tension, tension_before, series)
        store_pull(k + 1, spring, rise, rise_before, series)
        if spring > 0:
            heading = load(direction, (spring - 1, lane))
            pull, pull_rise = tension - tension_before, rise - rise_before
            if varied is not None:
                _push_varied(k, spring - 1, pull, heading, varied, series)
                _push_varied(k + 1, spring - 1, pull_rise, heading, varied, series)
            else:
                push_position(k, spring, heading != 0.0, pull, series)
                push_position(k + 1, spring, heading != 0.0, pull_rise, series)
        tension_before, rise_before = tension, rise


@inlined
def extend_series(order, varied, direction, lane, series):
    """All levels from 2 on of the forces, from 4 to `order` of the positions.

    order : one of the two; direction : (N, W), zero for stuck blocks; see `start_springs`.
    """
    # one call for each pair of levels: a constant level lets the compiler lay out all its terms
    extend_pair(2, varied, direction, lane, series)
    extend_pair(4, varied, direction, lane, series)
    extend_pair(6, varied, direction, lane, series)
    extend_pair(8, varied, direction, lane, series)
    extend_pair(10, varied, direction, lane, series)
    if order > NOISY_ORDER:
        extend_pair(12, varied, direction, lane, series)
        extend_pair(14, varied, direction, lane, series)
        extend_pair(16, varied, direction, lane, series)


def _evaluating(read):
    """Value and slope of polynomials of odd order at `time` (float64x8): even and odd powers apart.

    read : of coefficients at an index; those of one power more lie LANES further on.
    """

    def _evaluate(order, coefficients, first, time):
        square = time * time
        even = read(coefficients, (first + (order - 1) * LANES,))
        odd = read(coefficients, (first + order * LANES,))
        even_slope, odd_slope = spread(0.0), spread(0.0)
        for k in range(order - 3, -1, -2):
            even_slope = fma(even_slope, square, even)
            odd_slope = fma(odd_slope, square, odd)
            even = fma(even, square, read(coefficients, (first + k * LANES,)))
            odd = fma(odd, square, read(coefficients, (first + (k + 1) * LANES,)))
        slope = fma(2.0 * time, fma(odd_slope, time, even_slope), odd)
        return fma(odd, time, even), slope

    return inlined(_evaluate)


@inlined
def _read_one(coefficients, indices):
    return spread(coefficients[indices[0]])


_evaluate_all, _evaluate_lane = _evaluating(load), _evaluating(_read_one)


@inlined
def polynomial(order, coefficients, column, time):
    """Value and slope at `time` (float64x8) of the polynomials in a column of coefficients."""
    return _evaluate_all(order, coefficients, at(0, column), time)


@inlined
def evaluate_one(order, series, block, i, times):
    """Position and relative velocity of a block of the chain in lane i at eight times."""
    return _evaluate_lane(order, series.position, at(0, block + 1) + i, times)


@inlined
def value_and_slope(order, coefficients, column, i, time):
    """Value and slope of the polynomial of the chain in lane i at one time (float64)."""
    first = at(0, column) + i
    value = coefficients[first + order * LANES]
    slope = 0.0
    for k in range(order - 1, -1, -1):
        slope = fma(slope, time, value)
        value = fma(value, time, coefficients[first + k * LANES])
    return value, slope


@inlined
def integral(order, coefficients, column, time):
    """Integral from the start to `time` (float64x8) of the series in a column."""
    total = spread(0.0)
    for k in range(order, -1, -1):
        total = fma(total, time, load(coefficients, (at(k, column),)) * (1.0 / (k + 1.0)))
    return total * time


@inlined
def mean_change(order, series, block, time):
    """Mean from the start to `time` of the change of position of a block."""
    square = time * time
    even = load(series.position, (at(order - 1, block + 1),)) * (1.0 / order)
    odd = load(series.position, (at(order, block + 1),)) * (1.0 / (order + 1.0))
    for k in range(order - 2, 2, -2):
        odd = fma(odd, square, load(series.position, (at(k, block + 1),)) * (1.0 / (k + 1.0)))
        even = fma(even, square, load(series.position, (at(k - 1, block + 1),)) * (1.0 / k))
    odd = fma(odd, square, load(series.position, (at(1, block + 1),)) * 0.5)
    return fma(even, time, odd) * time


@inlined
def deformation(k, spring, series):
    """Coefficient k of the deformation of a spring."""
    return load(series.position, (at(k, spring + 1),)) - load(series.position, (at(k, spring),))


@inlined
def bounds(c0, c1, c2, rest, step):
    """Least and greatest value on [0, step] of a polynomial c0 + c1 t + c2 t^2 + ...

    rest : bound of the terms from the third order on. The parabola before them leaves its chord by
    at most |c2| step^2 / 4, and only if it turns on the way does it leave the values at the ends.
    """
    end = fma(step, fma(step, c2, c1), c0)
    turns = c1 * fma(2.0 * step, c2, c1) < 0.0
    sag = select(turns, 0.25 * c2 * (step * step), 0.0)
    return (
        minimum(c0, end) - maximum(sag, 0.0) - rest,
        maximum(c0, end) - minimum(sag, 0.0) + rest,
    )
