"""Claims on the effect of noise for other numbers of blocks, by runs with a known answer."""

from functools import partial

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.sizes import claims as noise_and_size
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, UNDECIDED
from beltrepro.stats import estimates
from made_up import grades, measured, scan

SIZES = (5, 6, 7, 10)
LEVELS = np.arange(0.0, 10.5, 1)


@pytest.fixture(autouse=True)
def fewer_resamples(monkeypatch):
    monkeypatch.setattr(noise_and_size, "RESAMPLES", 30)
    monkeypatch.setattr(estimates, "bootstrap", partial(estimates.bootstrap, resamples=80))


# --- rise of r ------------------------------------------------------------------------------------


def columns(ratios, *, width=2.0, scatter=0.02, replicates=8):
    """r(sigma) of each N that rises by a ratio about sigma = 4, and a flat one at a smaller u."""
    rng = np.random.default_rng(1)
    parts, sizes, places = [], [], []
    for n_blocks, ratio in zip(SIZES, ratios, strict=True):
        for u, factor in ((18.0, ratio), (12.0, 1.0)):
            share = np.clip(0.5 + (LEVELS - 4) / width, 0, 1)
            mean = np.repeat(0.02 * (1 + (factor - 1) * share), replicates)
            parts.append(mean * (1 + scatter * rng.standard_normal(mean.size)))
            sizes.append(n_blocks)
            places.append(u)
    count = LEVELS.size
    return scan(
        np.repeat(sizes, count), np.repeat(places, count), np.concatenate(parts),
        noise=np.tile(LEVELS, len(sizes)), replicates=replicates,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("ratios", "slope", "difference"),
    [
        ((6.0, 4.0, 3.0, 2.0), HOLDS, HOLDS),
        ((2.0, 3.0, 4.0, 6.0), FAILS, FAILS),
        ((6.0, 4.0, 3.0, 1.0), HOLDS, HOLDS),
        ((3.0, 2.0, 5.0, 3.0), UNDECIDED, UNDECIDED),
    ],
)
def test_rises_against_n(ratios, slope, difference):
    scatter = 0.02 if slope != UNDECIDED else 0.3
    made = grades("r-of-sigma-size", size_columns=columns(ratios, scatter=scatter))
    if slope == UNDECIDED:
        assert made["N = 5 minus N = 10"] == UNDECIDED
    else:
        assert (made["slope over N"], made["N = 5 minus N = 10"]) == (slope, difference)


def test_the_rise_is_measured_at_the_highest_velocity_of_each_n():
    made = measured("r-of-sigma-size", size_columns=columns((6.0, 4.0, 3.0, 2.0)))
    assert made.also["N = 5"].value == pytest.approx(np.log(6), abs=0.05) and made.runs == 8
    slope = np.polyfit(SIZES, np.log([6, 4, 3, 2]), 1)[0]
    assert made.judged["slope over N"].value == pytest.approx(slope, abs=0.02)


def test_a_steep_rise_is_more_evident_in_a_reading():
    wide, steep = columns((4.0,) * 4, width=8.0), columns((4.0,) * 4, width=0.5)
    reading = "the same over the width of the rise"
    values = [
        measured("r-of-sigma-size", reading, size_columns=made).also["N = 5"].value
        for made in (wide, steep)
    ]
    assert values[1] > 3 * values[0] > 0


def test_without_any_rise_none_is_weaker():
    flat = columns((1.0,) * 4, scatter=0.0)
    assert grades("r-of-sigma-size", size_columns=flat)[""] == FAILS


def test_single_runs_tell_nothing_of_the_rise():
    single = columns((6.0, 4.0, 3.0, 2.0), replicates=1)
    assert grades("r-of-sigma-size", size_columns=single)[""] == UNDECIDED


# --- effect on r and on the section ---------------------------------------------------------------

U = np.arange(8.0, 37, 2)
ALL_U, SECTION = "r, all u of each N", "section velocities"


def replicates(effects, *, scatter=0.05, count=8, seed=1, beyond=0.0):
    """r of runs with and without noise: noise changes ln r by these effects, up and down in turn.

    beyond : the same at u = 40, for all N.
    """
    rng = np.random.default_rng(seed)
    u = np.append(U, 40.0)
    turn = np.where(np.arange(u.size) % 2, 1.0, -1.0)
    rows = []
    for n_blocks, effect in zip(SIZES, effects, strict=True):
        for noise in (0.0, 1.0):
            change = np.append(effect * turn[:-1], beyond) * noise
            logs = np.repeat(np.log(0.1) + change, count)
            r = np.exp(logs + scatter * rng.standard_normal(logs.size))
            v = rng.normal(np.repeat(change * 3, count)[:, None], 1.0, (r.size, 20))
            rows.append((n_blocks, noise, r, v))
    return scan(
        np.repeat([row[0] for row in rows], u.size), np.tile(u, len(rows)),
        np.concatenate([row[2] for row in rows]), noise=np.repeat([row[1] for row in rows], u.size),
        replicates=count, section_velocity=np.concatenate([row[3] for row in rows]),
    )  # fmt: skip


@pytest.mark.thorough
@pytest.mark.parametrize("reading", [None, ALL_U, SECTION])
@pytest.mark.parametrize(
    ("effects", "verdict"), [((0.5, 0.4, 0.3, 0.1), HOLDS), ((0.1, 0.3, 0.4, 0.5), FAILS)]
)
def test_the_effect_of_noise_against_n(effects, verdict, reading):
    made = grades("noise-less-relevant", reading, n5_replicates=replicates(effects))
    assert set(made.values()) == {verdict}


def test_equal_effects_are_undecided_and_have_their_size():
    made = measured("noise-less-relevant", n5_replicates=replicates((0.3,) * 4))
    for n_blocks in SIZES:
        effect = made.also[f"N = {n_blocks}"]
        assert effect.low < 0.09 < effect.high and effect.runs == 8
    assert grades("noise-less-relevant", n5_replicates=replicates((0.3,) * 4))[""] == UNDECIDED


def test_the_scatter_of_the_runs_is_no_effect_of_noise():
    """Without an effect the interval holds zero in 95 of 100, however much the runs scatter."""
    effects = []
    for seed in range(25):
        made = replicates((0,) * 4, scatter=0.5, seed=seed)
        effects += measured("noise-less-relevant", n5_replicates=made).also.values()
    held = sum(each.low <= 0 <= each.high for each in effects)
    assert abs(np.mean([each.value for each in effects])) < 0.012  # 0.06 with the scatter in it
    assert held >= 88  # of 100: 95 expected, three standard errors less


@pytest.mark.thorough
def test_the_velocities_of_a_reading():
    effects = (0.3, 0.2, 0.1, 0.0)
    apart = replicates(effects, beyond=2.0)
    common = measured("noise-less-relevant", n5_replicates=apart).also["N = 10"]
    every = measured("noise-less-relevant", ALL_U, n5_replicates=apart).also["N = 10"]
    assert common.high < 0.01 < every.low
    section = measured("noise-less-relevant", SECTION, n5_replicates=apart).also
    assert section["N = 5"].low > section["N = 10"].high


def test_the_effect_needs_independent_runs_at_shared_velocities():
    with pytest.raises(NotEnoughDataError, match="3 runs at u = 8, 4 are needed"):
        measured("noise-less-relevant", n5_replicates=replicates((0.1,) * 4, count=3))
    made = replicates((0.1,) * 4)
    arrays = made.arrays | {
        "belt_velocity": np.where(
            made.arrays["noise"] == 0,
            made.arrays["belt_velocity"],
            made.arrays["belt_velocity"] + 1,
        )
    }
    with pytest.raises(NotEnoughDataError, match="0 shared belt velocities at N = 5"):
        measured("noise-less-relevant", n5_replicates=Dataset(arrays, made.attributes))
