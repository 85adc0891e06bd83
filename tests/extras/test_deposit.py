"""A run made ready for a repository: what files say of their origin, manifest, crate, archive."""

import json
import re
import shutil
import subprocess
import tomllib
import zipfile
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pypdf
import pytest
import yaml
from matplotlib.figure import Figure
from PIL import Image

from beltrepro.base import provenance, seal, store
from beltrepro.base.errors import InputError
from beltrepro.base.seal import metadata_path
from beltrepro.extras.deposit import archive, crate
from beltrepro.replication.drawing import style
from beltrepro.replication.plan import files, inputs, manifest, tables
from beltrepro.replication.plan.plan import make_plan
from beltrepro.replication.plan.points import columns

ROOT = Path(__file__).parents[2]
SETTINGS = {"duration": 2000, "transient": 50}
POINT = {"kind": "scan", "n_blocks": 2, "belt_velocity": [5, 10], "noise": [0, 1], "seed": [4, 9]}


# --- what files say of their origin ---


@pytest.fixture(scope="module")
def plan():
    presets = {"own": {"defaults": SETTINGS, "datasets": {"rows": POINT | {"method": "event"}}}}
    return make_plan({"preset": "own", "seed": 3, "datasets": {}, "presets": presets})


@pytest.fixture(scope="module")
def made(plan, tmp_path_factory):
    """A dataset, a table of it, one of that table, and a figure, as the scripts make them."""
    folder = tmp_path_factory.mktemp("made")
    spec, points = plan.dataset_spec("rows"), plan.datasets["rows"].points
    arrays = columns(points) | {"disorder_parameter": np.linspace(0.1, 0.3, len(points))}
    files.write(folder / "rows.h5", spec, arrays)
    expected = {"rows": files.expected(spec)}
    about = {"preset": "own", "run": "own", "sources": expected}
    paths = {"rows": folder / "rows.h5"}
    for name in ("first", "second"):
        data = inputs.load(paths, expected)
        frame = pd.DataFrame({"n": [1, 2]})
        lineage = inputs.lineage(paths, data)
        path = folder / f"{name}.csv"
        tables.write(path, frame, title="T.", columns={}, sources=expected, lineage=lineage)
        paths, expected = {name: path}, {name: about}
    figure = Figure()
    figure.add_subplot().plot([0, 1])
    for ending in ("png", "pdf", "svg"):
        style.write(figure, folder / f"some.{ending}", "some", "a source", lineage)
    return folder


def said_by(path: Path) -> dict:
    """What a file says of the data behind it and of the code that wrote it, as JSON."""
    match path.suffix:
        case ".h5":
            about = dict(store.read(path).attributes)
            about |= {name: json.loads(about[name]) for name in ("config", "library_versions")}
            return about | {"lineage": {"rows": about}}
        case ".csv":
            about = json.loads(metadata_path(path).read_text())
            return about["beltrepro:origin"] | {"lineage": about["beltrepro:lineage"]}
        case ".png":
            with Image.open(path) as image:
                return json.loads(image.info["Description"])
        case ".svg":
            tag = "{http://purl.org/dc/elements/1.1/}description"
            return json.loads(next(ElementTree.parse(path).iter(tag)).text)
    return json.loads(pypdf.PdfReader(path).metadata["/Keywords"])


@pytest.mark.parametrize(
    "name", ["rows.h5", "first.csv", "second.csv", "some.png", "some.pdf", "some.svg"]
)
def test_tables_and_figures_say_all_that_made_their_data(made, plan, name):
    said = said_by(made / name)
    assert said["code_version"] == provenance.code_version()
    libraries = said["library_versions"]
    libraries = json.loads(libraries) if isinstance(libraries, str) else libraries
    assert libraries["numpy"] == np.__version__
    rows = said["lineage"]["rows"]
    assert rows["config"] == json.loads(json.dumps(plan.dataset_spec("rows")))
    assert rows["config"]["points"]["seed"] == [4, 9]
    assert rows["config"]["points"]["method"] == ["event"]
    assert rows["digest"] == files.digest(plan.dataset_spec("rows"))
    assert rows["code_version"] == provenance.code_version()
    assert rows["library_versions"]["numba"] and rows["processor"]


def test_figures_of_other_data_have_other_bytes_and_of_the_same_the_same(made, tmp_path):
    figure = Figure()
    figure.add_subplot().plot([0, 1])
    lineage = said_by(made / "some.png")["lineage"]
    style.write(figure, tmp_path / "some.png", "some", "a source", lineage)
    assert (tmp_path / "some.png").read_bytes() == (made / "some.png").read_bytes()
    style.write(figure, tmp_path / "some.png", "some", "a source", {})
    assert (tmp_path / "some.png").read_bytes() != (made / "some.png").read_bytes()


# --- a small project with a finished run ---


def git(top: Path, *arguments: str) -> str:
    author = ["-c", "user.name=someone", "-c", "user.email=someone@example.org"]
    command = ["git", "-C", str(top), *author, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


SOURCES = ("Snakefile", "config.yaml", "CITATION.cff", "README.md", provenance.COMMIT_FILE)
SOURCES += ("results/README.md", "workflow/scripts/join.py", "workflow/scripts/report.py")
SOURCES += ("workflow/scripts/simulate.py",)
RECORDS = (
    crate.JobRecord("simulate", "batches/rows/0000", (), ("results/own/batches/rows/0000.h5",)),
    crate.JobRecord("join", "datasets/rows", ("results/own/batches/rows/0000.h5",),
                 ("results/own/datasets/rows.h5",)),
    crate.JobRecord("report", "report", ("results/own/datasets/rows.h5",),
                 ("results/own/report.html",)),
)  # fmt: skip
RULES = {
    "simulate": ("Simulate a batch.", "workflow/scripts/simulate.py"),
    "join": ("Join the batches.", "workflow/scripts/join.py"),
    "report": ("Write the report.", "workflow/scripts/report.py"),
}
RUN = crate.WorkflowRun("own", "own", 3, RULES, RECORDS)


@pytest.fixture
def project(made, tmp_path):
    top = tmp_path / "project"
    for name in SOURCES:
        (top / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, top / name)
    git(tmp_path, "init", "-q", str(top))
    git(top, "add", ".")
    git(top, "commit", "-qm", "First")
    results = top / "results" / "own"
    for folder in ("datasets", "batches/rows", "logs"):
        (results / folder).mkdir(parents=True)
    shutil.copy(made / "rows.h5", results / "datasets")
    shutil.copy(made / "rows.h5", results / "batches" / "rows" / "0000.h5")
    (results / "report.html").write_text("<p>Report</p>")
    (results / "logs" / "report.log").write_text("done")
    for name in ("datasets/rows.tsv", "batches/rows/0000.tsv"):
        (results / "benchmarks" / name).parent.mkdir(parents=True, exist_ok=True)
        (results / "benchmarks" / name).write_text("s\tmax_rss\n2.5\t81.25\n")
    manifest.add(results, results.rglob("*.h*"))
    return top


def unpacked(project, tmp_path):
    path = project / "results" / "own" / "beltrepro-own.zip"
    count = archive.write(path, project, RUN)
    with zipfile.ZipFile(path) as file:
        assert len(set(file.namelist())) == count
        file.extractall(tmp_path / "elsewhere")
    return tmp_path / "elsewhere" / "beltrepro-own"


def test_archive_has_sources_results_crate_and_the_checksum_of_each(project, tmp_path):
    top = unpacked(project, tmp_path)
    there = {path.relative_to(top).as_posix() for path in top.rglob("*") if path.is_file()}
    made = {"datasets/rows.h5", "report.html"}
    results = {
        *made,
        "benchmarks/datasets/rows.tsv",
        "benchmarks/batches/rows/0000.tsv",
        manifest.NAME,
    }
    expected = {*git(project, "ls-files").split(), manifest.CRATE, manifest.NAME}
    assert there == expected | {f"results/own/{name}" for name in results}
    listed = manifest.read(top)
    assert set(listed) == there - {manifest.NAME}
    assert all(seal.digest_of(top / name) == digest for name, digest in listed.items())
    manifest.check(top / "results" / "own", made)
    commit = git(project, "rev-parse", "HEAD").strip()
    assert manifest.datasets(top, "own") == {"rows"} and manifest.datasets(top, "other") == set()
    assert provenance.commit(top) == commit


def test_what_is_not_committed_is_refused_with_git_and_without(project, tmp_path):
    top = unpacked(project, tmp_path)
    assert archive.source_files(top) == sorted(git(project, "ls-files").split())
    archive.write(top / "results" / "own" / "beltrepro-own.zip", top, RUN)
    for place, name in ((top, "Snakefile"), (project, "config.yaml")):
        (place / name).write_text("seed: 2\n")
        with pytest.raises(InputError, match=f"^{name}: not as committed"):
            archive.write(tmp_path / "some.zip", place, RUN)
    assert not (tmp_path / "some.zip").exists()
    with pytest.raises(InputError, match="neither a git checkout nor an unpacked archive"):
        archive.source_files(tmp_path)


@pytest.mark.parametrize("name", ["report.html", "datasets/rows.h5", "notes.txt"])
def test_what_the_run_did_not_write_gets_into_no_archive_and_no_crate(project, tmp_path, name):
    path = project / "results" / "own" / name
    path.write_bytes((path.read_bytes() if path.exists() else b"") + b"more")
    for write in (archive.write_crate, partial(archive.write, tmp_path / "some.zip")):
        with pytest.raises(InputError, match=f"{name}: .*; to make it again: rm .*{name} && snake"):
            write(project, RUN)
    assert not (tmp_path / "some.zip").exists()


# --- the crate ---


@pytest.fixture
def described(project):
    archive.write_crate(project, RUN)
    graph = json.loads((project / "results" / "own" / manifest.CRATE).read_text())["@graph"]
    return {entity["@id"]: entity for entity in graph}


def test_the_crate_names_files_that_are_there_and_refers_to_nothing_else(project, described):
    folder = project / "results" / "own"
    files_of = {name for name, entity in described.items() if "File" in np.ravel(entity["@type"])}
    named = {"datasets/rows.h5", "report.html", "source/Snakefile", "source/config.yaml"}
    assert named < files_of == {part["@id"] for part in described["./"]["hasPart"]}
    for name in files_of:
        digest = seal.digest_of(folder / name)  # and so it is there
        assert described[name].get("sha256", digest) == digest
    refers = set(re.findall(r"""\{"@id": "([^"]+)"\}""", json.dumps(list(described.values()))))
    assert {name for name in refers - set(described) if not name.startswith("https://")} == set()
    page = described["source/README.md"]  # what to read first
    assert (page["about"], page["encodingFormat"]) == ({"@id": "./"}, "text/markdown")


def test_the_whole_run_was_told_its_preset_seed_and_machine(described):
    spec = [described[entity["@id"]] for entity in described["#run"]["object"]]
    values = {entity["name"]: entity["value"] for entity in spec[1:]}
    assert values == {"preset": RUN.preset, "seed": str(RUN.seed)} | provenance.machine()
    assert spec[0]["@id"] == "source/config.yaml"
    outputs = {path for record in RUN.records for path in record.outputs}
    last = {path.removeprefix("results/own/") for path in outputs if "/batches/" not in path}
    results = [entity["@id"] for entity in np.ravel(described["#run"]["result"])]
    assert len(outputs) > len(last) == len(results) and set(results) == last


def test_each_job_is_an_action_with_its_ends_time_and_memory(described):
    action = described["#job-join-datasets/rows"]
    assert action["instrument"] == {"@id": "source/workflow/scripts/join.py"}
    assert action["object"] == {"@id": "#batches/rows/0000.h5"}
    assert action["result"] == {"@id": "datasets/rows.h5"}
    usage = [described[entity["@id"]] for entity in action["resourceUsage"]]
    amounts = {amount["name"]: amount["value"] for amount in usage}
    assert amounts == {"seconds": "2.5", "max_rss": "81.25"}
    began, ended = (pd.Timestamp(action[name]) for name in ("startTime", "endTime"))
    assert 2 <= (ended - began).total_seconds() <= 3
    control = described["#control-join-datasets/rows"]
    assert control["instrument"] == {"@id": "#step-join"}
    assert control["object"] == {"@id": "#job-join-datasets/rows"}


# --- citation ---


def test_citation_zenodo_and_package_agree():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    zenodo = json.loads((ROOT / ".zenodo.json").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for name in ("title", "version", "license", "keywords"):
        assert citation[name] == zenodo[name]
    assert citation["abstract"].split() == zenodo["description"].split()
    assert (project["version"], project["license"]) == (zenodo["version"], zenodo["license"])
    names = [{"name": author["name"]} for author in citation["authors"]]
    assert names == zenodo["creators"] == project["authors"]
    papers = [paper["doi"] for paper in citation["references"]]
    assert papers == [paper["identifier"] for paper in zenodo["related_identifiers"]]
