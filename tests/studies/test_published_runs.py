"""The runs behind published tables, few and short, against the calls that they stand for."""

import functools
import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.special import expit

from beltrepro import ChainParameters, audit, catalogue, periodic_orbit, simulate
from beltrepro.base.store import Dataset
from beltrepro.chaos import orbit_loss
from beltrepro.replication.plan.files import CHAIN
from beltrepro.replication.studies.avalanches import runs as avalanches
from beltrepro.replication.studies.disturbance import measure
from beltrepro.replication.studies.disturbance import runs as disturbance
from beltrepro.replication.studies.friction_ratio import runs as friction
from beltrepro.replication.studies.laws import measure as laws
from beltrepro.replication.studies.sizes import measure as sizes
from beltrepro.stats import estimates
from beltrepro.stats.motion import PERIODIC

COUNTED = ("one_block", "several_blocks", "all_blocks")

# --- the fall at other friction ratios ------------------------------------------------------------


@pytest.mark.parametrize(("ratio", "scaled"), [(0.2, 40.0), (0.7, 31.0)])
def test_a_made_up_fall_is_found_where_it_is(monkeypatch, ratio, scaled):
    shares = expit((friction.VELOCITIES - scaled) / 2)
    rng = np.random.default_rng(5)

    def deviations(springs, friction_ratio):
        assert (springs, friction_ratio) == ("linear", ratio)
        fallen = rng.random((len(shares), friction.REPLICATES)) < shares[:, np.newaxis]
        return np.where(fallen, 2.0, 10.0) * rng.normal(1, 0.02, fallen.shape)

    monkeypatch.setattr(friction, "_deviations", deviations)
    (row,) = friction.falls("linear", ratio)
    step = (friction.VELOCITIES[1] - friction.VELOCITIES[0]) * (1 - ratio)
    critical = scaled * (1 - ratio)
    assert row["critical"] == pytest.approx(critical, abs=step)
    assert row["critical_low"] < row["critical"] < row["critical_high"]
    assert row["critical_high"] - row["critical_low"] < 3 * step
    assert row["plateau"] == pytest.approx(10, rel=0.01)
    assert row["begin"] == pytest.approx(critical, abs=2 * step)
    assert row["begin_low"] < row["begin"] <= row["begin_high"]
    assert row["runs"] == len(shares) * friction.REPLICATES


def test_half_of_the_runs_have_fallen_at_two_neighbours():
    u = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
    assert friction._begin(u, np.array([0.4, 0.5, 0.4, 0.5, 0.6])) == 8
    assert friction._begin(u, np.array([0.6, 0.5, 0.4, 0.3, 0.6])) == 1
    assert math.isnan(friction._begin(u, np.array([0.1, 0.6, 0.4, 0.6, 0.49])))


@pytest.mark.parametrize("springs", friction.SPRINGS)
def test_deviations_are_those_of_single_runs(monkeypatch, springs):
    ratio, velocities = 0.3, np.array([10.0, 20.0, 45.0])
    small = {"VELOCITIES": velocities, "REPLICATES": 2, "DURATION": 100.0, "TRANSIENT": 30.0}
    for name, value in small.items():
        monkeypatch.setattr(friction, name, value)
    deviation = friction._deviations(springs, ratio)
    assert deviation.shape == (3, 2)
    limit = {"linear_limit": math.inf} if springs == "linear" else {}
    chain = ChainParameters(5, 45 * 0.7, friction_ratio=ratio, rest_length=1000.0, **limit)
    pull = np.arange(5, 0, -1) * ratio * chain.static_friction  # on the spring before each block
    law = pull if springs == "linear" else _stretched(pull)
    run = simulate(
        chain,
        replicate=2,
        method="event",
        duration=100,
        transient=30,
        sample_interval=0.02,
        initial_positions=np.cumsum(1000 + law),
        initial_spread=4 * (1 - ratio),
    )
    kept = run.positions[run.time >= 30, -1]
    assert deviation[2, 1] == pytest.approx(kept.std(), rel=1e-3)


def _stretched(pull):
    """Deformation of the paper's springs, which stiffen beyond their limit, under a pull."""
    chain = ChainParameters(1, 1.0)
    limit, rate = chain.linear_limit, chain.extension_rate
    beyond = limit + np.log1p(rate * np.maximum(pull - limit, 0)) / rate
    return np.where(pull <= limit, pull, beyond)


# --- orbits that are lost, lifetimes --------------------------------------------------------------


def test_a_row_of_a_lost_orbit_is_what_each_call_gives(monkeypatch):
    chain = ChainParameters(2, 5.0)
    orbit = periodic_orbit(chain, duration=4000, transient=2000)
    monkeypatch.setattr(disturbance, "WITHIN", 300.0)
    monkeypatch.setattr(disturbance, "_orbits", lambda chain: iter([(orbit, 3)]))
    settled = {"period_events": np.array([orbit.period_events, 1, orbit.period_events])}
    monkeypatch.setattr(disturbance, "_settled", lambda chain, time, method: settled)
    monkeypatch.setitem(disturbance.STARTS, 2, 7)
    (row,) = disturbance.orbits_lost(chain)
    track = orbit_loss.Track.of(orbit)
    for name, replicates in (("kick", 8), ("step", 4), ("noise", 8)):
        loss = orbit_loss.loss(
            track, getattr(orbit_loss, name.upper()), duration=300.0, replicates=replicates
        )
        column = "time_step" if name == "step" else name
        ends = [row[column], row[f"{column}_low"], row[f"{column}_high"]]
        assert ends == [loss.size, loss.low, loss.high] and loss.low <= loss.size <= loss.high
    assert (row["starts"], row["ended"], row["scheme"]) == (7, 3, 2)
    assert row["period_time"] == orbit.period_time and row["slips"] == orbit.period_events
    assert 0 < row["scatter"] < 100 and row["margin"] > 0


def test_orbits_that_starts_end_on_are_counted(monkeypatch):
    chain = ChainParameters(2, 5.0)
    for name, value in (("STARTS", {2: 5}), ("SETTLING", {2: 4000.0})):
        monkeypatch.setattr(disturbance, name, value)
    runs = disturbance._settled(chain, 4000.0)
    periodic = runs["state"].astype(str) == PERIODIC
    orbits = list(disturbance._orbits(chain))
    assert sum(starts for _, starts in orbits) == periodic.sum() > 0
    assert [orbit.period_events for orbit, _ in orbits] == sorted(
        set(runs["period_events"][periodic])
    )


@pytest.mark.parametrize(("mean", "given_up"), [(300.0, 900.0), (50.0, 1e9)])
def test_laws_of_made_up_lifetimes(monkeypatch, mean, given_up):
    times = np.random.default_rng(9).exponential(mean, 160)
    others = {"n_blocks": 4, "belt_velocity": 3.0, "lifetime": 1.0, "settled": True}
    runs = pd.DataFrame(
        {"n_blocks": 5, "belt_velocity": 7.0, "lifetime": np.minimum(times, given_up)}
    ).assign(settled=times < given_up)
    few = pd.DataFrame([others] * 99)
    monkeypatch.setattr(measure, "_published", lambda name: pd.concat([few, runs]))
    fewer = functools.partial(estimates.bootstrap, resamples=60)
    monkeypatch.setattr(estimates, "bootstrap", lambda *of, resamples: fewer(*of))
    (row,) = measure.lifetime_laws({}).to_dict("records")
    ended = times < given_up
    assert row["mean"] == pytest.approx(np.minimum(times, given_up).sum() / ended.sum())
    assert (row["runs"], row["ended"], row["n_blocks"]) == (160, ended.sum(), 5)
    assert row["shape_low"] < row["shape"] < row["shape_high"]
    assert row["shape"] == pytest.approx(1, abs=0.2) and row["aic_exponential"] < 4


# --- energies of avalanches, audits, sections -----------------------------------------------------


def test_energies_of_avalanches_are_counted_by_run_bin_and_blocks(monkeypatch):
    for name, value in (("RUNS", 3), ("DURATION", 3000.0), ("TRANSIENT", 600.0)):
        monkeypatch.setattr(avalanches, name, value)
    rows = list(avalanches.energies(3))
    chain = ChainParameters(3, 1.0)
    start = np.cumsum(50 + _stretched(np.arange(3, 0, -1) * 0.45 * 71.4))
    for number in (1, 3):
        seen = catalogue(
            chain, method="event", replicate=number, initial_positions=start, initial_spread=1.0,
            duration=3000.0, transient=600.0,
        )["avalanches"]  # fmt: skip
        expected = {}
        for energy, blocks in zip(seen["dissipated"], seen["blocks"], strict=True):
            if energy > 0:
                middle = 10 ** ((math.floor(20 * math.log10(energy)) + 0.5) / 20)
                name = {1: "one_block", 3: "all_blocks"}.get(int(blocks), "several_blocks")
                counts = expected.setdefault(round(middle, 9), dict.fromkeys(COUNTED, 0))
                counts[name] += 1
        here = [row for row in rows if row["run"] == number]
        assert {round(row["energy"], 9): {k: row[k] for k in COUNTED} for row in here} == expected
        assert sum(sum(counts.values()) for counts in expected.values()) > 20


def test_a_dataset_is_audited_as_its_run():
    chain = ChainParameters(2, 5.0, noise=0.5)
    run = simulate(chain, method="event", duration=60, sample_interval=0.1)
    of_run = {name: getattr(run, name) for name in ("time", "positions", "velocities", "friction")}
    about = {name: getattr(chain, name) for name in CHAIN} | {"method": "event", "time_step": 1e-3}
    residual = np.array([run.energy_residual])
    data = Dataset(of_run | {"energy_residual": residual}, about)
    table = laws.audit(dict.fromkeys(laws.TABLES["audit"].uses, data))
    assert table["dataset"].tolist() == ["u20", "u17", "friction_event", "n10_u28"]
    for name, value in vars(audit(run)).items():
        assert table[name].to_numpy() == pytest.approx([value] * 4, nan_ok=True), name
    assert set(table["noise"]) == {0.5} and set(table["belt_velocity"]) == {5.0}


def test_distributions_at_the_section_are_compared_and_averaged_over_u(monkeypatch):
    monkeypatch.setattr(sizes, "RESAMPLES", 3)
    u, rng = np.array([1.0, 2.0, 4.0, 5.0, 9.0, 20.0]), np.random.default_rng(8)

    def row(shift, counts):
        samples = {p: shift * p + rng.normal(size=n) for p, n in zip(u, counts, strict=True)}
        place = np.repeat(u, counts)
        velocities = np.concatenate([samples[p] for p in u])
        velocities[place == 5.0] = np.where(rng.random(sum(place == 5.0)) < 0.9, np.nan, 1.0)
        return SimpleNamespace(
            belt_velocity=place, velocities=velocities, samples=samples,
            between=lambda low, high: (place >= low) & (place <= high),
        )  # fmt: skip

    quiet, noisy = row(0.0, [40, 50, 35, 60, 45, 80]), row(0.2, [45, 40, 55, 70, 36, 90])
    counted = [1.0, 2.0, 4.0, 9.0]  # at 5 there are few crossings, 20 is beyond the range
    far = []
    for place in counted:
        one, other = quiet.samples[place], noisy.samples[place]
        ends = np.concatenate([one, other])
        far.append(max(abs(np.mean(one <= end) - np.mean(other <= end)) for end in ends))
    value = sizes.effect_on_section(1.0, 9.0, quiet, noisy).value
    assert value == pytest.approx(np.trapezoid(far, counted) / 8)
