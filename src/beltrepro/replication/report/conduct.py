"""Sections on how the run was made: deviations from the paper, datasets, times, machines."""

import os

import pandas as pd

from beltrepro.replication.report.material import Material, distinct
from beltrepro.replication.report.trust import PAPER_DURATION, PAPER_TRANSIENT, length
from beltrepro.replication.verdicts.ledger import read_yaml

WORDS = read_yaml("beltrepro.replication.report", "page.yaml")


def deviations(material: Material) -> dict:
    """Rows of texts: in lengths and methods of this run, and the general ones."""
    return {"deviations": [*deviations_of_run(material.datasets), *WORDS["deviations"]]}


def deviations_of_run(datasets: list[dict]) -> list[dict]:
    """Lengths other than the paper's, and the datasets by the other integrator."""
    by_lengths: dict[tuple[str, str], list[str]] = {}
    for dataset in datasets:
        if dataset["kind"] == "scan":
            lengths = dataset["duration"], dataset["transient"]
            by_lengths.setdefault(lengths, []).append(dataset["name"])
    by_lengths.pop((length(PAPER_DURATION), length(PAPER_TRANSIENT)), None)
    texts = WORDS["deviations_of_run"]
    rows = [
        texts["length"]
        | {"ours": f"t = {duration}, of which {transient} discarded"}
        | {"where": ", ".join(distinct(names))}
        for (duration, transient), names in sorted(by_lengths.items())
    ]
    by_events = [dataset["name"] for dataset in datasets if "event" in dataset["method"]]
    return rows + ([texts["integrator"] | {"where": ", ".join(by_events)}] if by_events else [])


def runs(material: Material) -> dict:
    """Rows of plain values, from the attributes of the datasets."""
    return {"runs": material.datasets}


def times(material: Material) -> dict:
    """Jobs, time (s) and memory (MB) per kind of rule, from the benchmark files of Snakemake."""
    tables = [pd.DataFrame(columns=["s", "max_rss", "group"], dtype=float)]
    for path in sorted(material.benchmarks.rglob("*.tsv")):
        group = path.relative_to(material.benchmarks).with_suffix("").parts[0]
        # of a job that ended at once Snakemake knows no memory, and writes - or NA
        tables.append(pd.read_csv(path, sep="\t", na_values="-").assign(group=group))
    groups = pd.concat(tables).groupby("group")
    columns = {"jobs": ("s", "size"), "seconds": ("s", "sum"), "longest": ("s", "max")}
    rows = groups.agg(**columns, memory_mb=("max_rss", "max")).fillna(0.0).to_dict("index")
    names = WORDS["rules"] | {name: name for name in sorted(rows.keys() - WORDS["rules"].keys())}
    return {"rules": [{"rule": names[name]} | rows[name] for name in names if name in rows]}


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
