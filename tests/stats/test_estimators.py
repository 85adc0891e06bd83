"""Formulas, errors and edges of the estimators, against formulas of other form and plain loops."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.distance import pdist

from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.replication.studies.noise import measure
from beltrepro.stats import dimension, fits, intermittency, scale_free, sections, spectra, states

RNG = np.random.default_rng

# --- fits -----------------------------------------------------------------------------------------


def test_a_line_has_the_slope_and_error_of_weighted_least_squares():
    rng = RNG(0)
    x = np.geomspace(0.5, 60, 9)
    y = 3 * x**-1.3 * np.exp(0.2 * rng.standard_normal(9))
    weight = rng.uniform(1, 5, 9)
    fit = fits.fit_log_log(x, y, low=0.5, high=60, weight=weight)
    # normal equations about the weighted means
    a, b = np.log(x), np.log(y)
    a0, b0 = np.average(a, weights=weight), np.average(b, weights=weight)
    spread = np.sum(weight * (a - a0) ** 2)
    slope = np.sum(weight * (a - a0) * (b - b0)) / spread
    residual = np.sum(weight * (b - b0 - slope * (a - a0)) ** 2) / (9 - 2)
    assert fit.exponent == pytest.approx(slope)
    assert fit.exponent_error == pytest.approx(math.sqrt(residual / spread))
    assert fit.prefactor == pytest.approx(math.exp(b0 - slope * a0))
    assert (fit.low, fit.high, fit.sample_size) == (0.5, 60, 9)
    assert fit(2.0) == pytest.approx(fit.prefactor * 2**slope)
    plain, line = fits.fit_log_log(x, y, low=0.5, high=60), stats.linregress(a, b)
    assert plain.exponent == pytest.approx(line.slope)
    assert plain.exponent_error == pytest.approx(line.stderr)


def test_a_fit_takes_the_points_in_its_range_that_have_a_logarithm_and_a_weight():
    x = np.array([-1.0, 0.0, 1, 2, 4, 8, 16, 32, 64])
    y = np.array([5.0, 5, 1, 2, 0, 8, 16, 32, 1e9])
    weight = np.array([1.0, 1, 1, 1, 1, 1, 0, 1, 1])
    fit = fits.fit_log_log(x, y, low=-2, high=32, weight=weight)
    assert fit.sample_size == 4 and fit.exponent == pytest.approx(1)
    assert fits.fit_log_log(x, y, low=1, high=32).sample_size == 5
    with pytest.raises(NotEnoughDataError, match="3 points between 2 and 32, 4 are needed"):
        fits.fit_log_log(x, y, low=2, high=32, weight=weight)


def test_the_error_of_a_line_is_the_spread_of_its_slope():
    rng, x = RNG(1), np.geomspace(1, 100, 12)
    results = [
        fits.fit_log_log(x, x**-1.5 * np.exp(0.3 * rng.standard_normal(12)), low=1, high=100)
        for _ in range(400)
    ]
    score = [(fit.exponent + 1.5) / fit.exponent_error for fit in results]
    assert stats.kstest(score, stats.t(10).cdf).pvalue > 1e-3


# --- avalanches -----------------------------------------------------------------------------------


def test_a_histogram_by_hand():
    centre, result, count = avalanches.log_histogram(
        [1, 2, 20, 300, 1000, 0, -5], bins_per_decade=1
    )
    np.testing.assert_allclose(centre, np.sqrt([10, 1000, 1e5]))
    assert count.tolist() == [2, 1, 2]
    np.testing.assert_allclose(
        result, np.array([2, 1, 2]) / (5 * np.array([9, 90, 900])), rtol=1e-9
    )
    part = avalanches.log_histogram([1, 2, 20, 300, 1000], bins_per_decade=1, low=10, high=100)
    assert part[2].tolist() == [1] and part[1] == pytest.approx([1 / (5 * 90)])
    # edges at whole multiples of a tenth of a decade, whatever the values
    centre, _, count = avalanches.log_histogram([1.3, 1.9], bins_per_decade=10)
    np.testing.assert_allclose(centre, 10 ** np.array([0.15, 0.25]))
    assert count.tolist() == [1, 1]
    with pytest.raises(NotEnoughDataError, match="no positive value"):
        avalanches.log_histogram([0.0, -1], bins_per_decade=5)


@pytest.mark.parametrize("decade", [1e-3, 1.0, 1e3])
def test_values_on_the_edges_are_kept_in_one_bin_each(decade):
    values = decade * np.array([1.0, 10.0])
    _, _, count = avalanches.log_histogram(values, bins_per_decade=2)
    assert count.tolist() == [1, 1]
    assert avalanches.log_histogram(values[:1], bins_per_decade=2)[2].tolist() == [1]


def test_the_falling_range_at_its_edges():
    centre, result = np.arange(1.0, 6), np.array([1, 5, 4, 3, 2.0])
    assert avalanches.falling_range(centre, result, np.array([10, 10, 10, 10, 9])) == (2, 4)
    assert avalanches.falling_range(centre, result, np.full(5, 10)) == (2, 5)
    with pytest.raises(NotEnoughDataError, match="holds 10 values"):
        avalanches.falling_range(centre, result, np.array([90, 90, 9, 90, 90]))
    with pytest.raises(NotEnoughDataError):
        avalanches.falling_range(centre, result[::-1] * [1, 1, 1, 1, 99], np.full(5, 90))


def test_a_density_is_fitted_with_its_counts_from_bin_to_bin():
    centre = np.geomspace(1, 100, 8)
    result = centre**-2 * np.array([1, 3, 1, 1.2, 1, 0.9, 1, 9])
    count = np.array([5, 50, 40, 30, 20, 10, 5, 1])
    fit = avalanches.fit_density(centre, result, count, low=centre[1], high=centre[6])
    inner = slice(1, 7)
    same = fits.fit_log_log(centre[inner], result[inner], low=0, high=1e9, weight=count[inner])
    assert (fit.exponent, fit.exponent_error) == (same.exponent, same.exponent_error)
    assert fit.sample_size == 6


def random_slips(seed, count=60):
    """Slips of three blocks on two chains that overlap, touch, or come alone, in any order."""
    rng = RNG(seed)
    slips = np.zeros(count, SLIP)
    slips["point"], slips["block"] = rng.integers(0, 2, count), rng.integers(1, 4, count)
    slips["start_time"] = rng.integers(0, 80, count) / 2
    slips["stop_time"] = slips["start_time"] + rng.integers(1, 9, count) / 2
    slips["dissipated"] = rng.random(count)
    return slips


@pytest.mark.parametrize("seed", range(3))
def test_samples_of_a_catalogue_are_those_of_a_plain_loop(seed):
    """Slips forth and back, of a size from far below 1 on, and of none."""
    slips = random_slips(seed)
    slips["start_position"] = RNG(seed).choice([-2.0, 0.0, 1e-3, 0.4, 1.0, 30.0], slips.size)
    catalogue = Dataset(
        {"slips": slips, "avalanches": slips}, {"n_blocks": 3, "belt_velocity": 0.1}
    )
    expected = {"laboratory": [], "belt": [], "last": []}
    for slip in slips[slips["block"] == 3]:
        size, time = slip["start_position"], slip["stop_time"] - slip["start_time"]
        for frame, moved in (("laboratory", size), ("belt", size + 0.1 * time)):
            expected[frame] += [(moved, slip["point"])] * bool(moved > 0)
        expected["last"].append((slip["dissipated"], slip["point"]))
    assert len(expected["laboratory"]) < len(expected["belt"]) < len(expected["last"])
    results = {frame: avalanches.slip_sizes(catalogue, frame) for frame in ("laboratory", "belt")}
    results["last"] = avalanches.last_block_energies(catalogue)
    for name, pairs in expected.items():
        np.testing.assert_allclose(np.transpose(results[name]), pairs)
        for chain, part in enumerate(results[name].by_chain()):
            np.testing.assert_allclose(part, [value for value, point in pairs if point == chain])


def test_a_power_law_is_tested_from_the_most_probable_value_to_the_largest():
    rng, chain = RNG(3), np.repeat([0, 1, 2, 3, 4], [90, 200, 150, 400, 60])
    values = 20 * (1 - rng.random(chain.size) * (1 - 12**-0.8)) ** (-1 / 0.8)
    values[rng.random(chain.size) < 0.1] /= 3
    fit = avalanches.scale_free_fit(avalanches.Sample(values, chain))
    centre, density, _ = avalanches.log_histogram(values, bins_per_decade=10)
    tail = values >= centre[np.argmax(density)]
    assert (fit.low, fit.high, fit.chains) == (values[tail].min(), values.max(), 5)
    law = scale_free.fit_law(np.log(values[tail]).mean(), fit.low, fit.high)
    assert fit.exponent.value == pytest.approx(law.exponent) and fit.exponent.runs == 5


def test_avalanches_reach_the_last_block_if_one_of_its_slips_starts_in_them():
    slips = random_slips(5)[:20]
    rng = RNG(6)
    starts = rng.integers(0, 40, 30).astype(float)
    catalogue = np.zeros(30, [("point", "i4"), ("start_time", "f8"), ("stop_time", "f8")])
    catalogue["point"] = rng.integers(0, 2, 30)
    catalogue["start_time"], catalogue["stop_time"] = starts, starts + 2
    expected = [
        any(
            slip["point"] == avalanche["point"]
            and slip["block"] == 3
            and avalanche["start_time"] <= slip["start_time"] <= avalanche["stop_time"]
            for slip in slips
        )
        for avalanche in catalogue
    ]
    assert avalanches.with_last_block(catalogue, slips, 3).tolist() == expected
    assert 0 < sum(expected) < 30


# --- spectra and densities ------------------------------------------------------------------------


def test_a_spectrum_is_averaged_in_bins_of_equal_width_before_its_fit():
    frequency = np.linspace(0.01, 1, 400)
    power = frequency**-1.2 * RNG(3).exponential(1.0, 400)
    bins: dict[int, list[int]] = {}
    for index, nu in enumerate(frequency):
        if 0.02 <= nu <= 0.9:
            bins.setdefault(math.floor(10 * math.log10(nu)), []).append(index)
    x = [math.exp(np.log(frequency[one]).mean()) for one in bins.values()]
    y = [power[one].mean() for one in bins.values()]
    line = stats.linregress(np.log(x), np.log(y))
    fit = spectra.fit_power_law(frequency, power, low=0.02, high=0.9)
    assert fit.exponent == pytest.approx(line.slope)
    assert fit.exponent_error == pytest.approx(line.stderr)
    assert fit.prefactor == pytest.approx(math.exp(line.intercept))
    assert fit.sample_size == len(bins)
    with pytest.raises(NotEnoughDataError, match="no frequency between 2 and 3"):
        spectra.fit_power_law(frequency, power, low=2, high=3)


def test_a_periodogram_is_the_square_of_the_fourier_transform():
    values = RNG(4).standard_normal(64) + 3
    frequency, power = spectra.power_spectrum(values, 0.25, window="boxcar")
    transform = np.fft.rfft(values - values.mean())[1:]
    expected = np.abs(transform) ** 2 * 0.25 / 64 * np.array([*[2] * 31, 1])
    np.testing.assert_allclose(frequency, np.arange(1, 33) / 16)
    np.testing.assert_allclose(power, expected)
    assert spectra.power_spectrum(values, 0.25, segment=16)[0].tolist() == list(np.arange(1, 9) / 4)
    assert spectra.power_spectrum(values[:16], 1.0, segment=99)[0].size == 8
    with pytest.raises(NotEnoughDataError, match="15 samples, a spectrum needs 16"):
        spectra.power_spectrum(values[:15], 1.0)


def test_a_velocity_density_by_hand():
    row = {
        "belt_velocity": np.array([2.0, 1.0, 2.0]),
        "section_velocity": np.array([[0.5, 1.5], [0.5, np.nan], [1.5, 9.0]]),
    }
    u_edges, v_edges, result = measure.velocity_density(row, bins=4, range=(0.0, 2.0))
    assert u_edges.tolist() == [0.5, 1.5, 2.5] and v_edges.tolist() == [0, 0.5, 1, 1.5, 2]
    assert result[:, 0].tolist() == [0, 2, 0, 0]
    np.testing.assert_allclose(result[:, 1], [0, 2 / 3, 0, 4 / 3])
    one = {"belt_velocity": np.array([3.0]), "section_velocity": np.array([[1.0]])}
    assert measure.velocity_density(one, bins=2, range=(0, 2))[0].tolist() == [2.5, 3.5]
    blank = {"belt_velocity": np.ones(1), "section_velocity": np.full((1, 3), np.nan)}
    assert np.isnan(measure.velocity_density(blank, bins=2, range=(0, 2))[2]).all()
    none = {"belt_velocity": np.empty(0), "section_velocity": np.empty((0, 3))}
    assert measure.velocity_density(none, bins=2, range=(0, 2))[2].shape == (2, 0)


# --- dimension ------------------------------------------------------------------------------------


def test_the_correlation_integral_is_the_share_of_close_pairs():
    points = RNG(5).random((700, 2))
    points[3] = np.nan
    fit = dimension.correlation_dimension(points, window=(1e-3, 1e-2))
    distances = pdist(np.delete(points, 3, axis=0))
    shares = [np.mean(distances <= radius) for radius in fit.radius]
    np.testing.assert_allclose(fit.correlation, shares, rtol=1e-12)
    assert (fit.low, fit.high) == (fit.radius[0], fit.radius[-1])
    assert fit.n_points == 699 and fit.radius.size == 24
    assert shares[0] == pytest.approx(1e-3, rel=0.1) and shares[-1] == pytest.approx(1e-2, rel=0.1)
    line = stats.linregress(np.log(fit.radius), np.log(shares))
    halves = [
        np.polyfit(np.log(fit.radius[half]), np.log(np.array(shares)[half]), 1)[0]
        for half in (slice(12), slice(12, None))
    ]
    assert fit.dimension == pytest.approx(line.slope)
    assert fit.error == pytest.approx(math.hypot(line.stderr, (halves[1] - halves[0]) / 2))


def test_the_window_of_the_dimension_holds_enough_pairs_and_not_too_many_points():
    points = RNG(6).random((600, 2))
    fit = dimension.correlation_dimension(points)
    pairs = 600 * 599 / 2
    assert fit.correlation[0] * pairs == pytest.approx(100, rel=0.3)
    few = dimension.correlation_dimension(np.repeat(points, 3, axis=0), max_points=600)
    assert few.n_points == 600
    assert few.dimension == pytest.approx(fit.dimension, abs=0.15)


# --- intermittency --------------------------------------------------------------------------------


def test_intermittent_points_at_the_edges_of_the_criterion():
    points = {
        "laminar_fraction": np.array([0.05, 0.049, 0.95, 0.951, 0.5, np.nan]),
        "laminar_count": np.array([2, 2, 2, 2, 1, 9]),
    }
    mask = intermittency.intermittent_mask(points)
    assert mask.tolist() == [True, False, True, False, False, False]
    wide = intermittency.intermittent_mask(points, low=0.01, high=0.99)
    assert wide.tolist() == [True] * 4 + [False] * 2


def test_laminar_phases_longer_than_the_limit_only():
    phases = intermittency.laminar_phases([0, 10], [5.0, 15.5], 5.0, start=0, stop=20)
    assert phases.tolist() == [[10, 15.5]]
    begun_before = intermittency.laminar_phases([10], [8.0, 18.0], 5.0, start=1, stop=20)
    assert begun_before.tolist() == [[1, 8], [10, 18]]
    without_start = intermittency.laminar_phases([], [8.0], 5.0, start=1, stop=20)
    assert without_start.tolist() == [[1, 8]]
    goes_on = intermittency.laminar_phases([3.0], [], 5.0, start=1, stop=20)
    assert goes_on.tolist() == [[3, 20]]
    assert intermittency.laminar_phases([], [], 5.0, start=0.0, stop=1.0).shape == (0, 2)


# --- sections -------------------------------------------------------------------------------------


def test_the_period_search_at_its_edges():
    cycle = np.arange(41.0)
    assert sections.find_period(np.tile(cycle[:40], 3)) == 40
    assert sections.find_period(np.tile(cycle, 3)) == 0  # longer than allowed
    assert sections.find_period(np.tile(cycle[:6], 3)) == 6
    assert sections.find_period(np.tile(cycle[:6], 3)[:-1]) == 0  # not three times over
    assert sections.find_period(np.tile(cycle[:4], 3)) == 4
    with pytest.raises(NotEnoughDataError, match="11 crossings"):
        sections.find_period(np.tile(cycle[:4], 3)[:11])


def test_the_tolerance_of_a_period_is_a_tenth_or_two_percent():
    def period(amplitude, error):
        values = np.tile([0.0, amplitude], 12)
        values[7] += error
        return sections.find_period(values)

    assert (period(1.0, 0.0999), period(1.0, 0.101)) == (2, 0)
    assert (period(5.0, 0.0999), period(5.0, 0.103)) == (2, 0)
    assert (period(50.0, 0.99), period(50.0, 1.05)) == (2, 0)
    assert sections.find_period(np.tile([0.0, 0.25], 8), tolerance=0.25) == 1


def test_the_occupied_share_by_hand():
    values = np.repeat([0.5, 1.5, 2.5, 9.5], [10, 5, 4, 1])  # of 20, 90 % are 18
    assert sections.occupied_share(values, range=(0, 10), bins=10) == 0.3
    assert sections.occupied_share(values, range=(0, 10), bins=10, mass=0.5) == 0.1
    assert sections.occupied_share(values, range=(0, 10), bins=10, mass=0.51) == 0.2
    assert sections.occupied_share(values, range=(0, 10), bins=10, mass=1.0) == 0.4
    beyond = np.repeat([-5.0, 50.0], [10, 5])
    assert sections.occupied_share(beyond, range=(0, 10), bins=10) == 0.2


def test_the_0_1_test_is_that_of_a_plain_loop():
    values = RNG(10).standard_normal(80).cumsum()
    results = []
    for frequency in RNG(0).uniform(math.pi / 5, 4 * math.pi / 5, 60):
        p, q, x, y = [0.0], [0.0], 0.0, 0.0
        for step, value in enumerate(values - values.mean(), start=1):
            x += value * math.cos(frequency * step)
            y += value * math.sin(frequency * step)
            p.append(x)
            q.append(y)
        lags, span = range(1, 9), 80 - 8
        squares = [
            np.mean([(p[1 + j + n] - p[1 + j]) ** 2 + (q[1 + j + n] - q[1 + j]) ** 2
                     for j in range(span)])
            for n in lags
        ]  # fmt: skip
        results.append(stats.pearsonr(lags, squares).statistic)
    assert sections.zero_one_test(values) == pytest.approx(np.median(results))
    assert sections.zero_one_test(np.full(50, 3.0)) == 0
    with pytest.raises(NotEnoughDataError, match="49 crossings, the 0-1 test needs 50"):
        sections.zero_one_test(values[:49])


def test_rows_tell_noise_levels_and_order_replicates():
    table = {
        "n_blocks": np.array([5, 5, 5, 4, 5, 5]),
        "belt_velocity": np.array([2.0, 1.0, 2.0, 1.0, 1.0, 1.0]),
        "noise": np.array([0.3, 0.3, 0.1 + 0.2, 0.3, 0.31, 0.3]),
        "replicate": np.array([1, 1, 0, 0, 0, 0]),
    }
    row = sections.rows(table, n_blocks=5, noise=0.3)
    assert row["belt_velocity"].tolist() == [1, 1, 2, 2]
    assert row["replicate"].tolist() == [0, 1, 0, 1]
    column = sections.columns(table, n_blocks=5, belt_velocity=1.0)
    assert column["noise"].tolist() == [0.3, 0.3, 0.31]
    assert column["replicate"].tolist() == [0, 1, 0]
    del table["replicate"]
    assert sections.rows(table, n_blocks=5, noise=0.3)["belt_velocity"].tolist() == [1, 1, 2, 2]
    kept = sections.select(row, row["replicate"] == 1)
    assert kept["belt_velocity"].tolist() == [1, 2]


# --- states ---------------------------------------------------------------------------------------


def one_state(monkeypatch=None, *, last_stick=1e9, share=0.0, count=0, velocities=(), chaos=None):
    points = {
        "belt_velocity": np.ones(1),
        "last_stick_time": np.array([last_stick]),
        "laminar_fraction": np.array([share]),
        "laminar_count": np.array([count]),
        "section_velocity": np.array([np.array(velocities, dtype=float)]),
    }
    if chaos is not None:
        monkeypatch.setattr(sections, "zero_one_test", lambda velocities: chaos)
    return states.label_states(points, transient=100.0, duration=300.0)[0]


def test_states_at_the_edges_of_their_criteria(monkeypatch):
    cycle, wandering = np.tile([1.0, 2.0], 30), 100 * RNG(11).random(60)
    assert one_state(last_stick=np.nan) == one_state(last_stick=100.0) == states.CONTINUOUS
    assert one_state(last_stick=100.1, velocities=cycle) == states.TRANSIENT
    assert one_state(last_stick=199.9, velocities=cycle) == states.TRANSIENT
    assert one_state(last_stick=200.0, velocities=cycle) == states.PERIODIC
    assert one_state(share=0.5, count=2, velocities=cycle) == states.INTERMITTENT
    assert one_state(share=0.5, count=1, velocities=cycle) == states.PERIODIC
    assert one_state(velocities=cycle[:11]) == states.UNDECIDED
    for chaos, label in (
        (0.81, states.CHAOTIC),
        (0.8, states.UNDECIDED),
        (0.2, states.UNDECIDED),
        (0.19, states.QUASI_PERIODIC),
    ):
        assert one_state(monkeypatch, velocities=wandering, chaos=chaos) == label


# --- on maps and samples whose answer is known --------------------------------------------------


def logistic(rate, size, start=0.3):
    """Orbit of the logistic map after a transient."""
    orbit = np.empty(2000 + size)
    value = start
    for step in range(orbit.size):
        value = rate * value * (1 - value)
        orbit[step] = value
    return orbit[2000:]


def henon(size):
    """Orbit of the Henon map with its usual parameters."""
    orbit = np.empty((size + 100, 2))
    x, y = 0.1, 0.1
    for step in range(orbit.shape[0]):
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        orbit[step] = x, y
    return orbit[100:]


@pytest.mark.parametrize(("rate", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.83, 3), (3.55, 8)])
def test_periods_of_the_logistic_map(rate, period):
    orbit = logistic(rate, 120)
    assert sections.find_period(orbit, tolerance=1e-4) == period


def test_chaos_and_quasi_periodic_motion_have_no_period():
    assert sections.find_period(100 * logistic(4.0, 200)) == 0
    assert sections.find_period(10 * np.cos(2 * np.pi * 0.618034 * np.arange(200))) == 0


def test_the_0_1_test_tells_chaos_from_regular_motion():
    assert sections.zero_one_test(logistic(4.0, 400)) > 0.9
    assert sections.zero_one_test(logistic(3.97, 400)) > 0.8
    assert abs(sections.zero_one_test(logistic(3.5, 400))) < 0.2
    rotation = np.cos(2 * np.pi * 0.618034 * np.arange(400))
    assert sections.zero_one_test(rotation) < 0.2


def test_the_correlation_dimension_of_the_henon_attractor():
    fit = dimension.correlation_dimension(henon(5000))
    assert fit.dimension == pytest.approx(1.2, abs=0.04)
    assert fit.error < 0.1


@pytest.mark.parametrize("true", [1, 2])
def test_the_correlation_dimension_of_a_curve_and_of_a_surface(true):
    parameters = np.random.default_rng(0).random((4000, true))
    embedding = np.random.default_rng(1).normal(size=(true, 6))
    fit = dimension.correlation_dimension(parameters @ embedding)
    assert fit.dimension == pytest.approx(true, abs=0.1)


def test_a_dimension_needs_points_in_more_than_a_few_places():
    with pytest.raises(NotEnoughDataError, match="500 are needed"):
        dimension.correlation_dimension(np.zeros((10, 2)))
    with pytest.raises(NotEnoughDataError, match="few places"):
        dimension.correlation_dimension(np.tile([[0.0, 0.0], [1.0, 2.0]], (400, 1)))


def test_laminar_phases_of_a_series_are_those_of_its_last_block():
    fields = [("time", "f8"), ("block", "i8"), ("kind", "U5")]
    rows = [(1, 2, "slip"), (5, 3, "slip"), (40, 2, "stick"), (41, 3, "stick"), (60, 3, "slip")]
    events = np.array(rows, fields)
    phases = intermittency.last_block_phases(events, 3, 30.0, start=0.0, stop=100.0)
    np.testing.assert_array_equal(phases, [[5, 41], [60, 100]])
    phases = intermittency.last_block_phases(events, 2, 30.0, start=5.0, stop=100.0)
    np.testing.assert_array_equal(phases, [[5, 40]])


def test_states_near_an_earlier_one_are_repeated():
    orbit = 100 * np.random.default_rng(3).random((7, 4))
    jitter = np.random.default_rng(4).uniform(-0.1, 0.1, (21, 4))
    states = np.vstack([orbit] * 3) + jitter
    np.testing.assert_array_equal(sections.repeated(states), np.arange(21) >= 7)
    assert not sections.repeated(states, near=1e-5).any()
    assert sections.repeated(np.empty((0, 4))).shape == (0,)
    # near is a part of the widest range, not of the distance between columns
    apart = np.column_stack([np.linspace(0, 1, 21), np.full(21, 1e6)])
    assert not sections.repeated(apart, near=0.01).any()


def test_new_states_are_apart_and_all_others_near_one_of_them():
    """Also over more states than are compared at once."""
    states = np.random.default_rng(5).random((2600, 2))
    again = sections.repeated(states, near=0.05)
    limit = 0.05 * np.ptp(states, axis=0).max()
    new = []
    for index, state in enumerate(states):
        near = any(np.hypot(*(state - states[other])) <= limit for other in new)
        assert again[index] == near
        if not near:
            new.append(index)
    assert 50 < len(new) < 500


SLIP = [
    ("point", "i4"),
    ("block", "i4"),
    ("start_time", "f8"),
    ("stop_time", "f8"),
    ("start_position", "f8"),
    ("stop_position", "f8"),
    ("dissipated", "f8"),
]


def bounded_power_law(exponent, low, high, size, seed=1):
    """Sample of a density ~ x**exponent between low and high, by inversion."""
    power = 1 + exponent
    uniform = np.random.default_rng(seed).random(size)
    return (low**power + uniform * (high**power - low**power)) ** (1 / power)


def coloured_noise(slope, size, seed=1):
    """Series whose power spectral density falls as frequency**slope."""
    rng = np.random.default_rng(seed)
    frequency = np.fft.rfftfreq(size)
    amplitude = np.zeros_like(frequency)
    amplitude[1:] = frequency[1:] ** (slope / 2)
    phase = np.exp(2j * np.pi * rng.random(frequency.size))
    return np.fft.irfft(amplitude * phase, size)


@pytest.mark.parametrize("slope", [0.0, -1.2, -2.0])
def test_the_slope_of_a_spectrum_is_recovered(slope):
    frequency, power = spectra.power_spectrum(coloured_noise(slope, 2**15), 0.1)
    fit = spectra.fit_power_law(frequency, power, low=0.01, high=3)
    assert fit.exponent == pytest.approx(slope, abs=0.05)


def test_a_power_spectrum_is_normalised_to_the_variance():
    values = np.random.default_rng(0).normal(5.0, 2.0, 20_000)
    frequency, power = spectra.power_spectrum(values, 0.5, segment=256)
    assert np.sum(power) * (frequency[1] - frequency[0]) == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("exponent", [-0.87, -1.47, -2.5])
def test_power_law_exponents_are_recovered_over_less_than_a_decade(exponent):
    values = bounded_power_law(exponent, 60, 400, 20_000)
    histogram = avalanches.log_histogram(values, bins_per_decade=20, low=60, high=400)
    line = avalanches.fit_density(*histogram, low=65, high=350)
    assert line.exponent == pytest.approx(exponent, abs=0.1)


def test_errors_of_a_density_come_from_the_scatter_of_runs():
    """Values of one run hang together: the error is that of the number of runs, not of values."""
    rng = np.random.default_rng(11)
    n_runs, values_a_run = 40, 50
    results = []
    for _ in range(200):
        place = np.repeat(rng.random(n_runs) < 0.3, values_a_run)
        values = np.where(place, 2.0, 30.0)
        run = np.repeat(np.arange(n_runs), values_a_run)
        centre, density, _ = avalanches.log_histogram(values, bins_per_decade=1, low=1, high=100)
        error = avalanches.density_error(values, run, centre, bins_per_decade=1)
        results.append((density[0], error[0]))
    densities, errors = np.array(results).T
    assert errors.mean() == pytest.approx(densities.std(), rel=0.1)


def test_error_of_a_density_by_hand():
    values, run = [2.0, 3.0, 20.0, 4.0, 50.0, 60.0, -1.0], [0, 0, 0, 1, 1, 1, 1]
    centre, *_ = avalanches.log_histogram(values, bins_per_decade=1)
    error = avalanches.density_error(values, run, centre, bins_per_decade=1)
    # without one of two runs the shares in the first bin, 1 to 10, are 1/3 and 2/3
    np.testing.assert_allclose(error, [1 / 6 / 9, 1 / 6 / 90])
    assert np.isnan(avalanches.density_error([2.0, 3.0], [4, 4], centre, bins_per_decade=1)).all()
