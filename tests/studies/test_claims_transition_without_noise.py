"""Claims on the fall of r without noise on scans whose transition is known."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from made_up import escapes, few_resamples, judged, readings, scan_of_laws  # noqa: F401

U = [6, 8, 10, 12, 13, 14, 15, 15.5, 16, 16.5, 17, 17.5, 18, 19, 20, 21, 22, 24, 28, 33]


# --- the fall of r --------------------------------------------------------------------------------


def falling(at=16.5, high=0.13, low=0.02, scatter=0.004):
    def disorder(u, rng):
        return (high if u + rng.normal(0, 0.3) < at else low) + rng.normal(0, scatter)

    return disorder


def replicates(**how):
    names = ("n5_replicates_check", "n5_replicates", "n5_replicates_wide")
    return {name: scan_of_laws(U, falling(**how)) for name in names}


@pytest.mark.parametrize(
    ("how", "verdict"),
    [
        ({}, "holds"),
        ({"high": 0.1}, "partly"),
        ({"high": 0.1, "low": 0.035}, "fails"),
        ({"low": 0.005}, "partly"),  # a ratio of 26
        ({"low": 0.0105, "scatter": 0.005}, "undecided"),
    ],
)
def test_the_plateaus_of_r(how, verdict):
    found = judged("r-jump", {"n5_replicates_check": scan_of_laws(U, falling(**how))})
    assert found[0] == verdict and found[2].runs == 8


def test_the_readings_of_the_fall_use_the_scans_of_their_names():
    scans = ("n5_replicates_check", "n5_replicates", "n5_replicates_wide")
    made = {name: scan_of_laws(U, falling(high=0.1 + 0.02 * k)) for k, name in enumerate(scans)}
    names = ("the paper's scheme", "exact dynamics", "wider starts")
    found = [judged("r-jump", made, name)[2].judged["r_chaotic"].value for name in names]
    assert found == pytest.approx([0.1, 0.12, 0.14], abs=0.003)


@pytest.mark.parametrize(
    ("at", "verdict"), [(16.5, "holds"), (19.5, "fails"), (14.0, "fails"), (17.4, "undecided")]
)
def test_the_critical_velocity(at, verdict):
    found = judged("u-critical", {"n5_replicates_check": scan_of_laws(U, falling(at=at))})
    assert found[0] == verdict
    assert found[2].judged["critical"].value == pytest.approx(at, abs=0.6)
    assert found[2].also["lower"].value < found[2].also["upper"].value
    assert "side by side at u = " in found[2].note


def test_the_readings_of_the_critical_velocity():
    names = {"the paper's scheme", "exact dynamics", "wider starts", "one run at each u"}
    assert set(readings("u-critical", replicates())) == names


def test_one_run_at_each_u_decides_nothing():
    row = {"n5_rows": scan_of_laws(np.arange(4, 40, 0.5), falling(), replicates=1)}
    for name in ("r-jump", "u-critical"):
        assert judged(name, row, "one run at each u")[0] == "undecided"
    with pytest.raises(NotEnoughDataError, match="no independent runs"):
        judged("u-critical", row)


# --- outliers and windows -------------------------------------------------------------------------


def with_outliers(large, label):
    def disorder(u, rng):
        return 0.12 if u in large else falling()(u, rng)

    return scan_of_laws(
        np.arange(10, 30, 0.25),
        disorder,
        replicates=1,
        labels=lambda u: label if u in large else "continuous",
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("large", "label", "verdict"),
    [
        ((20.25, 20.5, 21.0, 21.75, 21.5, 21.25), "periodic", "holds"),
        ((20.25, 20.5, 21.0, 21.75, 21.5, 21.25), "chaotic", "partly"),
        ((20.0, 22.0), "periodic", "undecided"),  # the ends do not count
        ((21.0,), "periodic", "undecided"),
    ],
)
def test_outliers_beyond_the_transition(large, label, verdict):
    made = replicates() | {"n5_rows": with_outliers(large, label)}
    found = judged("outliers", made, "one run at each u")
    inside = [u for u in large if 20 < u < 22]
    assert found[2].judged["runs of large r"].value == len(inside) / 7
    assert found[0] == (verdict if inside else "partly" if verdict == "holds" else "undecided")
    both = judged("outliers", made)[2].judged["runs of large r"]
    assert (both.value, both.runs) == (len(inside) / 15, 15)  # 7 and 8 at u = 21


def test_outliers_among_many_runs():
    def many(large, on_orbit, small, chaotic=0):
        made = escapes(large + small, 0, on_orbit, chaotic, u=21.0)["lifetimes"]
        made.arrays["final_disorder"][:large] = 0.12
        return replicates() | {"lifetimes": made}

    assert judged("outliers", many(300, 0, 700), "many runs")[0] == "holds"
    assert judged("outliers", many(0, 0, 1000), "many runs")[0] == "fails"
    assert judged("outliers", many(0, 100, 900), "many runs")[0] == "holds"
    assert judged("outliers", many(0, 0, 900, 100), "many runs")[0] == "undecided"
    with pytest.raises(NotEnoughDataError, match="3 runs in 20 < u < 22, 4 are needed"):
        judged("outliers", many(0, 0, 3), "many runs")


@pytest.mark.parametrize(("r", "verdict"), [(0.03, "holds"), (0.1, "fails"), (None, "undecided")])
def test_r_in_the_periodic_windows(r, verdict):
    def disorder(u, rng):
        window = u % 2 == 0
        calm = rng.uniform(0.02, 0.11) if r is None else r + rng.normal(0, 0.003)
        return calm if window else 0.13 + rng.normal(0, 0.003)

    def label(u):
        return "periodic" if u % 2 == 0 else "chaotic"

    # beyond u = 15 the periodic motion has no say
    u = np.arange(3, 40, 1.0)
    row = scan_of_laws(
        u, lambda u, rng: disorder(u, rng) if u <= 15 else 0.5, replicates=1, labels=label
    )
    found = judged("r-windows", {"n5_rows": row})
    assert found[0] == verdict and "6 periodic and 7 chaotic runs" in found[2].note
    with pytest.raises(NotEnoughDataError, match="2 periodic"):
        judged("r-windows", {"n5_rows": scan_of_laws(u[:5], disorder, replicates=1, labels=label)})
