"""Observers against plain NumPy on the samples and events of the same run."""

import numpy as np
import pytest

from beltrepro import ChainParameters, catalogue, scan, simulate
from beltrepro.model.spring import potential_energy

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


def test_length_slips_and_laminar_phases(table, runs):
    for point, run in enumerate(runs):
        length = run.positions[run.time >= TRANSIENT, -1]
        measured = {name: values[point] for name, values in table.items()}
        assert run.mean_length == pytest.approx(length.mean(), rel=1e-12)
        assert measured["mean_length"] == pytest.approx(length.mean(), rel=1e-12)
        for disorder in (run.disorder_parameter, measured["disorder_parameter"]):
            assert disorder == pytest.approx(length.std() / length.mean(), rel=1e-9)
        extremes = measured["minimum_length"], measured["maximum_length"]
        assert extremes == pytest.approx((length.min(), length.max()), rel=1e-12)
        for name in ("mean_wall_tension", "sum_rule_residual"):
            assert measured[name] == getattr(run, name)

        events, n_blocks = run.events, run.parameters.n_blocks
        late = (events["kind"] == "slip") & (events["time"] >= TRANSIENT)
        slips = np.bincount(events["block"][late] - 1, minlength=10)
        np.testing.assert_array_equal(measured["slip_count"], slips)
        times = events["time"][events["block"] == n_blocks]  # slip, stick, slip, ...
        assert measured["last_stick_time"] == times[1::2][-1]
        starts, stops = times[::2], np.append(times[1::2], DURATION)[: len(times[::2])]
        lengths = stops - np.maximum(starts, TRANSIENT)
        phases = lengths[lengths > LAMINAR_TIME]
        assert measured["laminar_count"] == len(phases)
        assert measured["laminar_longest"] == pytest.approx(phases.max(initial=0))
        share = phases.sum() / (DURATION - TRANSIENT)
        assert measured["laminar_fraction"] == pytest.approx(share)
    assert table["laminar_count"].sum() > 0


@pytest.mark.parametrize(("method", "error"), [("verlet", 1e-9), ("event", 5e-5)])
def test_crossings_of_the_section(method, error):
    """Between samples 0.001 apart the scheme's motion is a line; |a| < 200 bends the true one."""
    chain, lengths = ChainParameters(5, 20.0, 1.0), {"duration": 240, "method": method}
    some, last = (
        catalogue(chain, transient=40, section_block=block, section_position=place, **lengths)
        for block, place in ((2, 250.0), (5, 600.0))
    )
    run = simulate(chain, sample_interval=0.001, **lengths)
    for block, place, section in ((2, 250.0, some["section"]), (5, 600.0, last["section"])):
        x = run.positions[:, block - 1]
        down = np.flatnonzero((x[:-1] >= place) & (x[1:] < place) & (run.time[1:] >= 40))
        assert len(section) == len(down) > 3
        share = (x[down] - place) / (x[down] - x[down + 1])
        np.testing.assert_allclose(section["time"], run.time[down] + share * 0.001, atol=error)
        between = run.positions[down] + share[:, None] * np.diff(run.positions, axis=0)[down]
        np.testing.assert_allclose(section["positions"], between, atol=error)
        np.testing.assert_allclose(section["positions"][:, block - 1], place)
        assert np.abs(section["velocities"] - run.velocities[down + 1]).max() < 0.2
    bins = [-90.0, -40.0, -20.0, -15.0, 0.0]
    table = scan([chain] * 2, transient=40, section_position=[250.0, 600.0], replicate=[1, 0],
                 section_bins=bins, **lengths)  # fmt: skip
    assert table["section_count"][1] == len(last["section"])
    velocities = table["section_velocity"][1, : len(last["section"])]
    np.testing.assert_allclose(velocities, last["section"]["velocities"][:, -1], rtol=1e-6)
    counts, _ = np.histogram(last["section"]["velocities"][:, -1], bins)
    assert table["section_histogram"][1].tolist() == counts.tolist() and counts.any()


def test_avalanches_take_their_energy_from_the_springs():
    chain = ChainParameters(3, 2.0)
    run = simulate(chain, duration=400, sample_interval=0.001, method="verlet")
    step = np.round(run.events["time"] / 0.001).astype(int)
    sampled = run.positions[step, run.events["block"] - 1]
    np.testing.assert_allclose(run.events["position"], sampled, atol=1e-9)
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
