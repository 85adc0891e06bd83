"""Wiring: each thing that a job is told reaches what it is for."""

import ast
import copy
import inspect
import re
import runpy
from pathlib import Path
from pkgutil import resolve_name

import numpy as np
import pandas as pd
import pytest

import small_plans
from beltrepro.base import seal, store
from beltrepro.base.errors import InputError
from beltrepro.model.units import to_si
from beltrepro.replication.plan import files, inputs, kinds, tables
from beltrepro.replication.plan.config import Settings, load_config
from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.plan.points import CHAIN, QUANTITIES, REQUIRED, SETTINGS, points_of
from beltrepro.replication.plan.workflow import Workflow

ROOT = Path(__file__).parents[2]
WORKFLOW = ROOT / "workflow"
CONFIG = load_config(ROOT / "config.yaml")
EMPTY = inspect.Parameter.empty
METHODS = {"without_noise": "verlet", "with_noise": "event"}
OTHER = {  # than those of `planned`, and sensible
    "method": "verlet",
    "samples": ["velocities"],
    "noise_clock": "laboratory",
    "energies": [5.0, 2.0],
    "section_block": 1,
    "section_position": 61.5,
}


def planned(kind="scan", **keys):
    """A dataset of three points of two sizes, cut into unequal batches."""
    points = {"n_blocks": [2, 3], "belt_velocity": {2: [5, 7], 3: 6}, "noise": 1, "replicate": 2}
    return small_plans.planned(kind, **points | {"initial_spread": 0.5, "points_per_job": 2} | keys)


def changed(spec, name):
    """The same with another value of a quantity or setting."""
    spec = copy.deepcopy(spec)
    part = spec["points"] if name in QUANTITIES else spec["settings"]
    value = part[name][0] if name in QUANTITIES and isinstance(part[name], list) else part[name]
    part[name] = OTHER[name] if name in OTHER else value * 0.5 if value % 1 else value + 1
    return spec


def script(name):
    return runpy.run_path(str(WORKFLOW / "scripts" / f"{name}.py"))


# --- from the plan to the function of a kind ------------------------------------------------------


@pytest.mark.filterwarnings("ignore:.*repeat another")
@pytest.mark.parametrize("kind", KINDS)
def test_each_quantity_and_setting_reaches_the_function_of_the_kind(kind, monkeypatch):
    calls = []

    def recording(setup, **spec):
        calls.append((setup.cases, spec))
        return {}

    monkeypatch.setattr(kinds, "resolve_name", {KINDS[kind].record: recording}.__getitem__)
    whole = planned(kind).spec("one", "0000")
    names = [*QUANTITIES, *KINDS[kind].settings]
    heard = set()
    for spec in (whole, *(changed(whole, name) for name in names)):
        points = points_of(spec["points"])
        columns = kinds.record(kind, points, spec["settings"], progress=print)
        cases, settings = calls[-1]
        assert settings == spec["settings"] | {"progress": print}
        for row, (point, case) in enumerate(zip(points, cases, strict=True)):
            assert all(getattr(case.parameters, name) == getattr(point, name) for name in CHAIN)
            for name in ("method", "time_step", "initial_spread"):
                assert getattr(case, name) == getattr(point, name)
            assert (case.state.seed, case.state.replicate) == (point.seed, point.replicate)
            for name, values in columns.items():
                assert values[row] == getattr(point, name)
        heard.add(repr((spec["settings"], points)))
    assert len(heard) == len(names) + 1


def test_defaults_of_settings_are_those_of_the_functions_that_get_them():
    compared = 0
    for kind in KINDS.values():
        of_function = inspect.signature(resolve_name(kind.record)).parameters
        for name in kind.settings:
            own = Settings.model_fields[name].default
            default = getattr(of_function.get(name), "default", EMPTY)
            if own != REQUIRED and default is not EMPTY:
                compared += 1
                assert own == (list(default) if isinstance(own, list) else default), name
    assert compared > 8


@pytest.mark.parametrize("name", [*QUANTITIES, *KINDS["scan"].settings, "dataset", "run", "preset"])
def test_whatever_a_batch_is_told_is_known_of_its_file(tmp_path, name):
    spec = planned().spec("one", "0000")
    other = changed(spec, name) if name in QUANTITIES | SETTINGS else spec | {name: "other"}
    arrays = {"mean_length": np.array([1.0, 2.0])}
    arrays = kinds.columns(points_of(spec["points"])) | arrays
    files.write(tmp_path / "a.h5", spec, arrays)
    files.read(tmp_path / "a.h5", files.expected(spec))
    with pytest.raises(InputError, match=r"holds dataset one .*to make it again: rm "):
        files.read(tmp_path / "a.h5", files.expected(other))


# --- scripts --------------------------------------------------------------------------------------


def rules():
    """Text of each rule that runs a script, by name of the script."""
    for path in sorted((WORKFLOW / "rules").glob("*.smk")):
        for rule in re.split(r"^rule ", path.read_text(), flags=re.M)[1:]:
            if named := re.search(r'"\.\./scripts/(\w+)\.py"', rule):
                yield named[1], rule


@pytest.mark.parametrize(("name", "rule"), list(rules()), ids=[name for name, _ in rules()])
def test_a_script_reads_each_parameter_of_its_rule_and_no_other(name, rule):
    block = re.search(r"^    params:\n((?:        .*\n)+)", rule, re.M)[1]
    values = set(re.findall(r"^        (\w+)=", block, re.M))
    tree = ast.parse((WORKFLOW / "scripts" / f"{name}.py").read_text())
    bases = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    read = {node.attr for node in bases if ast.unparse(node.value) in ("job.params", "params")}
    whole = values - read - {"code", "shown"}  # of reruns
    assert whole == set(), "never read"
    assert read & {"spec", "expected", "settings", "code", "benchmarks"} <= values


def test_a_dataset_is_joined_from_its_batches_in_their_order(tmp_path):
    plan = planned()
    paths, expected, points = [], [], []
    for name, batch in plan.datasets["one"].batches.items():
        spec = plan.spec("one", name)
        paths.append(tmp_path / f"{name}.h5")
        expected.append(files.expected(spec))
        points += batch
        arrays = {"mean_length": np.array([point.belt_velocity for point in batch])}
        files.write(paths[-1], spec, kinds.columns(batch) | arrays)
    assert [len(batch) for batch in plan.datasets["one"].batches.values()] == [2, 1]
    join, spec = script("join")["join"], plan.spec("one")
    join(paths, expected, spec, tmp_path / "one.h5")
    whole = files.read(tmp_path / "one.h5", files.expected(spec))
    assert whole.arrays["mean_length"].tolist() == [point.belt_velocity for point in points]
    join(paths, expected, spec | {"run": "other"}, tmp_path / "other.h5")
    assert store.read(tmp_path / "other.h5").attributes["run"] == "other"
    with pytest.raises(InputError, match="with other settings"):
        join(paths, expected[::-1], spec, tmp_path / "wrong.h5")
    with pytest.raises(ValueError, match="shorter"):
        join(paths, expected[:1], spec, tmp_path / "wrong.h5")


@pytest.mark.parametrize(
    ("noise", "method", "words"),
    [
        (0, "event", "event"),
        (0, ["event", "verlet"], "event, verlet"),
        ([0, 1], ["event", "verlet"], "event, verlet"),
        ([0, 1], METHODS, "verlet (sigma = 0), event (sigma > 0)"),
    ],
)
def test_a_file_says_by_which_methods_its_points_are_computed(tmp_path, noise, method, words):
    plan = planned(noise=noise, method=method)
    arrays = kinds.columns(plan.datasets["one"].points)
    files.write(tmp_path / "one.h5", plan.spec("one"), arrays)
    assert files.read_any(tmp_path / "one.h5").attributes["method"] == words


@pytest.mark.filterwarnings("ignore:loading is measured")
def test_chains_of_more_blocks_than_the_papers_are_joined_with_shorter_ones():
    lengths = {"duration": 900, "transient": 340}
    plan = planned(n_blocks=[3, 13], belt_velocity={3: [5, 7], 13: 6}, **lengths)
    specs = [plan.spec("one", name) for name in plan.datasets["one"].batches]
    parts = []
    for spec in specs:
        arrays = kinds.record("scan", points_of(spec["points"]), spec["settings"])
        parts.append(store.Dataset(arrays, {}))
    joined = files.join(parts, KINDS["scan"].arrays)
    slips = joined["slip_count"]
    assert joined["n_blocks"].tolist() == [3, 3, 13]
    assert slips.shape == (3, 13) and slips.dtype == parts[0].arrays["slip_count"].dtype
    assert slips[:2, :3].all() and not slips[:2, 3:].any() and slips[2].all()


@pytest.mark.slow
def test_a_film_is_taken_as_told(tmp_path):
    plan = planned("series", n_blocks=2, belt_velocity=5, sample_interval=0.5448376, noise=0)
    spec = plan.spec("one")
    points = plan.datasets["one"].points
    data = kinds.record("series", points, spec["settings"])
    files.write(tmp_path / "one.h5", spec, data)
    expected = {"one": files.expected(spec)}
    small = {"width": 128, "height": 64, "seed": 1, "compression": 0, "metres_per_pixel": 0.004}
    take, made = script("film")["take"], {}
    others = {"width": 130, "height": 48, "seed": 2, "blur": 3, "angle": 5, "sensor_noise": 9}
    others |= {"exposure": 0.04, "light_unevenness": 0.5, "dropped": 0.5, "compression": 30}
    cameras = [small, *(small | {name: value} for name, value in others.items())]
    for number, camera in enumerate(cameras):
        film, table = (tmp_path / f"{number}.{ending}" for ending in ("mp4", "csv"))
        spec = {"film": "f", "camera": camera}
        take({"one": tmp_path / "one.h5"}, expected, spec, film, table)
        made[seal.digest_of(film)] = spec
        for path in (film, table):
            about = {"preset": "own", "run": "r", "sources": expected | {"f_film": spec}}
            inputs.check(path, about)
        seen = inputs.load({"f_track": table}, {})["f_track"]
        frame = np.rint(seen.time_s * 24).astype(int)
        true = to_si(data["positions"][0, frame, -1], "length")
        np.testing.assert_allclose(seen.x_m, true, atol=2e-3)
    assert len(made) == len(cameras)


def test_a_table_is_refused_where_its_sources_are_others(tmp_path):
    sources = {"one": {"digest": "a"}, "two": {"digest": "b"}, "three": {"digest": "c"}}
    frame = pd.DataFrame({"a": [1]})
    tables.write(tmp_path / "t.csv", frame, title="T.", columns={}, sources=sources)
    about = {"preset": "own", "run": "r", "sources": sources}
    inputs.check(tmp_path / "t.csv", about)
    for name in sources:
        other = sources | {name: {"digest": "d"}}
        with pytest.raises(InputError, match="made from other datasets"):
            inputs.check(tmp_path / "t.csv", about | {"sources": other})


def test_the_lineage_of_a_result_names_every_dataset_behind_it(tmp_path):
    """Of three inputs, a dataset stands between what was made from others."""
    plan, frame = planned(), pd.DataFrame({"a": [1]})
    paths = {"first": tmp_path / "first.csv", "one": tmp_path / "one.h5"}
    paths["last"] = tmp_path / "last.csv"
    behind = {"first": {"u1": {"digest": "a"}, "u2": {"digest": "b"}}, "last": {"u3": {}}}
    for name, origins in behind.items():
        tables.write(paths[name], frame, title="T.", columns={}, sources={}, lineage=origins)
    files.write(paths["one"], plan.spec("one"), kinds.columns(plan.datasets["one"].points))
    expected = {"one": files.expected(plan.spec("one"))}
    lineage = inputs.lineage(paths, inputs.load(paths, expected))
    assert list(lineage) == ["one", "u1", "u2", "u3"]
    assert lineage["u1"] == {"digest": "a"} and lineage["one"]["config"]["dataset"] == "one"


# --- what files must say of themselves ---


def expectations(dataset=None, compression=None):
    """Those of a smoke run, whose dataset is longer or whose camera is another."""
    config = copy.deepcopy(CONFIG) | {"preset": "smoke"}
    if dataset:
        chosen = config["presets"]["smoke"]["datasets"].setdefault(dataset, {})
        chosen["duration"] = 4321
    if compression:
        config["camera"]["compression"] = compression
    return Workflow(config)


@pytest.mark.parametrize("name", ["belt_028", "belt_028_film", "belt_028_track", "recordings"])
def test_a_file_must_name_the_dataset_that_it_comes_from(name):
    asked = expectations().expected(name)
    assert asked == expectations("u1").expected(name)
    assert asked != expectations("belt_028").expected(name)


def test_what_is_filmed_and_how_is_told_of_films_and_tracks_only():
    one, other = expectations(), expectations(compression=30)
    for name in ("belt_028_film", "belt_028_track", "recordings"):
        assert one.expected(name) != other.expected(name)
    assert one.expected("belt_028", "lifetimes") == other.expected("belt_028", "lifetimes")


def test_claims_are_measured_from_all_datasets_and_all_tracks():
    expectations_of = expectations()
    plan = expectations_of.plan
    assert set(expectations_of.judged) == {
        *plan.datasets,
        *(f"{name}_track" for name in plan.films),
    }
    assert expectations_of.made_from(*expectations_of.judged) == {
        "preset": "smoke",
        "run": "smoke",
        "sources": expectations_of.expected(*expectations_of.judged),
    }
