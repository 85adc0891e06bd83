"""Made-up runs without noise: motions by name, runs that settle, scans of r."""

import numpy as np

from beltrepro.base.store import Dataset
from beltrepro.stats.motion import CHAOTIC, EQUILIBRIUM, PERIODIC, QUASI_PERIODIC, TRANSIENT

NAMES = {"e": EQUILIBRIUM, "p": PERIODIC, "q": QUASI_PERIODIC, "c": CHAOTIC, "t": TRANSIENT}
ABOVE = np.full(8, 0.002) + np.tile([-1e-4, 1e-4], 4)  # exponents
CLEAR, SHORT = 2e5, 99_999.0  # durations on both sides of the shortest that counts as long


def settled(
    lifetime, *, u, spread=10.0, exponents=ABOVE, state=PERIODIC, returns=500, duration=CLEAR,
    **others,
):  # fmt: skip
    """Runs of five blocks with these lifetimes; those of `duration` did not settle."""
    lifetime = np.array(lifetime, dtype=float)
    size, done = lifetime.size, lifetime < duration
    arrays = {
        "n_blocks": np.full(size, 5),
        "belt_velocity": np.broadcast_to(np.array(u, dtype=float), size),
        "initial_spread": np.full(size, spread),
        "lifetime": lifetime,
        "settled": done,
        "state": np.where(done, state, "irregular"),
        "period_returns": np.where(done, returns, 0),
        "irregular_exponent": np.resize(exponents, size).astype(float),
        "irregular_error": np.full(size, 1e-5),
        "irregular_time": np.full(size, duration),
    }
    arrays |= {name: np.full(size, value) for name, value in others.items()}
    return Dataset(arrays, {"duration": duration})


def joined(*datasets):
    """Datasets of one duration as one."""
    arrays = {
        name: np.concatenate([each.arrays[name] for each in datasets])
        for name in datasets[0].arrays
    }
    return Dataset(arrays, datasets[0].attributes)


def motion_map(letters, *, u=None, duration=CLEAR, returns=500, disorder=0.1):
    """Runs by number of blocks: a letter for each motion, at u = 1, 2, ... if not given."""
    velocity = [np.arange(1.0, len(own) + 1) if u is None else u for own in letters.values()]
    size = sum(map(len, letters.values()))
    arrays = {
        "n_blocks": np.repeat(list(letters), [len(own) for own in letters.values()]),
        "belt_velocity": np.concatenate(velocity),
        "state": np.array([NAMES[letter] for letter in "".join(letters.values())]),
        "period_returns": np.resize(returns, size),
        "disorder_parameter": np.resize(disorder, size).astype(float),
    }
    return Dataset(arrays, {"duration": duration, "transient": duration / 2})


def scan(
    n_blocks, belt_velocity, disorder, *, noise=0.0, method="event", replicates=1, transient=2e5,
    duration=1e6, **others,
):  # fmt: skip
    """Points of a scan, each `replicates` times: numbers, or one for each point or run."""
    belt_velocity = np.repeat(np.array(belt_velocity, dtype=float), replicates)
    size = belt_velocity.size

    def each(values):
        values = np.asarray(values)
        if values.ndim and len(values) * replicates == size:
            return np.repeat(values, replicates, axis=0)
        return np.broadcast_to(values, (size, *values.shape[1:])) if not values.ndim else values

    given = {"n_blocks": n_blocks, "noise": noise, "disorder_parameter": disorder, **others}
    arrays = {name: each(values) for name, values in given.items()}
    arrays |= {"belt_velocity": belt_velocity, "method": np.full(size, method)}
    return Dataset(arrays, {"transient": transient, "duration": duration})
