"""Claims on how noise changes the transition: made-up runs with a known answer."""

import numpy as np
import pytest

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.verdicts.criteria import FAILS, HOLDS, UNDECIDED
from beltrepro.stats import estimates
from made_up import LEDGER, falling, grades, measured, replicates, table

RISING = {0.0: 16.5, 0.5: 16.7, 1.0: 17.0, 2.2: 18.0, 5.0: 20.5}  # u_c by sigma
WINDOWS = {0.0: 0.25}


@pytest.fixture(autouse=True)
def fewer_resamples(monkeypatch):
    """Enough for intervals whose ends are not asked for to a few percent."""
    monkeypatch.setattr(estimates, "RESAMPLES", 60)


def like_the_paper(**changes):
    return {"n5_replicates": replicates(RISING, windows=WINDOWS, **changes)}


# --- Figs. 13 and 14 ------------------------------------------------------------------------------


def test_weak_noise_leaves_the_transition_and_removes_windows():
    assert set(grades("sigma1-transition", **like_the_paper()).values()) == {HOLDS}
    shifted = {"n5_replicates": replicates(RISING | {1.0: 20.0}, windows=WINDOWS)}
    at_limit = {"n5_replicates": replicates(RISING | {1.0: 18.0}, windows=WINDOWS)}
    assert grades("sigma1-transition", **shifted)["u_c(1) - u_c(0)"] == FAILS
    assert grades("sigma1-transition", **at_limit)["u_c(1) - u_c(0)"] == UNDECIDED
    remaining = {"n5_replicates": replicates(RISING, windows={0.0: 0.5, 1.0: 0.25})}
    assert grades("sigma1-transition", **remaining)["windows at 1"] == FAILS


def test_the_scatter_of_r_is_compared_run_by_run():
    def ratio(quiet, noisy):
        scatter = {0.0: quiet, 1.0: noisy}
        return measured(
            "sigma1-transition", n5_replicates=replicates(RISING, scatter=scatter)
        ).judged["scatter of r, 1 over 0"]

    assert ratio(0.01, 0.003).high < 1 < ratio(0.003, 0.01).low
    same = ratio(0.006, 0.006)
    assert same.low < 1 < same.high
    assert ratio(0.01, 0.005).value == pytest.approx(0.5, rel=0.2)


def test_a_reading_takes_the_runs_without_noise_from_the_scheme():
    made = like_the_paper()
    made["n5_replicates_check"] = replicates({0.0: 15.0}, noises=[0.0], width=1.0)
    reading = "the paper's scheme at sigma = 0"
    shift = measured("sigma1-transition", reading, **made).judged["u_c(1) - u_c(0)"]
    assert shift.value == pytest.approx(2.0, abs=0.5)
    with pytest.raises(NotEnoughDataError, match="n5_replicates_wide"):
        measured("sigma1-transition", f"{reading}, wider starts", **made)


@pytest.mark.parametrize(
    ("critical", "difference", "slope"),
    [
        (RISING, HOLDS, HOLDS),
        ({0.0: 18.0, 0.5: 17.5, 1.0: 17.0, 2.2: 15.5, 5.0: 13.0}, FAILS, FAILS),
        (dict.fromkeys(RISING, 17.0), UNDECIDED, UNDECIDED),
        (RISING | {2.2: 15.0}, FAILS, HOLDS),
    ],
)
def test_u_c_of_sigma(critical, difference, slope):
    verdict = grades("uc-of-sigma", n5_replicates=replicates(critical))
    assert verdict["u_c(2.2) - u_c(0)"] == difference
    # One level that lies off the line widens the interval of the slope.
    assert verdict["slope of u_c over sigma"] in (slope, UNDECIDED)
    if critical != RISING | {2.2: 15.0}:
        assert verdict["slope of u_c over sigma"] == slope


def test_u_c_of_sigma_without_a_transition_at_strong_noise():
    made = replicates(RISING, noises=(0.0, 0.5, 1.0, 2.2))
    flat = replicates({5.0: 99.0}, noises=(5.0,))
    both = {name: np.concatenate([made.arrays[name], flat.arrays[name]]) for name in made.arrays}
    measurement = measured("uc-of-sigma", n5_replicates=Dataset(both, made.attributes))
    assert np.isnan(measurement.also["u_c(5)"].value)
    assert measurement.judged["slope of u_c over sigma"].value == pytest.approx(0.7, abs=0.2)
    few = replicates(RISING, noises=(0.0, 2.2))
    with pytest.raises(NotEnoughDataError, match="2 of 2 noise levels, not 3"):
        measured("uc-of-sigma", n5_replicates=few)


def test_other_settings_of_the_finder_are_readings():
    """A fall by a factor of 1.4 is none in the reading that asks for 1.5."""
    made = {"n5_replicates": replicates(RISING)}
    weak = made["n5_replicates"].arrays | {
        "disorder_parameter": made["n5_replicates"].arrays["disorder_parameter"] + 0.25
    }
    weak = {"n5_replicates": Dataset(weak, made["n5_replicates"].attributes)}
    reading = "fall by 1.5 or more"
    assert measured("uc-sigma22", reading, **made).also == measured("uc-sigma22", **made).also
    assert np.isfinite(measured("uc-sigma22", **weak).also["lower edge"].value)
    assert np.isnan(measured("uc-sigma22", reading, **weak).also["lower edge"].value)


@pytest.mark.parametrize(
    ("u_c", "verdict"), [(18.8, HOLDS), (15.0, FAILS), (17.6, UNDECIDED), (99.0, FAILS)]
)
def test_the_critical_velocity_at_sigma_22(u_c, verdict):
    made = {"n5_replicates": replicates(RISING | {2.2: u_c})}
    assert grades("uc-sigma22", **made)[""] == verdict
    if u_c < 90:
        in_si = measured("uc-sigma22", **made).also["u_c_m_s"].value
        assert in_si == pytest.approx(0.0183065 * u_c, rel=0.02)


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        ({0.0: 0.5}, [HOLDS, HOLDS, HOLDS, HOLDS]),
        ({0.0: 0.0}, [FAILS, HOLDS, HOLDS, HOLDS]),
        ({0.0: 0.125, 2.2: 0.125}, [UNDECIDED, HOLDS, UNDECIDED, HOLDS]),
        ({0.0: 0.5, 1.0: 0.375, 5.0: 0.5}, [HOLDS, FAILS, HOLDS, FAILS]),
    ],
)
def test_windows_are_counted_at_each_noise(share, expected):
    verdict = grades("windows-vanish", n5_replicates=replicates(RISING, windows=share))
    names = [f"at sigma = {level}" for level in ("0", "1", "2.2", "5")]
    assert [verdict[name] for name in names] == expected
    made = measured("windows-vanish", n5_replicates=replicates(RISING, windows=share))
    assert made.judged["at sigma = 0"].value == share[0.0]
    assert made.runs == 64  # eight runs at each of eight velocities up to 15


@pytest.mark.parametrize(("spread", "share"), [(0.45, 0.5), (0.55, 0.0)])
def test_a_window_fills_less_than_half_of_the_usual_bins(spread, share):
    made = replicates(RISING)
    half = (made.arrays["noise"] == 0) & (made.arrays["replicate"] <= 4)
    velocity = np.linspace(-60, 0, 100) * np.ones((half.size, 1))
    made.arrays["section_velocity"] = np.where(half[:, None], spread * velocity, velocity)
    assert measured("windows-vanish", n5_replicates=made).judged["at sigma = 0"].value == share


def test_windows_are_those_of_the_range_and_the_section():
    made = replicates(RISING, windows={0.0: 0.5})
    made.arrays["section_velocity"][:, 11:] = np.nan
    with pytest.raises(NotEnoughDataError, match="0 runs cross the section, 6 are needed"):
        measured("windows-vanish", n5_replicates=made)
    above = replicates(RISING, windows={0.0: 0.0})
    above.arrays["section_velocity"][above.arrays["belt_velocity"] > 15] = -20.0
    assert measured("windows-vanish", n5_replicates=above).judged["at sigma = 0"].value == 0


# --- along sigma ----------------------------------------------------------------------------------


def rising(noise, centre, width, *, low=0.06, high=0.13):
    return low + (high - low) * np.clip((noise - centre + width / 2) / width, 0, 1)


def u7(centre, *, width=0.2, scatter=0.002, without=0.06):
    noise = np.repeat(np.arange(0, 2.01, 0.1), 8)
    rng = np.random.default_rng(2)
    disorder = np.where(noise > 0, rising(noise, centre, width), without)
    disorder = disorder + scatter * rng.standard_normal(noise.size)
    return table(np.column_stack([np.full(noise.size, 7.0), noise]), disorder)


def noisy_motion(exponents, *, scatter=1e-4):
    """Largest exponents at u = 7, by noise: mean over eight runs."""
    noise = np.repeat(list(exponents), 8)
    about = scatter * np.tile([-1.0, 1.0], noise.size // 2)
    arrays = {
        "n_blocks": np.full(noise.size, 5),
        "belt_velocity": np.full(noise.size, 7.0),
        "noise": noise,
        "largest_exponent": np.repeat(list(exponents.values()), 8) + about,
    }
    return Dataset(arrays, {"transient": 1e5, "duration": 2e5})


EXPONENTS = {0.25: -0.001, 0.75: 0.0, 1.0: 0.001, 1.5: 0.002, 2.2: 0.003, 5.0: -0.001}


def test_noise_induced_chaos_at_u_7():
    def verdict(centre=0.75, exponents=(), **options):
        made = noisy_motion(EXPONENTS | dict(exponents), **options)
        return grades("sigma-c-u7", n5_u7=u7(centre), noisy_motion=made)

    assert set(verdict().values()) == {HOLDS}
    assert verdict(1.3)["sigma_c"] == FAILS
    assert verdict(0.95)["sigma_c"] == UNDECIDED
    above = "lowest exponent from sigma = 1 to 2.2"
    assert verdict(exponents={1.5: -0.001})[above] == FAILS
    assert verdict(exponents={1.5: 0.00001})[above] == UNDECIDED
    assert verdict(exponents={0.75: -0.001, 5.0: -0.001})[above] == HOLDS
    below = "exponent at the weakest noise"
    assert verdict(exponents={0.25: 0.001})[below] == FAILS
    # the exponent of periodic motion, which is 0, with an interval of a tenth of the limit
    assert verdict(exponents={0.25: 0.0}, scatter=1e-6)[below] == HOLDS


def test_the_scheme_without_noise_counts_in_a_reading_only():
    made = {"n5_u7": u7(0.75, without=9.0), "noisy_motion": noisy_motion(EXPONENTS)}
    assert measured("sigma-c-u7", **made).judged["sigma_c"].value == pytest.approx(0.75, abs=0.05)
    other = measured("sigma-c-u7", "with the paper's scheme at sigma = 0", **made)
    assert other.judged["sigma_c"].value != pytest.approx(0.75, abs=0.05)


def test_noise_induced_chaos_needs_exponents_on_both_sides():
    strong = {level: value for level, value in EXPONENTS.items() if level > 0.3}
    with pytest.raises(NotEnoughDataError, match=r"no exponents at sigma <= 0\.3"):
        measured("sigma-c-u7", n5_u7=u7(0.75), noisy_motion=noisy_motion(strong))
    weak = {level: value for level, value in EXPONENTS.items() if level < 1 or level > 3}
    with pytest.raises(NotEnoughDataError, match=r"no exponents from sigma = 1 to 2\.2"):
        measured("sigma-c-u7", n5_u7=u7(0.75), noisy_motion=noisy_motion(weak))


def columns(centre, width, *, high=0.13):
    """Columns at six u; centre and width are functions of u."""
    rng = np.random.default_rng(4)
    points, disorder = [], []
    for u in (18.0, 20.0, 22.0, 25.0, 30.0, 35.0, 40.0):
        noise = np.repeat(np.arange(0, 10.01, 0.5), 8)
        points += [(u, each) for each in noise]
        own = rising(noise, centre(u), width(u), high=high)
        disorder += list(own + 0.001 * rng.standard_normal(noise.size))
    return {"n5_columns": table(points, disorder)}


def test_the_rise_of_r_against_u():
    def verdict(centre=lambda u: 0.2 * u - 2, width=lambda u: 0.1 * u, **options):
        judgement = grades("r-of-sigma", **columns(centre, width, **options))
        return [judgement[name] for name in LEDGER["r-of-sigma"].criterion["allowed"]]

    assert verdict() == [HOLDS, HOLDS, HOLDS]
    assert verdict(centre=lambda u: 8 - 0.1 * u) == [HOLDS, FAILS, HOLDS]
    assert verdict(width=lambda u: 5 - 0.1 * u) == [HOLDS, HOLDS, FAILS]
    assert verdict(centre=lambda u: 4.0, width=lambda u: 2.0) == [HOLDS, UNDECIDED, UNDECIDED]
    with pytest.raises(NotEnoughDataError, match="r rises in 0 of 6 columns, not 3"):
        verdict(high=0.07)


# --- Figs. 17 and 18 ------------------------------------------------------------------------------


def rows(spread):
    """Single runs at sigma = 0 and 10; spread of v_N above u = 25, by noise."""
    points = [(u, s) for s in spread for u in np.arange(1.0, 51)]
    rng = np.random.default_rng(6)
    reach = np.array([spread[s] if u > 25 else 60.0 for u, s in points])
    reach *= rng.uniform(0.8, 1.2, len(points))
    velocity = -reach[:, None] * rng.random((len(points), 200))
    return table(points, np.ones(len(points)), section_velocity=velocity)


@pytest.mark.parametrize(
    ("quiet", "strong", "verdicts"),
    [(5.0, 50.0, [HOLDS, HOLDS]), (50.0, 5.0, [FAILS, FAILS]), (27.0, 27.0, [UNDECIDED] * 2)],
)
def test_the_natural_distribution(quiet, strong, verdicts):
    made = replicates(RISING, width={0.0: 1.0, 0.5: 1.0, 1.0: 1.0, 2.2: 2.0, 5.0: 9.0})
    both = {"n5_replicates": made, "n5_rows": rows({0.0: quiet, 10.0: strong})}
    verdict = grades("natural-distribution", **both)
    assert verdict["windows at 1"] == verdict["width(5) - width(1)"] == HOLDS
    assert [verdict["spread ratio at 0"], verdict["spread ratio at 10"]] == verdicts
    both["n5_replicates"] = replicates(
        RISING, width={1.0: 9.0, 5.0: 1.0} | dict.fromkeys((0, 0.5, 2.2), 1.0)
    )
    assert grades("natural-distribution", **both)["width(5) - width(1)"] == FAILS


def map_of(factor=1.0, *, quiet=0, loud=0):
    """Map at whole u; of the points at low u and sigma = 1 so many are quiet, of high u loud."""
    points = np.array([(u, s) for s in (0.0, 1.0, 5.0) for u in np.arange(1.0, 51)])
    u, noise = points.T
    disorder = falling(u, np.select([noise == 0, noise == 1], [16.5, 17.0], 20.5), 3.0) * factor
    disorder[np.flatnonzero((u <= 15) & (noise == 1))[:quiet]] = 0.05
    disorder[np.flatnonzero((u >= 25) & (noise <= 2))[:loud]] = 0.13
    return table(points, disorder)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, [HOLDS, HOLDS, HOLDS]),
        ({"factor": 1.2}, [FAILS, HOLDS, HOLDS]),
        ({"factor": 0.8}, [FAILS, HOLDS, HOLDS]),
        ({"quiet": 14}, [HOLDS, FAILS, HOLDS]),
        ({"quiet": 6}, [HOLDS, UNDECIDED, HOLDS]),
        ({"loud": 40}, [HOLDS, HOLDS, FAILS]),
        ({"loud": 24}, [HOLDS, HOLDS, UNDECIDED]),
    ],
)
def test_the_map(change, expected):
    verdict = grades("r-map", n5_map=map_of(**change), n5_replicates=replicates(RISING))
    assert [verdict[name] for name in LEDGER["r-map"].criterion["allowed"]] == expected


def test_the_map_is_not_compared_across_integrators():
    made = replicates(RISING)
    own = made.arrays["noise"] == 0
    made.arrays["disorder_parameter"][own] *= 9  # without noise
    assert grades("r-map", n5_map=map_of(), n5_replicates=made)[""] == HOLDS
    with pytest.raises(NotEnoughDataError, match="0 points shared, not 10"):
        measured("r-map", n5_map=map_of(), n5_replicates=replicates(RISING, noises=(0.0,)))


# --- what sigma means -----------------------------------------------------------------------------


def noise_steps(r_of, *, scatter=0.002):
    points = [(s, dt) for s in (0.5, 1.0, 2.0) for dt in (0.00025, 0.001, 0.004) for _ in range(8)]
    noise, step = np.array(points).T
    rng = np.random.default_rng(7)
    disorder = r_of(noise, step) * np.exp(scatter * rng.standard_normal(noise.size))
    return {
        "noise_steps": table(np.column_stack([np.full(72, 18.0), noise]), disorder, time_step=step)
    }


def test_the_noise_depends_on_the_time_step():
    def verdict(r_of, **options):
        found = grades("noise-time-step", **noise_steps(r_of, **options))
        return [found["equal sigma"], found["equal sigma sqrt(dt)"]]

    def by_product(noise, step):
        return 0.02 + 1.5 * noise * np.sqrt(step)

    assert verdict(by_product) == [HOLDS, HOLDS]
    assert verdict(lambda noise, step: 0.02 + 0.05 * noise) == [FAILS, FAILS]
    assert verdict(lambda noise, step: 0.02 + 20 * noise * step) == [HOLDS, FAILS]
    assert verdict(lambda noise, step: 0.1 + 0 * noise, scatter=0.2) == [UNDECIDED, UNDECIDED]
