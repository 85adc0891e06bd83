"""Derive one table from its datasets."""

import importlib
from pathlib import Path

from beltrepro.replication.plan import inputs, scripting
from beltrepro.replication.plan import tables as files


def main(job):
    """`expected` : what the files of datasets must say of themselves, by name."""
    paths, params, output = dict(job.input.items()), job.params, Path(job.output.table)
    data = inputs.load(paths, params.expected)
    table = getattr(importlib.import_module(params.module), output.stem)(data)
    about = {"title": params.title, "columns": params.columns, "sources": params.expected}
    files.write(output, table, lineage=inputs.lineage(paths, data), **about)


if __name__ == "__main__":
    scripting.run(main, snakemake)
