"""Claims on the motion of five blocks without noise, by made-up runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.chaos.runs_of_motion import Motions
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, PARTLY, UNDECIDED
from beltrepro.replication.verdicts.evidence import Cut
from beltrepro.stats import states
from beltrepro.stats.motion import CHAOTIC, PERIODIC
from made_up import (
    ABOVE,
    CLEAR,
    NAMES,
    SHORT,
    grades,
    joined,
    measured,
    motion_map,
    scan,
    settled,
)

# --- shares with open runs ------------------------------------------------------------------------


def motions(letters, *, long=True):
    names = np.array([NAMES[letter] for letter in letters])
    return Motions(names, np.zeros(names.size, dtype=int), np.full(names.size, long))


def test_irregular_runs_without_an_exponent_are_open_and_widen_the_interval():
    closed, opened = motions("c" * 10 + "p" * 10), motions("c" * 10 + "p" * 5 + "t" * 5)
    share, wider = closed.share(CHAOTIC), opened.share(CHAOTIC)
    assert [(of.value, of.still_open) for of in (share, wider)] == [(0.5, 0), (0.5, 5)]
    assert wider.low == share.low and wider.high > share.high
    assert wider.high == motions("c" * 15 + "p" * 5).share(CHAOTIC).high
    assert opened.share(PERIODIC).high == motions("p" * 10 + "c" * 10).share(PERIODIC).high
    assert "5 of 20 are open" in opened.words


def test_chaos_counts_only_where_it_was_seen_for_long():
    brief = motions("c" * 10 + "p" * 10, long=False).share(CHAOTIC)
    assert (brief.value, brief.still_open) == (0, 10)
    assert brief.high == motions("c" * 10 + "p" * 10).share(CHAOTIC).high


# --- section of phase space -----------------------------------------------------------------------


def section(coordinates, *, runs=16, belt_velocity=1.0):
    """Section points whose coordinates are functions of these; a third of them are stuck."""
    size, columns = len(coordinates), [("positions", "f8", (5,)), ("velocities", "f8", (5,))]
    points = np.zeros(size, [("point", "i4"), *columns])
    points["point"] = np.arange(size) % runs
    mixed = coordinates @ np.random.default_rng(7).normal(size=(coordinates.shape[1], 9))
    points["positions"], points["velocities"] = mixed[:, :5], mixed[:, 4:]
    points["velocities"][:, 4] = -1 - np.abs(mixed[:, 8])
    points["velocities"][::3, 4] = belt_velocity
    return Dataset({"section": points}, {"belt_velocity": belt_velocity})


def cantor(size, share):
    """Points of a self-similar dust of a dimension below one: ln 2 over -ln share."""
    digits = np.random.default_rng(3).integers(0, 2, (size, 40))
    return (digits * share ** np.arange(40)).sum(axis=1, keepdims=True)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("coordinates", "verdict"),
    [
        (np.random.default_rng(1).random((12_000, 2)), HOLDS),
        (cantor(12_000, 0.25), FAILS),  # of dimension one half
        (np.random.default_rng(1).random((12_000, 5)), FAILS),
        (np.random.default_rng(1).random((12_000, 3)), UNDECIDED),
    ],
)
def test_the_dimension_of_the_section(coordinates, verdict):
    runs = settled([CLEAR] * 8, u=1.0)
    made = grades("poincare", slips_u1=section(coordinates), survival=runs)
    assert made["dimension"] == verdict and made["exponent"] == HOLDS


@pytest.mark.thorough
def test_the_readings_of_the_section_leave_out_stuck_states_and_project():
    runs = settled([CLEAR] * 8, u=1.0)
    points = section(np.random.default_rng(1).random((12_000, 3)))
    names = ("all nine coordinates", "points shown (v_rN < 0)", "their projection on (x_N, v_rN)")
    values = [
        measured("poincare", name, slips_u1=points, survival=runs).judged["dimension"].value
        for name in names
    ]
    assert values[2] == pytest.approx(2, abs=0.2) and values[1] > 2.5
    few = section(np.random.default_rng(1).random((2000, 2)))
    with pytest.raises(NotEnoughDataError, match="2000 section points are too few"):
        measured("poincare", slips_u1=few, survival=runs)


@pytest.mark.thorough
def test_a_group_of_runs_that_is_elsewhere_widens_the_interval():
    """What runs share is in the points; what they do not share is in the interval."""
    runs = settled([CLEAR] * 8, u=1.0)
    rng = np.random.default_rng(5)
    plane = rng.random((12_000, 2))
    alike = measured("poincare", slips_u1=section(plane), survival=runs).judged["dimension"]
    plane[np.arange(12_000) % 16 < 4, 1] = 0.0  # a quarter of the runs stays on a line
    apart = measured("poincare", slips_u1=section(plane), survival=runs).judged["dimension"]
    assert apart.high - apart.low > 2 * (alike.high - alike.low)


# --- u = 15 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("long", "verdict"), [(40, HOLDS), (28, HOLDS), (20, UNDECIDED), (6, FAILS), (0, FAILS)]
)
def test_aperiodic_motion_at_u15(long, verdict):
    """Of 40 runs: two in three hold, one in two do not tell, one in six fail."""
    runs = settled([1e5] * long + [99_999.0] * (40 - long), u=15.0)
    assert grades("u15-aperiodic", survival=runs)["irregular for 1e5"] == verdict


def test_runs_at_u15_that_are_given_up_are_open():
    lifetimes = [SHORT] * 20 + [500.0] * 20
    runs = settled(lifetimes, u=15.0, duration=SHORT)
    share = measured("u15-aperiodic", survival=runs).judged["irregular for 1e5"]
    assert (share.value, share.still_open) == (0, 20) and share.high > 0.6
    enough = settled([SHORT] * 4 + [500.0] * 36, u=15.0, duration=SHORT)
    assert grades("u15-aperiodic", survival=enough)["irregular for 1e5"] == FAILS


@pytest.mark.parametrize(
    ("exponents", "verdict"),
    [
        (ABOVE, HOLDS),
        (-ABOVE, FAILS),
        (1e-4 + np.tile([-1e-3, 1e-3], 4), UNDECIDED),
        ([0.003, 0.002, 0.004, *[np.nan] * 5], HOLDS),
        ([0.003, 0.001, 0.008, *[np.nan] * 5], UNDECIDED),
        ([0.003, 0.002, *[np.nan] * 6], FAILS),  # two are no sample: none is found
    ],
)
def test_exponents_against_their_scatter_over_the_runs(exponents, verdict):
    runs = settled([1e5] * 8, u=15.0, exponents=exponents)
    assert grades("u15-aperiodic", survival=runs)["exponent"] == verdict


def test_an_exponent_is_missing_only_if_all_motion_settled_too_soon():
    none = np.full(8, np.nan)
    soon = settled([400.0] * 8, u=15.0, exponents=none, duration=1000.0)
    assert grades("u15-aperiodic", survival=soon)["exponent"] == FAILS
    one = settled([400.0] * 7 + [1000.0], u=15.0, exponents=none, duration=1000.0)
    with pytest.raises(NotEnoughDataError, match=r"7 of 8 runs .* needed for an exponent"):
        measured("u15-aperiodic", survival=one)


def test_starts_of_each_spread_are_a_reading_and_the_longest_runs_serve():
    wide, narrow = settled([1e5] * 8, u=15.0), settled([500.0] * 8, u=15.0, spread=1.0)
    elsewhere = settled([500.0] * 8, u=15.5)
    runs = joined(narrow, elsewhere, wide)
    assert grades("u15-aperiodic", survival=runs)["irregular for 1e5"] == HOLDS
    narrow_name = "starts spread by 1"
    assert grades("u15-aperiodic", narrow_name, survival=runs)["irregular for 1e5"] == FAILS
    longer = settled([500.0] * 8, u=15.0, duration=5e5)
    made = {"survival": runs, "survival_many": longer}
    assert grades("u15-aperiodic", **made)["irregular for 1e5"] == FAILS
    assert "within 500000" in measured("u15-aperiodic", **made).note


# --- u <= 15 --------------------------------------------------------------------------------------

BELOW = np.linspace(1, 15, 30)


@pytest.mark.parametrize(
    ("letters", "verdict"),
    [
        ("c" * 30, HOLDS),
        ("c" * 25 + "p" * 5, UNDECIDED),
        ("c" * 10 + "p" * 20, FAILS),
        ("c" * 10 + "p" * 10 + "t" * 10, UNDECIDED),
        ("c" * 4 + "p" * 20 + "t" * 6, FAILS),
    ],
)
def test_permanent_chaos(letters, verdict):
    made = motion_map({5: letters}, u=BELOW)
    assert grades("permanent-chaos", motion_map=made)[""] == verdict


def test_windows_do_not_count_against_permanent_chaos():
    """Short orbits are windows, long ones are not, and chaos is none whatever its returns."""
    letters = "c" * 20 + "p" * 10
    windows = motion_map({5: letters}, u=BELOW, returns=[0] * 20 + [20] * 10)
    long_orbits = motion_map({5: letters}, u=BELOW, returns=[0] * 20 + [21] * 10)
    assert grades("permanent-chaos", motion_map=windows)[""] == HOLDS
    assert grades("permanent-chaos", motion_map=long_orbits)[""] == UNDECIDED
    assert measured("permanent-chaos", motion_map=windows).runs == 20
    assert "10 of 30 runs end in a window" in measured("permanent-chaos", motion_map=windows).note
    only = motion_map({5: "p" * 30}, u=BELOW, returns=1)
    with pytest.raises(NotEnoughDataError, match="30 of 30 runs end in a window"):
        measured("permanent-chaos", motion_map=only)


def test_permanent_chaos_by_lifetimes_and_by_the_scheme():
    runs = settled([1e5] * 28 + [5e4] * 2, u=BELOW)
    beyond = settled([10.0] * 40, u=15.1)
    reading = "irregular for 1e5"
    assert grades("permanent-chaos", reading, survival=joined(runs, beyond))[""] == HOLDS
    scheme = joined(
        settled([CLEAR] * 30, u=BELOW, time_step=0.001),
        settled([10.0] * 30, u=BELOW, time_step=0.004),
    )
    name = "irregular for 1e5 by the paper's scheme"
    assert grades("permanent-chaos", name, steps=scheme)[""] == HOLDS
    brief = settled([2e4] * 30, u=BELOW, time_step=0.001, duration=2e4)
    assert grades("permanent-chaos", name, steps=brief)[""] == UNDECIDED
    assert "30 open" in measured("permanent-chaos", name, steps=brief).note


# --- u >= 18 --------------------------------------------------------------------------------------


def beyond(low, high, **options):
    """Runs beyond the transition: motions by letters below and above u = 35.5."""
    u = np.concatenate([np.linspace(18, 35, len(low)), np.linspace(36, 50, len(high))])
    return motion_map({5: low + high}, u=u, **options)


@pytest.mark.parametrize(
    ("low", "high", "verdicts"),
    [
        ("p" * 90, "p" * 90, (HOLDS, HOLDS)),
        ("p" * 90, "c" * 20 + "p" * 70, (HOLDS, FAILS)),
        ("p" * 90, "c" * 2 + "p" * 88, (HOLDS, UNDECIDED)),
        ("p" * 20, "p" * 90, (UNDECIDED, HOLDS)),  # none of 20 may be up to 17 %
        ("p" * 89 + "t", "p" * 70 + "t" * 20, (UNDECIDED, UNDECIDED)),
    ],
)
def test_chaotic_runs_beyond_the_transition(low, high, verdicts):
    reading = "starts spread by 1, after a transient"
    made = grades("no-permanent-chaos", reading, motion_map=beyond(low, high))
    names = ("chaotic, u = 18 to 35", "chaotic, u = 36 to 50")
    assert tuple(made[name] for name in names) == verdicts
    if set(verdicts) == {HOLDS, FAILS}:
        assert made[""] == PARTLY


def test_runs_that_settle_count_beside_the_motions():
    """A run that is still irregular is chaotic by its exponent, and open without one.

    Runs of the spread of the map are left out, whose starts are its own.
    """
    few = beyond("p" * 30, "p" * 90)
    own = settled([CLEAR] * 60, u=np.linspace(18, 35, 60), spread=1.0)
    calm = joined(settled([100.0] * 60, u=np.linspace(18, 35, 60)), own)
    name = "chaotic, u = 18 to 35"
    assert grades("no-permanent-chaos", motion_map=few, survival=calm)[name] == HOLDS
    wild = settled([CLEAR] * 20 + [100.0] * 40, u=np.linspace(18, 35, 60))
    assert grades("no-permanent-chaos", motion_map=few, survival=wild)[name] == FAILS
    unknown = settled([CLEAR] * 20 + [100.0] * 40, u=np.linspace(18, 35, 60), exponents=0.0)
    assert grades("no-permanent-chaos", motion_map=few, survival=unknown)[name] == UNDECIDED
    brief = settled([SHORT] * 20 + [100.0] * 40, u=np.linspace(18, 35, 60), duration=SHORT)
    share = measured("no-permanent-chaos", motion_map=few, survival=brief).judged[name]
    assert (share.value, share.still_open, share.runs) == (0, 20, 90)


# --- bifurcation diagram --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("letters", "chaotic", "periodic"),
    [
        ("c" * 45 + "p" * 15, HOLDS, HOLDS),
        ("c" * 60, HOLDS, UNDECIDED),
        ("c" * 10 + "p" * 50, FAILS, FAILS),
        ("c" * 45 + "p" * 3 + "e" * 12, HOLDS, HOLDS),
        ("c" * 30 + "p" * 30, UNDECIDED, UNDECIDED),
        ("e" * 60, FAILS, UNDECIDED),
    ],
)
def test_bands_and_windows_up_to_u15(letters, chaotic, periodic):
    u = [0.9, *np.linspace(1, 15, 60), 15.1]
    made = grades("bifurcation-sigma0", motion_map=motion_map({5: f"p{letters}p"}, u=u))
    assert (made["chaotic"], made["periodic"]) == (chaotic, periodic)


def test_bands_and_windows_by_the_look_of_the_section(monkeypatch):
    row = scan(5, np.repeat(np.linspace(1, 16, 16), 4), 0.1, method="verlet")
    labels = np.array([states.CHAOTIC] * 45 + [states.PERIODIC] * 12 + [states.UNDECIDED] * 3)
    labels = np.append(labels, [states.PERIODIC] * 4)  # at u = 16
    monkeypatch.setattr(Cut, "states", labels)
    reading = "look of the section, the paper's scheme"
    made = measured("bifurcation-sigma0", reading, n5_replicates_check=row)
    assert made.judged["chaotic"].value == 0.75 and made.judged["periodic"].value == 0.2
    assert made.judged["chaotic"].still_open == 3 and made.runs == 60
    assert grades("bifurcation-sigma0", reading, n5_replicates_check=row)[""] == HOLDS
