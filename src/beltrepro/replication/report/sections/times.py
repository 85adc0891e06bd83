"""Time and memory per rule, from the benchmark files of Snakemake."""

import csv
from pathlib import Path

import numpy as np

TITLE = "Time per rule"
ANCHOR = "time"
NEEDS = ()

# Folders or names of benchmark files, and what the jobs behind them do.
RULES = {
    "batches": "simulate batches",
    "datasets": "join batches",
    "experiment": "film and track",
    "tables": "derive tables",
    "agreement": "compare the integrators",
    "figures": "draw figures",
    "claims": "measure claims",
    "report": "write the report",
    "article": "set the article",
}


def gather(material) -> dict:
    """A row for each rule."""
    return {"rules": read_benchmarks(material.benchmarks)}


def read_benchmarks(folder: Path) -> list[dict]:
    """Jobs, time (s) and memory (MB) per kind of rule; empty if there are no files."""
    groups: dict[str, list] = {}
    for path in sorted(Path(folder).rglob("*.tsv")):
        relative = path.relative_to(folder)
        group = relative.parts[0] if len(relative.parts) > 1 else path.stem
        with path.open(newline="", encoding="utf-8") as file:
            groups.setdefault(group, []).extend(
                (_number(run.get("s")), _number(run.get("max_rss")))
                for run in csv.DictReader(file, delimiter="\t")
            )
    order = [*RULES, *sorted(groups.keys() - RULES.keys())]
    return [_row(name, groups[name]) for name in order if name in groups]


def _row(name, jobs) -> dict:
    seconds, memory = np.array(jobs).T
    return {
        "rule": RULES.get(name, name),
        "jobs": len(seconds),
        "seconds": float(np.nansum(seconds)),
        "longest": float(np.nanmax(seconds, initial=0.0)),
        "memory_mb": float(np.nanmax(memory, initial=0.0)),
    }


def _number(text) -> float:
    try:
        return float(text)
    except (TypeError, ValueError):
        return np.nan
