"""Pack a finished run, with the sources of its commit, into one ZIP file."""

from pathlib import Path
from typing import TYPE_CHECKING

from beltrepro.extras.deposit import archive, crate
from beltrepro.replication.plan import scripting

if TYPE_CHECKING:
    from snakemake.iocontainers import snakemake


def main(job):
    path = Path(job.output[0])
    count = archive.write(path, Path(), crate.run_from(job.params.spec))
    print(f"{path}: {count} files, {path.stat().st_size / 1e6:.0f} MB")


if __name__ == "__main__":
    scripting.run(main, snakemake)
