"""Made-up datasets on the end of irregular motion, in the form of the kinds settling and motion."""

import numpy as np

from beltrepro.base.store import Dataset

HOW = {
    "preset": "smoke",
    "method": "event",
    "time_step": 0.001,
    "duration": 1e6,
    "noise": 0.0,
    "seed": 1,
    "code_version": "0.0+gabc",
}


def mean_lifetime(n_blocks, belt_velocity):
    """Grows with N, longest at u = 12: between 1e2 for N = 2 and 1e9 for N = 10."""
    return 10 ** (0.9 * n_blocks) * np.exp(-(((belt_velocity - 12) / 20) ** 2))


def exponent(n_blocks, belt_velocity):
    """Zero for N below 5, 0.012 for N = 10."""
    return np.maximum(0, 0.0023 * (n_blocks - 4.5)) * np.exp(-(((belt_velocity - 12) / 25) ** 2))


def grid(**levels):
    """Columns of all combinations of levels."""
    values = np.meshgrid(*map(np.asarray, levels.values()), indexing="ij")
    return {name: column.ravel() for name, column in zip(levels, values, strict=True)}


def settling(*, duration=1e6, lasts=None, runs=16, seed=11, **levels):
    """Runs that settle at a constant rate, periodic or in equilibrium slip.

    lasts : mean lifetime as a function of the columns.
    """
    columns = grid(**levels, replicate=np.arange(1, runs + 1))
    rng = np.random.default_rng(seed)
    n, u = columns["n_blocks"], columns["belt_velocity"]
    lifetime = rng.exponential((lasts or mean_lifetime)(n, u))
    settled = lifetime < duration
    lifetime = np.minimum(lifetime, duration)
    long_enough = lifetime > 2000
    error = 0.02 / np.sqrt(np.maximum(lifetime, 1.0))
    measured = exponent(n, u) + error * rng.standard_normal(n.size)
    ends = {
        "settled": settled,
        "lifetime": lifetime,
        "state": np.select([~settled, u > 30], ["irregular", "equilibrium slip"], "periodic"),
        "period_events": np.where(settled, 18, 0),
        "period_returns": np.where(settled, 2, 0),
        "irregular_exponent": np.where(long_enough, measured, np.nan),
        "irregular_error": np.where(long_enough, error, np.nan),
        "irregular_time": lifetime,
    }
    return Dataset(columns | ends, HOW | {"kind": "settling", "duration": duration})


def survivals(**levels):
    """Datasets of the survival of irregular motion, by name."""
    return {
        "survival": settling(**levels),
        "survival_many": settling(
            lasts=lambda n, u: 3e3 + 200 * u,
            n_blocks=[5],
            belt_velocity=levels["belt_velocity"][:2],
            initial_spread=[10.0],
            duration=2e5,
            runs=150,
        ),
        "survival_long": settling(
            n_blocks=[6], belt_velocity=levels["belt_velocity"][:1], initial_spread=[10.0],
            duration=1e7,
        ),
    }  # fmt: skip


def motion(*, runs=8, transient=2e5, seed=12, **levels):
    """Motions after a transient; chaotic where the mean lifetime is long and the exponent is."""
    columns = grid(**levels, replicate=np.arange(1, runs + 1))
    rng = np.random.default_rng(seed)
    n, u = columns["n_blocks"], columns["belt_velocity"]
    irregular = rng.exponential(mean_lifetime(n, u)) > transient
    value = np.where(irregular, exponent(n, u), 0) + 1e-5 * rng.standard_normal(n.size)
    regular = np.where(u > 30, "equilibrium slip", "periodic")
    results = {
        "state": np.where(irregular, np.where(value > 1e-4, "chaotic", "transient"), regular),
        "period_events": np.where(irregular, 0, 50),
        "period_returns": np.where(irregular, 0, 5),
        "largest_exponent": value,
        "nontrivial_exponent": value - 0.01,
        "erased": np.where(irregular, n, 1),
        "standard_error": np.full(n.size, 1e-5),
        "disorder_parameter": np.full(n.size, 0.1),
    }
    return Dataset(columns | results, HOW | {"kind": "motion", "transient": transient})
