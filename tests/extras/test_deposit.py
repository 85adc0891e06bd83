"""A run made ready for a repository: what files say of their origin, manifest, crate, archive."""

import importlib.metadata
import json
import shutil
import subprocess
import tomllib
import zipfile
from pathlib import Path

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
    told, points = plan.told("rows"), plan.datasets["rows"].points
    arrays = columns(points) | {"disorder_parameter": np.linspace(0.1, 0.3, len(points))}
    files.write(folder / "rows.h5", told, arrays)
    expected = {"rows": files.expected(told)}
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
    if path.suffix == ".h5":
        about = dict(store.read(path).attributes)
        about |= {name: json.loads(about[name]) for name in ("config", "library_versions")}
        return about | {"lineage": {"rows": about}}
    if path.suffix == ".csv":
        about = json.loads(metadata_path(path).read_text())
        return about["beltrepro:origin"] | {"lineage": about["beltrepro:lineage"]}
    if path.suffix == ".png":
        with Image.open(path) as image:
            return json.loads(image.info["Description"])
    if path.suffix == ".svg":
        from xml.etree import ElementTree

        (words,) = ElementTree.parse(path).iter("{http://purl.org/dc/elements/1.1/}description")
        return json.loads(words.text)
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
    assert rows["config"] == json.loads(json.dumps(plan.told("rows")))
    assert rows["config"]["points"]["seed"] == [4, 9]
    assert rows["config"]["points"]["method"] == ["event"]
    assert rows["digest"] == files.digest(plan.told("rows"))
    assert rows["code_version"] == provenance.code_version()
    assert rows["library_versions"]["numba"] and rows["processor"]


def test_a_table_of_an_older_version_is_one_line(made, tmp_path):
    for path in (made / "first.csv", metadata_path(made / "first.csv")):
        shutil.copy(path, tmp_path)
    metadata = metadata_path(tmp_path / "first.csv")
    metadata.write_text(metadata.read_text().replace("beltrepro:lineage", "other"))
    with pytest.raises(InputError, match=r"first.csv: of an older version"):
        inputs.lineage({"first": tmp_path / "first.csv"}, {"first": None})


def test_figures_of_other_data_have_other_bytes_and_of_the_same_the_same(made, tmp_path):
    figure = Figure()
    figure.add_subplot().plot([0, 1])
    lineage = said_by(made / "some.png")["lineage"]
    style.write(figure, tmp_path / "some.png", "some", "a source", lineage)
    assert (tmp_path / "some.png").read_bytes() == (made / "some.png").read_bytes()
    style.write(figure, tmp_path / "some.png", "some", "a source", {})
    assert (tmp_path / "some.png").read_bytes() != (made / "some.png").read_bytes()


# --- the commit where there is no git ---


@pytest.mark.parametrize(
    ("text", "expected"),
    [(f"node: {'0a' * 20}\n", "0a" * 20), ("node: $Format:%H$\n", ""), ("", "")],
)
def test_commit_of_an_archive(tmp_path, monkeypatch, text, expected):
    (tmp_path / provenance.COMMIT_FILE).write_text(text)
    monkeypatch.setattr(provenance, "ROOT", tmp_path / "src" / "beltrepro")
    assert provenance.commit(tmp_path) == expected
    provenance.code_version.cache_clear()
    number = importlib.metadata.version("beltrepro")
    try:
        said = provenance.code_version()
    finally:
        provenance.code_version.cache_clear()
    assert said == (f"{number}+g{expected[:12]}" if expected else number)


# --- a small project with a finished run ---


def git(top: Path, *arguments: str) -> str:
    own = ["-c", "user.name=someone", "-c", "user.email=someone@example.org"]
    command = ["git", "-C", str(top), *own, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


SOURCES = ("Snakefile", "config.yaml", "CITATION.cff", "README.md", provenance.COMMIT_FILE)
SOURCES += ("results/README.md", "workflow/scripts/join.py", "workflow/scripts/report.py")
RECORDS = (
    crate.JobRecord("join", "datasets/rows", ("results/own/batches/rows/0000.h5",),
                 ("results/own/datasets/rows.h5",)),
    crate.JobRecord("report", "report", ("results/own/datasets/rows.h5",),
                 ("results/own/report.html",)),
)  # fmt: skip
RULES = {
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
    for folder in ("datasets", "batches/rows", "benchmarks/datasets", "logs"):
        (results / folder).mkdir(parents=True)
    shutil.copy(made / "rows.h5", results / "datasets")
    shutil.copy(made / "rows.h5", results / "batches" / "rows" / "0000.h5")
    (results / "report.html").write_text("<p>Report</p>")
    (results / "logs" / "report.log").write_text("done")
    (results / "benchmarks" / "datasets" / "rows.tsv").write_text("s\tmax_rss\n2.5\t81.25\n")
    return top


def unpacked(project, tmp_path):
    path = project / "results" / "own" / "beltrepro-own.zip"
    archive.write(path, project, RUN)
    with zipfile.ZipFile(path) as file:
        file.extractall(tmp_path / "elsewhere")
    return tmp_path / "elsewhere" / "beltrepro-own"


def test_archive_has_sources_results_crate_and_the_checksum_of_each(project, tmp_path):
    top = unpacked(project, tmp_path)
    there = {each.relative_to(top).as_posix() for each in top.rglob("*") if each.is_file()}
    results = {"datasets/rows.h5", "report.html", "benchmarks/datasets/rows.tsv"}
    expected = {*git(project, "ls-files").split(), manifest.CRATE, manifest.NAME}
    assert there == expected | {f"results/own/{name}" for name in results}
    listed = manifest.read(top)
    assert set(listed) == there - {manifest.NAME}
    assert all(seal.digest_of(top / name) == each for name, each in listed.items())
    commit = git(project, "rev-parse", "HEAD").strip()
    assert manifest.datasets(top, "own") == {"rows"} and manifest.datasets(top, "other") == set()
    assert provenance.commit(top) == commit


def test_archive_refuses_what_is_not_committed(project):
    (project / "config.yaml").write_text("seed: 2\n")
    with pytest.raises(InputError, match=r"^config.yaml: not as committed"):
        archive.write(project / "some.zip", project, RUN)
    assert not (project / "some.zip").exists()


def test_an_unpacked_archive_can_be_packed_again_without_git(project, tmp_path):
    top = unpacked(project, tmp_path)
    assert archive.source_files(top) == sorted(git(project, "ls-files").split())
    archive.write(top / "results" / "own" / "beltrepro-own.zip", top, RUN)
    (top / "Snakefile").write_text("")
    with pytest.raises(InputError, match=r"^Snakefile: not as committed"):
        archive.write(tmp_path / "some.zip", top, RUN)


def test_sources_are_not_guessed(tmp_path):
    with pytest.raises(InputError, match="neither a git checkout nor an unpacked archive"):
        archive.source_files(tmp_path)


# --- the crate ---


@pytest.fixture
def described(project):
    archive.write_crate(project, RUN)
    graph = json.loads((project / "results" / "own" / manifest.CRATE).read_text())["@graph"]
    return {each["@id"]: each for each in graph}


def types(entity) -> list:
    kind = entity["@type"]
    return kind if isinstance(kind, list) else [kind]


def test_files_of_the_crate_are_there_with_their_checksums(project, described):
    folder = project / "results" / "own"
    names = [name for name, each in described.items() if "File" in types(each)]
    assert {"datasets/rows.h5", "report.html", "source/Snakefile", "source/config.yaml"} < set(
        names
    )
    for name in names:
        assert (folder / name).is_file()
        if "sha256" in described[name]:
            assert described[name]["sha256"] == seal.digest_of(folder / name)
    parts = {each["@id"] for each in described["./"]["hasPart"]}
    assert parts == set(names)


def test_each_job_is_an_action_with_its_ends_time_and_memory(described):
    action = described["#job-join-datasets/rows"]
    assert action["instrument"] == {"@id": "source/workflow/scripts/join.py"}
    assert action["object"] == {"@id": "#batches/rows/0000.h5"}
    assert action["result"] == {"@id": "datasets/rows.h5"}
    usage = {
        described[each["@id"]]["name"]: described[each["@id"]]["value"]
        for each in action["resourceUsage"]
    }
    assert usage == {"seconds": "2.5", "max_rss": "81.25"}
    began, ended = (pd.Timestamp(action[name]) for name in ("startTime", "endTime"))
    assert 2 <= (ended - began).total_seconds() <= 3
    control = described["#control-join-datasets/rows"]
    assert control["instrument"] == {"@id": "#step-join"}
    assert control["object"] == {"@id": "#job-join-datasets/rows"}


def test_no_reference_of_the_crate_leads_nowhere(described):
    def references(value):
        if isinstance(value, dict):
            yield from [value["@id"]] if set(value) == {"@id"} else []
            for each in value.values():
                yield from references(each)
        if isinstance(value, list):
            for each in value:
                yield from references(each)

    found = {each for entity in described.values() for each in references(entity)}
    outside = {each for each in found - set(described) if not each.startswith("https://")}
    assert outside == set()


def test_the_crate_is_plain_and_says_what_to_read_first(described):
    lists = [value for each in described.values() for value in each.values() if type(value) is list]
    assert lists and min(map(len, lists)) > 1
    page = described["source/README.md"]
    assert (page["about"], page["encodingFormat"]) == ({"@id": "./"}, "text/markdown")


# --- citation ---


def test_citation_zenodo_and_package_agree():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    zenodo = json.loads((ROOT / ".zenodo.json").read_text())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert citation["title"] == zenodo["title"]
    assert citation["abstract"].split() == zenodo["description"].split()
    assert citation["version"] == zenodo["version"] == project["version"]
    assert citation["license"] == zenodo["license"] == project["license"]
    assert citation["keywords"] == zenodo["keywords"]
    names = [{"name": each["name"]} for each in citation["authors"]]
    assert names == zenodo["creators"] == project["authors"]
    papers = [each["doi"] for each in citation["references"]]
    assert papers == [each["identifier"] for each in zenodo["related_identifiers"]]
    assert (zenodo["upload_type"], zenodo["access_right"]) == ("software", "open")
