"""Formulas, errors and edges of the estimators, against formulas of other form and plain loops."""

from types import SimpleNamespace

import numpy as np
import pytest

import samples
from beltrepro import ChainValues, density
from beltrepro.base.errors import NotEnoughDataError
from beltrepro.replication.studies.avalanches import measure as avalanches
from beltrepro.stats import power_law, sections, spectra, states

RNG = np.random.default_rng

# --- avalanches -----------------------------------------------------------------------------------


def histogram(values, chain=0, bins_per_decade=1):
    values = np.asarray(values, dtype=float)
    chain = np.broadcast_to(chain, values.shape)
    return density(ChainValues(values, chain), bins_per_decade)


def test_a_histogram_by_hand():
    by_hand = histogram([1, 2, 20, 300, 1000, 0, -5])
    np.testing.assert_allclose(by_hand.centre, np.sqrt([10, 1000, 1e5]))
    assert by_hand.count.tolist() == [2, 1, 2]
    expected = np.array([2, 1, 2]) / (5 * np.array([9, 90, 900]))
    np.testing.assert_allclose(by_hand.density, expected, rtol=1e-9)
    # edges at whole multiples of a tenth of a decade, whatever the values
    fine = histogram([1.3, 1.9], bins_per_decade=10)
    np.testing.assert_allclose(fine.centre, 10 ** np.array([0.15, 0.25]))
    assert fine.count.tolist() == [1, 1]
    with pytest.raises(NotEnoughDataError, match="no positive value"):
        histogram([0.0, -1])


def test_a_power_law_is_tested_from_the_most_probable_value_to_the_largest():
    rng, chain = RNG(3), np.repeat([0, 1, 2, 3, 4], [90, 200, 150, 400, 60])
    values = 20 * (1 - rng.random(chain.size) * (1 - 12**-0.8)) ** (-1 / 0.8)
    values[rng.random(chain.size) < 0.1] /= 3
    fit = avalanches.scale_free_fit(ChainValues(values, chain))
    fine = histogram(values, bins_per_decade=10)
    tail = values[values >= fine.centre[np.argmax(fine.density)]]
    low, high = tail.min(), values.max()
    expected = power_law.fit_exponent(np.log(tail).mean(), low, high)
    exponent = fit.also["exponent"]
    assert exponent.value == pytest.approx(expected) and exponent.runs == 20  # stretches
    assert fit.also["decades"].value == pytest.approx(np.log10(high / low))


# --- spectra and densities ------------------------------------------------------------------------


def test_a_density_at_places_by_hand():
    counts = np.array([[1, 1, 0], [3, 0, 0], [1, 1, 4], [0, 0, 0]], np.uint32)
    edges = np.array([-3.0, -1.0, -0.5, 0.0])
    u, density = sections.density_at([2.0, 1.0, 2.0, 3.0], counts, edges)
    assert u.tolist() == [1, 2, 3] and np.isnan(density[:, 2]).all()
    np.testing.assert_allclose(density[:, :2], [[0.5, 0.125], [0, 0.5], [0, 1.0]])


# --- intermittency --------------------------------------------------------------------------------


def test_intermittent_points_at_the_edges_of_the_criterion():
    points = {
        "laminar_fraction": np.array([0.05, 0.049, 0.95, 0.951, 0.5, np.nan]),
        "laminar_count": np.array([2, 2, 2, 2, 1, 9]),
    }
    mask = states.intermittent_mask(points)
    assert mask.tolist() == [True, False, True, False, False, False]
    wide = states.intermittent_mask(points, (0.01, 0.99))
    assert wide.tolist() == [True] * 4 + [False] * 2


@pytest.mark.parametrize(
    ("slips", "sticks", "start", "velocity", "expected"),
    [
        ([0, 10], [5.0, 15.5], 0, 9.0, [[10, 15.5]]),  # longer than the limit only
        ([10], [8.0, 18.0], 1, 9.0, [[1, 8], [10, 18]]),  # begun before
        ([], [8.0], 1, 9.0, [[1, 8]]),
        ([3.0], [], 1, 9.0, [[3, 20]]),  # goes on
        ([], [], 0, 7.0, []),  # rides on the belt all the time
        ([], [], 1, 9.0, [[1, 20]]),  # slips all the time
    ],
)
def test_laminar_phases(slips, sticks, start, velocity, expected):
    rows = [(time, 2, "slip") for time in slips] + [(time, 2, "stick") for time in sticks]
    rows += [(time, 1, "stick") for time in range(20)]  # of another block
    kind = [("time", float), ("block", int), ("kind", "U5")]
    events = np.sort(np.array(rows, kind), order="time")
    about = {"n_blocks": 2, "belt_velocity": 7.0, "transient": start, "duration": 20}
    arrays = {"events": events, "velocities": np.full((9, 2), velocity)}
    phases = states.laminar_phases(SimpleNamespace(arrays=arrays, attributes=about), 5.0)
    assert phases.tolist() == expected and phases.shape[1:] == (2,)


def test_ends_of_shorter_chains_are_read_at_their_own_last_block():
    runs = {
        "final_stick_rate": [[0.0, 0.2, np.nan], [0.2, 0.0, np.nan], [0.2, 0.2, 0.0]],
        "final_disorder": np.array([0.1, 0.1, 0.01]),
        "escaped": np.ones(3),
    }
    ends = [states.STICK_SLIP, states.LARGE_SLIP, states.SMALL_SLIP]
    assert states.label_ends(runs).tolist() == ends


def test_each_point_is_judged_by_its_own_numbers():
    cycle = np.tile([1.0, 2.0], 30)
    points = {
        "belt_velocity": np.ones(3),
        "last_stick_time": np.array([50.0, 290.0, 290.0]),
        "laminar_fraction": np.array([0.5, 0.0, 0.0]),
        "laminar_count": np.zeros(3),
        "section_velocity": np.stack([cycle, np.where(np.arange(60) < 11, cycle, np.nan), cycle]),
    }
    for order in ([0, 1, 2], [2, 0, 1]):
        rows = {name: values[order] for name, values in points.items()}
        labels = np.array([states.CONTINUOUS, states.UNDECIDED, states.PERIODIC])[order]
        assert states.label_states(rows, transient=100.0, duration=300.0).tolist() == [*labels]


# --- sections -------------------------------------------------------------------------------------


def test_the_period_search_at_its_edges():
    cycle = np.arange(41.0)
    assert sections.find_period(np.tile(cycle[:40], 3)) == 40
    assert sections.find_period(np.tile(cycle, 3)) == 0  # longer than allowed
    assert sections.find_period(np.tile(cycle[:6], 3)) == 6
    assert sections.find_period(np.tile(cycle[:6], 3)[:-1]) == 0  # not three times over
    assert sections.find_period(np.tile(cycle[:4], 3)) == 4
    assert sections.find_period(np.arange(12.0)) == sections.find_period(-np.arange(12.0)) == 0
    with pytest.raises(NotEnoughDataError, match="11 crossings"):
        sections.find_period(np.tile(cycle[:4], 3)[:11])


@pytest.mark.parametrize(
    ("size", "off", "period"), [(1.0, 0.049, 2), (1.0, 0.051, 4), (100.0, 0.99, 2), (100.0, 1.1, 4)]
)
def test_a_period_is_seen_within_a_tenth_or_a_fiftieth_of_the_range(size, off, period):
    values = np.tile([0.0, size], 20) + np.tile([off, off, -off, -off], 10)
    assert sections.find_period(np.append(values, [np.nan] * 9)) == period


def test_the_occupied_bins_by_hand():
    counts = [[9, 5, 4, 2], [10, 5, 2, 3], [1, 9, 1, 9], [11, 0, 0, 0]]  # of 20, 90 % are 18
    assert sections.occupied_bins(counts)[:3].tolist() == [3, 3, 2]
    assert np.isnan(sections.occupied_bins(counts)[3])  # too few crossings


def test_rows_tell_noise_levels_and_order_replicates():
    table = {
        "n_blocks": np.array([5, 5, 5, 4, 5, 5]),
        "belt_velocity": np.array([2.0, 1.0, 2.0, 1.0, 1.0, 1.0]),
        "noise": np.array([0.3, 0.3, 0.1 + 0.2, 0.3, 0.31, 0.3]),
        "replicate": np.array([1, 1, 0, 0, 0, 0]),
    }
    row = sections.cut(table, n_blocks=5, noise=0.3)
    assert row["belt_velocity"].tolist() == [1, 1, 2, 2]
    assert row["replicate"].tolist() == [0, 1, 0, 1]
    column = sections.cut(table, n_blocks=5, belt_velocity=1.0)
    assert column["noise"].tolist() == [0.3, 0.3, 0.31]
    assert column["replicate"].tolist() == [0, 1, 0]
    del table["replicate"]
    assert sections.cut(table, n_blocks=5, noise=0.3)["belt_velocity"].tolist() == [1, 1, 2, 2]


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
    for last_stick, label in (
        *((np.nan, states.CONTINUOUS), (100.0, states.CONTINUOUS)),
        *((100.1, states.TRANSIENT), (199.9, states.TRANSIENT)),
    ):
        assert one_state(last_stick=last_stick, share=0.01, velocities=cycle) == label
        # it has not stuck again, and has not slipped for long either: it rides on the belt
        assert one_state(last_stick=last_stick, velocities=cycle) == states.UNDECIDED
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


ROTATION = np.cos(2 * np.pi * 0.618034 * np.arange(400))


def logistic(rate, size):
    return samples.orbit(samples.logistic(rate), 0.3, size, skip=2000)[:, 0]


def test_the_0_1_test_tells_chaos_from_regular_motion():
    assert sections.zero_one_test(logistic(4.0, 400)) > 0.9
    assert sections.zero_one_test(logistic(3.97, 400)) > 0.8
    assert abs(sections.zero_one_test(logistic(3.5, 400))) < 0.2
    assert sections.zero_one_test(ROTATION) < 0.2


def test_the_correlation_dimension_of_the_henon_attractor_a_curve_and_a_surface():
    orbit = samples.orbit(samples.henon(1.4), [0.1, 0.1], 5000, skip=100)
    slope, error = sections.correlation_dimension(orbit)
    assert slope == pytest.approx(1.2, abs=0.04) and error < 0.1
    for true in (1, 2):
        flat = RNG(0).random((4000, true)) @ RNG(1).normal(size=(true, 6))
        assert sections.correlation_dimension(flat)[0] == pytest.approx(true, abs=0.1)
    with pytest.raises(NotEnoughDataError, match="500 are needed"):
        sections.correlation_dimension(np.zeros((10, 2)))
    with pytest.raises(NotEnoughDataError, match="few places"):
        sections.correlation_dimension(np.tile([[0.0, 0.0], [1.0, 2.0]], (400, 1)))


def coloured_noise(slope, size, seed=1):
    """Series whose power spectral density falls as frequency**slope."""
    rng = np.random.default_rng(seed)
    frequency = np.fft.rfftfreq(size)
    amplitude = np.zeros_like(frequency)
    amplitude[1:] = frequency[1:] ** (slope / 2)
    phase = np.exp(2j * np.pi * rng.random(frequency.size))
    return np.fft.irfft(amplitude * phase, size)


def exponent(values, low=0.01):
    """Exponent of a series of one sample a unit of time, with its interval."""
    law = spectra.fit_power_law(*spectra.power_spectrum(values, 1.0), low=low, high=0.3)
    return spectra.exponent_of(law, values, 1.0)


def switching(seed, size=4000):
    """A series that changes between two kinds of noise some ten times."""
    rng = RNG(seed)
    kind = np.searchsorted(np.cumsum(rng.exponential(size / 10, 60)), np.arange(size)) % 2
    slopes = rng.permutation([-1.0, -2.5])
    first, second = (coloured_noise(slope, size, (seed, round(-slope))) for slope in slopes)
    return np.where(kind, first / first.std(), second / second.std())


def test_the_exponent_of_motion_of_two_kinds_is_known_as_badly_as_one_run_tells_it():
    numbers = [exponent(switching(seed)) for seed in range(20)]
    mean = np.mean([number.value for number in numbers])
    assert sum(number.low <= mean <= number.high for number in numbers) >= 17
    steady = [exponent(coloured_noise(-1.0, 4000, seed)) for seed in range(5)]
    assert all(number.high - number.low < 0.5 for number in steady)


def test_the_exponent_of_a_spectrum_of_lines_says_little():
    """What lies between the lines decides it: noise of a millionth of their power or of less."""
    lines = sum(np.cos(2 * np.pi * k * 0.023 * np.arange(4000) + k * k) / k for k in range(1, 10))
    values = [exponent(lines + level * RNG(1).normal(size=4000)) for level in (1e-3, 1e-5)]
    for one, other in (values, values[::-1]):
        assert one.low < other.value < one.high and one.high - one.low > 1


def test_a_stretch_at_rest_leaves_the_error_of_an_exponent_open():
    resting = np.where(np.arange(4000) < 1000, 0.0, coloured_noise(-1.0, 4000))
    assert "error not known" in exponent(resting).words


def test_what_rests_has_no_spectrum_of_its_rounding():
    for values in (np.full(4000, 0.9), 0.9 + 1e-16 * RNG(0).normal(size=4000)):
        assert not spectra.power_spectrum(values, 1.0)[1].any()
        with pytest.raises(NotEnoughDataError, match=r"0 points between 0\.01 and 0\.3"):
            exponent(values)
