"""What files must say of themselves: whether it changes with what they are made from."""

import copy
from pathlib import Path

import pytest

from beltrepro.replication.plan.config import load_config
from beltrepro.replication.plan.workflow import Workflow

CONFIG = load_config(Path(__file__).parents[2] / "config.yaml")


def expectations(dataset=None, compression=None):
    """Those of a smoke run, whose dataset is longer or whose camera is another."""
    config = copy.deepcopy(CONFIG) | {"preset": "smoke"}
    if dataset:
        own = config["presets"]["smoke"]["datasets"].setdefault(dataset, {})
        own["duration"] = 4321
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
    found = expectations()
    plan = found.plan
    assert set(found.judged) == {*plan.datasets, *(f"{name}_track" for name in plan.films)}
    assert found.made_from(*found.judged) == {
        "preset": "smoke",
        "run": "smoke",
        "sources": found.expected(*found.judged),
    }
