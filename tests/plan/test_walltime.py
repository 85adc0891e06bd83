"""Wall time on many cores, from the time of some jobs."""

from pathlib import Path

import numpy as np
import pytest

from beltrepro.replication.plan import jobs as walltime
from beltrepro.replication.plan.jobs import Job, estimate, job_seconds, wall_seconds
from beltrepro.replication.plan.jobs import wall_times as table

ROOT = Path(__file__).parents[2]
FREE = {"overhead": 0.0, "rate": np.inf}  # what a schedule on paper costs


def test_known_schedules():
    assert wall_seconds([3, 1, 2, 4], 1, **FREE) == 10
    # core 1: 3, then 4; core 2: 1, 2
    assert wall_seconds([3, 1, 2, 4], 2, **FREE) == 7
    assert wall_seconds([3, 1, 2, 4], 4, **FREE) == wall_seconds([3, 1, 2, 4], 9, **FREE) == 4
    # Graham's worst case: 2 - 1/p times the optimum, which is 3
    assert wall_seconds([1, 1, 1, 1, 1, 1, 3], 3, **FREE) == 5


def test_schedule_lies_between_its_bounds():
    seconds = np.random.default_rng(1).exponential(100, 300)
    for cores in (1, 7, 50, 400):
        least = max(seconds.sum() / cores, seconds.max())
        found = wall_seconds(seconds, cores, **FREE)
        assert least * (1 - 1e-12) <= found <= (2 - 1 / cores) * least


def test_starts_and_sending_cost_time():
    assert wall_seconds([10] * 4, 2, overhead=1, rate=np.inf) == 22
    # the last of 100 is sent after 99/2 s
    assert wall_seconds([10] * 100, 1000, overhead=0, rate=2) == 99 / 2 + 10


def test_table_says_what_limits():
    answer = table([100.0] * 99 + [2000.0], (1, 100), **FREE)
    assert list(answer["limit"]) == ["work", "longest job"]
    assert answer["hours"].tolist() == pytest.approx([11900 / 3600, 2000 / 3600])
    assert answer["busy"].tolist() == pytest.approx([1, 11900 / (100 * 2000)])
    assert table([1.0] * 50, (1000,), overhead=0, rate=2)["limit"][0] == "sending"


def test_time_of_a_job_is_its_work_times_the_cost_of_its_class():
    one, other = ("scan", "event", True), ("scan", "verlet", False)
    jobs = [Job(*one, "a", 10.0), Job(*one, "b", 30.0), Job(*other, "c", 5.0)]
    timing = estimate(jobs, {"a": 20.0, "c": 50.0})
    assert job_seconds(jobs, timing) == pytest.approx([20, 60, 50])
    with pytest.raises(walltime.InputError, match=r"series by event with noise"):
        job_seconds([*jobs, Job("series", "event", True, "d", 1.0)], timing)


@pytest.fixture
def timing(tmp_path):
    """timing.csv in which each job of smoke took as many seconds as its work / 1000."""
    from beltrepro.replication.plan.config import load_config
    from beltrepro.replication.plan.jobs import simulation_jobs
    from beltrepro.replication.plan.plan import make_plan

    jobs = simulation_jobs(make_plan(load_config(ROOT / "config.yaml") | {"preset": "smoke"}))
    path = tmp_path / "timing.csv"
    estimate(jobs, {job.name: job.work / 1000 for job in jobs}).to_csv(path, index=False)
    return path, sum(job.work for job in jobs) / 1000


@pytest.mark.thorough
def test_command(timing, capsys, tmp_path):
    path, total = timing
    config = str(ROOT / "config.yaml")
    words = [str(path), "--preset", "smoke", "--cores", "1", "--config", config]
    assert walltime.main([*words, "--overhead", "0"]) == 0
    assert f"{total / 3600:.3g}" in capsys.readouterr().out.splitlines()[-1].split()
    variant = tmp_path / "variant.yaml"
    variant.write_text("presets: {smoke: {datasets: {n5_map: {replicate: {count: 3}}}}}\n")
    assert walltime.main([*words, str(variant), "--overhead", "0"]) == 0
    more = capsys.readouterr().out.splitlines()[-1].split()
    assert float(more[1]) > total / 3600
    variant.write_text(
        "presets: {smoke: {datasets: {n5_u7: {replicate: {count: 8}, more_runs: "
        "{by: 8, up_to: 24, of: disorder_parameter, half_width: 0.1}}}}}\n"
    )
    assert walltime.main([*words, str(variant), "--overhead", "0"]) == 0
    # 5 levels of noise, one of them 0, at u = 7: two jobs in each of two rounds
    work = 5 * 1500 * 5 * 16 / 1000 / 3600
    said = capsys.readouterr().out.splitlines()[1]
    assert said == (
        f"with 4 jobs that add runs where they are needed: at most {work:.3g} core-hours, "
        "all counted here"
    )


@pytest.mark.thorough
def test_bad_input_of_the_command_is_one_line(timing, capsys, tmp_path):
    assert walltime.main([str(tmp_path / "absent.csv")]) == 1
    other = tmp_path / "other.csv"
    other.write_text("a,b\n1,2\n")
    assert walltime.main([str(other)]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2 and "absent.csv" in lines[0] and "snakemake timing" in lines[1]
