"""Falls of r: by hand, and whether its intervals cover made-up falls of many kinds."""

import itertools

import numpy as np
import pytest
from scipy.special import expit

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.stats import estimates, transition
from beltrepro.stats.transition import fall

RNG = np.random.default_rng
# Those of n5_replicates and, of ten blocks, size_replicates.
FIVE = np.array(
    [*range(6, 14, 2), 13, *np.arange(14, 20.1, 0.5), 21, 22, 23, 24, 26, 28, 30, 33, 36.0]
)
TEN = np.array([8, 12, 16, 20, *range(22, 26, 2), *range(26, 32), *range(32, 51, 2)], dtype=float)
PER_WIDTH = 2 * np.log(9)  # width of the fall from 90 % to 10 %, over w
MIDDLES, LATER = (15.5, 18.5), (21.0, 26.0)


# --- made-up studies ------------------------------------------------------------------------------


def tossed(share, u, rng):
    return (rng.random(share.size) < share).astype(float)


def clustered(among, stray=0.0):
    """Runs at one u share their luck: beta-binomial, with a share of strays beyond the fall."""

    def draw(share, u, rng):
        places, place = np.unique(u, return_inverse=True)
        at_place = np.zeros(places.size)
        at_place[place] = stray + (1 - stray) * share
        ends = np.maximum([at_place, 1 - at_place], 1e-9) * (1 - among) / among
        return tossed(rng.beta(*ends)[place], u, rng)

    return draw


def mixed(share, u, rng):
    """Every run lies between the transition."""
    return rng.beta(4 * share + 1e-9, 4 * (1 - share) + 1e-9)


def smooth(share, u, rng):
    return share


def made(rng, draw, w, middles=MIDDLES, grid=FIVE, runs=8, r=(0.13, 0.013), scatter=0.05):
    """A row of runs (u, r), and its u_c."""
    critical = rng.uniform(*middles)
    u = np.repeat(grid, rng.permutation(np.resize(runs, grid.size)))
    position = draw(expit((critical - u) / w), u, rng)
    high, low = r
    return u, (low + (high - low) * position) * rng.lognormal(0, scatter, u.size), critical


STUDIES = {
    "sharp": {"draw": tossed, "w": 0.02},
    "two branches, narrow": {"draw": tossed, "w": 0.3},
    "two branches, wide": {"draw": tossed, "w": 1.5},
    "uneven numbers of runs": {"draw": tossed, "w": 1.0, "runs": [6, 8, 16, 40]},
    "two runs": {"draw": tossed, "w": 1.0, "runs": 2},
    "forty runs": {"draw": tossed, "w": 1.0, "runs": 40},
    "noisy": {"draw": smooth, "w": 0.7, "scatter": 0.15},
    "noisy, wide": {"draw": smooth, "w": 1.5, "scatter": 0.1},
    "as at sigma = 5": {"draw": mixed, "w": 2.0, "middles": LATER},
    "as of ten blocks": {
        "draw": smooth,
        "w": 1.3,
        "middles": (28, 37),
        "grid": TEN,
        "r": (0.083, 0.059),
        "scatter": 0.06,
    },
    "clustered": {"draw": clustered(0.3), "w": 0.8},
    "strays": {"draw": clustered(0.7, 0.2), "w": 0.1},
}


def coverage(names):
    """Shares of studies whose intervals of u_c, width and of differences cover."""
    places, truths, inside = [], [], []
    for seed, name in enumerate(names):
        u, r, critical = made(RNG(seed), **STUDIES[name])
        numbers = transition._fit(transition.Row.of(u, r))[0].numbers(8)
        width = PER_WIDTH * STUDIES[name]["w"]
        inside.append([covers(numbers["critical"], critical), covers(numbers["width"], width)])
        places.append(numbers["critical"])
        truths.append(critical)
    shifted = [
        covers(estimates.difference(one, other), first - second)
        for (one, first), (other, second) in itertools.pairwise(zip(places, truths, strict=True))
    ]
    return (*np.mean(inside, axis=0), np.mean(shifted))


def covers(estimate, truth):
    return estimate.low <= truth <= estimate.high


# --- by hand --------------------------------------------------------------------------------------


def by_hand(share, runs=8, grid=FIVE):
    """A row without scatter, of which this share of the runs at each u is high."""
    u = np.repeat(grid, runs)
    rank = np.tile((np.arange(runs) + 0.5) / runs, grid.size)
    return u, np.where(rank < np.repeat(share, runs), 0.13, 0.01)


def test_a_jump_between_two_places_is_known_to_the_grid():
    numbers = fall(*by_hand((FIVE < 17.2).astype(float)))
    critical = numbers["critical"]
    assert 16.75 < critical.low < 17.1 and critical.value == pytest.approx(17.25, abs=0.1)
    assert 17.4 < critical.high < 17.75
    assert numbers["width"].low == 0 and numbers["width"].high < 2
    assert (numbers["r_high"].numbers, numbers["r_low"].numbers) == (3 * (0.13,), 3 * (0.01,))
    assert numbers["contrast"].value == pytest.approx(13) and critical.runs == 8
    assert numbers["lower"].value < critical.value < numbers["upper"].value


@pytest.mark.parametrize("w", [0.7, 1.2])
def test_shares_by_a_logistic_curve_return_its_numbers(w):
    numbers = fall(*by_hand(expit((18 - FIVE) / w), runs=40))
    values = {name: estimate.value for name, estimate in numbers.items()}
    assert values["critical"] == pytest.approx(18, abs=0.15)
    assert values["width"] == pytest.approx(PER_WIDTH * w, rel=0.15)
    assert values["upper"] - values["lower"] == pytest.approx(values["width"], rel=0.05)
    assert numbers["width"].low > 0


def test_strays_beyond_a_sharp_fall_do_not_move_it():
    numbers = fall(*by_hand(np.where((FIVE < 17.2) | np.isin(FIVE, (24, 33)), 1.0, 0.0)))
    assert 16.75 < numbers["critical"].value < 17.75 and numbers["r_low"].value == 0.01


def test_places_that_go_one_way_together_count_as_one_toss():
    """Of 3 of 8 runs each and of places that are all high or all low, the second tell less."""
    share = np.where(FIVE < 15, 1.0, np.where(FIVE > 20, 0.0, 0.5))
    alone = fall(*by_hand(share))
    order = np.flatnonzero((FIVE >= 15) & (FIVE <= 20))
    share[order] = np.resize([1.0, 0.0, 0.0, 1.0], order.size)
    together = fall(*by_hand(share))
    spread = [row["critical"].high - row["critical"].low for row in (alone, together)]
    assert spread[1] > 1.5 * spread[0]


def test_a_fall_that_the_row_does_not_end_has_no_upper_end():
    grid = np.arange(10.0, 30, 2)
    share = expit((24 - grid) / 5)
    numbers = fall(*by_hand(share, 40, grid))
    assert numbers["width"].high == numbers["upper"].high == np.inf
    assert 3 < numbers["width"].low < PER_WIDTH * 5 < np.inf and np.isfinite(numbers["lower"].high)


def test_plateaus_are_those_of_the_branches_beside_the_fall():
    """A window at 6 and a branch of large r from 28 on are not what medians show."""
    u, r = by_hand((FIVE < 17.2).astype(float))
    r[u == 6], r[(u >= 28) & (np.arange(u.size) % 8 < 3)] = 0.05, 0.12
    numbers = fall(u, r)
    assert (numbers["r_high"].value, numbers["r_low"].value) == (0.13, 0.01)


def test_without_a_fall_only_the_plateaus_are_known(monkeypatch):
    rng = RNG(4)
    u = np.repeat(FIVE, 8)
    alike = fall(u, 0.1 * rng.lognormal(0, 0.1, u.size))
    assert np.isnan([alike[name].value for name in ("critical", "lower", "width")]).all()
    weak = by_hand((FIVE < 17.2).astype(float))[1] + 0.2  # by a factor of 1.57
    assert fall(u, weak)["critical"].value == pytest.approx(17.25, abs=0.1)
    monkeypatch.setattr(transition, "MINIMUM_CONTRAST", 1.6)
    refused = fall(u, weak)
    assert np.isnan(refused["critical"].value) and refused["critical"].runs == 8
    assert refused["contrast"].value == pytest.approx(0.33 / 0.21)
    assert np.isnan(fall(u, u)["contrast"].value)  # r rises
    for few, message in (
        (u[:56], "7 points along the curve, 8 are"),
        (FIVE, "one run at each point"),
    ):
        with pytest.raises(NotEnoughDataError, match=message):
            fall(few, few)


@pytest.mark.parametrize("scatter", [0.02, 0.1, 0.3])
def test_flat_rows_have_no_fall(scatter):
    u = np.repeat(FIVE, 8)
    results = [
        np.isfinite(fall(u, RNG(seed).lognormal(0, scatter, u.size))["critical"].value)
        for seed in range(20)
    ]
    assert sum(results) <= 1


def test_order_and_missing_values_do_not_matter():
    u, r, _ = made(RNG(5), **STUDIES["two branches, wide"])
    order = RNG(6).permutation(u.size + 2)
    again = fall(np.append(u, [17.0, np.nan])[order], np.append(r, [np.nan, 0.1])[order])
    for name, estimate in fall(u, r).items():
        assert again[name].numbers == pytest.approx(estimate.numbers), name


def test_one_run_left_at_a_place_does_not_make_it_a_row_of_single_runs():
    """Where outliers are left out, one run may remain; the others still tell what is known."""
    u, r = by_hand((FIVE < 17.2).astype(float))
    r = r * RNG(2).normal(1, 0.05, r.size)
    lonely = (u != 20) | (np.arange(u.size) == np.flatnonzero(u == 20)[0])
    numbers, whole = fall(u[lonely], r[lonely]), fall(u, r)
    assert np.sum(lonely) == u.size - 7 and numbers["critical"].runs == 8
    for name in ("r_high", "r_low", "contrast"):
        widths = [of[name].high - of[name].low for of in (numbers, whole)]
        assert widths[0] == pytest.approx(widths[1], rel=0.3) and numbers[name].runs == 8


# --- coverage -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["two branches, wide", "clustered"])
def test_intervals_of_few_studies_cover(name):
    assert min(coverage([name] * 20)) >= 0.7


@pytest.mark.thorough
def test_intervals_cover_studies_of_any_kind():
    # One does not know of which kind a row is: the kind of each study is drawn by lot.
    critical, width, shift = coverage(RNG(20261124).choice(list(STUDIES), 5000))
    assert 0.93 <= critical <= 0.97 and 0.93 <= width <= 0.97 and 0.93 <= shift <= 0.98


def test_an_interval_holds_95_percent_of_what_the_runs_leave_open():
    u = np.repeat(np.arange(8.0, 30), 8)
    r = np.where(RNG(0).random(u.size) < expit((17 - u) / 1.5), 0.13, 0.01)
    draws = transition._fit(transition.Row.of(u, r))[0]
    found = draws.numbers(8)
    for name, drawn in (("critical", draws.critical), ("width", 2 * transition.EDGE * draws.scale)):
        inside = (drawn >= found[name].low) & (drawn <= found[name].high)
        assert np.mean(inside) == pytest.approx(0.95, abs=0.002)
