"""How long a preset takes, judged from a sample of its jobs, and on many cores."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from beltrepro.base.errors import InputError
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.jobs import (
    Job,
    draw,
    estimate,
    job_seconds,
    main,
    simulation_jobs,
    wall_seconds,
    wall_times,
)
from beltrepro.replication.plan.plan import make_plan

ROOT = Path(__file__).parents[2]


def plan(preset):
    return make_plan(load_config(ROOT / "config.yaml") | {"preset": preset})


def made_up(count, cost_class=("scan", "event", True)):
    return [Job(*cost_class, f"{cost_class[0]}/{number}", 1.0 + number) for number in range(count)]


@pytest.mark.thorough
@pytest.mark.parametrize("preset", ["smoke", "standard", "paper"])
def test_sample_is_a_tenth_of_every_class_and_no_job_twice(preset):
    jobs = simulation_jobs(plan(preset))
    assert len({job.name for job in jobs}) == len(jobs)
    sample = draw(jobs, seed=1)
    assert len(set(sample)) == len(sample)
    for cost_class in {job.cost_class for job in jobs}:
        alike = [job for job in jobs if job.cost_class == cost_class]
        assert len([job for job in sample if job.cost_class == cost_class]) >= len(alike) / 10


def test_work_is_chains_times_blocks_times_time():
    paper = plan("paper")
    work = {job.name: job.work for job in simulation_jobs(paper)}
    assert work["batches/n5_rows/0000"] == 32 * 5 * 2e6
    assert work["batches/u1/0000"] == 5 * 210000
    of_map = sum(value for name, value in work.items() if name.startswith("batches/size_rows/"))
    assert of_map == sum(500000 * point.n_blocks for point in paper.datasets["size_rows"].points)


def test_classes_tell_noise():
    jobs = simulation_jobs(plan("paper"))
    assert {job.noise for job in jobs if job.name.startswith("batches/n5_u7/")} == {False, True}
    assert {job.noise for job in jobs if "slips_u1" in job.name} == {False}
    assert {job.noise for job in jobs if "n5_map" in job.name and job.method == "event"} == {True}


def test_chances_are_proportional_to_work():
    jobs = made_up(23)
    work = np.array([job.work for job in jobs])
    counts = np.zeros(23)
    for seed in range(4000):
        for job in draw(jobs, seed):
            counts[int(job.name.split("/")[1])] += 1
    # three draws; 5 standard errors of a share are at most 0.04
    assert np.all(np.abs(counts / 4000 - 3 * work / work.sum()) < 0.04)


def test_a_large_job_is_always_drawn():
    jobs = [*made_up(9), Job("scan", "event", True, "scan/9", 1e9)]
    assert all(draw(jobs, seed)[-1].work == 1e9 for seed in range(20))


@pytest.mark.thorough
def test_estimate_covers_the_truth_within_its_error():
    """Scatter of 20 %: the estimate is within 2 standard errors in 95 % of samples, about."""
    random = np.random.default_rng(1)
    jobs = made_up(200)
    seconds = {job.name: 100 * job.work * random.normal(1, 0.2) for job in jobs}
    truth = sum(seconds.values()) / 3600
    within = []
    for seed in range(300):
        row = estimate(jobs, {job.name: seconds[job.name] for job in draw(jobs, seed)}).iloc[0]
        within.append(abs(row["hours"] - truth) < 2 * row["standard_error"])
    assert np.mean(within) > 0.85


def test_estimate_sums_kinds_and_knows_what_is_missing():
    jobs = made_up(10) + made_up(1, ("series", "verlet", False))
    expected = {job.name: 3600.0 for job in jobs}
    table = estimate(jobs, expected)
    assert list(table["kind"]) == ["scan", "series", "sum"]
    assert table["hours"].iloc[-1] == pytest.approx(11)
    assert table["standard_error"].iloc[-1] == 0
    del expected["series/0"]
    assert np.isnan(estimate(jobs, expected)["hours"].iloc[-1])


def test_the_error_of_a_sum_is_that_over_all_samples():
    """Over all samples of jobs of equal work the mean square of the error is the one stated."""
    jobs = [Job("scan", "event", True, f"scan/{number}", 2.0) for number in range(7)]
    hours = np.array([1.0, 2.0, 4.0, 4.5, 7.0, 9.0, 20.0])
    for size in (2, 3, 6):
        misses, errors = [], []
        for sample in itertools.combinations(range(7), size):
            ran = {f"scan/{number}": 3600 * hours[number] for number in sample}
            row = estimate(jobs, ran).iloc[0]
            assert (row["jobs"], row["jobs_run"]) == (7, size)
            assert row["hours_run"] == pytest.approx(hours[list(sample)].sum())
            misses.append(row["hours"] - hours.sum())
            errors.append(row["standard_error"])
        assert np.mean(misses) == pytest.approx(0, abs=1e-9)
        assert np.mean(np.square(misses)) == pytest.approx(np.mean(np.square(errors)))


def test_errors_of_classes_add_as_squares_and_one_of_several_jobs_has_none():
    classes = [("catalogue", "event", True), ("scan", "event", True), ("series", "event", True)]
    jobs = [job for classe in classes for job in made_up(4, classe)]
    seconds = {f"{kind}/{k}": 3600.0 * (k + 1) ** 2 for kind, *_ in classes[:2] for k in (0, 2, 3)}
    seconds["series/1"] = 3600.0
    table = estimate(jobs, seconds)
    one, other, unknown, total = table["standard_error"]
    assert one == other > 0 and np.isnan(unknown)
    assert total == pytest.approx(np.sqrt(2) * one)
    # of work 1, 3, 4 and times 1, 9, 16, with a ratio of 26/8
    by_hand = sum((t - 3.25 * w) ** 2 for w, t in ((1, 1), (3, 9), (4, 16))) / 2
    assert one == pytest.approx(4 * np.sqrt((1 / 3 - 1 / 4) * by_hand))
    assert table["hours"].iloc[2] == pytest.approx(10 / 2)


def test_estimate_of_time_memory_and_disk():
    """Time and size are proportional to work here, so exact; memory is the largest seen."""
    jobs = made_up(40) + made_up(1, ("series", "verlet", False))
    ran = [*jobs[3:40:10], jobs[-1]]
    seconds = {job.name: 1800 * job.work for job in ran}
    memory = {job.name: 100 + job.work for job in ran}
    table = estimate(jobs, seconds, memory, {job.name: 2e6 * job.work for job in ran})
    total = table.iloc[-1]
    work = sum(job.work for job in jobs)
    assert (total["hours"], total["megabytes"]) == pytest.approx((0.5 * work, 2 * work))
    errors = total["standard_error"], total["megabytes_error"]
    assert errors == pytest.approx((0, 0), abs=1e-6)
    assert list(table["memory_mb"]) == [134.0, 101.0, 134.0]
    unknown = estimate(jobs, seconds).iloc[-1]
    assert np.isnan(unknown["megabytes"]) and np.isnan(unknown["memory_mb"])


# --- on many cores ---

AT_ONCE = np.inf  # jobs sent in a second


@pytest.mark.parametrize(
    ("seconds", "cores", "rate", "wall"),
    [
        ([3, 1, 2, 4], 1, AT_ONCE, 10),
        ([3, 1, 2, 4], 2, AT_ONCE, 7),  # core 1: 3, then 4; core 2: 1, 2
        ([3, 1, 2, 4], 4, AT_ONCE, 4),
        ([3, 1, 2, 4], 9, AT_ONCE, 4),
        # Graham's worst case: 2 - 1/p times the optimum, which is 3
        ([1, 1, 1, 1, 1, 1, 3], 3, AT_ONCE, 5),
        ([10] * 100, 1000, 2, 99 / 2 + 10),  # the last of 100 is sent after 99/2 s
    ],
)
def test_known_schedules(seconds, cores, rate, wall):
    assert wall_seconds(seconds, cores, rate) == wall


def test_schedule_lies_between_its_bounds():
    seconds = np.random.default_rng(1).exponential(100, 300)
    for cores in (1, 7, 50, 400):
        least = max(seconds.sum() / cores, seconds.max())
        seconds_needed = wall_seconds(seconds, cores, AT_ONCE)
        assert least * (1 - 1e-12) <= seconds_needed <= (2 - 1 / cores) * least


def test_table_says_what_limits():
    answer = wall_times([100.0] * 99 + [2000.0], (1, 100), AT_ONCE)
    assert list(answer["limit"]) == ["work", "longest job"]
    assert answer["hours"].tolist() == pytest.approx([11900 / 3600, 2000 / 3600])
    assert answer["busy"].tolist() == pytest.approx([1, 11900 / (100 * 2000)])
    assert wall_times([1.0] * 50, (1000,), rate=2)["limit"][0] == "sending"


def test_time_of_a_job_is_its_work_times_the_cost_of_its_class():
    one, other = ("scan", "event", True), ("scan", "verlet", False)
    jobs = [Job(*one, "a", 10.0), Job(*one, "b", 30.0), Job(*other, "c", 5.0)]
    timing = estimate(jobs, {"a": 20.0, "c": 50.0})
    assert job_seconds(jobs, timing) == pytest.approx([20, 60, 50])
    with pytest.raises(InputError, match=r"series by event with noise"):
        job_seconds([*jobs, Job("series", "event", True, "d", 1.0)], timing)


@pytest.fixture
def timing(tmp_path):
    """timing.csv in which each job of smoke took as many seconds as its work / 1000."""
    jobs = simulation_jobs(make_plan(load_config(ROOT / "config.yaml") | {"preset": "smoke"}))
    path = tmp_path / "timing.csv"
    estimate(jobs, {job.name: job.work / 1000 for job in jobs}).to_csv(path, index=False)
    return path, sum(job.work for job in jobs) / 1000


@pytest.mark.thorough
def test_command(timing, capsys, tmp_path):
    path, total = timing
    config = str(ROOT / "config.yaml")
    words = [str(path), "--preset", "smoke", "--cores", "1", "--config", config]
    assert main([*words, "--overhead", "0"]) == 0
    assert f"{total / 3600:.3g}" in capsys.readouterr().out.splitlines()[-1].split()
    variant = tmp_path / "variant.yaml"
    variant.write_text("presets: {smoke: {datasets: {n5_map: {replicate: {count: 3}}}}}\n")
    assert main([*words, str(variant), "--overhead", "0"]) == 0
    more = capsys.readouterr().out.splitlines()[-1].split()
    assert float(more[1]) > total / 3600
    variant.write_text(
        "presets: {smoke: {datasets: {n5_u7: {replicate: {count: 8}, more_runs: "
        "{by: 8, up_to: 24, of: disorder_parameter, half_width: 0.1}}, "
        "n5_u7_check: {more_runs: null}}}}\n"
    )
    assert main([*words, str(variant), "--overhead", "0"]) == 0
    # 5 levels of noise, one of them 0, at u = 7: two jobs in each of two rounds
    work = 5 * 1500 * 5 * 16 / 1000 / 3600
    said = capsys.readouterr().out.splitlines()[1]
    assert said == (
        f"with 4 jobs that add runs where they are needed: at most {work:.3g} core-hours, "
        "all counted here"
    )


@pytest.mark.thorough
def test_bad_input_of_the_command_is_one_line(timing, capsys, tmp_path):
    assert main([str(tmp_path / "absent.csv")]) == 1
    other = tmp_path / "other.csv"
    other.write_text("a,b\n1,2\n")
    assert main([str(other)]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2 and "absent.csv" in lines[0] and "snakemake timing" in lines[1]
