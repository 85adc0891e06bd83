"""Measure the claims of the paper and write them as CSV."""

from typing import TYPE_CHECKING

from beltrepro import inputs, scripting
from beltrepro.claims import measure
from beltrepro.tables import files

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake

TITLE = "Every claim of the paper: what it prints, what was measured, and the verdict."


def claims(paths: dict, expected: dict, settings: dict, output) -> None:
    """Measure the claims from files by name of the dataset or track."""
    data = inputs.load(paths, expected)
    table = measure(data, settings)
    lineage = inputs.lineage(paths, data)
    files.write(output, table, title=TITLE, columns={}, sources=expected, lineage=lineage)


def main(job):
    claims(dict(job.input.items()), job.params.expected, job.params.settings, job.output.table)


if __name__ == "__main__":
    scripting.run(main, snakemake)
