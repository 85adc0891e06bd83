"""The plan made from config.yaml: grids, blocks, and one clear line for whatever is wrong."""

import copy
from pathlib import Path

import pytest

from beltrepro import config
from beltrepro.errors import InputError

ROOT = Path(__file__).parents[1]
CONFIG = config.load(ROOT / "config.yaml")
SCHEMA = config.load(ROOT / "workflow" / "schemas" / "config.schema.yaml")


def changed(path: str, value):
    """The project's config with one value changed; None removes the key."""
    result = copy.deepcopy(CONFIG)
    *parents, last = path.split(".")
    section = result
    for key in parents:
        section = section[key]
    if value is None:
        del section[last]
    else:
        section[last] = value
    return result


def complaint(configuration) -> str:
    with pytest.raises(InputError) as caught:
        config.make_plan(configuration, SCHEMA)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith("config.yaml: ")
    return message


@pytest.fixture(scope="module", params=sorted(CONFIG["presets"]))
def plan(request):
    return config.make_plan(changed("preset", request.param), SCHEMA)


# --- what the plan holds ---


def test_standard_is_the_default():
    assert CONFIG["preset"] == "standard"


def test_paper_grids_are_those_of_the_paper():
    plan = config.make_plan(changed("preset", "paper"), SCHEMA)
    assert {scan.duration for scan in plan.scans.values()} == {2e6}
    assert {scan.transient for scan in plan.scans.values()} == {1e6}
    assert plan.numerics.time_step == 0.001
    points = {name: len(scan.points) for name, scan in plan.scans.items()}
    assert points == {
        "n5_map": 100 * 21,
        "n5_rows": 250 * 7,
        "n5_u7": 41,
        "n5_columns": 6 * 41,
        "size_rows": 6 * 200 * 3,
        "size_columns": 4 * 41,
        "n5_rows_check": 25 * 2,
        "size_rows_check": 6 * 50,
    }
    assert len(plan.ensembles["lifetimes"].belt_velocities) == 35
    assert plan.ensembles["lifetimes"].n_members == 1000


def test_points_are_sorted_by_size_noise_velocity(plan):
    for scan in plan.scans.values():
        assert list(scan.points) == sorted(scan.points, key=lambda p: (p[0], p[2], p[1]))
        assert len(set(scan.points)) == len(scan.points)


def test_blocks_hold_every_point_once_in_order(plan):
    for scan in plan.scans.values():
        assert sum((block.points for block in scan.blocks), ()) == scan.points
        assert all(len(block.points) <= scan.points_per_job for block in scan.blocks)


def test_equal_points_of_different_grids_have_equal_bits():
    fine = config._values({"start": 0.2, "stop": 50, "step": 0.2}, "fine")
    coarse = config._values({"start": 0.5, "stop": 50, "step": 0.5}, "coarse")
    assert set(range(1, 51)) <= set(fine) & set(coarse)
    assert (fine[0], fine[-1], len(fine)) == (0.2, 50, 250)


def test_grid_ends_at_the_last_step_before_stop():
    assert config._values({"start": 1, "stop": 2, "step": 0.3}, "") == (1, 1.3, 1.6, 1.9)
    assert config._values(7, "") == (7,)
    assert config._values([3, 1], "") == (1, 3)


def test_method_of_all_datasets_in_one_line():
    plan = config.make_plan(changed("method", "event"), SCHEMA)
    assert {block.method for scan in plan.scans.values() for block in scan.blocks} == {"event"}
    assert {series.method for series in plan.series.values()} == {"event"}
    assert plan.catalogues["u1"].method == plan.ensembles["lifetimes"].method == "event"


def test_method_may_differ_without_and_with_noise():
    methods = {"without_noise": "verlet", "with_noise": "event"}
    configuration = changed("methods.scans.n5_rows", methods) | {"method": "listed"}
    scan = config.make_plan(configuration, SCHEMA).scans["n5_rows"]
    for block in scan.blocks:
        assert {point[2] > 0 for point in block.points} == {block.method == "event"}
    assert scan.settings()["method"] == "verlet (sigma = 0), event (sigma > 0)"


def test_numbers_that_yaml_reads_as_text_are_numbers():
    plan = config.make_plan(changed("presets.standard.duration", "2e6"), SCHEMA)
    assert plan.scans["n5_rows"].duration == 2e6


def test_settings_are_plain_values(plan):
    import json

    json.dumps(plan.settings())


def test_every_key_of_the_schema_is_described():
    def walk(node, path):
        if not isinstance(node, dict):
            return
        for group in ("properties", "patternProperties"):
            for key, child in node.get(group, {}).items():
                target = child
                if "$ref" in child:
                    target = SCHEMA["$defs"][child["$ref"].rsplit("/", 1)[1]]
                elif group == "properties":
                    assert "description" in child, f"{path}.{key}"
                yield from walk(target, f"{path}.{key}")
        if node.get("type") == "object" and "properties" in node:
            yield path, node.get("additionalProperties")

    found = list(walk(SCHEMA, "config"))
    assert len(found) > 8
    assert [path for path, additional in found if additional is not False] == []


# --- what it refuses ---


@pytest.mark.parametrize(
    ("path", "where"),
    [
        ("presett", ""),
        ("model.static_fricton", "model"),
        ("numerics.time_stp", "numerics"),
        ("methods.scan", "methods"),
        ("presets.standard.transiet", "presets.standard"),
        ("presets.standard.scans.n5_map.belt_velocty", "presets.standard.scans.n5_map"),
        ("presets.smoke.scans.n5_map.noise.stpe", "presets.smoke.scans.n5_map.noise"),
        ("presets.paper.series.u1.durration", "presets.paper.series.u1"),
        ("presets.paper.catalogues.u1.n_chain", "presets.paper.catalogues.u1"),
        ("presets.paper.ensembles.lifetimes.n_member", "presets.paper.ensembles.lifetimes"),
    ],
)
def test_misspelt_key_is_refused_at_every_level(path, where):
    message = complaint(changed(path, 1))
    assert f"unknown key {path.rsplit('.', 1)[-1]!r}" in message
    assert "did you mean" in message
    assert (f" in {where};" in message) == bool(where)


def test_the_line_for_a_misspelt_key():
    assert complaint(changed("presets.standard.scans.n5_map.belt_velocty", 3)) == (
        "config.yaml: unknown key 'belt_velocty' in presets.standard.scans.n5_map; "
        "did you mean 'belt_velocity'?"
    )


def test_unknown_key_without_a_near_one_gets_no_suggestion():
    assert complaint(changed("foo", 1)) == "config.yaml: unknown key 'foo'"


def test_unknown_preset_suggests_the_nearest():
    message = complaint(changed("preset", "smok"))
    assert "smoke, standard, paper" in message
    assert message.endswith("did you mean 'smoke'?")


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("seed", -1, "seed = -1: must be at least 0"),
        ("method", "verlett", "did you mean 'verlet'"),
        ("model.friction_ratio", 1.5, "must be less than 1"),
        ("numerics.time_step", 0, "must be greater than 0"),
        ("presets.standard.scans.n5_map.belt_velocity", -2, "must be greater than 0"),
        ("presets.standard.scans.n5_map.belt_velocity", [3, -2], "belt_velocity[1] = -2"),
        ("presets.standard.scans.n5_map.n_blocks", 0, "n_blocks = 0: must be at least 1"),
        ("presets.standard.scans.n5_map.n_blocks", 2.5, "must be a whole number"),
        ("presets.standard.scans.n5_map.noise", [], "is empty"),
        ("presets.standard.scans.n5_map.noise", [1, 1], "occurs twice"),
        ("presets.standard.scans.n5_map.noise", "much", "must be a number"),
        ("presets.standard.scans.n5_map.noise.step", 0, "must be greater than 0"),
        ("presets.standard.scans.n5_map.noise.step", 1e-9, "at most 100000"),
        ("presets.standard.scans.n5_map.noise.start", 11, "must not be less than start = 11"),
        ("presets.standard.scans.n5_map.noise.stop", None, "noise.stop is missing"),
        ("presets.standard.scans.n5_map.n_blocks", 9, "no entry for n_blocks = 9"),
        ("presets.standard.scans.n5_map.transient", 1e9, "n5_map.transient = 1e+09: must be less"),
        ("presets.standard.scans.size_columns.n_blocks", [5, 6, 7], "entry for n_blocks = 10"),
        ("presets.standard.scans.size_columns.n_blocks", [4, 5], "no entry for n_blocks = 4"),
        ("presets.standard.scans.n5_map", None, "has no dataset 'n5_map'"),
        ("methods.scans.n5_map", None, "n5_map has no entry in methods.scans"),
        ("presets.standard.transient", 50000, "must be less than duration = 40000"),
        ("presets.standard.series.u1.transient", 1e9, "series.u1.transient = 1e+09"),
        ("presets.standard.series.u1.noise", float("nan"), "a finite number is needed"),
        ("presets.standard.catalogues.u1.section_block", 6, "the chain has 5 blocks"),
        ("presets.standard.ensembles.lifetimes.settle_time", 1e9, "must be less than duration"),
    ],
)
def test_bad_value_is_refused(path, value, words):
    assert words in complaint(changed(path, value))


def test_files_that_cannot_be_read_are_one_line(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        config.load(tmp_path / "missing.yaml")
    broken = tmp_path / "broken.yaml"
    broken.write_text("a: [1,\nb: {")
    with pytest.raises(InputError, match="not YAML") as caught:
        config.load(broken)
    assert "\n" not in str(caught.value)
    broken.write_text("just text")
    with pytest.raises(InputError, match="must be a mapping"):
        config.load(broken)
