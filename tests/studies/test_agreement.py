"""Comparison of integrators: tests with known answers and error rates, its rows, page and runs."""

import importlib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from test_report import PIXEL, Page

from beltrepro.base.errors import InputError
from beltrepro.base.store import Dataset
from beltrepro.model import ChainParameters
from beltrepro.replication import report
from beltrepro.replication.drawing import style
from beltrepro.replication.plan import registry
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.kinds import KINDS, record
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import LAW as CONSTANTS
from beltrepro.replication.plan.points import QUANTITIES
from beltrepro.replication.studies.integrators import (
    agreement_attractors,
    agreement_disorder,
    agreement_trajectories,
    divergence,
    samples,
)
from beltrepro.replication.studies.integrators import compared as agreement
from beltrepro.replication.studies.integrators import words as page
from beltrepro.replication.studies.integrators.steps import mean_step
from beltrepro.replication.studies.measuring import measure
from beltrepro.replication.studies.transition.lifetimes import STICK_SLIP, labels_of
from beltrepro.simulation import TOLERANCES

ROOT = Path(__file__).parents[2]
CONFIG = load_config(ROOT / "config.yaml")
METHODS = ("verlet", "event")
LAW = [each.name for each in CONSTANTS]
FIGURES = (agreement_trajectories, agreement_disorder, agreement_attractors)


def within(rate, expected, trials, sigmas=4.0):
    """A counted rate is what it should be, to some standard errors of the count."""
    return abs(rate - expected) <= sigmas * np.sqrt(expected * (1 - expected) / trials)


# --- two samples ---


def test_means_and_errors_are_those_of_the_samples():
    found = samples.compare_samples([1, 2, 3, 4, 5, np.nan], [2, 3, 4, 5, 6])
    assert (found.n_tested, found.n_reference) == (5, 5)
    assert (found.mean_tested, found.mean_reference) == (3, 4)
    assert found.error_tested == pytest.approx(np.sqrt(2.5 / 5))
    assert found.z == pytest.approx(-1)
    assert found.mean_p == pytest.approx(2 * stats.t.sf(1, 8))
    assert found.distance == pytest.approx(1 / np.sqrt(90 / 5))
    assert found.test == "Kolmogorov-Smirnov"


def test_disjoint_samples_have_the_smallest_p_there_is():
    """Of the C(16, 8) ways to mix two samples of 8, two keep them apart."""
    found = samples.compare_samples(np.arange(8), np.arange(8) + 100)
    assert found.p == pytest.approx(2 / 12870)


def test_few_or_constant_runs_are_no_test():
    assert np.isnan(samples.compare_samples([1, 2, 3], [1, 2, 3]).p)
    same = samples.compare_samples(np.ones(8), np.ones(8))
    assert (same.z, same.p) == (0, 1) and np.isnan(same.mean_p)
    other = samples.compare_samples(np.ones(8), np.zeros(8))
    assert (other.z, other.mean_p) == (np.inf, 0)
    empty = samples.compare_samples([], [1.0] * 8)
    assert empty.n_tested == 0 and np.isnan(empty.distance)


@pytest.mark.thorough
def test_equal_samples_are_rejected_at_the_stated_rate():
    rng = np.random.default_rng(1)
    trials = 600
    found = [samples.compare_samples(*rng.standard_normal((2, 32))) for _ in range(trials)]
    assert within(np.mean([each.mean_p < 0.05 for each in found]), 0.05, trials)
    # exact, but the statistic has few values: the rate is the next one below the level
    possible = [stats.ks_2samp(range(32), np.arange(32) + k + 0.5).pvalue for k in range(33)]
    level = max(p for p in possible if p < 0.05)
    assert within(np.mean([each.p < 0.05 for each in found]), level, trials)


def test_shifted_or_wider_samples_are_noticed():
    rng = np.random.default_rng(2)
    base = rng.standard_normal(64)
    assert samples.compare_samples(base, rng.standard_normal(64) + 1).p < 1e-3
    wider = samples.compare_samples(base, 4 * rng.standard_normal(64))
    assert wider.p < 0.01


def test_shares_have_the_p_of_fisher():
    tested, reference = ["a"] * 18 + ["b"] * 6, ["a"] * 10 + ["b"] * 14
    found = samples.compare_shares(tested, reference, labels=("a", "b", "c"), counted="a")
    exact = stats.fisher_exact([[18, 6], [10, 14]]).pvalue
    assert found.p == pytest.approx(exact, abs=4 * np.sqrt(exact / 9999))
    assert (found.mean_tested, found.mean_reference) == (0.75, pytest.approx(10 / 24))
    assert found.distance == pytest.approx(8 / 24)
    alike = samples.compare_shares(tested, tested, labels=("a", "b"), counted="a")
    assert (alike.p, alike.distance) == (1, 0)
    one = samples.compare_shares(["a"] * 9, ["a"] * 9, labels=("a", "b"), counted="a")
    assert one.p == 1


def test_shares_are_rejected_at_the_stated_rate_or_less():
    rng = np.random.default_rng(3)
    p = [
        samples.compare_shares(
            *rng.choice(3, (2, 40), p=(0.7, 0.25, 0.05)),
            labels=(0, 1, 2),
            counted=0,
            n_permutations=399,
        ).p
        for _ in range(300)
    ]
    rate = np.mean(np.array(p) <= 0.05)
    assert rate < 0.05 + 4 * np.sqrt(0.05 * 0.95 / 300)


def lifetimes(rng, tau, size, end):
    lifetime = rng.exponential(tau, size)
    return np.minimum(lifetime, end), lifetime < end


def compare_lifetimes(rng, tau, other):
    (tested, left), (reference, gone) = (lifetimes(rng, t, 40, 100.0) for t in (tau, other))
    return samples.compare_lifetimes(tested, reference, escaped_tested=left, escaped_reference=gone)


def test_lifetimes_are_rejected_at_the_stated_rate_and_seen_through_censoring():
    rng = np.random.default_rng(4)
    p = np.array([compare_lifetimes(rng, 80.0, 80.0).p for _ in range(300)])
    assert within(np.mean(p < 0.05), 0.05, 300)
    assert compare_lifetimes(rng, 20.0, 150.0).p < 1e-3
    assert np.isnan(compare_lifetimes(rng, 1e6, 1e6).p)


# --- many tests ---


def test_holm_is_the_worked_example():
    corrected = samples.holm([0.01, 0.04, 0.03, 0.005, np.nan])
    np.testing.assert_allclose(corrected, [0.03, 0.06, 0.06, 0.02, np.nan])
    assert samples.holm([0.9, 0.8]).tolist() == [1, 1]
    assert samples.holm([]).size == 0


def test_family_wise_error_is_the_stated_one():
    rng = np.random.default_rng(5)
    wrong = [np.nanmin(samples.holm(rng.random(28))) < 0.05 for _ in range(2000)]
    assert within(np.mean(wrong), 0.05, 2000)


def test_verdicts():
    assert samples.verdict(0.05, 1.0) == samples.AGREE
    assert samples.verdict(0.049, 0.02) == samples.DIFFER
    assert samples.verdict(0.049, 0.005) == samples.CLOSE
    assert samples.verdict(np.nan, 0.0) == samples.UNKNOWN


def null_family(rng, shift=0.0):
    return [
        samples.compare_samples(5 + shift + rng.standard_normal(16), 5 + rng.standard_normal(16))
        for _ in range(24)
    ]


@pytest.mark.thorough
def test_overall_tests_have_the_stated_rate_and_see_a_common_shift():
    rng = np.random.default_rng(6)
    found = [samples.overall(null_family(rng)) for _ in range(60)]
    for p in ([each.chi2_p for each in found], [each.uniform_p for each in found]):
        assert stats.kstest(p, "uniform").pvalue > 1e-3
    scores = np.array([each.shift / each.shift_error for each in found])
    assert abs(scores.mean()) < 0.6 and 0.6 < scores.std() < 1.5
    # too small for any single test after correction, plain for all together
    shifted = null_family(rng, shift=0.5)
    assert samples.overall(shifted).chi2_p < 1e-3
    assert samples.overall(shifted).shift == pytest.approx(0.1, abs=0.06)
    assert samples.overall([]).degrees == 0


def test_largest_of_many():
    assert samples.largest_of(1) == pytest.approx(1.95996, abs=1e-4)
    rng = np.random.default_rng(7)
    largest = np.abs(rng.standard_normal((2000, 28))).max(axis=1)
    assert within(np.mean(largest > samples.largest_of(28)), 0.05, 2000)


# --- trajectories ---

EVENT = [("point", "i4"), ("time", "f8"), ("block", "i4"), ("kind", "U5")]


def events(times, *, block=1, run=0, first="slip"):
    other = {"slip": "stick", "stick": "slip"}[first]
    rows = [(run, time, block, (first, other)[k % 2]) for k, time in enumerate(times)]
    return np.array(rows, EVENT)


def test_events_are_shared_until_they_part():
    reference = events([1.0, 2.0, 3.0, 4.0])
    time, shift = divergence.match_events(events([1.1, 2.2, 3.4, 4.8]), reference)
    assert time.tolist() == [1, 2, 3]
    np.testing.assert_allclose(shift, [0.1, 0.2, 0.4])
    time, _ = divergence.match_events(events([1.0, 2.0, 3.0], first="stick"), reference)
    assert time.size == 0


def test_events_of_other_blocks_may_come_in_another_order():
    reference = np.concatenate([events([1.0, 3.0]), events([1.01, 2.0], block=2)])
    tested = np.concatenate([events([1.02, 3.0]), events([1.0, 2.0], block=2)])
    time, shift = divergence.match_events(tested, reference)
    np.testing.assert_allclose(time, [1, 1.01, 2, 3])
    np.testing.assert_allclose(shift, [0.02, -0.01, 0, 0])


@pytest.mark.parametrize("order", [1.0, 2.0, 0.5])
def test_order_of_convergence_is_found(order):
    steps = np.array([4e-3, 2e-3, 1e-3, 5e-4])
    found, error = divergence.convergence_order(steps, 7 * steps**order)
    assert found == pytest.approx(order)
    assert error < 1e-6
    noise = np.exp(0.1 * np.random.default_rng(8).standard_normal(4))
    found, error = divergence.convergence_order(steps, 7 * steps**order * noise)
    assert abs(found - order) < 4 * error


def test_rounding_and_two_steps_have_no_order():
    assert np.isnan(divergence.convergence_order([1e-3, 2e-3], [1, 2])[0])
    assert np.isnan(divergence.convergence_order([1e-3, 2e-3, 4e-3], [1, 2, 1e-12])[0])
    steps, errors = np.array([1e-3, 2e-3, 4e-3, 8e-3]), np.array([1e-12, 4, 16, 64])
    assert divergence.convergence_order(steps, errors)[0] == pytest.approx(2)
    found, _ = divergence.convergence_order(steps, errors, rounding=1e-13)
    assert found > 10


def trajectories(steps, *, slope=1.0, members=3):
    """Chains of 2 and 1 blocks whose error grows linearly from the first event, at t = 10, on."""
    time = np.arange(0.0, 40.5, 0.5)
    rows = [(n, 20.0, m, step) for n in (1, 2) for step in steps for m in range(members)]
    n_blocks, velocity, member, step = (np.array(column) for column in zip(*rows, strict=True))
    drift = slope * np.maximum(time - 10, 0)
    positions = 50.0 + time + member[:, None] + step[:, None] * drift
    positions = np.repeat(positions[..., None], 2, axis=2)
    positions[n_blocks == 1, :, 1] = np.nan
    found = [events([10.0, 20 + s, 30 + 2 * s], run=run) for run, s in enumerate(step)]
    return {
        "n_blocks": n_blocks,
        "belt_velocity": velocity,
        "noise": np.zeros(len(rows)),
        "replicate": member,
        "time_step": step,
        "allowed_error": np.full(len(rows), np.nan),
        "step": step,
        "time": time,
        "positions": positions,
        "events": np.concatenate(found),
    }


MADE_UP = [*10.0 ** -np.arange(1, 10), 1e-14]


def by_tolerance(tolerances=MADE_UP, *, order=15):
    """The same at dt = 0.001 for an integrator with mean step tolerance^(1/14) and this order."""
    runs = trajectories(np.asarray(tolerances) ** (order / 14))
    error = runs["time_step"]
    columns = {"step": error ** (1 / order), "allowed_error": error ** (14 / order)}
    return runs | columns | {"time_step": np.full(error.size, 0.001)}


def test_errors_and_partings_of_known_trajectories():
    steps = [0.004, 0.002, 0.001]
    reference = trajectories([1e-12, 0.5])
    partings, errors = agreement.compare_trajectories(
        trajectories(steps), reference, reference_step=1e-12
    )
    assert len(partings) == 2 * len(steps)
    row = next(row for row in partings if row["time_step"] == 0.002 and row["n_blocks"] == 2)
    assert row["members"] == 3 and row["parting_time"] == np.inf
    assert (row["shared_events"], row["reference_events"]) == (3, 3)
    assert row["first_shift"] == pytest.approx(0.004)
    table = {(row["n_blocks"], row["after_events"], row["time_step"]): row for row in errors}
    assert {key[1] for key in table} == {0, 1, 2}
    assert table[1, 0, 0.004]["error"] == 0 and np.isnan(table[1, 0, 0.004]["order"])
    assert table[1, 1, 0.004]["error"] == pytest.approx(0.5 * 0.004)
    assert table[2, 2, 0.002]["error"] == pytest.approx(10.5 * 0.002, rel=1e-6)
    assert table[2, 2, 0.002]["order"] == pytest.approx(1, abs=1e-6)
    own, _ = agreement.compare_trajectories(reference, reference, reference_step=1e-12)
    assert {row["time_step"] for row in own} == {0.5}
    assert all(row["parting_time"] == 12.5 for row in own)


@pytest.mark.parametrize("order", [15, 12])
def test_order_in_the_step_is_found_from_tolerances(order):
    rows = agreement.compare_tolerances(by_tolerance(order=order))
    assert len(rows) == 2 * 3 * (len(MADE_UP) - 1)
    for row in rows:
        assert (row["varied"], row["time_step"], row["members"]) == ("tolerance", 0.001, 3)
        assert row["tolerance"] == pytest.approx(row["step"] ** 14)
        if row["after_events"] == 0:
            assert row["error"] == 0 and np.isnan(row["order"])
        else:
            assert row["order"] == pytest.approx(order, abs=1e-3)
            assert row["order_error"] < 1e-2


def test_one_tolerance_or_none_has_no_order():
    assert agreement.compare_tolerances(trajectories([0.001])) == []
    assert agreement.compare_tolerances(by_tolerance([1e-10])) == []


def test_steps_are_those_of_the_scheme_or_those_that_the_tolerance_allows():
    chain = {"n_blocks": 2, "belt_velocity": 20.0}
    law = {name: QUANTITIES[name].default for name in ("noise", *LAW)}
    runs = {name: np.full(3, value) for name, value in (chain | law).items()}
    time = np.linspace(0, 40, 201)[:, None]
    positions = np.array([50.0, 100.0]) + 10 * np.sin(time)
    runs |= {
        "time_step": np.array([0.002, 0.001, 0.001]),
        "allowed_error": np.array([np.nan, 1e-10, 1e-4]),
        "positions": np.repeat(positions[None], 3, axis=0),
        "velocities": np.repeat(10 * np.cos(time) * np.ones((1, 201, 2)), 3, axis=0),
    }
    found = divergence.with_steps(runs)["step"]
    parameters = ChainParameters(**chain)
    samples_of_run = runs["positions"][0], runs["velocities"][0]
    assert found[0] == 0.002
    assert found[1:].tolist() == [mean_step(*samples_of_run, parameters, t) for t in (1e-10, 1e-4)]
    assert found[2] > found[1] > 0.01


# --- which quantities at which points ---


def points(seed, *, shift=0.0, runs=12):
    rng = np.random.default_rng(seed)
    grid = [(5, u, s) for u in (10.0, 30.0) for s in (1.0, 5.0) for _ in range(runs)]
    n_blocks, velocity, noise = (np.array(column) for column in zip(*grid, strict=True))
    size = len(grid)
    section = -20 + rng.standard_normal((size, 30))
    section[0] = np.nan
    return {
        "n_blocks": n_blocks,
        "belt_velocity": velocity,
        "noise": noise,
        "disorder_parameter": 0.1 + shift + 0.01 * rng.standard_normal(size),
        "mean_length": 600 + rng.standard_normal(size),
        "slip_count": np.tile(np.arange(10) * 100, (size, 1)) + rng.integers(0, 9, (size, 1)),
        "section_count": rng.integers(50, 60, size),
        "section_velocity": section,
    }


def catalogue(seed, runs=8):
    rng = np.random.default_rng(seed)
    slips = np.zeros(runs * 40, [("point", "i4"), ("block", "i4"), ("start_time", "f8"),
                                 ("stop_time", "f8"), ("start_position", "f8"),
                                 ("stop_position", "f8"), ("dissipated", "f8")])  # fmt: skip
    slips["point"] = np.repeat(np.arange(runs), 40)
    slips["block"] = 4 + np.arange(runs * 40) % 2
    slips["start_position"] = rng.exponential(50, slips.size)
    slips["dissipated"] = 30
    section = np.zeros(runs * 20, [("point", "i4"), ("velocities", "f8", 5)])
    section["point"] = np.repeat(np.arange(runs), 20)
    section["velocities"] = rng.standard_normal((section.size, 5))
    return {
        "n_blocks": np.full(runs, 5),
        "belt_velocity": np.ones(runs),
        "noise": np.zeros(runs),
        "slips": slips,
        "section": section,
    }


def escapes_of(seed, steps, *, stays=0.9, runs=24):
    rng = np.random.default_rng(seed)
    grid = [
        (u, spread, step)
        for u in (7.0, 25.0)
        for spread in (0.001, 1.0)
        for step in steps
        for _ in range(runs)
    ]
    velocity, spread, step = (np.array(column) for column in zip(*grid, strict=True))
    escaped = (rng.random(len(grid)) > stays) & (velocity > 20)
    return {
        "n_blocks": np.full(len(grid), 5),
        "belt_velocity": velocity,
        "noise": np.zeros(len(grid)),
        "initial_spread": spread,
        "time_step": step,
        "escaped": escaped,
        "lifetime": np.where(escaped, rng.uniform(0, 900, len(grid)), 1000.0),
        "final_disorder": np.where(escaped, 0.02, 0.12) + 1e-3 * rng.standard_normal(len(grid)),
        "final_stick_rate": np.where(escaped, 0, 0.1)[:, None] * np.ones(5),
    }


def test_statistics_of_runs():
    arrays = points(1)
    found = agreement.disorder_statistics(arrays, measured_time=100.0)
    assert found[agreement.DISORDER] is arrays["disorder_parameter"]
    rate = found["slips of the last block per time"]
    np.testing.assert_array_equal(rate, arrays["slip_count"][:, 4] / 100)
    assert np.isnan(found["v_N at the section, mean"][0])
    slips = catalogue(2)
    found = agreement.slip_statistics(slips)
    assert found["slips of the last block"].tolist() == [20] * 8
    own = slips["slips"][(slips["slips"]["point"] == 3) & (slips["slips"]["block"] == 5)]
    assert found["slip size, median"][3] == pytest.approx(np.median(own["start_position"]))
    assert found["v_N at section points, mean"][3] == pytest.approx(
        slips["section"]["velocities"][60:80, 4].mean()
    )


def test_families_are_judged_each_by_itself():
    rows = []
    for part, shift in (("disorder", 0.0), ("slips", 0.1)):
        sides = points(3), points(4, shift=shift)
        values = [agreement.disorder_statistics(side, measured_time=100.0) for side in sides]
        rows += [{"part": part} | row for row in agreement.compare_points(*sides, *values)]
    judged = agreement.judge(rows)
    assert len(judged) == len(rows) == 2 * 6 * 4
    table = {(row["part"], row["quantity"]): row for row in agreement.summarise(judged)}
    assert table["disorder", agreement.DISORDER][samples.AGREE] == 4
    assert table["slips", agreement.DISORDER][samples.DIFFER] == 4
    assert table["slips", "mean length"][samples.DIFFER] == 0
    assert all(row["points"] == 4 for row in table.values())


def test_attractors_are_compared_for_each_spread_and_step():
    tested, reference = escapes_of(5, [0.001, 0.002], stays=0.3), escapes_of(6, [0.001])
    rows = agreement.compare_attractors(tested, reference, reference_step=0.001)
    assert len(rows) == 2 * 2 * 2 * 3
    judged = agreement.judge([{"part": "attractors"} | row for row in rows])
    for row in judged:
        if row["quantity"] == agreement.STILL_STICKING:
            known = labels_of(tested)[
                (tested["belt_velocity"] == row["belt_velocity"])
                & (tested["initial_spread"] == row["initial_spread"])
                & (tested["time_step"] == row["time_step"])
            ]
            assert row["mean_tested"] == np.mean(known == STICK_SLIP)
            expected = samples.DIFFER if row["belt_velocity"] == 25 else samples.AGREE
            assert row["verdict"] == expected
        if row["quantity"] == agreement.LIFETIME and row["belt_velocity"] == 7:
            assert row["verdict"] == samples.UNKNOWN


# --- configuration ---


def plan(preset, **settings):
    return make_plan(CONFIG | {"preset": preset} | settings)


@pytest.mark.parametrize("preset", ["standard", "paper"])
def test_samples_are_as_large_as_promised(preset):
    datasets = plan(preset, method="event").datasets
    disorder = datasets["pairs_r_verlet"].values()
    assert len(disorder["belt_velocity"]) * len(disorder["noise"]) >= 24
    assert min(disorder["noise"]) > 0
    assert min(disorder["belt_velocity"]) < 15 and max(disorder["belt_velocity"]) > 30
    states = datasets["pairs_states_verlet"].values()
    assert min(len(each["replicate"]) for each in (disorder, states)) >= 32
    assert {0.002, 0.001, 0.0005} <= set(states["time_step"])
    for method in METHODS:
        assert 0.001 in datasets[f"pairs_paths_{method}"].values()["time_step"]
        assert 0.001 in datasets[f"pairs_states_{method}"].values()["time_step"]
    assert 1e-10 in datasets["pairs_paths_tolerances"].values()["tolerance"]


# --- from runs to tables, figures and page ---


HOW = {"preset": "smoke", "duration": 1000.0, "transient": 100.0, "seed": 1}


def made_up():
    """The datasets that all tables are derived from, made up; no chain slips in them."""
    paths = {
        "pairs_paths_verlet": trajectories([0.004, 0.002, 0.001]),
        "pairs_paths_event": trajectories([0.001, 0.002], slope=0.0),
        "pairs_paths_tolerances": by_tolerance(),
    }
    others = {
        f"pairs_{kind}_{method}": make(seed)
        for method, seed in (("verlet", 10), ("event", 20))
        for kind, make in (("r", points), ("slips", catalogue))
    }
    states = {
        "pairs_states_verlet": escapes_of(10, [0.004, 0.002, 0.001], stays=0.3),
        "pairs_states_event": escapes_of(20, [0.001, 0.002]),
    }
    return {
        name: Dataset(arrays, HOW | {"kind": "x", "method": _method(name)})
        for name, arrays in (paths | others | states).items()
    }


def _method(name):
    return "verlet" if name.endswith("verlet") else "event"


def derived(name, data):
    entry = registry.tables()[name]
    module = importlib.import_module(registry.tables()[name].module)
    return module.derive({used: data[used] for used in entry.uses})


@pytest.fixture(autouse=True)
def known_steps(monkeypatch):
    """Made-up trajectories bring their steps: there are no velocities to estimate them from."""

    def with_steps(runs):
        return runs if "step" in runs else original(runs)

    original = divergence.with_steps
    monkeypatch.setattr(divergence, "with_steps", with_steps)


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """The CSV files derived from made-up runs."""
    folder = tmp_path_factory.mktemp("agreement")
    data, paths = made_up(), {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(divergence, "with_steps", lambda runs: runs)
        for name in ("agreement", "families", "partings", "convergence"):
            paths[name] = folder / f"{name}.csv"
            derived(name, data).to_csv(paths[name], index=False)
    return page.Tables(paths.pop("agreement"), **paths)


def test_tables_have_a_row_for_each_comparison(tables):
    table = pd.read_csv(tables.comparisons)
    assert len(table) == 4 * 6 + 1 * 8 + 2 * 2 * 3 * 3
    assert set(table["verdict"]) <= set(samples.VERDICTS)
    assert set(table["tested"]) == {"verlet"} and set(table["reference"]) == {"event"}
    assert len(pd.read_csv(tables.families)) == 6 + 8 + 2 * 3 * 3
    assert set(pd.read_csv(tables.partings)["method"]) == {"verlet", "event"}
    errors = pd.read_csv(tables.convergence)
    assert errors.groupby(["method", "varied"]).size().to_dict() == {
        ("event", "time_step"): 2 * 3,
        ("event", "tolerance"): 2 * 3 * (len(MADE_UP) - 1),
        ("verlet", "time_step"): 2 * 3 * 3,
    }


def test_statistics_are_those_of_the_time_measured_and_of_the_finest_reference():
    """Rates of each side over its own settled time; its runs with the smallest step."""
    data = made_up()
    lengths = {"verlet": (1000.0, 100.0), "event": (640.0, 40.0)}
    for method, (duration, transient) in lengths.items():
        own = data[f"pairs_r_{method}"]
        changed = own.attributes | {"duration": duration, "transient": transient}
        data[f"pairs_r_{method}"] = Dataset(own.arrays, changed)
    table = derived("agreement", data).set_index(["part", "quantity", "belt_velocity", "noise"])
    counts = {
        "slips of the last block per time": lambda arrays: arrays["slip_count"][:, 4],
        "crossings of the section per time": lambda arrays: arrays["section_count"],
    }
    for quantity, counted in counts.items():
        row = table.loc[("disorder", quantity, 30.0, 5.0)]
        for role, method, time in (("tested", "verlet", 900.0), ("reference", "event", 600.0)):
            arrays = data[f"pairs_r_{method}"].arrays
            here = (arrays["belt_velocity"] == 30.0) & (arrays["noise"] == 5.0)
            assert row[f"mean_{role}"] == pytest.approx(counted(arrays)[here].mean() / time)
    final = table.loc[("attractors", agreement.FINAL_DISORDER, 25.0, 0.0)]
    arrays = data["pairs_states_event"].arrays
    for spread in (0.001, 1.0):
        here = (arrays["belt_velocity"] == 25.0) & (arrays["initial_spread"] == spread)
        here &= arrays["time_step"] == 0.001
        rows = final[final["initial_spread"] == spread]
        assert sorted(rows["time_step"]) == [0.001, 0.002, 0.004]
        np.testing.assert_allclose(
            rows["mean_reference"], arrays["final_disorder"][here].mean(), rtol=1e-12
        )


def test_trajectories_are_held_against_the_smallest_step_of_the_reference(tables):
    partings = pd.read_csv(tables.partings)
    steps = partings.groupby("method")["time_step"].unique()
    assert sorted(steps["verlet"]) == [0.001, 0.002, 0.004]
    # a run of the reference is not compared with itself
    assert list(steps["event"]) == [0.002]
    errors = pd.read_csv(tables.convergence)
    by_step = errors[(errors["method"] == "event") & (errors["varied"] == "time_step")]
    assert set(by_step["time_step"]) == {0.002}


@pytest.mark.parametrize("name", registry.tables())
def test_tables_explain_columns_that_they_have(name, tables):
    if name not in ("agreement", "families", "partings", "convergence"):
        return
    path = tables.comparisons if name == "agreement" else getattr(tables, name)
    assert set(registry.tables()[name].columns) <= set(pd.read_csv(path))


def test_page_says_what_the_tables_say(tables):
    settings = plan("smoke").settings()
    found = page.describe(tables, settings)
    words = {part["title"]: " ".join(part["sentences"]) for part in found["parts"]}
    assert "agree at 4 of 4 points" in words["With noise"]
    assert "falls as dt to the power 1.00" in words["Trajectories without noise"]
    assert (
        "falls as its mean step to the power 15.0 at u = 20" in words["Trajectories without noise"]
    )
    end = words["Attractors and lifetimes without noise"]
    assert "differ at u = 25" in end
    assert "does not hold at 2 of 4 points" in end
    assert "also from the most distant states" in end
    table = pd.read_csv(tables.comparisons)
    assert len(found["families"]) == len(pd.read_csv(tables.families))
    assert len(found["comparisons"]) == table["quantity"].isin(page.SHOWN).sum()


@pytest.mark.thorough
def test_page_is_a_section_of_the_report(tables, tmp_path):
    settings = plan("smoke").settings()
    claims, estimates, image = (
        tmp_path / name for name in ("claims.csv", "estimates.csv", "image.png")
    )
    measured = measure({}, settings)
    measured.claims.to_csv(claims, index=False)
    measured.estimates.to_csv(estimates, index=False)
    names = [module.__name__.rpartition(".")[2] for module in FIGURES]
    images = [image.with_stem(name) for name in names]
    for path in images:
        path.write_bytes(PIXEL)
    files = {name: [path] for name, path in vars(tables).items()}
    files["agreement"] = files.pop("comparisons")
    files |= {"claims": [claims], "estimates": [estimates], "figures": images}
    report.render(
        tmp_path / "report.html", report.Material("smoke", settings, files, tmp_path / "none")
    )
    rendered = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert {"agreement", *names} <= set(rendered.identifiers)
    assert len(rendered.images) == len(names)
    assert "#agreement" in rendered.addresses


def test_page_draws_no_conclusion_of_its_own(tables, tmp_path):
    """The same tables with all verdicts turned to agreement give the opposite sentence."""
    table = pd.read_csv(tables.comparisons)
    table["verdict"] = samples.AGREE
    turned = tmp_path / "turned.csv"
    table.to_csv(turned, index=False)
    settings = plan("smoke").settings()
    other = page.Tables(turned, tables.families, tables.partings, tables.convergence)
    sentences = page.describe(other, settings)["parts"][-1]["sentences"]
    assert "nothing speaks against" in sentences[-1]


def drawn_from(module, data):
    """The datasets and tables that a figure uses."""
    tables = registry.tables()
    return {
        name: derived(name, data) if name in tables else data[name] for name in module.FIGURE.uses
    }


@pytest.mark.thorough
@pytest.mark.parametrize("module", FIGURES)
def test_figures_draw_and_repeat(module, tmp_path):
    data, datasets = drawn_from(module, made_up()), list(made_up().values())
    written = []
    for name in ("first", "second"):
        figure = module.draw(data, style.small_print(datasets, "smoke"))
        (tmp_path / name).mkdir()
        style.save(figure, tmp_path / name / "a.png", tmp_path / name / "a.pdf")
        written.append((tmp_path / name / "a.png").read_bytes())
        assert all(axes.has_data() for axes in figure.axes)
    assert written[0] == written[1]
    first, second, *_ = module.FIGURE.uses
    with pytest.raises(InputError, match=second):
        module.draw({first: data[first]}, "")


@pytest.mark.parametrize(("tolerances", "drawn"), [([1e-10], False), ([1e-4, 1e-10], True)])
def test_few_tolerances_are_drawn_or_missed(tolerances, drawn):
    data = made_up()
    data["pairs_paths_tolerances"] = Dataset(by_tolerance(tolerances), HOW | {"method": "event"})
    figure = agreement_trajectories.draw(drawn_from(agreement_trajectories, data), "")
    assert bool(figure.axes[3].lines) == drawn
    assert bool(figure.axes[3].texts) != drawn


def run(name, n_replicates=2, **changes):
    """Arrays of the first points of a dataset of the smoke preset, of shorter runs."""
    dataset = plan("smoke").datasets[name]
    short = {"duration": 20.0, "transient": 5.0, "settle_time": 5.0, "section_values": 10}
    settings = dataset.settings | {
        key: min(value, dataset.settings[key])
        for key, value in short.items()
        if key in dataset.settings
    }
    chosen = [point._replace(**changes) for point in dataset.points]
    chosen = [point for point in dict.fromkeys(chosen) if point.replicate < n_replicates]
    return record(dataset.kind.name, chosen, settings)


@pytest.mark.thorough
@pytest.mark.parametrize("part", ["paths", "r", "slips", "states"])
def test_runs_have_a_row_for_each_point_and_the_arrays_of_their_kind(part):
    name = f"pairs_{part}_verlet"
    arrays, dataset = run(name), plan("smoke").datasets[name]
    count = len([point for point in dataset.points if point.replicate < 2])
    assert len(arrays["n_blocks"]) == count
    optional = {"positions", "velocities", "friction"}
    assert set(dataset.kind.arrays) - optional == set(arrays) - optional
    for array in KINDS[dataset.kind.name].arrays.values():
        if array.fields:
            assert set(array.fields) == set(arrays[array.name].dtype.names)
        elif array.name in arrays:
            assert arrays[array.name].ndim == len(array.dimensions)


@pytest.mark.thorough
def test_paths_begin_in_the_same_states():
    first = []
    for method in METHODS:
        arrays = run(f"pairs_paths_{method}", time_step=0.001)
        first.append(arrays["positions"][:, 0])
        order = np.lexsort((arrays["events"]["time"], arrays["events"]["point"]))
        assert (np.diff(order) > 0).all()
    np.testing.assert_array_equal(first[0][:, :2], first[1][:, :2])
    assert not np.array_equal(first[0][0], first[0][1])


def test_errors_fall_with_the_tolerance():
    """From runs to rows, by the integrator that has a tolerance."""
    arrays = run("pairs_paths_tolerances", n_replicates=4, n_blocks=2)
    assert set(arrays["allowed_error"]) == {1e-2, 1e-4, 1e-6, TOLERANCES["event"], 1e-14}
    rows = agreement.compare_tolerances(divergence.with_steps(arrays))
    rows = [row for row in rows if row["after_events"] == 5]
    assert [row["tolerance"] for row in rows] == [1e-2, 1e-4, 1e-6, 1e-10]
    errors, mean_steps = ([row[name] for row in rows] for name in ("error", "step"))
    assert errors[0] > 30 * errors[1] > 900 * errors[2] > 0
    assert errors[3] < 1e-11
    assert mean_steps == sorted(mean_steps, reverse=True)
    assert 12 < rows[0]["order"] < 18
