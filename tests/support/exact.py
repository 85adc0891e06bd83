"""Exact dynamics without noise (Sec. III, sigma = 0) with 40 digits and more, from any state.

The motion is a Taylor series between two events, on which every event function is a polynomial that
is positive until its event:

- d v_r for a block slipping in direction d (end of slip: "stick");
- F_st - F_ex and F_st + F_ex for a stuck block ("slip" in direction +1 or -1);
- the distance of a spring's deformation from the end of its branch, |dl| = dl_max ("kink").

The first root of all of them is found by Bernstein subdivision. Deviations follow the linearised
motion and jump at events as docs/exponents.md says.

All numbers are integers, in units of 2^-BITS: a sum is exact, and a product is off by one unit.
Positions are displacements y_i = x_i - 50 i in the laboratory frame; the wall is y_0 = 0. The
parameters are the doubles nearest to those of Sec. III.
"""

from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from math import comb
from operator import mul

import numpy as np
from mpmath import mp, mpf

BITS = 192  # 57 decimal digits
TAIL = 150  # binary digits of the last terms of a series
ORDER = 64
ONE = 1 << BITS


def fixed(number):
    """A number, or the text of one, in units of 2^-BITS."""
    with mp.workprec(2 * BITS):
        return int(mp.nint(mp.ldexp(mpf(number), BITS)))


def real(units):
    """As an mpf."""
    with mp.workprec(2 * BITS):
        return mp.ldexp(mpf(units), -BITS)


LIMIT, COMPRESSION, EXTENSION = fixed(20.0), fixed(0.2), fixed(0.01)
THRESHOLD = fixed(71.4)
KINETIC = THRESHOLD * fixed(0.45) >> BITS


@dataclass
class ExactChain:
    """A chain at one instant, wall first in every list.

    y, v : displacements and velocities. direction : of the slips, 0 while stuck. deviations : if
    any are carried along. events : (time, block from 1, "slip" or "stick") so far.
    """

    belt: int
    y: list
    v: list
    direction: list
    deviations: "Deviations | None" = None
    time: int = 0
    events: list = field(default_factory=list)
    kink: int | None = None  # spring that has just changed its branch

    def __post_init__(self):
        self.branch = [0] + [_branch(after - before) for before, after in pairwise(self.y)]

    @classmethod
    def of(cls, belt_velocity, displacements, relative_velocities=None, directions=None):
        """A chain from numbers or their texts; all blocks are stuck unless told otherwise."""
        belt, n_blocks = fixed(belt_velocity), len(displacements)
        relative = [fixed(w) for w in relative_velocities or [0] * n_blocks]
        return cls(
            belt=belt,
            y=[0] + [fixed(place) for place in displacements],
            v=[0] + [belt + w for w in relative],
            direction=[0] + [int(way) for way in directions or [0] * n_blocks],
        )

    def advance(self, until=None, n_events=None):
        """Go on to a time, or until that many events have happened."""
        while self.time != until and (n_events is None or len(self.events) < n_events):
            step = _Step(self)
            end = ONE if until is None else min(ONE, until - self.time << step.halvings)
            root, event = step.first_event(end)
            step.move(self, root)
            self.kink = None
            if event is not None:
                self._apply(*event, step, root)
        return self

    def flow(self):
        """Rates of change of displacements and velocities, as two lists."""
        pulls = [row[0] for row in _series(self)[1]]
        ways = self.direction
        return self.v, [way and pull - way * KINETIC for pull, way in zip(pulls, ways, strict=True)]

    def _apply(self, what, block, sign, step, root):
        if what == "kink":
            self.branch[block], self.kink = sign, block
            return
        pull = _value(step.force[block], root)
        if what == "stick":
            self.v[block], self.direction[block] = self.belt, 0
            self.events.append((self.time, block, "stick"))
        way = 1 if pull > 0 else -1
        if what == "slip" or abs(pull) >= THRESHOLD:
            self.direction[block] = way
            self.events.append((self.time, block, "slip"))
        after, before = pull - way * KINETIC, pull + way * KINETIC
        if self.deviations is None:
            return
        if what == "slip":
            rate = _value(_derivative(step.force[block]), root) << step.halvings
            change = step.pull_change(block, self.deviations, root)
            self.deviations.v[block] = change * ((after << BITS) // rate) >> BITS
        else:  # a stick, or a reversal
            kept = (after << BITS) // before if self.direction[block] else 0
            self.deviations.v[block] = self.deviations.v[block] * kept >> BITS


class Deviations:
    """Several deviations of a chain: of each block, wall first, an array of their numbers.

    columns : (displacements, velocities) of each deviation, wall first.
    """

    def __init__(self, columns):
        self.y, self.v = (
            list(np.array(rows, dtype=object).T) for rows in zip(*columns, strict=True)
        )

    def columns(self):
        """(displacements, velocities) of each deviation."""
        return list(zip(*(np.transpose(rows).tolist() for rows in (self.y, self.v)), strict=True))


def _branch(deformation):
    return 0 if abs(deformation) <= LIMIT else (1 if deformation > 0 else -1)


class _Step:
    """Series of a chain from now on, in units of the step: 1, halved until its last terms vanish.

    x, force, growth : displacements, F_ex and E = exp(c (dl - s dl_max)) of the springs, with s the
    branch and c = s b; it follows from E' = c dl' E.
    """

    def __init__(self, chain):
        self.chain = chain
        self.x, self.force, self.growth = _series(chain)
        self.halvings = 0
        while any(
            abs(terms[k]) >> self.halvings * k > ONE >> TAIL
            for terms in self.force[1:]
            for k in (ORDER - 3, ORDER - 2)
        ):
            self.halvings += 1
        for rows in (self.x, self.force, self.growth):
            for row in rows:
                row[:] = [c >> self.halvings * k for k, c in enumerate(row)]

    def move(self, chain, root):
        """Put the chain where it is at a share of the step."""
        chain.time += root >> self.halvings
        chain.y = [_value(row, root) for row in self.x]
        chain.v = [_value(_derivative(row), root) << self.halvings for row in self.x]
        for i, way in enumerate(chain.direction[1:], start=1):
            chain.v[i] = chain.v[i] if way else chain.belt
        if chain.deviations is not None:
            self._carry(chain.deviations, root)

    def _carry(self, deviations, root):
        powers = [ONE]
        for _ in range(ORDER):
            powers.append(powers[-1] * root >> BITS)
        rates = [k * power << self.halvings for k, power in enumerate([0, *powers[:-1]])]
        for i, row in enumerate(self._changes(deviations)):
            deviations.y[i], deviations.v[i] = _dot(row, powers) >> BITS, _dot(row, rates) >> BITS

    def _changes(self, deviations):
        """Series of the deviations of the displacements, whose tension is E times theirs."""
        chain, count = self.chain, len(deviations.y)
        x = [
            [place, speed >> self.halvings]
            for place, speed in zip(deviations.y, deviations.v, strict=True)
        ]
        stretch = [[] for _ in x]
        for k in range(ORDER - 1):
            tension = [0] * (count + 1)
            for i in range(1, count):
                stretch[i].append(x[i][k] - x[i - 1][k])
                tension[i] = stretch[i][k]
                if chain.branch[i]:
                    tension[i] = _dot(stretch[i], self.growth[i][k::-1]) >> BITS
            share = (ONE >> 2 * self.halvings) // ((k + 1) * (k + 2))
            for i in range(1, count):
                pull = tension[i + 1] - tension[i]
                x[i].append(chain.direction[i] and pull * share >> BITS)
            x[0].append(0)
        return x

    def pull_change(self, block, deviations, root):
        """dF_ex on a block from the deviations of the displacements."""
        change, y = 0, deviations.y
        for spring, sign in ((block, -1), (block + 1, 1)):
            if spring < len(y):
                slope = _value(self.growth[spring], root)
                change += sign * ((y[spring] - y[spring - 1]) * slope >> BITS)
        return change

    def first_event(self, end):
        """Share of the step at the first event, and the event; `end` and None if none is before."""
        results = [
            (root, event)
            for *event, function in self._event_functions()
            if (root := first_root(function)) <= end
        ]
        return min(results) if results else (end, None)

    def _event_functions(self):
        """(event, block or spring, new direction or branch, coefficients) of all of them."""
        chain, x = self.chain, self.x
        for i in range(1, len(x)):
            way = chain.direction[i]
            if way:
                first, *rest = _derivative(x[i])
                first -= chain.belt >> self.halvings
                yield "stick", i, 0, [way * c for c in (first, *rest)]
            else:
                for sign in (-1, 1):
                    first, *rest = (-sign * c for c in self.force[i])
                    yield "slip", i, sign, [first + THRESHOLD, *rest]
            stretch = [after - before for before, after in zip(x[i - 1], x[i], strict=True)]
            branch = chain.branch[i]
            for end in (branch,) if branch else (-1, 1):
                outward = -1 if branch else 1
                first, *rest = (-outward * end * c for c in stretch)
                at_end = i == chain.kink and end * stretch[0] > 0
                distance = 0 if at_end else first + outward * LIMIT
                yield "kink", i, 0 if branch else end, [distance, *rest]


def _series(chain):
    """Coefficients of displacements (to ORDER), F_ex and E (to ORDER - 2), wall first.

    E of a linear spring is 1: it is the slope of the tension.
    """
    count = len(chain.y)
    x = [[place, velocity] for place, velocity in zip(chain.y, chain.v, strict=True)]
    rate = [s * (COMPRESSION if s < 0 else EXTENSION) for s in chain.branch]
    force = [[0] * (ORDER - 1)] + [[] for _ in range(1, count)]
    growth = [[ONE] + [0] * (ORDER - 2) if not c else [] for c in rate]
    weighted = [[] for _ in rate]  # c k dl_k
    for k in range(ORDER - 1):
        tension = [0] * (count + 1)
        for i in range(1, count):
            stretch = x[i][k] - x[i - 1][k]
            if not rate[i]:
                tension[i] = stretch
            elif k == 0:
                beyond = stretch - chain.branch[i] * LIMIT
                growth[i].append(_exponential(rate[i] * beyond >> BITS))
                tension[i] = chain.branch[i] * LIMIT + ((growth[i][0] - ONE << BITS) // rate[i])
            else:
                weighted[i].append(k * rate[i] * stretch >> BITS)
                growth[i].append((_dot(weighted[i], growth[i][::-1]) >> BITS) // k)
                tension[i] = (growth[i][k] << BITS) // rate[i]
        for i in range(1, count):
            pull = tension[i + 1] - tension[i]
            force[i].append(pull)
            friction = chain.direction[i] * KINETIC if k == 0 else 0
            x[i].append(chain.direction[i] and (pull - friction) // ((k + 1) * (k + 2)))
        x[0].append(0)
    return x, force, growth


def _dot(one, other):
    return sum(map(mul, one, other))


def _exponential(exponent):
    with mp.workprec(2 * BITS):
        return fixed(mp.exp(real(exponent)))


def _value(coefficients, at):
    value = 0
    for c in reversed(coefficients):
        value = (value * at >> BITS) + c
    return value


def _derivative(coefficients):
    return [k * c for k, c in enumerate(coefficients)][1:]


def first_root(coefficients):
    """First root in [0, 1], apart from one at 0 from which the polynomial rises; 2 if none.

    The signs of the Bernstein coefficients on an interval change as often as there are roots, or
    more often by an even number: no change excludes a root, one proves one, more ask for halving.
    """
    first = next((k for k, c in enumerate(coefficients) if c), len(coefficients))
    coefficients = coefficients[first:]
    if len(coefficients) < 2:
        return 2 * ONE
    if min(coefficients[0], sum(coefficients[:2])) > sum(map(abs, coefficients[2:])):
        return 2 * ONE
    if coefficients[0] < 0:
        return 0
    n = len(coefficients) - 1
    bernstein = [c // comb(n, k) for k, c in enumerate(coefficients)]  # forward differences
    for k in range(n, 0, -1):
        bernstein[k - 1 :] = accumulate(bernstein[k - 1 :])
    pieces = [(0, ONE, bernstein)]
    while pieces:
        left, width, bernstein = pieces.pop()
        changes = sum((a > 0) != (b > 0) for a, b in pairwise(bernstein))
        if changes == 1 or (changes and width < 16):
            return _root_in(coefficients, left, left + width)
        if changes:
            first, second = [], []
            while bernstein:
                first.append(bernstein[0])
                second.append(bernstein[-1])
                bernstein = [(a + b) >> 1 for a, b in pairwise(bernstein)]
            width >>= 1
            pieces += [(left + width, width, second[::-1]), (left, width, first)]
    return 2 * ONE


def _root_in(coefficients, low, high):
    """The only root between two places: Newton's method, by halves where it leaves the bracket."""
    slopes = _derivative(coefficients)
    place = low + high >> 1
    while high - low > 4:
        value, slope = _value(coefficients, place), _value(slopes, place)
        low, high = (place, high) if value > 0 else (low, place)
        following = place - (value << BITS) // slope if slope else low
        if not low < following < high:
            following = low + high >> 1
        if abs(following - place) <= 4:
            return following
        place = following
    return high
