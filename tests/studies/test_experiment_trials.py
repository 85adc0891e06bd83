"""Trials of the experiment: r along a tape, which agree with a recording, odds, alternation."""

import numpy as np
import pytest

from beltrepro.base.store import Dataset
from beltrepro.model.units import TIME_S
from beltrepro.replication.studies.experiment import measure, words


def of_model(along_tape):
    """r of x_5 without blocks, if <x_5> is 600 units of 1.4 mm and 4.5 blocks have 18 cm."""
    return along_tape * (0.84 + 0.18) / 0.84


def test_r_along_the_tape_is_smaller_by_the_blocks_in_the_mean():
    """Blocks between the springs shift x_5 and do not change how it scatters."""
    x = 600 + 80 * np.sin(np.arange(1000))
    longer = x + 4.5 * 0.04 / 1.4e-3
    arrays = {"disorder_parameter": np.array([x.std() / x.mean()]), "mean_length": x.mean()}
    (shown,) = measure.disorder_along_tape(arrays)
    assert shown == pytest.approx(longer.std() / longer.mean(), rel=1e-6)


def test_a_trial_agrees_in_r_and_in_both_regimes():
    first, second = measure.EXPERIMENT
    arrays = {
        "mean_length": np.full(6, 600.0),
        "disorder_parameter": of_model(np.array([0.072, 0.079, 0.080, 0.072, 0.072, 0.052])),
        "lasting_longest": np.array([800.0, 800, 800, 700, 800, 300]),
        "lively_longest": np.array([2000.0, 2000, 2000, 2000, 1500, 300]),
    }
    assert measure.agrees(first, arrays).tolist() == [1, 1, 0, 0, 0, 0]
    assert measure.agrees(second, arrays).tolist() == [0, 0, 0, 0, 0, 1]
    assert measure.alternates(arrays).all()
    assert first.belt_velocity == pytest.approx(12.0176, abs=1e-3)
    velocity = {"belt_velocity": np.array([12.0176, 12.1, 15.2951])}
    assert measure.at_speed(first, velocity).tolist() == [True, False, False]
    assert measure.at_speed(second, velocity).tolist() == [False, False, True]


def test_the_odds_are_those_of_a_plain_loop():
    """Trials in which no two properties go together, in cells of unequal size."""
    rng, first = np.random.default_rng(3), measure.EXPERIMENT[0]
    noise = np.repeat([1.0, 2.0, 3.0], (7, 12, 5))
    arrays = {
        "noise": noise,
        "belt_velocity": np.full(noise.size, first.belt_velocity),
        "mean_length": np.full(noise.size, 600.0),
        "disorder_parameter": of_model(0.072 * rng.uniform(0.8, 1.2, noise.size)),
        "lasting_share": rng.random(noise.size),
        "lasting_longest": rng.choice([100, 500, 1000], noise.size),
        "lively_longest": rng.choice([100, 1000, 3000], noise.size),
        "all_slip_longest": rng.uniform(0, 10, noise.size),
    }
    second = {name: values.copy() for name, values in arrays.items()}
    second["belt_velocity"][:] = measure.EXPERIMENT[1].belt_velocity
    both = {name: np.r_[values, second[name]] for name, values in arrays.items()}
    trials = Dataset(both, {"duration": 200.0, "transient": 50.0})
    table = measure.experiment_odds({"trials": trials, "trials_short": trials})
    for level in (1.0, 2.0, 3.0):
        row = table[(table["noise"] == level) & (table["speed_m_s"] == 0.22)].iloc[0]
        counts = dict.fromkeys(("below", "alternates", "shows", "agrees", "both"), 0)
        chosen = np.flatnonzero(noise == level)
        for k in chosen:
            r = arrays["disorder_parameter"][k] * 0.84 / (0.84 + 4.5 * 0.04)  # in metres
            seconds = [TIME_S * arrays[name][k] for name in ("lasting_longest", "lively_longest")]
            shows = seconds[0] >= 60 and seconds[1] >= 125
            counts["below"] += r <= 0.072
            counts["alternates"] += min(seconds) >= 200 * TIME_S
            counts["shows"] += shows
            counts["agrees"] += shows and abs(np.log(r / 0.072)) <= 0.1
            counts["both"] += shows and r <= 0.072
        assert row["runs"] == chosen.size
        r = arrays["disorder_parameter"][chosen] * 0.84 / (0.84 + 4.5 * 0.04)
        ends = np.quantile(r, [0.025, 0.5, 0.975])
        assert row[["r_lower", "r", "r_upper"]].tolist() == pytest.approx(ends)
        for name, count in counts.items():
            assert row[name] == pytest.approx(count / chosen.size), name


def test_alternation_is_that_of_a_plain_loop():
    """Cells of unequal size, in which mean, median and largest differ."""
    rng, runs = np.random.default_rng(6), (3, 8, 5)
    arrays = {
        "noise": np.repeat([1.0, 2.0, 4.0], runs),
        "friction_ratio": np.full(16, 0.45),
        "belt_velocity": np.full(16, 12.0),
        "disorder_parameter": rng.lognormal(size=16),
        "lasting_share": rng.random(16),
        "lasting_longest": rng.choice([100.0, 300.0], 16),
        "lively_longest": rng.choice([100.0, 300.0], 16, p=[0.2, 0.8]),
        "all_slip_longest": rng.uniform(10, 70, 16) / TIME_S,
    }
    table = measure.alternation({"trials_free": Dataset(arrays, {})})
    for _, row in table.iterrows():
        cell = {name: values[arrays["noise"] == row["noise"]] for name, values in arrays.items()}
        slips = TIME_S * cell["all_slip_longest"]
        shows = np.minimum(cell["lasting_longest"], cell["lively_longest"]) == 300
        assert row["runs"] == shows.size and row["alternating"] == shows.sum()
        assert row["share_lower"] < row["share"] == shows.mean() < row["share_upper"] or (
            shows.mean() in (0, 1)
        )
        assert row["lasting_share"] == pytest.approx(cell["lasting_share"].mean())
        assert row["all_slip_longest_s"] == pytest.approx(slips.max())
        assert row["all_slip"] == np.sum(slips >= 60) and row["r"] == np.median(
            cell["disorder_parameter"]
        )
    # half of the trials is enough for a belt velocity to be named
    said = words._alternating(table.assign(share=[0.4, 0.5, 0.6]))
    assert [line["u"] for line in said] == ["", "12", "12"]
