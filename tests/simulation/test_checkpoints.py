"""A job that is killed goes on where it was, with the bits of one that was not."""

import numpy as np
import pytest

from beltrepro import ChainParameters, simulate
from beltrepro.chaos import classify, separation, time_to_orbit
from beltrepro.replication.camera.trials import trials
from beltrepro.simulation import catalogue, checkpoints, scan, time_to_continuous_slip

QUIET = [ChainParameters(n_blocks=n, belt_velocity=u) for n in (2, 5) for u in (7.0, 20.0)]
NOISY = [ChainParameters(n_blocks=5, belt_velocity=7.0, noise=1.0)]
STOPS = (0.1, 0.35, 0.6, 0.9)  # shares of the work at which a job is killed


class Killed(Exception):
    """Stands for a kill: nothing of the job is there afterwards but its checkpoint."""


def sampled(chains, **settings):
    runs = simulate(chains, sample_interval=0.5, **settings)
    return {
        "positions": np.concatenate([run.positions.ravel() for run in runs]),
        "events": np.concatenate([run.events for run in runs]),
        "residual": np.array([run.energy_residual for run in runs]),
    }


WORK = {
    "scan": (scan, QUIET + NOISY, {"duration": 1500, "transient": 500, "method": "event"}),
    "scan verlet": (scan, QUIET + NOISY, {"duration": 750, "transient": 250, "method": "verlet"}),
    "catalogue": (catalogue, QUIET + NOISY, {"duration": 1000, "method": "event"}),
    "escapes": (time_to_continuous_slip, QUIET, {"duration": 1500, "settle_time": 300}),
    "series": (sampled, QUIET + NOISY, {"duration": 750, "transient": 0, "method": "event"}),
    "trial": (trials, NOISY * 40, {"duration": 400, "transient": 100, "sample_interval": 1.0}),
    "motion": (classify, QUIET + NOISY, {"duration": 1500, "transient": 500}),
    "settling": (time_to_orbit, QUIET, {"duration": 6000}),
    "kicked": (time_to_orbit, QUIET, {"duration": 6000, "kick": 0.1}),
    "separation": (separation, QUIET, {"duration": 750, "transient": 250, "distances": [1e-6]}),
}


def run(name, progress):
    work, chains, options = WORK[name]
    count = range(1, len(chains) + 1)
    return work(chains, replicate=count, initial_spread=1.0, progress=progress, **options)


@pytest.mark.parametrize("name", WORK)
def test_a_killed_job_goes_on_with_the_same_bits(tmp_path, name):
    path, calls = tmp_path / "checkpoint", []
    whole = run(name, calls.append)
    again = []

    def until(stop):
        def report(fraction):
            again.append(fraction)
            if fraction > stop:
                raise Killed

        return report

    kills = 0
    for stop in STOPS:
        try:
            with checkpoints.keeping(path, name, every=0):
                run(name, until(stop))
        except Killed:
            kills += 1
            assert path.exists() or name == "series"  # samples are not kept
    assert kills >= (1 if name == "trial" else 2)  # motion that settles ends early
    with checkpoints.keeping(path, name, every=0):
        printed = run(name, again.append)
    assert not path.exists()
    assert set(printed) == set(whole)
    for array, values in whole.items():
        assert printed[array].tobytes() == values.tobytes(), array
    if name in ("scan", "scan verlet", "catalogue", "escapes", "motion"):
        assert len(again) == len(calls) + kills  # only the chunk is done again that was cut


def first_steps(path, work="work"):
    """Steps of a job with two steps that it has to do, killed in the second."""
    done = []
    with pytest.raises(Killed), checkpoints.keeping(path, work, every=0):
        checkpoints.once(done.append, 1)
        checkpoints.once(lambda: [done.append(2)])
        raise Killed
    return done


def test_steps_that_are_kept_are_not_done_again(tmp_path):
    assert first_steps(tmp_path / "c") == [1, 2]
    # the first gave None, which is nothing to keep
    assert first_steps(tmp_path / "c") == [1]


@pytest.mark.parametrize(
    "damage",
    [lambda data: data[:-3], lambda data: b"", lambda data: data[:70] + b"x" + data[71:]],
    ids=["truncated", "empty", "flipped"],
)
def test_a_damaged_checkpoint_is_ignored(tmp_path, damage, caplog):
    path = tmp_path / "c"
    first_steps(path)
    path.write_bytes(damage(path.read_bytes()))
    assert first_steps(path) == [1, 2]
    assert "damaged, beginning anew" in caplog.text


def test_a_checkpoint_of_other_work_is_ignored(tmp_path, caplog):
    caplog.set_level("INFO", "beltrepro")
    first_steps(tmp_path / "c", "by the code of yesterday")
    assert first_steps(tmp_path / "c") == [1, 2]
    assert "other settings, code or machine" in caplog.text


def test_short_steps_are_not_written(tmp_path):
    with pytest.raises(Killed), checkpoints.keeping(tmp_path / "c", "work"):
        run("escapes", lambda fraction: None)
        raise Killed
    assert not (tmp_path / "c").exists()
