"""Claims on chaotic motion by made-up runs: values, both sides of checks, and what stays open."""

import math

import numpy as np
import pytest
from scipy import stats

from beltrepro.analysis import dimension
from beltrepro.analysis.errors import NotEnoughDataError
from beltrepro.analysis.motion import CHAOTIC, EQUILIBRIUM, PERIODIC, QUASI_PERIODIC, TRANSIENT
from beltrepro.claims import motion
from made_up import REGISTRY, Stub, cut, data, measured, passed, transition

NAMES = {
    "e": EQUILIBRIUM,
    "p": PERIODIC,
    "q": QUASI_PERIODIC,
    "c": CHAOTIC,
    "t": TRANSIENT,
}
WIDE, NARROW = 10.0, 1.0  # spreads of starts
STARTS = "starts spread by 10"
ABOVE = np.full(8, 0.002) + np.tile([-1e-4, 1e-4], 4)
CLEAR, SHORT = 2e5, 99_999.0  # durations on both sides of the shortest that decide


def followed(lifetime, *, u, spread=WIDE, exponents=ABOVE, state=PERIODIC, duration=CLEAR):
    """Runs of five blocks with these lifetimes; those of `duration` did not settle."""
    lifetime = np.array(lifetime, dtype=float)
    size, settled = lifetime.size, lifetime < duration
    arrays = {
        "n_blocks": np.full(size, 5),
        "belt_velocity": np.full(size, u),
        "initial_spread": np.full(size, spread),
        "lifetime": lifetime,
        "settled": settled,
        "state": np.where(settled, state, "irregular"),
        "irregular_exponent": np.resize(exponents, size).astype(float),
    }
    return data(arrays, duration=duration)


def joined(*datasets):
    """Datasets of one duration as one."""
    arrays = {
        name: np.concatenate([each.arrays[name] for each in datasets])
        for name in datasets[0].arrays
    }
    return data(arrays, **datasets[0].attributes)


def motion_map(letters, *, u=None, duration=CLEAR):
    """Runs by number of blocks: a letter for each motion, at u = 1, 2, ... if not given."""
    velocity = [np.arange(1.0, len(own) + 1) if u is None else u for own in letters.values()]
    arrays = {
        "n_blocks": np.repeat(list(letters), [len(own) for own in letters.values()]),
        "belt_velocity": np.concatenate(velocity),
        "state": np.array([NAMES[letter] for letter in "".join(letters.values())]),
    }
    return {"motion_map": data(arrays, duration=duration, transient=duration / 2)}


# --- shares with open runs ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("known", "unknown", "outcome"),
    [(5, 0, True), (5, 5, True), (4, 0, False), (0, 4, False), (4, 1, None), (0, 10, None)],
)
def test_a_check_of_a_share_is_open_where_open_runs_decide(known, unknown, outcome):
    share = motion.Share(known, unknown, 10)
    if outcome is None:
        message = f"{known} of 10 runs, {unknown} more are open and decide: longer runs are needed"
        with pytest.raises(NotEnoughDataError, match=message):
            motion.decided(lambda value: value >= 0.5, share)
    else:
        assert motion.decided(lambda value: value >= 0.5, share) is outcome


def test_open_runs_of_several_shares_may_differ():
    """Both orders of two shares are possible, though all known or all open give the same."""
    first, second = motion.Share(4, 2, 10), motion.Share(5, 2, 10)
    assert first.low < second.low and first.high < second.high
    with pytest.raises(NotEnoughDataError, match="4, 5 of 10, 10 runs, 2, 2 more"):
        motion.decided(lambda a, b: a < b, first, second)
    assert motion.decided(lambda a, b: a < b, first, motion.Share(7, 0, 10)) is True


def test_chaos_counts_only_where_it_was_seen_for_long():
    names = np.array([NAMES[letter] for letter in "ccctteqppp"])
    for duration, chaotic, periodic in (
        (1e5, motion.Share(3, 2, 10), motion.Share(3, 2, 10)),
        (SHORT, motion.Share(0, 5, 10), motion.Share(3, 5, 10)),
    ):
        runs = motion.Motions(names, duration)
        assert (runs.share(CHAOTIC), runs.share(PERIODIC)) == (chaotic, periodic)
    assert "3 chaotic, 1 equilibrium slip, 3 periodic" in runs.words


# --- section of phase space -----------------------------------------------------------------------


def test_the_section_points_leave_out_the_coordinate_that_the_section_fixes(monkeypatch):
    rng = np.random.default_rng(4)
    points = np.zeros(1200, [("positions", "f8", (3,)), ("velocities", "f8", (3,))])
    points["positions"], points["velocities"] = rng.random((2, 1200, 3))
    points["velocities"][:400, 2] = 1.0  # stuck
    runs = {"survival": followed([1e5] * 8, u=1.0)}
    made = runs | {"slips_u1": data({"section": points}, belt_velocity=1.0)}
    seen = []

    def record(coordinates):
        seen.append(coordinates)
        nothing = np.zeros(0)
        return dimension.DimensionFit(1.5, 0.1, 2.0, 3.0, len(coordinates), nothing, nothing)

    monkeypatch.setattr(dimension, "correlation_dimension", record)
    readings = REGISTRY["poincare"](Stub("poincare", datasets=made))
    found = [reading() for reading in readings.values()]
    x, v = points["positions"], points["velocities"]
    state = np.column_stack([x[:, 0], x[:, 2], v])
    np.testing.assert_array_equal(seen[0], state)
    np.testing.assert_array_equal(seen[1], state[400:])
    np.testing.assert_array_equal(seen[2], np.column_stack([x[400:, 2], v[400:, 2]]))
    assert [each.sample_size for each in found] == [1200, 800, 800]
    assert (found[0].value, found[0].uncertainty) == (1.5, 0.1) and "2 to 3" in found[0].note
    assert [passed(each) for each in found] == [[1]] * 3
    assert "motion 0.002, error 4e-05; 8 of 8 runs settled within 200000" in found[0].note
    made["survival"] = followed([1e5] * 8, u=1.0, exponents=-ABOVE)
    assert passed(measured("poincare", "all nine coordinates", datasets=made)) == [0]
    made["slips_u1"] = data({"section": points[:999]}, belt_velocity=1.0)
    with pytest.raises(NotEnoughDataError, match="999 section points, 1000 are needed"):
        measured("poincare", datasets=made)


# --- runs that are followed until they settle -----------------------------------------------------


@pytest.mark.parametrize(
    ("lifetime", "checks"),
    [
        ([1e5] * 4 + [99_999] * 4, [1, 1]),  # settled, but late enough
        ([CLEAR] * 4 + [500] * 4, [1, 1]),
        ([1e5] * 3 + [99_999] * 5, [0, 1]),
    ],
)
def test_aperiodic_motion_at_u15(lifetime, checks):
    made = {"survival": followed(lifetime, u=15.0)}
    found = measured("u15-aperiodic", STARTS, datasets=made)
    assert passed(found) == checks and found.sample_size == 8
    assert found.value["share irregular for 1e5"] == sum(time >= 1e5 for time in lifetime) / 8
    assert found.value["median lifetime"] == np.median(lifetime)
    assert found.value["exponent"] == pytest.approx(0.002)
    assert found.uncertainty["exponent"] == pytest.approx(stats.sem(ABOVE))
    left = sum(time == CLEAR for time in lifetime)
    assert f"{8 - left} of 8 runs settled within 200000" in found.note


def test_short_runs_at_u15_leave_it_open_where_they_decide():
    open_runs = {"survival": followed([SHORT] * 4 + [500] * 4, u=15.0, duration=SHORT)}
    with pytest.raises(NotEnoughDataError, match="0 of 8 runs, 4 more are open"):
        measured("u15-aperiodic", STARTS, datasets=open_runs)
    enough = {"survival": followed([SHORT] * 3 + [500] * 5, u=15.0, duration=SHORT)}
    assert passed(measured("u15-aperiodic", STARTS, datasets=enough)) == [0, 1]


@pytest.mark.parametrize(
    ("exponents", "met"),
    [
        # deviations of 1 from the mean: a standard error of 1/sqrt(7), three are 1.134
        (1.13 + np.tile([-1, 1], 4), 0),
        (1.14 + np.tile([-1, 1], 4), 1),
        # three of them: 2/sqrt(6), three are 2.449
        ([2.46, 1.46, 3.46, *[math.nan] * 5], 1),
        ([1.7, 0.7, 2.7, *[math.nan] * 5], 0),
        ([5.0, 5.1, *[math.nan] * 6], 0),  # two are no sample
        ([math.nan] * 8, 0),
        ([0.0] * 8, 0),
    ],
)
def test_exponents_against_their_scatter_over_the_runs(exponents, met):
    made = {"survival": followed([1e5] * 8, u=15.0, exponents=exponents)}
    assert passed(measured("u15-aperiodic", STARTS, datasets=made)) == [1, met]


def test_an_exponent_is_missing_only_if_all_motion_settled_too_soon():
    """Of runs that are still irregular, longer ones would have it."""
    none = np.full(8, math.nan)
    soon = followed([400.0] * 8, u=15.0, exponents=none, duration=1000.0)
    found = measured("u15-aperiodic", STARTS, datasets={"survival": soon})
    assert passed(found) == [0, 0] and math.isnan(found.value["exponent"])
    one = followed([400.0] * 7 + [1000.0], u=15.0, exponents=none, duration=1000.0)
    with pytest.raises(NotEnoughDataError, match=r"7 of 8 runs .* needed for an exponent"):
        measured("u15-aperiodic", STARTS, datasets={"survival": one})


@pytest.mark.parametrize(
    ("lifetime", "state", "checks"),
    [
        ([1000] * 8, PERIODIC, [1, 1, 1]),
        ([1000] * 4 + [999] * 4, PERIODIC, [1, 1, 1]),
        ([1000] * 3 + [999] * 5, PERIODIC, [1, 0, 1]),
        ([CLEAR] * 4 + [1000] * 4, PERIODIC, [1, 1, 1]),
        ([CLEAR] * 5 + [1000] * 3, PERIODIC, [0, 1, 1]),
        ([1000] * 8, EQUILIBRIUM, [0, 1, 1]),
        ([1000] * 8, [PERIODIC] * 4 + [EQUILIBRIUM] * 4, [1, 1, 1]),
    ],
)
def test_the_transient_at_u7(lifetime, state, checks):
    made = {"survival": followed(lifetime, u=7.0, state=state)}
    found = measured("u7-transient-chaos", STARTS, datasets=made)
    assert passed(found) == checks and found.sample_size == 8
    assert found.value["median lifetime"] == np.median(lifetime)
    assert found.value["exponent"] == pytest.approx(0.002)
    assert found.uncertainty["exponent"] == pytest.approx(stats.sem(ABOVE))
    low = {"survival": followed(lifetime, u=7.0, state=state, exponents=-ABOVE)}
    assert passed(measured("u7-transient-chaos", STARTS, datasets=low)) == [*checks[:2], 0]


@pytest.mark.parametrize(
    ("lifetime", "duration", "message"),
    [
        ([SHORT] * 5 + [1000] * 3, SHORT, "3 of 8 runs, 5 more are open"),
        ([900] * 4 + [800] * 4, 900, "0 of 8 runs, 4 more are open"),
    ],
)
def test_short_runs_at_u7_leave_it_open_where_they_decide(lifetime, duration, message):
    made = {"survival": followed(lifetime, u=7.0, duration=duration)}
    with pytest.raises(NotEnoughDataError, match=message):
        measured("u7-transient-chaos", STARTS, datasets=made)


@pytest.mark.parametrize("name", ["u15-aperiodic", "u7-transient-chaos"])
def test_starts_of_each_spread_are_a_reading(name):
    u = {"u15-aperiodic": 15.0, "u7-transient-chaos": 7.0}[name]
    wide, narrow = (
        followed([1e5] * 8, u=u, spread=spread, exponents=scale * ABOVE)
        for spread, scale in ((WIDE, 1), (NARROW, 2))
    )
    elsewhere = followed([1e5] * 8, u=u + 0.5, exponents=9 * ABOVE)
    readings = REGISTRY[name](Stub(name, datasets={"survival": joined(narrow, elsewhere, wide)}))
    assert list(readings) == [STARTS, "starts spread by 1"]
    found = [reading().value["exponent"] for reading in readings.values()]
    assert found == pytest.approx([0.002, 0.004])
    few = {"survival": followed([1e5] * 7, u=u)}
    with pytest.raises(NotEnoughDataError, match=f"7 runs at u = {u:g} from starts spread by 10"):
        measured(name, STARTS, datasets=few)
    with pytest.raises(NotEnoughDataError, match=r"no run with .*initial_spread = 1 in"):
        measured(name, "starts spread by 1", datasets=few)


def test_the_longest_runs_at_a_point_serve():
    lengths = {"survival_long": 9e6, "survival_many": 5e5, "survival": 2e5}
    made = {name: followed([1e5] * 8, u=15.0, duration=time) for name, time in lengths.items()}
    for name, time in lengths.items():
        found = measured("u15-aperiodic", STARTS, datasets=made)
        assert f"within {time:g}" in found.note
        made[name].arrays["n_blocks"][:] = 6


# --- motions --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("letters", "checks"),
    [
        ("cccccceeeeep", [1, 1]),
        ("cccccceeeeee", [1, 0]),
        ("ccccceeeeeep", [0, 1]),
        ("ccccccttttpp", [1, 1]),
        ("cceeeeeetttp", [0, 1]),
    ],
)
def test_bands_and_windows_up_to_u15(letters, checks):
    u = [0.9, *np.linspace(1, 15, 12), 15.1]
    made = motion_map({5: f"p{letters}c"}, u=u)
    found = measured("bifurcation-sigma0", datasets=made)
    assert passed(found) == checks and found.sample_size == 12
    shares = {"chaotic share": letters.count("c") / 12, "periodic share": letters.count("p") / 12}
    assert found.value == shares
    assert f"{letters.count('c')} chaotic, " in found.note


@pytest.mark.parametrize(
    ("letters", "duration"),
    [
        ("cccccteeeeep", CLEAR),
        ("cccccceeeeet", CLEAR),  # the open run may be periodic, and none else is
        ("cccccceeeeep", SHORT),
    ],
)
def test_bands_and_windows_are_open_where_irregular_runs_decide(letters, duration):
    made = motion_map({5: letters}, duration=duration)
    with pytest.raises(NotEnoughDataError, match="longer runs are needed"):
        measured("bifurcation-sigma0", datasets=made)


def test_chaotic_runs_beyond_the_transition():
    letters = "c" + "c" * 3 + "p" * 13 + "e" * 4 + "c"
    u = [17.9, 18.0, *np.linspace(19, 49, 18), 50.0, 50.1]
    found = measured("no-permanent-chaos", datasets=motion_map({5: letters}, u=u))
    assert (found.value, found.sample_size) == (0.15, 20)
    assert found.uncertainty == pytest.approx(math.sqrt(0.15 * 0.85 / 20))
    assert found.note == "3 chaotic, 4 equilibrium slip, 13 periodic"
    assert measured("no-permanent-chaos", datasets=motion_map({5: "p" * 60})).value == 0
    with pytest.raises(NotEnoughDataError, match="7 runs with N = 5, 18 <= u <= 50, 8 are needed"):
        measured("no-permanent-chaos", datasets=motion_map({5: "p" * 24}))
    with pytest.raises(NotEnoughDataError, match="no run with n_blocks = 5 in motion_map"):
        measured("no-permanent-chaos", datasets=motion_map({6: "p" * 24}))


@pytest.mark.parametrize(
    ("letters", "duration", "value"),
    [
        ("p" * 99 + "t", CLEAR, None),  # none, or up to 5 %
        ("p" * 99 + "c", SHORT, None),
        ("p" * 95 + "ccctt", CLEAR, 0.03),
        ("p" * 94 + "cccttt", CLEAR, None),  # up to 5 %, or more
        ("p" * 86 + "ccct" + "t" * 10, CLEAR, None),
        ("p" * 60 + "c" * 30 + "t" * 10, CLEAR, 0.3),
    ],
)
def test_permanent_chaos_is_open_where_the_verdict_depends_on_it(letters, duration, value):
    made = motion_map({5: letters}, u=np.linspace(18, 50, 100), duration=duration)
    if value is None:
        with pytest.raises(NotEnoughDataError, match="longer runs are needed"):
            measured("no-permanent-chaos", datasets=made)
    else:
        assert measured("no-permanent-chaos", datasets=made).value == value


# --- lifetimes against u --------------------------------------------------------------------------

SETTLES = "until the motion settles, starts spread by 10"
ESCAPES = "until the last block slips for good, the paper's scheme"


def lifetimes_by(tau, *, ended="settled", n_blocks=5, duration=20_000.0, spread=WIDE):
    """Ten runs for each u of tau that all end at its tau."""
    u = np.repeat(list(tau), 10).astype(float)
    arrays = {
        "n_blocks": np.full(u.size, n_blocks),
        "belt_velocity": u,
        "initial_spread": np.full(u.size, spread),
        "lifetime": np.repeat(list(tau.values()), 10).astype(float),
        ended: np.full(u.size, True),
    }
    return data(arrays, duration=duration)


@pytest.mark.parametrize(
    ("tau", "checks"),
    [
        ({18.0: 1000, 21: 800, 25: 500, 30: 300, 35: 300}, [1, 1, 1]),
        ({18.0: 1000, 21: 799, 25: 500, 30: 300, 35: 300}, [0, 1, 1]),
        ({18.0: 9999, 21: 9999, 25: 500, 30: 300, 35: 300}, [1, 1, 1]),
        ({18.0: 10_000, 21: 9999, 25: 500, 30: 300, 35: 300}, [1, 1, 0]),
        ({18.0: 300, 21: 2000, 25: 100, 30: 350, 35: 200}, [1, 0, 1]),
    ],
)
def test_lifetimes_against_u(tau, checks):
    beyond = tau | {17.9: 1.0, 35.1: 9e3}
    six = lifetimes_by(dict.fromkeys(tau, 1.0), n_blocks=6)
    made = {"survival": joined(six, lifetimes_by(beyond))}
    found = measured("transient-lifetime", SETTLES, datasets=made)
    near, far = [tau[18.0], tau[21]], [tau[30], tau[35]]
    assert found.value["tau, u = 18 to 21"] == pytest.approx(np.mean(near))
    assert found.value["tau, u = 30 to 35"] == pytest.approx(np.mean(far))
    rank = stats.spearmanr(list(tau), list(tau.values())).statistic
    assert found.value["rank correlation"] == pytest.approx(rank)
    # tau/sqrt(10) each, joined over two velocities
    for name, own in (("tau, u = 18 to 21", near), ("tau, u = 30 to 35", far)):
        assert found.uncertainty[name] == pytest.approx(math.hypot(*own) / math.sqrt(10) / 2)
    assert found.sample_size == 50 and passed(found) == checks
    longest = max(tau, key=tau.get)
    assert f"longest {tau[longest]:.3g} at u = {longest:g}" in found.note


def test_the_readings_of_lifetimes_are_what_their_names_say():
    tau = {18.0: 1000, 21: 800, 25: 500, 30: 300, 35: 300}
    twice, thrice = ({u: scale * own for u, own in tau.items()} for scale in (2, 3))
    settling = joined(lifetimes_by(tau), lifetimes_by(twice, spread=NARROW))
    made = {"survival": settling, "lifetimes": lifetimes_by(thrice, ended="escaped", spread=0.001)}
    readings = REGISTRY["transient-lifetime"](Stub("transient-lifetime", datasets=made))
    assert list(readings) == [SETTLES, SETTLES.replace("10", "1"), ESCAPES]
    found = [reading().value["tau, u = 18 to 21"] for reading in readings.values()]
    assert found == [900, 1800, 2700]


def test_lifetimes_unknown_at_one_velocity_are_left_out():
    tau = {18.0: 1000, 19: 1.0, 21: 800, 25: 500, 30: 300, 35: 200}
    made = {"survival": lifetimes_by(tau, duration=1e4)}
    made["survival"].arrays["settled"][10:18] = False
    found = measured("transient-lifetime", SETTLES, datasets=made)
    assert found.value["tau, u = 18 to 21"] == 900 and found.sample_size == 60
    assert passed(found) == [1, 1, 0]
    made["survival"].attributes["duration"] = 9999.0
    with pytest.raises(NotEnoughDataError, match="1 lifetimes need longer runs"):
        measured("transient-lifetime", SETTLES, datasets=made)
    made["survival"] = lifetimes_by(tau)
    eight = {name: values[2:] for name, values in made["survival"].arrays.items()}
    made["survival"] = data(eight, duration=1e4)
    assert measured("transient-lifetime", SETTLES, datasets=made).sample_size == 58
    made["survival"] = data({name: own[1:] for name, own in eight.items()}, duration=1e4)
    with pytest.raises(NotEnoughDataError, match="7 runs at a belt velocity, 8 are needed"):
        measured("transient-lifetime", SETTLES, datasets=made)
    few = lifetimes_by({18.0: 1000, 21: 800, 30: 300, 35: 300})
    with pytest.raises(NotEnoughDataError, match="lifetimes at 4 belt velocities"):
        measured("transient-lifetime", SETTLES, datasets={"survival": few})
    for tau in (dict.fromkeys(range(18, 30), 900.0), dict.fromkeys(range(22, 36), 900.0)):
        with pytest.raises(NotEnoughDataError, match="on one side"):
            measured("transient-lifetime", SETTLES, datasets={"survival": lifetimes_by(tau)})


# --- other numbers of blocks ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("letters", "fall", "checks"),
    [
        ("p" * 20, transition(1, 2, found=False), [1, 1]),
        ("p" * 98 + "qe", transition(1, 2, found=False), [1, 1]),
        ("p" * 96 + "ccct", transition(1, 2, error=2.0), [1, 1]),
        ("p" * 95 + "ccccc", transition(1, 2, error=2.0), [0, 1]),
        ("p" * 90 + "ccccc" + "ttttt", transition(1, 2, error=1.9), [0, 0]),
    ],
)
def test_small_chains_are_regular(letters, fall, checks):
    plain = transition(1, 2, found=False)
    rows = {(2, 0.0): cut(fall=fall), (3, 0.0): cut(fall=plain), (4, 0.0): cut(fall=plain)}
    made = motion_map({2: letters, 3: "p" * 20, 4: "p" * 20})
    found = measured("small-n-regular", rows=rows, datasets=made)
    assert found.value["N = 2, chaotic share"] == letters.count("c") / len(letters)
    assert passed(found) == [*checks, 1, 1, 1, 1] and found.sample_size == len(letters) + 40


@pytest.mark.parametrize(
    ("letters", "duration"), [("p" * 95 + "cccct", CLEAR), ("p" * 95 + "ccccc", SHORT)]
)
def test_small_chains_are_open_where_irregular_runs_decide(letters, duration):
    rows = {(2, 0.0): cut(fall=transition(1, 2, found=False))}
    with pytest.raises(NotEnoughDataError, match="longer runs are needed"):
        measured("small-n-regular", rows=rows, datasets=motion_map({2: letters}, duration=duration))


SIZES = (5, 6, 7, 10)


def chaos_from(letters, widths, *, edge=8, found=(True,) * 4, duration=CLEAR):
    """Runs of each size up to the lower edge, and periodic ones beyond that do not count."""
    rows = {
        (n, 0.0): cut(fall=transition(edge, edge + width, found=there))
        for n, width, there in zip(SIZES, widths, found, strict=True)
    }
    made = motion_map(
        {n: own + "pppp" for n, own in zip(SIZES, letters, strict=True)}, duration=duration
    )
    return measured("chaos-from-n5", rows=rows, datasets=made)


@pytest.mark.parametrize(
    ("letters", "widths", "checks"),
    [
        (("cccceppp", "cccccepp", "cccccceq", "cccccccc"), (1, 2, 3, 4), [1, 1, 1, 1, 1, 1]),
        (("ccceeppp", "cccccepp", "cccccceq", "cccccccc"), (1, 2, 3, 4), [0, 1, 1, 1, 1, 1]),
        (("ccccpppp", "cccceeee", "ccccpppe", "ccceeppp"), (1, 2, 3, 4), [1, 1, 1, 0, 0, 1]),
        (("ccccpppp", "cccccepp", "cccccceq", "cccccccc"), (2, 1, 4, 3), [1, 1, 1, 1, 1, 1]),
        (("ccccpppp", "cccccepp", "cccccceq", "cccccccc"), (2, 4, 1, 3), [1, 1, 1, 1, 1, 0]),
        (("ccccpppp", "cccctpee", "ccccceee", "cccccccc"), (1, 2, 3, 4), [1, 1, 1, 1, 1, 1]),
    ],
)
def test_chaos_from_five_blocks_on(letters, widths, checks):
    found = chaos_from(letters, widths)
    for n, own, width in zip(SIZES, letters, widths, strict=True):
        assert found.value[f"N = {n}, chaotic share"] == own.count("c") / 8
        assert found.value[f"N = {n}, periodic share"] == own.count("p") / 8
        assert found.value[f"N = {n}, width"] == width
    assert passed(found) == checks and found.sample_size == 32


def test_chaos_from_five_blocks_on_without_some_transitions():
    letters = ("ccccpppp", "c" * 15, "ccccccpe", "cccccccc")
    found = chaos_from(letters, (1, 2, 3, 4), found=(True, False, True, True))
    assert "N = 6, width" not in found.value and found.sample_size == 24 + 15
    assert found.value["N = 6, chaotic share"] == 1  # up to u = 15, without a transition
    assert passed(found)[-1] == 1
    half = chaos_from(letters, (1, 2, 4, 3), found=(True, False, True, True))
    assert passed(half)[-1] == 0  # a rank correlation of 0.5 is not enough
    with pytest.raises(NotEnoughDataError, match="found for 2 numbers of blocks"):
        chaos_from(letters, (1, 2, 3, 4), found=(True, False, False, True))


@pytest.mark.parametrize(
    ("letters", "duration", "message"),
    [
        (("ccctpppp", "ccccccpe", "cccccccp", "cccccccc"), CLEAR, "3 of 8 runs, 1 more"),
        # the periodic shares fall with N if the open runs are chaotic, and rise if not
        (("ccccpppp", "cccctppp", "cccctttp", "ccccttte"), CLEAR, "4, 3, 1, 0 of 8, 8, 8, 8 runs"),
        (("ccccpppp", "ccccccpe", "cccccccp", "cccccccc"), SHORT, "0 of 8 runs, 4 more"),
    ],
)
def test_chaos_from_five_blocks_on_is_open_where_irregular_runs_decide(letters, duration, message):
    with pytest.raises(NotEnoughDataError, match=message):
        chaos_from(letters, (1, 2, 3, 4), duration=duration)


@pytest.mark.parametrize(("richest", "met"), [(4, 1), (5, 1), (6, 1), (3, 0), (7, 0)])
def test_the_richest_dynamics(richest, met):
    u = np.array([0.9, *range(1, 9), 50, 50.1])
    sizes = (2, 3, 4, *SIZES)
    made = motion_map(
        {n: "q" + ("ccppttqqe" if n == richest else "cppppppet") + "q" for n in sizes},
        u=np.tile(u, 1),
    )
    found = measured(
        "complexity-at-n5", "sigma = 0, motions by exponent and recurrence", datasets=made
    )
    share = np.array([2, 2, 2, 2, 1]) / 9
    assert found.value[f"N = {richest}"] == pytest.approx(-np.sum(share * np.log2(share)))
    assert passed(found) == [met] and found.sample_size == 63
    assert f"largest at N = {richest}" in found.note


@pytest.mark.parametrize(("richest", "met"), [(6, 1), (3, 0)])
def test_the_richest_dynamics_by_the_look_of_the_section(richest, met):
    u = np.array([0.9, *range(1, 9), 50, 50.1])
    name = "sigma = 1, states by the look of the section"
    rows = {
        (n, 1.0): cut(u, labels="q" + ("ccppqqsss" if n == richest else "cppppppps") + "q")
        for n in (2, 3, 4, *SIZES)
    }
    found = measured("complexity-at-n5", name, rows=rows)
    share = np.array([2, 2, 2, 3]) / 9
    assert found.value[f"N = {richest}"] == pytest.approx(-np.sum(share * np.log2(share)))
    assert passed(found) == [met] and found.sample_size == 63
    rows[10, 1.0] = cut(u, labels="u" * 11)
    with pytest.raises(NotEnoughDataError, match="states could not be named"):
        measured("complexity-at-n5", name, rows=rows)
