"""Derive one table from its datasets."""

import importlib
from pathlib import Path

from beltrepro.replication.plan import io, scripting


def main(job):
    path, params = Path(job.output[0]), job.params
    data, sources = io.load(dict(job.input.items()))
    table = getattr(importlib.import_module(params.module), path.stem)(data)
    io.write_table(path, table, title=params.title, columns=params.columns, sources=sources)


if __name__ == "__main__":
    scripting.run(main, snakemake)
