"""Exact dynamics without noise (Sec. III, sigma = 0) in double precision, in a slow way.

`event_reference` follows a chain with NumPy. The motion is a Taylor series between two events, on
which every event function is a polynomial that is positive until its event, as listed in exact.py,
which has 40 digits. Roots are bracketed between the critical points. Positions are displacements
y_i = x_i - 50 i in the laboratory frame; the wall is y_0 = 0.
"""

from itertools import pairwise
from math import copysign, inf, nan

import numpy as np

LIMIT, COMPRESSION, EXTENSION = 20.0, 0.2, 0.01
THRESHOLD, RATIO = 71.4, 0.45


def _value(coefficients, at):
    value = 0
    for c in reversed(coefficients):
        value = value * at + c
    return value


def _derivative(coefficients):
    return [k * c for k, c in enumerate(coefficients)][1:]


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
