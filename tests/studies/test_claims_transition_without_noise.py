"""Claims on the fall of r without noise and what lies beyond it, on runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.store import Dataset
from beltrepro.replication.studies.transition.measure import on_shared_orbits, until_last_stick
from beltrepro.replication.verdicts.criteria import IN_PART, NO, OPEN, YES
from beltrepro.replication.verdicts.evidence import EXACT
from made_up import (
    both,
    escapes,
    few_resamples,  # noqa: F401
    grades,
    joined,
    measured,
    motion_map,
    scan,
    scan_of_laws,
    settled,
)

U = [6, 8, 10, 12, 13, 14, 15, 15.5, 16, 16.5, 17, 17.5, 18, 19, 20, 21, 22, 24, 28, 33]

# --- the fall of r --------------------------------------------------------------------------------


def falling(at=16.5, high=0.13, low=0.02, scatter=0.003):
    def disorder(u, rng):
        return (high if u + rng.normal(0, 0.3) < at else low) * (1 + rng.normal(0, scatter / high))

    return disorder


def replicates(**how):
    """Runs by the scheme, and the same as exact ones and from wider starts."""
    names = ("n5_replicates_check", "n5_replicates", "n5_replicates_wide")
    return dict.fromkeys(names, scan_of_laws(U, falling(**how)))


FINE = np.arange(13, 24.01, 0.05)


def fine(stray=0.0, **how):
    """The row from the declared start and exact runs, a share of them of large r."""
    made = {}
    for name, runs in (("n5_density", 1), ("fall_orbits", 4)):
        made[name] = scan_of_laws(FINE, falling(**how), replicates=runs)
        arrays = made[name].arrays
        beyond = np.flatnonzero(arrays["belt_velocity"] > 17)
        arrays["disorder_parameter"][beyond[37 * np.arange(beyond.size) % 100 < 100 * stray]] = 0.12
        arrays["settled"] = np.full(arrays["belt_velocity"].size, True)
    return made


@pytest.mark.parametrize(
    ("how", "verdict"),
    [
        ({}, YES),
        ({"high": 0.1, "low": 0.035}, IN_PART),  # a ratio of 2.9, but all runs have fallen
        ({"high": 0.1, "low": 0.07}, NO),
        ({"low": 0.003}, IN_PART),  # a ratio of 43
        ({"low": 0.01005, "scatter": 0.02}, OPEN),
        ({"stray": 0.45}, IN_PART),  # the medians have fallen, but not most of the runs
    ],
)
def test_r_on_both_sides_of_the_transition(how, verdict):
    assert both("r-jump", **fine(**how)) == (verdict, verdict)


def test_runs_of_large_r_count_in_the_medians_beyond_the_transition():
    answer = grades("r-jump", **fine(stray=0.85))
    assert (answer["r beyond the fall"], answer["ratio"], answer["small r"]) == (NO, NO, NO)


@pytest.mark.parametrize(("at", "verdict"), [(16.5, YES), (17.4, IN_PART), (22.5, NO)])
def test_the_critical_velocity_is_the_printed_one_or_in_its_region(at, verdict):
    made = replicates(at=at)
    assert both("u-critical", **made) == (verdict, verdict)
    numbers = measured("u-critical", **made).numbers
    assert numbers["critical"].value == pytest.approx(at, abs=0.8)
    assert numbers["lower"].value < numbers["upper"].value


# --- periodic motion and outliers -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("periodic", "low", "verdicts"),
    [
        (0.03, 0.02, (YES, YES)),
        (0.07, 0.02, (YES, IN_PART)),  # smaller, but not much
        (0.12, 0.049, (NO, NO)),
        (None, 0.02, (YES, OPEN)),
    ],
)
def test_r_of_periodic_motion_beyond_the_transition_and_below(periodic, low, verdicts):
    """Irregular runs, and those beyond u = 15, have another r."""
    made = fine(low=low)
    spread = (
        np.resize([0.03, 0.12], 20) if periodic is None else np.linspace(0.99, 1.01, 20) * periodic
    )
    u = [*np.linspace(1, 15, 26), *np.linspace(15.5, 50, 10)]
    disorder = [*spread, *[0.5] * 6, *[0.5] * 10]
    made["motion_map"] = motion_map({5: "p" * 20 + "c" * 6 + "p" * 10}, u=u, disorder=disorder)
    assert both("r-windows", **made) == verdicts
    value = measured("r-windows", EXACT, **made).judged["periodic below"].value
    assert value == pytest.approx((periodic or 0.075) / 0.13, rel=0.02)


def of_large_r(places, label, u):
    return scan_of_laws(
        u,
        lambda place, rng: 0.12 if place in places else falling()(place, rng),
        replicates=1,
        labels=lambda place: label if place in places else "continuous",
    )


@pytest.mark.parametrize(
    ("places", "label", "verdict"),
    [
        ((20, 20.5, 21.5), "periodic", YES),
        ((20, 21, 22), "periodic", IN_PART),
        ((20, 20.5, 21.5), "chaotic", IN_PART),
        ((21,), "chaotic", NO),
    ],
)
def test_outlying_points_of_the_row(places, label, verdict):
    """Three, all regular, are printed; the row has three places inside 20 < u < 22."""
    runs = {"n5_rows": of_large_r(places, label, np.arange(14, 24, 0.5))}
    inside = sum(20 < place < 22 for place in places)
    assert measured("outliers", **runs).judged["outliers"].value == inside
    assert grades("outliers", **runs)[""] == verdict


@pytest.mark.parametrize(
    ("share", "settles", "verdict"),
    [(0.25, True, YES), (0.88, True, IN_PART), (0.88, False, NO), (0.5, True, OPEN)],
)
def test_whether_large_r_is_the_rule_beyond_the_transition(share, settles, verdict):
    """At the ends of 20 < u < 22 all runs have large r, and they do not count."""
    made = fine(share)["fall_orbits"]
    u = made.arrays["belt_velocity"]
    made.arrays["disorder_parameter"][(np.abs(u - 21) > 0.99) & (u > 19)] = 0.12
    made.arrays["settled"][:] = settles
    answer = measured("outliers", EXACT, fall_orbits=made).judged["runs of large r"]
    assert answer.value == pytest.approx(share, abs=0.03)
    assert grades("outliers", "robust", fall_orbits=made)[""] == verdict


# --- u = 20 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("counts", "verdicts"),
    [
        ((60, 40, 0, 0), (YES, YES)),
        ((100, 0, 0, 0), (OPEN, YES)),  # a transient beyond 4000 in up to 3.6 %
        ((20, 10, 70, 0), (IN_PART, NO)),  # most end on stick-slip orbits
        ((0, 0, 200, 0), (NO, NO)),
    ],
)
def test_transients_at_u20(counts, verdicts):
    runs = escapes(*counts)
    made = {"lifetimes_wide": runs, "n5_rows": scan_of_laws([20], falling(), replicates=1)}
    size = sum(counts)
    # the same runs as exact ones, and others that must not count
    points = {"initial_spread": np.array([1.0, 0.001]), "time_step": np.array([0.001, 0.001])}
    arrays = {name: np.concatenate([values, values]) for name, values in runs.arrays.items()}
    arrays["escaped"][size:] = ~arrays["escaped"][size:]
    arrays |= {name: np.repeat(values, size) for name, values in points.items()}
    made["pairs_states_event"] = Dataset(arrays, runs.attributes)
    assert both("u20-transient", **made) == verdicts
    numbers = measured("u20-transient", **made).numbers
    assert numbers["r from the declared start"].value == pytest.approx(0.02, abs=0.01)
    ended = counts[0] + counts[1]
    longer = numbers["longer than 4000, of these"]
    assert longer.runs == ended if ended else np.isnan(longer.value)


# --- lifetimes against u --------------------------------------------------------------------------

PLACES = (18.0, 20.0, 21.0, 24.0, 27.0, 30.0, 33.0, 35.0)


def growing(near=4000.0, far=400.0):
    """tau that falls from `near` at u = 18 to `far` at u = 35, exponentially."""
    return {u: near * (far / near) ** ((u - 18) / 17) for u in PLACES}


def draw(tau, *, runs=200, duration=2e5, seed=1):
    """Exponential lifetimes by u, runs that last on cut at the duration."""
    rng = np.random.default_rng(seed)
    u = np.repeat(list(tau), runs)
    return u, np.minimum(rng.exponential(np.repeat(list(tau.values()), runs)), duration)


def settling(tau, *, spread=10.0, **options):
    u, lifetime = draw(tau, **options)
    return settled(lifetime, u=u, spread=spread, duration=options.get("duration", 2e5))


def escaping(tau, *, stuck=0.0, duration=1e4, **options):
    """Runs followed until the last block slips for good, some on stick-slip attractors."""
    u, lifetime = draw(tau, duration=duration, **options)
    lifetime[np.random.default_rng(2).random(u.size) < stuck] = duration
    arrays = {"n_blocks": np.full(u.size, 5), "belt_velocity": u, "lifetime": lifetime}
    attributes = {"duration": duration, "settle_time": 2000.0}
    return Dataset(arrays | {"escaped": lifetime < duration}, attributes)


def test_what_ends_within_the_time_of_settling_tells_nothing():
    """Whether it has escaped or when, the mean time until the last stick is the same."""
    runs = escaping(dict.fromkeys(PLACES, 8000.0))
    late = runs.arrays["lifetime"] > 8000
    means = []
    for lifetime, escaped in ((1e4, False), (9000.0, True), (9900.0, True)):
        runs.arrays["lifetime"][late], runs.arrays["escaped"][late] = lifetime, escaped
        means.append(until_last_stick(runs).mean(0, 50).numbers)
    assert means[0] == means[1] == means[2] and means[0][1] < 8000 < means[0][2]


@pytest.mark.parametrize(
    ("tau", "verdict"),
    [
        (growing(), YES),
        (growing(400.0, 4000.0), IN_PART),  # short, but longer away from the transition
        (growing(6000.0, 60_000.0), NO),
        (dict.fromkeys(PLACES, 1000.0), IN_PART),
    ],
)
def test_lifetimes_against_u(tau, verdict):
    runs = {"lifetimes_wide": escaping(tau, duration=4e5), "survival": settling(tau, duration=4e5)}
    runs["fall_orbits"] = settling(tau, spread=7.0, duration=4e5, seed=3)
    assert both("transient-lifetime", **runs) == (verdict, verdict)
    longest = measured("transient-lifetime", **runs).also["u of the longest"]
    expected = PLACES[int(np.argmax(list(tau.values())))]
    assert longest.low <= expected <= longest.high
    assert (longest.high - longest.low > 8) == (len(set(tau.values())) == 1)


@pytest.mark.parametrize("duration", [2e5, 6000.0])
def test_lifetimes_are_those_put_in(duration):
    """With runs given up or not; beyond the range, and of other starts, runs do not count."""
    tau = {u: (3000.0 if u <= 21 else 1000.0 if u < 30 else 500.0) for u in PLACES}
    runs = joined(
        settling(tau, duration=duration),
        settling({17.5: 1e5, 36.0: 1e5}, seed=2, duration=duration),
        settling(dict.fromkeys(PLACES, 9000.0), spread=1.0, duration=duration),
    )
    near = settling(tau, spread=7.0, seed=3, duration=duration)
    numbers = measured("transient-lifetime", EXACT, survival=runs, fall_orbits=near).numbers
    expected = {"lifetime near": 3000, "lifetime far": 500, "near the fall over far": 6}
    for name, value in expected.items():
        assert numbers[name].low < value < numbers[name].high
    ends = 1562 if duration > 1e5 else 1562 * 0.86  # of a mixture, the longest of which are cut
    assert numbers["mean lifetime"].value == pytest.approx(ends, rel=0.1)


def test_runs_that_never_escape_say_nothing_of_the_lifetime():
    """A third of all runs, and all at one velocity, stay on stick-slip attractors."""
    runs = escaping(growing(2000.0, 400.0), stuck=0.33)
    alone = runs.arrays["belt_velocity"] == 20.0
    runs.arrays["escaped"][alone] = False
    made = measured("transient-lifetime", lifetimes_wide=runs)
    assert made.also["lifetime near"].value == pytest.approx(1850, rel=0.15)
    assert made.also["lifetime far"].value == pytest.approx(470, rel=0.15)


def test_runs_share_an_orbit_if_three_have_its_range_and_sticks():
    """Two may agree by chance; sticks are counted up to the ends of the settled part."""
    reach = np.array([50.0, 50.0, 80.0, 90.0, 90.05, 90.08, 90.2])
    runs = {"final_amplitude": reach, "final_stick_rate": np.full((7, 5), 0.1)}
    runs["final_stick_rate"][:, 4] = np.nan  # of a shorter chain
    for sticks, shared in ((0, 3), (2, 3), (3, 0)):
        runs["final_stick_rate"][5, 0] = 0.1 + sticks / 1000
        expected = [False] * 3 + [shared == 3] * 3 + [False]
        assert on_shared_orbits(runs, 1000.0).tolist() == expected


# --- continuous slip ------------------------------------------------------------------------------


def slipping(u, share):
    """Runs of which this share slips on; the others stick to the end."""
    order = np.random.default_rng(3).permutation(len(u))
    slips = (np.arange(len(u)) < share * len(u))[order]
    last, laminar = np.where(slips, np.nan, 1e6), np.where(slips, 1.0, 0.9)
    return scan(5, u, 0.02, last_stick_time=last, laminar_fraction=laminar)


ROW, LOW, HIGH = np.linspace(18, 50, 641), np.linspace(18, 36, 109), np.linspace(38, 50, 121)


@pytest.mark.parametrize(
    ("row", "low", "high", "verdicts"),
    [
        (1.0, 1.0, 1.0, (YES, YES)),
        (0.75, 0.7, 1.0, (IN_PART, IN_PART)),  # the usual end
        (0.3, 0.3, 0.2, (NO, NO)),
        (0.85, 0.82, 1.0, (IN_PART, OPEN)),
    ],
)
def test_continuous_slip(row, low, high, verdicts):
    made = {
        "n5_density": slipping(ROW, row),
        "n5_replicates": slipping(LOW, low),
        "n5_replicates_beyond": slipping(HIGH, high),
    }
    assert both("continuous-slip", **made) == verdicts


def test_a_late_stick_and_the_range_of_u():
    """Sticks in the first half after the transient are those of a transient."""
    row = slipping(np.linspace(15, 53, 153), 1.0)
    inside = (row.arrays["belt_velocity"] >= 18) & (row.arrays["belt_velocity"] <= 50)
    middle = (2e5 + 1e6) / 2
    runs = dict.fromkeys(("n5_replicates", "n5_replicates_beyond"), row)
    for last, share in ((middle - 1, 1), (middle, 0)):
        row.arrays["last_stick_time"] = np.where(inside, last, 1e6)
        assert (
            measured("continuous-slip", EXACT, **runs).judged["slips on, u = 18 to 36"].value
            == share
        )
