"""Sections on how the run was made: deviations from the paper, datasets, times, machines."""

import os

import pandas as pd

from beltrepro.replication.report.material import WORDS, Material

PAPER_LENGTHS = ("2e6", "1e6")  # of runs, and of the part that is discarded


def deviations(material: Material) -> dict:
    """Rows of texts: in lengths and methods of this run, and the general ones."""
    return {"deviations": [*deviations_of_run(material.datasets), *WORDS["deviations"]]}


def deviations_of_run(datasets: list[dict]) -> list[dict]:
    """Lengths other than the paper's, and the datasets by the other integrator."""
    texts = WORDS["deviations_of_run"]
    scans = [dataset for dataset in datasets if dataset["kind"] == "scan"]
    table = pd.DataFrame(scans, columns=["name", "duration", "transient"])
    rows = [
        texts["length"]
        | {"ours": f"t = {duration}, of which {transient} discarded", "where": ", ".join(names)}
        for (duration, transient), names in table.groupby(["duration", "transient"])["name"]
        if (duration, transient) != PAPER_LENGTHS
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
    values = {name: dict.fromkeys(str(one[name]) for one in material.datasets) for name in names}
    return {name: "; ".join(filter(None, texts)) for name, texts in values.items()} | {
        "cores": os.cpu_count(),
        "preset": material.preset,
        "constants": material.settings["model"],
        "laminar_time": material.settings["defaults"]["laminar_time"],
    }
