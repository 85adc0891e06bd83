"""Describe a finished run as an RO-Crate."""

from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro.extras.deposit import archive, crate
from beltrepro.replication.plan import scripting

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main(job):
    archive.write_crate(Path(), crate.run_from(job.params.spec))


if __name__ == "__main__":
    scripting.run(main, snakemake)
