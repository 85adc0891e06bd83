"""Claims on the transition of other numbers of blocks, by made-up runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, UNDECIDED
from beltrepro.stats import estimates
from made_up import grades, measured, scan

PRINTED = {5: (15, 18), 6: (18, 24), 7: (23, 32), 10: (27, 40)}


@pytest.fixture(autouse=True)
def fewer_resamples(monkeypatch):
    monkeypatch.setattr(estimates, "RESAMPLES", 40)


# --- width of the transition ----------------------------------------------------------------------


def fall(lower, upper, u, *, high=0.13, low=0.02):
    """R that has lost 10 % of its fall at the lower edge and 90 % at the upper one."""
    share = 0.9 - 0.8 * (u - lower) / (upper - lower)
    return low + (high - low) * np.clip(share, 0, 1)


def replicated(edges=None, *, noise=1.0, high=0.13, low=0.02, replicates=8, seed=1):
    rng = np.random.default_rng(seed)
    u = np.arange(6.0, 56)
    made = PRINTED | (edges or {})
    mean = np.concatenate([fall(*each, u, high=high, low=low) for each in made.values()])
    disorder = np.repeat(mean, replicates) * (
        1 + 0.02 * rng.standard_normal(mean.size * replicates)
    )
    return scan(
        np.repeat(list(made), u.size), np.tile(u, len(made)), disorder, noise=noise,
        replicates=replicates,
    )  # fmt: skip


def test_the_printed_edges_hold():
    assert set(grades("transition-width", n5_replicates=replicated()).values()) == {HOLDS}


@pytest.mark.parametrize(
    ("edges", "changed"),
    [
        ({5: (11, 18)}, {"lower, N = 5": FAILS, "width, N = 7 minus N = 5": HOLDS}),
        ({7: (23, 36)}, {"upper, N = 7": FAILS, "lower, N = 7": HOLDS}),
        ({5: (17, 19.5)}, {"lower, N = 5": UNDECIDED}),
        ({10: (28, 35)}, {"upper, N = 10": FAILS, "width, N = 10 minus N = 7": FAILS}),
        ({5: (14, 30)}, {"upper, N = 5": FAILS, "width, N = 7 minus N = 5": FAILS}),
        ({10: (30, 39)}, {"width, N = 10 minus N = 7": UNDECIDED}),
    ],
)
def test_other_edges_do_not(edges, changed):
    made = grades("transition-width", n5_replicates=replicated(edges))
    assert {name: made[name] for name in changed} == changed


def test_a_weak_fall_is_a_fall_and_a_flat_row_has_none():
    weak = {"n5_replicates": replicated(low=0.08)}
    assert grades("transition-width", **weak)["lower, N = 7"] == HOLDS
    flat = {"n5_replicates": replicated(low=0.125)}
    made = measured("transition-width", **flat)
    assert np.isnan(made.judged["lower, N = 7"].value)
    assert "N = 7: no fall is found, its plateaus differ by a factor of 1.0" in made.note
    assert grades("transition-width", **flat)["lower, N = 7"] == FAILS


def test_single_runs_decide_nothing():
    rows = replicated(replicates=1)
    reading = "single runs from undeformed springs"
    assert grades("transition-width", reading, n5_rows=rows)[""] == UNDECIDED
    value = measured("transition-width", reading, n5_rows=rows).judged["lower, N = 10"].value
    assert value == pytest.approx(27, abs=1.5)
    two = measured("transition-width", n5_replicates=replicated(replicates=2))
    assert two.judged["lower, N = 10"].numbers == pytest.approx((27, 25.5, 28.5), abs=1.5)


@pytest.mark.parametrize(
    ("edges", "verdicts"),
    [
        ({}, (HOLDS, HOLDS, HOLDS)),
        ({5: (14, 28), 10: (22, 44)}, (FAILS, FAILS, HOLDS)),
        ({5: (14, 20), 6: (20, 26), 10: (28, 31)}, (UNDECIDED, HOLDS, FAILS)),
    ],
)
def test_the_sharpest_transition(edges, verdicts):
    made = grades("sharpest-at-n5", n5_replicates=replicated(edges))
    assert tuple(made[f"width, N = {n} minus N = 5"] for n in (6, 7, 10)) == verdicts


def test_the_sharpest_transition_without_noise_is_a_reading():
    quiet = {"n5_replicates": replicated(noise=0.0)}
    assert grades("sharpest-at-n5", "sigma = 0", **quiet)[""] == HOLDS
    with pytest.raises(NotEnoughDataError, match="N = 5, sigma = 1"):
        measured("sharpest-at-n5", **quiet)


# --- intermittency of ten blocks ------------------------------------------------------------------

U = (28, 31, 34, 38)


def alternating(share, count, last=1e6, *, replicates=8):
    """Runs of ten blocks at the four velocities: laminar share, number of phases, last stick."""
    numbers = {"laminar_fraction": share, "laminar_count": count, "last_stick_time": last}
    size = len(U) * replicates
    numbers = {
        name: np.asarray(value, dtype=float) if np.ndim(value) != 1 or len(value) == size
        else np.repeat(np.asarray(value, dtype=float), replicates)
        for name, value in numbers.items()
    }  # fmt: skip
    return scan(10, U, 0.1, replicates=replicates, **numbers)


LONGER = ([0.2, 0.3, 0.4, 0.5], [160, 120, 80, 40])  # mean phases of 1000 to 10 000


@pytest.mark.parametrize(
    ("phases", "last", "verdicts"),
    [
        (LONGER, 1e6, (HOLDS, HOLDS, HOLDS)),
        (LONGER, 919_999.0, (HOLDS, FAILS, HOLDS)),
        (LONGER, 920_000.0, (HOLDS, HOLDS, HOLDS)),
        ((LONGER[0], [1, 1, 1, 1]), 1e6, (FAILS, HOLDS, HOLDS)),
        (([0.04] * 4, LONGER[1]), 1e6, (FAILS, HOLDS, HOLDS)),
        (([0.96] * 4, LONGER[1]), 1e6, (FAILS, HOLDS, HOLDS)),
        ((LONGER[0][::-1], LONGER[1][::-1]), 1e6, (HOLDS, HOLDS, FAILS)),
        (([0.5, 0.5, 0.0, 0.0], [100, 100, 0, 0]), 1e6, (UNDECIDED, HOLDS, FAILS)),
        (([0.0] * 4, [0] * 4), 1e6, (FAILS, HOLDS, FAILS)),  # nothing lengthens
    ],
)
def test_ten_blocks_alternate(phases, last, verdicts):
    made = grades("n10-intermittency", size_replicates=alternating(*phases, last))
    names = ("intermittent", "lasts", "laminar phase over u")
    assert tuple(made[name] for name in names) == verdicts


def test_the_slope_of_laminar_phases_covers_the_truth():
    """Phases of 1000 + 100 (u - 28) on average, from runs with numbers that scatter."""
    rng = np.random.default_rng(6)
    mean = np.repeat(1000 + 100 * (np.array(U) - 28.0), 8)
    count = rng.poisson(40, 32) + 2
    phases = np.array([rng.exponential(m, n).sum() for m, n in zip(mean, count, strict=True)])
    made = measured("n10-intermittency", size_replicates=alternating(phases / 8e5, count))
    slope = made.judged["laminar phase over u"]
    assert slope.low < 100 < slope.high and slope.low > 0 and slope.runs == 8
    flat = np.array([rng.exponential(1000, n).sum() for n in count])
    no_trend = grades("n10-intermittency", size_replicates=alternating(flat / 8e5, count))
    assert no_trend["laminar phase over u"] == UNDECIDED


def test_runs_that_never_stick_do_not_last():
    made = grades("n10-intermittency", size_replicates=alternating(*LONGER, np.nan))
    assert made["lasts"] == FAILS
    other = alternating(*LONGER)
    other.arrays["belt_velocity"] = np.where(other.arrays["belt_velocity"] == 31, 30.5, 31.5)
    with pytest.raises(NotEnoughDataError, match="no runs of ten blocks at u = 28, 31, 34, 38"):
        measured("n10-intermittency", size_replicates=other)


def series(u, phases):
    """Series of ten blocks of 20 000 after a transient of 5000: free between these instants."""
    rows, time = [], 5000.0
    for begin, end in phases:
        for stick in np.arange(time, begin, 10.0):
            rows += [(stick, 10, "stick"), (stick + 5, 10, "slip")]
        rows += [(begin, 10, "slip"), (end, 10, "stick")]
        time = end
    for stick in np.arange(time + 10, 25_000, 10.0):
        rows += [(stick, 10, "stick"), (stick + 5, 10, "slip")]
    events = np.array(sorted(rows), dtype=[("time", "f8"), ("block", "i4"), ("kind", "U5")])
    attributes = {"transient": 5000.0, "duration": 25_000.0, "n_blocks": 10, "belt_velocity": u}
    return Dataset({"events": events}, attributes)


def test_the_four_series_are_readings():
    made = {
        f"n10_u{u}": series(float(u), [(6000, 6000 + length), (12_000, 12_000 + length)])
        for u, length in zip(U, (600, 700, 1000, 1500), strict=True)
    }
    scheme, long = "four series by the paper's scheme", "the series, laminar from 784 on"
    first = measured("n10-intermittency", scheme, **made)
    assert first.judged["intermittent"].value == 1 and first.judged["lasts"].value == 1
    expected = np.polyfit(U, (600, 700, 1000, 1500), 1)[0]
    assert first.judged["laminar phase over u"].value == pytest.approx(expected, rel=0.02)
    assert grades("n10-intermittency", scheme, **made)["laminar phase over u"] == UNDECIDED
    assert measured("n10-intermittency", long, **made).judged["intermittent"].value == 0.5
    made["n10_u28"].attributes["transient"] = 20_001.0
    with pytest.raises(NotEnoughDataError, match="n10_u28 covers 4999, 5000 are needed"):
        measured("n10-intermittency", scheme, **made)
