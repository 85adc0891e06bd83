"""What the sections of the page print: what was judged, and how the run was made."""

import os
import statistics
from collections import Counter

import pandas as pd

from beltrepro.replication.report.claim_results import Result, count, statements
from beltrepro.replication.report.findings import findings_of
from beltrepro.replication.report.material import WORDS, Material
from beltrepro.replication.verdicts.ledger import SEEN

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
        "datasets": len(material.files.get("datasets", [])),
        "numbered": sum(bool(picture["number"]) for picture in pictures),
        "findings": findings_of(results),
        "drawn": {picture["name"] for picture in pictures},
        "first": [picture for picture in pictures if picture["name"] in WORDS["first"]],
        "counts": count(results),
        "statements": len(statements(results)),
        "kinds": Counter(result.claim.kind for result in results.values()),
        "duration": float(material.settings["datasets"][DECIDING]["duration"]),
        "runs": runs and (statistics.median_low(runs), min(runs), max(runs)),
        "seen": [last.count(name) for name in SEEN],  # when criteria were written or changed last
    }


def why(material: Material) -> dict:
    """The paragraphs on why r falls."""
    drawn = {picture["name"] for picture in material.pictures}
    return {"paragraphs": findings_of(material.claims, "why"), "drawn": drawn}


def cards(material: Material) -> dict:
    """Claims by group, those that are counted apart last, with their pictures; counts."""
    groups: dict[str, list] = {title: [] for title in WORDS["groups"].values()}
    for result in material.claims.values():
        claim = result.claim
        group = WORDS["groups"][claim.section if claim.finding else claim.kind]
        groups[group].append(_card(result, material.pictures))
    return {
        "groups": {title: group for title, group in groups.items() if group},
        "counts": count(material.claims),
        "claims": len(material.claims),
    }


def _card(result: Result, pictures: list[dict]) -> dict:
    """The result, the figure of its number, and other pictures that show a number of it."""
    number = str(result.claim.figure or "")
    figure = next((picture for picture in pictures if number and picture["number"] == number), None)
    shown = [picture for picture in pictures if picture["name"] in result.figures]
    besides = [picture for picture in shown if picture is not figure]
    return {"result": result, "number": number, "figure": figure, "shown": besides}


# --- how the run was made -------------------------------------------------------------------------


def times(material: Material) -> dict:
    """Jobs, time (s) and memory (MB) per kind of rule, from the benchmark files of Snakemake."""
    tables = [pd.DataFrame(columns=["s", "max_rss", "group"], dtype=float)]
    for path in sorted(material.benchmarks.rglob("*.tsv")):
        group = path.relative_to(material.benchmarks).with_suffix("").parts[0]
        # of a job that ended at once Snakemake knows no memory, and writes - or NA
        tables.append(pd.read_csv(path, sep="\t", na_values="-").assign(group=group))
    groups = pd.concat(tables).groupby("group")
    columns = {"jobs": ("s", "size"), "seconds": ("s", "sum"), "longest": ("s", "max")}
    rows = groups.agg(**columns, memory_mb=("max_rss", "max")).fillna(0.0)
    return {"rules": rows.rename_axis("rule").reset_index().to_dict("records")}


def environment(material: Material) -> dict:
    """Code, libraries, machines and constants: several values where datasets differ."""
    names = ("code_version", "processor", "libraries", "seed", "time_step")
    values = {name: dict.fromkeys(str(one[name]) for one in material.datasets) for name in names}
    return {name: "; ".join(filter(None, texts)) for name, texts in values.items()} | {
        "cores": os.cpu_count(),
        "constants": material.settings["model"],
        "laminar_time": material.settings["defaults"]["laminar_time"],
    }
