"""Estimate time, memory and disk of all simulation jobs from those that ran."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from beltrepro.replication.plan import scripting
from beltrepro.replication.plan import tables as files
from beltrepro.replication.plan.jobs import COLUMNS, Job, estimate

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

TITLE = "Core-hours, memory and disk of all simulation jobs, from those that ran."


def usage(jobs: list[Job], benchmarks: Path) -> tuple[dict[str, float], dict[str, float]]:
    """Seconds, and megabytes of memory, of each job that has a benchmark file."""
    paths = {job.name: benchmarks / f"{job.name}.tsv" for job in jobs}
    rows = {
        name: pd.read_csv(path, sep="\t", na_values="-").iloc[-1]
        for name, path in paths.items()
        if path.exists()
    }
    seconds = {name: float(row["s"]) for name, row in rows.items()}
    memory = {name: float(row["max_rss"]) for name, row in rows.items()}
    return seconds, {name: each for name, each in memory.items() if each == each}


def sizes(jobs: list[Job], results: Path) -> dict[str, float]:
    """Bytes of each result that is there."""
    paths = {job.name: results / f"{job.name}.h5" for job in jobs}
    return {name: path.stat().st_size for name, path in paths.items() if path.exists()}


def main(job):
    jobs = [Job(*fields) for fields in job.params.jobs]
    benchmarks = Path(job.params.benchmarks)
    size = sizes(jobs, benchmarks.parent)
    table = estimate(jobs, *usage(jobs, benchmarks), size)
    files.write(job.output.table, table, title=TITLE, columns=COLUMNS, sources={})
    print(table.to_string(index=False, float_format="%.3g"))


if __name__ == "__main__":
    scripting.run(main, snakemake)
