"""The plan made from config.yaml: points, batches, and one clear line for whatever is wrong."""

import copy
import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from beltrepro.base.errors import InputError
from beltrepro.model.units import TIME_S, VELOCITY_M_S
from beltrepro.replication.camera.scene import Camera
from beltrepro.replication.plan import checking, grids, schema
from beltrepro.replication.plan.films import CAMERA
from beltrepro.replication.plan.kinds import KINDS, MAXIMUM_SCAN_BLOCKS, SETTINGS
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import Point, columns, plain, points_of
from beltrepro.replication.plan.quantities import QUANTITIES

ROOT = Path(__file__).parents[2]
CONFIG = checking.load(ROOT / "config.yaml")
SCHEMA = schema.config_schema()
SCANS = {
    "n5_map": 100 * 21,
    "n5_rows": 100 * 5,
    "size_rows": 6 * 50 * 3,
}
# Runs with replicates, each shorter than the paper's one: together they are at least as long.
REPLICATED = {"n5_u7": 41, "n5_columns": 6 * 21, "size_columns": 4 * 21}


def changed(*changes):
    """The project's config with values changed: pairs of a path and a value; None removes."""
    result = copy.deepcopy(CONFIG)
    for path, value in zip(changes[::2], changes[1::2], strict=True):
        *parents, last = path.split(".")
        section = result
        for key in parents:
            section = section.setdefault(key, {})
        if value is None:
            del section[last]
        else:
            section[last] = value
    return result


def planned(name, *changes, preset="standard"):
    """One dataset of a preset, after changes."""
    return make_plan(changed("preset", preset, *changes)).datasets[name]


def single(name, values):
    """Config with one dataset of a made-up preset, one point unless `values` say otherwise."""
    point = {"kind": "scan", "n_blocks": 5, "belt_velocity": 10}
    defaults = {"duration": 100, "transient": 50}
    made_up = {"defaults": defaults, "datasets": {name: point | values}}
    return {"preset": "own", "seed": 3, "datasets": {}, "presets": {"own": made_up}}


def points(**values):
    return make_plan(single("one", values)).datasets["one"].points


def complaint(configuration) -> str:
    with pytest.raises(InputError) as caught:
        make_plan(configuration)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith("config.yaml: ")
    return message


@pytest.fixture(scope="module", params=sorted(CONFIG["presets"]))
def plan(request):
    return make_plan(changed("preset", request.param))


# --- what the plan holds ---


def test_standard_is_the_default():
    assert CONFIG["preset"] == "standard"


def test_paper_grids_are_those_of_the_paper():
    paper = make_plan(changed("preset", "paper")).datasets
    for name, count in SCANS.items():
        assert len(paper[name].points) == count
    rows = paper["n5_rows"].settings
    assert (rows["duration"], rows["transient"]) == (2e6, 1e6)  # of Fig. 12
    for name, count in REPLICATED.items():
        settings = paper[name].settings
        assert len(paper[name].points) == 8 * count
        assert 8 * (settings["duration"] - settings["transient"]) >= 1e6
    assert {point.time_step for each in SCANS for point in paper[each].points} == {0.001}
    assert len(paper["lifetimes"].points) == 35 * 1000


@pytest.mark.thorough
def test_points_are_sorted_by_size_noise_velocity(plan):
    for name in SCANS:
        found = plan.datasets[name].points
        assert list(found) == sorted(found, key=lambda p: (p.n_blocks, p.noise, p.belt_velocity))


@pytest.mark.thorough
def test_points_of_every_dataset_differ(plan):
    for dataset in plan.datasets.values():
        assert len(set(dataset.points)) == len(dataset.points)


def test_batches_hold_every_point_once_in_order(plan):
    for dataset in plan.datasets.values():
        assert sum(dataset.batches, ()) == dataset.points
        assert all(len(batch) <= dataset.points_per_job for batch in dataset.batches)
        for batch in dataset.batches:
            assert len({(point.method, point.noise > 0) for point in batch}) == 1


def test_equal_points_of_different_grids_have_equal_bits():
    fine = grids.values({"start": 0.2, "stop": 50, "step": 0.2}, "fine", InputError)
    coarse = grids.values({"start": 0.5, "stop": 50, "step": 0.5}, "coarse", InputError)
    assert set(range(1, 51)) <= set(fine) & set(coarse)
    assert (fine[0], fine[-1], len(fine)) == (0.2, 50, 250)


def test_grid_ends_at_the_last_step_before_stop():
    grid = {"start": 1, "stop": 2, "step": 0.3}
    assert grids.values(grid, "", InputError) == (1, 1.3, 1.6, 1.9)
    assert grids.values(7, "", InputError) == (7,)
    assert grids.values([3, None, 1], "", InputError) == (None, 1, 3)


AXES = {
    "n_blocks": [2, 8],
    "static_friction": [70, 72],
    "friction_ratio": {"start": 0.1, "stop": 0.9, "step": 0.4},
    "rest_length": [40, 50],
    "linear_limit": [10, 20],
    "compression_rate": [0.1, 0.2],
    "extension_rate": [0.01, 0.02],
    "noise": [0, 1],
    "belt_velocity": [5, 7.5],
    "initial_spread": [0, 0.1],
    "method": ["event", "verlet"],
    "time_step": [0.001, 0.002],
    "tolerance": [None, 1e-6],
    "kick": [0, 0.1],
    "seed": [1, 2],
    "replicate": [0, 4],
}


def test_any_quantity_can_be_an_axis():
    assert set(AXES) == set(QUANTITIES)
    for name, grid in AXES.items():
        exact = {"kind": "settling", "method": "event"} if name in ("kick", "tolerance") else {}
        found = points(**{name: grid}, **exact)
        expected = [0.1, 0.5, 0.9] if name == "friction_ratio" else grid
        assert [getattr(point, name) for point in found] == expected, name


def test_the_last_quantity_varies_fastest():
    found = points(seed=[1, 2], noise=[0, 1], belt_velocity=[5, 6], replicate={"count": 2})
    rows = [(point.noise, point.belt_velocity, point.seed, point.replicate) for point in found]
    assert rows == sorted(rows) and len(rows) == 16


def test_a_grid_may_differ_with_the_number_of_blocks():
    found = points(n_blocks=[6, 5], belt_velocity={5: 18, 6: [26, 27]})
    assert [(p.n_blocks, p.belt_velocity) for p in found] == [(5, 18), (6, 26), (6, 27)]


def test_seed_counts_on_that_of_the_top_level():
    assert [point.seed for point in points()] == [3]
    assert [point.seed for point in points(seed={"offset": 2})] == [5]
    assert [point.seed for point in points(seed=9)] == [9]


def test_second_side_of_pairs_has_another_seed_but_paths_share_theirs(plan):
    def seeds(name):
        return plan.datasets[name].values()["seed"]

    for part in ("r", "slips", "states"):
        assert seeds(f"pairs_{part}_verlet") == [1] and seeds(f"pairs_{part}_event") == [2]
    assert seeds("pairs_paths_verlet") == seeds("pairs_paths_event") == [1]


def test_both_sides_of_pairs_have_the_same_chains(plan):
    names = ("n_blocks", "belt_velocity", "noise", "initial_spread", "replicate")
    for part in ("paths", "r", "slips", "states"):
        ours, theirs = (plan.datasets[f"pairs_{part}_{m}"].values() for m in ("verlet", "event"))
        assert [ours[name] for name in names] == [theirs[name] for name in names]


def test_columns_and_plain_values_keep_the_points():
    found = points(tolerance=[None, 1e-6], method="event", replicate={"count": 2})
    assert points_of(json.loads(json.dumps(plain(found)))) == list(found)
    table = columns(found)
    assert set(table) == set(QUANTITIES)
    np.testing.assert_array_equal(table["tolerance"], [np.nan, np.nan, 1e-6, 1e-6])
    assert table["n_blocks"].dtype == np.int64 and table["method"].tolist() == ["event"] * 4


# --- methods ---


@pytest.mark.parametrize("method", ["verlet", "event"])
def test_any_method_can_be_asked_of_all(method):
    found = make_plan(changed("method", method)).datasets
    assert {point.method for point in found["n5_rows"].points} == {method}
    assert {point.method for point in found["motion_map"].points} == {"event"}


def test_method_of_all_datasets_in_one_line_but_for_pairs_of_methods():
    found = make_plan(changed("method", "event")).datasets
    methods = {name: each.values()["method"] for name, each in found.items()}
    assert methods.pop("pairs_r_verlet") == ["verlet"]
    assert {name for name, used in methods.items() if used != ["event"]} == {
        "pairs_paths_verlet",
        "pairs_slips_verlet",
        "pairs_states_verlet",
        "growth",
        "steps",
    }


def test_method_may_differ_without_and_with_noise():
    dataset = planned("n5_rows")
    assert {(point.method, point.noise > 0) for point in dataset.points} == {
        ("verlet", False),
        ("event", True),
    }


# --- layers ---


@pytest.mark.thorough
def test_a_dataset_stands_over_defaults_and_a_preset_over_the_top_level():
    assert planned("n5_map").settings["duration"] == 16000
    assert planned("n5_rows").settings["duration"] == 20000
    assert planned("u20").settings["transient"] == 0
    changes = ("defaults.laminar_time", 150, "presets.standard.defaults.laminar_time", 170)
    assert planned("n5_map", *changes).settings["laminar_time"] == 170
    assert planned("n5_map", *changes, preset="smoke").settings["laminar_time"] == 150
    over = (*changes, "presets.standard.datasets.n5_map.laminar_time", 190)
    assert planned("n5_map", *over).settings["laminar_time"] == 190


@pytest.mark.thorough
def test_a_variant_gives_only_what_it_changes():
    variant = {"based_on": "standard", "defaults": {"friction_ratio": 0.4}}
    changes = ("presets.f04", variant, "presets.f05.based_on", "f04", "presets.f05.defaults", {})
    standard = make_plan(changed()).datasets
    for preset in ("f04", "f05"):
        found = make_plan(changed("preset", preset, *changes))
        assert (found.run, found.model["friction_ratio"]) == (preset, 0.4)
        assert list(found.datasets) == list(standard)
        ours, theirs = found.datasets["size_rows"], standard["size_rows"]
        assert ours.points == tuple(point._replace(friction_ratio=0.4) for point in theirs.points)
        axis = found.datasets["friction_ratio"].values()["friction_ratio"]
        assert axis == standard["friction_ratio"].values()["friction_ratio"]


@pytest.mark.thorough
def test_constants_of_the_model_reach_every_dataset(plan):
    found = make_plan(changed("preset", plan.preset, "model.rest_length", 55)).datasets
    assert {point.rest_length for each in found.values() for point in each.points} == {55.0}


@pytest.mark.thorough
def test_a_run_has_a_name():
    assert make_plan(changed()).run == "standard"
    assert make_plan(changed("run", "f06")).run == "f06"
    assert make_plan(changed("run", 6)).run == "6"
    assert make_plan(changed("run", "standard")).run == "standard"


def test_numbers_that_yaml_reads_as_text_are_numbers():
    assert (
        planned("n5_rows", "presets.standard.defaults.duration", "2e6").settings["duration"] == 2e6
    )


def test_settings_are_plain_values(plan):
    json.dumps(plan.settings())
    for name, dataset in plan.datasets.items():
        told = plan.told_batch(name, len(dataset.batches) - 1)
        assert json.loads(json.dumps(told)) == told


# --- the schema ---


def test_schema_for_editors_is_the_one_that_checks():
    kept = (ROOT / "workflow" / "schemas" / "config.schema.yaml").read_text(encoding="utf-8")
    assert kept == schema.as_yaml(), "run `make schema`"


def test_every_key_of_the_schema_is_described_and_no_other_allowed():
    described = set(SCHEMA["$defs"])
    objects = []

    def walk(node, path):
        if isinstance(node, list):
            for index, child in enumerate(node):
                walk(child, f"{path}[{index}]")
        if not isinstance(node, dict):
            return
        for key, child in node.get("properties", {}).items():
            target = child.get("$ref", "").removeprefix("#/$defs/")
            assert "description" in child or target in described, f"{path}.{key}"
        if node.get("type") == "object" and "properties" in node:
            objects.append(path)
            assert node["additionalProperties"] is False, path
        for key, child in node.items():
            walk(child, f"{path}.{key}")

    walk(SCHEMA, "config")
    assert len(objects) > 8
    assert all("description" in each for each in SCHEMA["$defs"].values())


def test_schema_names_every_quantity_and_setting():
    known = set(SCHEMA["$defs"]["dataset"]["properties"])
    assert set(QUANTITIES) | set(SETTINGS) < known
    assert known - set(QUANTITIES) - set(SETTINGS) == {
        "kind",
        "like",
        "own_method",
        "points_per_job",
    }


def test_a_point_has_a_value_of_each_quantity():
    assert Point._fields == tuple(QUANTITIES)


def test_scans_take_as_many_blocks_as_the_simulation():
    from beltrepro.simulation import scans

    assert MAXIMUM_SCAN_BLOCKS == scans.MAXIMUM_BLOCKS


# --- what it refuses ---

DATASET = "presets.standard.datasets.n5_map"


@pytest.mark.parametrize(
    ("path", "where"),
    [
        ("presett", ""),
        ("model.static_fricton", "model"),
        ("defaults.time_stp", "defaults"),
        ("datasets.n5_map.knd", "datasets.n5_map"),
        ("presets.standard.default", "presets.standard"),
        ("presets.standard.defaults.transiet", "presets.standard.defaults"),
        (f"{DATASET}.belt_velocty", DATASET),
        ("presets.smoke.datasets.n5_map.noise.stpe", "presets.smoke.datasets.n5_map.noise"),
        ("presets.paper.datasets.u1.durration", "presets.paper.datasets.u1"),
        ("datasets.pairs_r_event.seed.ofset", "datasets.pairs_r_event.seed"),
    ],
)
def test_misspelt_key_is_refused_at_every_level(path, where):
    message = complaint(changed(path, 1))
    assert f"unknown key {path.rsplit('.', 1)[-1]!r}" in message
    assert "did you mean" in message
    assert (f" in {where};" in message) == bool(where)


def test_the_line_for_a_misspelt_key():
    assert complaint(changed(f"{DATASET}.belt_velocty", 3)) == (
        "config.yaml: unknown key 'belt_velocty' in presets.standard.datasets.n5_map; "
        "did you mean 'belt_velocity'?"
    )


def test_unknown_key_without_a_near_one_gets_no_suggestion():
    assert complaint(changed("foo", 1)) == "config.yaml: unknown key 'foo'"


def test_unknown_preset_suggests_the_nearest():
    message = complaint(changed("preset", "smok"))
    assert "smoke, standard, paper" in message
    assert message.endswith("did you mean 'smoke'?")


def test_a_setting_of_another_kind_is_refused():
    assert complaint(changed("datasets.u1.section_values", 3)) == (
        "config.yaml: datasets.u1.section_values: a dataset of kind series has no such setting, "
        "only duration, transient, sample_interval, samples"
    )


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("seed", -1, "seed = -1: must be at least 0"),
        ("method", "verlett", "did you mean 'verlet'"),
        ("run", "smoke", "run = 'smoke': is the name of another preset"),
        ("run", "r" * 101, "run has 101 characters: allowed are 100"),
        ("run", "../f06", "must begin with a letter or digit"),
        ("run", "a b", "must begin with a letter or digit"),
        ("model.friction_ratio", 1.5, "must be less than 1"),
        ("defaults.time_step", 0, "must be at least 1e-09"),
        ("datasets.n5_map.kind", "scam", "did you mean 'scan'"),
        ("datasets.n5_map.kind", None, "n5_map of preset smoke has no kind"),
        ("datasets.n5_map.n_blocks", None, "n5_map of preset smoke has no n_blocks"),
        ("datasets.n5_map.method", {"without_noise": "event"}, "method.with_noise is missing"),
        ("datasets.n5_rows_check.like", "n5_row", "did you mean 'n5_rows'"),
        ("datasets.n5_rows.like", "n5_rows_check", "a dataset cannot be like itself"),
        ("datasets.lifetimes.tolerance", "small", "must be a number or null"),
        ("datasets.lifetimes.kick", 0.1, "kick = 0.1: kind escapes has none"),
        ("datasets.u1.tolerance", 1e-6, "u1.tolerance = 1e-06: method verlet has none, only event"),
        ("datasets.u17.friction_ratio", 0.9, "u17.noise = 2.2: with friction_ratio = 0.9 and"),
        ("datasets.u1.sample_interval", 0.0015, "0.0015: method verlet needs a multiple of time_"),
        ("presets.smoke.based_on", "standart", "did you mean 'standard'"),
        ("presets.smoke.based_on", "smoke", "smoke is based on smoke"),
        (f"{DATASET}.belt_velocity", -2, "must be greater than 0"),
        (f"{DATASET}.belt_velocity", [3, -2], "belt_velocity[1] = -2"),
        (f"{DATASET}.n_blocks", 0, "n_blocks = 0: must be at least 1"),
        (f"{DATASET}.n_blocks", 2.5, "must be a whole number"),
        (f"{DATASET}.n_blocks", 12, "n5_map.n_blocks = 12: a scan takes at most 10 blocks"),
        (f"{DATASET}.noise", [], "is empty"),
        (f"{DATASET}.noise", [1, 1], "occurs twice"),
        (f"{DATASET}.noise", "much", "must be a number"),
        (f"{DATASET}.noise", float("nan"), "a finite number is needed"),
        (f"{DATASET}.noise.step", 0, "must be greater than 0"),
        (f"{DATASET}.noise.step", 1e-9, "at most 100000"),
        ("camera.width", 641, "camera.width = 641: must be a multiple of 2"),
        ("camera.blur", -1, "camera.blur = -1: must be at least 0"),
        ("camera.compression", 52, "camera.compression = 52: must be at most 51"),
        ("camera.exposure", 0.05, "films.belt_022: exposure = 0.05: must be at most 0.04167"),
        ("camera.colour", "red", "unknown key 'colour' in camera"),
        ("films.belt_028.of", "belt_29", "films.belt_028.of = 'belt_29': preset smoke has no such"),
        (
            "films.belt_028.of",
            "n5_u7",
            "films.belt_028.of = 'n5_u7': must be a series of one point",
        ),
        (
            "films.belt_028.of",
            "u17",
            "its sample_interval is 0.1, 24 frames a second need 0.5448376",
        ),
        ("films.belt_028.seconds", 0, "films.belt_028.seconds = 0: must be greater than 0"),
        ("films.belt_028.of", None, "films.belt_028.of is missing"),
        ("datasets.belt_022.samples", ["positions"], "its samples lack velocities"),
        ("datasets.a_track", {"like": "u1"}, "only films have names that end in _film or _track"),
        (f"{DATASET}.noise.start", 11, "must not be less than start = 11"),
        (f"{DATASET}.noise.stop", None, "noise.stop is missing"),
        (f"{DATASET}.transient", 1e9, "n5_map.transient = 1e+09: must be less"),
        ("presets.standard.datasets.size_columns.n_blocks", [5, 6, 7], "entry for n_blocks = 10"),
        ("presets.standard.datasets.size_columns.n_blocks", [4, 5], "no entry for n_blocks = 4"),
        ("presets.standard.defaults.transient", 50000, "must be less than duration = 20000"),
        ("presets.standard.datasets.slips_u1.section_block", 6, "the chain has 5 blocks"),
        ("datasets.slips_u1.section_position", None, "only for the last block there is a rule"),
        ("presets.standard.datasets.lifetimes.settle_time", 1e9, "must be less than duration"),
    ],
)
def test_bad_value_is_refused(path, value, words):
    assert words in complaint(changed(path, value))


def test_any_number_of_blocks_has_a_section():
    dataset = planned("n5_map", f"{DATASET}.n_blocks", 8)
    assert dataset.settings["section_position"] is None
    assert all(kind.complaint for kind in KINDS.values())


def test_files_that_cannot_be_read_are_one_line(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        checking.load(tmp_path / "missing.yaml")
    broken = tmp_path / "broken.yaml"
    broken.write_text("a: [1,\nb: {")
    with pytest.raises(InputError, match="not YAML") as caught:
        checking.load(broken)
    assert "\n" not in str(caught.value)
    broken.write_text("just text")
    with pytest.raises(InputError, match="must be a mapping"):
        checking.load(broken)


# --- films ---


def test_camera_of_the_configuration_is_that_of_the_package():
    fields = {each.name: each.default for each in dataclasses.fields(Camera)}
    assert {name: each.default for name, each in CAMERA.items()} | {"seed": 1} == fields
    for name, each in CAMERA.items():
        for key, beyond in (("minimum", -1), ("maximum", 1)):
            if key in each.schema and name != "exposure":
                whole = each.schema.get("multipleOf", 1)
                Camera(**{name: each.schema[key]})
                with pytest.raises(InputError, match=name):
                    Camera(**{name: each.schema[key] + beyond * whole})


def test_recordings_have_the_speeds_and_the_frames_of_the_paper(plan):
    speeds = {"belt_022": (0.22, 1.0), "belt_028": (0.28, 1.0), "belt_035": (0.35, 2.2)}
    for name, (speed, noise) in speeds.items():
        dataset = plan.datasets[plan.films[name].dataset]
        (point,) = dataset.points
        assert point.belt_velocity * VELOCITY_M_S == pytest.approx(speed, rel=1e-8)
        assert (point.n_blocks, point.noise, point.initial_spread) == (5, noise, 0)
        frames = dataset.settings["sample_interval"] * TIME_S * 24
        assert frames == pytest.approx(1, rel=1e-9)
        assert dataset.settings["transient"] * TIME_S >= 200
        kept = (dataset.settings["duration"] - dataset.settings["transient"]) * TIME_S
        ours = name == "belt_035" and plan.preset == "standard"  # no speed of the experiment
        assert kept >= (60 if plan.preset == "smoke" else 300 if ours else 1000)


def test_a_film_has_the_camera_of_all_but_for_what_it_gives(plan):
    whole, stage = plan.films["belt_028"], plan.films["stage_lens"]
    assert whole.camera["blur"] == stage.camera["blur"] == CONFIG["camera"]["blur"]
    assert whole.camera["compression"] == CONFIG["camera"]["compression"] > 0
    assert stage.camera["compression"] == stage.camera["sensor_noise"] == 0
    assert (whole.frames, stage.frames) == (None, 720)
    assert stage.told() == {"film": "stage_lens", "frames": 720, "camera": stage.camera}
    assert stage.camera["seed"] == plan.seed


@pytest.mark.thorough
@pytest.mark.parametrize("preset", ["smoke", "standard", "paper"])
def test_free_trials_include_the_printed_constants(preset):
    """Their posterior is compared with trials at the printed friction ratio and speeds."""
    values = make_plan(changed("preset", preset)).datasets["trials_free"].values()
    assert 0.45 in values["friction_ratio"]
    printed = make_plan(changed("preset", preset)).datasets["trials"].values()["belt_velocity"]
    assert set(printed) <= set(values["belt_velocity"])
