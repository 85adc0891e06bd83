"""Comparison of integrators: tests with known answers and error rates, and its tables."""

import itertools
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from beltrepro.base.store import Dataset
from beltrepro.model import ChainParameters
from beltrepro.observe.slips import SLIP
from beltrepro.replication.plan import registry
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.kinds import record
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import LAW, QUANTITIES
from beltrepro.replication.studies.integrators import agreement_trajectories, divergence, samples
from beltrepro.replication.studies.integrators import measure as integrators
from beltrepro.replication.studies.integrators.steps import mean_step
from beltrepro.replication.studies.transition.transients import STICK_SLIP, labels_of
from beltrepro.simulation import TOLERANCES

RNG = np.random.default_rng
CONFIG = load_config(Path(__file__).parents[2] / "config.yaml")
METHODS = ("verlet", "event")


def within(rate, expected, trials, sigmas=4.0):
    """A counted rate is what it should be, to some standard errors of the count."""
    return abs(rate - expected) <= sigmas * np.sqrt(expected * (1 - expected) / trials)


# --- two samples ----------------------------------------------------------------------------------


def test_a_comparison_of_samples_by_formulas_of_their_own():
    rng = RNG(8)
    one, two = rng.normal(5, 1, 12), rng.normal(6, 3, 7)
    row = samples.compare_samples([*one, np.nan], two)
    variance = [np.var(side, ddof=1) / side.size for side in (one, two)]
    z = (one.mean() - two.mean()) / math.sqrt(sum(variance))
    degrees = sum(variance) ** 2 / (variance[0] ** 2 / 11 + variance[1] ** 2 / 6)
    # area between the distribution functions, over the root mean square of the reference
    edges = np.sort(np.concatenate([one, two]))
    gap = [np.mean(one <= x) - np.mean(two <= x) for x in edges[:-1]]
    area = np.sum(np.abs(gap) * np.diff(edges))
    assert row == {
        "n_tested": 12,
        "n_reference": 7,
        "mean_tested": pytest.approx(one.mean()),
        "mean_reference": pytest.approx(two.mean()),
        "error_tested": pytest.approx(math.sqrt(variance[0])),
        "error_reference": pytest.approx(math.sqrt(variance[1])),
        "z": pytest.approx(z),
        "mean_p": pytest.approx(2 * stats.t.sf(abs(z), degrees)),
        "test": "Kolmogorov-Smirnov",
        "p": pytest.approx(stats.ks_2samp(one, two, method="exact").pvalue),
        "distance": pytest.approx(area / math.sqrt(np.mean(two**2))),
    }
    # of the C(16, 8) ways to mix two samples of 8, two keep them apart
    assert samples.compare_samples(np.arange(8), np.arange(8) + 9)["p"] == pytest.approx(2 / 12870)


def test_five_runs_are_a_sample_and_four_are_not():
    assert np.isfinite(samples.compare_samples(np.arange(5), np.arange(5) + 0.5)["z"])
    for sizes in ((4, 5), (5, 4)):
        one, two = (np.arange(size, dtype=float) for size in sizes)
        row = samples.compare_samples(one, two)
        assert np.isnan([row["p"], row["z"], row["mean_p"]]).all()
        shares = samples.compare_shares(one > 1, two > 1, labels=(True, False), counted=True)
        assert np.isnan([shares["p"], shares["z"]]).all()
        assert shares["mean_tested"] == np.mean(one > 1)
    alone = samples.compare_samples([1.0], [2.0, 3.0])
    assert np.isnan(alone["error_tested"]) and alone["error_reference"] == pytest.approx(0.5)
    assert np.isnan(samples.compare_samples([1.0, 2.0], [0.0, 0.0])["distance"])
    empty = samples.compare_samples([], [1.0] * 8)
    assert empty["n_tested"] == 0 and np.isnan(empty["distance"])


def test_runs_that_do_not_differ_are_no_test_of_the_means():
    same = samples.compare_samples(np.ones(8), np.ones(8))
    assert (same["z"], same["p"]) == (0, 1) and np.isnan(same["mean_p"])
    for one, z in ((1.0, np.inf), (-1.0, -np.inf)):
        other = samples.compare_samples(np.full(8, one), np.zeros(8))
        assert (other["z"], other["mean_p"]) == (z, 0)


def test_the_p_of_shares_is_that_of_all_tables_with_the_same_margins():
    """Three labels: every table of the hypergeometric law, with its chi^2, counted out."""
    tested, reference = [0] * 5 + [1] * 2 + [2] * 3, [0] * 2 + [1] * 6 + [2] * 2
    total = np.array([7, 8, 5])

    def chi2(first):
        rows = np.array([first, total - first])
        expected = np.outer(rows.sum(axis=1), total) / 20
        return np.sum((rows - expected) ** 2 / expected)

    observed, exact = chi2(np.array([5, 2, 3])), 0.0
    for a, b in itertools.product(range(8), range(9)):
        first = np.array([a, b, 10 - a - b])
        if 0 <= first[2] <= 5:
            ways = zip(total.tolist(), first.tolist(), strict=True)
            chance = math.prod(math.comb(n, k) for n, k in ways)
            exact += (chi2(first) >= observed - 1e-9) * chance / math.comb(20, 10)
    row = samples.compare_shares(tested, reference, labels=(0, 1, 2, 3), counted=0)
    assert row["p"] == pytest.approx(exact, abs=4 * math.sqrt(exact / 9999))
    assert row["distance"] == pytest.approx((0.3 + 0.4 + 0.1) / 2)
    assert (row["mean_tested"], row["mean_reference"]) == (0.5, 0.2)
    # never less than one in the number of draws and one
    apart = samples.compare_shares([0] * 40, [1] * 40, labels=(0, 1), counted=0, n_permutations=99)
    assert apart["p"] == pytest.approx(0.01)


def test_lifetimes_need_five_escapes_on_both_sides_together():
    time = np.arange(1.0, 7)
    left = np.array([True, True, False, False, False, False])
    more = np.array([True, True, True, False, False, False])
    assert np.isfinite(samples.compare_lifetimes(time, time + 1, left, more)["p"])
    row = samples.compare_lifetimes(time, time, left, left)
    assert np.isnan(row["p"]) and row["distance"] == 0 and row["mean_tested"] == 3.5


def test_the_log_rank_test_by_hand():
    """Sum of observed minus expected escapes at each instant, over its hypergeometric variance."""
    rng = RNG(9)
    sides = [rng.exponential(tau, size) for tau, size in ((30.0, 15), (60.0, 11))]
    escaped = [side < 50 for side in sides]
    sides = [np.minimum(side, 50.0) for side in sides]
    difference, variance = 0.0, 0.0
    for instant in np.sort(np.concatenate([s[e] for s, e in zip(sides, escaped, strict=True)])):
        risk = [np.sum(side >= instant) for side in sides]
        difference += np.any(sides[0][escaped[0]] == instant) - risk[0] / sum(risk)
        variance += risk[0] * risk[1] / sum(risk) ** 2
    p = 2 * stats.norm.sf(abs(difference) / math.sqrt(variance))
    assert samples.compare_lifetimes(*sides, *escaped)["p"] == pytest.approx(p)


@pytest.mark.thorough
def test_samples_shares_and_lifetimes_are_rejected_at_the_stated_rate():
    rng, trials = RNG(1), 600
    rows = [samples.compare_samples(*rng.standard_normal((2, 32))) for _ in range(trials)]
    assert within(np.mean([row["mean_p"] < 0.05 for row in rows]), 0.05, trials)
    # exact, but the statistic has few values: the rate is the next one below the level
    possible = [stats.ks_2samp(range(32), np.arange(32) + k + 0.5).pvalue for k in range(33)]
    level = max(p for p in possible if p < 0.05)
    assert within(np.mean([row["p"] < 0.05 for row in rows]), level, trials)
    times = rng.exponential(80.0, (300, 2, 40))
    rows = [samples.compare_lifetimes(*np.minimum(pair, 100.0), *(pair < 100)) for pair in times]
    assert within(np.mean([row["p"] < 0.05 for row in rows]), 0.05, 300)
    how = {"labels": (0, 1, 2), "counted": 0, "n_permutations": 399}
    labels = rng.choice(3, (300, 2, 40), p=(0.7, 0.25, 0.05))
    rate = np.mean([samples.compare_shares(*pair, **how)["p"] <= 0.05 for pair in labels])
    assert rate < 0.05 + 4 * np.sqrt(0.05 * 0.95 / 300)


# --- many tests -----------------------------------------------------------------------------------


def test_holm_by_hand_and_the_error_of_a_family():
    corrected = samples.holm([0.01, 0.04, 0.03, 0.005, np.nan])
    np.testing.assert_allclose(corrected, [0.03, 0.06, 0.06, 0.02, np.nan])
    np.testing.assert_allclose(samples.holm([0.001, 0.5, 0.4]), [0.003, 0.8, 0.8])
    assert samples.holm([0.02, 0.03, 0.02]).tolist() == [0.06, 0.06, 0.06]
    assert samples.holm([0.9, 0.8]).tolist() == [1, 1] and samples.holm([]).size == 0
    wrong = [np.nanmin(samples.holm(row)) < 0.05 for row in RNG(5).random((2000, 28))]
    assert within(np.mean(wrong), 0.05, 2000)


def test_verdicts():
    differ, close = samples.DIFFER, samples.CLOSE
    for corrected_p, distance, word in (
        *((0.05, 1.0, samples.AGREE), (0.049, 0.01, differ), (0.049, np.nan, differ)),
        *((0.0, 0.0099, close), (np.nan, 0.0, samples.UNKNOWN)),
    ):
        assert samples.verdict(corrected_p, distance) == word


def comparison(mean_p=0.5, tested=2.0, reference=1.0, **other):
    """A row whose numbers are all different."""
    row = {"n_tested": 8, "n_reference": 9, "mean_tested": tested, "error_tested": 0.3,
           "mean_reference": reference, "error_reference": 0.4, "z": 5.0, "mean_p": mean_p,
           "test": "KS", "p": 0.6, "distance": 0.1}  # fmt: skip
    row |= {"tested": "one", "reference": "two"}
    return row | other


def test_an_overall_test_by_hand():
    rows = [comparison(0.2, 11.0, 10.0), comparison(0.9, 4.0, 5.0), comparison(0.4, 1.0, 0.0)]
    together = samples.overall([*rows, comparison(np.nan, 100.0, 1.0)])
    chi2 = sum(stats.norm.ppf(p / 2) ** 2 for p in (0.2, 0.9, 0.4))
    assert together == {
        "degrees": 3,
        "chi2": pytest.approx(chi2),
        "chi2_p": pytest.approx(stats.chi2(3).sf(chi2)),
        # the ordered p are 0.2, 0.4, 0.9: farthest from uniform by 2/3 - 0.4
        "uniform_p": pytest.approx(stats.kstwo.sf(2 / 3 - 0.4, 3)),
        "shift": pytest.approx((0.1 - 0.2) / 2),
        "shift_error": pytest.approx(math.hypot(0.5 / 10, 0.5 / 5) / 2),
    }
    none = samples.overall([comparison(0.5, 1.0, 0.0)])
    assert none["degrees"] == 1 and np.isnan([none["shift"], none["shift_error"]]).all()
    assert samples.overall([])["degrees"] == 0


@pytest.mark.thorough
def test_overall_tests_have_the_stated_rate():
    rng = RNG(6)

    def family():
        sides = 5 + rng.standard_normal((24, 2, 16))
        return samples.overall([samples.compare_samples(*pair) for pair in sides])

    together = [family() for _ in range(60)]
    for name in ("chi2_p", "uniform_p"):
        assert stats.kstest([one[name] for one in together], "uniform").pvalue > 1e-3
    scores = np.array([one["shift"] / one["shift_error"] for one in together])
    assert abs(scores.mean()) < 0.6 and 0.6 < scores.std() < 1.5


def test_largest_of_many():
    assert samples.largest_of(1) == pytest.approx(1.95996, abs=1e-4)
    largest = np.abs(RNG(7).standard_normal((2000, 28))).max(axis=1)
    assert within(np.mean(largest > samples.largest_of(28)), 0.05, 2000)


# --- trajectories ---------------------------------------------------------------------------------

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
    assert divergence.match_events(events([1.0, 2.0], first="stick"), reference)[0].size == 0
    assert divergence.match_events(reference[:0], reference)[0].size == 0
    for later, shared in ((0.499, 4), (-0.499, 4), (0.5, 1), (-0.5, 1)):
        moved = events([1.0, 2.0 + later, 3.0, 4.0])
        assert divergence.match_events(moved, reference)[0].size == shared
    # events of other blocks may come in another order
    reference = np.concatenate([events([1.0, 3.0]), events([1.01, 2.0], block=2)])
    tested = np.concatenate([events([1.02, 3.0]), events([1.0, 2.0], block=2)])
    time, shift = divergence.match_events(tested, reference)
    np.testing.assert_allclose(time, [1, 1.01, 2, 3])
    np.testing.assert_allclose(shift, [0.02, -0.01, 0, 0])


def pair(separation, event_times, shifts=()):
    return divergence.Pair(
        time=np.arange(len(separation), dtype=float),
        separation=np.array(separation, dtype=float),
        event_time=np.arange(len(shifts), dtype=float),
        event_shift=np.array(shifts, dtype=float),
        reference_events=np.array(event_times, dtype=float),
    )


def test_errors_after_events_by_hand():
    one = pair([0, 0.1, 0.2, 0.5, 1.0, 1.01], [1.0, 2.5, 5.0])
    assert one.parting_time == 5  # beyond 1, not at 1
    # the sample after an event, not the one at it; none after the last
    np.testing.assert_array_equal(
        [one.error_after(n) for n in range(5)], [0, 0.2, 0.5, np.nan, np.nan]
    )
    assert pair([0.3, 0.7, 0.2], []).error_after(0) == 0.7
    assert pair([0.3], [0.0]).error_after(0) == 0
    assert pair([0, 1, 0.5], []).parting_time == np.inf
    # root mean square, where all members have one
    rows = divergence._errors({"at": 7}, [pair([0, 3, 3], [0.5, 1.5]), pair([0, 4, 9], [0.5])])
    after = {row["after_events"]: row["error"] for row in rows}
    assert after == {0: 0.0, 1: pytest.approx(math.sqrt((9 + 16) / 2))}
    assert all((row["at"], row["members"]) == (7, 2) for row in rows)


def test_a_summary_takes_medians_over_members():
    members = [
        pair([0, 2], [0.5], shifts=[0.1] * 10 + [-9.0]),
        pair([0, 0, 2], [0.5, 0.6, 0.7], shifts=[-0.3]),
        pair([0, 0, 0], [0.5] * 8, shifts=[0.2, 0.0]),
    ]
    medians = {"parting_time": 2, "shared_events": 2, "reference_events": 3}
    shifts = {"first_shift": 0.2, "shift": 0.3}
    assert divergence._summary(members) == {"members": 3} | medians | shifts
    assert np.isnan(divergence._summary([pair([0], [])])["shift"])


def test_order_of_convergence_is_that_of_the_errors_above_rounding():
    steps = np.array([4e-3, 2e-3, 1e-3, 5e-4])
    for order in (1.0, 2.0, 0.5):
        assert divergence.convergence_order(steps, 7 * steps**order) == pytest.approx((order, 0))
        scores = []
        for noise in np.exp(0.1 * RNG(8).standard_normal((400, 4))):
            fitted, error = divergence.convergence_order(steps, 7 * steps**order * noise)
            scores.append((fitted - order) / error)
        assert stats.kstest(scores, stats.t(2).cdf).pvalue > 1e-3
    assert np.isnan(divergence.convergence_order(steps[:2], [1, 2])[0])
    assert np.isnan(divergence.convergence_order(steps[:3], [1e-12, 1, 2])[0])
    for first, order in ((0.8e-9, 2), (1.2e-9, 11)):
        fitted, _ = divergence.convergence_order(steps[::-1], [first, 4, 16, 64])
        assert fitted == pytest.approx(order, abs=0.5)
    assert divergence.convergence_order(steps[::-1], [1e-12, 4, 16, 64], rounding=1e-13)[0] > 10


def trajectories(steps, *, slope=1.0, members=3):
    """Chains of 2 and 1 blocks whose error grows linearly from the first event, at t = 10, on."""
    time = np.arange(0.0, 40.5, 0.5)
    rows = [(n, 20.0, m, step) for n in (1, 2) for step in steps for m in range(members)]
    n_blocks, velocity, member, step = (np.array(column) for column in zip(*rows, strict=True))
    drift = slope * np.maximum(time - 10, 0)
    positions = 50.0 + time + member[:, None] + step[:, None] * drift
    positions = np.repeat(positions[..., None], 2, axis=2)
    positions[n_blocks == 1, :, 1] = np.nan
    recorded = [events([10.0, 20 + s, 30 + 2 * s], run=run) for run, s in enumerate(step)]
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
        "events": np.concatenate(recorded),
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
    partings = divergence.partings(trajectories(steps), reference)
    errors = divergence.errors_by_step(trajectories(steps), reference)
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
    # a run of the reference is not compared with itself
    partings = divergence.partings(reference, reference)
    assert {row["time_step"] for row in partings} == {0.5}
    assert all(row["parting_time"] == 12.5 for row in partings)


@pytest.mark.parametrize("order", [15, 12])
def test_order_in_the_step_is_found_from_tolerances(order):
    rows = divergence.errors_by_tolerance(by_tolerance(order=order))
    assert len(rows) == 2 * 3 * (len(MADE_UP) - 1)
    for row in rows:
        assert (row["varied"], row["time_step"], row["members"]) == ("tolerance", 0.001, 3)
        assert row["tolerance"] == pytest.approx(row["step"] ** 14)
        if row["after_events"] == 0:
            assert row["error"] == 0 and np.isnan(row["order"])
        else:
            assert row["order"] == pytest.approx(order, abs=1e-3) and row["order_error"] < 1e-2
    assert divergence.errors_by_tolerance(trajectories([0.001])) == []
    assert divergence.errors_by_tolerance(by_tolerance([1e-10])) == []


def test_steps_are_those_of_the_scheme_or_those_that_the_tolerance_allows():
    chain = {"n_blocks": 2, "belt_velocity": 20.0}
    law = {name: QUANTITIES[name].default for name in ("noise", *(one.name for one in LAW))}
    runs = {name: np.full(3, value) for name, value in (chain | law).items()}
    time = np.linspace(0, 40, 201)[:, None]
    positions = np.array([50.0, 100.0]) + 10 * np.sin(time)
    runs |= {
        "time_step": np.array([0.002, 0.001, 0.001]),
        "allowed_error": np.array([np.nan, 1e-10, 1e-4]),
        "positions": np.repeat(positions[None], 3, axis=0),
        "velocities": np.repeat(10 * np.cos(time) * np.ones((1, 201, 2)), 3, axis=0),
    }
    steps = divergence.with_steps(runs)["step"]
    motion = runs["positions"][0], runs["velocities"][0], ChainParameters(**chain)
    assert steps[0] == 0.002 and steps[2] > steps[1] > 0.01
    assert steps[1:].tolist() == [mean_step(*motion, tolerance) for tolerance in (1e-10, 1e-4)]


# --- from datasets to tables ----------------------------------------------------------------------


def scan_of(points, seed, replicates):
    """Arrays of a scan: so many replicates of each point (N, u, sigma), in any order."""
    rng = RNG(seed)
    rows = [point for point in points for _ in range(replicates)]
    rng.shuffle(rows)
    n_blocks, u, noise = (np.array(column) for column in zip(*rows, strict=True))
    section = rng.normal(-20, 3, (len(rows), 9))
    section[:, 6:] = np.nan
    section[1] = np.nan
    return {
        "n_blocks": n_blocks,
        "belt_velocity": u,
        "noise": noise,
        "disorder_parameter": 0.1 + 0.01 * rng.standard_normal(len(rows)),
        "mean_length": rng.normal(600, 9, len(rows)),
        "slip_count": rng.integers(0, 99, (len(rows), 10)),
        "section_count": rng.integers(50, 60, len(rows)),
        "section_velocity": section,
    }


def catalogue(seed, n_blocks):
    """Slips and section points of all runs but the last."""
    rng, count = RNG(seed), len(n_blocks) - 1
    slips, section = np.zeros(300, SLIP), np.zeros(50, [("point", "i4"), ("velocities", "f8", 3)])
    slips["point"], slips["block"] = rng.integers(0, count, 300), rng.integers(1, 4, 300)
    for name in ("start_position", "stop_position", "dissipated"):
        slips[name] = rng.random(300)
    section["point"], section["velocities"] = rng.integers(0, count, 50), rng.random((50, 3))
    points = {"belt_velocity": np.ones(count + 1), "noise": np.zeros(count + 1)}
    return {"slips": slips, "section": section, "n_blocks": np.array(n_blocks)} | points


def ends(seed, *, steps, runs, spreads=(1e-3, 1.0)):
    """Arrays of kind escapes at two belt velocities, in an order of their own."""
    rng = RNG(seed)
    rows = list(itertools.product((7.0, 25.0), spreads, steps, range(runs)))
    rng.shuffle(rows)
    u, spread, step, _ = (np.array(column) for column in zip(*rows, strict=True))
    escaped = (rng.random(u.size) < 0.5) & (u > 20)
    return {
        "n_blocks": np.full(u.size, 5),
        "belt_velocity": u,
        "noise": np.zeros(u.size),
        "initial_spread": spread,
        "time_step": step,
        "escaped": escaped,
        "lifetime": np.where(escaped, rng.uniform(0, 900, u.size), 1000.0),
        "final_disorder": rng.random(u.size) / 10,
        "final_stick_rate": rng.integers(0, 2, (u.size, 5)) / 10,
    }


@pytest.fixture(scope="module")
def made_up():
    """The datasets of all tables; the sides differ in length, number and order of runs."""
    shared = [(5, 10.0, 1.0), (5, 30.0, 1.0), (7, 10.0, 5.0)]
    arrays = {
        "pairs_paths_verlet": trajectories([0.004, 0.002, 0.001]),
        "pairs_paths_event": trajectories([0.001, 0.002], slope=0.0),
        "pairs_paths_tolerances": by_tolerance(),
        "pairs_r_verlet": scan_of([*shared, (5, 50.0, 1.0)], 19, 6),
        "pairs_r_event": scan_of([(9, 9.0, 9.0), *shared], 20, 9),
        "pairs_slips_verlet": catalogue(10, [3, 2, 2, 3, 3, 2]),
        "pairs_slips_event": catalogue(20, [2, 3, 2, 3, 3, 3, 3, 2]),
        "pairs_states_verlet": ends(21, steps=(0.004, 0.002, 0.001), runs=7),
        "pairs_states_event": ends(22, steps=(0.002, 0.001), runs=11),
    }
    lengths = {"verlet": (1000.0, 100.0), "event": (640.0, 40.0), "tolerances": (1.0, 0.0)}
    made = {}
    for name, columns in arrays.items():
        side = name.rpartition("_")[2]
        about = dict(zip(("duration", "transient"), lengths[side], strict=True))
        made[name] = Dataset(columns, about | {"method": side.replace("tolerances", "event")})
    return made


@pytest.fixture(scope="module")
def tables(made_up):
    """All tables; made-up trajectories bring their steps."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(divergence, "with_steps", lambda runs: runs)
        return {name: getattr(integrators, name)(made_up) for name in integrators.TABLES}


def numbers_of_scan(side, run):
    arrays, time = side.arrays, side.attributes["duration"] - side.attributes["transient"]
    velocities = arrays["section_velocity"][run][:6]
    rates = [arrays["slip_count"][run, arrays["n_blocks"][run] - 1] / time]
    rates += [arrays["section_count"][run] / time]
    names = ("disorder_parameter", "mean_length")
    return [*(arrays[name][run] for name in names), *rates, velocities.mean(), velocities.std()]


def numbers_of_catalogue(side, run):
    arrays, last = side.arrays, side.arrays["n_blocks"][run]
    slips = arrays["slips"]
    slips = slips[(slips["point"] == run) & (slips["block"] == last)]
    size = slips["start_position"] - slips["stop_position"]
    v = arrays["section"]["velocities"][arrays["section"]["point"] == run][:, last - 1]
    if not size.size:
        return [0, *4 * [np.nan], 0, np.nan, np.nan]
    lost = slips["dissipated"].mean()
    return [size.size, size.mean(), *np.percentile(size, [50, 90]), lost, v.size, v.mean(), v.std()]


def numbers_of_ends(side, run):
    sticks = labels_of(side.arrays)[run] == STICK_SLIP
    return [sticks, side.arrays["final_disorder"][run], side.arrays["lifetime"][run]]


@pytest.mark.parametrize(
    ("part", "name", "numbers", "points"),
    [
        ("disorder", "pairs_r", numbers_of_scan, 3),
        ("slips", "pairs_slips", numbers_of_catalogue, 2),
        ("attractors", "pairs_states", numbers_of_ends, 2 * 2 * 3),
    ],
)
def test_each_row_compares_the_runs_of_both_sides_at_its_point(
    made_up, tables, part, name, numbers, points
):
    """By plain loops, run by run; of the attractors the reference has its smallest step."""
    table = tables["agreement"][tables["agreement"]["part"] == part]
    place = ["n_blocks", "belt_velocity", "noise"]
    place += ["initial_spread", "time_step"] * (part == "attractors")
    assert table.groupby(place).ngroups == points
    for point, rows in table.groupby(place):
        for role, method in zip(("tested", "reference"), METHODS, strict=True):
            side = made_up[f"{name}_{method}"]
            here = dict(zip(place, point, strict=True))
            if part == "attractors" and role == "reference":
                here["time_step"] = 0.001
            runs = range(side.arrays["n_blocks"].size)
            there = [k for k in runs if all(side.arrays[q][k] == here[q] for q in here)]
            values = np.array([numbers(side, run) for run in there], dtype=float)
            assert len(rows) == values.shape[1] and (rows[role] == method).all()
            counts = np.isfinite(values).sum(axis=0)
            np.testing.assert_array_equal(rows[f"n_{role}"], counts)
            np.testing.assert_allclose(rows[f"mean_{role}"], np.nanmean(values, axis=0))
            error = np.nanstd(values, axis=0, ddof=1) / np.sqrt(counts)
            np.testing.assert_allclose(rows[f"error_{role}"], error)


def test_the_attractors_are_tested_by_lifetimes_with_the_runs_that_escaped(made_up, tables):
    table = tables["agreement"].set_index(["quantity", "belt_velocity", "initial_spread"])
    rows = table.loc[(integrators.LIFETIME, 25.0, 1.0)]
    for _, row in rows.iterrows():
        sides = []
        for method, step in zip(METHODS, (row["time_step"], 0.001), strict=True):
            side = made_up[f"pairs_states_{method}"].arrays
            here = (side["belt_velocity"] == 25) & (side["initial_spread"] == 1)
            here &= side["time_step"] == step
            sides.append((side["lifetime"][here], side["escaped"][here]))
        (one, gone), (other, went) = sides
        assert row["p"] == samples.compare_lifetimes(one, other, gone, went)["p"]


def test_families_are_judged_each_by_itself():
    def row(p, distance, quantity="q", runs=9):
        return comparison(p=p, distance=distance, n_reference=runs, part="a", quantity=quantity)

    rows = [row(0.01, 0.5), row(0.02, 0.001), row(0.9, 0.9, runs=7), row(np.nan, np.nan)]
    judged = integrators.judge([*rows, row(0.04, 0.02, quantity="other")])
    assert [one["corrected_p"] for one in judged[:3]] == pytest.approx([0.03, 0.04, 0.9])
    assert judged[4]["corrected_p"] == 0.04  # a family of its own
    verdicts = [samples.DIFFER, samples.CLOSE, samples.AGREE, samples.UNKNOWN, samples.DIFFER]
    assert [one["verdict"] for one in judged] == verdicts
    first, second = integrators.summarise(judged)
    assert (first["part"], first["quantity"], first["time_step"]) == ("a", "q", None)
    assert (first["points"], first["runs"], first["test"]) == (4, 7, "KS")
    assert [first[name] for name in samples.VERDICTS] == [1, 1, 1, 1]
    assert first["smallest_p"] == pytest.approx(0.03) and first["largest_distance"] == 0.9
    assert first["degrees"] == 4 and first["shift"] == pytest.approx(1.0)
    assert (second["points"], second["smallest_p"]) == (1, 0.04)
    assert (second["tested"], second["reference"]) == ("one", "two")


def test_trajectories_have_a_row_for_each_point_and_step(tables):
    assert len(tables["families"]) == 6 + 8 + 2 * 3 * 3
    steps = tables["partings"].groupby("method")["time_step"].unique()
    assert sorted(steps["verlet"]) == [0.001, 0.002, 0.004] and list(steps["event"]) == [0.002]
    assert tables["convergence"].groupby(["method", "varied"]).size().to_dict() == {
        ("event", "time_step"): 2 * 3,
        ("event", "tolerance"): 2 * 3 * (len(MADE_UP) - 1),
        ("verlet", "time_step"): 2 * 3 * 3,
    }
    for name, entry in registry.tables().items():
        assert name not in tables or set(entry.columns) <= set(tables[name]), name


# --- pages and runs -------------------------------------------------------------------------------


@pytest.mark.parametrize(("tolerances", "drawn"), [([1e-10], False), ([1e-4, 1e-10], True)])
def test_few_tolerances_are_drawn_or_missed(monkeypatch, made_up, tolerances, drawn):
    monkeypatch.setattr(divergence, "with_steps", lambda runs: runs)
    about = made_up["pairs_paths_tolerances"].attributes
    data = made_up | {"pairs_paths_tolerances": Dataset(by_tolerance(tolerances), about)}
    figure = agreement_trajectories.draw(data | {"convergence": integrators.convergence(data)})
    assert bool(figure.axes[3].lines) == drawn and bool(figure.axes[3].texts) != drawn


@pytest.mark.parametrize("preset", ["standard", "paper"])
def test_samples_are_as_large_as_promised(preset):
    datasets = make_plan(CONFIG | {"preset": preset, "method": "event"}).datasets
    disorder = datasets["pairs_r_verlet"].values()
    assert len(disorder["belt_velocity"]) * len(disorder["noise"]) >= 24
    assert min(disorder["noise"]) > 0
    assert min(disorder["belt_velocity"]) < 15 and max(disorder["belt_velocity"]) > 30
    states = datasets["pairs_states_verlet"].values()
    assert min(len(values["replicate"]) for values in (disorder, states)) >= 32
    assert {0.002, 0.001, 0.0005} <= set(states["time_step"])
    for method, kind in itertools.product(METHODS, ("paths", "states")):
        assert 0.001 in datasets[f"pairs_{kind}_{method}"].values()["time_step"]
    assert 1e-10 in datasets["pairs_paths_tolerances"].values()["tolerance"]


def run(name, n_replicates=2, **changes):
    """Arrays of the first points of a dataset of the smoke preset, of shorter runs."""
    dataset = make_plan(CONFIG | {"preset": "smoke"}).datasets[name]
    short = {"duration": 20.0, "transient": 5.0}
    settings = dataset.settings | {
        name: min(short[name], dataset.settings[name]) for name in short if name in dataset.settings
    }
    chosen = [point._replace(**changes) for point in dataset.points]
    chosen = [point for point in dict.fromkeys(chosen) if point.replicate < n_replicates]
    return record(dataset.kind.name, chosen, settings)


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
    rows = pd.DataFrame(divergence.errors_by_tolerance(divergence.with_steps(arrays)))
    rows = rows[rows["after_events"] == 5]
    assert rows["tolerance"].tolist() == [1e-2, 1e-4, 1e-6, 1e-10]
    errors = rows["error"].tolist()
    assert errors[0] > 30 * errors[1] > 900 * errors[2] > 0 and errors[3] < 1e-11
    assert (np.diff(rows["step"]) < 0).all() and 12 < rows["order"].iloc[0] < 18
