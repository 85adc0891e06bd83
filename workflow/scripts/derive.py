"""Derive one table from its datasets."""

import importlib
from pathlib import Path

from beltrepro.replication.plan import io, scripting


def main(job):
    path, about = Path(job.output[0]), job.params.about
    data, sources = io.load(dict(job.input.items()))
    table = getattr(importlib.import_module(about["module"]), path.stem)(data)
    io.write_table(path, table, title=about["title"], columns=about["columns"], sources=sources)


if __name__ == "__main__":
    scripting.run(main, snakemake)
