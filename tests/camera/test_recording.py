"""Recordings of the last block: r, quiet stretches and spectra of series with known answers."""

import warnings

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter

import recorded
from beltrepro.base.errors import InputError, NotEnoughDataError
from beltrepro.replication.camera.recording import FIT_TO_HZ, analyse, regimes
from beltrepro.replication.camera.scene import lengths_of_blocks
from beltrepro.replication.studies.experiment.figures import draw_recording
from beltrepro.replication.studies.experiment.measure import (
    tracking_error,
)
from beltrepro.stats.spectra import comb
from beltrepro.stats.states import slips_of_all

RATE = recorded.RATE
FULL = recorded.recordings()


def instants(seconds):
    return np.arange(round(seconds * RATE)) / RATE


def bursts(seconds=200.0, quiet=((40.0, 100.0), (150.0, 158.0))):
    """Swings of 15 cm about 90 cm, of 5 mm in the quiet stretches."""
    time = instants(seconds)
    calm = np.any([(time >= begin) & (time < end) for begin, end in quiet], axis=0)
    return time, 0.9 + np.where(calm, 0.005, 0.15) * np.sin(2 * np.pi * 0.5 * time)


def test_means_are_over_time_and_not_over_frames():
    # Twenty frames a second for the first half at 0.8 m, forty for the other at 1 m; then a gap.
    time = np.concatenate([np.arange(0, 50, 0.05), np.arange(50, 100, 0.025), [200.0]])
    position = np.where(time < 50, 0.8, 1.0)
    with pytest.warns(UserWarning, match="gaps are 100 s of 200 s"):
        recording = analyse(time, position)
    assert recording.mean_length == pytest.approx(0.9, rel=2e-3)
    assert recording.disorder_parameter == pytest.approx(0.1 / 0.9, rel=5e-3)
    assert recording.observed_s == pytest.approx(100, rel=2e-3)  # the gap counts for nothing


def test_quiet_stretches_are_found_and_only_long_ones_last():
    whole = analyse(*bursts())
    # A window of 5 s that holds a second of the burst can still be quiet; the quiet stretch of 8 s
    # is too short to last and belongs to what lies around it.
    np.testing.assert_allclose(whole.small_s, [[40, 100], [150, 158]], atol=1.3)
    np.testing.assert_allclose(whole.lasting_s, [[40, 100]], atol=1.3)
    np.testing.assert_allclose(whole.lively_s, [[0, 40], [100, 200]], atol=1.3)
    assert whole.small_share == pytest.approx(68 / 200, abs=0.03)
    assert whole.lasting_share == pytest.approx(60 / 200, abs=0.015)
    for lasting_s, share in ((5.0, whole.small_share), (48.0, whole.lasting_share), (72.0, 0.0)):
        assert regimes(*bursts(), lasting_s=lasting_s).lasting_share == share
    assert analyse(*bursts(), quiet=0.2).small_share == 1.0
    assert analyse(*bursts(), quiet=0.001).small_share == 0.0


def test_what_is_shorter_than_a_window_has_no_amplitude():
    time = instants(300.0)
    calm = 0.85 + 0.002 * np.sin(2 * np.pi * 0.7 * time)
    for later, share in ((150.0, 1.0), (0.0, np.nan)):  # six frames are lost every 4 s
        seen = (np.arange(time.size) % 96 >= 6) | (time < later)
        with pytest.warns(UserWarning, match="s are in pieces too short to tell their amplitude"):
            recording = analyse(time[seen], calm[seen])
        assert recording.small_share == pytest.approx(share, nan_ok=True)
        assert "large" not in recording.spectra


def test_a_picture_of_three_spectra_has_room_for_all():
    time, position = bursts()
    coloured = lfilter([1], [1, -0.9], np.random.default_rng(1).standard_normal(time.size))
    figure = draw_recording(analyse(time, position + 0.002 * coloured))
    with warnings.catch_warnings(action="error"):
        figure.draw_without_rendering()
    boxes = [axes.get_tightbbox() for axes in figure.axes]
    assert len(boxes) == 4
    for number, box in enumerate(boxes):
        assert figure.bbox.containsx(box.x0) and figure.bbox.containsx(box.x1)
        assert not any(box.overlaps(other) for other in boxes[:number])


def test_few_changes_of_amplitude_are_told():
    quiet = [(begin, begin + 20.0) for begin in range(20, 600, 40)]
    with pytest.warns(UserWarning, match="the amplitude changes for long 9 times: intervals hold"):
        analyse(*bursts(200.0, quiet[:5]))
    with warnings.catch_warnings(action="error"):
        analyse(*bursts(600.0, quiet))
    time, calm = bursts(200.0, [(0.0, 200.0)])  # parted by gaps, and yet of one amplitude
    with pytest.warns(UserWarning) as caught:
        analyse(time[time % 50 > 1], calm[time % 50 > 1])
    assert not any("changes" in str(warning.message) for warning in caught)


def test_what_is_no_array_of_seconds_and_metres_is_refused():
    time, place = bursts()
    masked = np.ma.masked_greater(place, 1.0)
    for wrong in (
        (time, masked),
        (pd.to_timedelta(time, unit="s"), place),
        (time[None], place[None]),
    ):
        with pytest.raises(NotEnoughDataError, match="time_s and x_m must be finite numbers"):
            analyse(*wrong)
    with pytest.raises(
        InputError, match=r"window_s = 5: .* 3 samples or more, and there is one every 41"
    ):
        analyse(1000 * time, place)
    assert analyse(pd.Series(time), list(place)).small_share == analyse(time, place).small_share


@pytest.mark.parametrize("gap", [(60.0, 140.0), (100.0, 101.0)])
def test_nothing_is_measured_across_a_gap(gap):
    """Noise with a known law, and quiet on both sides of the gap; four frames are none."""
    time, noise = coloured(np.random.default_rng(8), -2.0, 200.0)
    few = abs(time - 30) > 1.6 / RATE
    assert analyse(time[few], 0.9 + 0.005 * noise[few]).spectra["whole"].end_s == time[-1]
    seen = (time < gap[0]) | (time >= gap[1])
    lost = f"gaps are {np.diff(gap)[0]:g} s of 200 s of the recording: the spectrum"
    with pytest.warns(UserWarning, match=lost):
        calm = analyse(time[seen], 0.9 + 0.005 * noise[seen])
    np.testing.assert_allclose(calm.small_s, [[0, gap[0]], [gap[1], 200]], atol=0.05)
    whole = calm.spectra["whole"]
    assert whole.end_s - whole.begin_s == pytest.approx(max(gap[0], 200 - gap[1]), abs=0.1)
    assert whole.law.exponent == pytest.approx(-2, abs=0.3)
    assert whole.x_m == pytest.approx(
        0.9 + 0.005 * noise[(time >= whole.begin_s) & (time <= whole.end_s)]
    )


def test_a_recording_of_short_pieces_alone_is_refused():
    time, x = bursts()
    seen = time % 1 < 0.6
    with pytest.raises(NotEnoughDataError, match="no 32 samples that no gap parts"):
        analyse(time[seen], x[seen])
    with pytest.warns(UserWarning, match="gaps are"):  # pieces of 3 s do not tell of 5 s
        seen = analyse(time[time % 4 < 3], x[time % 4 < 3])
    assert np.isnan(seen.small_share)


# --- errors ---------------------------------------------------------------------------------------


def swings(random, seconds, memory_s):
    """Gaussian swings of 10 cm about 85 cm that forget within a time, so r = 0.1 / 0.85."""
    kept = np.exp(-1 / RATE / memory_s)
    noise = np.sqrt(1 - kept**2) * random.normal(size=round(RATE * (seconds + 10 * memory_s)))
    time = instants(seconds)
    return time, 0.85 + 0.1 * lfilter([1], [1, -kept], noise)[-time.size :]


@pytest.mark.parametrize("memory_s", [0.5, 2.0])
def test_intervals_hold_the_truth_of_95_in_100_recordings(memory_s):
    random, held = np.random.default_rng(5), {"r": 0, "length": 0}
    for _ in range(200):
        seen = analyse(*swings(random, 150.0, memory_s))
        held["r"] += seen.disorder.low <= 0.1 / 0.85 <= seen.disorder.high
        held["length"] += seen.length.low <= 0.85 <= seen.length.high
    assert 181 <= held["r"] <= 198 and 181 <= held["length"] <= 198


@pytest.mark.parametrize("amplitude_m", [0.0, 1e-8, 1e-3])
def test_r_is_right_down_to_a_block_at_rest(amplitude_m):
    time = instants(120.0)
    seen = analyse(time, 0.8 + amplitude_m * np.sin(2 * np.pi * time)).disorder
    assert seen.value == pytest.approx(amplitude_m / np.sqrt(2) / 0.8, rel=1e-3, abs=0)
    assert not seen.low > seen.value


def test_centimetres_of_two_blocks_are_told():
    assert analyse(instants(10.0), np.full(240, 16.0)).mean_length == 16
    with pytest.raises(NotEnoughDataError, match="centimetres"):
        analyse(instants(10.0), np.full(240, 16.0), n_blocks=2)


def test_the_length_of_blocks_lowers_r_as_much_as_it_raises_the_mean():
    time, x = bursts()
    held = lengths_of_blocks(5, 0.04)
    along_tape, of_springs = analyse(time, x + held), analyse(time, x + held, blocks_m=held)
    assert held == pytest.approx(0.18)
    assert of_springs.mean_length == pytest.approx(along_tape.mean_length - held)
    assert of_springs.disorder_parameter == pytest.approx(
        along_tape.disorder_parameter * along_tape.mean_length / of_springs.mean_length
    )
    assert of_springs.x_m.min() == pytest.approx(x.min())


@pytest.mark.parametrize("exponent", [-1.0, -2.0])
def test_the_exponent_of_coloured_noise_is_found_and_its_intervals_hold_it(exponent):
    random = np.random.default_rng(8)
    laws, intervals = [], []
    for _ in range(12):
        time, noise = coloured(random, exponent, 60.0)
        spectrum = analyse(time, 0.9 + 0.05 * noise).spectra["whole"]
        laws.append(spectrum.law)
        intervals.append(spectrum.exponent)
    assert all(law.high == FIT_TO_HZ for law in laws)
    # the error of each is about 0.15, and 60 s flatten the steeper law by a little
    mean = np.mean([law.exponent for law in laws])
    assert mean == pytest.approx(exponent, abs=0.15)
    held = sum(interval.low <= exponent <= interval.high for interval in intervals)
    assert held >= 9


def coloured(random, exponent, seconds):
    """A part of a longer noise with a power law, of standard deviation 1."""
    time = instants(seconds)
    frequency = np.fft.rfftfreq(4 * time.size, 1 / RATE)[1:]
    waves = frequency ** (exponent / 2) * (random.normal(size=(frequency.size, 2)) @ [1, 1j])
    noise = np.fft.irfft(np.concatenate([[0], waves]))[: time.size]
    return time, noise / noise.std()


# --- peaks at equal distances ---------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize("exponent", [0.0, -1.0, -2.0])
def test_smooth_noise_has_a_comb_in_5_of_100_stretches(exponent):
    random = np.random.default_rng(5)
    p = np.array([comb(coloured(random, exponent, 60.0)[1], 1 / RATE).p for _ in range(400)])
    assert 10 <= np.sum(p < 0.05) <= 36 and 0.4 < np.median(p) < 0.7


@pytest.mark.parametrize(
    ("frequencies", "spacing"),
    [
        (0.465 * np.arange(1, 18), 0.465),
        (1.04 * np.arange(1, 8), 1.04),
        (1.9 * np.arange(1, 5), 1.9),
        ([1.04, 2.08, 4.16, 5.2, 6.24, 7.28], 1.04),  # one is missing
        ([2.1], None),
        ([0.93, 4.15], None),
        ([0.59, 1.73, 2.45, 3.02, 3.4], None),
    ],
)
def test_peaks_at_equal_distances_are_told_from_others(frequencies, spacing):
    time, noise = coloured(np.random.default_rng(3), -2.0, 60.0)
    heights = 0.3 / np.array(frequencies)
    found = comb(noise + heights @ np.cos(2 * np.pi * np.outer(frequencies, time)), 1 / RATE)
    assert (found.p < 0.01) == bool(spacing)
    if spacing:
        assert found.spacing_hz == pytest.approx(spacing, abs=0.015)
        assert len(frequencies) <= found.peaks.sum() <= found.peaks.size == int(8 / spacing)


# --- slips of all blocks --------------------------------------------------------------------------


def test_all_slip_where_no_block_is_stuck():
    # two blocks: the first sticks from 2 to 3, the second from 2.5 to 4 and turns at 6
    time, slipping = np.array([1.0, 5.0, 9.0]), np.array([[-3.0, 2.0], [0, 0], [0, 0]])
    rows = [(0.5, 1, "slip"), (2, 1, "stick"), (2.5, 2, "stick"), (3, 1, "slip"), (4, 2, "slip")]
    events = np.array([*rows, (6, 2, "stick"), (6, 2, "slip")], recorded.EVENTS)
    assert slips_of_all(time, slipping, events).tolist() == [[1, 2], [4, 6], [6, 9]]
    assert slips_of_all(time, slipping, events[:1]).tolist() == [[1, 9]]
    one_stuck = np.array([[-3.0, 1e-12], [0, 0], [0, 0]])
    assert slips_of_all(time, one_stuck, events[:0]).size == 0
    assert slips_of_all(time, one_stuck, events[4:5]).tolist() == [[4, 9]]
    assert slips_of_all(time[:0], slipping[:0], events).shape == (0, 2)


# --- errors of a track ----------------------------------------------------------------------------


def test_errors_of_a_track():
    true = 0.7 + 0.1 * np.sin(np.arange(2000))
    number = np.flatnonzero(np.arange(2000) % 7)
    noise = np.random.default_rng(0).normal(0, 1e-4, number.size)
    error = tracking_error(number / RATE, 1.001 * true[number] + 5e-4 + noise, true, 1 / RATE)
    assert error.scale == pytest.approx(1e-3, abs=1e-4)
    assert error.offset == pytest.approx(5e-4 + 7e-4, abs=2e-5)
    assert error.scatter == pytest.approx(np.hypot(1e-4, 1e-4 / np.sqrt(2)), rel=0.05)
    assert error.largest > error.offset + 2 * error.scatter
    for time in (np.arange(50) / RATE + 0.01, np.arange(2001) / RATE):
        with pytest.raises(NotEnoughDataError, match="other instants"):
            tracking_error(time, np.ones(time.size), true, 1 / RATE)
