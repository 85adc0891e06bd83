"""config.yaml: what may stand there, and one clear line for whatever is wrong."""

import copy
import datetime
import math
from pathlib import Path

import pytest

from beltrepro.base.errors import InputError
from beltrepro.replication.plan import config
from beltrepro.replication.plan.kinds import KINDS
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import QUANTITIES, SETTINGS
from small_plans import configuration as single

CONFIG = config.load_config(Path(__file__).parents[2] / "config.yaml")
DATASET = "presets.standard.datasets.n5_map"
REMOVED = object()


def changed(whole, path, value):
    """A configuration with one value changed."""
    whole = copy.deepcopy(whole)
    *parents, last = path.split(".")
    section = whole
    for key in parents:
        section = section.setdefault(key, {})
    section[last] = value
    if value is REMOVED:
        del section[last]
    return whole


def complaint(configuration) -> str:
    with pytest.raises(InputError) as caught:
        make_plan(configuration)
    message = str(caught.value)
    assert "\n" not in message and len(message) < 400 and message.startswith("config.yaml: ")
    return message


# --- every key ------------------------------------------------------------------------------------

NONSENSE = [
    *({1}, b"1", math.nan, math.inf, "1e999", [1.0, math.nan], [[1]], [1, 1], [1, "much"]),
    *({"a": 1}, [datetime.date(2013, 4, 29)], [], "", -1, 10**40, 1e300, {"0": 1}, "9" * 5000),
    *({"start": 1, "stop": 2}, {"start": 1, "stop": 2, "step": 0}, {"5": {"5": 1}}, True),
    *({"start": 1, "stop": math.inf, "step": 1}, {"offset": -1}, {"count": 0}, {"count": 10**12}),
]
COUNTS = ("n_blocks", "seed", "replicate", "section_values", "section_bins", "section_block")
COUNTS += ("points_per_job",)
OF_DATASETS = ("kind", "like", "own_method", "points_per_job", "also")
OF_THE_WHOLE = ("preset", "seed", "method", "defaults", "datasets", "films", "presets")


@pytest.mark.parametrize("kind", KINDS)
def test_no_key_takes_nonsense_or_a_misspelt_name(kind):
    whole = single(kind)
    make_plan(whole)
    names = (*QUANTITIES, *KINDS[kind].settings, *OF_DATASETS)
    paths = [f"datasets.one.{name}" for name in names]
    if kind == "scan":
        paths += [f"defaults.{name}" for name in (*QUANTITIES, *SETTINGS)] + list(OF_THE_WHOLE)
    for path in paths:
        name = path.rpartition(".")[2]
        for value in [*NONSENSE, 1.5 if name in COUNTS else "much"]:
            if (name, value) not in [("own_method", True), ("films", []), ("section_from", -1)]:
                assert name in complaint(changed(whole, path, value)), (path, value)
        message = complaint(changed(whole, f"{path}x", 1))
        assert f"'{name}x'" in message and f"did you mean '{name}'" in message
    for name in set(whole["datasets"]["one"]) - {"method"}:
        assert name in complaint(changed(whole, f"datasets.one.{name}", REMOVED))


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (f"{DATASET}.noise", -3, f"{DATASET}.noise = -3: must be greater than or equal to 0"),
        (f"{DATASET}.noise.stpe", 1, f"unknown key 'stpe' in {DATASET}.noise; did you mean"),
        ("datasets.pairs_r_event.seed.ofset", 1, "in datasets.pairs_r_event.seed; did you mean"),
        ("presets.standard.datasets.n5_mpa.noise", 1, "no kind; did you mean 'n5_map'?"),
        ("preset", "smok", "'smok': allowed are standard, paper, smoke; did you mean 'smoke'?"),
        ("seed", REMOVED, "seed is missing"),
        ("datasets.u1.section_values", 3, "a dataset of kind series has no such setting, only dur"),
        ("run", "smoke", "run = 'smoke': is the name of another preset"),
        ("run", "../f06", "must match pattern '^[A-Za-z0-9]"),
        ("datasets.n5_map.method", {"with_noise": "event"}, "method.without_noise is missing"),
        ("datasets.n5_map.replicate", {"start": 1, "stop": 2, "step": 0.5}, "replicate = 1.5: m"),
        (f"{DATASET}.noise", {5: {"start": 3, "stop": 1, "step": 1}}, "noise.stop = 1: must not"),
        ("datasets.n5_rows_check.like", "n5_row", "did you mean 'n5_rows'"),
        ("datasets.n5_rows.like", "n5_rows_check", "like = 'n5_rows': rests on itself"),
        ("datasets.motion_map.method", "verlet", "method = verlet: only event has a tangent"),
        ("datasets.u17.friction_ratio", 0.9, "u17.noise = 2.2: with friction_ratio = 0.9 and"),
        ("datasets.u1.sample_interval", 0.0015, "0.0015: method verlet needs a multiple of time_"),
        ("datasets.u1.sample_interval", 1e9, "sample_interval = 1e+09: at most duration - transi"),
        ("presets.standard.based_on", "standard", "based_on = 'standard': rests on itself"),
        ("presets.smoke.thin", {"value": 3}, "in presets.smoke.thin; did you mean 'values'"),
        (f"{DATASET}.noise.step", 1e-9, "at most 100000"),
        (f"{DATASET}.transient", 60000, "n5_map.transient = 60000: must be less"),
        ("camera.blurr", 1, "unknown key 'blurr' in camera; did you mean 'blur'"),
        ("presets.standard.datasets.n5_u7.noise", 0, "n5_u7.replicate: without noise and initial"),
        ("films", ["belt_29"], "films: belt_29: preset standard has no"),
        ("films", ["u17"], "sample_interval is 0.1, 24 frames a second need 0.5448376"),
        ("presets.standard.datasets.size_columns.n_blocks", [4, 5], "no entry for n_blocks = 4"),
        ("presets.standard.datasets.slips_u1.section_block", 6, "the chain has 5 blocks"),
        ("datasets.slips_u1.n_blocks", [1, 5], "section_block = 2: the chain has 1 blocks"),
        ("datasets.slips_u1.section_position", REMOVED, "section_block needs one"),
        ("presets.standard.datasets.lifetimes.settle_time", 1e9, "must be less than duration"),
        ("presets.standard.defaults.noise", CONFIG, "unknown key 'preset' in presets.standard.def"),
        (
            "datasets.n5_u7",
            CONFIG["datasets"]["n5_u7"] | {"belt_velocity": [*range(1, 99_999)]},
            "datasets.n5_u7.belt_velocity: with the other axes it makes 1.68e+07 points",
        ),
    ],
)  # fmt: skip
def test_a_wrong_value_is_one_line(path, value, words):
    assert words in complaint(changed(CONFIG, path, value))


# --- the file -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: [1,\nb: {", "more.yaml, line 2: while parsing a flow node expected"),
        ("a:\n\tb: 1", "more.yaml, line 2: .*cannot start any token"),
        ("", "must be a mapping"),
        ("a: 1\nb: {c: 1, 5: 2,\n  5: 3}", "more.yaml, line 3: the key '5' is given twice"),
        ("presets:\n  no: {}", "more.yaml, line 2: 'no' can be read in two ways"),
        ("a: !!python/object/apply:os.getcwd []", "line 1: could not determine a constructor"),
        ("a: \u00e9", "not a text file in UTF-8"),
        ("#" * (config.MOST_BYTES + 1), "too large: 1 MB, at most 1 MB are allowed"),
        *(
            (f"'seed': 1\n{word}: 1\nrun: 2", f"more.yaml, line 2: '{word}' can be read in two")
            for word in ("5:30", "190:20:30.15", "1_000", "0300", "0b11", "on", "NO")
        ),
    ],
)
def test_files_that_cannot_be_read_are_one_line(tmp_path, text, words):
    path = tmp_path / "more.yaml"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(InputError, match=words) as caught:
        config.load_config(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="no such file"):
        config.load_config(tmp_path / "missing.yaml")


def test_files_are_read_as_everybody_reads_them(tmp_path):
    path = tmp_path / "more.yaml"
    path.write_text(
        "a: &a {b: 1}\nc: {<<: *a, b: 2}\nrun: 'on'  # 5:30\nd: [-0.5, 1.5e+3, .5, 0, true]"
    )
    values = {"a": {"b": 1}, "c": {"b": 2}, "run": "on", "d": [-0.5, 1500, 0.5, 0, True]}
    assert config.load_config(path) == values
    lengths = single(duration="1e5", transient="300")  # as YAML 1.1 and `--config` have them
    assert make_plan(lengths).datasets["one"].settings["duration"] == 1e5
