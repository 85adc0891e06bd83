"""Made-up runs of five blocks with noise, whose transition and windows are known."""

import numpy as np

import judging
from beltrepro.base.store import Dataset

NOISES = (0.0, 0.5, 1.0, 2.2, 5.0)
VELOCITIES = (6, 8, 10, 12, 13, 14, 14.5, 15, 15.5, 16, 16.5, 17, 17.5, 18, 18.5, 19, 19.5, 20)
VELOCITIES += (21, 22, 23, 24, 26, 28, 30, 33, 36)
HIGH, LOW = 0.13, 0.02


def found(name, reading=None, /, **datasets):
    """Measurement of a claim, in the reading that counts or another one."""
    return judging.judged(name, datasets, reading)[2]


def judged(name, reading=None, /, **datasets):
    """Verdict on each component of a claim, by its name, and on the whole under ""."""
    verdict, components, _ = judging.judged(name, datasets, reading)
    return components | {"": verdict}


def falling(u, centre, width):
    """R(u) that falls in a straight line."""
    return LOW + (HIGH - LOW) * np.clip((centre + width / 2 - u) / width, 0, 1)


def runs(
    critical, *, noises=NOISES, velocities=VELOCITIES, replicates=8, width=3.0, scatter=0.003,
    windows=None, laminar=None, seed=1, **lengths,
):  # fmt: skip
    """Scan with independent runs at each point.

    critical, width, scatter : number, or dict by noise.
    windows : share of the runs at u <= 15 that are periodic, by noise; theirs is a smaller r.
    laminar : function of u and noise: probability that a run is intermittent.
    """
    points = np.array(
        [(u, s, k) for s in noises for u in velocities for k in range(1, replicates + 1)], float
    )
    rng = np.random.default_rng(seed)
    u, noise, replicate = points.T
    of = {
        name: np.array([each.get(s, 0.0) if isinstance(each, dict) else each for s in noise])
        for name, each in {"critical": critical, "width": width, "scatter": scatter}.items()
    }
    disorder = falling(u, of["critical"], of["width"])
    disorder = disorder * (1 + of["scatter"] / HIGH * rng.standard_normal(u.size))
    share = np.array([(windows or {}).get(s, 0.0) for s in noise])
    periodic = (u <= 15) & (replicate <= replicates * share)
    velocity = np.where(periodic[:, None], -20.0, rng.uniform(-60, 0, (u.size, 100)))
    alternating = np.zeros(u.size, dtype=bool)
    if laminar is not None:
        alternating = rng.random(u.size) < [laminar(*each) for each in points[:, :2]]
    arrays = {
        "n_blocks": np.full(u.size, 5),
        "belt_velocity": u,
        "noise": noise,
        "replicate": replicate.astype(int),
        "disorder_parameter": np.where(periodic, 0.6 * disorder, disorder),
        "section_velocity": velocity,
        "laminar_fraction": np.where(alternating, 0.4 + 0.1 * rng.random(u.size), 0.0),
        "laminar_count": np.where(alternating, 9, 0),
        "laminar_longest": np.where(alternating, 900.0, 0.0),
    }
    attributes = {"transient": 2e5, "duration": 1e6} | lengths
    arrays["last_stick_time"] = np.full(u.size, attributes["duration"])
    return Dataset(arrays, attributes)


def table(points, disorder, **others):
    """Scan of single points (u, sigma) with these values."""
    u, noise = np.array(points, dtype=float).T
    arrays = {"n_blocks": np.full(u.size, 5), "belt_velocity": u, "noise": noise}
    arrays |= {"disorder_parameter": np.array(disorder, dtype=float)}
    arrays |= {name: np.asarray(values) for name, values in others.items()}
    return Dataset(arrays, {"transient": 2e5, "duration": 1e6})
