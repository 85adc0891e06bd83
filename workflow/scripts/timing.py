"""Estimate the time of all simulation jobs from the benchmark files of those that ran."""

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from beltrepro import scripting
from beltrepro.jobs import Job, estimate
from beltrepro.tables import files

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

TITLE = "Core-hours of all simulation jobs, from the time of those that ran."


def seconds_by_name(jobs: list[Job], benchmarks: Path) -> dict[str, float]:
    """Time of each job that has a benchmark file."""
    paths = {job.name: benchmarks / f"{job.name}.tsv" for job in jobs}
    return {
        name: float(pd.read_csv(path, sep="\t")["s"].iloc[-1])
        for name, path in paths.items()
        if path.exists()
    }


def main(job):
    jobs = [Job(*fields) for fields in job.params.jobs]
    table = estimate(jobs, seconds_by_name(jobs, Path(job.params.benchmarks)))
    files.write(job.output.table, table, title=TITLE, columns={}, sources={})
    print(table.to_string(index=False, float_format="%.3g"))


if __name__ == "__main__":
    scripting.run(main, snakemake)
