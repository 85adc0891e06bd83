"""The container copies what exists and suffices; the profile for Slurm fits the workflow."""

import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
DOCKERFILE = (ROOT / "container" / "Dockerfile").read_text()


def copied_by_docker():
    lines = re.findall(r"^COPY (.+) (\S+)$", DOCKERFILE, re.M)
    return {name for names, _ in lines for name in names.split()}


def test_it_copies_what_exists_and_all_that_the_environment_is_made_of():
    assert all((ROOT / name).exists() for name in copied_by_docker())
    stamp = re.search(r"^\$\(STAMP\): (.+)$", (ROOT / "Makefile").read_text(), re.M)[1]
    needed = {"Makefile", "src", PROJECT["readme"], *PROJECT["license-files"], *stamp.split()}
    assert needed <= copied_by_docker()
    kept = set(re.findall(r"^!(\S+)$", (ROOT / ".dockerignore").read_text(), re.M))
    assert copied_by_docker() <= kept


def test_profile_of_slurm_groups_rules_that_exist():
    profile = yaml.safe_load((ROOT / "profiles" / "slurm" / "profile.yaml").read_text())
    text = "".join(path.read_text() for path in (ROOT / "workflow" / "rules").glob("*.smk"))
    rules = set(re.findall(r"^rule (\w+):$", text, re.M))
    groups = dict(entry.split("=") for entry in profile["groups"])
    assert profile["executor"] == "slurm"
    assert groups.keys() <= rules - {"simulate"}, "batches take minutes: each is a job of its own"
    sizes = dict(entry.split("=") for entry in profile["group-components"])
    assert set(groups.values()) == sizes.keys()
