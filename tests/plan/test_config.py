"""config.yaml: what may stand there, and one clear line for whatever is wrong.

What is tried follows from the typed descriptions, so a new key is tried without a change here.
"""

import copy
import datetime
import json
import math
from pathlib import Path

import jsonschema
import pytest
from pydantic import TypeAdapter

from beltrepro.base.errors import InputError
from beltrepro.replication.plan import config
from beltrepro.replication.plan.kinds import KINDS, SETTINGS
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import LAW, QUANTITIES
from small_plans import configuration as single

ROOT = Path(__file__).parents[2]
CONFIG = config.load_config(ROOT / "config.yaml")
DATASET = "presets.standard.datasets.n5_map"


def changed(whole, path, value):
    """A configuration with one value changed; None removes it."""
    whole = copy.deepcopy(whole)
    *parents, last = path.split(".") if isinstance(path, str) else path
    section = whole
    for key in parents:
        section = section.setdefault(key, {})
    if value is REMOVED:
        del section[last]
    else:
        section[last] = value
    return whole


REMOVED = object()


def complaint(configuration, *words) -> str:
    with pytest.raises(InputError) as caught:
        make_plan(configuration)
    message = str(caught.value)
    assert "\n" not in message and len(message) < 400 and message.startswith("config.yaml: ")
    assert all(word in message for word in words), (words, message)
    return message


# --- the schema -----------------------------------------------------------------------------------


def test_schema_for_editors_is_made_of_what_checks_and_takes_the_configuration():
    kept = (ROOT / "workflow" / "schemas" / "config.schema.yaml").read_text(encoding="utf-8")
    assert kept == config.schema_as_yaml(), "run `make schema`"
    validator = jsonschema.Draft202012Validator(config.schema())
    as_text = json.loads(json.dumps(CONFIG))  # keys are text
    assert list(validator.iter_errors(as_text)) == []
    for path, value in (("seed", -1), (f"{DATASET}.noise", [1, 1]), ("camera.width", 641)):
        assert not validator.is_valid(changed(as_text, path, value)), path


def test_every_key_of_the_schema_is_described_and_no_other_allowed():
    parts = config.schema()["$defs"]
    for name, part in parts.items():
        assert "description" in part or name.startswith("Grid_"), name
        if "properties" in part:
            assert part["additionalProperties"] is False
            for key, entry in part["properties"].items():
                limit_of_a_range = name.startswith("Range_") and key in ("start", "stop")
                words = "description" in entry or "$ref" in entry or limit_of_a_range
                assert words or name == "Methods", (name, key)
    assert set(parts["Dataset"]["properties"]) == {
        *("kind", "like", "own_method", "points_per_job", "also"),
        *QUANTITIES,
        *SETTINGS,
    }


# --- every key ------------------------------------------------------------------------------------

NOWHERE = {  # what YAML can hold and no key can be; text that is a number is one
    "nested": [[1]],
    "unknown key": {"a": 1},
    "nan": math.nan,
    "infinite": math.inf,
    "too large": "1e999",
    "nan in a list": [1.0, math.nan],
    "date": [datetime.date(2013, 4, 29)],
    "bytes": b"1",
    "set": {1},
    "empty": "",
    "word": "much",
    "empty list": [],
}
NUMBERS = {
    "negative": -1,
    "huge": 10**40,
    "no physics": 1e300,
    "true": True,
    "twice": [1, 1],
    "text in a list": [1, "much"],
    "no keys": {},
    "part of a range": {"start": 1, "stop": 2},
    "no step": {"start": 1, "stop": 2, "step": 0},
    "backward step": {"start": 1, "stop": 2, "step": -1},
    "no end": {"start": 1, "stop": math.inf, "step": 1},
    "size of nothing": {"0": 1},
    "no offset": {"offset": -1},
    "no replicates": {"count": 0},
    "too many replicates": {"count": 10**12},
}
OF_TYPE = {
    "number": NUMBERS,
    "integer": NUMBERS | {"fraction": 1.5},
    "boolean": {"number": 1, "null": None},
    "array": {"number": 1, "null": None, "no keys": {}},
    "object": {"number": 1, "null": None},
    "string": {"number": 1, "true": True, "null": None, "no keys": {}},
}


def keys_of(kind):
    """Path to each key of a dataset of this kind, and its type in JSON; of a scan to all others."""
    described = QUANTITIES | {name: SETTINGS[name] for name in KINDS[kind].settings}
    types = {name: _types(about) for name, about in described.items()}
    yield from ((("datasets", "one", name), types[name]) for name in types)
    others = {"kind": "string", "like": "string", "own_method": "boolean"}
    others["points_per_job"] = "integer"
    yield from ((("datasets", "one", name), [type_]) for name, type_ in others.items())
    if kind == "scan":
        every = QUANTITIES | SETTINGS
        yield from ((("defaults", name), _types(about)) for name, about in every.items())
        yield from ((("model", about.name), _types(about)) for about in LAW)
        top = {"preset": "string", "run": "string", "seed": "integer", "method": "string"}
        maps = ("model", "defaults", "datasets", "camera", "films", "presets")
        top |= dict.fromkeys(maps, "object")
        yield from (((name,), [type_]) for name, type_ in top.items())
        chosen = {"based_on": "string", "defaults": "object", "datasets": "object"}
        yield from ((("presets", "own", name), [type_]) for name, type_ in chosen.items())


def _types(about):
    made = TypeAdapter(config.type_of(about.type, **about.limits)).json_schema()
    return [one.get("type", "string") for one in made.get("anyOf", [made])]


@pytest.mark.parametrize("kind", KINDS)
def test_wrong_value_of_each_key_is_refused(kind):
    whole = single(kind)
    make_plan(whole)
    tried = 0
    for path, types in keys_of(kind):
        wrong = NOWHERE | OF_TYPE[types[0]] | ({} if "null" in types else {"null": None})
        if path == ("run",):  # any text that can be the name of a folder, a date too
            kept = {name: NOWHERE[name] for name in ("empty", "bytes", "set", "unknown key")}
            wrong = kept | {"up": "../x", "space": "a b", "true": True, "list": ["a"]}
        for value in wrong.values():
            complaint(changed(whole, path, value), str(path[-1]))
            tried += 1
    assert tried > 300


@pytest.mark.parametrize("kind", KINDS)
def test_misspelt_keys_are_named(kind):
    for (*parents, name), _ in keys_of(kind):
        message = complaint(changed(single(kind), (*parents, f"{name}x"), 1), f"'{name}x'")
        assert f"did you mean {name!r}" in message


def test_missing_keys_are_named():
    for kind in KINDS:
        whole = single(kind)
        for name in set(whole["datasets"]["one"]) - {"method"}:
            complaint(changed(whole, f"datasets.one.{name}", REMOVED), f"no {name}")
    for name in ("preset", "seed", "datasets", "presets"):
        complaint(changed(single(), name, REMOVED), f"{name} is missing")


def limits():
    """Each limit of a quantity or setting: a value on its inner side, and one beyond."""
    for name, about in (QUANTITIES | SETTINGS).items():
        made = TypeAdapter(config.type_of(about.type, **about.limits)).json_schema()
        for part in made.get("anyOf", [made]):
            for key, inner, outer in (("minimum", 1.2, 0.8), ("maximum", 0.8, 1.2)):
                if part.get(key) and part["type"] == "number":
                    yield name, inner * part[key], outer * part[key]


@pytest.mark.parametrize(("name", "inner", "outer"), list(limits()))
def test_values_are_taken_up_to_their_limits(name, inner, outer):
    for value, is_taken in ((inner, True), (outer, False)):
        whole = single()
        whole["defaults"] = {name: value}
        try:
            config.checked(whole)
        except InputError as error:
            assert not is_taken and f"defaults.{name} = " in str(error)
        else:
            assert is_taken


# --- single lines ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (f"{DATASET}.noise.stpe", 1, f"unknown key 'stpe' in {DATASET}.noise; did you mean"),
        ("datasets.pairs_r_event.seed.ofset", 1, "in datasets.pairs_r_event.seed; did you mean"),
        ("preset", "smok", "'smok': allowed are smoke, standard, paper; did you mean 'smoke'?"),
        (
            "datasets.u1.section_values",
            3,
            "a dataset of kind series has no such setting, only dura",
        ),
        ("run", "smoke", "run = 'smoke': is the name of another preset"),
        ("run", "r" * 101, "must have at most 100 characters"),
        ("run", "../f06", "must match pattern '^[A-Za-z0-9]"),
        ("datasets.n5_map.kind", REMOVED, "n5_map of preset standard has no kind"),
        ("datasets.n5_map.method", {"with_noise": "event"}, "method.without_noise is missing"),
        ("datasets.n5_map.method", {"event": "event"}, "must be 'verlet' or 'event'"),
        ("datasets.N5", {}, "unknown key 'N5' in datasets: a name that matches ^[a-z]"),
        (f"{DATASET}.belt_velocity", {"5": {"5": 1}}, "'5' in presets.standard.datasets.n5_map."),
        (f"{DATASET}.belt_velocity", {"5": {"5": 1}}, "allowed are start, stop, step"),
        ("datasets.n5_rows_check.like", "n5_row", "did you mean 'n5_rows'"),
        ("datasets.n5_rows.like", "n5_rows_check", "a dataset cannot be like itself"),
        ("datasets.lifetimes.tolerance", "small", "must be a number or null"),
        ("datasets.motion_map.method", "verlet", "method = verlet: only event has a tangent"),
        ("datasets.u17.friction_ratio", 0.9, "u17.noise = 2.2: with friction_ratio = 0.9 and"),
        ("datasets.u1.sample_interval", 0.0015, "0.0015: method verlet needs a multiple of time_"),
        ("presets.standard.based_on", "smok", "did you mean 'smoke'"),
        ("presets.standard.based_on", "standard", "standard is based on standard"),
        (f"{DATASET}.belt_velocity", [3, -2], "belt_velocity[1] = -2"),
        (f"{DATASET}.n_blocks", 2.5, "must be a whole number"),
        (f"{DATASET}.noise", [], "must have at least 1 item"),
        (f"{DATASET}.noise.step", 1e-9, "at most 100000"),
        (f"{DATASET}.noise.start", 11, "must not be less than start = 11"),
        (f"{DATASET}.transient", 60000, "n5_map.transient = 60000: must be less"),
        ("camera.width", 641, "camera.width = 641: must be a multiple of 2"),
        ("camera.exposure", 0.05, "camera.exposure = 0.05: must be at most 0.04167"),
        ("films.belt_028.of", "belt_29", "films.belt_028.of = 'belt_29': preset standard has no"),
        ("films.belt_028.of", "n5_u7", "= 'n5_u7': must be a series of one point"),
        ("films.belt_028.of", "u17", "sample_interval is 0.1, 24 frames a second need 0.5448376"),
        ("datasets.belt_022.sample_interval", 0.5448376 * 1.0012, "frames a second need"),
        ("films.belt_028.of", REMOVED, "films.belt_028.of is missing"),
        ("datasets.belt_022.samples", ["positions"], "its samples lack velocities"),
        ("datasets.a_track", {"like": "u1"}, "only films have names that end in _film or _track"),
        ("presets.standard.datasets.size_columns.n_blocks", [5, 6, 7], "entry for n_blocks = 10"),
        ("presets.standard.datasets.size_columns.n_blocks", [4, 5], "no entry for n_blocks = 4"),
        ("presets.standard.datasets.slips_u1.section_block", 6, "the chain has 5 blocks"),
        ("datasets.slips_u1.section_position", REMOVED, "only for the last block there is a rule"),
        ("presets.standard.datasets.lifetimes.settle_time", 1e9, "must be less than duration"),
    ],
)
def test_bad_value_is_refused(path, value, words):
    complaint(changed(CONFIG, path, value), words)


def test_a_value_within_itself_is_one_line():
    whole = single()
    whole["datasets"]["one"]["noise"] = whole["datasets"]
    complaint(whole, "part of itself")


def test_samples_of_a_film_may_be_a_thousandth_off_its_frames():
    make_plan(changed(CONFIG, "datasets.belt_022.sample_interval", 0.5448376 * 1.0008))


def test_the_last_block_of_the_shortest_chain_may_make_the_section():
    # datasets of three blocks are like slips_u1
    make_plan(changed(CONFIG, "presets.standard.datasets.slips_u1.section_block", 3))


def test_a_preset_that_nobody_asks_for_needs_no_points():
    whole = changed(CONFIG, "presets.mine", {"defaults": {}})
    assert make_plan(whole).preset == "standard"
    complaint(changed(whole, "preset", "mine"), "of preset mine has no ")


def test_a_dataset_has_not_too_many_points():
    whole = single(belt_velocity={"start": 1, "stop": 10, "step": 0.001}, replicate={"count": 1000})
    words = "datasets.one.belt_velocity: with the other axes it makes 9e+06 points, at most 1000000"
    complaint(whole, words)


BOMB = "".join(f"a{n}: &a{n} [{','.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 30))
BOMB = f"a0: &a0 [x]\n{BOMB}"


def test_files_that_cannot_be_read_are_one_line(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        config.load_config(tmp_path / "missing.yaml")
    for text, words in (
        ("a: [1,\nb: {", "broken.yaml, line 2: while parsing a flow node expected"),
        ("just text", "must be a mapping"),
        ("", "must be a mapping"),
        ("a: 1\nb: {c: 1, 5: 2,\n  5: 3}", "broken.yaml, line 3: the key '5' is given twice"),
        ("a: &a {b: *a}", "more than 100000 values, perhaps without end"),
        (BOMB, "more than 100000 values, perhaps without end"),
        ("a: " + "[" * 100_000, "not YAML: maximum recursion depth exceeded"),
        ("a: !!python/object/apply:os.getcwd []", "line 1: could not determine a constructor"),
        ("a: 1\0", "not YAML: unacceptable character"),
        ("a: \u00e9", "not a text file in UTF-8"),
        ("a: 2013-02-30", "line 1: '2013-02-30': day is out of range"),
        ("seed: 1\nrun: 1.10", "line 2: run = 1.10: is read as the number 1.1; quote it"),
        ("#" * (config.MOST_BYTES + 1), "too large: 1 MB, at most 1 MB are allowed"),
    ):
        (tmp_path / "broken.yaml").write_text(text, encoding="latin-1")
        with pytest.raises(InputError, match=words) as caught:
            config.load_config(tmp_path / "broken.yaml")
        assert "\n" not in str(caught.value)
    whole = tmp_path / "whole.yaml"
    whole.write_text("a: &a {b: 1}\nc: {<<: *a, b: 2}\nd: {b: 1}")
    assert config.load_config(whole) == {"a": {"b": 1}, "c": {"b": 2}, "d": {"b": 1}}


@pytest.mark.parametrize("word", ["5:30", "190:20:30.15", "1_000", "010", "0b11", "on", "NO"])
def test_what_yaml_1_1_reads_in_its_own_way_is_refused(tmp_path, word):
    """Snakemake takes them for 330, 685230.15, 1000, 8, 3, true and false."""
    path = tmp_path / "more.yaml"
    path.write_text(f"'seed': 1\n{word}: 1\nrun: 2")
    with pytest.raises(InputError, match=f"more.yaml, line 2: '{word}' can be read in two ways"):
        config.load_config(path)
    path.write_text(f"run: '{word}'  # {word}\nseed: [-0.5, +1.5e+3, .5, 0, true, 2e6]")
    numbers = [-0.5, 1500, 0.5, 0, True, "2e6"]
    assert config.load_config(path) == {"run": word, "seed": numbers}
