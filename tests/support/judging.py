"""Verdicts of claims on made-up datasets, and made-up datasets of independent runs."""

import numpy as np
import pytest

from beltrepro.base.store import Dataset
from beltrepro.replication.verdicts.criteria import judge
from beltrepro.replication.verdicts.evidence import Evidence
from beltrepro.stats import estimates
from made_up import LAW, LEDGER, REGISTRY

SETTINGS = {"model": LAW, "defaults": {"laminar_time": 200.0}}


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch):
    """Intervals from fewer resamples, where a module imports this."""
    monkeypatch.setitem(estimates.bootstrap.__kwdefaults__, "resamples", 100)
    monkeypatch.setattr(estimates, "RESAMPLES", 100)


def readings(name, datasets=None, settings=SETTINGS):
    """Functions of a claim by reading, the one that counts first."""
    evidence = Evidence(datasets or {}, settings)
    evidence.start(LEDGER[name])
    found = REGISTRY[name](evidence)
    return found if isinstance(found, dict) else {"": lambda: found}


def judged(name, datasets=None, reading=None, settings=SETTINGS):
    """Verdict, what each number makes of it, and the measurement; of the first reading if none is
    named."""
    found = readings(name, datasets, settings)
    measurement = found[reading if reading is not None else next(iter(found))]()
    judgement = judge(LEDGER[name].criterion, measurement)
    return judgement.verdict, judgement.components, measurement


def runs(**arrays):
    """Arrays of one length; single values are repeated."""
    size = max(np.size(values) for values in arrays.values())
    return {
        name: np.array(values) if np.ndim(values) else np.full(size, values)
        for name, values in arrays.items()
    }


def scan(belt_velocity, disorder, *, replicates=8, labels=None, noise=0.0, n_blocks=5):
    """Rows of a scan: r(u) by a function of u and a random stream, states by one of u."""
    rng = np.random.default_rng(0)
    u = np.repeat(np.asarray(belt_velocity, dtype=float), replicates)
    transient, duration = 1e5, 2e5
    named = [labels(each) if labels else "chaotic" for each in u]
    cycle = {"periodic": np.tile([5.0, 9.0], 50), "continuous": np.full(100, np.nan)}
    velocity = [cycle.get(each, -1.0) for each in named]
    irregular = _irregular(u.size)
    arrays = runs(
        n_blocks=np.full(u.size, n_blocks),
        noise=noise,
        belt_velocity=u,
        replicate=np.tile(np.arange(1, replicates + 1), u.size // replicates),
        disorder_parameter=[disorder(each, rng) for each in u],
        laminar_fraction=0.0,
        laminar_count=0,
        last_stick_time=[0.0 if each == "continuous" else duration for each in named],
    )
    arrays["section_velocity"] = np.array(
        [own if np.ndim(own) else other for own, other in zip(velocity, irregular, strict=True)]
    )
    return Dataset(arrays, {"transient": transient, "duration": duration})


def escapes(short, long, on_orbit, chaotic, *, duration=1e4, u=20.0):
    """Runs that escape before and after 4000, end on stick-slip orbits, or are chaotic still."""
    rng = np.random.default_rng(5)
    size = short + long + on_orbit + chaotic
    kept = short + long
    reach = np.r_[np.full(kept, 30.0), np.full(on_orbit, 350.0), rng.uniform(300, 400, chaotic)]
    rates = np.full((size, 5), 0.1)
    rates[kept + on_orbit :] += 0.02 * rng.random((chaotic, 5))
    rates[:kept, -1] = 0
    arrays = runs(
        n_blocks=np.full(size, 5),
        belt_velocity=u,
        lifetime=np.r_[
            np.full(short, 900.0), np.full(long, 6000.0), np.full(on_orbit + chaotic, duration)
        ],
        escaped=np.arange(size) < kept,
        final_disorder=np.where(np.arange(size) < kept, 0.02, 0.12),
        final_amplitude=reach,
    )
    return {
        "lifetimes": Dataset(
            arrays | {"final_stick_rate": rates}, {"duration": duration, "settle_time": 2000.0}
        )
    }


def _irregular(count, size=100):
    """Rows of a logistic map, which is chaotic."""
    values = np.random.default_rng(1).uniform(0.1, 0.9, count)
    rows = []
    for _ in range(size + 20):
        values = 4 * values * (1 - values)
        rows.append(10 * values)
    return np.array(rows[20:]).T
