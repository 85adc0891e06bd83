"""Claims on the motion of five blocks without noise, by made-up runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.chaos.measure import before_settling
from beltrepro.replication.studies.transition.measure import saddle
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
    ("dimension", "lifetime", "verdicts"),
    [
        (2, 2e6, (YES, YES)),
        (2, 1e5, (YES, IN_PART)),  # the scheme's is judged by what the paper shows
        pytest.param(5, 1e5, (NO, NO), marks=pytest.mark.thorough),
    ],
)
def test_the_section_of_an_attractor_that_lasts(dimension, lifetime, verdicts):
    points = section(np.random.default_rng(1).random((9000, dimension)), runs=6)
    runs = settled([lifetime] * 40, u=1.0, duration=2e6)
    made = {"slips_u1": points, "slips_u1_event": points}
    assert both("poincare", **made, survival_long=runs, survival_scheme=runs) == verdicts


def test_section_points_count_up_to_where_a_run_repeats_itself():
    """Seen twice at least; a run that comes back once, or leaves its orbit, has not settled."""
    irregular = list(np.random.default_rng(2).permutation(np.arange(5, 65)) / 64.0)
    orbit = [0.01, 0.5, 0.03]
    made = (irregular + orbit * 4, irregular + orbit, irregular + orbit * 4 + [0.9], irregular)
    rows = section(np.concatenate(made)[:, None], runs=1).arrays["section"]
    rows["velocities"][:, 4] = -1.0
    rows["point"] = np.repeat(np.arange(4), [len(one) for one in made])
    kept = before_settling(rows)
    counts = [np.count_nonzero(kept[rows["point"] == run]) for run in range(4)]
    assert counts == [60, 63, 73, 60]
    assert before_settling(rows[:0]).size == 0


@pytest.mark.thorough
def test_the_paper_shows_points_of_slips_alone_and_groups_widen_the_interval():
    """What runs share is in the points; what they do not share is in the interval."""
    rng = np.random.default_rng(5)
    plane = rng.random((9000, 2))
    points = section(plane)
    points.arrays["section"]["positions"][::3] = rng.random((3000, 5))  # the stuck ones fill space
    runs = settled([2e6] * 8, u=1.0, duration=2e6)
    alike = measured("poincare", slips_u1=points, survival_scheme=runs).judged["dimension"]
    assert alike.value == pytest.approx(2, abs=0.2)
    plane[np.arange(9000) % 16 < 4, 1] = 0.0  # a quarter of the runs stays on a line
    made = {"slips_u1": section(plane), "survival_scheme": runs}
    apart = measured("poincare", **made).judged["dimension"]
    assert apart.high - apart.low > 2 * (alike.high - alike.low)


# --- u = 7 and u = 15 -----------------------------------------------------------------------------


def by_both(lifetime, **options):
    """The same runs by the scheme, whose exponents are not known, and by the exact dynamics."""
    lost = np.full(8, np.nan)
    return {
        "survival_scheme": settled(lifetime, **options | {"exponents": lost}),
        "survival": settled(lifetime, **options),
    }


def near_15(long, count=40, **options):
    """The same starts at u = 14.5 to 15.5 by both, of which so many are irregular for long."""
    lifetime = [1e5] * long + [99_999.0] * (count - long)
    u = np.resize(np.arange(14.5, 15.6, 0.25), count)
    lost = np.full(8, np.nan)  # exponents of the scheme
    return {
        "survival_long": settled(lifetime, u=u, **options),
        "survival_scheme": settled(lifetime, u=u, **options | {"exponents": lost}),
    }


@pytest.mark.parametrize(("long", "verdict"), [(28, YES), (20, OPEN), (6, NO)])
def test_aperiodic_motion_at_u15(long, verdict):
    assert both("u15-aperiodic", **near_15(long)) == (verdict, verdict)


def test_only_runs_about_u15_count_and_without_long_ones_many_at_15():
    """Other velocities, and starts of another spread, are no part of it."""
    made = near_15(40)
    others = [
        settled([500.0] * 9, u=15.0, spread=1.0),
        settled([500.0] * 9, u=[14.25, 15.75, 7] * 3),
    ]
    made = {name: joined(runs, *others) for name, runs in made.items()}
    many = settled([500.0] * 8, u=15.0)
    assert both("u15-aperiodic", survival_many=many, **made) == (YES, YES)
    made["survival_long"] = others[1]
    assert both("u15-aperiodic", survival_many=many, **made) == (YES, NO)


def test_exponents_are_medians_over_starts_and_the_trivial_one_is_told_apart():
    runs = settled([1e5] * 9, u=15.0, exponents=[0.0] * 5 + [0.01] * 4)
    ends = motion_map({5: "p" * 5}, u=np.full(5, 15.0))
    ends.arrays["nontrivial_exponent"] = np.array([-0.3, -0.002, -0.1, -np.inf, np.nan])
    made = {"survival_long": runs, "motion_map": ends}
    also = measured("u15-aperiodic", EXACT, **made).also
    assert also["exponent"].value == 0.0 and also["nontrivial exponent"].value == -0.1
    alone = measured("u15-aperiodic", EXACT, survival_long=runs).also
    assert np.isnan(alone["nontrivial exponent"].value)


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
IN_WINDOW = settled([2e6] * 16, u=np.repeat(np.arange(12.0, 16), 4), duration=2e6)


def diagram(windows, *, values=20, crossings=5000, u=None, n_blocks=5):
    """Bifurcation diagram of the scheme that shows so many values in windows, else a band of 90."""
    u = np.arange(1.0, 16) if u is None else u
    filled = np.where(np.isin(u, windows), values, 90)
    counts = crossings / filled[:, None] * (np.arange(120) < filled[:, None])
    counts[:, -5:] = 0.01 * crossings  # strays, 5 % of the crossings
    return scan(n_blocks, u, 0.1, method="verlet", section_histogram=counts)


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
def test_permanent_chaos_outside_the_windows_of_the_diagram(lasting, verdict):
    runs = joined(four_at_each(lasting), IN_WINDOW)
    made = {"survival_scheme": runs, "survival_long": runs}
    made["n5_density"] = diagram(np.arange(12.0, 16))
    assert both("permanent-chaos", **made) == (verdict, verdict)


def test_runs_at_one_velocity_that_end_alike_tell_less():
    made = {"n5_density": diagram(np.arange(12.0, 16))}
    reach = []
    for lasting in ([2] * 10, [4, 0] * 5):
        runs = joined(four_at_each(lasting), IN_WINDOW)
        numbers = measured("permanent-chaos", survival_scheme=runs, **made).judged
        share = numbers["irregular for 1e6"]
        assert share.value == 0.5 and share.runs == 40
        reach.append(share.high - share.low)
    assert reach[1] > 1.5 * reach[0]


def test_windows_are_those_of_the_diagram_whatever_the_judged_runs_do():
    runs = joined(four_at_each([0] * 10), IN_WINDOW)
    for values, crossings, left in ((21, 5000, 40), (22, 5000, 56), (21, 90, 56)):
        shown = diagram(np.arange(12.0, 16), values=values, crossings=crossings)
        made = {"survival_scheme": runs, "survival_long": runs, "n5_density": shown}
        if crossings < 100:  # too few to tell
            with pytest.raises(NotEnoughDataError):
                measured("permanent-chaos", **made)
            continue
        for reading in (None, EXACT):
            measurement = measured("permanent-chaos", *filter(None, [reading]), **made)
            assert measurement.judged["irregular for 1e6"].runs == left


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


@pytest.mark.parametrize(
    ("windows", "periodic", "verdict"),
    [
        (0.2, 0.2, YES),
        (0.7, 0.7, NO),
        (0.0, 0.0, OPEN),
    ],  # none of so few velocities may be one in a hundred
)
def test_bands_and_windows_by_the_look_of_the_diagram(windows, periodic, verdict):
    """Means over parts of 0.5 in u, each with as many windows as another."""
    u = np.round(np.arange(1.05, 16.01, 0.05), 2)
    shown = diagram(u[np.arange(u.size) % 10 < 10 * windows], u=u)
    made = measured("bifurcation-sigma0", n5_density=shown).judged
    assert made["periodic"].value == pytest.approx(periodic) and made["periodic"].runs == 280
    assert made["chaotic"].value == pytest.approx(1 - periodic)
    assert grades("bifurcation-sigma0", n5_density=shown)[""] == verdict


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
        ("p" * 90, 1, 40, IN_PART),  # a counterexample
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


def test_nothing_of_a_saddle_counts_beyond_the_horizon():
    """Ends are counted up to half of the duration, however many later ones are known."""
    rng, duration = np.random.default_rng(1), 1e4
    life = rng.exponential(3000, 300)
    runs = {"irregular_exponent": rng.normal(0.01, 1e-3, 300), "lifetime": life.clip(max=duration)}
    runs["irregular_time"] = np.full(300, 2000.0)
    seen = [
        saddle(runs | {"settled": life < share * duration}, duration, since=1000.0)
        for share in (0.5, 0.7, 1.0)
    ]
    assert len({str(one) for one in seen}) == 1
    assert seen[0]["lifetime"].low < 3000 < seen[0]["lifetime"].high
