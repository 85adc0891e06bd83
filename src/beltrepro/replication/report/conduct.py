"""Sections on how the run was made: deviations from the paper, datasets, times, machines."""

import csv
import os
from pathlib import Path

import numpy as np
import pandas as pd

from beltrepro.replication.report.material import Material, distinct
from beltrepro.replication.report.trust import PAPER_DURATION, PAPER_TRANSIENT, length

ALWAYS = (
    {
        "what": "Criteria",
        "paper": "judged by eye",
        "ours": "computed, by criteria fixed before the runs that they judge",
        "where": "claims",
        "why": "so that anyone gets the same verdict",
    },
    {
        "what": "Initial states",
        "paper": "one declared state",
        "ours": "the declared state for scans and series; slightly shifted copies of it where "
        "statistics are needed",
        "where": "Figs. 9, 10 and the inset of Fig. 12",
        "why": "one chaotic trajectory is no sample; copies are independent ones",
    },
    {
        "what": "Lifetimes of transients",
        "paper": "method of a cited reference",
        "ours": "exponential law by maximum likelihood, runs that did not escape counted as "
        "censored",
        "where": "inset of Fig. 12",
        "why": "uses every run and gives an error",
    },
)
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
_DIGITS = {
    "energy_residual": ".1e",
    "wrong_way": ".2g",
    "overload": ".4g",
    "deviation": ".1e",
    "noise_ratio": ".3f",
    "noise_error": ".3f",
}


def deviations(material: Material) -> dict:
    """Rows of texts: in lengths and methods of this run, and the general ones."""
    return {"deviations": [*deviations_of_run(material.datasets), *ALWAYS]}


def deviations_of_run(datasets: list[dict]) -> list[dict]:
    """Lengths other than the paper's, and the datasets by the other integrator."""
    by_lengths: dict[tuple[str, str], list[str]] = {}
    for dataset in datasets:
        if dataset["kind"] == "scan":
            lengths = dataset["duration"], dataset["transient"]
            by_lengths.setdefault(lengths, []).append(dataset["name"])
    by_lengths.pop((length(PAPER_DURATION), length(PAPER_TRANSIENT)), None)
    rows = [
        {
            "what": "Length of the runs",
            "paper": f"t = {length(PAPER_DURATION)}, of which {length(PAPER_TRANSIENT)} discarded",
            "ours": f"t = {duration}, of which {transient} discarded",
            "where": ", ".join(distinct(names)),
            "why": "this preset trades length for time; the preset named paper does not",
        }
        for (duration, transient), names in sorted(by_lengths.items())
    ]
    by_events = [dataset["name"] for dataset in datasets if "event" in dataset["method"]]
    if by_events:
        rows.append(
            {
                "what": "Integrator",
                "paper": "Verlet scheme, step 0.001, stick and slip at the ends of steps",
                "ours": "high order between events, instants of stick and slip located",
                "where": ", ".join(by_events),
                "why": "faster; see the section on the two integrators",
            }
        )
    return rows


def runs(material: Material) -> dict:
    """Rows of plain values, from the attributes of the datasets and from audit.csv."""
    audits = []
    if material.has(["audit"]):
        audits = [_audit(row) for row in pd.read_csv(material.file("audit")).to_dict("records")]
    return {"runs": material.datasets, "audits": audits}


def times(material: Material) -> dict:
    """Jobs, time (s) and memory (MB) per kind of rule, from the benchmark files of Snakemake."""
    groups: dict[str, list[tuple[float, float]]] = {}
    folder = Path(material.benchmarks)
    for path in sorted(folder.rglob("*.tsv")):
        relative = path.relative_to(folder)
        group = relative.parts[0] if len(relative.parts) > 1 else path.stem
        with path.open(newline="", encoding="utf-8") as file:
            groups.setdefault(group, []).extend(
                (_number(job.get("s")), _number(job.get("max_rss")))
                for job in csv.DictReader(file, delimiter="\t")
            )
    order = [*RULES, *sorted(groups.keys() - RULES.keys())]
    return {"rules": [_times_of(name, groups[name]) for name in order if name in groups]}


def environment(material: Material) -> dict:
    """Code, libraries, machines and constants: several values where datasets differ."""
    names = ("code_version", "processor", "libraries", "seed", "time_step")
    values = {
        name: "; ".join(distinct(dataset[name] for dataset in material.datasets)) for name in names
    }
    return values | {
        "cores": os.cpu_count(),
        "preset": material.preset,
        "constants": material.settings["model"],
        "laminar_time": material.settings["defaults"]["laminar_time"],
    }


def _audit(row: dict) -> dict:
    """A row as text; what does not apply is empty."""
    return row | {
        name: "" if np.isnan(row[name]) else format(row[name], digits)
        for name, digits in _DIGITS.items()
    }


def _times_of(name: str, jobs: list[tuple[float, float]]) -> dict:
    seconds, memory = np.array(jobs).T
    return {
        "rule": RULES.get(name, name),
        "jobs": len(seconds),
        "seconds": float(np.nansum(seconds)),
        "longest": float(np.nanmax(seconds, initial=0.0)),
        "memory_mb": float(np.nanmax(memory, initial=0.0)),
    }


def _number(text: str | None) -> float:
    try:
        return float(text)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return np.nan
