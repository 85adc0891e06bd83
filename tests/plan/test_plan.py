"""The plan made from config.yaml: layers, points, batches, films, and what jobs are told."""

import copy
from pathlib import Path

import pytest

import small_plans
from beltrepro.base.errors import InputError
from beltrepro.model import ChainParameters
from beltrepro.model.units import TIME_S, UNIT_OF, VELOCITY_M_S
from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import DEFAULTS
from beltrepro.simulation.setup import Setup

CONFIG = load_config(Path(__file__).parents[2] / "config.yaml")


def changed(*changes):
    """The project's configuration with values changed: pairs of a path and a value."""
    result = copy.deepcopy(CONFIG)
    for path, value in zip(changes[::2], changes[1::2], strict=True):
        *parents, last = path.split(".")
        section = result
        for key in parents:
            section = section.setdefault(key, {})
        section[last] = value
    return result


def planned(name, *changes, preset="standard"):
    """One dataset of a preset, after changes."""
    return make_plan(changed("preset", preset, *changes)).datasets[name]


def single(**keys):
    """A dataset, one point unless the keys say otherwise."""
    return small_plans.planned(**{"n_blocks": 5} | keys).datasets["one"]


@pytest.fixture(scope="module", params=sorted(CONFIG["presets"]))
def plan(request):
    return make_plan(changed("preset", request.param))


# --- points ---------------------------------------------------------------------------------------


def test_grids():
    def values(grid):
        return single(belt_velocity=grid).values()["belt_velocity"]

    fine = values({"start": 0.2, "stop": 50, "step": 0.2})
    coarse = values({"start": 0.5, "stop": 50, "step": 0.5})
    assert set(range(1, 51)) <= set(fine) & set(coarse), "equal points have equal bits"
    assert (fine[0], fine[-1], len(fine)) == (0.2, 50, 250)
    assert values({"start": 1, "stop": 2, "step": 0.3}) == [1, 1.3, 1.6, 1.9]
    assert values([3, 1]) == values({5: [3, 1], 6: 2}) == [1, 3]


def test_defaults_are_those_of_the_library():
    (case,) = Setup([ChainParameters(n_blocks=2, belt_velocity=10)]).cases
    for name, default in DEFAULTS.items():
        parts = [part for part in (case, case.parameters, case.state) if hasattr(part, name)]
        assert {getattr(part, name) for part in parts} == {default}, name


@pytest.mark.parametrize("kind", ["scan", "escapes", "motion", "settling"])
def test_units_of_results_are_those_of_datasets(kind):
    for name, array in KINDS[kind].arrays.items():
        assert not array.unit or UNIT_OF.get(name, "1") == array.unit, name


def test_the_last_quantity_varies_fastest():
    axes = {"seed": [1, 2], "noise": [0, 1], "belt_velocity": [5, 6], "replicate": {"count": 3}}
    points_made = single(**axes).points
    rows = [(p.noise, p.belt_velocity, p.seed, p.replicate) for p in points_made]
    assert rows == sorted(rows) and len(set(rows)) == 24
    seeds = [single(**keys).points[0].seed for keys in ({}, {"seed": {"offset": 2}}, {"seed": 9})]
    assert seeds == [3, 5, 9]  # the first two count on that of the top level


# --- batches --------------------------------------------------------------------------------------


def test_batches_hold_every_point_once_in_order(plan):
    for dataset in plan.datasets.values():
        batches = [*dataset.batches.values()]
        assert sum(batches, ()) == dataset.points
        assert len(set(dataset.points)) == len(dataset.points)
        assert all(len(batch) <= dataset.points_per_job for batch in batches)


def test_further_points_follow_those_of_the_axes():
    more = {"belt_velocity": 2, "replicate": {"start": 2, "stop": 3, "step": 1}}
    points = single(belt_velocity=[1, 2], noise=1, replicate=1, also=more).points
    assert [(p.belt_velocity, p.replicate) for p in points] == [(1, 1), (2, 1), (2, 2), (2, 3)]
    with pytest.raises(InputError, match="also: gives points that the dataset has without it"):
        single(belt_velocity=[1, 2], noise=1, replicate=1, also={"belt_velocity": 2})


# --- methods --------------------------------------------------------------------------------------


def test_method_of_all_datasets_in_one_line_but_for_pairs_of_methods():
    datasets_made = make_plan(changed("method", "event")).datasets
    methods = {name: dataset.values()["method"] for name, dataset in datasets_made.items()}
    assert methods.pop("pairs_r_verlet") == ["verlet"]
    assert {name for name, used in methods.items() if used != ["event"]} == {
        "disturbances_scheme",
        "pairs_paths_verlet",
        "pairs_slips_verlet",
        "pairs_states_verlet",
        "survival_scheme",
    }
    scheme = make_plan(changed("method", "verlet")).datasets
    assert {point.method for point in scheme["n5_rows"].points} == {"verlet"}
    assert {point.method for point in scheme["motion_map"].points} == {"event"}


def test_the_method_may_be_that_of_the_noise():
    by_noise = {"without_noise": "verlet", "with_noise": "event"}
    points = single(noise=[0, 1e-3, 1], method=by_noise).points
    assert [point.method for point in points] == ["verlet", "event", "event"]


# --- layers ---------------------------------------------------------------------------------------


def test_a_dataset_stands_over_defaults_and_a_preset_over_the_top_level():
    assert planned("n5_rows").settings["duration"] == 20000
    assert planned("u20").settings["transient"] == 0
    changes = ("defaults.laminar_time", 150, "presets.standard.defaults.laminar_time", 170)
    assert planned("n5_map", *changes).settings["laminar_time"] == 170
    assert planned("n5_map", *changes, preset="paper").settings["laminar_time"] == 150
    over = (*changes, "presets.standard.datasets.n5_map.laminar_time", 190)
    assert planned("n5_map", *over).settings["laminar_time"] == 190


@pytest.mark.thorough
def test_a_variant_gives_only_what_it_changes():
    variant = {"based_on": "standard", "defaults": {"friction_ratio": 0.4}}
    changes = ("presets.f04", variant, "presets.f05.based_on", "f04", "presets.f05.defaults", {})
    standard = make_plan(changed()).datasets
    for preset in ("f04", "f05"):
        result = make_plan(changed("preset", preset, *changes))
        assert (result.run, result.defaults["friction_ratio"]) == (preset, 0.4)
        assert list(result.datasets) == list(standard)
        ours, theirs = result.datasets["size_rows"], standard["size_rows"]
        assert ours.points == tuple(point._replace(friction_ratio=0.4) for point in theirs.points)
        axis = result.datasets["trials_free"].values()["friction_ratio"]
        assert axis == standard["trials_free"].values()["friction_ratio"]


# --- the grids of the paper -----------------------------------------------------------------------


def test_paper_grids_are_those_of_the_paper():
    paper = make_plan(changed("preset", "paper")).datasets
    counts = {"n5_map": 100 * 21, "n5_rows": 100 * 2, "size_rows": 6 * 50}
    counts |= {"n5_density": 1000 * 5, "lifetimes": 35 * 1000}
    for name, count in counts.items():
        assert len(paper[name].points) == count
    rows = paper["n5_rows"]
    assert (rows.settings["duration"], rows.settings["transient"]) == (2e6, 1e6)  # of Fig. 12
    assert rows.values()["time_step"] == [0.001]
    # Runs with replicates, each shorter than the paper's one: together at least as long.
    for name, count in {"n5_u7": 41, "n5_columns": 6 * 21, "size_columns": 4 * 21}.items():
        settings = paper[name].settings
        assert len(paper[name].points) == 8 * count
        assert 8 * (settings["duration"] - settings["transient"]) >= 1e6


def test_recordings_have_the_speeds_and_the_frames_of_the_paper(plan):
    speeds = {"belt_022": (0.22, 1.0), "belt_028": (0.28, 1.0), "belt_035": (0.35, 2.2)}
    for name, (speed, noise) in speeds.items():
        dataset = plan.datasets[name]
        (point,) = dataset.points
        assert point.belt_velocity * VELOCITY_M_S == pytest.approx(speed, rel=1e-8)
        assert (point.n_blocks, point.noise, point.initial_spread) == (5, noise, 0)
        frames = dataset.settings["sample_interval"] * TIME_S * 24
        assert frames == pytest.approx(1, rel=1e-9)
        assert dataset.settings["transient"] * TIME_S >= 200
        kept = (dataset.settings["duration"] - dataset.settings["transient"]) * TIME_S
        assert kept >= {"smoke": 60, "standard": 300, "paper": 1000}[plan.preset]


@pytest.mark.parametrize(
    ("keys", "axis", "kept"),
    [
        ({"noise": {"start": 0, "stop": 6, "step": 1}}, "noise", [0, 3, 6]),
        ({"noise": {2: {"start": 0, "stop": 6, "step": 1}}}, "noise", [0, 3, 6]),
        ({"seed": [1, 2, 3, 4]}, "seed", [1, 2, 3, 4]),
        ({"replicate": {"count": 9}}, "replicate", [0, 1, 2]),
        ({"replicate": {"start": 1, "stop": 4, "step": 1}}, "replicate", [1, 2]),
        ({"replicate": 1, "also": {"replicate": {"start": 2, "stop": 9, "step": 1}}},
         "replicate", [1, 2, 3]),
    ],
)  # fmt: skip
def test_a_thinner_preset_has_a_part_of_the_points(keys, axis, kept):
    whole = small_plans.configuration(**{"noise": 1} | keys)
    thin = {"values": 3, "replicates": 4, "duration": 80, "transient": 90}
    presets = {"thin": {"based_on": "own", "thin": thin}, "more": {"based_on": "thin"}}
    presets["more"]["datasets"] = {"one": {axis: [7, 8, 9, 10]}}
    whole["presets"] |= presets
    thin_plan = make_plan(whole | {"defaults": {"rest_length": 50}, "preset": "thin"})
    assert thin_plan.defaults["rest_length"] == 50
    thinner = thin_plan.datasets["one"]
    assert thinner.values()[axis] == kept
    assert set(thinner.points) <= set(make_plan(whole).datasets["one"].points)
    assert (thinner.settings["duration"], thinner.settings["transient"]) == (80, 50)
    if "also" not in keys:
        more = make_plan(whole | {"preset": "more"}).datasets["one"]
        assert more.values()[axis] == [7, 8, 9, 10]
