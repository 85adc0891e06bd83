"""What the sections of the page print: what was judged, and how the run was made."""

import os
import statistics
from collections import Counter
from collections.abc import Iterator

import pandas as pd

from beltrepro.replication.plan import registry
from beltrepro.replication.report.claim_results import count, statements
from beltrepro.replication.report.findings import filled, findings_of, printed_and_measured, words
from beltrepro.replication.report.material import WORDS, Material
from beltrepro.replication.verdicts.ledger import SECTIONS, SEEN, read_yaml

STUDIES = "beltrepro.replication.studies"
DECIDING = "n5_replicates"  # the dataset that most claims rest on


# --- what was judged ------------------------------------------------------------------------------


def summary(material: Material) -> dict:
    """What was run in numbers, findings, claims counted by both verdicts, and trust."""
    results = material.claims
    last = [one.claim.seen for one in statements(results) if one.claim.testable]
    answers = [answer for one in statements(results) for answer in one.answers.values()]
    runs = [number.estimate.runs for answer in answers for number in answer.judged]
    runs = [number for number in runs if number is not None]
    pictures = material.pictures
    return {
        "findings": findings_of(results),
        "words": words(),
        "measured": list(printed_and_measured(results)),
        "drawn": {one["name"]: f"Figure {one['number']}".strip() for one in pictures},
        "first": [picture for picture in pictures if picture["name"] in WORDS["first"]],
        "counts": count(results),
        "statements": len(statements(results)),
        "kinds": Counter(result.claim.kind for result in results.values()),
        "duration": float(material.settings["datasets"][DECIDING]["duration"]),
        "runs": runs and (statistics.median_low(runs), min(runs), max(runs)),
        "seen": [last.count(name) for name in SEEN],  # when criteria were written or changed last
    }


def studies(material: Material) -> Iterator[dict]:
    """Each question: its words, its figures with the statements on them, its other statements."""
    numbers = {picture["number"] for picture in material.pictures} - {""}
    for name in WORDS["studies"]:
        section = read_yaml(STUDIES, f"{name}/words.yaml")["section"]
        yield {
            "name": name,
            "title": section["title"],
            "paragraphs": [filled(text, material.claims) for text in section["paragraphs"]],
            "findings": findings_of(material.claims, name),
            "pictures": [one for one in material.pictures if of_study(one["module"]) == name],
            "statements": [
                result
                for result in material.claims.values()
                if SECTIONS[result.claim.section] == name
                and str(result.claim.figure) not in numbers
            ],
            "tables": [
                table
                for table, entry in registry.tables().items()
                if of_study(entry.module) == name and material.files.get(table)
            ],
        }


def of_study(module: str) -> str:
    """Name of the study that has a module."""
    return module.split(".")[-2]


# --- how the run was made -------------------------------------------------------------------------


def times(material: Material) -> list[dict]:
    """Jobs, time (s) and memory (MB) per kind of rule, from the benchmark files of Snakemake."""
    tables = [pd.DataFrame(columns=["s", "max_rss", "group"], dtype=float)]
    for path in sorted(material.benchmarks.rglob("*.tsv")):
        group = path.relative_to(material.benchmarks).with_suffix("").parts[0]
        # of a job that ended at once Snakemake knows no memory, and writes - or NA
        tables.append(pd.read_csv(path, sep="\t", na_values="-").assign(group=group))
    groups = pd.concat(tables).groupby("group")
    columns = {"jobs": ("s", "size"), "seconds": ("s", "sum"), "longest": ("s", "max")}
    rows = groups.agg(**columns, memory_mb=("max_rss", "max")).fillna(0.0)
    return rows.rename_axis("rule").reset_index().to_dict("records")


def environment(material: Material) -> dict:
    """Code, libraries, machines and constants: several values where datasets differ."""
    names = ("code_version", "processor", "libraries", "seed", "time_step")
    values: dict[str, dict[str, None]] = {name: {} for name in names}
    for one in material.datasets:
        for name in names:  # what batches of several versions made has them all in one text
            values[name] |= dict.fromkeys(str(one[name]).split("; "))
    worst = max((one["energy_residual"] for one in material.datasets), default=0.0)
    return {name: "; ".join(filter(None, texts)) for name, texts in values.items()} | {
        "cores": os.cpu_count(),
        "energy_residual": f"{worst:.1e}",
        "constants": material.settings["model"],
        "laminar_time": material.settings["defaults"]["laminar_time"],
    }
