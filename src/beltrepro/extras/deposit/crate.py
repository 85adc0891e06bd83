"""RO-Crate of a run: its files, the jobs that made them, and the code, as JSON-LD.

The profile is Provenance Run Crate 0.5 (https://w3id.org/ro/wfrun/provenance): the workflow has a
step for each rule, and each job is an action with its inputs, outputs, times and memory.
"""

from __future__ import annotations

import json
import mimetypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from beltrepro.base import provenance, seal
from beltrepro.base.errors import needing

_TERMS = "https://w3id.org/ro/terms/workflow-run#"
_PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": "Process Run Crate",
    "https://w3id.org/ro/wfrun/workflow/0.5": "Workflow Run Crate",
    "https://w3id.org/ro/wfrun/provenance/0.5": "Provenance Run Crate",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": "Workflow RO-Crate",
}
_WORKFLOW_PROFILE = "https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE"
_USAGE = (  # name, column of the benchmark file, unit
    ("seconds", "s", "https://qudt.org/vocab/unit/SEC"),
    ("max_rss", "max_rss", "https://qudt.org/vocab/unit/MebiBYTE"),
)
_ENGINE = "https://snakemake.github.io"
_MEDIA = mimetypes.MimeTypes()  # those of Python, not of the machine
_MEDIA.add_type("text/markdown", ".md")
_MEDIA.add_type("application/yaml", ".yaml")


@dataclass(frozen=True)
class JobRecord:
    """What one job of the workflow read and wrote."""

    rule: str  # its rule
    name: str  # of the job, and of its benchmark file without suffix: "datasets/u1"
    inputs: Sequence[str]  # files, below the folder of the project
    outputs: Sequence[str]


@dataclass(frozen=True)
class WorkflowRun:
    """A run as the workflow knows it."""

    name: str  # its name and its preset
    preset: str
    seed: int  # that of the configuration
    # by rule its sentence and its script: "workflow/scripts/join.py"
    rules: Mapping[str, tuple[str, str]]
    records: Sequence[JobRecord]  # its jobs

    @property
    def folder(self) -> str:
        """That of the results."""
        return f"results/{self.name}"


def run_from(values: Mapping[str, Any]) -> WorkflowRun:
    """A run from plain values, as a script of the workflow is given them."""
    return WorkflowRun(**{**values, "records": [JobRecord(*job) for job in values["records"]]})


def describe(top: Path, run: WorkflowRun, moved: Mapping[str, str]) -> str:
    """The crate of a run; `moved` has new beginnings of paths by old ones, tried in their order."""
    made = _Made(top, run, moved)
    made.add_top()
    made.add_workflow()
    made.add_jobs()
    metadata = made.crate.metadata.generate()
    for entity in metadata["@graph"]:  # no lists of one, as RO-Crate recommends
        entity |= {k: v[0] for k, v in entity.items() if isinstance(v, list) and len(v) == 1}
    return json.dumps(metadata, indent=1, ensure_ascii=False) + "\n"


class _Made:
    """A crate while it is made: entities by the paths of the project."""

    def __init__(self, top: Path, run: WorkflowRun, moved: Mapping[str, str]) -> None:
        self.top, self.run, self.moved = top, run, moved
        with needing("the crate", "deposit"):
            from rocrate.rocrate import ROCrate
        self.crate = ROCrate(version="1.1")  # that of the profile
        self.crate.metadata.extra_terms |= {
            name: _TERMS + name for name in ("resourceUsage", "sha256")
        }
        self.about = yaml.safe_load((top / "CITATION.cff").read_text(encoding="utf-8"))
        self.files: dict[str, Any] = {}
        self.tools: dict[str, Any] = {}
        self.steps: dict[str, Any] = {}

    def add(self, identifier: str, kind: str | list[str], **properties: Any) -> Any:
        """A contextual entity, or the one that has this identifier."""
        entity = {"@id": identifier, "@type": kind} | properties
        return self.crate.get(identifier) or self.crate.add_jsonld(entity)

    def file(self, path: str, properties: Mapping[str, Any] | None = None) -> Any:
        """A file of the project; a batch, which no archive holds, by its name only."""
        if path not in self.files:
            if path.startswith(f"{self.run.folder}/batches/"):
                name = path.removeprefix(f"{self.run.folder}/")
                self.files[path] = self.add(f"#{name}", "CreativeWork", name=name)
            else:
                about = self._of_file(path) | dict(properties or {})
                place = self._place(path)
                self.files[path] = self.crate.add_file(dest_path=place, properties=about)
        return self.files[path]

    def _place(self, path: str) -> str:
        """Path of a file in the crate."""
        old = next((old for old in self.moved if path.startswith(old)), "")
        return self.moved.get(old, "") + path.removeprefix(old)

    def _of_file(self, path: str) -> dict[str, Any]:
        there = self.top / path
        return {
            "name": path.removeprefix(f"{self.run.folder}/"),
            "contentSize": str(there.stat().st_size),
            "sha256": seal.digest_of(there),
            "encodingFormat": _MEDIA.guess_type(there.name)[0] or "text/plain",
        }

    # --- the parts ---

    def add_top(self) -> None:
        """The crate itself: title, authors, licence, profiles, and what to read first."""
        about, root = self.about, self.crate.root_dataset
        licence = f"https://spdx.org/licenses/{about['license']}"
        self.add(licence, "CreativeWork", name=f"{about['license']} licence")
        root["name"] = f"{about['title']}: preset {self.run.preset}, run {self.run.name}"
        root["description"] = about["abstract"]
        root["keywords"] = ", ".join(about["keywords"])
        root["license"] = {"@id": licence}
        root["version"] = provenance.code_version()
        root["author"] = [
            self.add(f"#{author['name'].replace(' ', '-')}", "Organization", name=author["name"])
            for author in about["authors"]
        ]
        for paper in about["references"]:
            work = self.add(f"https://doi.org/{paper['doi']}", "ScholarlyArticle")
            work["name"] = paper["title"]
            root.append_to("citation", work)
        root["conformsTo"] = [
            self.add(profile, "CreativeWork", name=name, version=profile.rpartition("/")[2])
            for profile, name in _PROFILES.items()
        ]
        self.file("README.md", {"about": {"@id": root.id}})

    def add_workflow(self) -> None:
        """The Snakefile with its inputs and outputs, and a step and a tool for each rule."""
        code = ["File", "SoftwareSourceCode"]
        workflow = self.crate.add_workflow(
            dest_path=self._place("Snakefile"),
            main=True,
            lang="snakemake",
            properties=self._of_file("Snakefile")
            | {
                "@type": [*code, "ComputationalWorkflow", "HowTo"],
                "conformsTo": {"@id": _WORKFLOW_PROFILE},
                "version": provenance.code_version(),
            },
        )
        self.workflow = workflow
        for position, (rule, (sentence, script)) in enumerate(self.run.rules.items(), 1):
            tool = self.file(script, {"@type": code, "version": provenance.code_version()})
            self.tools[rule] = tool
            self.steps[rule] = self.add(
                f"#step-{rule}",
                "HowToStep",
                name=rule,
                description=sentence,
                position=str(position),
                workExample={"@id": tool.id},
            )
        workflow["hasPart"] = list(self.tools.values())
        workflow["step"] = list(self.steps.values())

    def add_jobs(self) -> None:
        """The run, and each of its jobs: an action of its tool, and the control of its step."""
        actions = [self._job(record) for record in self.run.records]
        run = self._whole_run(actions)
        controls = [
            self.add(
                f"#control-{record.rule}-{record.name}",
                "ControlAction",
                name=f"Snakemake runs {record.name}",
                instrument={"@id": self.steps[record.rule].id},
                object={"@id": action.id},
            )
            for record, action in zip(self.run.records, actions, strict=True)
        ]
        engine = self.add(_ENGINE, "SoftwareApplication", name="Snakemake", url=_ENGINE)
        engine["softwareVersion"] = version("snakemake")
        whole = self.add("#snakemake", "OrganizeAction", name="Snakemake runs the workflow")
        whole["instrument"], whole["object"], whole["result"] = engine, controls, run
        whole["endTime"] = run["endTime"]
        self.crate.root_dataset["datePublished"] = run["endTime"]
        self.crate.root_dataset["mentions"] = [run, whole, *actions]

    def _whole_run(self, actions: list[Any]) -> Any:
        """The run of the workflow, from what it was told to all that it made."""
        values = {"preset": self.run.preset, "seed": str(self.run.seed)} | provenance.machine()
        settings = [self.file("config.yaml")]
        settings += [self.add(f"#{k}", "PropertyValue", name=k, value=v) for k, v in values.items()]
        run = self.add("#run", "CreateAction", name=f"Run {self.run.name}")
        run["instrument"], run["object"] = self.workflow, settings
        made = [path for record in self.run.records for path in record.outputs]
        batches = f"{self.run.folder}/batches/"
        run["result"] = [self.file(path) for path in made if not path.startswith(batches)]
        run["startTime"] = min(action.get("startTime", action["endTime"]) for action in actions)
        run["endTime"] = max(action["endTime"] for action in actions)
        self._add_parameters(settings)
        return run

    def _add_parameters(self, settings: list[Any]) -> None:
        """Inputs and outputs of the workflow, each with the value that it had."""
        report = self.files.get(f"{self.run.folder}/report.html")
        ends = {"input": settings[:3], "output": [report] if report else []}
        for end, values in ends.items():
            parameters = []
            for value in values:
                kind = "File" if "File" in value.type else "Text"
                name = Path(value.id).stem.lstrip("#")
                parameter = self.crate.add_formal_parameter(name, kind, f"#parameter-{name}")
                parameter["workExample"], value["exampleOfWork"] = value, parameter
                parameters.append(parameter)
            self.workflow[end] = parameters

    def _job(self, record: JobRecord) -> Any:
        action = self.add(f"#job-{record.rule}-{record.name}", "CreateAction")
        action["name"] = f"{record.rule}: {record.name}"
        action["description"] = self.run.rules[record.rule][0]
        action["instrument"] = self.tools[record.rule]
        action["object"] = [self.file(path) for path in record.inputs]
        action["result"] = [self.file(path) for path in record.outputs]
        benchmark = self.top / self.run.folder / "benchmarks" / f"{record.name}.tsv"
        if not benchmark.is_file():
            first = self.top / record.outputs[0]
            ended = first.stat().st_mtime if first.is_file() else 0.0
            action["endTime"] = _iso(ended)
            return action
        row = pd.read_csv(benchmark, sep="\t").iloc[-1]
        ended = benchmark.stat().st_mtime
        action["startTime"], action["endTime"] = _iso(ended - float(row["s"])), _iso(ended)
        action["resourceUsage"] = [
            self.add(
                f"{action.id}-{name}",
                "PropertyValue",
                name=name,
                propertyID=f"https://snakemake.readthedocs.io/en/stable/tutorial/additional_features.html#{name}",
                value=f"{float(row[column]):.6g}",
                unitCode=unit,
            )
            for name, column, unit in _USAGE
            if pd.notna(pd.to_numeric(row[column], errors="coerce"))
        ]
        return action


def _iso(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")
