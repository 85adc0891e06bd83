"""Claims on the motion of other numbers of blocks, by made-up runs with a known answer."""

from functools import partial

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, UNDECIDED
from beltrepro.stats import estimates
from made_up import SHORT, grades, measured, motion_map, scan

SIZES = (5, 6, 7, 10)


@pytest.fixture(autouse=True)
def fewer_resamples(monkeypatch):
    monkeypatch.setattr(estimates, "RESAMPLES", 40)
    monkeypatch.setattr(estimates, "bootstrap", partial(estimates.bootstrap, resamples=80))


# --- two, three and four blocks -------------------------------------------------------------------

PLACES = np.arange(1.0, 41)
FLAT = 0.1 * (1 + 0.02 * np.sin(7 * PLACES))


def rows(disorder):
    """One row without noise for each of two, three and four blocks."""
    made = {n: disorder.get(n, FLAT) for n in (2, 3, 4)}
    return scan(np.repeat([2, 3, 4], 40), np.tile(PLACES, 3), np.concatenate([*made.values()]))


def fall(factor):
    return np.where(PLACES < 20.5, FLAT, FLAT / factor)


@pytest.mark.parametrize(
    ("letters", "verdict"),
    [
        ("p" * 150, HOLDS),
        ("p" * 120 + "q" * 20 + "e" * 10, HOLDS),
        ("c" * 3 + "p" * 147, UNDECIDED),
        ("c" * 20 + "p" * 130, FAILS),
        ("p" * 140 + "t" * 10, UNDECIDED),
    ],
)
def test_small_chains_are_regular(letters, verdict):
    runs = motion_map({2: letters[:50], 3: letters[50:100], 4: letters[100:]})
    made = grades("small-n-regular", motion_map=runs, size_rows=rows({}))
    assert made["chaotic"] == verdict


def test_small_chains_that_were_followed_briefly_are_open():
    brief = motion_map({2: "c" * 20, 3: "p" * 60, 4: "p" * 60}, duration=SHORT)
    share = measured("small-n-regular", motion_map=brief, size_rows=rows({})).judged["chaotic"]
    assert (share.value, share.still_open) == (0, 20)


@pytest.mark.parametrize(("factor", "verdict"), [(1, HOLDS), (2, HOLDS), (6.5, FAILS)])
def test_small_chains_have_no_transition(factor, verdict):
    runs = motion_map({2: "p" * 40, 3: "p" * 40, 4: "p" * 40})
    made = grades("small-n-regular", motion_map=runs, size_rows=rows({3: fall(factor)}))
    names = [f"contrast, N = {n}" for n in (2, 3, 4)]
    assert [made[name] for name in names] == [HOLDS, verdict, HOLDS]
    exact = motion_map(dict.fromkeys((2, 3, 4), "p" * 40), disorder=np.tile(fall(factor), 3))
    assert (
        grades("small-n-regular", "r by the exact dynamics", motion_map=exact)[names[1]] == verdict
    )


def test_a_fall_that_hangs_on_few_runs_is_undecided():
    """r is as low at three places only, and a resample may miss them."""
    runs = motion_map({2: "p" * 40, 3: "p" * 40, 4: "p" * 40})
    some = np.where(np.arange(40) % 2, FLAT, FLAT / 8) * np.where(PLACES > 20, 1, 2)
    made = measured("small-n-regular", motion_map=runs, size_rows=rows({2: some}))
    contrast = made.judged["contrast, N = 2"]
    assert contrast.low < 3.25 < contrast.high and contrast.runs == 40


# --- five and more blocks -------------------------------------------------------------------------


def replicated(widths, *, high=0.13, low=0.02, centre=20.0, seed=1):
    """Replicates whose r falls over these widths; None for no fall."""
    rng = np.random.default_rng(seed)
    u = np.arange(8.0, 33)
    parts = []
    for width in widths:
        share = 0.5 + (centre - u) / width if width else np.ones(u.size)
        mean = np.repeat(low + (high - low) * np.clip(share, 0, 1), 8)
        parts.append(mean * (1 + 0.01 * rng.standard_normal(mean.size)))
    return scan(np.repeat(SIZES, u.size), np.tile(u, 4), np.concatenate(parts), replicates=8)


def chaos_from(letters, widths=(2, 4, 8, 12), **options):
    """Motions at 60 velocities up to u = 12, below every transition, and periodic ones beyond."""
    u = np.concatenate([np.linspace(1, 12, 60), np.linspace(30, 40, 10)])
    made = motion_map(
        {n: own + "p" * 10 for n, own in zip(SIZES, letters, strict=True)}, u=u, **options
    )
    return {"motion_map": made, "n5_replicates": replicated(widths)}


DOMINANT = ("c" * 45 + "p" * 15, "c" * 52 + "p" * 8, "c" * 56 + "p" * 4, "c" * 60)


def test_chaos_dominates_with_fewer_windows_and_wider_transitions_from_five_blocks_on():
    assert set(grades("chaos-from-n5", **chaos_from(DOMINANT)).values()) == {HOLDS}
    rising = grades("chaos-from-n5", **chaos_from(DOMINANT[::-1], (12, 8, 4, 2)))
    assert (rising["periodic share over N"], rising["width over N"]) == (FAILS, FAILS)
    assert rising["chaotic, N = 10"] == HOLDS
    regular = ("p" * 60, *DOMINANT[1:])
    assert grades("chaos-from-n5", **chaos_from(regular))["chaotic, N = 5"] == FAILS
    alike = grades("chaos-from-n5", **chaos_from(["c" * 32 + "p" * 28] * 4, (4, 4, 4, 4)))
    names = ("chaotic, N = 7", "periodic share over N", "width over N")
    assert {alike[name] for name in names} == {UNDECIDED}


def test_chaos_below_the_transition_only():
    made = measured("chaos-from-n5", **chaos_from(DOMINANT))
    assert made.also["periodic, N = 5"].value == 0.25 and made.also["periodic, N = 5"].runs == 60
    without = chaos_from(DOMINANT, (None, 4, 8, 12))
    assert measured("chaos-from-n5", **without).also["periodic, N = 5"].runs == 60  # up to u = 15
    assert measured("chaos-from-n5", **without).judged["width over N"].value > 0


def test_widths_of_two_sizes_make_no_trend():
    made = grades("chaos-from-n5", **chaos_from(DOMINANT, (None, None, 8, 12)))
    assert made["width over N"] == FAILS and made["chaotic, N = 5"] == HOLDS


def test_irregular_runs_that_are_short_are_open():
    made = measured("chaos-from-n5", **chaos_from(DOMINANT, duration=SHORT))
    assert made.judged["chaotic, N = 10"].still_open == 60
    with pytest.raises(NotEnoughDataError, match="no run with n_blocks = 6 in motion_map"):
        measured("chaos-from-n5", **chaos_from(DOMINANT) | {"motion_map": motion_map({5: "c" * 9})})


# --- variety --------------------------------------------------------------------------------------

ALL = (2, 3, 4, *SIZES)
BY_MOTION = "sigma = 0, motions by exponent and recurrence"
VARIED, DULL = "c" * 20 + "p" * 20 + "q" * 10 + "e" * 10, "c" * 55 + "p" * 5


def varied(*richest):
    u = np.linspace(1, 50, 60)
    return motion_map({n: VARIED if n in richest else DULL for n in ALL}, u=u)


@pytest.mark.parametrize(
    ("richest", "verdict"),
    [
        ((4,), HOLDS),
        ((5,), HOLDS),
        ((6,), HOLDS),
        ((7,), FAILS),
        ((3,), FAILS),
        ((5, 7), UNDECIDED),
    ],
)
def test_the_richest_dynamics(richest, verdict):
    assert grades("complexity-at-n5", motion_map=varied(*richest))[""] == verdict


def test_the_entropy_is_that_of_the_shares():
    made = measured("complexity-at-n5", motion_map=varied(5))
    share = np.array([20, 20, 10, 10]) / 60
    assert made.also["bits, N = 5"].value == pytest.approx(-np.sum(share * np.log2(share)))
    share = np.array([55, 5]) / 60
    assert made.also["bits, N = 10"].value == pytest.approx(-np.sum(share * np.log2(share)))
    outside = varied(5)
    outside.arrays["belt_velocity"][outside.arrays["n_blocks"] == 5] = 51.0
    with pytest.raises(NotEnoughDataError, match="no runs with N = 5, 1 <= u <= 50"):
        measured("complexity-at-n5", motion_map=outside)


def test_motion_that_is_alike_everywhere_has_no_richest_size():
    made = motion_map(dict.fromkeys(ALL, "p" * 60), u=np.linspace(1, 50, 60))
    with pytest.raises(NotEnoughDataError, match="all runs of all N are alike"):
        measured("complexity-at-n5", motion_map=made)


def test_orbits_are_told_apart_by_their_returns_in_a_reading():
    u = np.linspace(1, 50, 60)
    returns = np.tile(np.arange(60) % 6 + 1, 7)
    made = motion_map({n: ("p" if n == 3 else "c") * 60 for n in ALL}, u=u, returns=returns)
    reading = "sigma = 0, motions and their periods"
    bits = measured("complexity-at-n5", reading, motion_map=made).also
    assert bits["bits, N = 3"].value == pytest.approx(np.log2(6)) and bits["bits, N = 4"].value == 0
    assert grades("complexity-at-n5", reading, motion_map=made)[""] == FAILS
