"""Comparison of integrators: tests with known answers and error rates, and its tables."""

import itertools
import math

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from beltrepro.base.store import Dataset
from beltrepro.observe.slips import SLIP
from beltrepro.replication.studies.integrators import measure as integrators
from beltrepro.stats.states import ATTRACTORS, STICK_SLIP, label_ends

RNG = np.random.default_rng
METHODS = ("verlet", "event")


def within(rate, expected, trials, sigmas=4.0):
    """A counted rate is what it should be, to some standard errors of the count."""
    return abs(rate - expected) <= sigmas * np.sqrt(expected * (1 - expected) / trials)


# --- two samples ----------------------------------------------------------------------------------


def test_a_comparison_of_samples_by_formulas_of_their_own():
    rng = RNG(8)
    one, two = rng.normal(5, 1, 12), rng.normal(6, 3, 7)
    row = integrators.compare_samples([*one, np.nan], two)
    variance = [np.var(side, ddof=1) / side.size for side in (one, two)]
    z = (one.mean() - two.mean()) / math.sqrt(sum(variance))
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
        "test": "Kolmogorov-Smirnov",
        "p": pytest.approx(stats.ks_2samp(one, two, method="exact").pvalue),
        "distance": pytest.approx(area / math.sqrt(np.mean(two**2))),
    }
    # of the C(16, 8) ways to mix two samples of 8, two keep them apart
    assert integrators.compare_samples(np.arange(8), np.arange(8) + 9)["p"] == pytest.approx(
        2 / 12870
    )


def test_five_runs_are_a_sample_and_four_are_not():
    assert np.isfinite(integrators.compare_samples(np.arange(5), np.arange(5) + 0.5)["z"])
    for sizes in ((4, 5), (5, 4)):
        one, two = (np.arange(size, dtype=float) for size in sizes)
        row = integrators.compare_samples(one, two)
        assert np.isnan([row["p"], row["z"]]).all()
        shares = integrators.compare_labels(*(np.where(x > 1, *ATTRACTORS[:2]) for x in (one, two)))
        assert np.isnan([shares["p"], shares["z"]]).all()
        assert shares["mean_tested"] == np.mean(one > 1)
    alone = integrators.compare_samples([1.0], [2.0, 3.0])
    assert np.isnan(alone["error_tested"]) and alone["error_reference"] == pytest.approx(0.5)
    assert np.isnan(integrators.compare_samples([], [1.0] * 8)["distance"])


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
    labels = np.array(ATTRACTORS)
    row = integrators.compare_labels(labels[tested], labels[reference])
    assert row["p"] == pytest.approx(exact, abs=4 * math.sqrt(exact / 9999))
    assert row["distance"] == pytest.approx((0.3 + 0.4 + 0.1) / 2)
    assert (row["mean_tested"], row["mean_reference"]) == (0.5, 0.2)
    # never less than one in the number of draws and one
    apart = integrators.compare_labels(labels[[0] * 40], labels[[1] * 40])
    assert apart["p"] == pytest.approx(1e-4)


def ended(lifetime, escaped):
    return {"lifetime": lifetime, "escaped": escaped}


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
    row = integrators.compare_lifetimes(*map(ended, sides, escaped))
    assert row["p"] == pytest.approx(p)


# --- many tests -----------------------------------------------------------------------------------


def test_holm_by_hand_and_the_error_of_a_family():
    corrected = integrators.holm([0.01, 0.04, 0.03, 0.005, np.nan])
    np.testing.assert_allclose(corrected, [0.03, 0.06, 0.06, 0.02, np.nan])
    np.testing.assert_allclose(integrators.holm([0.001, 0.5, 0.4]), [0.003, 0.8, 0.8])
    assert integrators.holm([0.02, 0.03, 0.02]).tolist() == [0.06, 0.06, 0.06]
    assert integrators.holm([0.9, 0.8]).tolist() == [1, 1] and integrators.holm([]).size == 0
    wrong = [np.nanmin(integrators.holm(row)) < 0.05 for row in RNG(5).random((2000, 28))]
    assert within(np.mean(wrong), 0.05, 2000)


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
        "pairs_r_verlet": scan_of([*shared, (5, 50.0, 1.0)], 19, 6),
        "pairs_r_event": scan_of([(9, 9.0, 9.0), *shared], 20, 9),
        "pairs_slips_verlet": catalogue(10, [3, 2, 2, 3, 3, 2]),
        "pairs_slips_event": catalogue(20, [2, 3, 2, 3, 3, 3, 3, 2]),
        "pairs_states_verlet": ends(21, steps=(0.004, 0.002, 0.001), runs=7),
        "pairs_states_event": ends(22, steps=(0.002, 0.001), runs=11),
    }
    lengths = {"verlet": (1000.0, 100.0), "event": (640.0, 40.0)}
    made = {}
    for name, columns in arrays.items():
        method = name.rpartition("_")[2]
        about = dict(zip(("duration", "transient"), lengths[method], strict=True))
        made[name] = Dataset(columns, about | {"method": method})
    return made


@pytest.fixture(scope="module")
def agreement(made_up):
    return integrators.agreement(made_up)


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
    sticks = label_ends(side.arrays)[run] == STICK_SLIP
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
    made_up, agreement, part, name, numbers, points
):
    """By plain loops, run by run; of the attractors the reference has its smallest step."""
    table = agreement[agreement["part"] == part]
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


def test_families_are_judged_each_by_itself():
    columns = ["p", "distance", "n_reference", "quantity"]
    rows = [(0.01, 0.5, 9, "q"), (0.02, 0.001, 9, "q"), (0.04, 0.02, 9, "other"),
            (0.2, 0.9, 7, "q"), (np.nan, np.nan, 9, "q")]  # fmt: skip
    alike = {"part": "a", "time_step": np.nan, "initial_spread": np.nan, "test": "KS"}
    alike |= {"tested": "one", "reference": "two"}
    judged = integrators.judge(pd.DataFrame(rows, columns=columns).assign(**alike))
    assert judged["corrected_p"].tolist()[:3] == pytest.approx([0.03, 0.04, 0.2])
    assert judged["corrected_p"].iloc[4] == 0.04  # a family of its own
    assert judged["verdict"].tolist() == [
        integrators.DIFFER, integrators.CLOSE, integrators.AGREE, integrators.UNKNOWN,
        integrators.DIFFER,
    ]  # fmt: skip
