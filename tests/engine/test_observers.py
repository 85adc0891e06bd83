"""Observers against plain NumPy on the samples and events of the same run."""

import numpy as np
import pytest

from beltrepro import ChainParameters, catalogue, scan, simulate
from beltrepro.model.spring import potential_energy
from beltrepro.observe.slips import EventLog

CHAINS = [ChainParameters(5, 12.0), ChainParameters(5, 25.0, 1.0), ChainParameters(3, 40.0, 2.0)]
DURATION, TRANSIENT, LAMINAR_TIME = 300.0, 100.0, 4.0
LENGTHS = {"duration": DURATION, "transient": TRANSIENT, "method": "verlet"}


@pytest.fixture(scope="module")
def table():
    sections = [615.0, 615.0, 250.0]
    return scan(CHAINS, section_position=sections, laminar_time=LAMINAR_TIME, **LENGTHS)


@pytest.fixture(scope="module")
def runs():
    return simulate(CHAINS, sample_interval=0.1, **LENGTHS)


def test_moments(table, runs):
    for point, run in enumerate(runs):
        length = run.positions[run.time >= TRANSIENT, -1]
        disorder = np.sqrt((length**2).mean() - length.mean() ** 2) / length.mean()
        for mean, r in (
            (run.mean_length, run.disorder_parameter),
            (table["mean_length"][point], table["disorder_parameter"][point]),
        ):
            assert mean == pytest.approx(length.mean(), rel=1e-12)
            assert r == pytest.approx(disorder, rel=1e-9)
        assert table["minimum_length"][point] == pytest.approx(length.min(), rel=1e-12)
        assert table["maximum_length"][point] == pytest.approx(length.max(), rel=1e-12)


def test_slips_and_laminar_phases(table, runs):
    for point, run in enumerate(runs):
        events = run.events
        n_blocks = run.parameters.n_blocks
        for block in range(1, n_blocks + 1):
            kinds = events["kind"][events["block"] == block]
            assert np.all(kinds[::2] == "slip") and np.all(kinds[1::2] == "stick")
            late = (events["block"] == block) & (events["time"] >= TRANSIENT)
            count = np.sum(events["kind"][late] == "slip")
            assert table["slip_count"][point, block - 1] == count
        assert np.all(table["slip_count"][point, n_blocks:] == 0)

        times = events["time"][events["block"] == n_blocks]
        assert table["last_stick_time"][point] == times[1::2][-1]
        starts, stops = times[::2], times[1::2]
        stops = np.append(stops, DURATION)[: len(starts)]
        lengths = stops - np.maximum(starts, TRANSIENT)
        phases = lengths[lengths > LAMINAR_TIME]
        assert table["laminar_count"][point] == len(phases)
        if len(phases):
            assert table["laminar_mean"][point] == pytest.approx(phases.mean())
            assert table["laminar_longest"][point] == pytest.approx(phases.max())
        share = phases.sum() / (DURATION - TRANSIENT)
        assert table["laminar_fraction"][point] == pytest.approx(share)
    assert table["laminar_count"].sum() > 0


def test_crossings_of_the_section():
    chain = ChainParameters(5, 20.0, 1.0)
    recorded = catalogue(
        chain, duration=120, transient=40, section_block=2, section_position=250.0, method="verlet"
    )
    run = simulate(chain, duration=120, sample_interval=0.001, method="verlet")
    x, v = run.positions, run.velocities
    down = (x[:-1, 1] >= 250) & (x[1:, 1] < 250) & (run.time[1:] >= 40)
    section = recorded["section"]
    assert len(section) == down.sum() > 3
    share = ((x[:-1, 1] - 250) / (x[:-1, 1] - x[1:, 1]))[down]
    np.testing.assert_allclose(section["time"], run.time[:-1][down] + share * 0.001, atol=1e-9)
    between = x[:-1][down] + share[:, None] * (x[1:] - x[:-1])[down]
    np.testing.assert_allclose(section["positions"], between, atol=1e-9)
    np.testing.assert_allclose(section["positions"][:, 1], 250)
    measured = scan([chain] * 2, duration=120, transient=40, section_position=[250.0, 600.0],
                    replicate=[1, 0], method="verlet")  # fmt: skip
    last = catalogue(chain, duration=120, transient=40, section_position=600.0, method="verlet")
    assert measured["section_count"][1] == len(last["section"]) > 3
    velocities = measured["section_velocity"][1, : len(last["section"])]
    np.testing.assert_allclose(velocities, last["section"]["velocities"][:, -1], rtol=1e-6)
    # velocities change by a*dt within the step, |a| < 200
    assert np.abs(section["velocities"] - v[1:][down]).max() < 0.2


def test_event_positions_are_those_of_the_samples():
    run = simulate(ChainParameters(3, 2.0), duration=400, sample_interval=0.001, method="verlet")
    step = np.round(run.events["time"] / 0.001).astype(int)
    sampled = run.positions[step, run.events["block"] - 1]
    np.testing.assert_allclose(run.events["position"], sampled, atol=1e-9)


def test_avalanches_take_their_energy_from_the_springs():
    chain = ChainParameters(3, 2.0)
    run = simulate(chain, duration=400, sample_interval=0.001, method="verlet")
    recorded = catalogue(chain, duration=400, transient=0, section_position=180.0, method="verlet")
    avalanches = recorded["avalanches"]
    starts = run.events["time"][run.events["kind"] == "slip"]
    assert len(avalanches) > 5 and set(recorded["slips"]["start_time"]) <= set(starts)
    before, after = (
        run.positions[np.round(avalanches[name] / 0.001).astype(int)]
        for name in ("start_time", "stop_time")
    )
    moved = (after - before)[:, -1]
    np.testing.assert_allclose(avalanches["last_block_displacement"], moved, atol=1e-9)
    drop = potential_energy(before, chain) - potential_energy(after, chain)
    np.testing.assert_allclose(avalanches["spring_energy_drop"], drop, rtol=1e-9, atol=1e-6)


def test_event_log_is_the_same_however_it_is_cut(monkeypatch):
    """A long run keeps its events in blocks; a run's records take them over."""
    chains = [ChainParameters(5, 20.0, 1.0), ChainParameters(2, 3.0)]
    lengths = {"duration": 1500, "method": "event", "sample_interval": None}
    whole = simulate(chains, **lengths)
    monkeypatch.setattr(EventLog, "_PIECE", 100)
    for one, cut in zip(whole, simulate(chains, **lengths), strict=True):
        assert len(one.events) > 300
        np.testing.assert_array_equal(one.events, cut.events)
