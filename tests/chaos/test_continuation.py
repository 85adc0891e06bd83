"""Branches of periodic orbits: closed forms, and their ends beside direct simulation."""

from dataclasses import replace
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest

from beltrepro import ChainParameters, orbit_branch, periodic_orbit
from beltrepro.base.errors import InputError
from beltrepro.chaos import continuation, words
from beltrepro.chaos.periodic_orbits import close_orbit, follow
from beltrepro.chaos.words import Symbol
from exact_orbits import ExactOrbit

ELSEWHERE = {"duration": 4000.0, "transient": 2000.0, "replicate": 1, "initial_spread": 1.0}


@pytest.fixture(scope="module")
def two():
    """Three slips at u = 5."""
    return periodic_orbit(ChainParameters(2, 5.0), **ELSEWHERE)


@pytest.fixture(scope="module")
def branch(two):
    """From a period doubling to a fold."""
    return orbit_branch(two, lower=0.5, upper=30.0)


@pytest.fixture(scope="module")
def grazing():
    """Six slips of two blocks; both ends are grazings."""
    return orbit_branch(periodic_orbit(ChainParameters(2, 20.0), **ELSEWHERE), lower=15, upper=30)


def away_after(orbit, belt_velocity, count, beside=0.0):
    """How far a chain is from an orbit after each of some periods, at another belt velocity."""
    chain = replace(orbit.parameters, belt_velocity=belt_velocity)
    state = orbit.state.under(chain)
    state = state.moved(positions=state.positions + beside * np.arange(chain.n_blocks))
    states = []
    for _ in range(count):
        state, _ = follow(state, orbit.period_time)
        states.append(state.displacements)
    return np.array(states) - orbit.state.displacements


# --- closed forms ---


def closed_form(belt_velocity, static_friction=71.4, friction_ratio=0.45):
    """Period of one block on a linear spring, which swings about k from F_st to 2 k - F_st."""
    reach = static_friction * (1 - friction_ratio)
    return 2 * (pi - np.arctan(reach / belt_velocity)) + 2 * reach / belt_velocity


def of_one_block():
    chain = ChainParameters(1, 3.0, linear_limit=1000.0)
    return periodic_orbit(chain, duration=12 * closed_form(3.0), transient=6 * closed_form(3.0))


@pytest.mark.parametrize(
    ("quantity", "lower", "upper"),
    [("belt_velocity", 0.5, 20.0), ("friction_ratio", 0.2, 0.9), ("static_friction", 20.0, 100.0)],
)
def test_one_block_on_a_linear_spring_has_no_end(quantity, lower, upper):
    orbit = of_one_block()
    assert orbit.period_time == pytest.approx(closed_form(3.0), rel=1e-12)
    assert (orbit.period_events, orbit.period_returns, orbit.erased) == (1, 1, 1)
    # no deviation but that of the instant outlives the first stick
    assert (orbit.largest_multiplier, orbit.exponent) == (0, -np.inf)
    one = orbit_branch(orbit, quantity, lower=lower, upper=upper, step=(upper - lower) / 7)
    assert (one.lower, one.upper) == (lower, upper) == tuple(one.parameter[[0, -1]])
    assert one.lower_end.kind == one.upper_end.kind == "edge"
    period = closed_form(**{"belt_velocity": 3.0, quantity: one.parameter})
    assert one.period_time == pytest.approx(period, rel=1e-11)
    assert np.all(one.multipliers == [1, 0]) and np.all(one.stable)
    assert one.word == "1- 1|" and one.passed == ()


def test_one_block_ends_where_it_meets_the_wall():
    """It swings about k, by the reach of its force and the velocity of the belt together."""
    one = orbit_branch(of_one_block(), "friction_ratio", lower=0.1, upper=0.5)
    assert one.lower_end.kind == "contact" and one.upper == 0.5
    swing = np.hypot(71.4 * (1 - one.lower), 3.0)
    assert 71.4 * one.lower - swing == pytest.approx(-50.0, abs=1e-5)


# --- ends, beside direct simulation ---


def test_period_doubling_is_where_deviations_stop_to_shrink(branch):
    assert branch.lower_end.kind == "period doubling"
    assert branch.largest_multiplier[0] == pytest.approx(-1, abs=1e-6)
    assert 1.22 < branch.lower < 1.24  # the orbits of docs/chaos.md
    for offset, grows in ((0.02, False), (-0.02, True)):
        value = branch.lower + offset
        begin = branch.orbits[0].state.under(ChainParameters(2, value))
        orbit = close_orbit(begin, branch.period_time[0])
        apart = np.diff(away_after(orbit, value, 40, 1e-4))[:, 0]
        assert np.all(apart[1:] * apart[:-1] < 0)
        assert (abs(apart[-1]) > abs(apart[0])) == grows == (orbit.exponent > 0)
        ratio = abs(apart[-1] / apart[0]) ** (1 / 39)
        assert ratio == pytest.approx(-orbit.largest_multiplier.real, abs=2e-3)
        assert orbit.trivial == grows  # the trivial one is the largest where it attracts


@pytest.mark.slow
def test_unstable_pieces_are_followed_where_they_are_asked_for(two, branch):
    further = orbit_branch(two, lower=1.0, upper=6.0, unstable=True)
    assert (further.lower, further.lower_end.kind) == (1.0, "edge")
    (point,) = further.passed
    assert point.kind == "period doubling"
    assert point.parameter == pytest.approx(branch.lower, abs=1e-7)
    assert np.array_equal(further.stable, further.parameter >= point.parameter)


def test_a_multiplier_becomes_1_as_a_square_root_at_a_fold(branch):
    """By (1 - mu)^2 of orbits well before it the fold lies where the branch ends."""
    assert branch.upper_end.kind == "fold"
    nearby = (branch.upper - branch.parameter < 3e-3) & (branch.upper - branch.parameter > 1e-5)
    square = (1 - branch.largest_multiplier[nearby].real) ** 2
    slope, offset = np.polyfit(branch.parameter[nearby] - branch.upper, square, 1)
    assert nearby.sum() >= 4
    assert offset / -slope == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("end", ["lower", "upper"])
def test_a_motion_leaves_beyond_a_grazing(grazing, end):
    """By ten times the accuracy of the end; the multiplier says nothing of it."""
    value, special = getattr(grazing, end), getattr(grazing, f"{end}_end")
    orbit = grazing.orbits[0 if end == "lower" else -1]
    assert (special.kind, special.block) == ("grazing", 1)
    assert abs(orbit.largest_multiplier) < 0.2
    way = {"lower": -1, "upper": 1}[end]
    inside, outside = (away_after(orbit, value + beyond * 2e-6, 10) for beyond in (-way, way))
    assert np.abs(inside).max() < 1e-3
    assert np.abs(outside).max() > 1


@pytest.mark.slow
@pytest.mark.parametrize("end", ["lower", "upper"])
def test_a_grazing_is_where_it_is_with_forty_digits(grazing, end):
    """A block sticks with an acceleration whose square goes to zero, in proportion to what is left.

    Orbits 1e-6 and 3e-6 inside of the end say where.
    """
    special = getattr(grazing, f"{end}_end")
    orbit = grazing.orbits[0 if end == "lower" else -1]
    inward = {"lower": 1, "upper": -1}[end]
    values = [special.parameter + inward * offset for offset in (1e-6, 3e-6)]
    soft = [ExactOrbit(orbit, value).softest_stick(special.block) for value in values]
    exact = values[0] - float(soft[0] / (soft[1] - soft[0])) * (values[1] - values[0])
    assert 0 < (special.parameter - exact) * inward < 2e-8 * exact


@pytest.mark.parametrize("unit", [1.0, 64.0, 1 / 64])
def test_ends_have_one_name_in_each_unit_of_time(unit):
    chain = ChainParameters(3, 7.0 / unit, mass=unit**2)
    orbit = periodic_orbit(chain, duration=6000.0 * unit, transient=3000.0 * unit)
    branch = orbit_branch(orbit, lower=4.2 / unit, upper=10.5 / unit)
    assert branch.lower * unit == pytest.approx(6.18311769)
    assert branch.upper * unit == pytest.approx(7.94322375)
    ends = branch.lower_end, branch.upper_end
    assert [(end.kind, end.block) for end in ends] == [("grazing", 3), ("grazing", 2)]


# --- words ---


def word(*names):
    """Symbols at times 0, 1, ..."""
    return [Symbol(float(time), int(name[0]), name[1]) for time, name in enumerate(names)]


def test_a_reversal_is_no_stick():
    events = np.zeros(4, [("time", "f8"), ("block", "i8"), ("kind", "U5"), ("force", "f8")])
    events["block"], events["time"] = 1, [0, 2, 2, 3]
    events["kind"], events["force"] = ["slip", "stick", "slip", "stick"], [-71.4, 75, 75, 20]
    assert " ".join(map(str, words.symbols(events))) == "1- 1+ 1|"


@pytest.mark.parametrize(
    ("other", "alike"),
    [
        (("2-", "1-", "1|", "2|", "1+", "1|"), True),  # another order of the two blocks
        (("1+", "1|", "1-", "2-", "1|", "2|"), True),  # from another instant on
        (("1-", "2-", "1+", "1|", "2|"), True),  # a stick has shrunk to nothing
        (("1-", "2-", "1|", "2|", "1-", "1|"), False),
        (("1-", "2-", "1|", "2|"), False),
        (("1-", "1|", "1+", "1|"), False),
    ],
)
def test_words_of_one_branch(other, alike):
    begin = word("1-", "2-", "1|", "2|", "1+", "1|")
    assert words.slips_alike(begin, word(*other)) == alike


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e-3])
@pytest.mark.parametrize(
    ("outside", "symbol", "appears", "at_once"),
    [
        ({0: "1-", 2: "2-", 3.01: "2|", 4: "1|"}, None, None, None),
        ({0: "1-", 1: "1|", 2: "2-", 2.5: "1-", 3: "2|", 4: "1|"}, "1|", True, False),
        ({0: "1-", 2: "2-", 4: "1|"}, "2|", False, False),
        ({0: "1-", 2: "2-", 3.01: "2+", 4: "1|"}, "2|", False, True),
    ],
)
def test_the_first_difference_of_two_motions(outside, symbol, appears, at_once, unit):
    inside = {0: "1-", 2: "2-", 3: "2|", 4: "1|"}
    one, other = (
        [Symbol(unit * time, int(name[0]), name[1]) for time, name in motion.items()]
        for motion in (inside, outside)
    )
    difference = words.first_difference(one, other, unit)
    if symbol is None:
        assert difference is None
    else:
        assert (str(difference.symbol), *difference[1:]) == (symbol, appears, at_once)


# --- wrong input ---


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"orbit": 5}, "orbit = 5: a PeriodicOrbit is needed"),
        ({"quantity": "u"}, "did you mean 'belt_velocity'"),
        ({"quantity": "noise"}, "quantity = 'noise': allowed are belt_velocity"),
        ({"lower": 6.0}, "lower = 6, upper = 7: must have the belt_velocity of the orbit, 5"),
        ({"lower": 5.0, "upper": 5.0}, "lower = 5, upper = 5: must have the belt_velocity"),
        ({"quantity": "friction_ratio", "lower": 0.2, "upper": 1.0}, "upper = 1"),
        ({"step": 0.0}, "step = 0"),
        ({"unstable": "yes"}, "unstable = 'yes': must be True or False"),
    ],
)
def test_bad_input_is_one_line(two, changes, message):
    with pytest.raises(InputError) as caught:
        orbit_branch(**{"orbit": two, "lower": 4.0, "upper": 7.0} | changes)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_what_happens_on_the_way_is_in_order_of_the_quantity(two, monkeypatch):
    def walk(course, begin, edge):
        values = np.linspace(begin.value, edge, 4)[1:]
        *passed, end = (continuation.SpecialPoint(value, "torus", 0, "") for value in values)
        return [begin], passed, end

    monkeypatch.setattr(continuation._Course, "walk", walk)
    further = orbit_branch(two, lower=2.0, upper=8.0, unstable=True)
    assert [point.parameter for point in further.passed] == [3.0, 4.0, 6.0, 7.0]
    assert (further.lower, further.upper) == (2.0, 8.0)


def test_several_periods_are_refused(two):
    with pytest.raises(InputError, match="is several periods of a shorter one"):
        orbit_branch(close_orbit(two.state, 2 * two.period_time), lower=4.0, upper=7.0)


# --- what is said of an end -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "appears", "at_once", "says"),
    [
        ("|", True, False, "block 2, which slips, touches the velocity of the belt"),
        ("|", False, False, "block 2 no longer reaches the velocity of the belt"),
        ("-", True, False, "the pull on block 2, which is stuck, touches the static friction"),
        ("+", False, False, "the pull on block 2 no longer reaches the static friction"),
        ("-", True, True, "a stick of block 2 between two slips has no length"),
    ],
)
def test_what_is_said_of_an_event_that_comes_or_goes(kind, appears, at_once, says):
    difference = words.Difference(Symbol(1.0, 2, kind), appears, at_once)
    special = continuation._grazing(6.0, difference)
    end = "stick of no length" if at_once else "grazing"
    assert special == (6.0, end, 2, says)


def test_a_branch_goes_on_where_the_time_of_most_stuck_blocks_ends():
    """There a stick and a slip change their order, and all else is smooth."""
    chain = ChainParameters(3, 25.0, viscosity=0.02)
    orbit = periodic_orbit(chain, duration=20_000, transient=15_000)
    whole = orbit_branch(orbit, lower=24.9, upper=25.0)
    assert whole.lower_end.kind == "fold" and whole.lower == pytest.approx(24.9603936, abs=1e-6)
    beyond = whole.orbits[1]
    assert beyond.parameters.belt_velocity < 24.97335
    again = orbit_branch(beyond, lower=beyond.parameters.belt_velocity, upper=25.0)
    assert again.orbits[-1].period_time == pytest.approx(orbit.period_time, rel=1e-12)


@pytest.mark.parametrize(
    ("multipliers", "kind", "says"),
    [
        ([1.0, 0.3, -1.0002, 0.1], "period doubling", "a multiplier is -1"),
        ([1.0, -0.9, 0.1, 1.0003], "fold", "a multiplier is 1"),
        ([1.0, 0.6 + 0.8001j, 0.6 - 0.8001j, 0.2], "torus", "0.6 +- 0.8i of modulus 1"),
    ],
)
def test_what_happens_where_a_multiplier_leaves_the_circle(multipliers, kind, says):
    before, after = (
        continuation._Point(6.0, SimpleNamespace(multipliers=values, trivial=0), word("1-", "1|"))
        for values in (0.99 * np.array(multipliers), np.array(multipliers))
    )
    special = continuation._happens(before, after)
    assert (special.parameter, special.kind, special.block) == (6.0, kind, 0)
    assert says in special.text
