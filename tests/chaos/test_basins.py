"""Basins: closed answers, the two motions at u = 15, labels along the belt velocity."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from beltrepro import (
    ChainParameters,
    ChainState,
    Grid,
    Setup,
    basins,
    orbit_branch,
    slipping_state,
)
from beltrepro.base.errors import InputError
from beltrepro.chaos import basins_picture
from beltrepro.chaos.basins import Attractor, Basins
from beltrepro.chaos.periodic_orbits import close_orbit
from beltrepro.stats import estimates

attraction = sys.modules[Basins.__module__]  # `basins` is a function, too

# All blocks slip or move with the belt; on a cycle of 23 slips from there.
LOW = [156.6, 298.4, 426.1, 531.6, 611.1], [15.0, 4.3, -20.7, 15.0, -4.4]


def test_one_block_ends_on_its_one_orbit_or_never_sticks():
    # k swings with any energy; H < u^2 / 2 never reaches the belt, all others stick once
    chain = ChainParameters(1, 10.0, linear_limit=1000.0)
    starts = [slipping_state(chain, energy) for energy in (9.0, 30.0, 49.0, 51.0, 90.0)]
    one = basins(chain, duration=4000.0, initial_state=starts)
    sliding, cycle = sorted(one.attractors, key=lambda attractor: attractor.state)
    assert (sliding.state, sliding.reached_by, sliding.starts) == ("equilibrium slip", 3, 5)
    assert (cycle.state, cycle.reached_by, cycle.period_events) == ("periodic", 2, 1)
    reach = 71.4 * 0.55  # it slips from F_st to 2 k - F_st about k
    period = 2 * (np.pi - np.arctan(reach / 10.0)) + 2 * reach / 10.0
    assert cycle.period_time == pytest.approx(period, rel=1e-9)
    assert one.runs["attractor"].tolist() == 3 * [sliding.label] + 2 * [cycle.label]
    assert one.values.tolist() == [10.0] and one.quantity == "belt_velocity"


def test_two_motions_at_one_belt_velocity():
    chain = ChainParameters(5, 15.0)
    low = ChainState.in_motion(chain, *LOW)
    other = low.moved(low.positions + 0.1)
    both = basins(chain, duration=20000.0, initial_state=[low, None, other])
    few, many = sorted(both.attractors, key=lambda attractor: attractor.disorder_parameter)
    assert (few.reached_by, few.period_events, many.reached_by) == (2, 23, 1)
    assert few.disorder_parameter == pytest.approx(0.0118, abs=5e-5)
    assert many.disorder_parameter == pytest.approx(0.137, abs=5e-3)
    assert few.orbit.period_time == pytest.approx(29.23, abs=5e-3)
    table = both.table().set_index("label")
    share = estimates.share(2, 3)
    assert table.loc[few.label, ["share", "share_low", "share_high"]].tolist() == list(
        share.numbers
    )


@pytest.fixture(scope="module")
def two():
    """Two blocks from one start at each of four belt velocities; two orbits coexist at u = 20."""
    return basins(Grid(2, [18.0, 19.0, 20.0, 23.0]), duration=6000.0)


def test_an_orbit_keeps_its_label_and_is_there_where_no_start_reaches_it(two):
    assert two.branches
    for label, branch in two.branches.items():
        inside = [value for value in two.values if branch.lower <= value <= branch.upper]
        ones = [attractor for attractor in two.attractors if attractor.label == label]
        assert [one.value for one in ones] == inside
        slips = {one.period_events for one in ones}
        assert slips == {branch.orbits[0].period_events}
    for value in two.values:
        here = [one for one in two.attractors if one.value == value]
        assert sum(one.reached_by for one in here) == 1 == here[0].starts
        assert len({one.label for one in here}) == len(here)


def test_the_orbit_that_no_start_reached_is_there(two):
    unseen = next(one for one in two.attractors if one.reached_by == 0)
    again = close_orbit(unseen.orbit.state, unseen.period_time)
    assert again.period_time == pytest.approx(unseen.period_time, rel=1e-12)
    assert abs(again.largest_multiplier) < 1
    branch = two.branches[unseen.label]
    whole = orbit_branch(again, lower=18.0, upper=23.0)
    ends = branch.lower, branch.upper
    assert (whole.lower, whole.upper) == pytest.approx(ends, rel=1e-7)


def test_shares_do_not_depend_on_the_order_of_the_starts():
    grid = Grid(2, [19.0, 20.0], replicates=6)
    order = np.random.default_rng(3).permutation(12)
    shuffled = [np.array(values)[order].tolist() for values in (grid.chains, grid.replicate)]
    told = {"duration": 6000.0, "initial_spread": 10.0}
    sorted_out, mixed = basins(grid, **told), basins(shuffled[0], replicate=shuffled[1], **told)
    assert [one.reached_by for one in mixed.attractors] == [6, 3, 3]
    for one, other in zip(sorted_out.attractors, mixed.attractors, strict=True):
        pairs = ((both.value, both.reached_by, both.period_events) for both in (one, other))
        assert len(set(pairs)) == 1
        assert one.period_time == pytest.approx(other.period_time, rel=1e-12)


def test_picture_of_one_value_and_of_several(two, tmp_path):
    for number, one in enumerate((two, basins(ChainParameters(1, 5.0), duration=3000.0))):
        figure = one.plot(tmp_path / f"{number}.png")
        assert (tmp_path / f"{number}.png").stat().st_size > 5000
        bars = sum(bar.get_height() for bar in figure.axes[1].patches)
        assert bars == pytest.approx(one.values.size)
    assert repr(two) == "Basins(3 attractors of 4 starts, belt_velocity 18 to 23)"


@pytest.mark.parametrize(
    ("chains", "words"),
    [
        (Grid([1, 2], 5.0), "of 2 numbers of blocks"),
        (Grid(2, [5.0, 6.0], friction_ratio=[0.4, 0.5]), "belt_velocity, friction_ratio"),
        ([ChainParameters(2, 5.0, mass=(1.0, m)) for m in (1.0, 2.0)], "mass differs among the bl"),
        (ChainParameters(2, 5.0, noise=1.0), "noise = 1"),
        (Setup(ChainParameters(2, 5.0), method="verlet"), "verlet"),
    ],
)
def test_what_has_no_basins_is_refused(chains, words):
    with pytest.raises(InputError, match=words):
        basins(chains, duration=100.0)


# --- made-up motions ------------------------------------------------------------------------------

SEVEN = {18.0: {1: 4, 2: 3}, 19.0: {1: 2, 2: 0, 8: 5}, 21.0: {2: 6, 3: 1}}  # starts by label
STATES = {1: "periodic", 2: "periodic", 3: "equilibrium slip", 8: "irregular"}


def made_up(shares):
    """Basins of seven starts at each value, with two branches."""
    attractors = [
        Attractor(value, label, STATES[label], reached, 7, 10.0 * label + value, 3 * label,
                  label / value, 60.0 + label, SimpleNamespace(largest_multiplier=-label / 9)
                  if STATES[label] == "periodic" else None)
        for value, labels in shares.items() for label, reached in labels.items()
    ]  # fmt: skip
    runs = {name: np.repeat(list(shares), 7) for name in ("belt_velocity", "attractor")}
    places = {1: [18.0, 18.7, 19.5], 2: [18.0, 20.0, 20.5, 21.0]}
    branches = {
        label: SimpleNamespace(parameter=np.array(u), disorder_parameter=label / np.array(u))
        for label, u in places.items()
    }
    return Basins("belt_velocity", tuple(attractors), branches, runs)


def test_the_picture_draws_the_numbers_of_the_attractors():
    basins = made_up(SEVEN)
    disorder, shares = basins_picture.draw(basins).axes
    colours = {}
    for (label, branch), line in zip(basins.branches.items(), disorder.lines, strict=True):
        assert line.get_xydata().tolist() == np.transpose(
            [branch.parameter, branch.disorder_parameter]).tolist()  # fmt: skip
        colours[label] = to_rgba(line.get_color())
    dots = {marks.get_label(): marks for marks in disorder.collections}
    assert set(dots) == set(STATES.values())
    for state, marks in dots.items():
        those = [one for one in basins.attractors if one.state == state]
        points = [[one.value, one.disorder_parameter] for one in those]
        assert marks.get_offsets().tolist() == points
        for one, colour in zip(those, marks.get_facecolor(), strict=True):
            assert colours.setdefault(one.label, tuple(colour)) == tuple(colour)
    assert colours[1] == colours[8] and len(set(colours.values())) == 3  # told again after seven
    assert (disorder.get_xlabel(), disorder.get_ylabel(), disorder.get_yscale()) == (
        "$u$", "$r$", "log")  # fmt: skip
    bars = iter(shares.patches)
    for value, labels in SEVEN.items():
        below = 0.0
        for label, reached in labels.items():
            bar = next(bars)
            place = bar.get_x() + bar.get_width() / 2, bar.get_y(), bar.get_height()
            assert place == pytest.approx((value, below, reached / 7))
            assert bar.get_width() == pytest.approx(0.8)  # of the least distance
            assert bar.get_facecolor() == colours[label]
            below += reached / 7
    assert shares.get_ylim() == (0, 1)


@pytest.mark.parametrize(("gap", "groups"), [(0.8, [[1, 2, 4, 6]]), (1.2, [[4], [1, 6], [2]])])
def test_irregular_motions_with_a_gap_between_their_r_are_several(gap, groups):
    steps = np.array([9, 1, 2, 9, 0, 9, 1])  # rows 0, 3 and 5 are of another value
    r = 0.05 * np.exp(gap * 0.5 * steps)
    runs = {"disorder_parameter": r, "mean_length": 60.0 + steps, "state": ["irregular"] * 7}
    runs |= {"period_time": [np.nan] * 7, "period_events": [0] * 7}
    motions = attraction._irregular(runs, np.array([1, 2, 4, 6]))
    assert [sorted(motion.starts) for motion in motions] == groups
    for motion, rows in zip(motions, groups, strict=True):
        assert motion.disorder_parameter == pytest.approx(np.mean(r[rows]))
        assert motion.mean_length == pytest.approx(60 + np.mean(steps[rows]))


def motion(state="irregular", r=0.1, length=60.0, **more):
    return attraction._Motion(state, np.nan, 0, r, length, **more)


@pytest.mark.parametrize(("share", "same"), [(0.8, True), (1.2, False)])
def test_motions_without_orbit_go_on_at_the_next_value_where_alike(share, same):
    def labels(*by_value):
        attraction._spread(by_value[0][0], 7, 0, list(by_value))
        return [[one.label for one in motions] for motions in by_value]

    r = [0.1 * np.exp(share * 0.5 * step) for step in (0, 1, 2)]
    further = [7, 7] if same else [0, 0]
    others = motion(r=0.5), motion("equilibrium slip"), motion("periodic"), motion(label=2)
    assert labels([motion()], [*others, motion(r=r[1])], [motion(r=r[2])]) == [
        [7], [0, 0, 0, 2, further[0]], further[1:]]  # fmt: skip
    # <x_N> in its deviations, r <x_N> of the smaller
    long = motion(length=60.0 * (1 + share * 0.5 * 0.1))
    assert labels([motion()], [long]) == [[7], further[:1]]
    # the nearest of two; a value without any is passed over; slip without stick is one family
    near, nearer = motion(r=0.08), motion(r=0.11)
    assert labels([motion()], [], [near, nearer]) == [[7], [], [0, 7]]
    assert labels([motion("equilibrium slip", r=0.01)], [motion("equilibrium slip", r=0.4)]) == [
        [7], [7]]  # fmt: skip
