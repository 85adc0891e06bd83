"""Orbits of maps, and samples of laws, whose answers are known."""

import numpy as np


def orbit(step, start, count, skip=0):
    """States (count, D) of a map after some steps."""
    state, states = np.atleast_1d(np.asarray(start, dtype=float)), []
    for index in range(skip + count):
        state = np.atleast_1d(step(state))
        if index >= skip:
            states.append(state)
    return np.array(states)


def logistic(rate):
    return lambda x: rate * x * (1 - x)


def henon(a, b=0.3):
    return lambda z: np.array([1 - a * z[0] ** 2 + z[1], b * z[0]])


def power_law(exponent, low, high, size, seed=0):
    """Values of a density ~ x**exponent between low and high, by inversion."""
    rate = exponent + 1
    ends = np.array([low, high]) ** rate
    return (ends[0] + np.random.default_rng(seed).random(size) * np.diff(ends)) ** (1 / rate)
