"""Approximate Bayesian computation on a grid: known posteriors, coverage, pairs of recordings."""

import itertools
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.model.units import TIME_S
from beltrepro.replication.studies.experiment import inference, measure, observations, runs, words
from beltrepro.replication.studies.experiment.inference import Simulated, calibrate, posterior

LEVELS = np.linspace(-2, 2, 9)


def gaussian(runs=4000, recordings=(1.0, 2.0), seed=3):
    """Recordings that scatter about a mean by these standard deviations; the feature always shows.

    The second parameter has no effect.
    """
    generator = np.random.default_rng(seed)
    scatter = np.reshape(recordings, (-1, 1, 1, 1))
    shape = (len(recordings), LEVELS.size, 3, runs)
    summary = LEVELS[:, np.newaxis, np.newaxis] + scatter * generator.standard_normal(shape)
    levels = {"mean": LEVELS, "idle": np.arange(3.0)}
    return Simulated(levels, summary, np.ones(shape, dtype=bool))


def test_the_posterior_of_a_gaussian_mean_is_known():
    recorded, tolerance = [0.6, -1.2], 0.2
    answer = posterior(gaussian(), recorded, tolerance)
    ends = np.add.outer([-tolerance, tolerance], recorded)[..., np.newaxis]
    within = np.diff(stats.norm.cdf(ends, LEVELS, [[1.0], [2.0]]), axis=0)[0]
    likelihood = within.prod(axis=0)
    expected = likelihood / likelihood.sum()
    np.testing.assert_allclose(answer.marginal("mean"), expected, atol=0.025)
    np.testing.assert_allclose(answer.marginal("idle"), 1 / 3, atol=0.03)
    assert answer.evidence == pytest.approx(likelihood.mean(), rel=0.03)
    assert answer.agreed == pytest.approx(4000 * 3 * within.sum(axis=1), rel=0.05)
    assert answer.probability.sum() == pytest.approx(1)
    np.testing.assert_allclose(answer.marginal("mean", "idle"), answer.probability)
    # the held-out probability of agreement is the mean likelihood under the posterior
    fresh = inference.held_out(gaussian(), recorded, tolerance)
    assert fresh == pytest.approx((expected * likelihood).sum(), rel=0.05)
    mean = (answer.marginal("mean") * LEVELS).sum()
    quantiles = inference.predicted(answer, gaussian().summary[0], (0.16, 0.5, 0.84))
    assert quantiles[1] == pytest.approx(mean, abs=0.1) and quantiles[2] - quantiles[0] > 2.0


def test_only_trials_that_show_the_feature_agree():
    simulated = gaussian(runs=200)
    simulated.shown[1, 4:] = False
    assert posterior(simulated, [0.0, 0.0], 1.0).marginal("mean")[4:].sum() == 0
    simulated.shown[1] = False
    with pytest.raises(NotEnoughDataError, match=r"and 0 of .* none with all at one combination"):
        posterior(simulated, [0.0, 0.0], 1.0)
    with pytest.raises(NotEnoughDataError, match="no trials show"):
        calibrate(simulated, 1.0)


def test_trials_can_be_left_out_and_levels_fixed():
    simulated = gaussian(runs=50)
    half = np.zeros(simulated.shown.shape, dtype=bool)
    half[..., ::2] = True
    left = posterior(simulated, [0.0, 0.0], 1.0, without=half)
    chosen = posterior(simulated.of(lambda trials: trials[..., 1::2]), [0.0, 0.0], 1.0)
    np.testing.assert_allclose(left.probability, chosen.probability)
    assert left.evidence == pytest.approx(chosen.evidence) and left.agreed == chosen.agreed
    one = simulated.fixed("mean", 1.0)
    assert one.levels["mean"].tolist() == [1.0] and one.shown.shape == (2, 1, 3, 50)
    np.testing.assert_array_equal(one.summary[:, 0], simulated.summary[:, 6])
    with pytest.raises(NotEnoughDataError, match=r"no trial with mean = 0\.3"):
        simulated.fixed("mean", 0.3)


def test_shares_are_averaged_over_neighbouring_levels():
    generator = np.random.default_rng(8)
    # agreement is equally probable at all levels, so that all else is scatter of few trials
    shape = (1, 9, 3, 4)
    summary = generator.choice([0.0, 5.0], size=shape)
    levels, shown = {"mean": LEVELS, "idle": np.arange(3.0)}, np.ones(shape, dtype=bool)
    rough = posterior(Simulated(levels, summary, shown), [0.0], 1.0)
    smooth = posterior(Simulated(levels, summary, shown, {"mean": 1.5}), [0.0], 1.0)
    assert np.ptp(smooth.marginal("mean")) < 0.5 * np.ptp(rough.marginal("mean"))
    # the other parameter is not averaged over
    agreed = (summary == 0).sum(axis=-1)[0]
    weights = np.exp(-0.5 * ((LEVELS - LEVELS[:, np.newaxis]) / 0.5 / 1.5) ** 2)
    expected = weights @ agreed / weights.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(smooth.probability, expected / expected.sum(), atol=2e-4)


def test_what_is_probable_before_multiplies_what_the_trials_say():
    """A normal mean under a normal prior: closed form, whatever the scale of the weights."""
    weight = 7 * np.exp(-((LEVELS - 0.5) ** 2))
    simulated = replace(gaussian(), weights={"mean": weight})
    assert simulated.prior.shape == (9, 3) and simulated.prior.sum() == pytest.approx(1)
    np.testing.assert_allclose(simulated.prior[:, 1], weight / weight.sum() / 3)
    alike, answer = (posterior(trials, [0.6, -1.2], 0.2) for trials in (gaussian(), simulated))
    expected = alike.probability * simulated.prior
    np.testing.assert_allclose(answer.probability, expected / expected.sum())
    assert answer.agreed == alike.agreed
    # of 27 equally probable combinations before, the mean likelihood; now the weighted one
    assert answer.evidence == pytest.approx(27 * alike.evidence * expected.sum())
    one = simulated.fixed("mean", 1.0)
    assert one.prior.shape == (1, 3) and not one.weights
    sharp = replace(gaussian(runs=150), weights={"mean": np.exp(-8 * (LEVELS - 0.5) ** 2)})
    coverage = calibrate(sharp, 0.15, draws=600).coverage["mean"]
    assert coverage.high > 0.9


def test_credible_sets_hold_the_most_probable_levels():
    probability = np.array([0.05, 0.3, 0.5, 0.1, 0.05])
    for credibility, levels in ((0.5, [2]), (0.51, [1, 2]), (0.8, [1, 2]), (0.9, [1, 2, 3])):
        chosen = inference.credible_set(probability, credibility)
        assert np.flatnonzero(chosen).tolist() == levels


def test_credible_sets_cover_the_truth_as_often_as_they_say():
    done = calibrate(gaussian(runs=150), 0.15, draws=600)
    for name in ("mean", "idle"):
        # levels are few, so that sets hold somewhat more than 90 %
        assert done.coverage[name].high > 0.9 and done.uniform_p[name] > 0.01
    assert done.experiments + done.unanswered == 600 and done.unanswered < 30


def test_a_quiet_share_that_films_told_would_narrow_the_sets():
    """It is the mean itself with a small error, so the sets shrink to its level."""
    noise = 0.05 * np.random.default_rng(4).standard_normal((2, LEVELS.size, 3, 150))
    trials = replace(gaussian(runs=150), quiet_share=LEVELS[:, np.newaxis, np.newaxis] + noise)
    near = trials.as_quiet([0.5, -1.0], 0.15)
    assert near[0, LEVELS == 0.5].mean() > 0.99 and near[1, LEVELS == -1.0].mean() > 0.99
    assert near.mean() < 1.01 / LEVELS.size
    without, with_share = (calibrate(trials, 0.3, draws=100, quiet_within=x) for x in (None, 0.15))
    assert without.levels["mean"] > 3 > 1.1 > with_share.levels["mean"] >= 1
    assert with_share.levels["idle"] == pytest.approx(3, abs=0.2)
    assert with_share.coverage["mean"].value == 1
    with pytest.raises(NotEnoughDataError, match="no quiet share"):
        gaussian(runs=3).as_quiet([0.5, -1.0], 0.15)


def test_what_fits_is_the_median_level_with_the_range_of_95_percent():
    probability = np.array([[0.01, 0.02], [0.3, 0.1], [0.2, 0.3], [0.05, 0.02]])
    levels = {
        "friction_ratio": np.array([0.4, 0.45, 0.5, 0.55]),
        "speed_factor": np.array([1, 2.0]),
    }
    answer = inference.Posterior(levels, probability, 0.1, (7, 5))
    fitted = measure.fitted(answer, "friction_ratio")  # 3, 40, 50 and 7 % at the levels
    assert (fitted.value, fitted.low, fitted.high, fitted.runs) == (0.5, 0.4, 0.55, 5)
    fitted = measure.fitted(answer, "speed_factor")  # 56 and 44 %
    assert (fitted.value, fitted.low, fitted.high) == (1, 1, 2)


def test_a_level_stands_for_the_noises_half_way_around_it_in_ratio():
    coarse = np.array([0.5, 1.0, 2.0, 4.0])
    for levels in (coarse, np.geomspace(0.5, 4, 13), coarse[1:3]):
        span = levels.size * np.log(levels[1] / levels[0])
        assert measure.assigned_share(levels) == pytest.approx(np.log(2) / span)
    share = measure.assigned_share(coarse, np.array([0.1, 0.2, 0.6, 0.1]))
    assert share == pytest.approx(0.2 / 2 + 0.6 / 2)
    assert measure.assigned_share(coarse[2:3]) == 1.0 and measure.assigned_share(coarse[3:]) == 0.0


# --- trials of the experiment ---------------------------------------------------------------------


def grid(velocities, noises=(1.0, 2.0), ratios=(0.4, 0.45, 0.5), runs=3):
    """Trials whose r tells their point and number, in shuffled order."""
    rows = list(itertools.product(noises, ratios, velocities, range(runs)))
    noise, ratio, velocity, number = np.random.default_rng(2).permutation(rows).T
    r = np.exp(noise + 10 * ratio + 0.01 * velocity + 1e-4 * number)
    return {
        "noise": noise,
        "lasting_share": noise + 0.01 * velocity,
        "friction_ratio": ratio,
        "belt_velocity": velocity,
        "mean_length": np.full(noise.size, 600.0),
        "disorder_parameter": of_model(r),
        "lasting_longest": 100 * velocity,
        "lively_longest": np.full(noise.size, 2000.0),
    }


def test_trials_at_speeds_in_the_ratio_of_the_recordings_are_pairs():
    first = observations.EXPERIMENT[0].belt_velocity
    velocities = first * np.array([1.0, 14 / 11, (14 / 11) ** 2, 1.1])
    simulated = observations.on_grid(grid(velocities, noises=(1.0, 2.0, 4.5)))
    # shares are averaged over 0.035 of the logarithm of the speed, in steps of the grid
    assert simulated.smoothing == pytest.approx({"speed_factor": 0.035 / np.log(14 / 11)})
    np.testing.assert_allclose(simulated.levels["speed_factor"], [1, 14 / 11])
    # the printed constants are the most probable ones before, by errors that we allow them
    ratio, factor = np.exp(-2 / 9), np.exp(-((np.log(14 / 11) / 0.2) ** 2) / 2)
    prior = simulated.prior / simulated.prior[0, 1, 0]
    np.testing.assert_allclose(prior, np.tile(np.outer([ratio, 1, ratio], [1, factor]), (3, 1, 1)))
    assert simulated.summary.shape == (2, 3, 3, 2, 3) and simulated.runs == 3
    for recording, shift in ((0, 1.0), (1, 14 / 11)):
        u = first * shift * simulated.levels["speed_factor"]
        expected = 2.0 + 10 * 0.5 + 0.01 * u
        np.testing.assert_allclose(simulated.summary[recording, 1, 2].min(axis=-1), expected)
        np.testing.assert_allclose(simulated.quiet_share[recording, 1, 2, :, 0], 2.0 + 0.01 * u)
    # 60 s are 784.6 model units at the first speed, 200 at the second
    assert (
        simulated.shown[0, 0, 0].all(axis=-1).tolist() == [True, True] and simulated.shown[1].all()
    )


def test_what_is_no_grid_is_refused():
    arrays = grid(observations.EXPERIMENT[0].belt_velocity * np.array([1.0, 14 / 11]))
    short = {name: values[:-1] for name, values in arrays.items()}
    elsewhere = arrays | {"noise": np.where(np.arange(36) == 0, 3.0, arrays["noise"])}
    for wrong in (short, elsewhere, {name: values[:0] for name, values in arrays.items()}):
        with pytest.raises(NotEnoughDataError, match="no full grid"):
            observations.on_grid(wrong)
    with pytest.raises(NotEnoughDataError, match="ratio of those of the experiment"):
        observations.on_grid(grid([10.0, 11.0]))


def of_model(along_tape):
    """r of x_5 without blocks, if <x_5> is 600 units of 1.4 mm and 4.5 blocks have 18 cm."""
    return along_tape * (0.84 + 0.18) / 0.84


def test_r_along_the_tape_is_smaller_by_the_blocks_in_the_mean():
    """Blocks between the springs shift x_5 and do not change how it scatters."""
    x = 600 + 80 * np.sin(np.arange(1000))
    longer = x + 4.5 * 0.04 / 1.4e-3
    arrays = {"disorder_parameter": np.array([x.std() / x.mean()]), "mean_length": x.mean()}
    (shown,) = observations.disorder_along_tape(arrays)
    assert shown == pytest.approx(longer.std() / longer.mean(), rel=1e-6)


def test_a_trial_agrees_in_r_and_in_both_regimes():
    first, second = observations.EXPERIMENT
    arrays = {
        "mean_length": np.full(6, 600.0),
        "disorder_parameter": of_model(np.array([0.072, 0.079, 0.080, 0.072, 0.072, 0.052])),
        "lasting_longest": np.array([800.0, 800, 800, 700, 800, 300]),
        "lively_longest": np.array([2000.0, 2000, 2000, 2000, 1500, 300]),
    }
    assert observations.agrees(first, arrays).tolist() == [1, 1, 0, 0, 0, 0]
    assert observations.agrees(second, arrays).tolist() == [0, 0, 0, 0, 0, 1]
    assert observations.alternates(arrays).all()
    assert first.belt_velocity == pytest.approx(12.0176, abs=1e-3)
    velocity = {"belt_velocity": np.array([12.0176, 12.1, 15.2951])}
    assert observations.at_speed(first, velocity).tolist() == [True, False, False]
    assert observations.at_speed(second, velocity).tolist() == [False, False, True]


def test_the_odds_are_those_of_a_plain_loop():
    """Trials in which no two properties go together, in cells of unequal size."""
    rng, first = np.random.default_rng(3), observations.EXPERIMENT[0]
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
    second["belt_velocity"][:] = observations.EXPERIMENT[1].belt_velocity
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


# --- viscous friction beside the dry one ----------------------------------------------------------


def test_viscous_trials_are_counted_for_each_recording(monkeypatch):
    monkeypatch.setattr(runs, "RUNS", 3)
    monkeypatch.setattr(runs, "LENGTH", runs.LENGTH | {"duration": 1500.0, "transient": 500.0})
    rows = list(runs.viscous_trials(noise=2.0, friction_ratio=0.45, viscosity=0.05))
    assert [row["speed_m_s"] for row in rows] == [0.22, 0.28]
    for row in rows:
        assert row["runs"] == 3 and row["agrees"] <= row["shows"] <= 3
        assert 0.06 < row["r_lower"] <= row["r"] <= row["r_upper"] < 0.12


def test_published_viscous_trials_fall_through_the_recorded_r():
    table = pd.read_csv(runs.FILE)
    assert len(table) == 2 * np.prod([len(levels) for levels in runs.LEVELS.values()])
    for observation in observations.EXPERIMENT:
        here = table[table["speed_m_s"] == observation.speed_m_s]
        for _, line in here[here["friction_ratio"] == 0.45].groupby("noise"):
            r = line.sort_values("viscosity")["r"].to_numpy()
            assert r[0] > observation.disorder_parameter > r[-1]


def test_a_prediction_weighs_trials_by_the_posterior():
    values = np.array([[5.0, 1.0, 2.0], [4.0, 9.0, 7.0], [3.0, 8.0, 6.0]])
    weights = [3, 0, 2]
    answer = inference.Posterior({"mean": np.arange(3.0)}, np.array(weights) / 5, 0.1, (4,))
    drawn = np.concatenate(
        [np.repeat(row, weight) for row, weight in zip(values, weights, strict=True)]
    )
    wanted = [0.1, 0.5, 0.84]
    expected = np.quantile(drawn, wanted, method="inverted_cdf")
    np.testing.assert_array_equal(inference.predicted(answer, values, wanted), expected)
