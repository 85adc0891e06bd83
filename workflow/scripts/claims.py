"""Measure the claims of the paper and write them as CSV."""

from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro import scripting, store
from beltrepro.claims import measure

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def claims(files: dict[str, list], settings: dict, output) -> None:
    """Measure the claims from files by kind (`scans`, `series`, `catalogues`, `ensembles`)."""
    datasets = {
        kind: {Path(path).stem: store.read(path) for path in paths} for kind, paths in files.items()
    }
    measure(**datasets, settings=settings).to_csv(output, index=False)


def main(job):
    kinds = ("scans", "series", "catalogues", "ensembles")
    files = {kind: list(job.input[kind]) for kind in kinds}
    claims(files, job.params.settings, job.output[0])


if __name__ == "__main__":
    scripting.run(main, snakemake)
