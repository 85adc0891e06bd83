"""Claims on the motion of five blocks without noise, by made-up runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.store import Dataset
from beltrepro.replication.verdicts import motions
from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN, YES
from beltrepro.replication.verdicts.evidence import EXACT, Cut, Evidence
from beltrepro.stats import states
from beltrepro.stats.motion import CHAOTIC, EQUILIBRIUM, PERIODIC
from made_up import (
    ABOVE,
    CLEAR,
    both,
    grades,
    joined,
    measured,
    motion_map,
    scan,
    settled,
)

# --- shares with open runs ------------------------------------------------------------------------


def share_of(letters, motion=CHAOTIC, duration=CLEAR):
    evidence = Evidence({"motion_map": motion_map({5: letters}, duration=duration)}, {})
    return motions.share(motions.runs(evidence, 5), motion)


def test_irregular_runs_without_an_exponent_are_open_and_widen_the_interval():
    share, wider = share_of("c" * 10 + "p" * 10), share_of("c" * 10 + "p" * 5 + "t" * 5)
    assert [(of.value, of.still_open) for of in (share, wider)] == [(0.5, 0), (0.5, 5)]
    assert wider.low == share.low and wider.high > share.high
    assert wider.high == share_of("c" * 15 + "p" * 5).high
    periodic = share_of("c" * 10 + "p" * 5 + "t" * 5, PERIODIC)
    assert periodic.high == share_of("p" * 10 + "c" * 10, PERIODIC).high


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


@pytest.mark.parametrize(
    ("dimension", "lifetime", "verdicts", "size"),
    [
        (2, 5e5, (YES, IN_PART), 9000),  # of low dimension, but no attractor
        pytest.param(2, 2e6, (YES, YES), 9000, marks=pytest.mark.thorough),
        pytest.param(5, 2e6, (NO, IN_PART), 9000, marks=pytest.mark.thorough),
    ],
)
def test_the_section_of_an_attractor(dimension, lifetime, verdicts, size):
    points = section(np.random.default_rng(1).random((size, dimension)), runs=6)
    runs = settled([lifetime] * 8, u=1.0, duration=2e6)
    made = {"slips_u1": points, "slips_u1_event": points, "survival_long": runs}
    assert both("poincare", **made) == verdicts


@pytest.mark.thorough
def test_the_paper_shows_points_of_slips_alone_and_groups_widen_the_interval():
    """What runs share is in the points; what they do not share is in the interval."""
    rng = np.random.default_rng(5)
    plane = rng.random((9000, 2))
    points = section(plane)
    points.arrays["section"]["positions"][::3] = rng.random((3000, 5))  # the stuck ones fill space
    alike = measured("poincare", slips_u1=points).judged["dimension"]
    assert alike.value == pytest.approx(2, abs=0.2)
    plane[np.arange(9000) % 16 < 4, 1] = 0.0  # a quarter of the runs stays on a line
    apart = measured("poincare", slips_u1=section(plane)).judged["dimension"]
    assert apart.high - apart.low > 2 * (alike.high - alike.low)


# --- u = 7 and u = 15 -----------------------------------------------------------------------------


def by_both(lifetime, **options):
    """The same runs by the scheme, whose exponents are not known, and by the exact dynamics."""
    lost = np.full(8, np.nan)
    return {
        "survival_scheme": settled(lifetime, **options | {"exponents": lost}),
        "survival": settled(lifetime, **options),
    }


@pytest.mark.parametrize(("long", "verdict"), [(28, YES), (20, OPEN), (6, NO)])
def test_aperiodic_motion_at_u15(long, verdict):
    made = by_both([1e5] * long + [99_999.0] * (40 - long), u=15.0)
    assert both("u15-aperiodic", **made) == (verdict, verdict)


def test_only_runs_at_the_point_count_and_of_the_exact_ones_the_longest():
    """Other velocities, and starts of another spread, are no part of it."""
    runs = joined(
        settled([500.0] * 8, u=15.0, spread=1.0),
        settled([500.0] * 8, u=15.5),
        settled([1e5] * 8, u=15.0),
    )
    made = {"survival": runs, "survival_scheme": runs}
    assert both("u15-aperiodic", **made) == (YES, YES)
    longer = settled([500.0] * 8, u=15.0, duration=5e5)
    assert both("u15-aperiodic", survival_many=longer, **made) == (YES, NO)


@pytest.mark.parametrize(
    ("lifetime", "changes", "verdicts"),
    [
        ([2000] * 40, {}, (YES, YES)),  # 4 e-foldings
        ([2000] * 40, {"exponents": ABOVE / 10}, (YES, IN_PART)),  # 0.4 e-foldings
        ([2000] * 4 + [499] * 36, {}, (IN_PART, IN_PART)),
        ([2000] * 40, {"state": EQUILIBRIUM}, (IN_PART, IN_PART)),
        ([2000] * 4 + [CLEAR] * 36, {}, (IN_PART, IN_PART)),  # lasting irregular motion
        ([499] * 40, {"state": EQUILIBRIUM, "exponents": -ABOVE}, (NO, NO)),
    ],
)
def test_the_transient_at_u7(lifetime, changes, verdicts):
    made = by_both(lifetime, u=7.0, **changes)
    assert both("u7-transient-chaos", **made) == verdicts
    periodic = sum(time < CLEAR for time in lifetime) / len(lifetime)
    if "state" in changes:
        periodic = 0
    verdict = {0: NO, 0.1: NO, 0.5: OPEN, 1: YES}[periodic]
    assert both("u7-periodic", **made) == (verdict, verdict)


# --- u <= 15 --------------------------------------------------------------------------------------


OUTSIDE = np.arange(1.0, 11)  # velocities with four runs each, and four more in a window
IN_WINDOW = settled([3e3] * 16, u=np.repeat(np.arange(12.0, 16), 4), returns=20, duration=2e6)


def four_at_each(lasting, duration=2e6):
    """Runs outside the windows, of which the first at each velocity are irregular to the end."""
    lifetime = np.where(np.arange(4) < np.reshape(lasting, (-1, 1)), duration, 5e4)
    return settled(lifetime.ravel(), u=np.repeat(OUTSIDE, 4), duration=duration)


@pytest.mark.parametrize(
    ("lasting", "verdict"),
    [
        ([4] * 10, YES),
        ([3] * 10, OPEN),
        ([2] * 10, IN_PART),  # at all velocities, but half of the runs
        ([0] * 10, NO),
    ],
)
def test_permanent_chaos(lasting, verdict):
    runs = joined(four_at_each(lasting), IN_WINDOW)
    made = {"survival_scheme": runs, "survival_long": runs}
    assert both("permanent-chaos", **made) == (verdict, verdict)


def test_a_window_is_a_velocity_at_which_most_runs_of_the_scheme_end_on_short_orbits():
    """Long orbits are none, whatever exact motion does there."""
    exact = joined(four_at_each([0] * 10), IN_WINDOW)
    half = settled([3e3] * 2 + [2e6] * 2, u=11.0, returns=20, duration=2e6)
    for more, returns, runs, windows in (
        (IN_WINDOW, 20, 40, "12, 13, 14, 15"),
        (IN_WINDOW, 21, 56, "none"),
        (half, 20, 44, "none"),
    ):
        more = Dataset(more.arrays | {"period_returns": np.minimum(returns, 25)
                                      * more.arrays["settled"]}, more.attributes)  # fmt: skip
        scheme = joined(four_at_each([4] * 10), more)
        made = {"survival_scheme": scheme, "survival_long": joined(exact, half)}
        for reading in (None, EXACT):
            measurement = measured("permanent-chaos", *filter(None, [reading]), **made)
            assert measurement.judged["irregular for 1e6"].runs == runs
            assert measurement.note.startswith(f"windows at u = {windows}; ")


@pytest.mark.parametrize(
    ("letters", "chaotic", "periodic"),
    [
        ("c" * 45 + "p" * 15, YES, YES),
        ("c" * 60, YES, OPEN),
        ("c" * 4 + "p" * 56, NO, NO),
        ("c" * 30 + "p" * 30, OPEN, OPEN),
    ],
)
def test_bands_and_windows_up_to_u15(letters, chaotic, periodic):
    u = [0.9, *np.linspace(1, 15, 60), 15.1]
    runs = motion_map({5: f"p{letters}p"}, u=u)
    made = grades("bifurcation-sigma0", "robust", motion_map=runs)
    assert (made["chaotic"], made["periodic"]) == (chaotic, periodic)
    longest = settled([100.0] * 400, u=2.0, duration=2e6)
    made = grades("bifurcation-sigma0", "robust", motion_map=runs, survival_long=longest)
    assert (made["chaotic"], made["periodic"]) == (NO, NO)  # 60 of 460 are chaotic at most


def test_bands_and_windows_by_the_look_of_the_section(monkeypatch):
    row = scan(5, np.repeat(np.linspace(1, 16, 16), 4), 0.1, method="verlet")
    labels = np.array([states.CHAOTIC] * 45 + [states.PERIODIC] * 12 + [states.UNDECIDED] * 3)
    labels = np.append(labels, [states.PERIODIC] * 4)  # at u = 16
    monkeypatch.setattr(Cut, "states", labels)
    made = measured("bifurcation-sigma0", n5_replicates_check=row).judged
    assert made["chaotic"].value == 0.75 and made["periodic"].value == 0.2
    assert made["chaotic"].still_open == 3 and made["chaotic"].runs == 60
    assert grades("bifurcation-sigma0", n5_replicates_check=row)[""] == YES
    monkeypatch.setattr(Cut, "states", np.full(64, states.PERIODIC))
    assert grades("bifurcation-sigma0", n5_replicates_check=row)[""] == NO


# --- u >= 18 --------------------------------------------------------------------------------------


def beyond(low, lasting=0, high=40):
    """Motions by letters up to u = 41, and runs above of which some are irregular for 2e6."""
    runs = settled([2e6] * lasting + [4e5] * (high - lasting), u=46.0, duration=2e6)
    return {
        "motion_map": motion_map({5: low}, u=np.linspace(18, 41, len(low))),
        "survival_long": joined(runs, settled([2e6] * 40, u=1.0, duration=2e6)),
    }


@pytest.mark.parametrize(
    ("low", "lasting", "high", "verdict"),
    [
        ("p" * 90, 0, 40, YES),
        ("p" * 90, 20, 40, IN_PART),
        ("c" * 40 + "p" * 50, 20, 40, NO),
        ("p" * 20, 0, 40, OPEN),  # none of 20 may be up to 17 %
        ("p" * 80 + "t" * 10, 0, 40, OPEN),
    ],
)
def test_chaotic_runs_beyond_the_transition(low, lasting, high, verdict):
    assert grades("no-permanent-chaos", "robust", **beyond(low, lasting, high))[""] == verdict


@pytest.mark.parametrize(
    ("low", "high", "duration", "verdict"),
    [
        (0, 0, 2e6, YES),
        (2, 0, 2e6, IN_PART),  # long orbits look chaotic too
        (30, 9, 2e6, NO),
        (0, 9, 5e4, OPEN),  # transients
    ],
)
def test_belt_velocities_that_look_chaotic(monkeypatch, low, high, duration, verdict):
    u = np.linspace(18, 50, 65)
    chaotic = (u < 18 + low / 2) | (u > 50 - high / 2)
    monkeypatch.setattr(Cut, "states", np.where(chaotic, states.CHAOTIC, states.CONTINUOUS))
    row = scan(5, u, 0.1, method="verlet", duration=duration, transient=duration / 2)
    assert grades("no-permanent-chaos", n5_rows=row)[""] == verdict


def test_runs_that_settle_count_beside_the_motions():
    """A run that is still irregular is chaotic by its exponent, and open without one.

    Runs of the spread of the map are left out, whose starts are its own.
    """
    few, u = beyond("p" * 30), np.linspace(18, 41, 60)
    chosen = settled([CLEAR] * 60, u=u, spread=1.0)
    calm = joined(settled([100.0] * 60, u=u), chosen)
    assert grades("no-permanent-chaos", "robust", survival=calm, **few)[""] == YES
    name = "chaotic, u = 18 to 41"
    lifetimes = [CLEAR] * 20 + [100.0] * 40
    for exponents, verdict in ((ABOVE, NO), (0.0, OPEN)):
        wild = settled(lifetimes, u=u, exponents=exponents)
        made = grades("no-permanent-chaos", "robust", survival=wild, **few)
        assert made[name] == verdict
