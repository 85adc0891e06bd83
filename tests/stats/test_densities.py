"""Densities, power laws and spectra of series with closed forms: values, intervals, few data."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
import scipy

from beltrepro import ChainValues, PowerLaw, density, power_law, spectrum
from beltrepro.base.errors import InputError, NotEnoughDataError
from made_up import few_resamples  # noqa: F401 shorter
from samples import power_law as law_of

RNG = np.random.default_rng


def share_that_holds(truth, intervals):
    return np.mean([one.low <= truth <= one.high for one in intervals])


# --- spectra --------------------------------------------------------------------------------------


def test_white_noise_has_a_flat_spectrum_of_its_variance():
    """One-sided: 2 s^2 d for a standard deviation s and an interval d."""
    found = spectrum(3 + 2 * RNG(1).standard_normal((8, 20_000)), sample_interval=0.25)
    assert found.frequency[[0, -1]] == pytest.approx([1 / 5000, 2.0])
    assert found.power.mean() == pytest.approx(2 * 4 * 0.25, rel=0.01)
    assert np.sum(found.power) * found.frequency[0] == pytest.approx(4, rel=0.01)
    law = found.law(0.01, 1)
    assert law.exponent.low < 0 < law.exponent.high < 0.05 and law.exponent.runs == 8
    assert law.prefactor.low < 2 < law.prefactor.high
    assert law(0.1) == pytest.approx(2, rel=0.05) and (law.low, law.high) == (0.01, 1)
    assert repr(found) == "PowerSpectrum(8 series of 20000 samples, frequency 0.0002 to 2)"


def test_the_spectrum_of_an_autoregressive_series_is_its_closed_form():
    memory, interval = 0.9, 0.5
    noise = RNG(2).standard_normal((40, 4200))
    values = scipy.signal.lfilter([1], [1, -memory], noise)[:, 200:]
    found = spectrum(values, sample_interval=interval)
    wave = memory * np.exp(-2j * np.pi * found.frequency * interval)
    ratio = found.power / (2 * interval / np.abs(1 - wave) ** 2)
    assert ratio.reshape(-1, 100).mean(axis=1) == pytest.approx(1, abs=0.06)
    # between 1 / memory and the end it falls as the square: the closed form on the same bins
    assert found.exponent(0.1, 0.4).value == pytest.approx(-1.77, abs=0.08)


@pytest.mark.parametrize(
    ("series", "size", "runs"), [(1, 6500, 6), (1, 20_500, 20), (3, 2100, 6), (7, 1100, 7)]
)
def test_the_interval_of_an_exponent_is_that_of_few_stretches_or_series(series, size, runs):
    """Of noise with a known slope; 6 stretches are as few as make an interval."""
    made = []
    for seed in range(30):
        noise = RNG(seed).standard_normal((series, 2 * size))
        spectra = np.fft.rfft(noise)
        spectra[:, 1:] *= np.arange(1, size + 1) ** -0.7
        values = np.fft.irfft(spectra)[:, :size]
        made.append(spectrum(values, sample_interval=1.0).exponent(0.01, 0.3))
    assert share_that_holds(-1.4, made) >= 0.8
    assert np.mean([one.value for one in made]) == pytest.approx(-1.4, abs=0.05)
    assert {one.runs for one in made} == {runs}


@pytest.mark.parametrize("chain", [np.ma.array([1, 1, 2], mask=[0, 1, 0]), [1.0, np.nan, 2.0]])
def test_labels_that_are_missing_are_no_chain(chain):
    with pytest.raises(InputError, match="chain: some values have no chain"):
        ChainValues([1.0, 2.0, 3.0], chain)


def test_bins_narrower_than_the_step_of_the_values_are_told():
    values = np.random.default_rng(0).zipf(2.0, 4000).astype(float)
    with pytest.warns(
        UserWarning, match="values in steps of 1: bins below 2.2 hold one of them or"
    ):
        density(values)
    with warnings.catch_warnings(action="error"):
        density(values * np.random.default_rng(1).random(4000))


@pytest.mark.parametrize("beside", [0.0, 1e-12, -1e-12, 1e-10, -1e-10, 1e-8, -1e-8])
def test_values_near_the_edge_of_a_bin_are_all_counted(beside):
    for values in ([1.0, 2.0, 10.0], [1.0, 1.0, 1.0]):
        made = density(np.repeat(np.array(values) * (1 + beside), 20))
        assert made.count.sum() == 60 and len(made.count) <= 6


def test_a_spectrum_of_too_little_says_what_is_needed():
    short = spectrum(RNG(0).standard_normal((2, 2900)), sample_interval=1.0)
    needed = "lasts 2900: from a frequency of 0.01 on 3 stretches of 1000 are needed, 3000 in all"
    with pytest.raises(NotEnoughDataError, match=needed):
        short.exponent(0.01, 0.3)
    with pytest.raises(NotEnoughDataError, match="15 samples, a spectrum needs 16"):
        spectrum(np.arange(15.0), sample_interval=1.0)
    assert short.law(0.05, 7).high == 0.5  # half of the rate of the samples
    with pytest.raises(InputError, match=r"low = 30: must be below 0.5, the last of the freq"):
        short.law(30, 60)
    with pytest.raises(InputError, match=r"high = 0\.1: must be greater than low = 0\.3"):
        short.law(0.3, 0.1)
    with pytest.raises(NotEnoughDataError, match="0 points between"):
        spectrum(np.full(7000, 0.9), sample_interval=1.0).law(0.01, 0.3)


@pytest.mark.parametrize("low", [0.003, 0.007, 0.0321, 9.0])
def test_the_length_that_a_law_asks_for_is_enough(low):
    interval, values = 0.1 / low, RNG(0).standard_normal(700)
    with pytest.raises(NotEnoughDataError) as caught:
        spectrum(values[:500], sample_interval=interval).law(low, 5 * low)
    needed = float(str(caught.value).removesuffix(" in all").rpartition(" ")[2])
    size = int(np.ceil(needed / interval))
    spectrum(values[:size], sample_interval=interval).law(low, 5 * low)
    with pytest.raises(NotEnoughDataError):
        spectrum(values[: int(0.99 * size)], sample_interval=interval).law(low, 5 * low)


def test_stretches_that_differ_by_more_than_chance_are_told():
    """Of motion that changes between a weak and a strong kind; of one kind, however red, not."""
    red = scipy.signal.lfilter([1], [1, -0.98], RNG(0).standard_normal((24, 20_000)), axis=1)
    changing = red[:6] * (1 + 4 * (np.arange(20_000) // 2500 % 2))
    with warnings.catch_warnings(action="error"):
        for series in red:
            spectrum(series, sample_interval=1.0).law(0.01, 0.3)
        spectrum(changing, sample_interval=1.0).law(0.01, 0.3)
    for series in changing:
        with pytest.warns(UserWarning, match="as of motion that changes: .* of 6 or more runs"):
            spectrum(series, sample_interval=1.0).law(0.01, 0.3)


def waves(first, count, last):
    """A wave of 20,000 samples with some harmonics, of which the last has a given amplitude."""
    phases = np.arange(20_000)[:, None] * 2 * np.pi * first * np.arange(1, count + 1)
    return np.cos(phases) @ np.geomspace(1, last, count)


NOISE = RNG(0).standard_normal(20_000)


@pytest.mark.parametrize(
    ("values", "low"),
    [
        (waves(0.02137, 19, 1e-3), 0.003),
        (waves(0.0051, 60, 1e-3), 0.02),  # in stretches of 500 samples no line is by itself
        (waves(0.00051, 580, 1e-3), 0.02),  # a third of the range is in lines
        (waves(0.02137, 1, 1), 0.003),
        (waves(0.02137, 3, 0.1), 0.003),  # in most of the range there is none
        (waves(0.02137, 3, 0.1) + 0.05 * NOISE, 0.003),
    ],
)
def test_a_spectrum_of_lines_is_warned_of(values, low):
    with pytest.warns(UserWarning, match="one of lines or narrow peaks") as heard:
        spectrum(values, sample_interval=1.0).exponent(low, 0.3)
    assert len(heard) == 1 and heard[0].filename == __file__


# nearly all of whose power over a straight line is in few frequencies, but in half a decade
STEEP = scipy.signal.sosfilt(scipy.signal.butter(7, 0.04, output="sos"), NOISE)


@pytest.mark.parametrize(
    "values", [np.cumsum(NOISE), NOISE, waves(0.02137, 1, 1) + 2 * NOISE, STEEP]
)
def test_a_spectrum_of_a_noise_is_not_taken_for_lines(values):
    with warnings.catch_warnings(action="ignore"):  # stretches of so steep a one may differ
        warnings.filterwarnings("error", "the spectrum is one of lines")
        spectrum(values, sample_interval=1.0).exponent(0.003, 0.3)


# --- densities ------------------------------------------------------------------------------------


def test_a_law_through_the_bins_of_exact_values_lies_on_them():
    values = law_of(-1.5, 10, 1000, 40_000, 1)
    found = density(values, 10)
    law = found.law()
    assert law.exponent.low < -1.5 < law.exponent.high and np.isnan(law.p)
    np.testing.assert_allclose(law(found.centre), found.density, rtol=0.15)
    assert np.sum(found.density * found.width) == pytest.approx(1)
    assert repr(found).startswith("Density(40000 values of 16 chains, 11.2202 to 891.251")
    assert repr(law).startswith(f"PowerLaw(exponent={law.exponent.value:.6g} (")
    assert repr(replace(law, p=0.09)).endswith("p=0.09 (refused))")
    assert repr(replace(law, p=0.11)).endswith("p=0.11)")


def test_bins_of_few_values_tilt_the_line_by_what_is_told():
    lines = []
    for seed in range(30):
        with pytest.warns(UserWarning, match="bins of few values tilt the line") as heard:
            law = density(law_of(-1.5, 1, 1000, 300, seed), 20).law()
        (tilt,) = re.findall(r"by about (\S+):", str(heard[0].message))
        lines.append((law.exponent.value, float(tilt)))
    value, tilt = np.mean(lines, axis=0)
    assert value == pytest.approx(-1.5 + tilt, abs=0.03) and tilt > 0.05
    with warnings.catch_warnings(action="error"):
        density(law_of(-1.5, 1, 1000, 1000, 1), 5).law()


def test_the_interval_of_series_of_two_kinds_holds_their_scatter():
    """Each of eight series is averaged over its own stretches: slopes of -1 and of -2."""
    noise = np.fft.rfft(RNG(1).standard_normal((8, 20_000)))
    slopes = np.repeat([-0.5, -1.0], 4)[:, np.newaxis]
    noise[:, 1:] *= (np.arange(1.0, noise.shape[1]) / 1000) ** slopes
    runs = np.fft.irfft(noise)
    both = spectrum(runs, sample_interval=1.0).exponent(0.01, 0.3)
    of_each = [spectrum(run, sample_interval=1.0).exponent(0.01, 0.3).value for run in runs]
    assert both.high - both.low > 0.3 * np.ptp(of_each) > 0.25


def test_errors_of_one_series_are_those_of_its_stretches():
    """A series that is small or large for a 40th of its length: neighbours say the same."""
    densities, errors = [], []
    for seed in range(200):
        large = np.repeat(RNG(seed).random(40) < 0.4, 25)
        made = density(np.where(large, 30.0, 2.0), 1)
        densities.append(made.density[0])
        errors.append(made.error[0])
    assert np.mean(errors) == pytest.approx(np.std(densities), rel=0.25)
    np.testing.assert_array_equal(np.isnan(made.error), made.count == 0)


def test_values_of_chains_pass_for_their_array():
    sizes = ChainValues([3.0, 1, 2], [0, 0, 7])
    assert len(sizes) == 3 and np.median(sizes) == 2 and np.asarray(sizes).tolist() == [3, 1, 2]
    assert repr(sizes) == "ChainValues(3 of 2 chains, 1 to 3)"
    assert density(ChainValues([3.0, 1, 2, 2, 2, 2, 2], [0, 0, 1, 2, 3, 4, 5])).counts.sum(
        axis=1
    ).tolist() == [2, 1, 1, 1, 1, 1]
    with pytest.raises(InputError, match=r"chain of shape \(2,\): the shape \(3,\)"):
        ChainValues([3.0, 1, 2], [0, 0])


@pytest.mark.parametrize(("chains", "runs"), [(2, 16), (3, 18), (4, 16), (6, 6)])
def test_intervals_of_few_chains_are_those_of_their_stretches(chains, runs):
    """Of 100 samples whose chains stand in no order; resamples of two chains would hold 45."""
    laws = []
    for seed in range(100):
        values = law_of(-1.5, 10, 1000, 240 * chains, seed + 1000 * chains)
        made = density(ChainValues(values, np.arange(values.size) % chains))
        laws.append(made.law().exponent)
        assert made.counts.sum() == values.size and laws[-1].runs == runs
    assert share_that_holds(-1.5, laws) >= 0.85


def test_stretches_of_few_chains_follow_their_time():
    """Each of two chains has small values first: none of 16 stretches holds both sizes."""
    values, chain = np.repeat([2.0, 30.0], 40), np.tile([5, 3], 40)
    assert (np.count_nonzero(density(ChainValues(values, chain), 1).counts, axis=1) == 1).all()


# --- power laws -----------------------------------------------------------------------------------


def test_the_law_of_exact_values_is_found_with_its_range_and_is_not_refused():
    law = power_law(law_of(-1.47, 60, 400, 3000, 2), low=60)
    assert isinstance(law, PowerLaw) and law.low == 60 and 399 < law.high < 400
    assert law.exponent.low < -1.47 < law.exponent.high and law.p > 0.1
    x = np.geomspace(law.low, law.high, 10_001)
    assert np.trapezoid(law(x), x) == pytest.approx(1, rel=1e-6)
    assert law.prefactor.low < 0.47 * (60**-0.47 - 400**-0.47) ** -1 < law.prefactor.high


@pytest.mark.parametrize("count", [60, 200])
def test_intervals_of_few_values_hold_the_exponent_and_p_is_spread(count, monkeypatch):
    """Where values are as good as too few the line says so, and there is no number."""
    laws, refused = [], 0
    for seed in range(60):
        try:
            laws.append(power_law(law_of(-1.47, 60, 400, count, seed), low=60))
        except NotEnoughDataError as error:
            assert "50 are needed" in str(error)
            refused += 1
    assert refused < 45 * (count < 100) + 1
    assert share_that_holds(-1.47, [law.exponent for law in laws]) >= 0.85
    p = np.array([law.p for law in laws])
    assert np.mean(p < 0.1) < 0.2 and p.std() > 0.15


def test_what_is_no_power_law_is_refused_and_the_best_start_is_looked_for():
    exponential = 60 + RNG(3).exponential(60, 2000)
    assert power_law(exponential, low=60).p < 0.01
    bent = np.r_[RNG(4).uniform(20, 100, 3000), law_of(-1.8, 100, 2000, 3000, 5)]
    bent = RNG(6).permutation(bent)
    law = power_law(bent, low="best")
    assert 80 < law.low < 300 and law.exponent.value == pytest.approx(-1.8, abs=0.2)
    few = power_law(bent[:300], low="best")
    assert np.count_nonzero(bent[:300] >= few.low) >= 50
    share = np.mean(bent >= law.low)
    x = np.geomspace(law.low, law.high, 10_001)
    assert np.trapezoid(law(x), x) == pytest.approx(share, rel=1e-6)
    for low, said in (
        (5e4, r"no value of 5e"),
        (1990.0, r"values above 1\.99e\+03, 50 are needed"),
    ):
        with pytest.raises(NotEnoughDataError, match=said):
            power_law(bent, low=low)


def test_values_without_a_range_a_label_or_a_unit_of_their_size_are_told():
    with pytest.raises(NotEnoughDataError, match="values from 2 to 2 span no range"):
        power_law([2.0] * 100)
    with pytest.raises(InputError, match=r"chain = \[None, None\]: numbers or texts are needed"):
        density(ChainValues([1.0, 2.0], [None] * 2))
    assert len(ChainValues([1.0, 2.0], np.array(["a", "b"], dtype=object))) == 2
    for size in (1e-300, 1e200):
        with pytest.raises(InputError, match="as the prefactor: take another unit"):
            power_law(law_of(-2.5, 1, 100, 400, 1) * size, low=size)
        with pytest.raises(InputError, match="no bins hold them; take another unit"):
            density(law_of(-2.5, 1, 100, 400, 1) * size)
    laws = [density(law_of(-2.5, 1, 100, 400, 1) * size).law() for size in (1e-149, 1.0, 1e147)]
    assert np.ptp([law.exponent.value for law in laws]) < 1e-6


def test_runs_that_differ_as_a_whole_widen_the_interval():
    exponents = RNG(7).uniform(-2.2, -0.7, 16)
    values = np.concatenate([law_of(e, 60, 400, 200, k) for k, e in enumerate(exponents)])
    chain = np.repeat(np.arange(16), 200)
    unlike = power_law(ChainValues(values, chain), low=60).exponent
    alike = power_law(ChainValues(RNG(8).permutation(values), chain), low=60).exponent
    assert unlike.high - unlike.low > 2 * (alike.high - alike.low) and unlike.runs == 16
