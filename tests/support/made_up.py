"""Verdicts of claims on made-up runs: datasets whose answers are known."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from beltrepro.base.store import Dataset
from beltrepro.replication.studies import every_claim  # noqa: F401 registers the claims
from beltrepro.replication.verdicts.criteria import QUESTIONS, judge
from beltrepro.replication.verdicts.evidence import Evidence
from beltrepro.replication.verdicts.ledger import REGISTRY, load_ledger
from beltrepro.stats import estimates
from beltrepro.stats.motion import CHAOTIC, EQUILIBRIUM, PERIODIC, QUASI_PERIODIC, TRANSIENT

LEDGER = load_ledger()
LAW = {
    "static_friction": 71.4,
    "friction_ratio": 0.45,
    "rest_length": 50.0,
    "linear_limit": 20.0,
    "compression_rate": 0.2,
    "extension_rate": 0.01,
}


def data(arrays=None, **attributes):
    return SimpleNamespace(arrays=arrays or {}, attributes=attributes)


# --- verdicts, and scans by laws ------------------------------------------------------------------

SETTINGS = {"model": LAW, "defaults": {"laminar_time": 200.0}}


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch):
    """Intervals from fewer resamples, where a module imports this."""
    monkeypatch.setitem(estimates.bootstrap.__kwdefaults__, "resamples", 100)
    monkeypatch.setattr(estimates, "RESAMPLES", 100)


def readings(name, datasets=None, settings=SETTINGS):
    """Functions of a claim by reading, the first one of `replicated` first."""
    evidence = Evidence(datasets or {}, settings)
    evidence.start(LEDGER[name])
    return {reading: partial(of, evidence) for reading, of in REGISTRY[name].items()}


def measured(name, reading=None, /, settings=SETTINGS, **datasets):
    """Measurement of a claim, in the first reading or another one."""
    functions = readings(name, datasets, settings)
    measurement = functions[reading if reading is not None else next(iter(functions))]()
    return measurement


def grades(name, question="replicated", /, settings=SETTINGS, **datasets):
    """Verdict on each number of a claim, by its name, and on the whole under ""."""
    criterion = LEDGER[name].criteria[question]
    measurement = measured(name, criterion.reading or None, settings=settings, **datasets)
    answer = judge(criterion, measurement)
    return answer.components | {"": answer.verdict}


def both(name, /, settings=SETTINGS, **datasets):
    """The two verdicts of a claim: replicated, robust."""
    return tuple(grades(name, q, settings=settings, **datasets)[""] for q in QUESTIONS)


def scan_of_laws(belt_velocity, disorder, *, replicates=8, labels=None, noise=0.0):
    """Rows of a scan: r(u) by a function of u and a random stream, states by one of u."""
    rng = np.random.default_rng(0)
    u = np.repeat(np.asarray(belt_velocity, dtype=float), replicates)
    named = np.array([labels(one) if labels else "chaotic" for one in u])
    velocity = _irregular(u.size)
    velocity[named == "periodic"] = np.tile([5.0, 9.0], 50)
    velocity[named == "continuous"] = np.nan
    others = {
        "replicate": np.tile(np.arange(1, replicates + 1), u.size // replicates),
        "laminar_fraction": np.where(named == "continuous", 1.0, 0.0),
        "laminar_count": 0,
        "last_stick_time": np.where(named == "continuous", 0.0, 2e5),
        "section_velocity": velocity,
    }
    r = np.array([disorder(one, rng) for one in u])
    return scan(5, u, r, noise=noise, transient=1e5, duration=2e5, **others)


def escapes(short, long, on_orbit, chaotic):
    """Runs that escape before and after 4000, end on stick-slip orbits, or are chaotic still."""
    rng = np.random.default_rng(5)
    counts = [short, long, on_orbit, chaotic]
    size, kept = sum(counts), short + long
    rates = np.full((size, 5), 0.1)
    rates[kept + on_orbit :] += 0.02 * rng.random((chaotic, 5))
    rates[:kept, -1] = 0
    reach = np.repeat([30.0, 30.0, 350.0, 350.0], counts)
    reach[kept + on_orbit :] += rng.uniform(-50, 50, chaotic)
    arrays = {
        "n_blocks": np.full(size, 5),
        "belt_velocity": np.full(size, 20.0),
        "lifetime": np.repeat([900.0, 6000.0, 1e4, 1e4], counts),
        "escaped": np.arange(size) < kept,
        "final_disorder": np.repeat([0.02, 0.02, 0.12, 0.12], counts),
        "final_amplitude": reach,
        "final_stick_rate": rates,
    }
    return Dataset(arrays, {"duration": 1e4, "settle_time": 2000.0})


def _irregular(count, size=100):
    """Rows of a logistic map, which is chaotic."""
    values = np.random.default_rng(1).uniform(0.1, 0.9, count)
    rows = []
    for _ in range(size + 20):
        values = 4 * values * (1 - values)
        rows.append(10 * values)
    return np.array(rows[20:]).T


# --- five blocks with noise -----------------------------------------------------------------------

NOISES = (0.0, 0.5, 1.0, 2.2, 5.0)
VELOCITIES = (6, 8, 10, 12, 13, 14, 14.5, 15, 15.5, 16, 16.5, 17, 17.5, 18, 18.5, 19, 19.5, 20)
VELOCITIES += (21, 22, 23, 24, 26, 28, 30, 33, 36)
HIGH, LOW = 0.13, 0.02


def falling(u, centre, width):
    """R(u) that falls in a straight line."""
    return LOW + (HIGH - LOW) * np.clip((centre + width / 2 - u) / width, 0, 1)


def replicates(
    critical, *, noises=NOISES, velocities=VELOCITIES, replicates=8, width=3.0, scatter=0.003,
    windows=None, laminar=None, seed=1,
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
        name: np.array([one.get(s, 0.0) if isinstance(one, dict) else one for s in noise])
        for name, one in {"critical": critical, "width": width, "scatter": scatter}.items()
    }
    disorder = falling(u, of["critical"], of["width"])
    disorder = disorder * (1 + of["scatter"] / HIGH * rng.standard_normal(u.size))
    share = np.array([(windows or {}).get(s, 0.0) for s in noise])
    periodic = (u <= 15) & (replicate <= replicates * share)
    velocity = np.where(periodic[:, None], -20.0, rng.uniform(-60, 0, (u.size, 100)))
    alternating = np.zeros(u.size, dtype=bool)
    if laminar is not None:
        alternating = rng.random(u.size) < [laminar(*one) for one in points[:, :2]]
    others = {
        "replicate": replicate.astype(int),
        "mean_length": 600.0,
        "section_velocity": velocity,
        "laminar_fraction": np.where(alternating, 0.4 + 0.1 * rng.random(u.size), 0.0),
        "laminar_count": np.where(alternating, 9, 0),
    }
    r = np.where(periodic, 0.6 * disorder, disorder)
    return scan(5, u, r, noise=noise, **others)


def table(points, disorder, **others):
    """Scan of single points (u, sigma) with these values."""
    u, noise = np.array(points, dtype=float).T
    return scan(5, u, np.asarray(disorder, dtype=float), noise=noise, **others)


# --- motions by name, runs that settle, scans without noise ---------------------------------------

NAMES = {"e": EQUILIBRIUM, "p": PERIODIC, "q": QUASI_PERIODIC, "c": CHAOTIC, "t": TRANSIENT}
ABOVE = np.full(8, 0.002) + np.tile([-1e-4, 1e-4], 4)  # exponents
CLEAR, SHORT = 2e5, 99_999.0  # durations on both sides of the shortest that counts as long


def settled(
    lifetime, *, u, spread=10.0, exponents=ABOVE, state=PERIODIC, returns=500, slips=90,
    duration=CLEAR, **others,
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
        "period_events": np.where(done, slips, 0),
        "irregular_exponent": np.resize(exponents, size).astype(float),
        "irregular_error": np.full(size, 1e-5),
        "irregular_time": np.full(size, duration),
    }
    arrays |= {name: np.full(size, value) for name, value in others.items()}
    return Dataset(arrays, {"duration": duration})


def joined(*datasets):
    """Datasets of one duration as one."""
    arrays = {
        name: np.concatenate([dataset.arrays[name] for dataset in datasets])
        for name in datasets[0].arrays
    }
    return Dataset(arrays, datasets[0].attributes)


def motion_map(letters, *, u=None, duration=CLEAR, returns=500, disorder=0.1):
    """Runs by number of blocks: a letter for each motion, at u = 1, 2, ... if not given."""
    velocity = [np.arange(1.0, len(one) + 1) if u is None else u for one in letters.values()]
    size = sum(map(len, letters.values()))
    arrays = {
        "n_blocks": np.repeat(list(letters), [len(one) for one in letters.values()]),
        "belt_velocity": np.concatenate(velocity),
        "state": np.array([NAMES[letter] for letter in "".join(letters.values())]),
        "period_returns": np.resize(returns, size),
        "disorder_parameter": np.resize(disorder, size).astype(float),
    }
    at_each = pd.DataFrame(arrays).groupby(["n_blocks", "belt_velocity"])
    arrays["replicate"] = at_each.cumcount().to_numpy() + 1
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
        return values if values.ndim else np.full(size, values)

    passed = {"n_blocks": n_blocks, "noise": noise, "disorder_parameter": disorder}
    passed |= {"last_stick_time": float(duration), **others}
    arrays = {name: each(values) for name, values in passed.items()}
    arrays |= {"belt_velocity": belt_velocity, "method": np.full(size, method)}
    return Dataset(arrays, {"transient": transient, "duration": duration})
