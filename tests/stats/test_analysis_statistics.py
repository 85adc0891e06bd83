"""Spectra, densities of avalanches, lifetimes: estimators against data with a known answer."""

import numpy as np
import pytest

from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.stats import spectra
from beltrepro.stats.errors import NotEnoughDataError
from beltrepro.stats.fits import fit_log_log

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


# --- fits and spectra -----------------------------------------------------------------------------


def test_a_power_law_is_recovered_exactly():
    abscissa = np.geomspace(0.1, 10, 20)
    fit = fit_log_log(abscissa, 3.0 * abscissa**-1.21, low=0.1, high=10)
    assert fit.exponent == pytest.approx(-1.21)
    assert fit.prefactor == pytest.approx(3.0)
    assert fit(2.0) == pytest.approx(3.0 * 2**-1.21)


@pytest.mark.parametrize("slope", [0.0, -1.2, -2.0])
def test_the_slope_of_a_spectrum_is_recovered(slope):
    frequency, power = spectra.power_spectrum(coloured_noise(slope, 2**15), 0.1)
    fit = spectra.fit_power_law(frequency, power, low=0.01, high=3)
    assert fit.exponent == pytest.approx(slope, abs=0.05)
    amplitude = spectra.amplitude_spectrum(frequency, power)
    halved = spectra.fit_power_law(frequency, amplitude, low=0.01, high=3)
    assert halved.exponent == pytest.approx(slope / 2, abs=0.05)


def test_a_power_spectrum_is_normalised_to_the_variance():
    values = np.random.default_rng(0).normal(5.0, 2.0, 20_000)
    frequency, power = spectra.power_spectrum(values, 0.5, segment=256)
    assert np.sum(power) * (frequency[1] - frequency[0]) == pytest.approx(4.0, rel=0.05)


def test_a_sine_has_its_line_at_its_frequency():
    time = np.arange(0, 500, 0.1)
    frequency, power = spectra.power_spectrum(np.sin(2 * np.pi * 0.25 * time), 0.1)
    assert frequency[np.argmax(power)] == pytest.approx(0.25, abs=0.005)


def test_too_few_samples_are_refused_in_one_line():
    with pytest.raises(NotEnoughDataError, match="a spectrum needs 16"):
        spectra.power_spectrum(np.ones(5), 0.1)
    with pytest.raises(NotEnoughDataError, match="4 are needed"):
        spectra.fit_power_law(np.arange(1.0, 4), np.ones(3), low=1, high=10)


# --- avalanches -----------------------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [-0.87, -1.47, -2.5])
def test_power_law_exponents_are_recovered_over_less_than_a_decade(exponent):
    values = bounded_power_law(exponent, 60, 400, 20_000)
    histogram = avalanches.log_histogram(values, bins_per_decade=20, low=60, high=400)
    line = avalanches.fit_density(*histogram, low=65, high=350)
    assert line.exponent == pytest.approx(exponent, abs=0.1)


def test_log_histogram_is_a_density_and_keeps_the_extremes():
    values = bounded_power_law(-1.5, 1, 1000, 5000)
    centre, density, count = avalanches.log_histogram(values, bins_per_decade=10)
    width = centre * (10**0.05 - 10**-0.05)
    assert count.sum() == values.size
    assert np.sum(density * width) == pytest.approx(1, rel=1e-6)
    assert avalanches.log_histogram([100.0, -3.0], bins_per_decade=10)[2].sum() == 1


def test_the_falling_range_starts_at_the_top_and_ends_before_sparse_bins():
    centre = np.arange(1.0, 8)
    density, count = np.array([1, 5, 4, 3, 2, 1, 1.0]), np.array([20, 90, 70, 50, 3, 40, 2])
    assert avalanches.falling_range(centre, density, count) == (2.0, 4.0)


def test_slip_sizes_in_both_frames():
    slips = np.array(
        [(0, 5, 1.0, 3.0, 600.0, 500.0, 9.0), (0, 4, 1.0, 2.0, 0.0, 1.0, 1.0)], dtype=SLIP
    )
    sizes = avalanches.last_block_slip_sizes(slips, 5, 2.0)
    assert sizes.tolist() == [100.0]
    assert avalanches.last_block_slip_sizes(slips, 5, 2.0, frame="belt").tolist() == [104.0]
    with pytest.raises(ValueError, match="laboratory, belt"):
        avalanches.last_block_slip_sizes(slips, 5, 2.0, frame="moon")


def test_energies_of_avalanches_that_reach_the_last_block():
    slips = np.array(
        [
            (0, 1, 0.0, 2.0, 0, 0, 10.0),
            (0, 2, 1.0, 4.0, 0, 0, 30.0),
            (0, 5, 1.0, 2.0, 0, 0, 7.0),
            (0, 1, 10.0, 11.0, 0, 0, 5.0),
            (1, 5, 10.0, 11.0, 0, 0, 6.0),
        ],
        dtype=SLIP,
    )
    # While block 5 slips (1 to 2): half of the first slip, a third of the second, its own.
    energies = avalanches.dissipation_while_last_block_slips(slips, 5)
    assert energies.tolist() == [5.0 + 10.0 + 7.0, 6.0]
    catalogue = np.array(
        [(0, 0.0, 4.0), (0, 10.0, 11.0), (1, 10.0, 11.0)],
        dtype=[("point", "i4"), ("start_time", "f8"), ("stop_time", "f8")],
    )
    assert avalanches.with_last_block(catalogue, slips, 5).tolist() == [True, False, True]


# --- lifetimes ------------------------------------------------------------------------------------


def test_errors_of_a_density_come_from_the_scatter_of_runs():
    """Values of one run hang together: the error is that of the number of runs, not of values."""
    rng = np.random.default_rng(11)
    n_runs, each = 40, 50
    found = []
    for _ in range(200):
        place = np.repeat(rng.random(n_runs) < 0.3, each)
        values = np.where(place, 2.0, 30.0)
        run = np.repeat(np.arange(n_runs), each)
        centre, density, _ = avalanches.log_histogram(values, bins_per_decade=1, low=1, high=100)
        error = avalanches.density_error(values, run, centre, bins_per_decade=1)
        found.append((density[0], error[0]))
    densities, errors = np.array(found).T
    assert errors.mean() == pytest.approx(densities.std(), rel=0.1)


def test_error_of_a_density_by_hand():
    values, run = [2.0, 3.0, 20.0, 4.0, 50.0, 60.0, -1.0], [0, 0, 0, 1, 1, 1, 1]
    centre, *_ = avalanches.log_histogram(values, bins_per_decade=1)
    error = avalanches.density_error(values, run, centre, bins_per_decade=1)
    # without one of two runs the shares in the first bin, 1 to 10, are 1/3 and 2/3
    np.testing.assert_allclose(error, [1 / 6 / 9, 1 / 6 / 90])
    assert np.isnan(avalanches.density_error([2.0, 3.0], [4, 4], centre, bins_per_decade=1)).all()
