"""Basins: closed answers, the two motions at u = 15, labels along the belt velocity."""

import numpy as np
import pytest

from beltrepro import ChainParameters, ChainState, Grid, Setup, basins, orbit_branch, slipping_state
from beltrepro.base.errors import InputError
from beltrepro.chaos import basins as attraction
from beltrepro.chaos.basins import Attractor
from beltrepro.stats import estimates

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
    assert cycle.orbit.largest_multiplier == 0
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
    assert repr(two) == "Basins(3 attractors of 4 starts, belt_velocity 18 to 23)"
    for label, branch in two.branches.items():
        inside = [value for value in two.values if branch.lower <= value <= branch.upper]
        ones = [attractor for attractor in two.attractors if attractor.label == label]
        assert [one.value for one in ones] == inside
        assert {one.period_events for one in ones} == {branch.orbits[0].period_events}
    for value in two.values:
        here = [one for one in two.attractors if one.value == value]
        assert sum(one.reached_by for one in here) == 1 == here[0].starts
        assert len({one.label for one in here}) == len(here)
    unseen = next(one for one in two.attractors if one.reached_by == 0)
    # an end does not depend on the way to it
    whole = orbit_branch(unseen.orbit, lower=18.0, upper=23.0, step=0.37, tolerance=1e-9)
    branch = two.branches[unseen.label]
    assert (whole.lower, whole.upper) == pytest.approx((branch.lower, branch.upper), rel=1e-6)


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


def test_the_picture_draws_the_numbers_of_the_attractors(two, tmp_path):
    disorder, shares = two.plot(tmp_path / "basins.png"), two.plot_shares()
    assert (tmp_path / "basins.png").stat().st_size > 5000
    for branch, line in zip(two.branches.values(), disorder.lines, strict=True):
        points = [[orbit.parameters.belt_velocity, orbit.disorder_parameter]
                  for orbit in branch.orbits]  # fmt: skip
        assert line.get_xydata().tolist() == points
    points = [point for marks in disorder.collections for point in marks.get_offsets().tolist()]
    assert sorted(points) == sorted([a.value, a.disorder_parameter] for a in two.attractors)
    areas = np.concatenate([marks.get_sizes() for marks in disorder.collections])
    assert areas.max() == 20 * areas.min()  # all of the starts, and none
    below = dict.fromkeys(two.values, 0.0)
    for attractor, bar in zip(two.attractors, shares.patches, strict=True):
        place = bar.get_x() + bar.get_width() / 2, bar.get_y(), bar.get_height()
        share = attractor.reached_by / attractor.starts
        assert place == pytest.approx((attractor.value, below[attractor.value], share))
        assert bar.get_width() == pytest.approx(0.8)  # of the least distance
        below[attractor.value] += share
    assert set(below.values()) == {1.0}


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


def test_irregular_motions_with_a_gap_between_their_r_are_several():
    for gap, groups in (0.8, [[1, 2, 4, 6]]), (1.2, [[4], [1, 6], [2]]):
        steps = np.array([9, 1, 2, 9, 0, 9, 1])  # rows 0, 3 and 5 are of another value
        runs = {"disorder_parameter": 0.05 * np.exp(gap * 0.5 * steps)}
        parts = attraction._parted(runs, np.array([1, 2, 4, 6]))
        assert [sorted(part) for part in parts] == groups


def made_up(state="irregular", r=0.1, length=60.0, **more):
    return Attractor(18.0, 7, state, np.nan, 0, r, length, **more)


@pytest.mark.parametrize(("share", "same"), [(0.8, True), (1.2, False)])
def test_motions_without_orbit_go_on_at_the_next_value_where_alike(share, same):
    def labels(begin, *by_value):
        begin.label = 7
        attraction._spread(begin, list(by_value))
        return [[one.label for one in motions] for motions in by_value]

    further = [7] if same else [0]
    r = [0.1 * np.exp(share * 0.5 * step) for step in (1, 2)]
    others = made_up(r=0.5), made_up("equilibrium slip"), made_up("periodic"), made_up(label=2)
    assert labels(made_up(), [*others, made_up(r=r[0])], [made_up(r=r[1])]) == [
        [0, 0, 0, 2, *further], further]  # fmt: skip
    # <x_N> in its deviations, r <x_N> of the smaller
    assert labels(made_up(), [made_up(length=60.0 * (1 + share * 0.5 * 0.1))]) == [further]
    # the nearest of two; a value without any is passed over; slip without stick is one family
    assert labels(made_up(), [], [made_up(r=0.08), made_up(r=0.11)]) == [[], [0, 7]]
    slip = made_up("equilibrium slip", r=0.01), made_up("equilibrium slip", r=0.4)
    assert labels(slip[0], [slip[1]]) == [[7]]
    assert labels(made_up("periodic"), [made_up("periodic")]) == [[0]]


def test_an_orbit_is_that_with_its_period_slips_and_crossings(two):
    for attractor in two.attractors:
        orbit, period = attractor.orbit, (attractor.period_time, attractor.period_events)
        crossing = attraction._crossings(orbit, orbit.mean_length)[-1]
        assert attractor.is_of(*period, crossing)
        for change in (-1e-3, 1e-3):
            beside = crossing.copy()
            beside[0] += change * np.abs(crossing).max()
            assert not attractor.is_of(*period, beside)
        assert not attractor.is_of(1.001 * period[0], period[1], crossing)
        assert not attractor.is_of(period[0], period[1] + 1, crossing)
