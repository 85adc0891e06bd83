"""Derive one table from its datasets."""

import importlib
from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro.replication.plan import inputs, registry, scripting
from beltrepro.replication.plan import tables as files

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def derive(name: str, paths: dict, expected: dict, output) -> None:
    """Derive table `name` from files by name of the dataset or table; write it with what made it.

    expected : what the files of datasets must say of themselves, by name.
    """
    entry = registry.tables()[name]
    module = importlib.import_module(entry.module)
    data = inputs.load(paths, expected)
    table = getattr(module, name)(data)
    files.write(
        output,
        table,
        title=entry.title,
        columns=entry.columns,
        sources=expected,
        lineage=inputs.lineage(paths, data),
    )


def main(job):
    output = Path(job.output.table)
    derive(output.stem, dict(job.input.items()), job.params.expected, output)


if __name__ == "__main__":
    scripting.run(main, snakemake)
