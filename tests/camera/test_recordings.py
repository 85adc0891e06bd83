"""Recordings of the virtual experiment: lines of spectra, slips of all, errors, table."""

import numpy as np
import pytest

import recorded
from beltrepro.base import seal
from beltrepro.base.errors import NotEnoughDataError
from beltrepro.base.store import Dataset
from beltrepro.replication.camera.track import Track
from beltrepro.replication.camera.video import write_video
from beltrepro.replication.plan import io
from beltrepro.replication.studies.experiment.measure import (
    TABLES,
    longest_slip_of_all_s,
    recordings,
    tracking_error,
)
from beltrepro.stats.intermittency import slips_of_all
from beltrepro.stats.lines import lines, spacing

RATE = recorded.RATE
FULL = recorded.recordings()


# --- lines of a spectrum --------------------------------------------------------------------------


def waves(frequencies, seconds=60.0, noise=1e-3):
    time = np.arange(round(seconds * RATE)) / RATE
    random = np.random.default_rng(3).normal(0, noise, time.size)
    return sum(np.cos(2 * np.pi * f * time + f) for f in frequencies) + random


def test_harmonics_are_found_at_their_places_and_are_equally_spaced():
    frequencies = 0.57 * np.arange(1, 7)
    spectral_lines = lines(waves(frequencies), 1 / RATE)
    assert spectral_lines.peaks_hz == pytest.approx(frequencies, abs=0.01)
    assert spectral_lines.flatness < 0.01
    step = spacing(spectral_lines.peaks_hz)
    assert step.step_hz == pytest.approx(0.57, abs=0.003)
    assert step.concentration > 0.99 and step.p < 0.01


def test_lines_at_unequal_distances_are_no_multiples():
    spectral_lines = lines(waves([0.59, 1.73, 2.45, 3.02, 3.4]), 1 / RATE)
    assert spectral_lines.peaks_hz.size == 5
    assert spacing(spectral_lines.peaks_hz).p > 0.05


@pytest.mark.thorough
def test_random_peaks_are_seldom_taken_for_multiples():
    random = np.random.default_rng(5)
    p = [spacing(np.sort(random.uniform(0, 2.8, 6)) + 0.2 + 0.15 * np.arange(6)).p
         for _ in range(40)]  # fmt: skip
    assert np.mean(np.array(p) < 0.05) < 0.15
    assert 0.25 < np.median(p) < 0.75


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_noise_has_a_flat_spectrum_without_lines(memory):
    random = np.random.default_rng(1).normal(size=24 * 200)
    values = np.zeros(random.size)
    for index in range(1, random.size):
        values[index] = memory * values[index - 1] + random[index]
    spectral_lines = lines(values, 1 / RATE)
    assert spectral_lines.flatness > 0.8
    assert spectral_lines.peaks_hz.size == 0


def test_too_short_a_series_and_too_few_peaks_are_said():
    with pytest.raises(NotEnoughDataError, match="needs 20 s"):
        lines(np.zeros(100), 1 / RATE)
    with pytest.raises(NotEnoughDataError, match="3 peaks"):
        spacing([1.0, 2.0, 3.0])


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


def test_the_longest_slip_of_all_blocks_is_told_in_seconds():
    """In `belt_028` every block sticks each half second, but for 120 s."""
    run = FULL["belt_028"]
    assert longest_slip_of_all_s(run) == pytest.approx(120, abs=0.6)
    stuck = run.arrays["velocities"].copy()
    stuck[0, 2] = run.attributes["belt_velocity"]  # the middle one moves with the belt
    arrays = run.arrays | {"velocities": stuck, "events": run.arrays["events"][:0]}
    assert longest_slip_of_all_s(Dataset(arrays, run.attributes)) == 0.0


# --- errors of a track ----------------------------------------------------------------------------


def test_errors_of_a_track():
    true = 0.7 + 0.1 * np.sin(np.arange(2000))
    number = np.flatnonzero(np.arange(2000) % 7)
    noise = np.random.default_rng(0).normal(0, 1e-4, number.size)
    error = tracking_error(number / RATE, 1.001 * true[number] + 5e-4 + noise, true, 1 / RATE)
    assert error.scale == pytest.approx(1e-3, abs=1e-4)
    assert error.offset == pytest.approx(5e-4 + 7e-4, abs=2e-5)
    assert error.scatter == pytest.approx(np.hypot(1e-4, 1e-4 / np.sqrt(2)), rel=0.05)
    assert error.places == number.size
    assert error.largest > error.offset + 2 * error.scatter


def test_a_track_at_other_instants_is_refused():
    true = np.ones(100)
    for time in (np.arange(50) / RATE + 0.01, np.arange(101) / RATE):
        with pytest.raises(NotEnoughDataError, match="other instants"):
            tracking_error(time, np.ones(time.size), true, 1 / RATE)


# --- the table ------------------------------------------------------------------------------------


def test_table_has_a_row_for_each_film_with_its_errors():
    table = recordings(FULL).set_index("film")
    assert list(table.index) == ["belt_022", "belt_028", "belt_035"]
    assert set(TABLES["recordings"].columns) - {"film"} <= set(table.columns)
    row = table.loc["belt_028"]
    assert row["belt_speed"] == pytest.approx(0.28)
    assert row["r_run"] == pytest.approx(float(FULL["belt_028"].arrays["disorder_parameter"]))
    assert row["r_sampled"] == pytest.approx(row["r_run"], rel=1e-4)
    assert row["scatter"] == pytest.approx(1e-4 / recorded.PIXEL, rel=0.02)
    assert row["small_tracked"] == pytest.approx(0.12, abs=0.003)
    assert row["seconds"] == pytest.approx(1000)


# --- files ----------------------------------------------------------------------------------------


def test_films_and_tracks_are_read_by_their_names(tmp_path):
    frames = recorded.film(FULL["belt_028"], frames=5)
    write_video(tmp_path / "a.mp4", frames(), frames_per_second=RATE)
    FULL["belt_028_track"].save(tmp_path / "a.csv", sources={"a": {}})
    seal.put(tmp_path / "a.csv")
    paths = {"a_film": str(tmp_path / "a.mp4"), "a_track": str(tmp_path / "a.csv")}
    loaded, sources = io.load(paths)
    assert sources == {"a": {}}
    times = [frame.time_s for frame in loaded["a_film"]()]
    assert times == pytest.approx(np.arange(5) / RATE, abs=1e-4)
    assert [frame.time_s for frame in loaded["a_film"]()] == times
    assert isinstance(loaded["a_track"], Track)
    assert loaded["a_track"].x_m == pytest.approx(FULL["belt_028_track"].x_m, rel=1e-8)
