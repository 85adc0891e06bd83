"""Trials: runs judged as recordings of the experiment, against naive twins."""

import numpy as np
import pytest

from beltrepro import ChainParameters, simulate
from beltrepro.model import units
from beltrepro.replication.camera import recording
from beltrepro.replication.camera.trials import trials

FRAME = 0.54484  # model time between frames, 24 in a second
SPAN = {"duration": 1500.0, "transient": 500.0}
CHAINS = [
    ChainParameters(5, 20.0, 1.0, friction_ratio=0.6),
    ChainParameters(5, 12.0, 1.0),
    ChainParameters(3, 15.0, 1.0, friction_ratio=0.6),
]
HOW = {"method": "event", "seed": 4, "replicate": [3, 4, 5]}


@pytest.fixture(scope="module")
def table():
    return trials(CHAINS, **SPAN, sample_interval=FRAME, **HOW)


def naive_slip(run, blocks):
    """Longest time without a stuck block, event by event."""
    stuck, since, longest = set(blocks), None, 0.0
    for event in run.events:
        if event["block"] not in blocks:
            continue
        time = max(event["time"], run.transient)
        if event["kind"] == "slip":
            stuck.discard(event["block"])
            if not stuck and since is None:
                since = time
        else:
            at_once = run.events[run.events["time"] == event["time"]]
            if not any(at_once["kind"][at_once["block"] == event["block"]] == "slip"):
                if since is not None:
                    longest = max(longest, time - since)
                stuck.add(event["block"])
                since = None
    return max(longest, run.duration - since) if since is not None else longest


def test_a_trial_is_what_the_analysis_of_a_recording_says_of_the_frames(table):
    for row, chain in enumerate(CHAINS):
        how = HOW | {"replicate": HOW["replicate"][row], "sample_start": 500.0}
        run = simulate(chain, **SPAN, sample_interval=FRAME, **how)
        film = recording.analyse(
            units.to_si(run.time, "time"), units.to_si(run.positions[:, -1], "length")
        )
        assert table["disorder_parameter"][row] == film.disorder_parameter
        assert table["small_share"][row] == film.small_share
        assert table["lasting_share"][row] == film.lasting_share
        lengths = units.from_si(np.diff(film.small_s, axis=1)[:, 0], "time")
        assert table["lasting_longest"][row] == pytest.approx(lengths.max(initial=0.0)) or (
            lengths.max(initial=0.0) <= 200
        )
        assert table["lasting_count"][row] == np.sum(lengths > 200)
        edges = units.from_si(film.small_s, "time")
        phases = edges[np.diff(edges, axis=1)[:, 0] > 200]
        between = np.diff([run.time[0], *phases.ravel(), run.time[-1]])[::2]
        assert table["lively_longest"][row] == pytest.approx(between.max(), abs=2 * FRAME)
        every = range(1, chain.n_blocks + 1)
        assert table["slip_longest"][row] == pytest.approx(naive_slip(run, [chain.n_blocks]))
        assert table["all_slip_longest"][row] == pytest.approx(naive_slip(run, every))
    assert (table["lasting_count"] > 0).any() and (table["lasting_count"] == 0).any()


def test_trials_do_not_depend_on_how_many_are_made_at_once(table, monkeypatch):
    short = trials(CHAINS, **SPAN, sample_interval=FRAME, laminar_time=20.0, **HOW)
    assert np.all(short["lasting_share"] >= table["lasting_share"])
    assert np.any(short["lasting_count"] > table["lasting_count"])
    monkeypatch.setattr("beltrepro.replication.camera.trials._AT_ONCE", 2)
    again = trials(CHAINS, **SPAN, sample_interval=FRAME, **HOW)
    for name, values in table.items():
        np.testing.assert_array_equal(values, again[name])
