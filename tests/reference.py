"""Exact dynamics without noise (Sec. III, sigma = 0), in two slow ways.

`exact_events` follows a chain with 40 digits and finds the first root of every event function by
Bernstein subdivision. `event_reference` does it in double precision, with NumPy, and brackets the
roots between the critical points. In both, the motion is a Taylor series between two events, on
which every event function is a polynomial that is positive until its event:

- d v_r for a block slipping in direction d (end of slip: "stick");
- F_st - F_ex and F_st + F_ex for a stuck block ("slip" in direction +1 or -1);
- the distance of a spring's deformation from the end of its branch, |dl| = dl_max ("kink").

Positions are displacements y_i = x_i - 50 i in the laboratory frame; the wall is y_0 = 0. The
parameters are the doubles nearest to those of Sec. III. `python tests/reference.py` writes
tests/data/reference_events.json anew.
"""

import json
from itertools import pairwise
from math import comb, copysign, inf, nan
from pathlib import Path

import numpy as np
from mpmath import mp, mpf

LIMIT, COMPRESSION, EXTENSION = 20.0, 0.2, 0.01
THRESHOLD, RATIO = 71.4, 0.45

DATA = Path(__file__).parent / "data" / "reference_events.json"
CASES = (
    {"n_blocks": 5, "belt_velocity": 20.0, "displacement": [0.0] * 5, "n_events": 60},
    {"n_blocks": 10, "belt_velocity": 30.0, "displacement": [0.0] * 10, "n_events": 60},
    {"n_blocks": 1, "belt_velocity": 1.0, "displacement": [0.0], "n_events": 6},
    {"n_blocks": 5, "belt_velocity": 1.0, "displacement": [0.0] * 5, "n_events": 60},
    {"n_blocks": 3, "belt_velocity": 8.0, "displacement": [0.3, -0.7, 1.1], "n_events": 60},
)


def _value(coefficients, at):
    value = 0
    for c in reversed(coefficients):
        value = value * at + c
    return value


def _derivative(coefficients):
    return [k * c for k, c in enumerate(coefficients)][1:]


# --- 40 digits ---


def exact_events(
    n_blocks, belt_velocity, displacement, n_events, *, digits=40, order=30, longest=0.1
):
    """First events of a chain whose blocks are all stuck at t = 0, in arbitrary precision.

    displacement : (N,) displacements at t = 0.
    digits, order, longest : of the numbers, of the series, step (100 times longer in full stick).

    Returns
    -------
    events : list of (time as mpf, block from 1, "slip" or "stick").
    y, v : displacements and velocities of the blocks at the last event, lists of mpf.
    """
    with mp.workdps(digits):
        belt, threshold, time = mpf(belt_velocity), mpf(THRESHOLD), mpf(0)
        y = [mpf(0)] + [mpf(start) for start in displacement]
        v = [mpf(0)] + [belt] * n_blocks
        direction = [0] * (n_blocks + 1)
        branch = [0] + [_branch(after - before) for before, after in pairwise(y)]
        events, kink = [], None
        while len(events) < n_events:
            x, force = _series(y, v, direction, branch, order)
            step = mpf(longest) * (1 if any(direction) else 100)
            last = max(abs(c) for f in force for c in f[-2:])
            while last * step ** (order - 3) > mpf(10) ** -digits:
                step /= 2
            functions = _event_functions(x, force, direction, branch, belt, threshold, kink)
            roots = [
                (_first_root([c * step**k for k, c in enumerate(function)]), *event)
                for *event, function in functions
            ]
            root, what, block, sign = min(roots)
            elapsed = min(root, 1) * step
            time += elapsed
            y = [_value(c, elapsed) for c in x]
            v = [_value(_derivative(c), elapsed) for c in x]
            kink = block if root <= 1 and what == "kink" else None
            if root > 1:
                continue
            if what == "kink":
                branch[block] = sign
            elif what == "slip":
                direction[block] = sign
                events.append((time, block, "slip"))
            else:
                pull = _value(force[block], elapsed)
                v[block], direction[block] = belt, 0
                events.append((time, block, "stick"))
                if abs(pull) >= threshold:
                    direction[block] = int(mp.sign(pull))
                    events.append((time, block, "slip"))
        return events[:n_events], y[1:], v[1:]


def _branch(deformation):
    return 0 if abs(deformation) <= LIMIT else int(mp.sign(deformation))


def _series(y, v, direction, branch, order):
    """Coefficients of the displacements (to `order`) and of F_ex (to order - 2), wall first.

    E = exp(c (dl - s dl_max)), with s the branch and c = s b, follows from E' = c dl' E.
    """
    x = [[place, velocity] for place, velocity in zip(y, v, strict=True)]
    force = [[mpf(0)] * (order - 1)] + [[] for _ in y[1:]]
    rate = [s * mpf(COMPRESSION if s < 0 else EXTENSION) for s in branch]
    growth, weighted = [[] for _ in y], [[] for _ in y]  # E_k and c k dl_k
    for k in range(order - 1):
        tension = [mpf(0)] * (len(y) + 1)
        for i in range(1, len(y)):
            stretch = x[i][k] - x[i - 1][k]
            if branch[i] == 0:
                tension[i] = stretch
                continue
            if k == 0:
                growth[i].append(mp.exp(rate[i] * (stretch - branch[i] * LIMIT)))
                tension[i] = branch[i] * LIMIT + (growth[i][0] - 1) / rate[i]
            else:
                weighted[i].append(rate[i] * k * stretch)
                growth[i].append(mp.fdot(weighted[i], growth[i][::-1]) / k)
                tension[i] = growth[i][k] / rate[i]
        for i, heading in enumerate(direction[1:], start=1):
            force[i].append(tension[i + 1] - tension[i])
            friction = heading * mpf(RATIO) * mpf(THRESHOLD) if k == 0 else 0
            x[i].append((force[i][k] - friction) / ((k + 1) * (k + 2)) if heading else mpf(0))
        x[0].append(mpf(0))
    return x, force


def _event_functions(x, force, direction, branch, belt, threshold, kink):
    """(event, block or spring, new direction or branch, coefficients) of all event functions."""
    for i in range(1, len(x)):
        if direction[i]:
            first, *rest = _derivative(x[i])
            yield "stick", i, 0, [direction[i] * c for c in (first - belt, *rest)]
        else:
            for sign in (-1, 1):
                first, *rest = (-sign * c for c in force[i])
                yield "slip", i, sign, [first + threshold, *rest]
        stretch = [after - before for before, after in zip(x[i - 1], x[i], strict=True)]
        for end in (-1, 1) if branch[i] == 0 else (branch[i],):
            outward = 1 if branch[i] == 0 else -1
            first, *rest = (-outward * end * c for c in stretch)
            at_end = i == kink and end * stretch[0] > 0
            distance = mpf(0) if at_end else first + outward * LIMIT
            yield "kink", i, end if branch[i] == 0 else 0, [distance, *rest]


def _first_root(coefficients):
    """First root in [0, 1], apart from one at 0 from which the polynomial rises; 2 if none.

    The signs of the Bernstein coefficients on an interval change as often as there are roots, or
    more often by an even number: no change excludes a root, one proves one, more ask for halving.
    """
    while coefficients and coefficients[0] == 0:
        coefficients = coefficients[1:]
    if not coefficients or coefficients[0] > sum(map(abs, coefficients[1:])):
        return 2
    if coefficients[0] < 0:
        return mpf(0)
    n = len(coefficients) - 1
    bernstein = [c / comb(n, k) for k, c in enumerate(coefficients)]  # forward differences
    for k in range(n, 0, -1):
        for j in range(k, n + 1):
            bernstein[j] += bernstein[j - 1]
    pieces = [(mpf(0), mpf(1), bernstein)]
    while pieces:
        left, width, bernstein = pieces.pop()
        changes = sum((a > 0) != (b > 0) for a, b in pairwise(bernstein))
        if changes == 1 or (changes and width < 10 * mp.eps):
            while width > mp.eps:
                width /= 2
                left += width if _value(coefficients, left + width) > 0 else 0
            return left + width
        if changes:
            first, second = [], []
            while bernstein:
                first.append(bernstein[0])
                second.append(bernstein[-1])
                bernstein = [(a + b) / 2 for a, b in pairwise(bernstein)]
            pieces += [(left + width / 2, width / 2, second[::-1]), (left, width / 2, first)]
    return 2


# --- double precision ---


def event_reference(n_blocks, belt_velocity, displacement, duration, *, longest=0.05, order=20):
    """Events up to `duration` of a chain whose blocks are all stuck at t = 0, in double precision.

    displacement : (N,) displacements at t = 0.
    longest, order : longest step (100 times longer while all are stuck), order of the series.

    Returns
    -------
    events : list of (time, block from 1, "slip" or "stick").
    contacts : (distance, time, block, rate) for every event, and one more for the time after them.
        The first three: the least local minimum that a function of stick or slip has had since the
        event before without becoming zero; (inf, nan, 0) if none was below 1. `rate`: |df/dt| of
        the event's own function at the event (nan without one). Where the distance or the rate is
        tiny, another rounding could gain or lose an event.
    """
    y = np.concatenate([[0.0], displacement])
    v = np.concatenate([[0.0], np.full(n_blocks, float(belt_velocity))])
    direction = np.zeros(n_blocks)
    branch = np.where(np.abs(np.diff(y)) > LIMIT, np.sign(np.diff(y)), 0.0)
    time, kink, none = 0.0, None, (inf, nan, 0)
    events, contacts, nearest = [], [], none
    while time < duration:
        x, force = _series64(y, v, direction, branch, order)
        step = min(longest * (1 if direction.any() else 100), duration - time)
        while np.abs(force[-2:]).max() * step ** (order - 3) > 1e-15:
            step /= 2
        rows = _event_rows64(x, force, direction, branch, belt_velocity)
        rows *= step ** np.arange(order + 1)
        if kink is not None:
            rows[kink, 0] = 0.0
        root, found, minima = 2.0, None, []
        close = rows[:, 0] - np.abs(rows[:, 1:]).sum(axis=1) < 1
        for row in np.flatnonzero(close & rows.any(axis=1)):
            function = rows[row].tolist()
            falling = next(c for c in function if c) < 0
            zeros = [0.0] if falling else _crossings64(function)
            if zeros and zeros[0] < root:
                root, found = zeros[0], row
            if row < 3 * n_blocks:
                slope = _derivative(function)
                minima += [
                    (_value(function, at), at, row)
                    for at in _crossings64(slope)
                    if _value(_derivative(slope), at) > 0
                ]
        elapsed = min(root, 1.0) * step
        for distance, at, row in minima:
            if at < root and 0 < distance < min(nearest[0], 1):
                nearest = (distance, time + at * step, int(row) % n_blocks + 1)
        powers = elapsed ** np.arange(order + 1)
        v = (np.arange(1, order + 1) * powers[:-1]) @ x[1:]
        y = powers @ x
        time += elapsed
        kink = None
        if found is None:
            continue
        what, block = divmod(int(found), n_blocks)
        if what >= 3:
            end = 1.0 if what == 3 else -1.0
            branch[block] = end if branch[block] == 0 else 0.0
            kink = found
            continue
        kinds = ["slip"]
        pull = powers[: order - 1] @ force[:, block]
        if what == 0:
            v[block + 1], direction[block] = belt_velocity, 0.0
            kinds = ["stick", "slip"] if abs(pull) >= THRESHOLD else ["stick"]
        if "slip" in kinds:
            direction[block] = copysign(1.0, pull)
        rate = abs(_value(_derivative(rows[found].tolist()), root)) / step
        events += [(time, block + 1, kind) for kind in kinds]
        contacts += [(*nearest, rate) for _ in kinds]
        nearest = none
    return events, [*contacts, (*nearest, nan)]


def _series64(y, v, direction, branch, order):
    n_blocks = branch.size
    x = np.zeros((order + 1, n_blocks + 1))
    x[0], x[1] = y, v
    force, growth, weighted = np.zeros((3, order - 1, n_blocks))
    linear = branch == 0
    rate = np.where(linear, 1.0, np.where(branch < 0, -COMPRESSION, EXTENSION))
    for k in range(order - 1):
        tension = np.diff(x[k])
        if k == 0:
            exponent = np.where(linear, 0.0, rate * (tension - branch * LIMIT))
            growth[0] = np.exp(exponent)
            curved = branch * LIMIT + np.expm1(exponent) / rate
        else:
            weighted[k] = k * rate * tension
            growth[k] = (weighted[1 : k + 1] * growth[k - 1 :: -1]).sum(axis=0) / k
            curved = growth[k] / rate
        tension = np.where(linear, tension, curved)
        force[k] = np.append(tension[1:], 0.0) - tension
        friction = direction * RATIO * THRESHOLD if k == 0 else 0.0
        x[k + 2, 1:] = (direction != 0) * (force[k] - friction) / ((k + 1) * (k + 2))
    return x, force


def _event_rows64(x, force, direction, branch, belt_velocity):
    """Event functions (5 N, order + 1): end of slip, slip +, slip -, upper kink, lower kink.

    Rows of zeros stand for functions that do not apply.
    """
    order, n_blocks = x.shape[0] - 1, branch.size
    rows = np.zeros((5, n_blocks, order + 1))
    velocity = np.arange(1, order + 1)[:, None] * x[1:, 1:]
    velocity[0] -= belt_velocity
    rows[0, :, :order] = (direction * velocity).T
    for row, sign in ((1, 1.0), (2, -1.0)):
        rows[row, :, : order - 1] = -sign * force.T
        rows[row, :, 0] += THRESHOLD
        rows[row, direction != 0] = 0.0
    for row, end in ((3, 1.0), (4, -1.0)):
        rows[row] = -end * np.diff(x).T
        rows[row, :, 0] += LIMIT
        rows[row] *= np.where(branch == 0, 1.0, -1.0)[:, None]
        rows[row, branch == -end] = 0.0
    return rows.reshape(5 * n_blocks, order + 1)


def _crossings64(coefficients):
    """Where the polynomial changes sign in ]0, 1]: once at most between critical points."""
    if len(coefficients) < 2 or abs(coefficients[0]) > sum(map(abs, coefficients[1:])):
        return []
    crossings = []
    for left, right in pairwise([0.0, *_crossings64(_derivative(coefficients)), 1.0]):
        start, stop = _value(coefficients, left), _value(coefficients, right)
        if start * stop > 0 or start == 0:
            continue
        while left < (middle := (left + right) / 2) < right:
            if start * _value(coefficients, middle) > 0:
                left = middle
            else:
                right = middle
        crossings.append(right)
    return crossings


def write_reference():
    """Write the events of `CASES`, with the state at the last event, to tests/data."""
    records = []
    for case in CASES:
        events, y, v = exact_events(**case)
        records.append(
            {
                **case,
                "events": [(float(time), block, kind) for time, block, kind in events],
                "positions": [float(50 * i + place) for i, place in enumerate(y, start=1)],
                "velocities": [float(velocity) for velocity in v],
            }
        )
    DATA.parent.mkdir(exist_ok=True)
    DATA.write_text(json.dumps(records, indent=1) + "\n")


if __name__ == "__main__":
    write_reference()
