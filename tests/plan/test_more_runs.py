"""Runs added to the points of a dataset until their mean is known well enough."""

import itertools
import json
import math
import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.stats

import small_plans
from beltrepro.base.errors import InputError
from beltrepro.replication.plan import files, kinds
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.jobs import Job, draw, estimate, simulation_jobs
from beltrepro.replication.plan.more_runs import MoreRuns, half_width, rows, runs_at_places, wanted
from beltrepro.replication.plan.plan import LEAST_RUNS, MOST_ROUNDS
from beltrepro.replication.plan.points import points_in, points_of
from beltrepro.replication.plan.workflow import Workflow

SCRIPTS = Path(__file__).parents[2] / "workflow" / "scripts"
RULE = {"by": 3, "up_to": 10, "of": "disorder_parameter", "half_width": 0.01}


def planned(more_runs=RULE, **keys):
    """A plan with a dataset of two rows of four velocities, five runs at each."""
    dataset = {"belt_velocity": [5, 8, 9, 20], "noise": [0.5, 1], "points_per_job": 6}
    dataset |= {"replicate": {"start": 2, "stop": 6, "step": 1}, "initial_spread": 2}
    dataset |= {"duration": 40, "transient": 10, "more_runs": more_runs} | keys
    return small_plans.planned(dataset.pop("kind", "scan"), **dataset)


def added(plan):
    """The jobs that add runs."""
    return [batch for batch in plan.datasets["one"].batches.values() if batch.looks_at]


def script(name):
    return runpy.run_path(str(SCRIPTS / f"{name}.py"))[name]


# --- where runs are added -------------------------------------------------------------------------


def test_half_width_is_that_of_student_and_covers_what_it_says():
    random = np.random.default_rng(1)
    for size in (2, 5, 24):
        values = random.normal(size=size)
        interval = scipy.stats.t.interval(0.95, size - 1, values.mean(), scipy.stats.sem(values))
        assert half_width(values) == pytest.approx(np.ptp(interval) / 2)
    few = random.normal(size=(4000, 5))
    within = np.abs(few.mean(axis=1)) <= [half_width(values) for values in few]
    assert np.mean(within) == pytest.approx(0.95, abs=0.012)
    assert half_width(np.array([1.0])) == half_width(np.array([1, 2, np.nan])) == math.inf


def spread(width, count):
    """So many values with this half-width."""
    values = np.arange(count) * 1.0
    return values * (width / half_width(values))


@pytest.mark.parametrize(
    ("widths", "counts", "added"),
    [
        ([[0.8, 0.8, 0.8, 0.8], [0.8] * 4], [5, 5, 5, 5], [[], []]),
        # the wide one and its neighbours, in its own row
        ([[0.8, 0.8, 0.8, 1.2], [0.8] * 4], [5, 5, 5, 5], [[0, 0, 3, 3], [0] * 4]),
        ([[1.2, 0.8, 0.8, 0.8], [0.8, 0.8, 1.2, 0.8]], [5] * 4, [[3, 3, 0, 0], [0, 3, 3, 3]]),
        # up to the most: a point that has all is left as it is, whatever its neighbour
        ([[1.2] * 4, [1.2, 0.8, 0.8, 0.8]], [5, 8, 9, 10], [[3, 2, 1, 0], [3, 2, 0, 0]]),
        ([[0.8] * 4, [0.8, math.nan, 0.8, 0.8]], [5, 5, 7, 5], [[0] * 4, [3, 3, 3, 0]]),
    ],
)
def test_runs_are_added_where_the_mean_is_not_known(widths, counts, added):
    dataset = planned().datasets["one"]
    first = [point for point in dataset.points if point.replicate == 2]
    runs, values, expected = [], [], []
    grid = itertools.product((0.5, 1), enumerate((5, 8, 9, 20)))
    for place, (noise, (number, velocity)) in zip(first, grid, strict=True):
        assert (place.noise, place.belt_velocity) == (noise, velocity)
        count = counts[number]
        runs += [place._replace(replicate=run) for run in range(2, count + 2)]
        row = 0 if noise == 0.5 else 1
        values += [*spread(widths[row][number] * RULE["half_width"], count)]
        more = added[row][number] if added[row] else 0
        expected += [place._replace(replicate=count + 2 + run) for run in range(more)]
    order = np.random.default_rng(1).permutation(len(runs))
    runs, values = [runs[k] for k in order], np.array(values)[order]
    others = [point._replace(friction_ratio=0.5) for point in runs]
    rule = dataset.more_runs
    assert wanted(dataset.points, [*runs, *others], [*values, *values * 9], rule) == expected


def test_a_row_is_along_the_longest_axis_and_does_not_mix_noise_and_none():
    sigmas = {"belt_velocity": [5, 8, 9], "noise": [0, 0.5, 1, 2]}
    for keys, along, lengths in (
        ({}, "belt_velocity", [4, 4]),
        (sigmas, "noise", [1, 1, 1, 3, 3, 3]),
    ):
        dataset = planned(**keys).datasets["one"]
        assert dataset.more_runs.along == along
        cut = rows(dataset.points, along)
        assert sorted(map(len, cut)) == lengths
        assert sum(map(len, cut)) * 5 == len(dataset.points)
        for row in cut:
            values = [getattr(place, along) for place in row]
            assert values == sorted(set(values)) and {place.replicate for place in row} == {0}
            assert len({place._replace(**{along: 0}) for place in row}) == 1


@pytest.mark.thorough
def test_to_stop_when_precise_draws_no_point_to_the_branch_it_is_near():
    """Made-up falls from one branch to another: 200 studies of 11 points, 8 to 24 runs each."""
    velocity = np.arange(12.0, 23)
    share = 1 / (1 + np.exp(velocity - 17.2))
    truth = 0.13 * share + 0.013 * (1 - share)
    rule = MoreRuns(8, 24, "disorder_parameter", 0.025, "belt_velocity")
    place = planned().datasets["one"].points[0]
    places = [place._replace(belt_velocity=float(u)) for u in velocity]
    random = np.random.default_rng(1)
    misses, counts = [], []
    for _ in range(200):
        first = [point._replace(replicate=run) for point in places for run in range(1, 9)]
        more, runs, values = first, [], []
        while more:
            number = np.array([point.belt_velocity for point in more], dtype=int) - 12
            high = random.random(len(more)) < share[number]
            values += [*np.where(high, 0.13, 0.013) * random.normal(1, 0.05, len(more))]
            runs += more
            more = wanted(first, runs, values, rule)
        number = np.array([point.belt_velocity for point in runs], dtype=int) - 12
        counts.append(np.bincount(number))
        misses.append(np.bincount(number, values) / counts[-1] - truth)
    assert np.max(counts) == 24 and np.all(np.mean(counts, axis=0)[[0, -1]] < 12)
    # mean over the studies of the miss outwards, to the nearer branch, and of that along u; by the
    # width at the point alone it would be 0.0019, nine standard errors
    for weight in (np.sign(share - 0.5), np.ones(11)):
        sums = np.mean(np.array(misses) * weight, axis=1)
        assert abs(sums.mean()) < 3 * sums.std() / np.sqrt(len(sums))


# --- the plan -------------------------------------------------------------------------------------


def test_each_row_is_looked_at_once_a_round_with_all_its_runs():
    seven = {"start": 1, "stop": 7, "step": 1}
    batches = added(planned(noise=[0.5, 1, 2], replicate=seven, points_per_job=9))
    assert [batch.name for batch in batches] == ["round1_0000", "round1_0001"]
    assert [len(batch.points) for batch in batches] == [2 * 28, 28]
    unequal = {"n_blocks": [2, 3], "replicate": {2: {"count": 7}, 3: {"count": 5}}, "noise": 1}
    batches = added(planned(**unequal, points_per_job=99))
    assert [len(batch.most) for batch in batches] == [3 * 8, 2 * 8]  # as those with fewest ask
    dataset, batches = planned().datasets["one"], added(planned())
    names = ["round1_0000", "round2_0000", "round1_0001", "round2_0001"]
    assert [*dataset.batches] == [*(f"{number:04d}" for number in range(7)), *names]
    for batch in batches:
        first = [dataset.batches[name].points for name in batch.looks_at if name not in names]
        assert {*batch.points} <= {point for points in first for point in points}
        assert all({*points} & {*batch.points} for points in first)
    others = [[name for name in batch.looks_at if name in names] for batch in batches]
    assert others == [[], ["round1_0000"], [], ["round1_0001"]]
    assert [len(batch.most) for batch in batches] == [12, 8, 12, 8]


def test_first_batches_are_told_nothing_of_more_runs_and_the_whole_is():
    without, with_them = planned(None), planned()
    assert added(without) == []
    assert without.dataset_spec("one") != with_them.dataset_spec("one")
    spec, fewer = specs(with_them), specs(without)
    assert list(spec.items())[: len(fewer)] == list(fewer.items())
    digests = {files.digest(part) for part in [*spec.values(), with_them.dataset_spec("one")]}
    assert len(digests) == len(spec) + 1 and json.loads(json.dumps(spec)) == spec
    for name, value in {"by": 2, "up_to": 9, "of": "mean_length", "half_width": 0.02}.items():
        other = planned(RULE | {name: value})
        assert files.digest(other.dataset_spec("one")) not in digests
        assert files.digest(other.batch_spec("one", "round1_0000")) not in digests


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"by": 0}, "datasets.one.more_runs.by = 0: must be greater than or equal to 1"),
        ({"half_width": 0}, "half_width = 0: must be greater than 0"),
        ({"half_width": "narrow"}, "must be a number"),
        (
            {"off": "r"},
            "unknown key 'off' in datasets.one.more_runs; did you mean 'of'",
        ),
        (
            {"of": "disorder"},
            "more_runs.of = 'disorder': a dataset of kind scan has mean_length, d",
        ),
        ({"of": "section_velocity"}, "more_runs.of = 'section_velocity': a dataset of kind scan"),
        ({"up_to": 5}, "more_runs.up_to = 5: there are 5 runs at a point"),
        ({"by": 1, "up_to": 5 + MOST_ROUNDS + 1}, f"takes 21 rounds, at most {MOST_ROUNDS}"),
        ({"by": 99999, "up_to": 100000}, None),
    ],
)
def test_a_rule_that_cannot_be_meant_is_one_line(keys, words):
    if words is None:
        assert len(added(planned(RULE | keys))) == 2
        keys, words = keys | {"up_to": 10**5, "by": 10**5}, "makes 1.2e+06 points, at most 1000000"
        many = {"belt_velocity": [5, 6, 7, 8, 9, 10]}
    else:
        many = {}
    with pytest.raises(InputError) as caught:
        planned(RULE | keys, **many)
    message = str(caught.value)
    assert message.startswith("config.yaml: ") and words in message and "\n" not in message


def test_a_rule_needs_all_its_keys_a_number_and_runs_that_tell_of_their_spread():
    for name in RULE:
        with pytest.raises(InputError, match=f"more_runs.{name} is missing"):
            planned({key: value for key, value in RULE.items() if key != name})
    for count in (LEAST_RUNS - 1, LEAST_RUNS):
        keys = {"replicate": {"count": count}}
        if count < LEAST_RUNS:
            with pytest.raises(InputError, match="more_runs: 3 runs at a point, at least 4 tell"):
                planned(**keys)
        else:
            planned(**keys)
    slips = {"kind": "catalogue", "duration": 50}
    with pytest.raises(InputError, match="kind catalogue has no such number"):
        planned(**slips)


def test_time_is_estimated_with_all_that_can_be_added():
    jobs = simulation_jobs(planned())
    first = [job for job in jobs if not job.adds]
    assert sum(job.work for job in first) == 40 * 2 * 40
    assert sum(job.work for job in jobs) == 40 * 2 * 80
    assert {job.adds for job in draw(first, seed=1)} == {False}
    row = estimate(jobs, {job.name: 3.6 * job.work for job in first[:2]}).iloc[0]
    assert (row["jobs"], row["jobs_run"]) == (len(first), 2)
    assert row["hours"] == pytest.approx(3.2) and row["hours_at_most"] == pytest.approx(6.4)
    table = estimate([Job("scan", "event", True, "a", 1.0)], {"a": 3600.0})
    assert table["hours_at_most"].tolist() == [1, 1]


def test_the_crate_says_what_added_runs_are_made_from():
    paper = Workflow(load_config(SCRIPTS.parents[1] / "config.yaml") | {"preset": "paper"})
    sources = {output: inputs for _, _, inputs, outputs in paper.records() for output in outputs}
    at, (first, second) = "<results>/batches/n5_replicates_wide", ("round1_0000", "round2_0000")
    assert sources[f"{at}/{second}.h5"] == [*sources[f"{at}/{first}.h5"], f"{at}/{first}.h5"]
    whole = sources["<results>/datasets/n5_replicates_wide.h5"]
    assert whole == [*sources[f"{at}/{second}.h5"], f"{at}/{second}.h5"]
    assert whole == paper.batches(SimpleNamespace(dataset="n5_replicates_wide"))


# --- the same bits --------------------------------------------------------------------------------


def specs(plan):
    return {name: plan.batch_spec("one", name) for name in plan.datasets["one"].batches}


def made(plan, folder):
    """A dataset of a plan, simulated batch by batch by the scripts of the workflow."""
    spec = specs(plan)
    paths = {name: folder / f"{name}.h5" for name in spec}
    expected = {name: files.expected(part) for name, part in spec.items()}
    for name, part in spec.items():
        if sources := plan.datasets["one"].batches[name].looks_at:
            script("add_runs")(
                part, [paths[k] for k in sources], [expected[k] for k in sources], paths[name]
            )
        else:
            script("simulate")(part, paths[name], progress=lambda share: None)
    whole = folder / "one.h5"
    script("join")(list(paths.values()), list(expected.values()), plan.dataset_spec("one"), whole)
    parts = {name: files.read(path, expected[name]).arrays for name, path in paths.items()}
    return files.read(whole, files.expected(plan.dataset_spec("one"))), parts


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore:.*repeat another")
def test_added_runs_have_the_bits_of_runs_that_were_planned(tmp_path):
    for name in ("grown", "few", "all"):
        (tmp_path / name).mkdir()
    # of the first runs one point is wide and seven are not
    few, _ = made(planned(None), tmp_path / "few")
    runs = few.arrays["disorder_parameter"].reshape(2, 4, 5)
    widths = np.sort([half_width(values) for values in runs.reshape(8, 5)])
    limit = (widths[-1] + widths[-2]) / 2
    grown, parts = made(planned(RULE | {"half_width": limit}), tmp_path / "grown")
    everything, _ = made(
        planned(None, replicate={"start": 2, "stop": 11, "step": 1}), tmp_path / "all"
    )
    for name, values in few.arrays.items():
        np.testing.assert_array_equal(grown.arrays[name][: len(values)], values)
    place = {point: row for row, point in enumerate(points_in(everything.arrays))}
    points = points_in(grown.arrays)
    assert len(set(points)) == len(points) and 40 < len(points) < 80
    at = [place[point] for point in points]
    for name, values in everything.arrays.items():
        np.testing.assert_array_equal(grown.arrays[name], values[at])
    assert {len(arrays["noise"]) for arrays in parts.values()} >= {0, 6}
    assert sum(len(arrays["noise"]) for arrays in parts.values()) == len(points)
    spec = runs_at_places(points)
    assert spec.startswith("5 runs at ") and " runs at " in spec[12:]
    # nothing that is wide is left but where the most runs are
    left = wanted(
        points_of(planned().batch_spec("one", "round1_0000")["points"]),
        points,
        grown.arrays["disorder_parameter"],
        MoreRuns(**RULE | {"half_width": limit}, along="belt_velocity"),
    )
    assert left == []


def test_of_each_kind_a_dataset_without_a_point_can_be_joined():
    for kind in kinds.KINDS.values():
        arrays = {
            name: np.zeros(2, [("point", "i4"), ("time", float)])
            if array.fields
            else np.ones([{"point": 3}.get(axis, 2) for axis in array.dimensions])
            for name, array in kind.arrays.items()
        }
        empty = files.without_points(arrays, kind.arrays)
        parts = [files.store.Dataset(part, {}) for part in (empty, arrays, empty)]
        for name, values in files.join(parts, kind.arrays).items():
            assert values.shape == arrays[name].shape
