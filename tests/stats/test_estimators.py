"""Formulas, errors and edges of the estimators, against formulas of other form and plain loops."""

import itertools
import math

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.distance import pdist

from beltrepro.replication.studies.avalanches import slips as avalanches
from beltrepro.replication.studies.integrators import compared as agreement
from beltrepro.replication.studies.integrators import divergence, samples
from beltrepro.replication.studies.transition import lifetimes
from beltrepro.stats import (
    density,
    dimension,
    fits,
    intermittency,
    sections,
    spectra,
    states,
)
from beltrepro.stats.errors import NotEnoughDataError

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
    found = [
        fits.fit_log_log(x, x**-1.5 * np.exp(0.3 * rng.standard_normal(12)), low=1, high=100)
        for _ in range(400)
    ]
    score = [(fit.exponent + 1.5) / fit.exponent_error for fit in found]
    assert stats.kstest(score, stats.t(10).cdf).pvalue > 1e-3


# --- avalanches -----------------------------------------------------------------------------------


def test_a_histogram_by_hand():
    centre, found, count = avalanches.log_histogram([1, 2, 20, 300, 1000, 0, -5], bins_per_decade=1)
    np.testing.assert_allclose(centre, np.sqrt([10, 1000, 1e5]))
    assert count.tolist() == [2, 1, 2]
    np.testing.assert_allclose(found, np.array([2, 1, 2]) / (5 * np.array([9, 90, 900])), rtol=1e-9)
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
    centre, found = np.arange(1.0, 6), np.array([1, 5, 4, 3, 2.0])
    assert avalanches.falling_range(centre, found, np.array([10, 10, 10, 10, 9])) == (2, 4)
    assert avalanches.falling_range(centre, found, np.full(5, 10)) == (2, 5)
    few = avalanches.falling_range(centre, found, np.array([0, 5, 3, 3, 2]), minimum_count=3)
    assert few == (2, 4)
    with pytest.raises(NotEnoughDataError, match="holds 10 values"):
        avalanches.falling_range(centre, found, np.array([90, 90, 9, 90, 90]))
    with pytest.raises(NotEnoughDataError):
        avalanches.falling_range(centre, found[::-1] * [1, 1, 1, 1, 99], np.full(5, 90))


def test_a_density_is_fitted_with_its_counts_from_bin_to_bin():
    centre = np.geomspace(1, 100, 8)
    found = centre**-2 * np.array([1, 3, 1, 1.2, 1, 0.9, 1, 9])
    count = np.array([5, 50, 40, 30, 20, 10, 5, 1])
    fit = avalanches.fit_density(centre, found, count, low=centre[1], high=centre[6])
    inner = slice(1, 7)
    same = fits.fit_log_log(centre[inner], found[inner], low=0, high=1e9, weight=count[inner])
    assert (fit.exponent, fit.exponent_error) == (same.exponent, same.exponent_error)
    assert fit.sample_size == 6


def random_slips(seed, count=60):
    """Slips of three blocks on two chains that overlap, touch, or come alone, in any order."""
    rng = RNG(seed)
    slips = np.zeros(count, [("point", "i4"), ("block", "i4"), ("start_time", "f8"),
                             ("stop_time", "f8"), ("dissipated", "f8")])  # fmt: skip
    slips["point"], slips["block"] = rng.integers(0, 2, count), rng.integers(1, 4, count)
    slips["start_time"] = rng.integers(0, 80, count) / 2
    slips["stop_time"] = slips["start_time"] + rng.integers(1, 9, count) / 2
    slips["dissipated"] = rng.random(count)
    return slips


@pytest.mark.parametrize("seed", range(3))
def test_losses_while_the_last_block_slips_are_those_of_a_plain_loop(seed):
    slips, expected = random_slips(seed), []
    for own in sorted(
        slips[slips["block"] == 3], key=lambda own: (own["point"], own["start_time"])
    ):
        energy = 0.0
        for slip in slips[slips["point"] == own["point"]]:
            overlap = min(slip["stop_time"], own["stop_time"]) - max(
                slip["start_time"], own["start_time"]
            )
            length = slip["stop_time"] - slip["start_time"]
            energy += slip["dissipated"] * max(overlap, 0.0) / length
        expected.append(energy)
    found = avalanches.dissipation_while_last_block_slips(slips, 3)
    np.testing.assert_allclose(np.sort(found), np.sort(expected))
    np.testing.assert_allclose(found.sum(), sum(expected))


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
    x = [math.exp(np.log(frequency[own]).mean()) for own in bins.values()]
    y = [power[own].mean() for own in bins.values()]
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
    np.testing.assert_allclose(spectra.amplitude_spectrum(frequency, power), np.sqrt(expected / 16))
    assert spectra.power_spectrum(values, 0.25, segment=16)[0].tolist() == list(np.arange(1, 9) / 4)
    assert spectra.power_spectrum(values[:16], 1.0, segment=99)[0].size == 8


def test_a_velocity_density_by_hand():
    row = {
        "belt_velocity": np.array([2.0, 1.0, 2.0]),
        "section_velocity": np.array([[0.5, 1.5], [0.5, np.nan], [1.5, 9.0]]),
    }
    u_edges, v_edges, found = density.velocity_density(row, bins=4, range=(0.0, 2.0))
    assert u_edges.tolist() == [0.5, 1.5, 2.5] and v_edges.tolist() == [0, 0.5, 1, 1.5, 2]
    assert found[:, 0].tolist() == [0, 2, 0, 0]
    np.testing.assert_allclose(found[:, 1], [0, 2 / 3, 0, 4 / 3])
    one = {"belt_velocity": np.array([3.0]), "section_velocity": np.array([[1.0]])}
    assert density.velocity_density(one, bins=2, range=(0, 2))[0].tolist() == [2.5, 3.5]
    none = {"belt_velocity": np.empty(0), "section_velocity": np.empty((0, 3))}
    assert density.velocity_density(none, bins=2, range=(0, 2))[2].shape == (2, 0)


# --- dimension ------------------------------------------------------------------------------------


def test_the_correlation_integral_is_the_share_of_close_pairs():
    points = RNG(5).random((700, 2))
    points[3] = np.nan
    found = dimension.correlation_dimension(points, window=(1e-3, 1e-2))
    distances = pdist(np.delete(points, 3, axis=0))
    shares = [np.mean(distances <= radius) for radius in found.radius]
    np.testing.assert_allclose(found.correlation, shares, rtol=1e-12)
    assert (found.low, found.high) == (found.radius[0], found.radius[-1])
    assert found.n_points == 699 and found.radius.size == 24
    assert shares[0] == pytest.approx(1e-3, rel=0.1) and shares[-1] == pytest.approx(1e-2, rel=0.1)
    line = stats.linregress(np.log(found.radius), np.log(shares))
    halves = [
        np.polyfit(np.log(found.radius[half]), np.log(np.array(shares)[half]), 1)[0]
        for half in (slice(12), slice(12, None))
    ]
    assert found.dimension == pytest.approx(line.slope)
    assert found.error == pytest.approx(math.hypot(line.stderr, (halves[1] - halves[0]) / 2))


def test_the_window_of_the_dimension_holds_enough_pairs_and_not_too_many_points():
    points = RNG(6).random((600, 2))
    found = dimension.correlation_dimension(points)
    pairs = 600 * 599 / 2
    assert found.correlation[0] * pairs == pytest.approx(100, rel=0.3)
    few = dimension.correlation_dimension(np.repeat(points, 3, axis=0), max_points=600)
    assert few.n_points == 600
    assert few.dimension == pytest.approx(found.dimension, abs=0.15)


# --- divergence -----------------------------------------------------------------------------------


def pair(separation, event_times, shifts=()):
    return divergence.Pair(
        time=np.arange(len(separation), dtype=float),
        separation=np.array(separation, dtype=float),
        event_time=np.arange(len(shifts), dtype=float),
        event_shift=np.array(shifts, dtype=float),
        reference_events=np.array(event_times, dtype=float),
    )


def test_errors_after_events_by_hand():
    one = pair([0, 0.1, 0.2, 0.5, 1.0, 1.01], [1.0, 2.5, 5.0])
    assert one.parting_time == 5  # beyond 1, not at 1
    assert one.error_after(0) == 0  # before the first event
    assert one.error_after(1) == 0.2  # the sample after t = 1, not the one at it
    assert one.error_after(2) == 0.5
    assert np.isnan(one.error_after(3)) and np.isnan(one.error_after(4))
    assert pair([0.3, 0.7, 0.2], []).error_after(0) == 0.7
    assert pair([0.3], [0.0]).error_after(0) == 0
    assert pair([0, 1, 0.5], []).parting_time == np.inf


def test_errors_are_root_mean_squares_where_all_members_have_one():
    found = divergence.errors([pair([0, 3, 3], [0.5, 1.5]), pair([0, 4, 9], [0.5])])
    assert found == {0: (2, 0.0), 1: (2, pytest.approx(math.sqrt((9 + 16) / 2)))}


def test_a_summary_takes_medians_over_members():
    members = [
        pair([0, 2], [0.5], shifts=[0.1] * 10 + [-9.0]),
        pair([0, 0, 2], [0.5, 0.6, 0.7], shifts=[-0.3]),
        pair([0, 0, 0], [0.5] * 8, shifts=[0.2, 0.0]),
    ]
    assert divergence.summarise(members) == {
        "members": 3,
        "parting_time": 2,
        "shared_events": 2,
        "reference_events": 3,
        "first_shift": 0.2,
        "shift": 0.3,
    }
    assert np.isnan(divergence.summarise([pair([0], [])])["shift"])


def test_shared_events_are_less_than_half_a_time_unit_apart():
    def events(*rows):
        return np.array(list(rows), [("time", "f8"), ("block", "i4"), ("kind", "U5")])

    reference = events((1, 1, "slip"), (2, 1, "stick"), (3, 1, "slip"))
    for shift, shared in ((0.499, 3), (-0.499, 3), (0.5, 1), (-0.5, 1)):
        moved = events((1, 1, "slip"), (2 + shift, 1, "stick"), (3, 1, "slip"))
        assert divergence.match_events(moved, reference)[0].size == shared
    assert divergence.match_events(reference[:0], reference)[0].size == 0
    time, shift = divergence.match_events(reference[:2], reference)
    assert time.tolist() == [1, 2] and shift.tolist() == [0, 0]


# --- intermittency --------------------------------------------------------------------------------


def test_intermittent_points_at_the_edges_of_the_criterion():
    points = {
        "laminar_fraction": np.array([0.05, 0.049, 0.95, 0.951, 0.5, np.nan]),
        "laminar_count": np.array([2, 2, 2, 2, 1, 9]),
    }
    found = intermittency.intermittent_mask(points)
    assert found.tolist() == [True, False, True, False, False, False]
    wide = intermittency.intermittent_mask(points, low=0.01, high=0.99, minimum_phases=1)
    assert wide.tolist() == [True] * 5 + [False]


def test_laminar_phases_longer_than_the_limit_only():
    phases = intermittency.laminar_phases([0, 10], [5.0, 15.5], 5.0, start=0, stop=20)
    assert phases.tolist() == [[10, 15.5]]
    begun_before = intermittency.laminar_phases([10], [8.0, 18.0], 5.0, start=1, stop=20)
    assert begun_before.tolist() == [[1, 8], [10, 18]]
    without_start = intermittency.laminar_phases([], [8.0], 5.0, start=1, stop=20)
    assert without_start.tolist() == [[1, 8]]
    goes_on = intermittency.laminar_phases([3.0], [], 5.0, start=1, stop=20)
    assert goes_on.tolist() == [[3, 20]]


def test_sampled_laminar_phases_end_with_the_last_slipping_sample():
    velocity = [0, -1, -1, -1, 0, 1e-7, -1, -1, -1, -1]
    phases = intermittency.sampled_laminar_phases(np.arange(10.0), velocity, 1.5)
    assert phases.tolist() == [[1, 3], [6, 9]]
    assert intermittency.sampled_laminar_phases(np.arange(10.0), velocity, 2.0).tolist() == [[6, 9]]
    assert intermittency.sampled_laminar_phases(np.arange(3.0), [0, 0, 0], 0.5).shape == (0, 2)


# --- lifetimes ------------------------------------------------------------------------------------


def test_attractors_at_the_edge_of_the_amplitude():
    found = lifetimes.label_attractors([1, 1, 0], [0.05, 0.0499, 0.0], np.zeros((3, 2)))
    assert found.tolist() == [lifetimes.LARGE_SLIP, lifetimes.SMALL_SLIP, lifetimes.STICK_SLIP]


def test_the_last_block_of_a_shorter_chain_is_the_last_one_that_it_has():
    rates = [[0.0, 0.1, 0.0], [0.0, 0.1, np.nan], [0.1, 0.0, np.nan], [0.0, 0.0, 0.1]]
    found = lifetimes.label_attractors([1] * 4, [0.0] * 4, rates)
    assert (found == lifetimes.STICK_SLIP).tolist() == [False, True, False, True]


# --- samples --------------------------------------------------------------------------------------


def test_a_comparison_of_samples_by_formulas_of_their_own():
    rng = RNG(8)
    one, two = rng.normal(5, 1, 12), rng.normal(6, 3, 7)
    found = samples.compare_samples(one, two)
    variance = [np.var(side, ddof=1) / side.size for side in (one, two)]
    z = (one.mean() - two.mean()) / math.sqrt(sum(variance))
    degrees = sum(variance) ** 2 / (variance[0] ** 2 / 11 + variance[1] ** 2 / 6)
    assert found.z == pytest.approx(z)
    assert found.mean_p == pytest.approx(2 * stats.t.sf(abs(z), degrees))
    assert found.error_tested == pytest.approx(math.sqrt(variance[0]))
    assert found.error_reference == pytest.approx(math.sqrt(variance[1]))
    assert (found.n_tested, found.n_reference) == (12, 7)
    # area between the distribution functions, over the root mean square of the reference
    edges = np.sort(np.concatenate([one, two]))
    gap = [np.mean(one <= x) - np.mean(two <= x) for x in edges[:-1]]
    area = np.sum(np.abs(gap) * np.diff(edges))
    assert found.distance == pytest.approx(area / math.sqrt(np.mean(two**2)))
    statistic = max(abs(np.mean(one <= x) - np.mean(two <= x)) for x in edges)
    assert found.p == pytest.approx(stats.ks_2samp(one, two, method="exact").pvalue)
    assert statistic == pytest.approx(stats.ks_2samp(one, two).statistic)


def test_five_runs_are_a_sample_and_four_are_not():
    assert np.isfinite(samples.compare_samples(np.arange(5), np.arange(5) + 0.5).z)
    for sizes in ((4, 5), (5, 4)):
        one, two = (np.arange(size, dtype=float) for size in sizes)
        found = samples.compare_samples(one, two)
        assert np.isnan([found.p, found.z, found.mean_p]).all()
        shares = samples.compare_shares(one > 1, two > 1, labels=(True, False), counted=True)
        assert np.isnan([shares.p, shares.z]).all() and shares.mean_tested == np.mean(one > 1)
    alone = samples.compare_samples([1.0], [2.0, 3.0])
    assert np.isnan(alone.error_tested) and alone.error_reference == pytest.approx(0.5)
    assert np.isnan(samples.compare_samples([1.0, 2.0], [0.0, 0.0]).distance)
    lower = samples.compare_samples(np.zeros(5), np.ones(5))
    assert lower.z == -np.inf and lower.mean_p == 0


def test_the_p_of_shares_is_that_of_all_tables_with_the_same_margins():
    """Three labels: every table of the hypergeometric law, with its chi^2, counted out."""
    tested, reference = [0] * 5 + [1] * 2 + [2] * 3, [0] * 2 + [1] * 6 + [2] * 2
    total = np.array([7, 8, 5])

    def chi2(first):
        rows = np.array([first, total - first])
        expected = np.outer(rows.sum(axis=1), total) / 20
        return np.sum((rows - expected) ** 2 / expected)

    observed, exact = chi2(np.array([5, 2, 3])), 0.0
    for a, b in itertools.product(range(8), range(9)):
        first = np.array([a, b, 10 - a - b])
        if 0 <= first[2] <= 5:
            chance = math.prod(
                math.comb(n, k) for n, k in zip(total.tolist(), first.tolist(), strict=True)
            )
            exact += (chi2(first) >= observed - 1e-9) * chance / math.comb(20, 10)
    found = samples.compare_shares(tested, reference, labels=(0, 1, 2, 3), counted=0)
    assert found.p == pytest.approx(exact, abs=4 * math.sqrt(exact / 9999))
    assert found.distance == pytest.approx((0.3 + 0.4 + 0.1) / 2)
    again = samples.compare_shares(
        tested, reference, labels=(0, 1, 2), counted=0, n_permutations=99
    )
    assert again.p * 100 == pytest.approx(round(again.p * 100))
    # never less than one in the number of draws and one
    apart = samples.compare_shares([0] * 40, [1] * 40, labels=(0, 1), counted=0, n_permutations=99)
    assert apart.p == pytest.approx(0.01)


def test_lifetimes_need_five_escapes_on_both_sides_together():
    time = np.arange(1.0, 7)
    left = np.array([True, True, False, False, False, False])
    more = np.array([True, True, True, False, False, False])
    assert np.isfinite(
        samples.compare_lifetimes(time, time + 1, escaped_tested=left, escaped_reference=more).p
    )
    found = samples.compare_lifetimes(time, time, escaped_tested=left, escaped_reference=left)
    assert np.isnan(found.p) and found.distance == 0 and found.mean_tested == 3.5


def test_the_log_rank_test_by_hand():
    """Sum of observed minus expected escapes at each instant, over its hypergeometric variance."""
    rng = RNG(9)
    sides = [rng.exponential(tau, 15) for tau in (30.0, 60.0)]
    escaped = [side < 50 for side in sides]
    sides = [np.minimum(side, 50.0) for side in sides]
    difference, variance = 0.0, 0.0
    for instant in np.sort(np.concatenate([s[e] for s, e in zip(sides, escaped, strict=True)])):
        risk = [np.sum(side >= instant) for side in sides]
        difference += np.any(sides[0][escaped[0]] == instant) - risk[0] / sum(risk)
        variance += risk[0] * risk[1] / sum(risk) ** 2
    p = 2 * stats.norm.sf(abs(difference) / math.sqrt(variance))
    found = samples.compare_lifetimes(
        *sides, escaped_tested=escaped[0], escaped_reference=escaped[1]
    )
    assert found.p == pytest.approx(p)


def test_an_overall_test_by_hand():
    def comparison(mean_p, tested, reference, errors=(0.3, 0.4)):
        return samples.Comparison(
            9, 9, tested, errors[0], reference, errors[1], 0.0, mean_p, "", 0.5, 0.1
        )

    members = [comparison(0.2, 11.0, 10.0), comparison(0.9, 4.0, 5.0), comparison(0.4, 1.0, 0.0)]
    found = samples.overall([*members, comparison(np.nan, 100.0, 1.0)])
    chi2 = sum(stats.norm.ppf(p / 2) ** 2 for p in (0.2, 0.9, 0.4))
    assert found.degrees == 3 and found.chi2 == pytest.approx(chi2)
    assert found.chi2_p == pytest.approx(stats.chi2(3).sf(chi2))
    # the ordered p are 0.2, 0.4, 0.9: farthest from uniform by 2/3 - 0.4
    assert found.uniform_p == pytest.approx(stats.kstwo.sf(2 / 3 - 0.4, 3))
    assert found.shift == pytest.approx((0.1 - 0.2) / 2)
    assert found.shift_error == pytest.approx(math.hypot(0.5 / 10, 0.5 / 5) / 2)
    none = samples.overall([comparison(0.5, 1.0, 0.0)])
    assert none.degrees == 1 and np.isnan([none.shift, none.shift_error]).all()


def test_holm_stops_at_the_first_that_is_too_large():
    assert samples.holm([0.02, 0.03, 0.02]).tolist() == [0.06, 0.06, 0.06]
    np.testing.assert_allclose(samples.holm([0.001, 0.5, 0.4]), [0.003, 0.8, 0.8])
    assert samples.verdict(0.0, 0.01) == samples.DIFFER
    assert samples.verdict(0.0, 0.00999) == samples.CLOSE
    assert samples.verdict(0.0, np.nan) == samples.DIFFER


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
    found = []
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
        found.append(stats.pearsonr(lags, squares).statistic)
    assert sections.zero_one_test(values) == pytest.approx(np.median(found))
    assert sections.zero_one_test(np.full(50, 3.0)) == 0
    with pytest.raises(NotEnoughDataError, match="49 crossings, the 0-1 test needs 50"):
        sections.zero_one_test(values[:49])


def test_rows_tell_noise_levels_and_order_replicates():
    table = {
        "n_blocks": np.full(5, 5),
        "belt_velocity": np.array([2.0, 1.0, 2.0, 1.0, 1.0]),
        "noise": np.array([0.3, 0.3, 0.1 + 0.2, 0.31, 0.3]),
        "replicate": np.array([1, 1, 0, 0, 0]),
    }
    row = sections.rows(table, n_blocks=5, noise=0.3)
    assert row["belt_velocity"].tolist() == [1, 1, 2, 2]
    assert row["replicate"].tolist() == [0, 1, 0, 1]
    column = sections.columns(table, n_blocks=5, belt_velocity=1.0)
    assert column["noise"].tolist() == [0.3, 0.3, 0.31] and column["replicate"].tolist() == [
        0,
        1,
        0,
    ]
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


# --- agreement ------------------------------------------------------------------------------------


def scan_of(points, seed, replicates):
    """Arrays of a scan: so many replicates of each point (N, u, sigma), in any order."""
    rng = RNG(seed)
    rows = [point for point in points for _ in range(replicates)]
    rng.shuffle(rows)
    n_blocks, u, noise = (np.array(column) for column in zip(*rows, strict=True))
    section = rng.normal(-20, 3, (len(rows), 9))
    section[:, 6:] = np.nan
    section[1] = np.nan
    return {
        "n_blocks": n_blocks,
        "belt_velocity": u,
        "noise": noise,
        "disorder_parameter": rng.random(len(rows)),
        "mean_length": rng.normal(600, 9, len(rows)),
        "slip_count": rng.integers(0, 99, (len(rows), 10)),
        "section_count": rng.integers(50, 60, len(rows)),
        "section_velocity": section,
    }


def test_statistics_of_the_points_of_a_scan_by_hand():
    arrays = scan_of([(2, 5.0, 1.0), (10, 5.0, 1.0)], 17, 3)
    found = list(agreement.disorder_statistics(arrays, measured_time=40.0).values())
    for run in range(6):
        own = arrays["section_velocity"][run, :6]
        expected = [
            arrays["disorder_parameter"][run],
            arrays["mean_length"][run],
            arrays["slip_count"][run, arrays["n_blocks"][run] - 1] / 40,
            arrays["section_count"][run] / 40,
            np.nan if run == 1 else own.mean(),
            np.nan if run == 1 else own.std(),
        ]
        np.testing.assert_allclose([values[run] for values in found], expected)


def test_statistics_of_slips_by_hand():
    rng = RNG(18)
    slips = np.zeros(60, [("point", "i4"), ("block", "i4"), ("start_time", "f8"),
                          ("stop_time", "f8"), ("start_position", "f8"),
                          ("stop_position", "f8"), ("dissipated", "f8")])  # fmt: skip
    slips["point"], slips["block"] = rng.integers(0, 2, 60), rng.integers(1, 4, 60)
    for name in ("start_position", "stop_position", "dissipated"):
        slips[name] = rng.random(60)
    section = np.zeros(30, [("point", "i4"), ("velocities", "f8", 3)])
    section["point"], section["velocities"] = rng.integers(0, 2, 30), rng.random((30, 3))
    catalogue = {"slips": slips, "section": section}
    catalogue |= {"n_blocks": np.array([3, 2, 3]), "belt_velocity": np.array([1.0, 2, 3])}
    found = list(agreement.slip_statistics(catalogue).values())
    for run, n_blocks in ((0, 3), (1, 2)):
        own = slips[(slips["point"] == run) & (slips["block"] == n_blocks)]
        size = own["start_position"] - own["stop_position"]
        v = section["velocities"][section["point"] == run][:, n_blocks - 1]
        expected = [
            size.size,
            size.mean(),
            *np.percentile(size, [50, 90]),
            own["dissipated"].mean(),
        ]
        expected += [v.size, v.mean(), v.std()]
        np.testing.assert_allclose([values[run] for values in found], expected)
    assert [values[2] for values in found][::5] == [0, 0]
    assert np.isnan([values[2] for values in found][1:5]).all()


def test_each_side_of_a_comparison_brings_its_own_runs():
    """Sides of different sizes, orders and points: one cannot stand in for the other."""
    shared = [(5, 10.0, 1.0), (5, 30.0, 1.0), (7, 10.0, 5.0)]
    tested = scan_of([*shared, (5, 50.0, 1.0)], 19, 6)
    reference = scan_of([(9, 9.0, 9.0), *shared], 20, 9)
    mine, theirs = ({"q": side["disorder_parameter"]} for side in (tested, reference))
    rows = agreement.compare_points(tested, reference, mine, theirs)
    assert [(row["n_blocks"], row["belt_velocity"], row["noise"]) for row in rows] == shared
    for row, point in zip(rows, shared, strict=True):
        sides = [
            [
                side["disorder_parameter"][k]
                for k in range(side["noise"].size)
                if (side["n_blocks"][k], side["belt_velocity"][k], side["noise"][k]) == point
            ]
            for side in (tested, reference)
        ]
        expected = samples.compare_samples(*sides)
        assert row["quantity"] == "q" and (row["n_tested"], row["n_reference"]) == (6, 9)
        assert (row["mean_tested"], row["mean_reference"]) == (
            expected.mean_tested, expected.mean_reference
        )  # fmt: skip
        assert (row["z"], row["p"], row["test"]) == (expected.z, expected.p, expected.test)


def ends(seed, *, steps, runs):
    """Arrays of kind escapes at two belt velocities, in an order of their own."""
    rng = RNG(seed)
    rows = [(u, step) for u in (7.0, 25.0) for step in steps for _ in range(runs)]
    rng.shuffle(rows)
    u, step = (np.array(column) for column in zip(*rows, strict=True))
    escaped = rng.random(u.size) < 0.5
    return {
        "n_blocks": np.full(u.size, 5),
        "belt_velocity": u,
        "noise": np.zeros(u.size),
        "initial_spread": np.full(u.size, 1e-3),
        "time_step": step,
        "escaped": escaped,
        "lifetime": np.where(escaped, rng.uniform(0, 900, u.size), 1000.0),
        "final_disorder": rng.random(u.size) / 10,
        "final_stick_rate": rng.integers(0, 2, (u.size, 5)) / 10,
    }


def test_each_side_of_the_attractors_brings_its_own_runs():
    tested = ends(21, steps=(0.001, 0.002), runs=7)
    reference = ends(22, steps=(0.001, 0.004), runs=11)
    rows = agreement.compare_attractors(tested, reference, reference_step=0.001)
    assert len(rows) == 2 * 2 * 3
    for row in rows:
        ours, theirs = (
            (side["belt_velocity"] == row["belt_velocity"]) & (side["time_step"] == step)
            for side, step in ((tested, row["time_step"]), (reference, 0.001))
        )
        assert (row["n_tested"], row["n_reference"]) == (7, 11)
        if row["quantity"] == agreement.STILL_STICKING:
            sticks = [
                np.mean(~side["escaped"][at] | (side["final_stick_rate"][at, -1] > 0))
                for side, at in ((tested, ours), (reference, theirs))
            ]
            assert (row["mean_tested"], row["mean_reference"]) == pytest.approx(sticks)
        elif row["quantity"] == agreement.FINAL_DISORDER:
            means = (
                tested["final_disorder"][ours].mean(),
                reference["final_disorder"][theirs].mean(),
            )
            assert (row["mean_tested"], row["mean_reference"]) == pytest.approx(means)
        else:
            assert row["quantity"] == agreement.LIFETIME
            expected = samples.compare_lifetimes(
                tested["lifetime"][ours],
                reference["lifetime"][theirs],
                escaped_tested=tested["escaped"][ours],
                escaped_reference=reference["escaped"][theirs],
            )
            assert (row["mean_tested"], row["mean_reference"], row["p"]) == (
                expected.mean_tested, expected.mean_reference, expected.p
            )  # fmt: skip


def test_a_summary_of_a_family_by_hand():
    def row(p, distance, quantity="q", runs=9):
        one = samples.Comparison(8, runs, 2.0, 0.1, 1.0, 0.1, 5.0, p, "KS", p, distance)
        return {"part": "a", "quantity": quantity} | vars(one)

    rows = [row(0.01, 0.5), row(0.02, 0.001), row(0.9, 0.9, runs=7), row(np.nan, np.nan)]
    judged = agreement.judge([*rows, row(0.04, 0.02, quantity="other")])
    assert [each["corrected_p"] for each in judged[:3]] == pytest.approx([0.03, 0.04, 0.9])
    assert judged[4]["corrected_p"] == 0.04  # a family of its own
    assert [each["verdict"] for each in judged] == [
        samples.DIFFER, samples.CLOSE, samples.AGREE, samples.UNKNOWN, samples.DIFFER
    ]  # fmt: skip
    first, second = agreement.summarise(judged)
    assert (first["part"], first["quantity"], first["time_step"]) == ("a", "q", None)
    assert (first["points"], first["runs"], first["test"]) == (4, 7, "KS")
    assert [first[name] for name in samples.VERDICTS] == [1, 1, 1, 1]
    assert first["smallest_p"] == pytest.approx(0.03) and first["largest_distance"] == 0.9
    assert first["degrees"] == 3 and first["shift"] == pytest.approx(1.0)
    assert second["points"] == 1 and second["smallest_p"] == 0.04
